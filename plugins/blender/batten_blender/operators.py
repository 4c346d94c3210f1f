"""What the add-on does: an operator per command of the program."""

import math
import os

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from . import curves, ply, preferences, shapes
from .program import Refusal, Run

# While the program runs nothing may be edited, but one may look around.
LOOKING = {"MOUSEMOVE", "INBETWEEN_MOUSEMOVE", "MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM"}
METRES = {"m": 1, "cm": 0.01, "mm": 0.001, "um": 1e-6, "in": 0.0254, "ft": 0.3048}

ANGLE = dict(subtype="ANGLE", min=0, max=math.pi)
LENGTH = dict(subtype="DISTANCE", unit="LENGTH", min=0, precision=4)
ACCEPT_FLAWS = dict(name="Accept Flaws", description="Take the result although it is not sound: it crosses itself, for example")


def sharp_angle():
    return FloatProperty(
        name="Mark Edges Above",
        default=math.radians(30),
        description="Edges of the result that are sharper become sharp edges and creases",
        **ANGLE,
    )


def repair_first():
    return BoolProperty(name="Repair First", description="Mend the mesh first, as Repair does")


def degrees(angle):
    return f"{math.degrees(angle)!r}deg"


class Work:
    """One run of the program, from the selection to a new object. Subclasses say what goes in and what comes out:

    begin(context): writes the input into self.run.folder, returns the arguments of the program
    finish(context, answer): makes the objects, returns a sentence

    Called from a menu it is modal: the window goes on, Esc stops the program. From a script, from the window that chooses
    files, and when an option is changed in the redo panel, it waits.
    """

    bl_options = {"REGISTER", "UNDO"}
    interactive = False

    def switches(self, *names):
        """The options of the program that take no value, of those properties that are set."""
        return ["--" + name.replace("_", "-") for name in names if getattr(self, name)]

    def invoke(self, context, _event):
        self.interactive = not bpy.app.background
        return self.execute(context)

    def execute(self, context):
        # For once: the redo panel calls execute() of the same object again.
        interactive, self.interactive = self.interactive, False
        self.remarks = []
        self.run = self.timer = None
        try:
            self.run = Run(preferences.program_path(context), bpy.app.tempdir)
            self.run.start(self.begin(context))
            if not interactive:
                return self.done(context, self.run.wait())
        except Refusal as refusal:
            return self.refused(context, refusal)
        except BaseException:
            self.end(context)
            raise
        self.timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        self.show(context)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC" and event.value == "PRESS":
            self.end(context)
            self.report({"WARNING"}, f"{self.bl_label} was cancelled")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"} if event.type in LOOKING else {"RUNNING_MODAL"}
        try:
            answer = self.run.poll()
            if answer is None:
                self.show(context)
                return {"RUNNING_MODAL"}
            return self.done(context, answer)
        except Refusal as refusal:
            return self.refused(context, refusal)
        except BaseException:
            self.end(context)
            raise

    def cancel(self, context):
        """Blender ends the operator: another file is opened, or the window is closed."""
        self.end(context)

    def show(self, context):
        context.workspace.status_text_set(f"{self.bl_label}: {self.run.stage}   |   Esc: Cancel")

    def done(self, context, answer):
        sentence = self.finish(context, answer)
        remarks = self.remarks + [self.run.in_words(warning) for warning in answer.get("warnings", [])]
        self.end(context)
        self.report({"INFO"}, sentence)
        for remark in remarks:
            self.report({"WARNING"}, remark)
        return {"FINISHED"}

    def refused(self, context, refusal):
        self.end(context)
        self.report({"ERROR"}, str(refusal))
        return {"CANCELLED"}

    def end(self, context):
        if self.run is not None:
            self.run.close()
            self.run = None
        if self.timer is not None:
            context.window_manager.event_timer_remove(self.timer)
            context.workspace.status_text_set(None)
            self.timer = None


class BATTEN_OT_surface(Work, bpy.types.Operator):
    """Fill the selected curves with a fair surface"""

    bl_idname = "batten.surface"
    bl_label = "Surface from Curves"

    edge_length: FloatProperty(name="Edge Length", description="Edges inside patches; 0: by the curves", **LENGTH)
    weld: FloatProperty(name="Weld", description="Curves this near meet; 0: what gives the simplest surface", **LENGTH)
    soft: BoolProperty(name="Soft", description="Pass near the curves instead of through them: for noisy ones")
    soft_weight: FloatProperty(
        name="Weight", default=1, min=0.001, soft_max=1000, description="Soft: a larger weight stays nearer to the curves"
    )
    keep_crossings: BoolProperty(
        name="Keep Crossings", description="Leave patches that cross others or fold as they came, instead of filling them flatter"
    )
    accept_flaws: BoolProperty(**ACCEPT_FLAWS)
    sharp_angle: sharp_angle()

    @classmethod
    def poll(cls, context):
        if context.mode == "OBJECT" and any(obj.type in {"CURVE", "MESH"} for obj in context.selected_objects):
            return True
        cls.poll_message_set("Select curves, or meshes of edges without faces, in object mode")
        return False

    def draw(self, _context):
        layout = self.layout
        layout.use_property_split = True
        for name in ("edge_length", "weld", "soft"):
            layout.prop(self, name)
        row = layout.row()
        row.enabled = self.soft
        row.prop(self, "soft_weight")
        for name in ("keep_crossings", "accept_flaws", "sharp_angle"):
            layout.prop(self, name)

    def begin(self, context):
        selected = sorted(context.selected_objects, key=lambda obj: obj.name)
        active = context.active_object
        lead = active if active in selected and active.type in {"CURVE", "MESH"} else selected[0]
        network, self.remarks = shapes.network_of(context, selected)
        self.source = lead.name
        self.origin = np.array(lead.matrix_world.translation, float)
        path = self.run.file("curves.json", known_as="the selected curves")
        curves.write(path, network)
        arguments = ["surface", path, "-o", self.run.file("surface.ply", known_as="the surface")]
        if self.edge_length > 0:
            arguments += ["--edge-length", repr(self.edge_length)]
        if self.weld > 0:
            arguments += ["--weld", repr(self.weld)]
        if self.soft:
            arguments += ["--constraints", "soft", "--soft-weight", repr(self.soft_weight)]
        if self.keep_crossings:
            arguments += ["--crossings", "keep"]
        return arguments + self.switches("accept_flaws")

    def finish(self, context, answer):
        V, F, values, _ = ply.read(self.run.file("surface.ply"))
        normals = np.stack([values[name] for name in ("nx", "ny", "nz")], axis=1)
        source = bpy.data.objects.get(self.source)
        materials = [slot.material for slot in source.material_slots] if source else []
        mesh = shapes.new_mesh("Surface", V, F, self.origin, angle=self.sharp_angle, normals=normals, materials=materials)
        shapes.add_result(context, "Surface", mesh, self.origin, self.source)
        openings = answer["boundary_loops"]
        kind = "closed" if answer["watertight"] else f"open, {openings} border{'s' if openings != 1 else ''}"
        return f"Surface of {answer['cycles']} patches, {len(F)} triangles, {kind}"


class MeshWork(Work):
    """Work on the active mesh; the result takes its place in the view."""

    suffix = ""
    command = ""

    @classmethod
    def poll(cls, context):
        obj = context.active_object
        if context.mode == "OBJECT" and obj is not None and obj.type == "MESH" and obj.select_get():
            return True
        cls.poll_message_set("Select a mesh in object mode")
        return False

    def draw(self, _context):
        self.layout.use_property_split = True
        for name in self.__annotations__:
            self.layout.prop(self, name)

    def begin(self, context):
        obj = context.active_object
        self.source = obj.name
        self.origin = np.array(obj.matrix_world.translation, float)
        triangles = shapes.triangles_of(context, obj)
        self.smooth = triangles.smooth
        path = self.run.file("in.ply", known_as=obj.name)
        ply.write(path, triangles.V, triangles.F, {"material": triangles.materials})
        return [self.command, path, "-o", self.run.file("out.ply", known_as="the result"), *self.option_words()]

    def finish(self, context, answer):
        V, F, _, values = ply.read(self.run.file("out.ply"))
        obj = bpy.data.objects.get(self.source)
        if obj is None:
            raise Refusal(f"{self.source} was removed in the meantime")
        mesh = self.mesh(context, obj, V, F, values.get("material"))
        shapes.add_result(context, f"{self.source} {self.suffix}", mesh, self.origin, self.source)
        obj.hide_set(True)
        return self.sentence(answer, F)

    def mesh(self, _context, obj, V, F, material_of_face):
        return shapes.new_mesh(
            f"{self.source} {self.suffix}", V, F, self.origin, angle=self.sharp_angle, smooth=self.smooth,
            materials=[slot.material for slot in obj.material_slots], material_of_face=material_of_face,
        )

    def sentence(self, _answer, F):
        return f"{self.source} {self.suffix}: {len(F)} triangles"


class BATTEN_OT_fair(MeshWork, bpy.types.Operator):
    """Remove noise from the active mesh and keep its edges"""

    bl_idname = "batten.fair"
    bl_label = "Fair"
    command, suffix = "fair", "faired"

    method: EnumProperty(
        name="Method",
        items=[
            ("auto", "Automatic", "Finds out by itself whether the shape is sharp or organic"),
            ("bilateral-normal", "Bilateral Normals", "Filtered normals"),
            ("guided-normal", "Guided Normals", "Normals filtered after those of patches"),
            ("taubin", "Taubin", "Smoothing that keeps the volume roughly, and no edges"),
            ("mcf", "Mean Curvature Flow", "Plain smoothing"),
            ("bilaplacian", "Bilaplacian Flow", "Plain smoothing of higher order"),
            ("tv", "Total Variation", "For shapes of flat pieces"),
        ],
    )
    noise: FloatProperty(
        name="Noise", min=0, soft_max=1, description="Standard deviation of the noise in mean edge lengths; 0: estimated"
    )
    iterations: IntProperty(name="Iterations", min=0, soft_max=100, description="Rounds or steps; 0: the method's own number")
    keep_boundary: BoolProperty(name="Keep Border", description="Vertices on the border stay in place")
    repair: repair_first()
    sharp_angle: sharp_angle()

    def option_words(self):
        options = ["--method", self.method]
        if self.noise > 0:
            options += ["--noise", repr(self.noise)]
        if self.iterations > 0:
            options += ["--iterations", str(self.iterations)]
        return options + self.switches("keep_boundary", "repair")

    def mesh(self, context, obj, V, F, material_of_face):
        if self.repair:
            return super().mesh(context, obj, V, F, material_of_face)
        # Only positions have changed: everything else that the mesh has lives on.
        return shapes.moved_copy(context, obj, V, F, self.origin, self.sharp_angle)


class BATTEN_OT_repair(MeshWork, bpy.types.Operator):
    """Mend the active mesh: weld, orient, take sheets apart, fill holes"""

    bl_idname = "batten.repair"
    bl_label = "Repair"
    command, suffix = "repair", "repaired"

    weld: EnumProperty(
        name="Weld",
        items=[
            ("auto", "Automatic", "Borders are welded where they lie together"),
            ("distance", "Distance", "Borders are welded within a distance"),
            ("off", "Off", "Nothing is welded"),
        ],
    )
    distance: FloatProperty(name="Distance", description="Of welding, where that goes by distance", **LENGTH)
    orient: BoolProperty(name="Orient", description="Turn closed parts outward")
    holes: EnumProperty(
        name="Fill Holes",
        items=[
            ("none", "None", "Holes stay"),
            ("small", "Small", "Holes of a few edges are filled by fair surfaces"),
            ("all", "All", "All holes are filled by fair surfaces"),
        ],
    )
    hole_edges: IntProperty(name="Edges", default=50, min=3, description="Small holes have no more edges than this")
    accept_flaws: BoolProperty(**ACCEPT_FLAWS)
    sharp_angle: sharp_angle()

    def option_words(self):
        options = ["--weld", repr(self.distance) if self.weld == "distance" else self.weld]
        if self.holes != "none":
            options += ["--fill-holes", "all" if self.holes == "all" else str(self.hole_edges)]
        return options + self.switches("orient", "accept_flaws")


class BATTEN_OT_remesh(MeshWork, bpy.types.Operator):
    """Replace the triangles of the active mesh by better ones"""

    bl_idname = "batten.remesh"
    bl_label = "Remesh"
    command, suffix = "remesh", "remeshed"

    edge: FloatProperty(name="Edge Length", description="0: that of the mesh", **LENGTH)
    adaptivity: FloatProperty(
        name="Adaptivity", default=0.1, min=0, max=1, description="0: even triangles; 1: as fine as curvature asks"
    )
    keep_edges: FloatProperty(
        name="Keep Edges Above", default=math.radians(30), description="Edges sharper than this stay where they are", **ANGLE
    )
    keep_border: BoolProperty(name="Keep Border", description="Vertices on the border stay in place, so that tiles join")
    repair: repair_first()
    accept_flaws: BoolProperty(**ACCEPT_FLAWS)
    sharp_angle: sharp_angle()

    def option_words(self):
        options = ["--adaptivity", repr(self.adaptivity), "--keep-edges", degrees(self.keep_edges)]
        if self.edge > 0:
            options += ["--edge", repr(self.edge)]
        if self.keep_border:
            options += ["--keep-border", "exact"]
        return options + self.switches("repair", "accept_flaws")


class BATTEN_OT_simplify(MeshWork, bpy.types.Operator):
    """Reduce the number of triangles of the active mesh"""

    bl_idname = "batten.simplify"
    bl_label = "Simplify"
    command, suffix = "simplify", "simplified"

    by: EnumProperty(
        name="By",
        items=[
            ("share", "Share", "A share of the triangles is removed"),
            ("faces", "Triangles", "So many triangles are left"),
            ("error", "Distance", "Nothing moves farther than this"),
        ],
    )
    remove: FloatProperty(name="Remove", default=80, min=0.1, max=99.99, subtype="PERCENTAGE", description="Share of the triangles")
    faces: IntProperty(name="Triangles", default=1000, min=4, description="At most this many are left")
    error: FloatProperty(
        name="Distance", default=0.01, description="Of the result from the mesh, in both directions", **LENGTH
    )
    keep_border: BoolProperty(name="Keep Border", description="Vertices on the border all stay, so that tiles join")
    repair: repair_first()
    sharp_angle: sharp_angle()

    def draw(self, _context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "by")
        layout.prop(self, {"share": "remove", "faces": "faces", "error": "error"}[self.by])
        for name in ("keep_border", "repair", "sharp_angle"):
            layout.prop(self, name)

    def option_words(self):
        options = {
            "share": ["--remove", f"{self.remove!r}%"],
            "faces": ["--faces", str(self.faces)],
            "error": ["--error", repr(self.error)],
        }[self.by]
        if self.keep_border:
            options += ["--keep-border", "exact"]
        return options + self.switches("repair")


class BATTEN_OT_import(ImportHelper, Work, bpy.types.Operator):
    """Import a scan or a curve network"""

    bl_idname = "batten.import_curves"
    bl_label = "Import Scan or Curves"

    filter_glob: StringProperty(default="*.rawnet;*.rawnet.gz;*.net;*.json;*.obj;*.txt;*.lop", options={"HIDDEN"})
    shape: EnumProperty(
        name="As",
        items=[
            ("auto", "By the File", "Edges where the file has normals, or is a scan; curves otherwise"),
            ("curves", "Curves", "An object per curve, to be edited; normals are left out"),
            ("edges", "Edges", "One mesh of edges with the normals, from which surfaces are more exact"),
        ],
    )
    scale: FloatProperty(name="Scale", default=1, min=1e-6, max=1e6, description="Beside that of units, where the file has one")

    def begin(self, _context):
        name = os.path.basename(self.filepath)
        is_scan = name.lower().endswith((".rawnet", ".rawnet.gz"))
        path = self.run.file("curves.json")
        return ["network", self.filepath, "-o", path] if is_scan else ["convert", self.filepath, path]

    def finish(self, context, _answer):
        network = curves.read(self.run.file("curves.json"))
        scale = self.scale
        if network.unit in METRES:
            scale *= METRES[network.unit] / context.scene.unit_settings.scale_length
        name = os.path.basename(self.filepath).split(".")[0]
        for other in context.selected_objects:
            other.select_set(False)
        as_edges = self.shape == "edges" or (self.shape == "auto" and network.normals is not None)
        (shapes.add_edges if as_edges else shapes.add_curves)(context, name, network, scale)
        return f"{len(network.curves)} curves imported from {name}"


class BATTEN_OT_mark(bpy.types.Operator):
    """Say what the selected curves are to surfaces"""

    bl_idname = "batten.mark_curves"
    bl_label = "Mark Curves"
    bl_options = {"REGISTER", "UNDO"}

    kind: EnumProperty(
        name="As",
        items=[
            (curves.INNER, "Inner", "The surface is smooth across the curve"),
            (curves.BORDER, "Border", "The surface ends at the curve"),
            (curves.SHARP, "Sharp", "The surface has an edge along the curve"),
        ],
    )

    @classmethod
    def poll(cls, context):
        if any(obj.type == "CURVE" for obj in context.selected_objects):
            return True
        cls.poll_message_set("Select curves; edges of meshes are borders as seams, and sharp as sharp edges")
        return False

    def execute(self, context):
        for obj in context.selected_objects:
            if obj.type == "CURVE":
                obj.batten_curve = self.kind
        return {"FINISHED"}


CLASSES = (
    BATTEN_OT_surface, BATTEN_OT_fair, BATTEN_OT_repair, BATTEN_OT_remesh, BATTEN_OT_simplify, BATTEN_OT_import, BATTEN_OT_mark,
)


def _import_entry(self, _context):
    self.layout.operator(BATTEN_OT_import.bl_idname, text="Batten Scan or Curves (.rawnet, .net, .json, .obj)")


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.batten_curve = EnumProperty(
        name="Curve", items=BATTEN_OT_mark.__annotations__["kind"].keywords["items"],
        description="What the curve is to a surface",
    )
    bpy.types.TOPBAR_MT_file_import.append(_import_entry)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(_import_entry)
    del bpy.types.Object.batten_curve
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
