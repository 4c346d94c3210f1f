"""The scorer of the benchmark on meshes whose scores are known, and the scores of batten on three quick cases."""

import csv
import json
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

BENCHMARK = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(BENCHMARK))

import meshes  # noqa: E402
import networks  # noqa: E402
import scoring  # noqa: E402
import shapes  # noqa: E402

PROGRAM = pathlib.Path(os.environ.get("BATTEN_PROGRAM", BENCHMARK.parent / "build" / "release" / "bin" / "batten"))


def grid(low, high, n, height=lambda x, y: 0 * x):
    """A height field over a rectangle, normals up."""
    x, y = np.meshgrid(np.linspace(low[0], high[0], n), np.linspace(low[1], high[1], n), indexing="ij")
    V = np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3).astype(float)
    i, j = np.meshgrid(np.arange(n - 1), np.arange(n - 1), indexing="ij")
    a, b, c, d = (k.ravel() for k in (i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1))
    return V, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def ball(radius, n=24):
    """A cube of squares, its vertices moved onto a sphere."""
    parts = []
    for axis in range(3):
        for sign in (1, -1):
            V, F = grid((-1, -1), (1, 1), n)
            V[:, 2] = 1
            parts.append((np.roll(V * [1, sign, sign], axis, axis=1), F))
    V = np.concatenate([V for V, _ in parts])
    F = np.concatenate([F + k * n * n for k, (_, F) in enumerate(parts)])
    _, first, number = np.unique(np.round(V, 9), axis=0, return_index=True, return_inverse=True)
    V = V[first]
    return radius * V / np.linalg.norm(V, axis=1)[:, None], number.ravel()[F]


def cube():
    V = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    squares = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return V, np.array([[q[0], q[k], q[k + 1]] for q in squares for k in (1, 2)])


def truth_of(folder, V, F, curve, told, shape=None):
    """A case in a folder, as make-cases writes it."""
    curve = np.asarray(curve, dtype=float)
    network = {"positions": curve, "curves": [{"vertices": np.arange(len(curve))}]}
    networks.write_network(folder / "network.json", network)
    meshes.write_ply(folder / "truth.ply", V, F, meshes.vertex_normals(V, F))
    case = {"borders": 0, "genus": 0, "components": 1, "spacing": 0.05, **told}
    (folder / "case.json").write_text(json.dumps({**case, **({"shape": shape} if shape else {})}))
    return scoring.Truth(folder)


def test_concentric_spheres_are_their_difference_apart(tmp_path):
    V, F = ball(1)
    truth = truth_of(tmp_path, V, np.zeros((0, 3), dtype=int), V[:3], {"diameter": 2.0}, "sphere3")
    row = scoring.score(truth, *ball(1.1))
    assert row["vertices_mean"] == pytest.approx(5)  # 0.1 of 2
    assert row["vertices_max"] == pytest.approx(5)
    assert row["curves_max"] == pytest.approx(5, rel=0.05)
    assert 4.8 < row["to_truth_mean"] < 5  # facets lie inside of their sphere
    assert 4.8 < row["to_result_mean"] < 5
    assert row["sound"] and row["genus"] == 0 and row["borders"] == 0
    assert row["normals_mean"] < 3


def test_shifted_planes_are_the_shift_apart_in_every_figure(tmp_path):
    V, F = grid((0, 0), (1, 1), 9)
    truth = truth_of(tmp_path, V, F, [[0, 0, 0], [0.5, 0, 0], [1, 0, 0]], {"diameter": 1.0, "borders": 1})
    W, G = grid((0, 0), (1, 1), 14, lambda x, y: 0 * x + 0.25)
    row = scoring.score(truth, W, G)
    for name in ("vertices_mean", "vertices_max", "curves_max"):
        assert row[name] == pytest.approx(25)
    for name in ("to_truth", "to_result"):
        for figure in ("mean", "rms", "p99", "max"):
            assert row[f"{name}_{figure}"] == pytest.approx(25)
    assert row["normals_p95"] == pytest.approx(0, abs=1e-5)
    assert row["sound"] and row["outward"]


def test_a_cube_inside_out_is_one_fault_of_its_own(tmp_path):
    V, F = cube()
    truth = truth_of(tmp_path, V, F, V[:2], {"diameter": 1.0})
    right, wrong = scoring.score(truth, V, F), scoring.score(truth, V, F[:, ::-1])
    assert right["sound"] and right["outward"]
    assert not wrong["sound"] and not wrong["outward"] and wrong["manifold"]
    assert wrong["to_truth_max"] == pytest.approx(0, abs=1e-9)
    assert wrong["normals_mean"] == pytest.approx(right["normals_mean"], abs=0.5)


def test_an_open_mesh_is_not_sound_where_a_closed_one_was_told(tmp_path):
    V, F = ball(1)
    truth = truth_of(tmp_path, V, F, V[:2], {"diameter": 2.0})
    row = scoring.score(truth, V, F[1:])
    assert row["manifold"] and row["borders"] == 1 and row["genus"] == 0 and not row["sound"]


def test_a_surface_past_its_border_is_far_in_one_direction_only(tmp_path):
    V, F = grid((0, 0), (1, 1), 9)
    truth = truth_of(tmp_path, V, F, V[:2], {"diameter": 1.0, "borders": 1})
    row = scoring.score(truth, *grid((-0.5, 0), (1, 1), 31))
    # A third of the area is up to 0.5 past the border: 0.25 there on average.
    assert row["to_truth_mean"] == pytest.approx(100 / 12, rel=0.05)
    assert row["to_truth_max"] == pytest.approx(50, rel=0.01)
    assert row["to_result_max"] == pytest.approx(0, abs=1e-9)
    # The same of a surface given by a formula.
    V, F = grid((-1, -1), (1, 1), 41, lambda x, y: 0.35 * (x**2 - y**2))
    (tmp_path / "saddle").mkdir()
    none = np.zeros((0, 3), dtype=int)
    truth = truth_of(tmp_path / "saddle", V, none, V[:2], {"diameter": 1.0, "borders": 1}, "saddle")
    W, G = grid((-1, -1), (1.5, 1), 41, lambda x, y: 0.35 * (x**2 - y**2))
    row = scoring.score(truth, W, G)
    assert row["to_truth_max"] == pytest.approx(100 * np.hypot(0.5, 0.35 * 1.25), rel=0.05)
    assert row["to_result_max"] < 0.3


def test_jumps_across_a_curve_are_those_of_the_surface(tmp_path):
    line = np.stack([np.zeros(41), np.linspace(-1, 1, 41), np.zeros(41)], axis=1)
    told = {"diameter": 3.0, "borders": 1, "spacing": 0.05}
    # A roof: 0.1 up and 0.1 down.
    truth = truth_of(tmp_path, *grid((-1, -1), (1, 1), 3), line, told)
    row = scoring.score(truth, *grid((-1, -1), (1, 1), 61, lambda x, y: -0.1 * np.abs(x)))
    assert row["normal_jump_max"] == pytest.approx(2 * np.degrees(np.arctan(0.1)), rel=0.01)
    assert row["curvature_jump_max"] == pytest.approx(0, abs=0.05)
    # A cylinder of radius 2 that goes on as a plane: the mean curvature jumps by 1/4, times a diameter of 3.
    row = scoring.score(truth, *grid((-1, -1), (1, 1), 81, lambda x, y: np.where(x > 0, np.sqrt(4 - x**2) - 2, 0)))
    assert row["normal_jump_max"] < 0.2
    assert row["curvature_jump_p95"] == pytest.approx(0.75, rel=0.05)


def test_crossings_folds_and_vertices_where_sheets_meet_are_found():
    V = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0.4, 0.4, -1], [0.6, 0.4, 1], [0.4, 0.6, 1]], dtype=float)
    assert meshes.count_crossings(meshes.Surface(V, np.array([[0, 1, 2], [3, 4, 5]]))) == 1
    V[3:] += [9, 0, 0]
    assert meshes.count_crossings(meshes.Surface(V, np.array([[0, 1, 2], [3, 4, 5]]))) == 0
    V = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, 0.9, 0.1]], dtype=float)
    assert meshes.topology(V, np.array([[0, 1, 2], [1, 0, 3]]))["folds"] == 1
    V = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], dtype=float)
    assert not meshes.topology(V, np.array([[0, 1, 2], [0, 3, 4]]))["manifold"]
    V, F = cube()
    assert meshes.topology(V, np.concatenate([F[1:], F[:1, ::-1]]))["manifold"] is False
    assert meshes.topology(V, F)["genus"] == 0


def test_distances_to_a_mesh_are_the_least_over_all_triangles():
    random = np.random.default_rng(3)
    V, F = random.normal(size=(300, 3)), random.integers(0, 300, (200, 3))
    V *= np.where(np.arange(300) < 150, 1, 0.01)[:, None]  # sizes that differ
    F = F[(F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])]
    Q = random.normal(size=(50, 3)) * 2
    _, found, _ = meshes.Surface(V, F).nearest(Q)
    for q, distance in zip(Q, found):
        P = meshes.nearest_on_triangles(np.tile(q, (len(F), 1)), V[F])
        assert distance == pytest.approx(np.linalg.norm(P - q, axis=1).min(), rel=1e-9)


SHAPES = ["ellipsoid", "torus", "bumpycube", "dish", "saddle", "waves", "cone", "cylinder", "hole", "wedge"]


@pytest.mark.parametrize("name", SHAPES)
def test_the_nearest_point_of_a_formula_is_where_the_way_is_square_to_the_surface(name):
    """Points moved off a surface along its normal are that far away, and come back to where they were."""
    surface = shapes.shape(name)
    size, shift = {"torus": (6, 0), "cone": (1, 0.9)}.get(name, (1, 0))
    cloud = size * np.random.default_rng(1).uniform(-0.7, 0.7, (200, 3)) + [0, 0, shift]
    P, N = surface.nearest(cloud)
    inside = np.isfinite(P).all(1)
    P, N = P[inside], N[inside]
    assert len(P) > 30
    back, normals = surface.nearest(P + 0.003 * N)
    kept = np.isfinite(back).all(1)  # edges and borders may go to either side
    assert kept.mean() > 0.8
    assert np.abs(back - P)[kept].max() < 1e-6
    assert np.linalg.norm(np.cross(N, P + 0.003 * N - back), axis=1)[kept].max() < 1e-6


def test_loops_of_a_network_are_its_patches():
    network, points, normals = networks.sharp_network("cube", 0.1)
    assert sorted(len(loop) for loop in networks.loops(network)) == [4 * 6] * 6
    assert np.abs(np.abs(points).max(1) - 1).max() < 1e-12
    assert (np.abs(normals).max(1) == 1).all()


def same(expected, found):
    """Words as they are, numbers with 10 % play. Distances and angles below the rounding of the table are nothing."""
    try:
        return abs(float(expected) - float(found)) <= 0.1 * abs(float(expected)) + 1e-6
    except ValueError:
        return expected == found


def test_batten_scores_what_it_scored(tmp_path):
    """A case that comes out worse (or better) than benchmark/scores.csv says is a change to look at. After one that
    is wanted: benchmark/run --again batten, then benchmark/table --publish."""
    if not PROGRAM.exists():
        pytest.skip(f"the program is not built: {PROGRAM}")
    cases = ["sphere3", "dish", "bad-open"]
    words = ["batten", "--cases", ",".join(cases), "--build", tmp_path, "--batten", PROGRAM, "--no-table"]
    done = subprocess.run([sys.executable, BENCHMARK / "run", *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    with open(BENCHMARK / "scores.csv", encoding="utf8", newline="") as file:
        expected = {row["case"]: row for row in csv.DictReader(file) if row["tool"] == "batten"}
    with open(tmp_path / "scores.csv", encoding="utf8", newline="") as file:
        found = {row["case"]: row for row in csv.DictReader(file)}
    assert sorted(found) == sorted(cases)
    different = [
        f"{case}, {column}: was {expected[case][column]}, is {found[case][column]}"
        for case in cases
        for column in expected[case]
        if not same(expected[case][column], found[case][column])
    ]
    assert not different
