"""Curve networks: files, the loops between curves, networks of bodies with sharp edges."""

import json

import numpy as np
import shapes


def read_network(path):
    data = json.loads(open(path, encoding="utf8").read())
    network = {"positions": np.array(data["positions"]), "curves": data["curves"]}
    if data.get("normals"):
        network["normals"] = np.array(data["normals"])
    for curve in network["curves"]:
        curve["vertices"] = np.array(curve["vertices"])
    return network


def write_network(path, network):
    curves = []
    for curve in network["curves"]:
        lists = {key: value.tolist() for key, value in curve.items() if isinstance(value, np.ndarray)}
        curves.append({**curve, **lists})
    data = {"format": "batten-network", "version": 1, "positions": network["positions"].tolist()}
    if "normals" in network:
        data["normals"] = network["normals"].tolist()
    data["curves"] = curves
    with open(path, "w", encoding="utf8") as file:
        json.dump(data, file)


def diameter(positions):
    """The diagonal of the box around points."""
    return float(np.linalg.norm(np.ptp(positions, axis=0)))


def loops(network):
    """The loops of vertices around patches, found by walking: at every vertex the walk leaves by the curve
    next to the one it came by, in the order of the directions around the normal there."""
    X, N = network["positions"], network["normals"]
    neighbours = {}
    boundary = set()
    for curve in network["curves"]:
        vertices = curve["vertices"]
        for a, b in zip(vertices[:-1].tolist(), vertices[1:].tolist()):
            neighbours.setdefault(a, []).append(b)
            neighbours.setdefault(b, []).append(a)
            if curve.get("boundary"):
                boundary |= {(a, b), (b, a)}
    follow = {}
    for v, around in neighbours.items():
        normal = N[v]
        u = np.cross(normal, [1, 0, 0] if abs(normal[0]) < 0.7 else [0, 1, 0])
        w = np.cross(normal, u)
        around.sort(key=lambda k: np.arctan2((X[k] - X[v]) @ w, (X[k] - X[v]) @ u))
        for k, a in enumerate(around):
            follow[a, v] = v, around[k - 1]  # clockwise: the patch is to the left
    found, seen = [], set()
    for start in sorted(follow):
        if start in seen:
            continue
        loop, edge = [], start
        while edge not in seen:
            seen.add(edge)
            loop.append(edge)
            edge = follow[edge]
        found.append(loop)
    inner = any(edge not in boundary for edge in follow)
    # Outside of an open surface lies a loop that sees nothing but its border.
    return [[a for a, _ in loop] for loop in found if not (inner and all(edge in boundary for edge in loop))]


def write_patches(path, network):
    """An OFF file with a polygon per patch."""
    found = loops(network)
    with open(path, "w", encoding="utf8") as file:
        print(f"OFF\n{len(network['positions'])} {len(found)} 0", file=file)
        for p in network["positions"].tolist():
            print(*p, file=file)
        for loop in found:
            print(len(loop), *loop, file=file)


def _segment(a, b, step):
    a, b = np.array(a, dtype=float), np.array(b, dtype=float)
    t = np.linspace(0, 1, max(2, int(round(np.linalg.norm(b - a) / step)) + 1))[:, None]
    return a + t * (b - a)


def _arc(radius, z, start, end, step):
    t = np.linspace(start, end, max(2, int(round(radius * (end - start) / step)) + 1))
    return np.stack([radius * np.cos(t), radius * np.sin(t), np.full(len(t), z)], axis=1)


def _lines(name):
    """The curves of a body: points, and whether they are sharp."""
    if name == "cube":
        corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        pairs = [(a, b) for a in corners for b in corners if a < b and sum(p != q for p, q in zip(a, b)) == 1]
        return [(lambda step, a=a, b=b: _segment(a, b, step), True) for a, b in pairs]
    if name == "wedge":
        pairs = {tuple(sorted((f[k - 1], f[k]))) for f in shapes.WEDGE_FACES for k in range(len(f))}
        C = shapes.WEDGE_CORNERS
        return [(lambda step, a=a, b=b: _segment(C[a], C[b], step), True) for a, b in sorted(pairs)]
    quarter = np.pi / 2
    if name == "cylinder":
        r, h = shapes.CYLINDER_RADIUS, shapes.CYLINDER_HEIGHT
        lines = []
        for k in range(4):
            for z in (-h, h):
                lines.append((lambda step, k=k, z=z: _arc(r, z, k * quarter, (k + 1) * quarter, step), True))
            x, y = round(r * np.cos(k * quarter), 12), round(r * np.sin(k * quarter), 12)
            lines.append((lambda step, x=x, y=y: _segment((x, y, -h), (x, y, h), step), False))
        return lines
    if name == "hole":
        (a, _, h), r = shapes.PLATE_SIZE, shapes.HOLE_RADIUS
        lines = []
        for k in range(4):
            start, end = quarter * (k + 0.5), quarter * (k + 1.5)
            rim = (r * np.cos(start), r * np.sin(start))
            corner, following = (np.round(np.sqrt(2) * a * np.array([np.cos(t), np.sin(t)]), 12) for t in (start, end))
            lines.append((lambda step, c=corner: _segment((*c, -h), (*c, h), step), True))
            lines.append((lambda step, p=rim: _segment((*p, -h), (*p, h), step), False))
            for z in (-h, h):
                lines.append((lambda step, c=corner, f=following, z=z: _segment((*c, z), (*f, z), step), True))
                lines.append((lambda step, s=start, e=end, z=z: _arc(r, z, s, e, step), True))
                lines.append((lambda step, c=corner, p=rim, z=z: _segment((*p, z), (*c, z), step), False))
        return lines
    raise ValueError(f"there is no body '{name}'")


def sharp_network(name, step):
    """The network of a body with sharp edges, and points of its surface with normals.

    Sharp curves carry the normals of both sides. The normal of a vertex is the mean of those of the faces around.
    """
    body = shapes.shape(name)
    lines = _lines(name)
    size = diameter(np.concatenate([make(1.0) for make, _ in lines]))
    positions, number, curves = [], {}, []
    for make, sharp in lines:
        points = make(step * size)
        vertices = []
        for p in points:
            key = tuple(np.round(p / size, 9) + 0.0)
            if key not in number:
                number[key] = len(positions)
                positions.append(p)
            vertices.append(number[key])
        curves.append({"sharp": sharp, "vertices": np.array(vertices)})
    X = np.array(positions)

    def side(P):
        return body.nearest(P)[1]

    reach = 1e-4 * size
    normals = np.zeros_like(X)
    for curve in curves:
        points = X[curve["vertices"]]
        along = np.gradient(points, axis=0)
        along /= np.linalg.norm(along, axis=1)[:, None]
        # The faces around a curve, met on a small circle around its points.
        across = np.cross(along, [0.36, 0.48, 0.8])
        across /= np.linalg.norm(across, axis=1)[:, None]
        up = np.cross(along, across)
        inward = points.copy()
        inward[0] += reach * (points[1] - points[0]) / np.linalg.norm(points[1] - points[0])
        inward[-1] += reach * (points[-2] - points[-1]) / np.linalg.norm(points[-2] - points[-1])
        around = []
        for t in np.arange(0, 2 * np.pi, np.pi / 36) + 0.01:
            Q = inward + 0.1 * reach * (np.cos(t) * across + np.sin(t) * up)
            P, n = body.nearest(Q)
            around.append((P - inward, n))
        directions = np.stack([d for d, _ in around])
        faces = np.stack([n for _, n in around])
        mean = faces.mean(0)
        for k in range(len(points)):
            unique = []
            for n in faces[:, k]:
                if all(n @ m < 0.999 for m in unique):
                    unique.append(n)
            mean[k] = np.sum(unique, axis=0)
        mean /= np.linalg.norm(mean, axis=1)[:, None]
        np.add.at(normals, curve["vertices"], mean)
        if curve["sharp"]:
            left = np.cross(mean, along)  # seen from outside along the curve
            position = np.einsum("nkd,kd->nk", directions, left)
            rows = np.arange(len(points))
            curve["left_normals"] = faces[position.argmax(0), rows]
            curve["right_normals"] = faces[position.argmin(0), rows]
        else:
            curve.pop("sharp")
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    # Points of the surface: those nearest to a cloud in the body.
    random = np.random.default_rng(1)
    low, high = X.min(0) - 0.02 * size, X.max(0) + 0.02 * size
    cloud = random.uniform(low, high, (400000, 3))
    P, N = body.nearest(cloud)
    # From inside alone: from outside many would land on the edges, where a normal is either side's.
    depth = ((P - cloud) * N).sum(1)
    near = (depth > 0) & (depth < 0.02 * size)
    return {"positions": X, "normals": normals, "curves": curves}, P[near][:10000], N[near][:10000]
