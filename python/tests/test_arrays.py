"""Arrays are taken in every form that holds them, and refused with row and value where they do not fit."""

import gc
import pickle

import numpy as np
import pytest
from conftest import torus

import batten

V, F = torus(12)
N = len(V)
LARGE = F.astype(np.int64)
LARGE[5, 1] = 2**32 + 3  # as an int32 this would be vertex 3
HALF = F.astype(float)
HALF[7, 2] = 0.5
NEGATIVE = F.copy()
NEGATIVE[2, 0] = -1
BEYOND = F.copy()
BEYOND[3, 0] = N
UNSIGNED = F.astype(np.uint64)
UNSIGNED[4, 2] = 2**64 - 1
NAN_INDEX = F.astype(float)
NAN_INDEX[1, 1] = np.nan
NAN = V.copy()
NAN[17, 1] = np.nan
INFINITE = V.copy()
INFINITE[9, 2] = -np.inf


@pytest.mark.parametrize(
    "positions, triangles, sentence",
    [
        (V, LARGE, r"triangles: row 5 holds 4294967299, which is out of range; whole numbers from 0 to 71"),
        (V, HALF, r"triangles: row 7 holds 0\.5, which is no whole number"),
        (V, NEGATIVE, r"triangles: row 2 holds -1, which is out of range"),
        (V, BEYOND, r"triangles: row 3 holds 72, which is out of range"),
        (V, UNSIGNED, r"triangles: row 4 holds 18446744073709551615, which is out of range"),
        (V, NAN_INDEX, r"triangles: row 1 holds nan"),
        (NAN, F, r"positions: row 17 holds nan; numbers must be finite"),
        (INFINITE, F, r"positions: row 9 holds -inf"),
        (V[:, :2], F, r"positions must have three columns, got the shape 72 × 2"),
        (V, F[:, :2], r"triangles must have three columns, got the shape 144 × 2"),
        (V.ravel(), F, r"positions must have three columns, got the shape 216"),
        (3.0, F, r"positions must have three columns, got a single number"),
        (V.astype(str), F, r"positions must hold numbers, got an array of <U"),
        (V + 0j, F, r"positions must hold numbers, got an array of complex128"),
        (V > 0, F, r"positions must hold numbers, got an array of bool"),
        (V, F > 3, r"triangles must hold whole numbers, got an array of bool"),
        (V, F.astype(object), r"triangles must hold whole numbers, got an array of object"),
        ([[0, 0, 0], [1, 0]], F, r"positions must be an array of numbers; numpy says"),
        (None, F, r"positions must hold numbers, got an array of object"),
    ],
)
def test_what_does_not_fit_is_refused_with_row_and_value(positions, triangles, sentence):
    with pytest.raises(batten.InvalidInput, match=sentence):
        batten.fair(positions, triangles)


def as_lists(a):
    return a.tolist()


def strided(a):
    return np.repeat(np.repeat(a, 2, axis=0), 2, axis=1)[::2, ::2]


@pytest.mark.parametrize("form", [as_lists, np.asfortranarray, strided, lambda a: a.astype(a.dtype.newbyteorder())])
def test_every_form_of_the_same_numbers_gives_the_same_bits(form):
    wanted = batten.fair(V, F, method="taubin").positions
    np.testing.assert_array_equal(batten.fair(form(V), form(F), method="taubin").positions, wanted)


@pytest.mark.parametrize("kind", [np.int8, np.uint8, np.int64, np.uint64, np.float32, np.float64])
def test_indices_of_every_type_are_the_same_indices(kind):
    wanted = batten.fair(V, F, method="taubin").positions
    np.testing.assert_array_equal(batten.fair(V, F.astype(kind), method="taubin").positions, wanted)


def test_single_precision_is_taken_as_it_is():
    low = V.astype(np.float32)
    wanted = batten.fair(low.astype(np.float64), F, method="taubin").positions
    np.testing.assert_array_equal(batten.fair(low, F, method="taubin").positions, wanted)


def test_inputs_stay_and_results_outlive_what_made_them():
    before = V.copy(), F.copy()
    positions = batten.fair(V, F, method="mcf").positions
    gc.collect()
    assert positions.flags.writeable and positions.dtype == np.float64 and positions.flags.c_contiguous
    copy = positions.copy()
    batten.fair(V, F, method="tv")
    np.testing.assert_array_equal(positions, copy)
    np.testing.assert_array_equal(V, before[0])
    np.testing.assert_array_equal(F, before[1])


def test_meshes_unpack_and_are_taken_where_they_were_given():
    mesh = batten.fair(V, F)
    X, G = mesh
    np.testing.assert_array_equal(G, F)
    assert G.dtype == np.int32
    np.testing.assert_array_equal(batten.fair(mesh).positions, batten.fair(X, G).positions)
    with pytest.raises(batten.InvalidInput, match="a Mesh has its triangles"):
        batten.fair(mesh, F)
    with pytest.raises(batten.InvalidInput, match="give positions and triangles, or one Mesh, got ndarray alone"):
        batten.fair(V)


def test_values_and_normals_must_fit_the_vertices():
    with pytest.raises(batten.InvalidInput, match=r"values\[quality\] must hold 72 numbers, got 3"):
        batten.fair(batten.Mesh(V, F, values={"quality": [1, 2, 3]}))
    with pytest.raises(batten.InvalidInput, match=r"normals must have 72 rows, got 71"):
        batten.fair(batten.Mesh(V, F, normals=V[1:]))


def test_objects_are_copied_and_pickled():
    mesh = pickle.loads(pickle.dumps(batten.fair(V, F)))
    np.testing.assert_array_equal(mesh.triangles, F)


@pytest.mark.parametrize(
    "name, value, sentence",
    [
        ("iterations", 1.5, "iterations must be a whole number, got 1.5"),
        ("iterations", True, "iterations must be a whole number, got True"),
        ("iterations", 2**40, "iterations must be a whole number from"),
        ("iterations", -1, "iterations must be at least 0, got -1"),
        ("keep_boundary", 1, "keep_boundary must be True or False, got 1"),
        ("noise", float("nan"), "noise must be a finite number, got nan"),
        ("noise", -1, "noise must be auto or a number of mean edge lengths, at least 0: -1"),
        ("noise", None, "noise must be auto"),
        ("method", 3, "'3' is no fairing method"),
        ("method", {}, "method must be text or a number, got {}"),
        ("progress", 3, "progress must be None or a function"),
    ],
)
def test_options_are_refused_by_their_name(name, value, sentence):
    with pytest.raises(batten.InvalidInput, match=sentence):
        batten.fair(V, F, **{name: value})


def test_numbers_stand_for_their_text():
    wanted = batten.remesh(V, F, edge="0.3", keep_edges="40deg").positions
    np.testing.assert_array_equal(batten.remesh(V, F, edge=np.float64(0.3), keep_edges=40).positions, wanted)


CURVES = [np.array([0, 1, 2]), np.array([2, 0])]
POSITIONS = [[0, 0, 0], [1, 0, 0], [1, 1, 0]]


@pytest.mark.parametrize(
    "change, sentence",
    [
        (dict(curves=[[0, 1, 3]], boundary=None), r"curves\[0\]: row 2 holds 3, which is out of range"),
        (dict(curves=[[0, 1], [0.5, 1]]), r"curves\[1\]: row 0 holds 0.5, which is no whole number"),
        (dict(curves=[[0, 1], 7]), r"curves\[1\] must have one dimension, got a single number"),
        (dict(boundary=[True]), r"boundary must have 2 entries, got 1"),
        (dict(boundary=[True, 2]), r"boundary\[1\] must be True or False, got 2"),
        (dict(names=["a", 3]), r"names\[1\] must be text, got 3"),
        (dict(nodes=[-1]), r"nodes: row 0 holds -1"),
        (dict(uncertainty=[1, 2]), r"uncertainty must hold 3 numbers, got 2"),
        (dict(left_normals=[None, [[0, 0, 1]]]), r"left_normals\[1\] must have 2 rows, got 1"),
    ],
)
def test_networks_are_refused_with_curve_row_and_value(change, sentence):
    fields = dict(positions=POSITIONS, curves=CURVES, normals=[[0, 0, 1]] * 3, boundary=[True, True]) | change
    with pytest.raises(batten.InvalidInput, match=sentence):
        batten.surface(batten.Network(**fields))


def test_scans_are_refused_with_curve_row_and_value():
    curve = dict(
        distances=[0, 1], tangents=[[1, 0, 0]] * 2, normals=[[0, 0, 1]] * 2, node_readings=[0, 1], node_ids=[0, 1]
    )
    for change, sentence in [
        (dict(tangents=[[1, 0, 0]]), r"curves\[0\].tangents must have 2 rows"),
        (dict(node_readings=[0, 2]), r"curves\[0\].node_readings: row 1 holds 2"),
        (dict(node_ids=[0]), r"curves\[0\].node_ids must have one entry for each of the 2"),
        (dict(distances=[0, np.nan]), r"curves\[0\].distances: row 1 holds nan"),
        (dict(closed=0), r"curves\[0\].closed must be True or False"),
    ]:
        with pytest.raises(batten.InvalidInput, match=sentence):
            batten.network_from_scan(batten.Scan([batten.ScanCurve(**(curve | change))]))


def test_cages_are_refused_with_face_row_and_value():
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    for faces, sentence in [
        ([[0, 1, 2, 4]], r"faces\[0\]: row 3 holds 4"),
        (np.array([[0, 1, 2, 3], [0, 1, 2, 9]]), r"faces: row 1 holds 9"),
        ([[0, 1.5, 2]], r"faces\[0\]: row 1 holds 1.5"),
        (3, "faces must be a list"),
    ]:
        with pytest.raises(batten.InvalidInput, match=sentence):
            batten.subdivide((square, faces))
    with pytest.raises(batten.InvalidInput, match=r"sharp_edges\[\(0, 7\)\]: row 1 holds 7"):
        batten.subdivide(batten.Cage(square, [[0, 1, 2, 3]], sharp_edges={(0, 7): 1.0}))
    with pytest.raises(batten.InvalidInput, match=r"sharp_edges\[\(0, 1\)\] must be at least 0, got -1"):
        batten.subdivide(batten.Cage(square, [[0, 1, 2, 3]], sharp_edges={(0, 1): -1}))
