"""Surfaces given by formulas: the nearest point of any point, and the outward normal there.

The smooth ones are those of `batten simulate` (docs/simulate.md), written here once more, so that no line of
the program is a judge of its own results. The sharp ones are made here.
"""

import numpy as np


class Implicit:
    """f = 0. Nearest points by turns of a Newton step onto the surface and a step along its tangent plane."""

    def __init__(self, function, inside=None):
        self.function = function
        self.inside = inside  # of an open surface: whether a point of f = 0 is within its border

    def nearest(self, Q):
        """Nearest points and normals; NaN where there is none in reach, or where it is past the border."""
        P = np.array(Q, dtype=float)
        share, before = np.ones(len(P)), np.full(len(P), np.inf)
        with np.errstate(all="ignore"):
            for _ in range(60):
                for _ in range(2):
                    f, gradient = self.function(P)
                    P -= (f / (gradient**2).sum(1))[:, None] * gradient
                N, along = self._frame(P, Q)
                length = np.linalg.norm(along, axis=1)
                if max(np.nanmax(length, initial=0), np.nanmax(np.abs(f), initial=0)) < 1e-12:
                    break
                # Farther away than a radius of curvature a whole step goes too far.
                share[length > before] /= 2
                before = length
                P += share[:, None] * along
            for _ in range(3):
                f, gradient = self.function(P)
                P -= (f / (gradient**2).sum(1))[:, None] * gradient
            N, along = self._frame(P, Q)
            lost = ~np.isfinite(P).all(1) | (np.abs(self.function(P)[0]) > 1e-9)
            lost |= np.linalg.norm(along, axis=1) > 1e-6 * (1 + np.linalg.norm(Q - P, axis=1))
        if self.inside is not None:
            lost |= ~self.inside(P)
        P[lost] = np.nan
        N[lost] = np.nan
        return P, N

    def _frame(self, P, Q):
        """Normals at P, and the parts of Q - P across them."""
        N = self.function(P)[1]
        N /= np.linalg.norm(N, axis=1)[:, None]
        along = Q - P
        return N, along - (along * N).sum(1)[:, None] * N


class Pieces:
    """A surface of pieces, each a function from points to their nearest points and the normals there."""

    def __init__(self, *pieces):
        self.pieces = pieces

    def nearest(self, Q):
        found = [piece(Q) for piece in self.pieces]
        distances = np.stack([np.linalg.norm(P - Q, axis=1) for P, _ in found])
        best = distances.argmin(0)
        rows = np.arange(len(Q))
        return np.stack([P for P, _ in found])[best, rows], np.stack([N for _, N in found])[best, rows]


def _sphere(X):
    return (X**2).sum(1) - 1, 2 * X


def _ellipsoid(X):
    axes = np.array([1.5, 1, 0.7])
    return ((X / axes) ** 2).sum(1) - 1, 2 * X / axes**2


def _torus(X):
    rho = np.hypot(X[:, 0], X[:, 1])
    across = rho - 4
    gradient = np.stack([2 * across * X[:, 0] / rho, 2 * across * X[:, 1] / rho, 2 * X[:, 2]], axis=1)
    return across**2 + X[:, 2] ** 2 - 4, gradient


def _bumpy_cube(X):
    c, s = np.cos(3 * X), np.sin(3 * X)
    bumps = np.stack([s[:, 0] * c[:, 1] * c[:, 2], c[:, 0] * s[:, 1] * c[:, 2], c[:, 0] * c[:, 1] * s[:, 2]], axis=1)
    return (X**4).sum(1) - 1 + 0.12 * c.prod(1), 4 * X**3 - 0.36 * bumps


def _cone(X):
    r = 0.25 * (2 - X[:, 2])
    return X[:, 0] ** 2 + X[:, 1] ** 2 - r**2, np.stack([2 * X[:, 0], 2 * X[:, 1], 0.5 * r], axis=1)


def _height(height):
    """Of z = h(x, y), with h and its two derivatives."""

    def function(X):
        h, dx, dy = height(X[:, 0], X[:, 1])
        return X[:, 2] - h, np.stack([-dx, -dy, np.ones(len(X))], axis=1)

    return function


def _saddle(x, y):
    return 0.35 * (x**2 - y**2), 0.7 * x, -0.7 * y


def _waves(x, y):
    h = 0.12 * np.sin(3 * x) * np.cos(2.5 * y) + 0.2 * x**2
    return h, 0.36 * np.cos(3 * x) * np.cos(2.5 * y) + 0.4 * x, -0.3 * np.sin(3 * x) * np.sin(2.5 * y)


def _dish(x, y):
    h = 0.18 * (x**3 - 3 * x * y**2) + 0.12 * (x**2 + y**2)
    return h, 0.18 * (3 * x**2 - 3 * y**2) + 0.24 * x, -1.08 * x * y + 0.24 * y


def _square(P):
    return (np.abs(P[:, :2]) <= 1 + 1e-9).all(1)


def _disc(P):
    return np.hypot(P[:, 0], P[:, 1]) <= 1 + 1e-9


def _cone_range(P):
    return (P[:, 2] >= 0.1 - 1e-9) & (P[:, 2] <= 1.7 + 1e-9)


def _rectangle(low, high, normal):
    """A rectangle across an axis: low and high are its corners, equal in one coordinate."""

    def nearest(Q):
        return np.clip(Q, low, high), np.broadcast_to(np.array(normal, dtype=float), Q.shape)

    return nearest


def _radial(Q):
    rho = np.hypot(Q[:, 0], Q[:, 1])
    safe = np.where(rho > 0, rho, 1)
    return np.stack([np.where(rho > 0, Q[:, 0] / safe, 1), Q[:, 1] / safe, np.zeros(len(Q))], axis=1), rho


def _tube(radius, height, sign):
    """The side of a cylinder along z; normals away from the axis for sign 1, to it for -1."""

    def nearest(Q):
        out, _ = _radial(Q)
        P = radius * out
        P[:, 2] = np.clip(Q[:, 2], -height, height)
        return P, sign * out

    return nearest


def _cap(radius, z):
    def nearest(Q):
        out, rho = _radial(Q)
        P = np.minimum(rho, radius)[:, None] * out
        P[:, 2] = z
        return P, np.broadcast_to([0.0, 0.0, np.sign(z)], Q.shape)

    return nearest


def _plate(side, radius, z):
    """A square with a round hole."""

    def nearest(Q):
        P = np.clip(Q, [-side, -side, z], [side, side, z])
        out, rho = _radial(P)
        P = np.where((rho < radius)[:, None], radius * out + [0, 0, z], P)
        return P, np.broadcast_to([0.0, 0.0, np.sign(z)], Q.shape)

    return nearest


def _box_sides(size):
    sides = []
    for axis in range(3):
        for sign in (-1, 1):
            low, high, normal = -np.array(size, dtype=float), np.array(size, dtype=float), np.zeros(3)
            low[axis] = high[axis] = sign * size[axis]
            normal[axis] = sign
            sides.append(_rectangle(low, high, normal))
    return sides


def _triangle_piece(corners):
    from meshes import nearest_on_triangles

    corners = np.array(corners, dtype=float)
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal /= np.linalg.norm(normal)

    def nearest(Q):
        triangles = np.broadcast_to(corners, (len(Q), 3, 3))
        return nearest_on_triangles(Q, triangles), np.broadcast_to(normal, Q.shape)

    return nearest


# A wedge: a right-angled triangle across y, 2 long. Its corners, and its faces seen from outside.
WEDGE_CORNERS = np.array([[-1, -1, 0], [1, -1, 0], [-1, -1, 0.8], [-1, 1, 0], [1, 1, 0], [-1, 1, 0.8]], dtype=float)
WEDGE_FACES = [[0, 1, 2], [5, 4, 3], [0, 3, 4, 1], [1, 4, 5, 2], [2, 5, 3, 0]]

CYLINDER_RADIUS, CYLINDER_HEIGHT = 1.0, 1.2  # half the height
HOLE_RADIUS, PLATE_SIZE = 0.5, (1.0, 1.0, 0.4)  # half the sides


def shape(name):
    """The surface of that name."""
    smooth = {
        "sphere3": (_sphere, None),
        "sphere6": (_sphere, None),
        "ellipsoid": (_ellipsoid, None),
        "torus": (_torus, None),
        "bumpycube": (_bumpy_cube, None),
        "saddle": (_height(_saddle), _square),
        "waves": (_height(_waves), _square),
        "dish": (_height(_dish), _disc),
        "cone": (_cone, _cone_range),
    }
    if name in smooth:
        return Implicit(*smooth[name])
    if name == "cube":
        return Pieces(*_box_sides((1, 1, 1)))
    if name == "wedge":
        triangles = [[f[0], f[k], f[k + 1]] for f in WEDGE_FACES for k in range(1, len(f) - 1)]
        return Pieces(*(_triangle_piece(WEDGE_CORNERS[t]) for t in triangles))
    if name == "cylinder":
        r, h = CYLINDER_RADIUS, CYLINDER_HEIGHT
        return Pieces(_tube(r, h, 1), _cap(r, h), _cap(r, -h))
    if name == "hole":
        x, _, z = PLATE_SIZE
        walls = _box_sides(PLATE_SIZE)[:4]
        return Pieces(*walls, _plate(x, HOLE_RADIUS, z), _plate(x, HOLE_RADIUS, -z), _tube(HOLE_RADIUS, z, -1))
    raise ValueError(f"there is no shape '{name}'")
