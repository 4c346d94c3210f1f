"""The macro, tried inside FreeCAD without a window (test_plugins.py starts it)."""

import json
import math
import os
import traceback

import FreeCAD
import Part
from FreeCAD import Vector

macro = {"__name__": "batten_surface"}
with open(os.environ["BATTEN_MACRO"], encoding="utf-8") as file:
    exec(compile(file.read(), os.environ["BATTEN_MACRO"], "exec"), macro)
macro["PROGRAM"] = os.environ["BATTEN_PROGRAM"]


def feature(document, shape, label):
    made = document.addObject("Part::Feature", "Curve")
    made.Shape, made.Label = shape, label
    return made


def circles(document, radius=50):
    return [feature(document, Part.Circle(Vector(), axis, radius).toShape(), "circle") for axis in (Vector(1, 0, 0), Vector(0, 1, 0), Vector(0, 0, 1))]


def refusal(items, document):
    count = len(document.Objects)
    try:
        macro["surface"](items, document)
    except macro["Refusal"] as found:
        assert len(document.Objects) == count
        return str(found)
    raise AssertionError("it was not refused")


def test_three_circles_become_a_solid_mesh_on_the_sphere(document):
    mesh = macro["surface"](circles(document), document).Mesh
    assert mesh.isSolid() and mesh.CountFacets > 10000
    worst = max(abs(point.Vector.Length - 50) for point in mesh.Points)
    assert worst < 0.02, worst
    assert abs(mesh.Volume / (4 / 3 * math.pi * 50**3) - 1) < 1e-3


def test_placements_count(document):
    items = circles(document)
    for item in items:
        item.Placement = FreeCAD.Placement(Vector(100, 0, 0), FreeCAD.Rotation(Vector(1, 1, 0), 30))
    box = macro["surface"](items, document).Mesh.BoundBox
    assert (box.Center - Vector(100, 0, 0)).Length < 0.05 and abs(box.XLength - 100) < 0.1


def test_faces_of_step_are_a_solid_of_the_right_volume(document):
    shape = macro["surface"](circles(document), document, as_faces=True).Shape
    assert shape.ShapeType == "Solid" or len(shape.Solids) == 1, shape.ShapeType
    assert shape.isValid()
    assert abs(shape.Volume / (4 / 3 * math.pi * 50**3) - 1) < 1e-3


def test_edges_of_a_body_with_a_sharp_label_keep_its_shape(document):
    box = feature(document, Part.makeBox(10, 20, 30), "sharp box")
    mesh = macro["surface"]([box], document).Mesh
    assert abs(mesh.Volume - 6000) < 0.1
    names = [f"Edge{number + 1}" for number in range(len(box.Shape.Edges))]
    mesh = macro["surface"]([(box, names)], document).Mesh
    assert abs(mesh.Volume - 6000) < 0.1


def test_a_border_by_label_leaves_the_surface_open(document):
    rim = feature(document, Part.Circle(Vector(), Vector(0, 0, 1), 50).toShape(), "rim")
    ribs = [feature(document, Part.Arc(Vector(*a), Vector(0, 0, 50), Vector(*b)).toShape(), "rib")
            for a, b in (((-50, 0, 0), (50, 0, 0)), ((0, -50, 0), (0, 50, 0)))]
    assert macro["surface"]([rim, *ribs], document).Mesh.isSolid()
    rim.Label = "border"
    mesh = macro["surface"]([rim, *ribs], document).Mesh
    assert not mesh.isSolid() and mesh.BoundBox.ZMin > -0.01


def test_refusals_are_words_and_add_nothing(document):
    line = feature(document, Part.makeLine(Vector(), Vector(1, 0, 0)), "line")
    assert "no closed cycle" in refusal([line], document)
    assert "no edges" in refusal([], document)
    macro["PROGRAM"] = "/nowhere/batten"
    try:
        assert "not at /nowhere/batten" in refusal([line], document)
    finally:
        macro["PROGRAM"] = os.environ["BATTEN_PROGRAM"]


def test_no_files_are_left(document):
    macro["surface"](circles(document), document)
    assert not [name for name in os.listdir(os.environ["TMPDIR"]) if name.startswith("batten-")]


outcome = {}
for name, test in list(globals().items()):
    if name.startswith("test_"):
        document = FreeCAD.newDocument()
        try:
            test(document)
            outcome[name] = ""
        except Exception:
            outcome[name] = traceback.format_exc()
        FreeCAD.closeDocument(document.Name)
with open(os.environ["BATTEN_RESULTS"], "w", encoding="utf-8") as file:
    json.dump(outcome, file, indent=1)
os._exit(0)  # the prompt of FreeCAD would wait
