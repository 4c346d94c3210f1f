"""The numbers are those of the program, bit for bit, and so are figures and warnings."""

import json
import warnings

import numpy as np
import pytest
from conftest import noisy_torus, torus

import batten

# What is about files, and what differs from run to run.
ASIDE = {"command", "options", "seconds", "written", "output"}


def without_files(figures):
    return {
        key: {k: v for k, v in value.items() if k not in ASIDE | {"file"}} if isinstance(value, dict) else value
        for key, value in figures.items()
        if key not in ASIDE
    }


def assert_same_report(report, figures, told=None):
    """Keys, their order and all numbers."""
    ours, theirs = without_files(report), without_files(figures)
    theirs.pop("warnings"), ours.pop("warnings")
    assert list(ours) == list(theirs)
    assert ours == theirs
    assert {"command", "options", "seconds", "warnings"} <= set(report)
    assert list(report["seconds"])[-1] == "total"


def assert_same_mesh(mesh, path):
    """Every bit, by the file that would be written."""
    theirs = batten.read_mesh(path)
    np.testing.assert_array_equal(mesh.triangles, theirs.triangles)
    np.testing.assert_array_equal(mesh.positions, theirs.positions)
    again = path.with_name("again" + path.suffix)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        batten.write_mesh(again, mesh)
    assert again.read_bytes() == path.read_bytes()


@pytest.fixture
def noisy(tmp_path):
    """A noisy torus with a value per vertex, as a file and as it is read."""
    V, F = noisy_torus(48)
    path = tmp_path / "in.ply"
    batten.write_mesh(path, batten.Mesh(V, F, values={"height": V[:, 2] * 1.5, "part": (V[:, 0] > 0) * 1.0}))
    return batten.read_mesh(path)


MESH_RUNS = [
    ("fair", {}),
    ("fair", {"method": "taubin", "iterations": 3}),
    ("fair", {"noise": 0.1, "keep_boundary": True}),
    ("remesh", {"vertices": 400, "adaptivity": 0.5}),
    ("remesh", {"edge": "5%", "keep_edges": "40deg", "repair": True}),
    ("remesh", {"edge": 0.17, "method": "lf", "iterations": 2}),
    ("simplify", {"faces": 300}),
    ("simplify", {"remove": "60%", "method": "plaplacian", "levels": 2, "fidelity": 2}),
    ("simplify", {"error": "0.5%", "keep_border": "exact"}),
    ("repair", {"weld": "0.01%", "fill_holes": "all"}),
]


def words(options):
    """Options as on a command line."""
    for name, value in options.items():
        flag = "--" + name.replace("_", "-")
        yield from [flag] if value is True else [flag, value]


@pytest.mark.parametrize("command, options", MESH_RUNS)
def test_meshes_are_those_of_the_program(program, noisy, tmp_path, command, options):
    figures = program(command, "in.ply", "-o", "out.ply", *words(options))
    mesh = getattr(batten, command)(noisy, **options)
    assert_same_mesh(mesh, tmp_path / "out.ply")
    assert_same_report(mesh.report, figures)
    assert set(options) <= set(mesh.report["options"])


def test_deformed_meshes_are_those_of_the_program(program, noisy, tmp_path):
    handles = {
        "fixed": {"box": [[-9, -9, -9], [-1, 9, 9]]},
        "handles": [{"select": {"sphere": [1, 0, 0, 0.6]}, "translate": [0.1, 0, 0.3], "rotate_deg": [0, 0, 1, 20]}],
    }
    (tmp_path / "handles.json").write_text(json.dumps(handles))
    figures = program("deform", "in.ply", "-o", "out.ply", "--handles", "handles.json", "--energy", "bend")
    mesh = batten.deform(noisy, handles=handles, energy="bend")
    assert_same_mesh(mesh, tmp_path / "out.ply")
    assert_same_report(mesh.report, figures)


def test_soups_are_welded_as_the_program_welds_them(program, tmp_path):
    V, F = torus(24)
    soup = V[F].reshape(-1, 3), np.arange(3 * len(F)).reshape(-1, 3)
    batten.write_mesh(tmp_path / "in.ply", *soup)
    figures = program("fair", "in.ply", "-o", "out.ply", "--method", "taubin")
    mesh = batten.fair(*soup, method="taubin")
    assert len(mesh.positions) == len(V)
    assert_same_mesh(mesh, tmp_path / "out.ply")
    assert [w.replace("mesh: ", "in.ply: ", 1) for w in mesh.warnings] == figures["warnings"] != []


def test_levels_are_those_of_the_program(program, noisy, tmp_path):
    figures = program("simplify", "in.ply", "-o", "out.ply", "--faces", "300", "--keep-all-levels", "levels")
    mesh = batten.simplify(noisy, faces=300, keep_all_levels=True)
    assert len(mesh.levels) == len(figures["levels"]) > 2
    for level, entry in zip(mesh.levels, figures["levels"]):
        theirs = batten.read_mesh(tmp_path / entry["file"])
        np.testing.assert_array_equal(level.positions, theirs.positions)
        np.testing.assert_array_equal(level.triangles, theirs.triangles)
        assert set(level.values) == set(theirs.values)
    assert mesh.vertex_map.shape == (len(noisy.positions),)
    assert mesh.vertex_map.max() == len(mesh.positions) - 1


def test_refined_cages_are_those_of_the_program(program, tmp_path):
    cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    faces = "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nt crease 2/1/0 4 5 2.5\n"
    (tmp_path / "cage.obj").write_text(cube + faces)
    cage = batten.read_cage(tmp_path / "cage.obj")
    assert cage.sharp_edges == {(4, 5): 2.5}
    for options in ({"levels": 2, "limit": True}, {"scheme": "nulissmod,catmull-clark", "knots": 1}):
        figures = program("subdivide", "cage.obj", "-o", "out.ply", *words(options))
        refined = batten.subdivide(cage, **options)
        assert_same_report(refined.report, figures)
        batten.write_cage(tmp_path / "again.ply", refined)
        assert (tmp_path / "again.ply").read_bytes() == (tmp_path / "out.ply").read_bytes()
        assert refined.faces.shape[1] == 4 and len(refined.triangles) == 2 * len(refined.faces)
        assert refined.mesh().triangles is refined.triangles


def test_distances_are_those_of_the_program(program, noisy, tmp_path):
    V, F = torus(40)
    batten.write_mesh(tmp_path / "b.ply", V + [0.01, 0, 0], F)
    figures = program(
        "compare", "in.ply", "b.ply", "--register", "rigid", "--samples", "5000", "--distances", "moved.ply"
    )
    found = batten.compare(noisy, (V + [0.01, 0, 0], F), register="rigid", samples=5000)
    assert_same_report(found.report, figures)
    assert_same_mesh(found.mesh, tmp_path / "moved.ply")
    np.testing.assert_array_equal(found.mesh.values["distance"], found.distances)
    assert found.hausdorff == figures["hausdorff"]


def test_check_is_that_of_the_program(program, tmp_path):
    scan = batten.simulate("sphere")
    surface = batten.reconstruct(scan.scan)
    batten.write_mesh(tmp_path / "ball.ply", surface)
    batten.write_network(tmp_path / "ball.json", surface.network)
    figures = program("check", "ball.ply", "--network", "ball.json")
    found = batten.check(surface, surface.network)
    assert_same_report(found.report, figures)
    assert found.passes and {curve["verdict"] for curve in found.curves} == {"pass"}
    strict = batten.check(surface, surface.network, tolerance="0.0001deg")
    assert not strict.passes and "normals differ by" in strict.curves[0]["reasons"][0]
    with pytest.raises(batten.InvalidInput, match="surface: this is a network"):
        batten.check(surface.network, surface.network)
    with pytest.raises(batten.InvalidInput, match="network: this is a mesh"):
        batten.check(surface, surface)


SCAN = {"seed": 7, "orientation_noise": "1deg", "drift": "0.5deg", "odometer_error": "0.3%", "step": "1.5%"}


@pytest.fixture
def simulated(program, tmp_path):
    figures = program(
        "simulate", "torus", "-o", "scan.rawnet", *words(SCAN), "--truth", "truth.ply", "--truth-network", "truth.json",
        "--truth-edge", "2%", "--truth-step", "0.5%",
    )  # fmt: skip
    made = batten.simulate("torus", **SCAN, truth=True, truth_network=True, truth_edge="2%", truth_step="0.5%")
    return figures, made


def test_simulations_are_those_of_the_program(simulated, tmp_path):
    figures, made = simulated
    assert_same_report(made.report, figures)
    batten.write_rawnet(tmp_path / "again.rawnet", made.scan)
    assert (tmp_path / "again.rawnet").read_bytes() == (tmp_path / "scan.rawnet").read_bytes()
    assert_same_mesh(made.truth, tmp_path / "truth.ply")
    batten.write_network(tmp_path / "again.json", made.truth_network)
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "truth.json").read_bytes()


def test_logs_are_those_of_the_program(program, tmp_path):
    options = {"raw": True, "seed": 2, "step": "2%", "gyroscope": True, "gyroscope_bias": "1deg", "sensor_noise": 0.5}
    figures = program("simulate", "dish", "-o", "log.csv", *words(options), "--tumble", "tumble.csv")
    made = batten.simulate("dish", **options, tumble=True)
    assert_same_report(made.report, figures)
    for log, name in [(made.log, "log.csv"), (made.tumble, "tumble.csv")]:
        batten.write_sensor_log(tmp_path / "again.csv", log)
        assert (tmp_path / "again.csv").read_bytes() == (tmp_path / name).read_bytes()
    read = batten.read_sensor_log(tmp_path / "log.csv")
    np.testing.assert_array_equal(read.gyroscope, made.log.gyroscope)
    scan = batten.read_scan(tmp_path / "log.csv")
    assert len(scan.curves) == len(made.scan.curves) and scan.curves[0].turns is not None


def test_networks_are_those_of_the_program(simulated, program, tmp_path):
    scan = batten.read_rawnet(tmp_path / "scan.rawnet")
    for options in ({"uncertainty": True}, {"weights": "1,100", "robust": "off", "scheme": "thesis", "step": "3%"}):
        figures = program("network", "scan.rawnet", "-o", "out.json", *words(options))
        network = batten.network_from_scan(scan, **options)
        assert_same_report(network.report, figures)
        batten.write_network(tmp_path / "again.json", network)
        assert (tmp_path / "again.json").read_bytes() == (tmp_path / "out.json").read_bytes()


def test_numbers_of_nodes_are_those_of_the_program(program, tmp_path):
    made = batten.simulate("waves", nodes="stays", step="1%")
    assert made.scan.curves[0].node_ids.tolist() == [-1] * len(made.scan.curves[0].node_ids)
    batten.write_rawnet(tmp_path / "stays.rawnet", made.scan)
    figures = program(
        "network", "stays.rawnet", "-o", "out.json", "--nodes", "auto", "--numbered", "numbered.rawnet"
    )
    network = batten.network_from_scan(made.scan, nodes="auto")
    assert_same_report(network.report, figures)
    numbered = batten.infer_nodes(made.scan)
    assert numbered.report == figures["inferred_nodes"]
    batten.write_rawnet(tmp_path / "again.rawnet", numbered)
    assert (tmp_path / "again.rawnet").read_bytes() == (tmp_path / "numbered.rawnet").read_bytes()
    doubtful = batten.simulate("torus", nodes="stays", step="2%").scan  # turned by a quarter it looks the same
    with pytest.raises(batten.Error, match=r"not sure, \d+ doubts; .*infer_nodes\(\) gives the proposal"):
        batten.network_from_scan(doubtful, nodes="auto")
    assert batten.infer_nodes(doubtful).report["doubts"]


def test_surfaces_are_those_of_the_program(program, tmp_path):
    network = batten.simulate("dish", truth_network=True, truth_step="2%").truth_network
    batten.write_network(tmp_path / "net.json", network)
    for options in ({"edge_length": "4%"}, {"method": "biharmonic", "rebuilds": 0, "edge_length": "4%"},
                    {"constraints": "soft", "soft_weight": 0.5, "edge_length": "4%", "uncertainty": True}):  # fmt: skip
        figures = program("surface", "net.json", "-o", "out.ply", *words(options))
        surface = batten.surface(network, **options)
        assert_same_report(surface.report, figures)
        assert_same_mesh(surface, tmp_path / "out.ply")
        assert len(surface.patch_of_triangle) == len(surface.triangles)
        assert (surface.uncertainty is not None) == ("uncertainty" in options)


def test_surfaces_of_strokes_are_those_of_the_program(program, tmp_path):
    network = batten.simulate("sphere", truth_network=True, truth_step="2%").truth_network
    network.normals = None
    batten.write_network(tmp_path / "strokes.json", network)
    figures = program("surface", "strokes.json", "-o", "out.ply", "--edge-length", "6%", "--write-network", "net.json")
    surface = batten.surface(network, edge_length="6%")
    assert_same_report(surface.report, figures)
    assert_same_mesh(surface, tmp_path / "out.ply")
    batten.write_network(tmp_path / "again.json", surface.network)
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "net.json").read_bytes()


def test_reconstructions_are_those_of_the_program(simulated, program, tmp_path):
    options = {"edge_length": "5%", "uncertainty": True}
    figures = program(
        "reconstruct", "scan.rawnet", "-o", "out.ply", "--network", "net.json", "--against", "truth.ply", *words(options)
    )
    surface = batten.reconstruct(simulated[1].scan, against=simulated[1].truth, **options)
    assert_same_report(surface.report, figures)
    assert surface.values.pop("error_percent").max() == pytest.approx(figures["error_percent"]["max"], rel=1)
    assert_same_mesh(surface, tmp_path / "out.ply")
    batten.write_network(tmp_path / "again.json", surface.network)
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "net.json").read_bytes()


def test_numbers_do_not_depend_on_threads(noisy):
    found = batten.threads()
    try:
        batten.set_threads(1)
        one = batten.fair(noisy)
        batten.set_threads(3)
        assert batten.threads() == 3
        np.testing.assert_array_equal(batten.fair(noisy).positions, one.positions)
        for wrong in (0, -1, 1025, True, "many", 1.5):
            with pytest.raises(batten.InvalidInput, match="threads must be all or a whole number"):
                batten.set_threads(wrong)
    finally:
        batten.set_threads("all")
    assert batten.threads() == found
