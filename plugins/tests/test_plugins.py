"""The add-on for Blender and the macro for FreeCAD, in these programs without a window; their parts without them."""

import ast
import json
import os
import pathlib
import shutil
import subprocess
import sys
import time

import numpy as np
import pytest

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PROGRAM = pathlib.Path(os.environ.get("BATTEN_PROGRAM", ROOT / "build/release/bin/batten"))
ADDON = ROOT / "plugins/blender/batten_blender"

# The parts of the add-on that are Python alone, without its __init__.py, which needs Blender.
sys.path.insert(0, str(ADDON))
import curves  # noqa: E402
import ply  # noqa: E402
import program as process  # noqa: E402

needs_program = pytest.mark.skipif(not PROGRAM.exists(), reason=f"the program is not built: {PROGRAM}")


def cases(file):
    """The names of the tests in a file that another program runs."""
    return [node.name for node in ast.walk(ast.parse((HERE / file).read_text()))
            if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")]


def run_inside(command, folder, **environment):
    """The outcome of every test by its name, as COMMAND wrote it into folder/results.json."""
    for needed in {"blender", "freecadcmd", "xvfb-run"} & set(command):
        if shutil.which(needed) is None:
            pytest.skip(f"{needed} is not installed; tools/setup plugins installs it")
    if not PROGRAM.exists():
        pytest.skip(f"the program is not built: {PROGRAM}")
    run = subprocess.run(command, cwd=folder, env={**os.environ, "TMPDIR": str(folder), "HOME": str(folder), **environment},
                         capture_output=True, text=True, timeout=120, check=False)
    results = folder / "results.json"
    assert results.exists(), run.stdout + run.stderr
    return json.loads(results.read_text())


@pytest.fixture(scope="session")
def addon(tmp_path_factory):
    path = tmp_path_factory.mktemp("addon") / "batten_blender.zip"
    subprocess.run([ROOT / "tools/blender-addon", path], check=True)
    return path


@pytest.fixture(scope="session")
def in_blender(addon, tmp_path_factory):
    folder = tmp_path_factory.mktemp("blender")
    return run_inside(["blender", "-b", "--factory-startup", "--python", str(HERE / "blender_cases.py"), "--",
                       str(addon), str(PROGRAM), str(folder / "results.json")], folder)


@pytest.fixture(scope="session")
def in_freecad(tmp_path_factory):
    folder = tmp_path_factory.mktemp("freecad")
    return run_inside(["freecadcmd", str(HERE / "freecad_cases.py")], folder, BATTEN_PROGRAM=str(PROGRAM),
                      BATTEN_MACRO=str(ROOT / "plugins/freecad/batten_surface.FCMacro"), BATTEN_RESULTS=str(folder / "results.json"))


@pytest.mark.parametrize("name", cases("blender_cases.py"))
def test_blender(name, in_blender):
    assert in_blender[name] == ""


@pytest.mark.parametrize("name", cases("freecad_cases.py"))
def test_freecad(name, in_freecad):
    assert in_freecad[name] == ""


def test_the_versions_are_those_of_the_project():
    project = (ROOT / "CMakeLists.txt").read_text().split("project(batten VERSION ")[1].split()[0]
    info = ast.parse((ADDON / "__init__.py").read_text()).body[1]
    assert ".".join(map(str, ast.literal_eval(info.value)["version"])) == project
    assert f'__Version__ = "{project}"' in (ROOT / "plugins/freecad/batten_surface.FCMacro").read_text()


def test_the_add_on_packs_to_the_same_bytes(addon, tmp_path):
    for path in ADDON.glob("*.py"):
        path.touch()
    subprocess.run([ROOT / "tools/blender-addon", tmp_path / "again.zip"], check=True)
    assert (tmp_path / "again.zip").read_bytes() == addon.read_bytes()


def test_edges_become_chains_between_their_ends():
    # A figure of two squares side by side, the middle edge shared, and a triangle apart.
    edges = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [1, 4], [4, 5], [5, 2], [6, 7], [7, 8], [8, 6]])
    found = curves.chains(edges, [curves.INNER] * 10)
    as_sets = sorted(tuple(sorted((tuple(chain), tuple(chain[::-1])))[0]) for chain, _ in found)
    assert [len(chain) for chain in as_sets] == [4, 2, 4, 4]
    assert (1, 2) in as_sets and (1, 0, 3, 2) in as_sets and (1, 4, 5, 2) in as_sets
    triangle = as_sets[-1]
    assert triangle[0] == triangle[-1] and set(triangle) == {6, 7, 8}


def test_chains_end_where_the_kind_changes():
    found = curves.chains(np.array([[0, 1], [1, 2], [2, 3], [3, 0]]), [curves.BORDER, curves.BORDER, curves.INNER, curves.INNER])
    assert sorted((set(chain), kind) for chain, kind in found) == sorted([({0, 1, 2}, curves.BORDER), ({2, 3, 0}, curves.INNER)])
    assert all(len(chain) == 3 for chain, _ in found)


@needs_program
def test_meshes_go_to_the_program_and_back(tmp_path):
    V = np.random.default_rng(1).normal(size=(4, 3))
    F = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    ply.write(tmp_path / "in.ply", V, F, {"material": np.array([3, 1, 0, 2])})
    subprocess.run([PROGRAM, "convert", "in.ply", "out.ply"], cwd=tmp_path, check=True, capture_output=True)
    X, G, _, values = ply.read(tmp_path / "out.ply")
    assert (X == V).all() and (G == F).all() and values["material"].tolist() == [3, 1, 0, 2]


def sphere(path, n=96):
    """Three circles of n points."""
    angles = 2 * np.pi * np.arange(n) / n
    points = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    positions = np.concatenate([np.roll(points, axis, axis=1) for axis in range(3)])
    lines = [("", [*range(k * n, k * n + n), k * n], curves.INNER) for k in range(3)]
    curves.write(path, curves.Network(positions, None, lines))


def is_running(pid):
    return pathlib.Path(f"/proc/{pid}").exists()


@needs_program
def test_a_run_tells_its_stages(tmp_path):
    run = process.Run(str(PROGRAM), tmp_path)
    sphere(run.file("curves.json"))
    run.start(["surface", run.file("curves.json"), "-o", run.file("out.ply"), "--edge-length", "0.8%"])
    stages = set()
    while (answer := run.poll()) is None:
        stages.add(run.stage)
        time.sleep(0.01)
    assert answer["watertight"]
    assert any(stage.endswith(" %") for stage in stages), stages
    run.close()
    assert list(tmp_path.iterdir()) == []


@needs_program
def test_closing_a_run_ends_the_program_and_removes_its_files(tmp_path):
    run = process.Run(str(PROGRAM), tmp_path)
    sphere(run.file("curves.json"))
    run.start(["surface", run.file("curves.json"), "-o", run.file("out.ply"), "--edge-length", "0.1%"])
    deadline = time.monotonic() + 60
    while run.stage == "starting" and time.monotonic() < deadline:  # at work, not still being loaded
        assert run.poll() is None
        time.sleep(0.01)
    assert run.stage != "starting"
    pid = run._process.pid
    run.close()
    assert not is_running(pid)
    assert list(tmp_path.iterdir()) == []


@needs_program
def test_refusals_are_the_words_of_the_program(tmp_path):
    run = process.Run(str(PROGRAM), tmp_path)
    path = run.file("in.ply", known_as="Suzanne")
    pathlib.Path(path).write_text("nothing")
    run.start(["fair", path, "-o", run.file("out.ply")])
    with pytest.raises(process.Refusal, match="^Suzanne:1: the PLY header has no") as refusal:
        run.wait()
    assert "batten-" not in str(refusal.value)
    run.close()


@needs_program
def test_work_that_is_not_sound_is_refused_in_words(tmp_path):
    # Two tetrahedra that run through each other: nothing that repair does takes them apart.
    V = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    F = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    run = process.Run(str(PROGRAM), tmp_path)
    path = run.file("in.ply", known_as="Suzanne")
    ply.write(path, np.concatenate([V, V + 0.1]), np.concatenate([F, F + 4]))
    run.start(["repair", path, "-o", run.file("out.ply", known_as="the result")])
    with pytest.raises(process.Refusal, match="^not all of Suzanne could be repaired: 3 pairs .*; the result was not written"):
        run.wait()
    run.close()


def test_without_a_program_the_remedy_is_told(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(process, "USUAL_PLACE", str(tmp_path / "batten"))
    with pytest.raises(process.Refusal, match="neither on PATH nor at .*; install the package batten"):
        process.find()
    with pytest.raises(process.Refusal, match="is not a file; choose"):
        process.find("/nowhere/batten")
    (tmp_path / "batten").write_text("#!/bin/sh\necho batten 9.8.7\n")
    (tmp_path / "batten").chmod(0o755)
    assert process.find() == (str(tmp_path / "batten"), "9.8.7")
