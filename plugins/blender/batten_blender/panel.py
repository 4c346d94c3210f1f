"""The tab Batten in the sidebar of the 3D view."""

import bpy

from . import preferences
from .program import Refusal


class BATTEN_PT_panel(bpy.types.Panel):
    bl_label = "Batten"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Batten"

    def draw(self, context):
        layout = self.layout
        try:
            preferences.program_path(context)
        except Refusal as refusal:
            for line in str(refusal).split("; "):
                layout.label(text=line, icon="ERROR")
            layout.operator("preferences.addon_show", text="Preferences").module = __package__
        column = layout.column(align=True)
        column.label(text="Curves")
        column.operator("batten.import_curves", icon="IMPORT")
        row = column.row(align=True)
        active = context.active_object
        for kind, text in (("INNER", "Inner"), ("BORDER", "Border"), ("SHARP", "Sharp")):
            is_kind = active is not None and active.type == "CURVE" and active.batten_curve == kind
            row.operator("batten.mark_curves", text=text, depress=is_kind).kind = kind
        column.operator("batten.surface", icon="SURFACE_DATA")
        column = layout.column(align=True)
        column.label(text="Mesh")
        column.operator("batten.fair", icon="MOD_SMOOTH")
        column.operator("batten.repair", icon="MODIFIER")
        column.operator("batten.remesh", icon="MOD_REMESH")
        column.operator("batten.simplify", icon="MOD_DECIM")


def register():
    bpy.utils.register_class(BATTEN_PT_panel)


def unregister():
    bpy.utils.unregister_class(BATTEN_PT_panel)
