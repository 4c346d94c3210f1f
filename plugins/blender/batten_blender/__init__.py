"""Batten in Blender: surfaces from curves, and meshes faired, repaired, remeshed and simplified, by the program batten."""

bl_info = {
    "name": "Batten",
    "author": "The Batten contributors",
    "version": (0, 2, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Batten; File > Import",
    "description": "Fair surfaces from curves; meshes faired, repaired, remeshed, simplified",
    "category": "Mesh",
}

from . import operators, panel, preferences  # noqa: E402  Blender reads bl_info as text, at the beginning


def register():
    preferences.register()
    operators.register()
    panel.register()


def unregister():
    panel.unregister()
    operators.unregister()
    preferences.unregister()
