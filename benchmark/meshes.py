"""Triangle meshes as arrays: files, samples, exact distances, topology, crossings."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip


def read_ply(path):
    """Positions, triangles and normals (or None) of a PLY file of triangles."""
    with open(path, "rb") as file:
        elements, layout = [], None
        while (line := file.readline().decode("ascii").split()) != ["end_header"]:
            if not line and not elements and layout is None:
                raise ValueError(f"{path} is no PLY file")
            if line[:1] == ["format"]:
                layout = line[1]
            elif line[:1] == ["element"]:
                elements.append((line[1], int(line[2]), []))
            elif line[:1] == ["property"]:
                kind = ("list", line[2], line[3]) if line[1] == "list" else (line[1],)
                elements[-1][2].append((line[-1], kind))
        order = ">" if layout == "binary_big_endian" else "<"
        tables = {}
        for name, count, properties in elements:
            fields = []
            for field, kind in properties:
                if kind[0] == "list":
                    fields += [(field + "#", order + _TYPES[kind[1]]), (field, order + _TYPES[kind[2]], 3)]
                else:
                    fields.append((field, order + _TYPES[kind[0]]))
            if layout == "ascii":
                width = sum(3 if len(f) == 3 else 1 for f in fields)
                rows = [tuple(map(float, file.readline().split())) for _ in range(count)]
                if any(len(row) != width for row in rows):
                    raise ValueError(f"{path} has faces that are no triangles")
                flat, table, column = np.array(rows).reshape(count, width), np.zeros(count, dtype=fields), 0
                for f in fields:
                    wide = 3 if len(f) == 3 else 1
                    table[f[0]] = flat[:, column : column + wide].reshape(table[f[0]].shape)
                    column += wide
            else:
                table = np.frombuffer(file.read(count * np.dtype(fields).itemsize), dtype=fields)
            for f in fields:
                if f[0].endswith("#") and (table[f[0]] != 3).any():
                    raise ValueError(f"{path} has faces that are no triangles")
            tables[name] = table
    vertices = tables["vertex"]
    V = np.stack([vertices[axis].astype(float) for axis in "xyz"], axis=1)
    has_normals = "nx" in vertices.dtype.names
    N = np.stack([vertices["n" + axis].astype(float) for axis in "xyz"], axis=1) if has_normals else None
    F = np.zeros((0, 3), dtype=int)
    if "face" in tables and len(tables["face"]):
        faces = tables["face"]
        F = faces["vertex_indices" if "vertex_indices" in faces.dtype.names else "vertex_index"].astype(int)
    return V, F, N


def write_ply(path, V, F=None, N=None):
    """A binary PLY file; without triangles a set of points."""
    F = np.zeros((0, 3), dtype=int) if F is None else F
    columns = V if N is None else np.hstack([V, N])
    names = ["x", "y", "z", "nx", "ny", "nz"][: columns.shape[1]]
    faces = np.zeros(len(F), dtype=[("n", "u1"), ("v", "<i4", 3)])
    faces["n"], faces["v"] = 3, F
    with open(path, "wb") as file:
        header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(V)}"]
        header += [f"property double {name}" for name in names]
        if len(F):
            header += [f"element face {len(F)}", "property list uchar int vertex_indices"]
        file.write("\n".join([*header, "end_header", ""]).encode("ascii"))
        file.write(np.ascontiguousarray(columns, dtype="<f8").tobytes())
        file.write(faces.tobytes())


def areas_and_normals(V, F):
    """Area and unit normal of every triangle; a normal of zeros where the area is zero."""
    across = np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]])
    double = np.linalg.norm(across, axis=1)
    return double / 2, across / np.where(double > 0, double, 1)[:, None]


def vertex_normals(V, F):
    areas, N = areas_and_normals(V, F)
    total = np.zeros_like(V)
    for k in range(3):
        np.add.at(total, F[:, k], areas[:, None] * N)
    length = np.linalg.norm(total, axis=1)
    return total / np.where(length > 0, length, 1)[:, None]


def samples(V, F, count, seed=1):
    """Random points, uniform by area, and the triangles that they lie on."""
    random = np.random.default_rng(seed)
    areas, _ = areas_and_normals(V, F)
    on = random.choice(len(F), count, p=areas / areas.sum())
    u, v = np.sqrt(random.random(count)), random.random(count)
    weights = np.stack([1 - u, u * (1 - v), u * v], axis=1)
    return np.einsum("nk,nkd->nd", weights, V[F[on]]), on


def nearest_on_segments(Q, A, B):
    along = B - A
    t = ((Q - A) * along).sum(1) / np.maximum((along**2).sum(1), 1e-300)
    return A + np.clip(t, 0, 1)[:, None] * along


def nearest_on_triangles(Q, T):
    """The nearest point of triangle T[k] (3 x 3) for every point Q[k]."""
    A, B, C = T[:, 0], T[:, 1], T[:, 2]
    normal = np.cross(B - A, C - A)
    square = np.maximum((normal**2).sum(1), 1e-300)
    P = Q - (((Q - A) * normal).sum(1) / square)[:, None] * normal
    inside = square > 1e-290
    for first, second in ((A, B), (B, C), (C, A)):
        inside &= (np.cross(second - first, P - first) * normal).sum(1) >= 0
    out = np.flatnonzero(~inside)
    best = np.full(len(out), np.inf)
    for first, second in ((A, B), (B, C), (C, A)):
        on_edge = nearest_on_segments(Q[out], first[out], second[out])
        distance = ((on_edge - Q[out]) ** 2).sum(1)
        nearer = distance < best
        best[nearer] = distance[nearer]
        P[out[nearer]] = on_edge[nearer]
    return P


class Surface:
    """A mesh that is asked for nearest points. Exact: a triangle in reach has its middle within the distance
    to the nearest vertex plus its own size, so that a tree of middles per class of size finds all of them."""

    def __init__(self, V, F):
        self.V, self.F = V, F
        self.T = V[F]
        self.middles = self.T.mean(1)
        self.sizes = np.linalg.norm(self.T - self.middles[:, None], axis=2).max(1)
        classes = np.floor(np.log2(np.maximum(self.sizes, self.sizes.max() / 256))).astype(int)
        self.classes = []
        for k in np.unique(classes):
            members = np.flatnonzero(classes == k)
            self.classes.append((cKDTree(self.middles[members]), members, self.sizes[members].max()))
        self.vertices = cKDTree(V[np.unique(F)])

    def nearest(self, Q):
        """Nearest points, distances and triangles."""
        points, distances, triangles = np.empty_like(Q), np.empty(len(Q)), np.empty(len(Q), dtype=int)
        for start in range(0, len(Q), 5000):
            part = slice(start, start + 5000)
            points[part], distances[part], triangles[part] = self._nearest(Q[part])
        return points, distances, triangles

    def _nearest(self, Q):
        best = self.vertices.query(Q)[0] * (1 + 1e-12)
        points, triangles = np.full_like(Q, np.nan), np.full(len(Q), -1)
        for tree, members, size in self.classes:
            lists = tree.query_ball_point(Q, best + size)
            counts = np.array([len(entry) for entry in lists])
            if not counts.any():
                continue
            rows = np.repeat(np.arange(len(Q)), counts)
            hits = members[np.concatenate([entry for entry in lists if entry]).astype(int)]
            P = nearest_on_triangles(Q[rows], self.T[hits])
            d = np.linalg.norm(P - Q[rows], axis=1)
            order = np.lexsort((hits, d, rows))
            first = order[np.unique(rows[order], return_index=True)[1]]
            better = first[d[first] <= best[rows[first]]]
            points[rows[better]], triangles[rows[better]], best[rows[better]] = P[better], hits[better], d[better]
        return points, best, triangles


def pairs_in_reach(surface):
    """Pairs of triangles whose boxes overlap, each once."""
    low, high = surface.T.min(1), surface.T.max(1)
    # The few largest are asked one by one, so that they do not widen the search for all the others.
    usual = np.percentile(surface.sizes, 99)
    small, large = np.flatnonzero(surface.sizes <= usual), np.flatnonzero(surface.sizes > usual)
    pairs = small[cKDTree(surface.middles[small]).query_pairs(2 * usual, output_type="ndarray")]
    if len(large):
        reach = surface.sizes[large] + surface.sizes.max()
        lists = cKDTree(surface.middles).query_ball_point(surface.middles[large], reach)
        rows, hits = np.repeat(large, [len(entry) for entry in lists]), np.concatenate(lists).astype(int)
        keep = (surface.sizes[hits] <= usual) | (rows < hits)
        pairs = np.concatenate([pairs, np.stack([rows[keep], hits[keep]], axis=1)])
    i, j = pairs.T
    return pairs[(low[i] <= high[j]).all(1) & (high[i] >= low[j]).all(1)]


def _edge_crosses(A, B, T):
    """Whether the open segment from A to B goes through the inside of triangle T."""

    def volume(a, b, c, d):
        return np.einsum("nk,nk->n", np.cross(b - a, c - a), d - a)

    scale = 1e-12 * np.linalg.norm(T[:, 1] - T[:, 0], axis=1) ** 3
    start, end = volume(T[:, 0], T[:, 1], T[:, 2], A), volume(T[:, 0], T[:, 1], T[:, 2], B)
    sides = [volume(A, B, T[:, k], T[:, (k + 1) % 3]) for k in range(3)]
    through = np.all([s > scale for s in sides], axis=0) | np.all([s < -scale for s in sides], axis=0)
    return through & (((start > scale) & (end < -scale)) | ((start < -scale) & (end > scale)))


def count_crossings(surface):
    """Pairs of triangles that go through each other."""
    pairs = pairs_in_reach(surface)
    a, b = surface.F[pairs[:, 0]], surface.F[pairs[:, 1]]
    shared = (a[:, :, None] == b[:, None, :]).any(2).sum(1)
    pairs = pairs[shared < 2]  # two triangles at one edge only meet there, or lie on each other: a fold
    crossing = np.zeros(len(pairs), dtype=bool)
    for first, second in ((0, 1), (1, 0)):
        T, U = surface.T[pairs[:, first]], surface.T[pairs[:, second]]
        for k in range(3):
            crossing |= _edge_crosses(T[:, k], T[:, (k + 1) % 3], U)
    return int(crossing.sum())


def topology(V, F):
    """Whether a mesh is manifold and oriented; components, border loops and genus; folds."""
    edges = np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]])
    low, high = edges.min(1), edges.max(1)
    key, inverse, count = np.unique(low * len(V) + high, return_inverse=True, return_counts=True)
    key = np.stack([key // len(V), key % len(V)], axis=1)
    forward = np.bincount(inverse, edges[:, 0] < edges[:, 1], len(key))
    oriented = bool((forward[count == 2] == 1).all())
    used = np.unique(F)
    # Around a manifold vertex the triangles are one fan: corners joined over edges have one component per vertex.
    corner = np.arange(3 * len(F)).reshape(3, -1)  # corner[k, f]: triangle f at its k-th vertex
    face = np.tile(np.arange(len(F)), 3)
    order = np.argsort(inverse, kind="stable")
    starts = np.concatenate([[0], np.cumsum(count)[:-1]])
    two = np.flatnonzero(count == 2)
    f, g = face[order[starts[two]]], face[order[starts[two] + 1]]
    joined = []
    for end in range(2):
        vertex = key[two, end]
        i = corner[(F[f] == vertex[:, None]).argmax(1), f]
        j = corner[(F[g] == vertex[:, None]).argmax(1), g]
        joined.append(np.stack([i, j], axis=1))
    joined = np.concatenate(joined)
    n = 3 * len(F)
    fans = connected_components(coo_matrix((np.ones(len(joined)), joined.T), shape=(n, n)), directed=False)[0]
    distinct = (F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])
    manifold = bool(count.max() <= 2 and fans == len(used) and distinct.all())
    links = coo_matrix((np.ones(len(key)), key.T), shape=(len(V), len(V)))
    labels = connected_components(links, directed=False)[1]
    components = len(np.unique(labels[used]))
    border = key[count == 1]
    on_border = np.unique(border)
    links = coo_matrix((np.ones(len(border)), border.T), shape=(len(V), len(V)))
    loops = len(np.unique(connected_components(links, directed=False)[1][on_border])) if len(border) else 0
    euler = len(used) - len(key) + len(F)
    areas, N = areas_and_normals(V, F)
    real = (areas[f] > 1e-9 * areas.mean()) & (areas[g] > 1e-9 * areas.mean())
    folds = int(((N[f] * N[g]).sum(1)[real] < -0.5).sum()) if oriented else 0
    return {
        "manifold": manifold and oriented,
        "components": components,
        "borders": loops,
        "genus": (2 * components - loops - euler) / 2,
        "folds": folds,
    }


def volume(V, F):
    """Signed volume: negative where the triangles look inwards."""
    return float(np.einsum("nk,nk->", V[F[:, 0]], np.cross(V[F[:, 1]], V[F[:, 2]])) / 6)
