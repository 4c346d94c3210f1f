"""Triangle meshes and what is made of them."""

import json

from . import _batten
from ._errors import InvalidInput
from ._options import mesh_of, shape_of


class Mesh:
    """A triangle mesh as arrays.

    ``V, F = mesh`` gives positions and triangles. The arrays may be edited; they are checked whenever a
    function takes the mesh.

    Parameters
    ----------
    positions : array_like, n x 3
        In the unit of the file.
    triangles : array_like of int, m x 3
        Vertices, counter-clockwise seen from outside.
    normals : array_like, n x 3, optional
        Unit normals.
    values : dict of str to array_like, optional
        Numbers per vertex by name, n each (properties of PLY files).
    name : str
        What messages call the mesh.
    unit : str
        Of length, "mm" and the like; empty: not known.

    Attributes
    ----------
    warnings : list of str
        What was told when the mesh was read or made.
    report : dict or None
        Figures of the function that made it, under the keys of ``batten ... --json``.
    vertex_map, levels
        Of simplify() alone.
    """

    def __init__(self, positions, triangles, normals=None, values=None, *, name="mesh", unit=""):
        self.positions = positions
        self.triangles = triangles
        self.normals = normals
        self.values = {} if values is None else dict(values)
        self.name = name
        self.unit = unit
        self.warnings = []
        self.report = None
        self.vertex_map = None
        self.levels = []
        self._attributes = None

    def __iter__(self):
        """Positions and triangles, in this order."""
        return iter((self.positions, self.triangles))

    def __repr__(self):
        return f"<batten.{type(self).__name__}: {len(self.positions)} vertices, {len(self.triangles)} triangles>"

    def __getstate__(self):
        # What a file said beyond the arrays is not pickled.
        return {**self.__dict__, "_attributes": None}


class Surface(Mesh):
    """A surface through a network.

    Attributes
    ----------
    patch_of_triangle : array of int, m
        The patch that each triangle fills.
    network : Network
        The network that was filled, mended where that was needed.
    """

    def __init__(self, positions, triangles, normals=None, values=None, *, name="surface", unit=""):
        super().__init__(positions, triangles, normals, values, name=name, unit=unit)
        self.patch_of_triangle = None
        self.network = None

    @property
    def uncertainty(self):
        """The standard deviation of each vertex across the surface, n, or None where it was not asked for."""
        return self.values.get("uncertainty")


class Cage:
    """Polygons with what is sharp, and the curves drawn along edges: what subdivision starts from.

    Parameters
    ----------
    positions : array_like, n x 3
    faces : list of array_like of int, or array_like m x k
        The vertices of each face, counter-clockwise seen from outside.
    sharp_edges : dict of (int, int) to float, optional
        For how many levels an edge stays sharp; infinity: for ever.
    sharp_vertices : dict of int to float, optional
        The same of vertices.
    polylines : dict of (int, int) to array_like k x 3, optional
        The curve along an edge, from one vertex to the other, both included.
    normals : array_like, n x 3, optional
        Unit normals, for writing.
    """

    def __init__(self, positions, faces, sharp_edges=None, sharp_vertices=None, polylines=None, normals=None):
        self.positions = positions
        self.faces = faces
        self.sharp_edges = {} if sharp_edges is None else dict(sharp_edges)
        self.sharp_vertices = {} if sharp_vertices is None else dict(sharp_vertices)
        self.polylines = {} if polylines is None else dict(polylines)
        self.normals = normals
        self.warnings = []

    def __repr__(self):
        return f"<batten.{type(self).__name__}: {len(self.positions)} vertices, {len(self.faces)} faces>"


class Subdivision(Cage):
    """A refined cage.

    Attributes
    ----------
    triangles : array of int, m x 3
        The same faces as triangles: quads cut along the diagonal from their first corner.
    report : dict
        Figures under the keys of ``batten subdivide --json``.
    """

    def __init__(self, positions, faces, sharp_edges=None, sharp_vertices=None, polylines=None, normals=None):
        super().__init__(positions, faces, sharp_edges, sharp_vertices, polylines, normals)
        self.triangles = None
        self.report = None

    def mesh(self):
        """The refined cage as a Mesh of triangles, with its normals."""
        return Mesh(self.positions, self.triangles, self.normals)


class CurveCheck:
    """Whether a surface is smooth across the curves of a network.

    Attributes
    ----------
    report : dict
        Figures under the keys of ``batten check --json``.
    warnings : list of str
    passes : bool
        No curve fails. Borders are not checked.
    curves : list of dict
        One per curve: ``name``, ``verdict`` ("pass", "fail", "sharp", "border"), ``reasons``, ``worst`` and figures.
    """

    def __init__(self, report):
        self.report = report
        self.warnings = report["warnings"]
        self.passes = report["passes"]
        self.curves = report["curves"]

    def __repr__(self):
        return f"<batten.CurveCheck: {self.report['failed']} of {self.report['checked']} curves fail>"


class Comparison:
    """How two shapes differ.

    Attributes
    ----------
    report : dict
        Figures under the keys of ``batten compare --json``.
    warnings : list of str
    hausdorff : float
        The largest distance found, in either direction, in the unit of B.
    distances : array, n
        From each vertex of A, moved as it was, to B; NaN where no face uses the vertex.
    mesh : Mesh or None
        A, moved, with the value "distance"; None where A is a network.
    """

    def __init__(self, report, hausdorff, distances, mesh):
        self.report = report
        self.warnings = report["warnings"]
        self.hausdorff = hausdorff
        self.distances = distances
        self.mesh = mesh

    def __repr__(self):
        return f"<batten.Comparison: largest distance {self.hausdorff:.6g}>"


def _mesh(fields, kind=Mesh, **more):
    """A mesh of the fields that the compiled module gives."""
    mesh = kind(fields["positions"], fields["triangles"], fields["normals"], fields["values"], **more)
    mesh._attributes = fields["_attributes"]
    mesh.report = fields.get("report")
    mesh.warnings = fields["warnings"] if "warnings" in fields else mesh.report["warnings"] if mesh.report else []
    return mesh


def _cage(fields, kind=Cage):
    cage = kind(
        fields["positions"],
        fields["faces"],
        fields["sharp_edges"],
        fields["sharp_vertices"],
        fields["polylines"],
        fields.get("normals"),
    )
    cage.warnings = fields.get("warnings", [])
    return cage


def repair(V, F=None, *, weld="auto", orient=False, fill_holes=0, accept_flaws=False, progress=None):
    """Mend a mesh: weld, orient, separate sheets, fill holes. A mesh without fault is returned as it is.

    Parameters
    ----------
    V, F : array_like n x 3 and m x 3, or one Mesh
    weld : str or float
        Weld borders that lie within this distance: "auto", "off", a length such as "0.01mm" or "0.001%" of the
        diameter, or a number in the unit of the mesh.
    orient : bool
        Turn closed parts outward, and inward those that lie within another.
    fill_holes : int or str
        Fill holes of up to so many edges (from 3 on), or "all"; 0 fills none.
    accept_flaws : bool
        Return the result although not all could be repaired, with a warning.
    progress : callable of (str, float), optional
        Told the stage and the fraction done, at most every 20 ms; returns False to stop.

    Returns
    -------
    Mesh
        Manifold and oriented, with ``report``.

    Raises
    ------
    InvalidInput
        On arguments out of range, with row and value.
    Error
        Where not all could be repaired and that is not accepted.
    Cancelled
        When `progress` returns False.
    """
    options = dict(weld=weld, orient=orient, fill_holes=fill_holes, accept_flaws=accept_flaws)
    mesh = mesh_of(V, F)
    return _mesh(_batten.repair(mesh, options, progress), name=mesh.name, unit=mesh.unit)


def fair(
    V,
    F=None,
    *,
    method="auto",
    noise="auto",
    iterations=0,
    keep_boundary=False,
    repair=False,
    progress=None,
):
    """Remove noise from a mesh and keep its edges.

    Linear in the number of vertices: about a second for 100,000 with the defaults.

    Parameters
    ----------
    V, F : array_like n x 3 and m x 3, or one Mesh
        An oriented manifold; a soup of triangles is welded first, with a warning.
    method : str
        "auto" chooses by itself; the others are the thesis's flows and well-known filters: "nlsdf", "sdf", "mcf",
        "bilaplacian", "amcf", "amcf-tensor", "tv", "taubin", "bilateral-normal", "guided-normal", "elastica",
        "nonlocal".
    noise : str or float
        Standard deviation of the noise in mean edge lengths, or "auto" to estimate it.
    iterations : int
        Rounds or steps, 0 to 100,000; 0 takes the method's own number.
    keep_boundary : bool
        Keep border vertices in place.
    repair : bool
        Mend the input first, as repair() does.
    progress : callable of (str, float), optional
        Told the stage and the fraction done, at most every 20 ms; returns False to stop.

    Returns
    -------
    Mesh
        The same triangles with new positions (and normals, where there were any), with ``report``.

    Raises
    ------
    InvalidInput
        On arguments out of range, with row and value, and on meshes that are no oriented manifold.
    SolverFailure, Cancelled
    """
    options = dict(method=method, noise=noise, iterations=iterations, keep_boundary=keep_boundary, repair=repair)
    mesh = mesh_of(V, F)
    return _mesh(_batten.fair(mesh, options, progress), name=mesh.name, unit=mesh.unit)


def remesh(
    V,
    F=None,
    *,
    edge=None,
    vertices=0,
    adaptivity=0.1,
    keep_edges="30deg",
    keep_border="curve",
    method="ar",
    sizes=None,
    iterations=8,
    repair=False,
    accept_flaws=False,
    progress=None,
):
    """Replace the triangles of a surface by better ones.

    Parameters
    ----------
    V, F : array_like n x 3 and m x 3, or one Mesh
        An oriented manifold; a soup of triangles is welded first, with a warning.
    edge : str or float, optional
        Edge length: a number in the unit of the mesh, "2mm" or "1.6%" of the diameter; None: that of the input.
    vertices : int
        Number of vertices (4 and more), instead of an edge length; 0 leaves it to that.
    adaptivity : float
        0: even; 1: as fine as curvature asks.
    keep_edges : str or float
        Keep edges sharper than this angle, above 0 to 180 degrees ("30deg", "0.5rad", or a number of degrees).
    keep_border : str
        "curve": border vertices move along the border; "exact": they all stay, so that tiles join.
    method : str
        "ar": adaptive remeshing; "lf": Laplacian flow.
    sizes : array_like, n, or str, optional
        Wanted edge lengths per vertex, or the name of such a value of the mesh.
    iterations : int
        Most rounds, 1 to 1000.
    repair : bool
        Mend the input first, as repair() does.
    accept_flaws : bool
        Return the result, with a warning, even where it crosses itself or misses surface or size.
    progress : callable of (str, float), optional
        Told the stage and the fraction done, at most every 20 ms; returns False to stop.

    Returns
    -------
    Mesh
        With the values of the input, and ``report``.

    Raises
    ------
    InvalidInput
        On arguments out of range, with row and value, and on meshes that are no oriented manifold.
    Error
        Where the result is not what was asked for and that is not accepted.
    Cancelled
    """
    is_array = sizes is not None and not isinstance(sizes, str)
    options = dict(
        edge=edge,
        vertices=vertices,
        adaptivity=adaptivity,
        keep_edges=keep_edges,
        keep_border=keep_border,
        method=method,
        sizes=None if is_array else sizes,
        iterations=iterations,
        repair=repair,
        accept_flaws=accept_flaws,
    )
    mesh = mesh_of(V, F)
    fields = _batten.remesh(mesh, sizes if is_array else None, options, progress)
    return _mesh(fields, name=mesh.name, unit=mesh.unit)


def simplify(
    V,
    F=None,
    *,
    faces=0,
    remove=None,
    error=None,
    levels=3,
    method="quadric",
    keep_edges="off",
    keep_border="shape",
    p=0.1,
    alpha=1.0,
    beta=1.0,
    weight="w3",
    sigma=0.5,
    fidelity="adaptive",
    keep_all_levels=False,
    repair=False,
    progress=None,
):
    """Reduce the number of triangles of a mesh. Exactly one of `faces`, `remove` and `error` says where to stop.

    Parameters
    ----------
    V, F : array_like n x 3 and m x 3, or one Mesh
        An oriented manifold; a soup of triangles is welded first, with a warning.
    faces : int
        Keep at most this many faces; 0: another criterion.
    remove : str or float, optional
        Remove this share of the faces: "95%" or 0.95.
    error : str or float, optional
        Stay within this distance of the input, in both directions: a number in the unit of the mesh, "2mm", "0.5%".
    levels : int
        Levels of "plaplacian" and of `keep_all_levels`, 1 to 100.
    method : str
        Which edges go: "quadric" or "plaplacian".
    keep_edges : str or float
        Edges sharper than this angle stay edges ("30deg"), or "off": as the error asks for it.
    keep_border : str
        "shape": as far as the error asks for it; "exact": border vertices all stay, so that tiles join.
    p, alpha, beta, weight, sigma, fidelity
        Of "plaplacian": exponent of the flow, above 0 to 2; exponents of error and length; "w1" even, "w2" by length,
        "w3" by curvature; width of w3, above 0; "adaptive" or one number for all.
    keep_all_levels : bool
        Give the mesh of every level too, with its map to the next coarser one.
    repair : bool
        Mend the input first, as repair() does.
    progress : callable of (str, float), optional
        Told the stage and the fraction done, at most every 20 ms; returns False to stop.

    Returns
    -------
    Mesh
        With the values of the input, ``report``, ``vertex_map`` (n: the vertex of the result that stands for each of the
        input, -1 where no face used it) and ``levels`` (Meshes from the input on, those but the last with the value
        "coarser_vertex"; empty unless asked for).

    Raises
    ------
    InvalidInput
        On arguments out of range, with row and value, and on meshes that are no oriented manifold.
    Cancelled
    """
    options = dict(
        faces=faces,
        remove=remove,
        error=error,
        levels=levels,
        method=method,
        keep_edges=keep_edges,
        keep_border=keep_border,
        p=p,
        alpha=alpha,
        beta=beta,
        weight=weight,
        sigma=sigma,
        fidelity=fidelity,
        keep_all_levels=keep_all_levels,
        repair=repair,
    )
    mesh = mesh_of(V, F)
    fields = _batten.simplify(mesh, options, progress)
    made = _mesh(fields, name=mesh.name, unit=mesh.unit)
    made.vertex_map = fields["vertex_map"]
    made.levels = [_mesh(level, name=mesh.name, unit=mesh.unit) for level in fields["levels"]]
    return made


def _plain(value):
    """Arrays and numbers of numpy as JSON has them."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError("handles hold dicts, lists, numbers and arrays, got " + type(value).__name__)


def deform(
    V,
    F=None,
    *,
    handles,
    energy="total",
    nonlinear="gauss-newton",
    soft=0.0,
    multiresolution=False,
    iterations=200,
    repair=False,
    progress=None,
):
    """Bend, twist and stretch a surface by handles, its detail kept.

    Parameters
    ----------
    V, F : array_like n x 3 and m x 3, or one Mesh
    handles : dict
        What is fixed and what moves, as docs/deform.md has it: ``{"fixed": {"vertices": [...]}, "handles": [{"select":
        {"box": [[x, y, z], [x, y, z]]}, "translate": [x, y, z], "rotate_deg": [ax, ay, az, angle]}]}``. Arrays may
        stand for lists.
    energy : str
        "stretch", "bend", "combined" or "total" (curvature).
    nonlinear : str
        How detail turns with the surface: "gauss-newton", "shape-matching" or "none".
    soft : float
        Weight of soft handles; 0 meets them exactly.
    multiresolution : bool
        Iterate on a simplified mesh, put the detail back, finish on the mesh itself.
    iterations : int
        Most iterations per part of the motion, 1 to 100,000.
    repair : bool
        Mend the input first, as repair() does.
    progress : callable of (str, float), optional
        Told the stage and the fraction done, at most every 20 ms; returns False to stop.

    Returns
    -------
    Mesh
        The same triangles with new positions, with ``report``.

    Raises
    ------
    InvalidInput
        On arguments out of range, with row and value, and on handles with an unknown member, without vertices or with one
        that another has too.
    SolverFailure, Cancelled
    """
    options = dict(
        energy=energy,
        nonlinear=nonlinear,
        soft=soft,
        multiresolution=multiresolution,
        iterations=iterations,
        repair=repair,
    )
    mesh = mesh_of(V, F)
    try:
        text = json.dumps(handles, default=_plain)
    except (TypeError, ValueError) as problem:
        raise InvalidInput(f"handles: {problem}") from None
    return _mesh(_batten.deform(mesh, text, options, progress), name=mesh.name, unit=mesh.unit)


def subdivide(cage, *, scheme="catmull-clark", levels=3, limit=False, corners="sharp", knots=0.5, progress=None):
    """Refine a cage of polygons into a smooth surface. Every level has four times as many faces.

    Parameters
    ----------
    cage : Cage, Mesh, or pair (positions, faces)
    scheme : str or list of str
        "catmull-clark", "nuliss", "nulissmod" or "linear"; a list (or text with commas): each but the last makes one level.
    levels : int
        Levels of refinement, 0 to 12.
    limit : bool
        Move the vertices onto the limit surface.
    corners : str
        Corners of the border: "sharp" or "smooth".
    knots : float
        NULISS: exponent of the lengths, 0 uniform to 1 chord length.
    progress : callable of (str, float), optional
        Told the stage and the fraction done, at most every 20 ms; returns False to stop.

    Returns
    -------
    Subdivision

    Raises
    ------
    InvalidInput
        On arguments out of range, naming face, edge or vertex.
    Cancelled
    """
    if isinstance(cage, Mesh):
        cage = Cage(cage.positions, cage.triangles)
    elif isinstance(cage, (tuple, list)) and len(cage) == 2:
        cage = Cage(*cage)
    elif not isinstance(cage, Cage):
        raise InvalidInput("give a Cage, a Mesh or a pair of positions and faces, got " + type(cage).__name__)
    options = dict(scheme=scheme, levels=levels, limit=limit, corners=corners, knots=knots)
    fields = _batten.subdivide(cage, options, progress)
    made = _cage(fields, Subdivision)
    made.triangles = fields["triangles"]
    made.report = fields["report"]
    made.warnings = made.report["warnings"]
    return made


def compare(A, B, *, register="none", samples=200000, seed=1, repair=False, progress=None):
    """Measure the distance between two meshes or networks, in both directions.

    Parameters
    ----------
    A, B : Mesh, Network or pair (positions, triangles)
        A is moved and measured, against B.
    register : str
        Move A onto B first: "none", "rigid" or "similarity".
    samples : int
        Random points per direction, uniform by area or length.
    seed : int
        Of the random points.
    repair : bool
        Mend meshes first, as repair() does.
    progress : callable of (str, float), optional
        Told the stage and the fraction done, at most every 20 ms; returns False to stop.

    Returns
    -------
    Comparison

    Raises
    ------
    InvalidInput
        On arguments out of range, with row and value, and on shapes that are empty.
    Cancelled
    """
    options = dict(register=register, samples=samples, seed=seed, repair=repair)
    A = shape_of(A)
    fields = _batten.compare(A, shape_of(B), options, progress)
    moved = None if fields["mesh"] is None else _mesh(fields["mesh"], name=A.name, unit=A.unit)
    return Comparison(fields["report"], fields["hausdorff"], fields["distances"], moved)


def check(
    surface, network, *, continuity="g1", tolerance="0.5deg", gap=0.1, curvature=10, distance=1, progress=None
):
    """Say of every curve of a network whether a surface is smooth across it.

    Parameters
    ----------
    surface : Mesh or pair (positions, triangles)
    network : Network
        The curves; best they run along edges of the surface.
    continuity : str
        What to hold it to: "g0" no gap, "g1" one normal, "g2" one curvature.
    tolerance : str or float
        Largest angle between the normals of both sides; a number is in degrees.
    gap : float
        Largest gap between both sides, % of the size of the surface.
    curvature : float
        For "g2": largest difference of the curvatures, % of the larger one.
    distance : float
        Largest distance of a curve from the surface, % of its size.
    progress : callable of (str, float), optional
        Told the stage and the fraction done, at most every 20 ms; returns False to stop.

    Returns
    -------
    CurveCheck

    Raises
    ------
    InvalidInput
        On arguments out of range, with row and value, and on a network without curves.
    Cancelled
    """
    options = dict(continuity=continuity, tolerance=tolerance, gap=gap, curvature=curvature, distance=distance)
    return CurveCheck(_batten.check(shape_of(surface), network, options, progress)["report"])


def carry_values(A, B, *, progress=None):
    """Give B the values per vertex of A, taken at the nearest points of A.

    Amounts are interpolated, colours interpolated and rounded, other whole numbers are those of the nearest corner.

    Parameters
    ----------
    A, B : Mesh
        Two meshes on the same surface.
    progress : callable of (str, float), optional
        Told the stage and the fraction done, at most every 20 ms; returns False to stop.

    Returns
    -------
    Mesh
        B with the values of A beside its own, and with normals of its own where A has any.

    Raises
    ------
    InvalidInput
        On arguments out of range, with row and value.
    Cancelled
    """
    return _mesh(_batten.carry_values(mesh_of(A, None), mesh_of(B, None), progress), name=B.name, unit=B.unit)

