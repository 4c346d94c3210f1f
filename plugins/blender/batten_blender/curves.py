"""Curves as the program reads them: a network of positions and polylines, and how edges become polylines."""

import json

import numpy as np

INNER, BORDER, SHARP = "INNER", "BORDER", "SHARP"


def chains(edges, kinds):
    """The polylines that edges (m x 2) form, as pairs of vertices and kind.

    They end at vertices where more or fewer than two edges of one kind meet. A closed one repeats its first vertex.
    """
    around = {}
    for number, (a, b) in enumerate(edges):
        around.setdefault(int(a), []).append(number)
        around.setdefault(int(b), []).append(number)

    def is_end(vertex):
        numbers = around[vertex]
        return len(numbers) != 2 or kinds[numbers[0]] != kinds[numbers[1]]

    used = [False] * len(edges)
    found = []

    def follow(vertex, number):
        chain = [vertex]
        while not used[number]:
            used[number] = True
            a, b = map(int, edges[number])
            vertex = b if vertex == a else a
            chain.append(vertex)
            if is_end(vertex):
                break
            one, other = around[vertex]
            number = other if used[one] else one
        found.append((chain, kinds[number]))

    for vertex, numbers in around.items():
        if is_end(vertex):
            for number in numbers:
                if not used[number]:
                    follow(vertex, number)
    for number, (a, _) in enumerate(edges):
        if not used[number]:
            follow(int(a), number)  # closed, without an end
    return found


class Network:
    """Positions (n x 3), normals (n x 3 or None) and curves: (name, vertices, kind)."""

    def __init__(self, positions, normals, curves, unit=""):
        self.positions, self.normals, self.curves, self.unit = positions, normals, curves, unit


def joined(networks):
    """All as one. Normals are kept where every one of them has some."""
    positions, normals, curves, first = [], [], [], 0
    for network in networks:
        positions.append(network.positions)
        normals.append(network.normals)
        curves += [(name, [first + v for v in vertices], kind) for name, vertices, kind in network.curves]
        first += len(network.positions)
    with_normals = all(part is not None for part in normals)
    return Network(np.concatenate(positions), np.concatenate(normals) if with_normals else None, curves)


def write(path, network):
    content = {
        "format": "batten-network",
        "version": 1,
        "positions": network.positions.tolist(),
        "curves": [
            {"name": name, "boundary": kind == BORDER, "sharp": kind == SHARP, "vertices": vertices}
            for name, vertices, kind in network.curves
        ],
    }
    if network.normals is not None:
        content["normals"] = network.normals.tolist()
    with open(path, "w", encoding="utf-8") as file:
        json.dump(content, file)


def read(path):
    """The network of a .json that the program wrote."""
    with open(path, encoding="utf-8") as file:
        content = json.load(file)
    curves = []
    for curve in content["curves"]:
        kind = SHARP if curve.get("sharp") else BORDER if curve.get("boundary") else INNER
        curves.append((curve.get("name", ""), curve["vertices"], kind))
    normals = content.get("normals")
    return Network(
        np.array(content["positions"], float).reshape(-1, 3), np.array(normals, float) if normals else None, curves,
        content.get("unit", ""),
    )
