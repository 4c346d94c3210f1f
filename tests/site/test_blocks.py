"""Every block of the documents runs: those of the guides one after another, the examples of the commands on small files of their names."""

import os
import shutil
import subprocess

import pytest
from documents import PAGES, PROGRAM, ROOT, fenced, indented_commands, name_of

pytestmark = pytest.mark.skipif(not PROGRAM.exists(), reason=f"the program is not built: {PROGRAM}")

GUIDES = [page for page in PAGES if name_of(page).startswith("docs/tutorials/") and fenced(page, "sh")]

# Blocks of shell that are no guides: they build, install or serve.
ELSEWHERE = {
    "README.md": "packaging/run-readme runs them; ./demo is run by tools/check-bare",
    "docs/install.md": "tools/package --bare does the same in a bare system",
    "docs/python.md": "builds; python/tests/test_examples.py runs the example",
    "docs/studio.md": "builds the page and serves it; web/tests and tests/apps/studio_test.cpp",
    "docs/blender.md": "its own test runs them",
    "docs/freecad.md": "its own test runs them",
    "docs/cluster.md": "workflows/tests runs them",
}

# Lines of the pages of commands that need what a test has not.
NOT_RUN = {
    "batten capture line:/dev/ttyUSB0@230400": "a device",
    "batten convert hull.blog hull.rawnet": "the recording of that device",
    "batten reconstruct hull.rawnet -o hull.ply": "the scan of that device",
    "batten report thesis-": "minutes; tests/apps/report_test.cpp",
    "batten report sketch": "minutes; tests/apps/report_test.cpp",
    "batten rig calibrate left*.png": "photographs; tests/apps/rig_test.cpp",
    "batten studio": "runs until Ctrl-C; tests/apps/studio_test.cpp",
}

# What the examples of the commands work on, made by the program: coarse, so that all of it is a matter of seconds.
FILES = """
batten simulate sphere -o scan.rawnet --step 3% --seed 2 --orientation-noise 1deg --truth truth.ply --truth-edge 9% \
  --truth-network truth.net --truth-step 3% --nodes numbered
batten simulate sphere -o log.csv --raw --tumble tumble.csv --step 3% --seed 3 --no-distortion
batten simulate pen -o blobs.jsonl --truth truth.csv --rig global --seed 1 --corners corners.csv --duration 3s --path letters
batten convert truth.net net.net --resample 8%
batten convert net.net net.json
batten convert net.net net.obj
batten surface net.net -o surface.ply
batten convert truth.ply large.obj
awk '/^v / {print "v", $2 / 50, $3 / 50, $4 / 50; next} {print}' large.obj >hand.obj  # of 40 mm, for lengths in millimetres
for name in part.ply part.obj part.stl parts.obj scan.ply scan.stl export.stl head.stl object.stl hood.stl fandisk.obj igea.ply; do
  batten convert hand.obj $name
done
cp net.json network.json
cp net.obj character-lines.obj
gzip -k part.stl
"""
STROKES = [[(5 * i - 25, y, 0) for i in range(11)] for y in (-20, 0, 20)] + [
    [(x, 5 * i - 25, 0) for i in range(11)] for x in (-20, 0, 20)
]
CAGE = """v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"""


def run(lines, folder):
    """Runs lines of bash; the one that fails is told with what it said."""
    environment = dict(os.environ, PATH=f"{folder / 'bin'}:{os.environ['PATH']}")
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", lines], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{lines}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}"
    return done


def with_program(folder):
    (folder / "bin").mkdir()
    (folder / "bin" / "batten").symlink_to(PROGRAM)
    for name in ("data", "examples"):
        (folder / name).symlink_to(ROOT / name)
    return folder


@pytest.mark.parametrize("page", GUIDES, ids=name_of)
def test_the_blocks_of_a_guide_run_one_after_the_other(page, tmp_path):
    run("".join(fenced(page, "sh")), with_program(tmp_path))


def test_no_block_of_shell_is_forgotten():
    others = {name_of(page) for page in PAGES if fenced(page, "sh")} - {name_of(page) for page in GUIDES}
    assert others <= set(ELSEWHERE), "a page with blocks of shell is run by nothing: name its test in ELSEWHERE"


@pytest.fixture(scope="module")
def small_files(tmp_path_factory):
    folder = with_program(tmp_path_factory.mktemp("files"))
    run(FILES, folder)
    (folder / "cage.obj").write_text(CAGE)
    obj = [f"v {x} {y} {z}" for stroke in STROKES for x, y, z in stroke]
    obj += ["l " + " ".join(str(11 * k + i + 1) for i in range(11)) for k in range(len(STROKES))]
    (folder / "sketch.obj").write_text("\n".join(obj) + "\n")
    (folder / "handles.json").write_text(
        '{"fixed": {"box": [[-2, -2, -2], [2, 2, -0.012]]}, "handles": [{"select": {"box": [[-2, -2, 0.016], [2, 2, 2]]}, "translate": [0, 0, 0.006]}]}'
    )
    # curl gives the mesh that is asked for, from here.
    (folder / "bin" / "curl").write_text(f'#!/bin/sh\nexec cat "{folder}/part.stl.gz"\n')
    (folder / "bin" / "curl").chmod(0o755)
    shutil.copy(ROOT / "examples" / "sessions" / "cube.jsonl", folder / "session.jsonl")
    return folder


def commands():
    for page in PAGES:
        lines = indented_commands(page)
        if lines:
            yield pytest.param(page, lines, id=name_of(page))


@pytest.mark.parametrize("page, lines", commands())
def test_the_examples_of_a_command_run(page, lines, small_files, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(small_files, folder, symlinks=True)
    lines = [line for line in lines if not any(line.startswith(start) for start in NOT_RUN)]
    # A verdict is no failure: on meshes as coarse as these a curve may well not be smooth enough.
    lines = [f"{line} || [[ $? == 1 ]]" if line.startswith("batten check ") else line for line in lines]
    if lines:
        run("\n".join(lines), folder)


def test_what_is_not_run_is_still_in_the_documents():
    lines = [line for page in PAGES for line in indented_commands(page)]
    for start in NOT_RUN:
        assert any(line.startswith(start) for line in lines), f"no page has {start!r} any more"
    assert len(lines) > 60


@pytest.mark.parametrize("page", [page for page in PAGES if fenced(page, "python") and name_of(page).startswith("docs/tutorials/")], ids=name_of)
def test_the_blocks_of_python_run_one_after_the_other(page, tmp_path, monkeypatch):
    pytest.importorskip("batten", reason="the Python package is not built: tools/build release python")
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "document"}
    for number, block in enumerate(fenced(page, "python")):
        exec(compile(block, f"{name_of(page)}, block {number + 1}", "exec"), names)
