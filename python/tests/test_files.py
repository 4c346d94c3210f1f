"""Files: what is written reads back as the same, and errors say where."""

import pathlib

import numpy as np
import pytest
from conftest import torus

import batten

pytestmark = pytest.mark.filterwarnings("ignore:.*single precision")

V, F = torus(12)


@pytest.mark.parametrize("name", ["a.ply", "a.obj", "a.off", "a.stl", "a.3mf", "a.glb"])
def test_meshes_read_back(tmp_path, name):
    batten.write_mesh(tmp_path / name, V, F, unit="m")
    mesh = batten.read_mesh(str(tmp_path / name))
    precision = 1e-6 if name in ("a.stl", "a.glb", "a.3mf") else 0
    np.testing.assert_allclose(mesh.positions[mesh.triangles], V[F], atol=precision)
    assert mesh.name == str(tmp_path / name)


def test_values_and_normals_read_back_bit_for_bit(tmp_path):
    N = V / np.linalg.norm(V, axis=1)[:, None]
    batten.write_mesh(tmp_path / "a.ply", batten.Mesh(V, F, N, {"quality": V[:, 0]}))
    mesh = batten.read_mesh(tmp_path / "a.ply")
    np.testing.assert_array_equal(mesh.values["quality"], V[:, 0])
    np.testing.assert_array_equal(mesh.positions, V)
    np.testing.assert_allclose(mesh.normals, N, atol=1e-15)


def test_what_a_format_cannot_hold_is_told(tmp_path):
    mesh = batten.Mesh(V, F, values={"quality": V[:, 0]})
    with pytest.warns(UserWarning, match="a.obj: .*quality"):
        batten.write_mesh(tmp_path / "a.obj", mesh)


def test_units_are_those_of_the_format(tmp_path):
    batten.write_mesh(tmp_path / "a.glb", V, F, unit="mm")
    np.testing.assert_allclose(batten.read_mesh(tmp_path / "a.glb").positions, V / 1000, atol=1e-9)
    with pytest.raises(batten.InvalidInput, match="'furlong' is no unit"):
        batten.write_mesh(tmp_path / "b.glb", V, F, unit="furlong")
    assert not (tmp_path / "b.glb").exists()


def test_attributes_of_files_go_through(tmp_path):
    """Objects, groups and texture coordinates, which Python does not show."""
    lines = ["o part", *(f"v {x!r} {y!r} {z!r}" for x, y, z in V.tolist()), "g left"]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in F.tolist()]
    (tmp_path / "in.obj").write_text("\n".join(lines) + "\n")
    mesh = batten.fair(batten.read_mesh(tmp_path / "in.obj"), method="taubin")
    batten.write_mesh(tmp_path / "out.obj", mesh)
    text = (tmp_path / "out.obj").read_text()
    assert "o part" in text and "g left" in text
    mesh.triangles = mesh.triangles[1:]  # of other triangles the file says nothing
    batten.write_mesh(tmp_path / "less.obj", mesh)
    assert "o part" not in (tmp_path / "less.obj").read_text()


def test_networks_read_back(tmp_path):
    network = batten.Network(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
        [[0, 1, 2, 0]],
        normals=[[0, 0, 1]] * 3,
        boundary=[True],
        names=["rim"],
        sharp=[True],
        left_normals=[[[0, 0, 1]] * 4],
        right_normals=[[[1, 0, 0]] * 4],
        nodes=[1],
        unit="mm",
        uncertainty=[0.1, 0.2, 0.3],
    )
    batten.write_network(tmp_path / "a.json", network)
    read = batten.read_network(tmp_path / "a.json")
    np.testing.assert_array_equal(read.positions, network.positions)
    np.testing.assert_array_equal(read.curves[0], [0, 1, 2, 0])
    np.testing.assert_array_equal(read.right_normals[0], [[1, 0, 0]] * 4)
    np.testing.assert_array_equal(read.uncertainty, [0.1, 0.2, 0.3])
    assert (read.names, read.boundary, read.sharp, read.unit) == (["rim"], [True], [True], "mm")
    assert 1 in read.nodes.tolist()
    with pytest.warns(UserWarning, match="a.net: .*uncertainty"):
        batten.write_network(tmp_path / "a.net", network)


def test_the_sample_scan_reads_and_reads_back(tmp_path):
    sample = pathlib.Path(__file__).parents[2] / "data" / "sample.rawnet"
    scan = batten.read_rawnet(sample)
    batten.write_rawnet(tmp_path / "a.rawnet", scan)
    again = batten.read_scan(tmp_path / "a.rawnet")
    for one, other in zip(scan.curves, again.curves):
        for field in ("distances", "tangents", "normals", "node_readings", "node_ids"):
            np.testing.assert_array_equal(getattr(one, field), getattr(other, field))
    assert len(scan.curves) == len(again.curves)


def test_errors_say_file_and_line(tmp_path):
    (tmp_path / "bad.obj").write_text("v 0 0 0\nv 1 0 0\nv x 1 0\nf 1 2 3\n")
    with pytest.raises(batten.FileError, match="bad.obj:3") as caught:
        batten.read_mesh(tmp_path / "bad.obj")
    assert caught.value.line == 3 and caught.value.path == str(tmp_path / "bad.obj")
    with pytest.raises(OSError, match="cannot be opened") as caught:
        batten.read_network(tmp_path / "missing.json")
    assert caught.value.line is None and isinstance(caught.value, batten.Error)
    with pytest.raises(batten.FileError, match="extension"):
        batten.write_mesh(tmp_path / "a.docx", V, F)
    with pytest.raises(batten.InvalidInput, match="a path must be text"):
        batten.read_mesh(3)
    assert list(tmp_path.iterdir()) == [tmp_path / "bad.obj"]


def test_objects_of_the_wrong_kind_are_refused(tmp_path):
    for call, sentence in [
        (lambda: batten.write_mesh(tmp_path / "a.ply", V), "give a Mesh, got ndarray"),
        (lambda: batten.write_network(tmp_path / "a.net", batten.Mesh(V, F)), "give a Network, got Mesh"),
        (lambda: batten.write_rawnet(tmp_path / "a.rawnet", V), "give a Scan, got ndarray"),
        (lambda: batten.write_sensor_log(tmp_path / "a.csv", V), "give a SensorLog, got ndarray"),
        (lambda: batten.write_cage(tmp_path / "a.obj", V), "give a Cage, got ndarray"),
        (lambda: batten.surface(V), "give a Network, got ndarray"),
        (lambda: batten.reconstruct("scan.rawnet"), "give a Scan, got str"),
        (lambda: batten.simulate(V), "give a Mesh, got ndarray"),
        (lambda: batten.subdivide(V), "give a Cage, a Mesh or a pair"),
        (lambda: batten.compare(3, (V, F)), "A: must be a Mesh, a Network or a pair"),
        (lambda: batten.SurfaceSolver(V), "give a Network, got ndarray"),
        (lambda: batten.ReconstructionSolver(V), "give a Scan, got ndarray"),
    ]:
        with pytest.raises(batten.InvalidInput, match=sentence):
            call()


def test_meshes_that_nothing_can_be_measured_on_are_refused_before_they_are_mended():
    flat = (np.zeros((3, 3)), F[:1] * 0 + [0, 1, 2])
    with pytest.raises(batten.InvalidInput, match="no face has an area"):
        batten.compare(flat, (V, F), repair=True)
