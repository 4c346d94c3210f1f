"""Where the program is, and which version was found there."""

import bpy

from . import program


class BattenPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: bpy.props.StringProperty(
        name="Program",
        subtype="FILE_PATH",
        description=f"The program batten. Empty: the one on PATH, else {program.USUAL_PLACE}",
    )

    def draw(self, _context):
        self.layout.prop(self, "program")
        try:
            path, version = program.find(bpy.path.abspath(self.program))
            self.layout.label(text=f"Found version {version}: {path}", icon="CHECKMARK")
        except program.Refusal as refusal:
            for line in str(refusal).split("; "):
                self.layout.label(text=line, icon="ERROR")


def program_path(context):
    """@raises program.Refusal where there is none."""
    return program.find(bpy.path.abspath(context.preferences.addons[__package__].preferences.program))[0]


def register():
    bpy.utils.register_class(BattenPreferences)


def unregister():
    bpy.utils.unregister_class(BattenPreferences)
