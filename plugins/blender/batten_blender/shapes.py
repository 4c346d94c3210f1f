"""Blender's objects as arrays, in the coordinates of the world, and arrays as Blender's objects."""

import bpy
import numpy as np

from . import curves as curve_files
from .program import Refusal

NORMAL = "batten_normal"  # attribute of imported edges: the normals of the surface, which curves of Blender cannot hold


def _matrix(obj):
    return np.array(obj.matrix_world, float)


def _moved(matrix, points):
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def _column(collection, name, width, dtype):
    values = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, values)
    return values.reshape(-1, width) if width > 1 else values


# From Blender


def edge_kinds(mesh):
    """Seams are borders, sharp edges are sharp curves."""
    seams, sharp = _column(mesh.edges, "use_seam", 1, bool), sharp_marks(mesh)
    return np.where(sharp, curve_files.SHARP, np.where(seams, curve_files.BORDER, curve_files.INNER))


def _polylines(obj, mesh):
    """The edges of an evaluated mesh that have no faces, as a network in the coordinates of the world."""
    points = _column(mesh.vertices, "co", 3, np.float32).astype(float)
    edges = _column(mesh.edges, "vertices", 2, np.int32)
    kinds = edge_kinds(mesh) if obj.type == "MESH" else np.full(len(edges), obj.batten_curve)
    loose = np.ones(len(edges), bool)
    if len(mesh.polygons):
        loose[_column(mesh.loops, "edge_index", 1, np.int32)] = False
    edges, kinds = edges[loose], kinds[loose]
    if len(edges) == 0:
        return None
    used, edges = np.unique(edges, return_inverse=True)
    edges = edges.reshape(-1, 2)
    matrix = _matrix(obj)
    normals = None
    attribute = mesh.attributes.get(NORMAL)
    # Modifiers move normals as if they were plain numbers: a mirror does not mirror them.
    if attribute is not None and not any(modifier.show_viewport for modifier in obj.modifiers):
        normals = _column(attribute.data, "vector", 3, np.float32).astype(float)[used]
        normals = normals @ np.linalg.inv(matrix[:3, :3])
        lengths = np.linalg.norm(normals, axis=1)
        normals = normals / lengths[:, None] if lengths.min() > 0 else None  # a point that was added since has none
    curves = [(obj.name, chain, kind) for chain, kind in curve_files.chains(edges, kinds)]
    return curve_files.Network(_moved(matrix, points[used]), normals, curves)


def _without_thickness(context, obj):
    """A copy of a curve that is drawn thick or filled, as the bare line. It has to be removed."""
    bare = obj.copy()
    bare.data = obj.data.copy()
    bare.data.bevel_depth = bare.data.extrude = bare.data.offset = 0
    bare.data.bevel_object = None
    if bare.data.dimensions == "2D":
        bare.data.fill_mode = "NONE"
    context.scene.collection.objects.link(bare)
    context.view_layer.update()
    return bare


def network_of(context, objects):
    """The curves of objects, their modifiers applied, and sentences about what was left out.

    @raises Refusal where there is nothing.
    """
    networks, remarks = [], []
    for obj in objects:
        if obj.type not in {"CURVE", "MESH"}:
            remarks.append(f"{obj.name} was left out: it is neither a curve nor a mesh; convert it with Object > Convert > Curve")
            continue
        bare = None
        if obj.type == "CURVE":
            data = obj.data
            if data.bevel_depth or data.extrude or data.bevel_object or data.dimensions == "2D":
                bare = _without_thickness(context, obj)
        source = bare or obj
        evaluated = source.evaluated_get(context.evaluated_depsgraph_get())
        mesh = evaluated.to_mesh()
        try:
            network = _polylines(source, mesh) if mesh is not None else None
        finally:
            evaluated.to_mesh_clear()
            if bare:
                data = bare.data
                bpy.data.objects.remove(bare)
                bpy.data.curves.remove(data)
        if network is None:
            why = "it has no edges without faces" if obj.type == "MESH" else "it has no line of two points or more"
            remarks.append(f"{obj.name} was left out: {why}")
        else:
            network.curves = [(obj.name, vertices, kind) for _, vertices, kind in network.curves]
            networks.append(network)
    if not networks:
        raise Refusal("; ".join(remarks) or "nothing is selected; select curves, or meshes of edges without faces")
    joined = curve_files.joined(networks)
    if joined.normals is None and any(network.normals is not None for network in networks):
        remarks.append("the normals of imported curves were not used: not all of the selected curves have some")
    return joined, remarks


class Triangles:
    """A mesh in the coordinates of the world: vertices V, triangles F, the material of each."""

    def __init__(self, obj, mesh):
        matrix = _matrix(obj)
        self.V = _moved(matrix, _column(mesh.vertices, "co", 3, np.float32).astype(float))
        mesh.calc_loop_triangles()
        self.F = _column(mesh.loop_triangles, "vertices", 3, np.int32)
        polygon = _column(mesh.loop_triangles, "polygon_index", 1, np.int32)
        self.materials = _column(mesh.polygons, "material_index", 1, np.int32)[polygon]
        self.smooth = bool(len(mesh.polygons)) and bool(_column(mesh.polygons, "use_smooth", 1, bool).any())
        if is_turned_over(obj):
            self.F = self.F[:, ::-1]


def is_turned_over(obj):
    """Whether a negative scale turns the faces of an object inside out."""
    return np.linalg.det(_matrix(obj)[:3, :3]) < 0


def triangles_of(context, obj):
    """@raises Refusal where the object has no faces."""
    evaluated = obj.evaluated_get(context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    try:
        if len(mesh.polygons) == 0:
            raise Refusal(f"{obj.name} has no faces")
        return Triangles(obj, mesh)
    finally:
        evaluated.to_mesh_clear()


# To Blender. What differs between its versions is told by what they have. Only 3.4 has been run.


def sharp_marks(mesh):
    if "use_edge_sharp" in bpy.types.MeshEdge.bl_rna.properties:
        return _column(mesh.edges, "use_edge_sharp", 1, bool)
    attribute = mesh.attributes.get("sharp_edge")
    return _column(attribute.data, "value", 1, bool) if attribute else np.zeros(len(mesh.edges), bool)


def mark_edges(mesh, is_edge):
    """Adds marks to those that the mesh has: edges are sharp for shading, and creases of full weight for subdivision."""
    sharp = sharp_marks(mesh) | is_edge
    if "use_edge_sharp" in bpy.types.MeshEdge.bl_rna.properties:
        mesh.edges.foreach_set("use_edge_sharp", sharp)
    else:
        attribute = mesh.attributes.get("sharp_edge") or mesh.attributes.new("sharp_edge", "BOOLEAN", "EDGE")
        attribute.data.foreach_set("value", sharp)
    if "crease" in bpy.types.MeshEdge.bl_rna.properties:  # until 3.6
        creases = _column(mesh.edges, "crease", 1, np.float32)
        creases[is_edge] = 1
        mesh.edges.foreach_set("crease", creases)
    else:
        attribute = mesh.attributes.get("crease_edge") or mesh.attributes.new("crease_edge", "FLOAT", "EDGE")
        creases = _column(attribute.data, "value", 1, np.float32)
        creases[is_edge] = 1
        attribute.data.foreach_set("value", creases)


def show_marks(mesh):
    """Until 4.0 sharp edges and custom normals show only where this is on."""
    if hasattr(mesh, "use_auto_smooth"):
        mesh.use_auto_smooth = True
        mesh.auto_smooth_angle = np.pi


def sharp_edges(V, F, angle):
    """The edges (k x 2, the smaller vertex first) at which triangles meet at more than `angle`."""
    normals = np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)[:, None]
    edges = np.sort(np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]]), axis=1)
    face = np.tile(np.arange(len(F)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, face = edges[order], face[order]
    pairs = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    cosines = np.einsum("ij,ij->i", normals[face[pairs]], normals[face[pairs + 1]])
    return np.unique(edges[pairs[cosines < np.cos(angle)]], axis=0)


def _mark_sharp(mesh, V, F, angle):
    """Marks the edges of a mesh that are sharper than `angle`; @returns the vertices on them."""
    found = sharp_edges(V, F, angle).astype(np.int64)
    edges = np.sort(_column(mesh.edges, "vertices", 2, np.int32), axis=1).astype(np.int64)
    n = len(mesh.vertices)
    mark_edges(mesh, np.isin(edges[:, 0] * n + edges[:, 1], found[:, 0] * n + found[:, 1]))
    return np.unique(found)


def new_mesh(name, V, F, origin, *, angle, normals=None, materials=(), material_of_face=None, smooth=True):
    """A mesh of Blender, its coordinates relative to `origin`, with normals per vertex where there are some."""
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(V))
    mesh.vertices.foreach_set("co", (V - origin).astype(np.float32).ravel())
    mesh.loops.add(3 * len(F))
    mesh.loops.foreach_set("vertex_index", F.astype(np.int32).ravel())
    mesh.polygons.add(len(F))
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * len(F), 3, dtype=np.int32))
    if "loop_total" in bpy.types.MeshPolygon.bl_rna.properties and not bpy.types.MeshPolygon.bl_rna.properties["loop_total"].is_readonly:
        mesh.polygons.foreach_set("loop_total", np.full(len(F), 3, np.int32))
    for material in materials:
        mesh.materials.append(material)
    if material_of_face is not None:
        mesh.polygons.foreach_set("material_index", material_of_face.astype(np.int32))
    mesh.polygons.foreach_set("use_smooth", np.full(len(F), smooth))
    mesh.update(calc_edges=True)
    on_edges = _mark_sharp(mesh, V, F, angle)
    show_marks(mesh)
    if normals is not None:
        # Zero asks Blender for its own, which are those of each side on a sharp edge; the program has one per vertex.
        normals = normals.copy()
        normals[on_edges] = 0
        mesh.normals_split_custom_set(normals[F.ravel()].astype(np.float32))
    return mesh


def moved_copy(context, obj, V, F, origin, angle):
    """A copy of an object's evaluated mesh, with polygons, materials, layers and marks, its vertices at V."""
    depsgraph = context.evaluated_depsgraph_get()
    mesh = bpy.data.meshes.new_from_object(obj.evaluated_get(depsgraph), preserve_all_data_layers=True, depsgraph=depsgraph)
    if len(mesh.vertices) != len(V):
        bpy.data.meshes.remove(mesh)
        raise Refusal(f"{obj.name} was changed in the meantime; run it again")
    mesh.vertices.foreach_set("co", (V - origin).astype(np.float32).ravel())
    if is_turned_over(obj):
        mesh.flip_normals()
    if mesh.has_custom_normals:
        # Those of the noisy shape; zeros ask Blender for its own.
        mesh.normals_split_custom_set(np.zeros((len(mesh.loops), 3), np.float32))
    mesh.update()
    _mark_sharp(mesh, V, F, angle)
    show_marks(mesh)
    return mesh


def add_result(context, name, data, origin, source_name):
    """A new object beside its source, selected in place of what was."""
    obj = bpy.data.objects.new(name, data)
    obj.location = origin
    source = bpy.data.objects.get(source_name)
    collections = source.users_collection if source else ()
    (collections[0] if collections else context.scene.collection).objects.link(obj)
    for other in context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj
    return obj


def add_curves(context, name, network, scale):
    """An object per curve, in a collection of their own."""
    collection = bpy.data.collections.new(name)
    context.collection.children.link(collection)
    for number, (curve_name, vertices, kind) in enumerate(network.curves):
        label = curve_name or f"{name} {number}"
        data = bpy.data.curves.new(label, "CURVE")
        data.dimensions = "3D"
        spline = data.splines.new("POLY")
        closed = len(vertices) > 2 and vertices[0] == vertices[-1]
        points = network.positions[vertices[:-1] if closed else vertices] * scale
        spline.points.add(len(points) - 1)
        spline.points.foreach_set("co", np.column_stack([points, np.ones(len(points))]).astype(np.float32).ravel())
        spline.use_cyclic_u = closed
        obj = bpy.data.objects.new(label, data)
        obj.batten_curve = kind
        collection.objects.link(obj)
        obj.select_set(True)
        context.view_layer.objects.active = obj


def add_edges(context, name, network, scale):
    """One mesh of edges that keeps normals and what curves share; borders become seams, sharp curves sharp edges."""
    edges, kinds = [], []
    for _, vertices, kind in network.curves:
        edges += zip(vertices[:-1], vertices[1:])
        kinds += [kind] * (len(vertices) - 1)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata((network.positions * scale).tolist(), edges, [])
    kinds = np.array(kinds)
    mesh.edges.foreach_set("use_seam", kinds == curve_files.BORDER)
    is_sharp = kinds == curve_files.SHARP
    if is_sharp.any():
        mark_edges(mesh, is_sharp)
    if network.normals is not None:
        attribute = mesh.attributes.new(NORMAL, "FLOAT_VECTOR", "POINT")
        attribute.data.foreach_set("vector", network.normals.astype(np.float32).ravel())
    obj = bpy.data.objects.new(name, mesh)
    context.collection.objects.link(obj)
    obj.select_set(True)
    context.view_layer.objects.active = obj
