"""What is kept and solved again gives what is solved once."""

import numpy as np
import pytest

import batten


@pytest.fixture(scope="module")
def network():
    return batten.simulate("dish", truth_network=True, truth_step="2%").truth_network


def test_a_solver_builds_the_surface_of_surface(network):
    solver = batten.SurfaceSolver(network, edge_length="4%")
    surface = batten.surface(network, edge_length="4%")
    used = np.unique(solver.triangles)  # surface() leaves out vertices that no triangle uses
    np.testing.assert_array_equal(solver.positions[used], surface.positions)
    np.testing.assert_array_equal(solver.normals[used], surface.normals)
    np.testing.assert_array_equal(solver.patch_of_triangle, surface.patch_of_triangle)
    assert solver.on_network.dtype == bool and solver.on_network[: len(network.positions)].all()
    assert solver.warnings == []


def test_moves_carry_the_surface_and_do_not_add_up(network):
    solver = batten.SurfaceSolver(network, edge_length="4%")
    before, triangles = solver.positions, solver.triangles
    moved = network.positions + [0.0, 0.0, 0.1]
    changed = solver.move(moved, network.normals, reach="all")
    np.testing.assert_allclose(solver.positions, before + [0.0, 0.0, 0.1], atol=1e-9)
    assert changed["patches_solved"] >= 1
    first, end = changed["positions"][0]
    assert 0 <= first < end <= len(before)
    solver.move(moved, network.normals, reach="touched", positions_only=True)
    solver.move(network.positions, network.normals, reach="all")
    np.testing.assert_allclose(solver.positions, before, atol=1e-12)
    np.testing.assert_array_equal(solver.triangles, triangles)


def test_moves_are_refused_and_leave_the_surface(network):
    solver = batten.SurfaceSolver(network, edge_length="4%")
    before = solver.positions
    bad = network.positions.copy()
    bad[3, 1] = np.nan
    for positions, reach, sentence in [
        (bad, "all", "positions: row 3 holds nan"),
        (bad[1:], "all", "must be finite|positions must have|holds nan"),
        (network.positions[1:], "all", f"positions must have {len(network.positions)} rows"),
        (network.positions, "far", "reach must be touched or all, got 'far'"),
    ]:
        with pytest.raises(batten.InvalidInput, match=sentence):
            solver.move(positions, network.normals, reach=reach)
    np.testing.assert_array_equal(solver.positions, before)


def test_reconstruction_solver_gives_the_bits_of_network_from_scan():
    scan = batten.simulate("dish", step="3%", orientation_noise="1deg").scan
    solver = batten.ReconstructionSolver(scan)
    for options in ({}, {"weights": (1, 100)}, {"step": "5%", "robust": "off"}, {"uncertainty": True}):
        made, wanted = solver.solve(**options), batten.network_from_scan(scan, **options)
        np.testing.assert_array_equal(made.positions, wanted.positions)
        np.testing.assert_array_equal(made.normals, wanted.normals)
        if options.get("uncertainty"):
            np.testing.assert_array_equal(made.uncertainty, wanted.uncertainty)
    followed = solver.follow(weights=(1, 90))
    np.testing.assert_allclose(followed.positions, solver.solve(weights=(1, 90)).positions, atol=0.02)


def test_values_are_carried_to_another_mesh():
    from conftest import torus

    fine = batten.Mesh(*torus(60), values={})
    fine.values["height"] = fine.positions[:, 2].copy()
    coarse = batten.simplify(batten.Mesh(*fine), remove="70%")
    coarse.values = {"own": np.arange(len(coarse.positions), dtype=float)}
    carried = batten.carry_values(fine, coarse)
    assert set(carried.values) == {"own", "height"}
    np.testing.assert_allclose(carried.values["height"], coarse.positions[:, 2], atol=0.03)
    with pytest.raises(batten.InvalidInput, match="got ndarray alone"):
        batten.carry_values(coarse.positions, fine)
