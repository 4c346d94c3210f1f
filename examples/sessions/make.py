#!/usr/bin/env python3
"""Writes the example sessions of this folder: what a hand would draw, as formulas, with a little tremor.

    python3 make.py        writes *.jsonl beside this file
"""
import json
import math
import os
import random

FOLDER = os.path.dirname(os.path.abspath(__file__))


def line(*corners, n=24):
    """A polyline through corners, n points on each side."""
    points = []
    for a, b in zip(corners, corners[1:]):
        points += [[a[k] + (b[k] - a[k]) * i / n for k in range(3)] for i in range(n)]
    return points + [list(corners[-1])]


def arc(centre, a, b, start=0.0, end=360.0, n=72):
    """centre + cos t a + sin t b, t in degrees; a whole turn leaves its last point out."""
    whole = abs(end - start) == 360
    return [
        [
            centre[k]
            + math.cos(math.radians(start + (end - start) * i / n)) * a[k]
            + math.sin(math.radians(start + (end - start) * i / n)) * b[k]
            for k in range(3)
        ]
        for i in range(n if whole else n + 1)
    ]


def curve(f, n=48):
    return [f(i / n) for i in range(n + 1)]


def tremor(points, size, rng):
    """A hand: noise in every coordinate, ends left alone."""
    if size == 0:
        return points
    return [p if i in (0, len(points) - 1) else [x + rng.gauss(0, size) for x in p] for i, p in enumerate(points)]


class Session:
    def __init__(self, name, unit, size=0.0):
        self.path = os.path.join(FOLDER, name + ".jsonl")
        self.lines = [{"batten_session": 1, "unit": unit}]
        self.size = size
        self.rng = random.Random(name)

    def stroke(self, points):
        return [[round(x, 6) for x in p] for p in tremor(points, self.size, self.rng)]

    def insert(self, points, **fields):
        self.lines.append({"op": "insert", "points": self.stroke(points), **fields})

    def add(self, op, **fields):
        self.lines.append({"op": op, **fields})

    def write(self):
        with open(self.path, "w") as file:
            for entry in self.lines:
                file.write(json.dumps(entry, separators=(",", ":")) + "\n")


def spheres():
    s = Session("sphere", "m")
    x, y, z = [1, 0, 0], [0, 1, 0], [0, 0, 1]
    for a, b in ((x, y), (x, z), (y, z)):
        s.insert(arc([0, 0, 0], a, b, n=120), closed=True)
    s.write()


def prism(s, bottom, height):
    """A prism over a polygon: each stroke adds one side face. Vertices: v0 … below, vn … above in the same order."""
    low = [[x, y, 0] for x, y in bottom]
    high = [[x, y, height] for x, y in bottom]
    n = len(low)
    s.insert(line(*low, low[0]), closed=True)
    s.insert(line(low[0], high[0], high[1], low[1]), into="opening")
    for k in range(1, n - 1):
        s.insert(line(high[k], high[k + 1], low[k + 1]))
    s.insert(line(high[n - 1], high[0]))

    def top(k):  # the curve and the vertices of edge k of the top
        return dict(curve="c%d" % (k + 1), between=["v%d" % (n + k), "v%d" % (n + (k + 1) % n)])

    def upright(k):
        return dict(curve="c%d" % max(k, 1), between=["v%d" % k, "v%d" % (n + k)])

    return top, upright


def cube():
    """H fig. 7.6: the four edges of the top face and two uprights are sharp; the uprights end as darts."""
    s = Session("cube", "m")
    top, upright = prism(s, [(0, 0), (1, 0), (1, 1), (0, 1)], 1)
    for k in range(4):
        s.add("sharpness", value=1, **top(k))
    for k in (0, 1):
        s.add("sharpness", value=1, **upright(k))
    s.write()


def cross():
    """H fig. 3.2: a cross with smooth and sharp edges; two arms are sharp around their ends."""
    s = Session("cross", "cm")
    outline = [(1, -1), (3, -1), (3, 1), (1, 1), (1, 3), (-1, 3), (-1, 1), (-3, 1), (-3, -1), (-1, -1), (-1, -3), (1, -3)]
    top, upright = prism(s, outline, 1.5)
    for k in (0, 1, 2, 6, 7, 8):  # tops of the arms along x
        s.add("sharpness", value=1, **top(k))
    for k in (1, 2, 7, 8):  # uprights at their ends, darts at the bottom
        s.add("sharpness", value=1, **upright(k))
    s.write()


def bottle():
    """H fig. 7.10: a bottle by skinning, closed at both ends, then a handle between two holes."""
    s = Session("bottle", "cm", 0.003)

    def radius(z):
        t = min(max((z - 8) / 4, 0), 1)
        return 3.1 - 1.9 * t * t * (3 - 2 * t)

    heights = [0, 4.5, 8, 10, 12, 15]
    profiles = [{"points": s.stroke(arc([0, 0, z], [radius(z), 0, 0], [0, radius(z), 0])), "closed": True} for z in heights]
    spines = [{"points": s.stroke(curve(lambda t, sign=sign: [sign * radius(15 * t), 0, 15 * t], 90))} for sign in (1, -1)]
    s.add("skin", profiles=profiles, spines=spines, snap=0.15)
    for z in (0, 15):
        s.insert(line([0, radius(z), z], [0, -radius(z), z]), snap=0.15)
    for c in ("c0", "c5"):
        s.add("sharpness", curve=c, value=1)

    def hole(z, size):
        def on_bottle(t):
            x, h = size * math.cos(2 * math.pi * t), z + size * math.sin(2 * math.pi * t)
            return [x, math.sqrt(radius(h) ** 2 - x * x), h]

        return [on_bottle(i / 48) for i in range(48)]

    s.add("hole", points=s.stroke(hole(6.2, 0.6)), snap=0.15)
    s.add("hole", points=s.stroke(hole(2.0, 0.6)), snap=0.15)
    middle, y = 4.1, radius(0)
    outer = arc([0, y, middle], [0, 0, 2.7], [0, 3.0, 0], 0, 180)
    inner = arc([0, y, middle], [0, 0, 1.5], [0, 1.8, 0], 0, 180)
    s.add("glue", first={"points": s.stroke(outer)}, second={"points": s.stroke(inner)}, snap=0.2)
    s.write()


def charger():
    """H fig. 7.9: a body with a cavity in its top."""
    s = Session("charger", "cm", 0.003)

    def outline(t, a, b, z, power=0.5):
        c, d = math.cos(2 * math.pi * t), math.sin(2 * math.pi * t)
        return [math.copysign(abs(c) ** power, c) * a, math.copysign(abs(d) ** power, d) * b, z]

    def ring(a, b, z, power=0.7):
        return [outline(i / 96, a, b, z, power) for i in range(96)]

    def height(u):  # over the distance from the middle, 0 … 1
        if u < 0.5:
            return 1.0 + 1.2 * (1 - math.cos(math.pi * u / 0.5)) / 2
        return 2.2 * math.sqrt(max(1 - ((u - 0.5) / 0.5) ** 4, 0))

    s.insert(ring(6, 4, 0), closed=True)
    across = [(-1 + 2 * i / 160) for i in range(161)]
    s.insert([[6 * u, 0, height(abs(u))] for u in across], snap=0.15)
    s.insert([[0, 4 * u, height(abs(u))] for u in across], snap=0.15)
    s.insert(ring(3, 2, 2.2), closed=True, snap=0.15, sharpness=1)  # the rim of the cavity
    s.insert(ring(1.5, 1, height(0.25)), closed=True, snap=0.15)
    y = 4 * (1 - (4 / 6) ** 4) ** 0.25  # on the outline at x = 4
    s.insert(line([-4, -y, 0], [4, y, 0]), into="opening", snap=0.15)
    s.add("sharpness", curve="c0", value=1)
    s.write()


def telephone():
    """H fig. 7.8, in spirit: a body with a sharp foot, a slanted face with a dial and a raised cradle."""
    s = Session("telephone", "cm", 0.003)
    foot = [[-8, -10, 0], [8, -10, 0], [8, 10, 0], [-8, 10, 0]]
    s.insert(line(*foot, foot[0]), closed=True, snap=0.2)

    def ridge(t):  # from the front (t = 0) to the back over the top
        return [0, -10 + 20 * t, 11 * math.sin(math.pi * t) ** 0.8 * (0.55 + 0.45 * t)]

    s.insert(curve(ridge, 96), snap=0.2)

    def rib(y, width, top):
        return lambda t: [-width * math.cos(math.pi * t), y, top * math.sin(math.pi * t) ** 0.7]

    for y in (-4.0, 3.5):
        s.insert(curve(rib(y, 8, ridge((y + 10) / 20)[2]), 96), snap=0.2)
    s.insert(line([-8, -0.5, 0], [8, -0.5, 0]), into="opening", snap=0.2)
    s.add("sharpness", curve="c0", value=1)
    s.write()


if __name__ == "__main__":
    for make in (spheres, cube, cross, bottle, charger, telephone):
        make()
