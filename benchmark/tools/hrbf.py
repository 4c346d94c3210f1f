"""Hermite radial basis functions: f = 0 through points with the gradient of f equal to their normals, with the
kernel r³ and a linear polynomial ([macedo2011]; the energy of [huang2019] without its search for normals).

usage: hrbf.py POINTS.ply OUTPUT.ply
"""

import itertools
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from meshes import read_ply, write_ply  # noqa: E402

MOST_POINTS = 700  # the system is dense, (4 n)²
CELLS = 60  # along the diagonal: triangles of about the size that a step of 2 % gives the others


def kernel(difference):
    """r³, its gradient 3 r d, and its second derivatives 3 (r I + d dᵀ / r)."""
    r = np.linalg.norm(difference, axis=-1)
    safe = np.where(r > 0, r, 1)
    outer = difference[..., :, None] * difference[..., None, :] / safe[..., None, None]
    return r**3, 3 * r[..., None] * difference, 3 * (r[..., None, None] * np.eye(3) + outer)


class Field:
    """f(x) = Σ a_i φ(x − x_i) − Σ b_i · ∇φ(x − x_i) + c · (x, 1)."""

    def __init__(self, X, N):
        self.X, n = X, len(X)
        value, gradient, second = kernel(X[:, None] - X[None])
        A = np.zeros((4 * n + 4, 4 * n + 4))
        A[:n, :n] = value
        A[:n, n : 4 * n] = -gradient.reshape(n, 3 * n)
        A[n : 4 * n, :n] = gradient.transpose(0, 2, 1).reshape(3 * n, n)
        A[n : 4 * n, n : 4 * n] = -second.transpose(0, 2, 1, 3).reshape(3 * n, 3 * n)
        P = np.zeros((4 * n, 4))
        P[:n, :3], P[:n, 3] = X, 1
        P[n:, :3] = np.tile(np.eye(3), (n, 1))
        A[: 4 * n, 4 * n :], A[4 * n :, : 4 * n] = P, P.T
        solution = np.linalg.solve(A, np.concatenate([np.zeros(n), N.ravel(), np.zeros(4)]))
        self.a, self.b, self.c = solution[:n], solution[n : 4 * n].reshape(n, 3), solution[4 * n :]

    def __call__(self, Q):
        """Values and gradients at points. Products of matrices instead of differences: many times faster."""
        values, gradients = np.empty(len(Q)), np.empty_like(Q)
        X, a, b = self.X, self.a, self.b
        xb = (X * b).sum(1)
        for start in range(0, len(Q), 4000):
            part = slice(start, start + 4000)
            q = Q[part]
            r = np.sqrt(np.maximum((q**2).sum(1)[:, None] + (X**2).sum(1) - 2 * q @ X.T, 0))
            db = q @ b.T - xb  # d · b, d = q − x
            weight = 3 * r * a - 3 * db / np.maximum(r, 1e-12)  # of d in the gradient
            values[part] = (r**3) @ a - 3 * (r * db).sum(1) + q @ self.c[:3] + self.c[3]
            gradients[part] = weight.sum(1)[:, None] * q - weight @ X - 3 * r @ b + self.c[:3]
        return values, gradients


# The six tetrahedra of a cell, each along one way over its edges from corner (0, 0, 0) to (1, 1, 1).
WAYS = [[np.eye(3, dtype=int)[list(p[:k])].sum(0) for k in range(4)] for p in itertools.permutations(range(3))]


def level_set(field, low, high, h):
    """Vertices and triangles of f = 0, by marching tetrahedra. Cells far from it are not looked at."""
    coarse = 4
    shape = np.ceil((high - low) / (coarse * h)).astype(int)
    blocks = np.argwhere(np.ones(shape, dtype=bool))
    f, gradient = field(low + coarse * h * (blocks + 0.5))
    # |f| is about the distance times the slope: kept is what may be reached from the middle of a block.
    reach = np.sqrt(3) / 2 * coarse * h
    blocks = blocks[np.abs(f) < 1.5 * reach * np.maximum(np.linalg.norm(gradient, axis=1), 1)]
    cells = coarse * blocks[:, None] + np.argwhere(np.ones((coarse,) * 3, dtype=bool))
    corners = np.stack([cells.reshape(-1, 3) + step for way in WAYS for step in way], axis=1)
    size = coarse * shape + 1
    numbers = np.ravel_multi_index(corners.transpose(2, 0, 1), size)
    points, tetrahedra = np.unique(numbers, return_inverse=True)
    X = low + h * np.stack(np.unravel_index(points, size), axis=1)
    f, _ = field(X)
    tetrahedra = tetrahedra.reshape(-1, 4)
    above = f[tetrahedra] > 0
    triangles = []  # corners of the result are pairs of points, one below and one above
    for k in range(4):
        rest = [j for j in range(4) if j != k]
        for sign in (True, False):  # one corner alone: a triangle
            t = tetrahedra[(above[:, k] == sign) & (above[:, rest] != sign).all(1)]
            triangles.append(np.stack([t[:, [k, j]] for j in rest], axis=1))
    for pair in ((0, 1), (0, 2), (0, 3)):  # two and two: a square
        (a, b), (c, d) = pair, [j for j in range(4) if j not in pair]
        t = tetrahedra[(above[:, a] == above[:, b]) & (above[:, c] == above[:, d]) & (above[:, a] != above[:, c])]
        for square in (((a, c), (b, c), (b, d)), ((a, c), (b, d), (a, d))):
            triangles.append(np.stack([t[:, list(edge)] for edge in square], axis=1))
    edges = np.sort(np.concatenate(triangles), axis=2).reshape(-1, 2)
    edges, F = np.unique(edges, axis=0, return_inverse=True)
    F = F.reshape(-1, 3)
    low_end, high_end = f[edges[:, 0]], f[edges[:, 1]]
    V = X[edges[:, 0]] + (low_end / (low_end - high_end))[:, None] * (X[edges[:, 1]] - X[edges[:, 0]])
    _, gradient = field(V)
    across = np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]])
    inward = (across * gradient[F].sum(1)).sum(1) < 0
    F[inward] = F[inward][:, ::-1]
    for _ in range(3):  # from the chords of cells onto f = 0
        f, gradient = field(V)
        move = -(f / (gradient**2).sum(1))[:, None] * gradient
        length = np.linalg.norm(move, axis=1)
        V += move * np.minimum(1, 0.2 * h / np.maximum(length, 1e-300))[:, None]
    return V, F


def main():
    points, output = sys.argv[1:]
    X, _, N = read_ply(points)
    keep = np.linspace(0, len(X) - 1, min(MOST_POINTS, len(X))).astype(int)
    centre, size = X.mean(0), np.linalg.norm(np.ptp(X, axis=0))
    X = (X - centre) / size
    field = Field(X[keep], N[keep])
    V, F = level_set(field, X.min(0) - 0.06, X.max(0) + 0.06, 1 / CELLS)
    write_ply(output, centre + size * V, F)


if __name__ == "__main__":
    main()
