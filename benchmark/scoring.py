"""The scores of one mesh on one case. Lengths in per cent of the diameter of the case, angles in degrees."""

import json
import pathlib

import meshes
import numpy as np
from networks import read_network
from scipy.spatial import cKDTree
from shapes import shape

SAMPLES = 10000
# Crossings of a mesh of this many triangles are not counted: it would take minutes.
MOST_TRIANGLES = 400000

COLUMNS = (
    "vertices_mean vertices_max to_truth_mean to_truth_rms to_truth_p99 to_truth_max to_result_mean to_result_rms "
    "to_result_p99 to_result_max curves_max normals_mean normals_p95 normal_jump_p95 normal_jump_max "
    "curvature_jump_p95 curvature_jump_max sound manifold outward borders genus components crossings folds triangles"
).split()


class Truth:
    """What is true of a case: nearest points of any points, and points of the surface itself."""

    def __init__(self, folder):
        folder = pathlib.Path(folder)
        self.case = json.loads((folder / "case.json").read_text())
        self.network = read_network(folder / "network.json")
        self.formula = self.mesh = self.V = None
        if (folder / "truth.ply").exists():
            self.V, F, self.N = meshes.read_ply(folder / "truth.ply")
            if "shape" in self.case:
                self.formula = shape(self.case["shape"])
            if len(F):
                self.mesh = meshes.Surface(self.V, F)
                self.V, on = meshes.samples(self.V, F, SAMPLES)
                self.N = meshes.areas_and_normals(self.mesh.V, F)[1][on]
            elif len(self.V) > SAMPLES:
                some = np.random.default_rng(1).choice(len(self.V), SAMPLES, replace=False)
                self.V, self.N = self.V[some], self.N[some]
            if self.case.get("fault") == "two parts":
                self.formula = Both(self.formula, np.array([3.0, 0, 0]))
                self.V, self.N = np.concatenate([self.V, self.V + [3.0, 0, 0]]), np.concatenate([self.N, self.N])

    def nearest(self, Q):
        if self.mesh is not None:
            P, _, on = self.mesh.nearest(Q)
            return P, meshes.areas_and_normals(self.mesh.V, self.mesh.F)[1][on]
        P, N = self.formula.nearest(Q)
        # Past a border, or farther away than a centre of curvature, where steps do not settle: the nearest of
        # the points of the surface. That far away their spacing, 0.8 % of the diameter, hardly counts.
        lost = np.isnan(P).any(1)
        if lost.any():
            k = cKDTree(self.V).query(Q[lost])[1]
            P[lost], N[lost] = self.V[k], self.N[k]
        return P, N


class Both:
    """A surface and a copy of it beside it."""

    def __init__(self, one, shift):
        self.one, self.shift = one, shift

    def nearest(self, Q):
        P, N = self.one.nearest(Q)
        R, M = self.one.nearest(Q - self.shift)
        R = R + self.shift
        first, second = (np.nan_to_num(np.linalg.norm(S - Q, axis=1), nan=np.inf) for S in (P, R))
        nearer = (second < first)[:, None]
        return np.where(nearer, R, P), np.where(nearer, M, N)


def spread(name, distances, diameter):
    d = 100 * distances / diameter
    return {
        f"{name}_mean": d.mean(),
        f"{name}_rms": np.sqrt((d**2).mean()),
        f"{name}_p99": np.percentile(d, 99),
        f"{name}_max": d.max(),
    }


def quadric(points):
    """Normal and mean curvature at the origin of z = a + bx + cy + dx² + exy + fy², fitted to points."""
    x, y, z = points.T
    a = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
    _, b, c, d, e, f = np.linalg.lstsq(a, z, rcond=None)[0]
    square = 1 + b * b + c * c
    return np.array([-b, -c, 1]) / np.sqrt(square), ((1 + c * c) * d - b * c * e + (1 + b * b) * f) / square**1.5


def continuity(network, V, F, surface, step, diameter, most=400):
    """Jumps across the smooth inner curves: angle between the normals, and difference of the mean curvatures
    times the diameter, of two quadrics, each fitted to the vertices on one side of the curve in a small ball."""
    radius = 2.5 * step
    degree = np.bincount(
        np.concatenate([np.concatenate([c["vertices"][:-1], c["vertices"][1:]]) for c in network["curves"]]),
        minlength=len(network["positions"]),
    )
    centres, tangents = [], []
    for curve in network["curves"]:
        vertices, closed = curve["vertices"], curve["vertices"][0] == curve["vertices"][-1]
        if curve.get("sharp") or curve.get("boundary") or len(vertices) < 3:
            continue
        X = network["positions"][vertices]
        middle = [k for k in range(1, len(vertices) - 1) if degree[vertices[k]] == 2]
        if closed and degree[vertices[0]] == 2:
            X = np.concatenate([X, X[1:2]])
            middle.append(len(X) - 2)
        centres += [X[k] for k in middle]
        tangents += [X[k + 1] - X[k - 1] for k in middle]
    if not centres:
        return {}
    keep = np.linspace(0, len(centres) - 1, min(most, len(centres))).astype(int)
    centres, tangents = np.array(centres)[keep], np.array(tangents)[keep]
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    N = meshes.vertex_normals(V, F)
    foot, _, on = surface.nearest(centres)
    used = np.unique(F)
    tree = cKDTree(V[used])
    nodes = cKDTree(network["positions"][degree > 2]) if (degree > 2).any() else None
    angles, curvatures = [], []
    for p, t, face in zip(foot, tangents, on):
        # Near a node another curve runs through the ball.
        if nodes is not None and nodes.query(p)[0] < 0.6 * radius:
            continue
        n = N[F[face]].sum(0)
        n -= (n @ t) * t
        length = np.linalg.norm(n)
        if length < 1e-9:
            continue
        n /= length
        side = np.cross(t, n)
        near = used[tree.query_ball_point(p, radius)]
        near = near[N[near] @ n > 0.3]  # not those of another sheet
        local = (V[near] - p) @ np.stack([t, side, n], axis=1)
        # What lies on the curve belongs to both sides.
        sides = [local[sign * local[:, 1] > -0.15 * step] for sign in (1, -1)]
        if min(map(len, sides)) < 10:
            continue
        (n1, h1), (n2, h2) = (quadric(points) for points in sides)
        angles.append(np.degrees(np.arctan2(np.linalg.norm(np.cross(n1, n2)), n1 @ n2)))
        curvatures.append(abs(h1 - h2) * diameter)
    if len(angles) < 5:
        return {}
    return {
        "normal_jump_p95": np.percentile(angles, 95),
        "normal_jump_max": max(angles),
        "curvature_jump_p95": np.percentile(curvatures, 95),
        "curvature_jump_max": max(curvatures),
    }


def score(truth, V, F):
    """All columns that the case has, as a dictionary."""
    case, diameter = truth.case, truth.case["diameter"]
    surface = meshes.Surface(V, F)
    row = meshes.topology(V, F)
    row["triangles"] = len(F)
    row["crossings"] = meshes.count_crossings(surface) if len(F) <= MOST_TRIANGLES else None
    row["curves_max"] = 100 * surface.nearest(truth.network["positions"])[1].max() / diameter
    row["outward"] = meshes.volume(V, F) > 0 if row["borders"] == 0 else None
    if truth.V is not None:
        used = np.unique(F)
        P, _ = truth.nearest(V[used])
        d = 100 * np.linalg.norm(P - V[used], axis=1) / diameter
        row["vertices_mean"], row["vertices_max"] = d.mean(), d.max()
        Q, on = meshes.samples(V, F, SAMPLES)
        P, N = truth.nearest(Q)
        row.update(spread("to_truth", np.linalg.norm(P - Q, axis=1), diameter))
        row.update(spread("to_result", surface.nearest(truth.V)[1], diameter))
        cosine = (meshes.areas_and_normals(V, F)[1][on] * N).sum(1)
        if row["outward"] is None:
            row["outward"] = bool(cosine.mean() > 0)
        # Inside out is one fault, told by its own column, and not 180 degrees everywhere.
        angles = np.degrees(np.arccos(np.clip(cosine if cosine.mean() > 0 else -cosine, -1, 1)))
        row["normals_mean"], row["normals_p95"] = angles.mean(), np.percentile(angles, 95)
    row.update(continuity(truth.network, V, F, surface, case["spacing"], diameter))
    row["sound"] = bool(
        row["manifold"]
        and row["outward"] is not False
        and all(row[key] == case[key] for key in ("borders", "genus", "components"))
        and row["crossings"] == 0
        and row["folds"] == 0
    )
    return row
