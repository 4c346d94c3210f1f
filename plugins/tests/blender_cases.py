"""What the add-on does, tried inside Blender without a window (test_plugins.py starts it).

blender -b --factory-startup --python blender_cases.py -- ADDON.zip PROGRAM RESULTS.json
"""

import json
import math
import os
import sys
import unittest

import bpy
import numpy as np
from mathutils import Matrix

ADDON, PROGRAM, RESULTS = sys.argv[sys.argv.index("--") + 1 :]
DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data")


def preferences():
    return bpy.context.preferences.addons["batten_blender"].preferences


def circle(axis=0, radius=1.0, **settings):
    """A Bezier circle as Add > Curve > Circle makes it, in one of the planes of coordinates."""
    rotation = [(0, 0, 0), (math.pi / 2, 0, 0), (0, math.pi / 2, 0)][axis]
    bpy.ops.curve.primitive_bezier_circle_add(radius=radius, rotation=rotation)
    obj = bpy.context.object
    obj.data.resolution_u = 32
    for name, value in settings.items():
        setattr(obj.data, name, value)
    return obj


def three_circles(**settings):
    return [circle(axis, **settings) for axis in range(3)]


def line(points, name="Line", cyclic=False):
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    spline = data.splines.new("POLY")
    spline.points.add(len(points) - 1)
    for point, at in zip(spline.points, points):
        point.co = (*at, 1)
    spline.use_cyclic_u = cyclic
    obj = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(obj)
    return obj


def arc(point, degrees=180, n=65):
    """Along `point` of the angle, from 0."""
    return line([point(math.radians(degrees) * i / (n - 1)) for i in range(n)], "Arc")


def mesh_object(V, F, name="Mesh", edges=()):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(map(float, v)) for v in V], list(edges), [tuple(map(int, f)) for f in F])
    mesh.update()
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(obj)
    return obj


def select(*objects):
    for obj in bpy.context.view_layer.objects:
        obj.select_set(False)
    for obj in objects:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = objects[-1] if objects else None
    bpy.context.view_layer.update()


def cube_of_quads(n, noise=0.0):
    """The cube from -1 to 1 with n x n quads a side, and noise along the diagonal directions of its vertices."""
    bpy.ops.mesh.primitive_cube_add(size=2)
    obj = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide(number_cuts=n - 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    V = positions(obj)
    rng = np.random.default_rng(1)
    obj.data.vertices.foreach_set("co", (V + rng.normal(0, noise, V.shape)).astype(np.float32).ravel() if noise else V.ravel())
    obj.data.update()
    select(obj)
    return obj


def positions(obj, world=False):
    V = np.empty(3 * len(obj.data.vertices), np.float32)
    obj.data.vertices.foreach_get("co", V)
    V = V.reshape(-1, 3).astype(float)
    matrix = np.array(obj.matrix_world)
    return V @ matrix[:3, :3].T + matrix[:3, 3] if world else V


def corner_normals(obj):
    """Per corner of a face: its vertex, and the normal that is drawn there."""
    mesh = obj.data
    mesh.calc_normals_split()
    normals, vertices = np.empty(3 * len(mesh.loops), np.float32), np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("normal", normals)
    mesh.loops.foreach_get("vertex_index", vertices)
    return vertices, normals.reshape(-1, 3).astype(float)


def face_normals(obj):
    N = np.empty(3 * len(obj.data.polygons), np.float32)
    obj.data.polygons.foreach_get("normal", N)
    return N.reshape(-1, 3).astype(float)


def degrees_between(a, b):
    return np.degrees(np.arccos(np.clip(np.einsum("ij,ij->i", a, b), -1, 1)))


def volume(obj):
    V = positions(obj, world=True)
    obj.data.calc_loop_triangles()
    F = np.empty(3 * len(obj.data.loop_triangles), np.int32)
    obj.data.loop_triangles.foreach_get("vertices", F)
    a, b, c = V[F.reshape(-1, 3)].transpose(1, 0, 2)
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def edge_lengths(obj):
    E = np.empty(2 * len(obj.data.edges), np.int32)
    obj.data.edges.foreach_get("vertices", E)
    V = positions(obj)
    return np.linalg.norm(V[E[::2]] - V[E[1::2]], axis=1)


def border_edges(obj):
    """The number of edges of one face."""
    edges = np.empty(len(obj.data.loops), np.int32)
    obj.data.loops.foreach_get("edge_index", edges)
    return int((np.bincount(edges) == 1).sum())


def folders_left():
    return [name for name in os.listdir(bpy.app.tempdir) if name.startswith("batten-")]


class Case(unittest.TestCase):
    def setUp(self):
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)
        bpy.data.batch_remove([*bpy.data.meshes, *bpy.data.curves, *bpy.data.materials, *bpy.data.collections])
        bpy.context.view_layer.update()
        bpy.context.scene.unit_settings.scale_length = 1
        preferences().program = PROGRAM

    def tearDown(self):
        self.assertEqual(folders_left(), [])

    def surface(self, *objects, **options):
        select(*objects)
        self.assertEqual(bpy.ops.batten.surface(**options), {"FINISHED"})
        return bpy.context.object

    def refusal(self, operator, **options):
        before = len(bpy.data.objects), len(bpy.data.meshes), len(bpy.data.curves)
        with self.assertRaises(RuntimeError) as caught:
            operator(**options)
        self.assertEqual((len(bpy.data.objects), len(bpy.data.meshes), len(bpy.data.curves)), before)
        sentence = str(caught.exception)
        self.assertNotIn(bpy.app.tempdir, sentence)
        return sentence


class Surfaces(Case):
    def assert_sphere(self, obj, radius=1.0, centre=(0, 0, 0), tolerance=5e-4):
        """A circle of four Bezier pieces leaves the true one by 2.7e-4 of its radius."""
        from_centre = positions(obj, world=True) - centre
        distances = np.linalg.norm(from_centre, axis=1)
        self.assertLess(np.abs(distances - radius).max(), tolerance * radius)
        vertices, normals = corner_normals(obj)
        self.assertLess(degrees_between(normals, from_centre[vertices] / distances[vertices, None]).max(), 0.2)
        self.assertEqual(border_edges(obj), 0)
        self.assertGreater(volume(obj), 0)

    def test_three_bezier_circles_become_a_sphere_with_its_normals(self):
        collection = bpy.data.collections.new("Drawn")
        bpy.context.scene.collection.children.link(collection)
        circles = three_circles()
        for obj in circles:
            collection.objects.link(obj)
            bpy.context.collection.objects.unlink(obj)
        circles[2].data.materials.append(bpy.data.materials.new("Paint"))
        sphere = self.surface(*circles)
        self.assert_sphere(sphere)
        self.assertEqual([c.name for c in sphere.users_collection], ["Drawn"])
        self.assertEqual([m.name for m in sphere.data.materials], ["Paint"])
        self.assertEqual(bpy.context.selected_objects, [sphere])
        self.assertTrue(sphere.data.has_custom_normals)
        self.assertEqual(len(bpy.data.objects), 4)

    def test_transforms_of_objects_and_their_parents_count(self):
        circles = three_circles()
        parent = bpy.data.objects.new("Parent", None)
        bpy.context.collection.objects.link(parent)
        parent.matrix_world = Matrix.Translation((10, -20, 5)) @ Matrix.Rotation(0.7, 4, "X") @ Matrix.Scale(-3, 4)
        for obj in circles:
            obj.parent = parent
        sphere = self.surface(*circles)
        self.assert_sphere(sphere, 3, (10, -20, 5))
        # Its origin is that of the active curve; it has no rotation and no scale.
        self.assertEqual([tuple(row) for row in sphere.matrix_world], [tuple(row) for row in Matrix.Translation((10, -20, 5))])

    def test_thick_curves_are_their_middle_lines(self):
        before = len(bpy.data.curves)
        self.assert_sphere(self.surface(*three_circles(bevel_depth=0.1)))
        self.assertEqual(len(bpy.data.curves), before + 3)
        self.assertEqual(len(bpy.data.objects), 4)

    def test_half_a_sketch_with_a_mirror_is_a_whole_one(self):
        whole = arc(lambda t: (0, math.cos(t), math.sin(t)), 360)
        halves = [arc(lambda t: (math.sin(t), math.cos(t), 0)), arc(lambda t: (math.sin(t), 0, math.cos(t)))]
        for half in halves:
            half.modifiers.new("Mirror", "MIRROR")
        sphere = self.surface(whole, *halves)
        self.assert_sphere(sphere)
        half_alone = [half.modifiers.remove(half.modifiers[0]) for half in halves]
        self.assertEqual(len(half_alone), 2)
        self.assertLess(volume(self.surface(whole, *halves)), 0.7 * volume(sphere))

    def test_a_surface_ends_at_a_marked_border_and_closes_without_the_mark(self):
        rim = arc(lambda t: (math.cos(t), math.sin(t), 0), 360)
        ribs = [arc(lambda t: (math.cos(t), 0, math.sin(t))), arc(lambda t: (0, math.cos(t), math.sin(t)))]
        self.assertEqual(border_edges(self.surface(rim, *ribs)), 0)
        select(rim)
        bpy.ops.batten.mark_curves(kind="BORDER")
        self.assertEqual(rim.batten_curve, "BORDER")
        dome = self.surface(rim, *ribs)
        self.assertGreater(border_edges(dome), 100)
        self.assertGreater(positions(dome, world=True)[:, 2].min(), -1e-6)
        self.assertLess(np.abs(np.linalg.norm(positions(dome, world=True), axis=1) - 1).max(), 0.1)  # two ribs: roughly a sphere

    def edges_of_a_cube(self, mark):
        corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
        pairs = [(a, b) for a in range(8) for b in range(a) if bin(a ^ b).count("1") == 1]
        obj = mesh_object(corners, [], "Wires", pairs)
        for edge in obj.data.edges:
            edge.use_edge_sharp = mark
        return obj

    def test_sharp_edges_of_a_mesh_are_edges_of_the_surface(self):
        cube = self.surface(self.edges_of_a_cube(True))
        self.assertAlmostEqual(volume(cube), 1, delta=1e-5)
        marked = [edge.use_edge_sharp for edge in cube.data.edges]
        self.assertAlmostEqual(edge_lengths(cube)[marked].sum(), 12, delta=1e-4)
        self.assertEqual([edge.crease == 1 for edge in cube.data.edges], marked)
        # Every corner is drawn with the normal of its side, also on the edges.
        normals = corner_normals(cube)[1]
        self.assertLess(degrees_between(normals, np.repeat(face_normals(cube), 3, axis=0)).max(), 0.1)
        rounded = self.surface(self.edges_of_a_cube(False))
        self.assertGreater(volume(rounded), 1.1)

    def test_lengths_are_those_of_the_scene(self):
        for name in ("surface", "remesh"):
            properties = getattr(bpy.ops.batten, name).get_rna_type().properties
            self.assertEqual(properties["edge_length" if name == "surface" else "edge"].unit, "LENGTH")
            self.assertEqual(properties["sharp_angle"].subtype, "ANGLE")
        bpy.context.scene.unit_settings.scale_length = 0.001
        sphere = self.surface(*three_circles(), edge_length=0.2)
        mean = edge_lengths(sphere).mean()
        fine = self.surface(*three_circles())
        self.assertLess(len(sphere.data.polygons), 0.5 * len(fine.data.polygons))
        self.assertTrue(0.05 < mean < 0.25, mean)

    def test_refusals_are_those_of_the_program(self):
        select(line([(0, 0, 0), (1, 0, 0)]))
        self.assertIn("no closed cycle", self.refusal(bpy.ops.batten.surface))

    def test_a_curve_of_no_length_is_refused(self):
        select(line([(1, 1, 1), (1, 1, 1)]))
        self.assertIn("no extent", self.refusal(bpy.ops.batten.surface))

    def test_curves_without_points_and_solid_meshes_are_refused_by_name(self):
        empty = bpy.data.objects.new("Nothing", bpy.data.curves.new("Nothing", "CURVE"))
        bpy.context.collection.objects.link(empty)
        bpy.ops.mesh.primitive_cube_add()
        select(empty, bpy.context.object)
        sentence = self.refusal(bpy.ops.batten.surface)
        self.assertIn("Nothing was left out: it has no line", sentence)
        self.assertIn("Cube was left out: it has no edges without faces", sentence)

    def test_text_alone_greys_out_and_beside_curves_is_left_out(self):
        bpy.ops.object.text_add()
        text = bpy.context.object
        select(text)
        self.assertFalse(bpy.ops.batten.surface.poll())
        self.assert_sphere(self.surface(*three_circles(), text))

    def test_nothing_selected_greys_everything_out(self):
        circle()
        select()
        for name in ("surface", "fair", "repair", "remesh", "simplify", "mark_curves"):
            self.assertFalse(getattr(bpy.ops.batten, name).poll(), name)
        select(circle())
        bpy.ops.object.mode_set(mode="EDIT")
        self.assertFalse(bpy.ops.batten.surface.poll())
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assertTrue(bpy.ops.batten.surface.poll())
        self.assertFalse(bpy.ops.batten.fair.poll())


class Meshes(Case):
    def test_fairing_removes_noise_and_keeps_edges_polygons_and_materials(self):
        n = 16
        cube = cube_of_quads(n, noise=0.02)
        for name in ("Red", "Blue"):
            cube.data.materials.append(bpy.data.materials.new(name))
        cube.data.polygons.foreach_set("material_index", np.arange(len(cube.data.polygons), dtype=np.int32) % 2)
        cube.data.uv_layers.new(name="Map")
        cube.location = (3, 0, 0)
        bpy.context.view_layer.update()

        def error(obj):
            N = np.sort(np.abs(face_normals(obj)), axis=1)
            return degrees_between(N, np.tile([0.0, 0.0, 1.0], (len(N), 1))).mean()

        before = error(cube)
        self.assertEqual(bpy.ops.batten.fair(), {"FINISHED"})
        faired = bpy.context.object
        self.assertGreater(before, 8)
        self.assertLess(error(faired), 1.5)
        self.assertAlmostEqual(volume(faired), 8, delta=0.1)
        self.assertEqual([len(p.vertices) for p in faired.data.polygons], [4] * (6 * n * n))
        self.assertEqual([p.material_index for p in faired.data.polygons], [p.material_index for p in cube.data.polygons])
        self.assertEqual([m.name for m in faired.data.materials], ["Red", "Blue"])
        self.assertIn("Map", faired.data.uv_layers)
        creases = [edge for edge in faired.data.edges if edge.crease == 1]
        self.assertEqual(len(creases), 12 * n)
        self.assertTrue(all(edge.use_edge_sharp for edge in creases))
        self.assertTrue(cube.hide_get())
        self.assertLess(np.abs(positions(faired, world=True).mean(axis=0) - (3, 0, 0)).max(), 0.02)

    def test_fairing_takes_what_modifiers_make_and_keeps_the_source(self):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4)
        sphere = bpy.context.object
        sphere.modifiers.new("Subsurf", "SUBSURF").levels = 1
        n = len(sphere.data.vertices)
        bpy.ops.batten.fair(method="taubin", iterations=5)
        self.assertGreater(len(bpy.context.object.data.vertices), 3 * n)
        self.assertEqual(len(sphere.data.vertices), n)
        self.assertEqual(len(bpy.context.object.modifiers), 0)

    def test_remeshing_takes_a_length_keeps_edges_and_materials(self):
        cube = cube_of_quads(8)
        for name in ("Sides", "Top"):
            cube.data.materials.append(bpy.data.materials.new(name))
        for polygon in cube.data.polygons:
            polygon.material_index = int(polygon.center.z > 0.99)
        cube.scale = (-2, 1, 1)
        bpy.context.view_layer.update()
        self.assertEqual(bpy.ops.batten.remesh(edge=0.3, adaptivity=0), {"FINISHED"})
        even = bpy.context.object
        self.assertAlmostEqual(volume(even), 16, delta=1e-3)
        mean = edge_lengths(even).mean()
        self.assertTrue(0.2 < mean < 0.4, mean)
        tops = {polygon.material_index for polygon in even.data.polygons if polygon.center.z > 0.99}
        sides = {polygon.material_index for polygon in even.data.polygons if polygon.center.z < 0.9}
        self.assertEqual((tops, sides), ({1}, {0}))
        creases = [edge.crease == 1 for edge in even.data.edges]
        self.assertAlmostEqual(edge_lengths(even)[creases].sum(), 32, delta=0.01)

    def test_simplifying_by_share_number_and_distance(self):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5)
        sphere = bpy.context.object
        n = len(sphere.data.polygons)
        for options, most in (({"remove": 75}, n // 4), ({"by": "faces", "faces": 500}, 500)):
            sphere.hide_set(False)
            select(sphere)
            bpy.ops.batten.simplify(**options)
            self.assertTrue(0.9 * most <= len(bpy.context.object.data.polygons) <= most)
        sphere.hide_set(False)
        select(sphere)
        bpy.ops.batten.simplify(by="error", error=0.02)
        radii = np.linalg.norm(positions(bpy.context.object), axis=1)
        self.assertLess(np.abs(radii - 1).max(), 0.021)

    def test_repairing_fills_holes_and_welds(self):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3)
        sphere = bpy.context.object
        V = positions(sphere)
        F = np.array([p.vertices for p in sphere.data.polygons])
        soup = mesh_object(V[F[1:]].reshape(-1, 3), np.arange(3 * (len(F) - 1)).reshape(-1, 3), "Soup")
        select(soup)
        bpy.ops.batten.repair(holes="all")
        whole = bpy.context.object
        self.assertEqual((border_edges(whole), len(whole.data.vertices)), (0, len(V)))

    def test_meshes_that_are_no_surface_are_refused_or_mended(self):
        fin = mesh_object([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)], [(0, 1, 2), (0, 1, 3), (0, 1, 4)], "Fin")
        select(fin)
        self.assertIn("the edge has more than two faces", self.refusal(bpy.ops.batten.remesh))
        self.assertEqual(bpy.ops.batten.fair(repair=True), {"FINISHED"})

    def test_a_mesh_without_faces_is_refused(self):
        select(mesh_object([(0, 0, 0), (1, 0, 0)], [], "Wire", [(0, 1)]))
        self.assertIn("Wire has no faces", self.refusal(bpy.ops.batten.fair))


class Files(Case):
    def test_a_scan_arrives_with_its_normals_and_becomes_a_surface(self):
        bpy.ops.batten.import_curves(filepath=os.path.join(DATA, "sample.rawnet"))
        edges = bpy.context.object
        self.assertEqual((edges.name, edges.type, len(edges.data.polygons)), ("sample", "MESH", 0))
        surface = self.surface(edges)
        self.assertEqual(border_edges(surface), 0)
        with_normals = volume(surface)
        # The bumpy cube of docs/simulate.md, turned as scanned; a mirror of the normals would turn it inside out.
        self.assertGreater(with_normals, 0)
        edges.data.attributes.remove(edges.data.attributes["batten_normal"])
        without = volume(self.surface(edges))
        self.assertNotEqual(with_normals, without)
        self.assertAlmostEqual(without / with_normals, 1, delta=0.02)

    def network(self, name, text):
        path = os.path.join(bpy.app.tempdir, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        self.addCleanup(os.remove, path)
        return path

    SQUARE = {
        "format": "batten-network", "version": 1, "unit": "mm", "positions": [[0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0]],
        "curves": [{"name": "rim", "boundary": True, "vertices": [0, 1, 2, 3, 0]}, {"sharp": True, "vertices": [0, 2]}],
    }

    def test_networks_arrive_as_curves_with_their_marks_in_their_unit(self):
        path = self.network("square.json", json.dumps(self.SQUARE))
        for scale, expected in ((1, 0.01), (0.001, 10)):
            bpy.context.scene.unit_settings.scale_length = scale
            bpy.ops.batten.import_curves(filepath=path)
            rim = bpy.context.selected_objects[0]
            self.assertEqual([obj.batten_curve for obj in bpy.context.selected_objects], ["BORDER", "SHARP"])
            self.assertTrue(rim.name.startswith("rim") and rim.data.splines[0].use_cyclic_u)
            self.assertEqual(len(rim.data.splines[0].points), 4)
            self.assertAlmostEqual(rim.data.splines[0].points[2].co[0], expected, delta=1e-6 * expected)

    def test_networks_arrive_as_edges_with_their_marks(self):
        bpy.ops.batten.import_curves(filepath=self.network("square.json", json.dumps(self.SQUARE)), shape="edges", scale=1000)
        mesh = bpy.context.object.data
        self.assertEqual([(e.use_seam, e.use_edge_sharp) for e in mesh.edges], [(True, False)] * 4 + [(False, True)])
        self.assertAlmostEqual(mesh.vertices[2].co[0], 10, places=5)

    def test_net_and_obj_arrive(self):
        net = "3\n0 0 0\n1 0 0\n1 1 0\n1\n1\n0 1 2 0\n"
        obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2 3 1\n"
        for path in (self.network("triangle.net", net), self.network("triangle.obj", obj)):
            bpy.ops.batten.import_curves(filepath=path)
            self.assertEqual(len(bpy.context.object.data.splines[0].points), 3)

    def test_files_that_are_none_are_refused_with_their_name(self):
        path = self.network("broken.net", "3\n0 0\n")
        sentence = self.refusal(bpy.ops.batten.import_curves, filepath=path)  # names the file, which lies in the folder
        self.assertIn("broken.net", sentence)

    def refusal(self, operator, **options):
        with self.assertRaises(RuntimeError) as caught:
            operator(**options)
        return str(caught.exception)


class Programs(Case):
    def test_a_wrong_path_is_told_with_a_remedy(self):
        select(*three_circles())
        for path, words in (("/nowhere/batten", "is not a file"), ("/bin/ls", "is not the program batten")):
            preferences().program = path
            sentence = self.refusal(bpy.ops.batten.surface)
            self.assertIn(f"{path} {words}", sentence)
            self.assertIn("preferences", sentence)

    def test_the_program_is_found_on_path(self):
        preferences().program = ""
        before = os.environ["PATH"]
        os.environ["PATH"] = os.path.dirname(PROGRAM) + os.pathsep + before
        try:
            select(*three_circles())
            self.assertEqual(bpy.ops.batten.surface(), {"FINISHED"})
        finally:
            os.environ["PATH"] = before

    def test_the_add_on_can_be_taken_off_and_put_on(self):
        bpy.ops.preferences.addon_disable(module="batten_blender")
        self.assertFalse(hasattr(bpy.types.Object, "batten_curve"))
        bpy.ops.preferences.addon_enable(module="batten_blender")
        preferences().program = PROGRAM
        self.assertTrue(hasattr(bpy.types.Object, "batten_curve"))


class Recorder(unittest.TestResult):
    """What became of every test, by its name."""

    def __init__(self):
        super().__init__()
        self.outcome = {}

    def addSuccess(self, test):
        self.outcome[test._testMethodName] = ""

    def addFailure(self, test, err):
        self.outcome[test._testMethodName] = self._exc_info_to_string(err, test)

    addError = addFailure


if __name__ == "__main__":
    bpy.ops.preferences.addon_install(filepath=ADDON)
    bpy.ops.preferences.addon_enable(module="batten_blender")
    recorder = Recorder()
    unittest.defaultTestLoader.loadTestsFromModule(sys.modules["__main__"]).run(recorder)
    with open(RESULTS, "w", encoding="utf-8") as file:
        json.dump(recorder.outcome, file, indent=1)
