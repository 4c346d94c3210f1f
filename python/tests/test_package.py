"""The package as such: errors, stubs, docstrings, size, and the file for other build tools."""

import ast
import inspect
import pathlib
import re
import shutil
import subprocess
import sys
import tomllib

import pytest
from conftest import BUILD, ROOT

import batten

STUB = ROOT / "python" / "batten" / "__init__.pyi"


def test_errors_are_those_of_python_too():
    assert issubclass(batten.Error, RuntimeError)
    assert issubclass(batten.InvalidInput, batten.Error) and issubclass(batten.InvalidInput, ValueError)
    assert issubclass(batten.FileError, batten.Error) and issubclass(batten.FileError, OSError)
    assert issubclass(batten.SolverFailure, batten.Error) and issubclass(batten.Cancelled, batten.Error)
    with pytest.raises(batten.Error, match=r"not all of mesh could be repaired: .*accept_flaws=True returns it") as caught:
        batten.repair(*two_crossing_squares())
    assert type(caught.value) is batten.Error
    assert "accepted: " in batten.repair(*two_crossing_squares(), accept_flaws=True).warnings[-1]


def two_crossing_squares():
    V = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, -2, -1], [0, 2, -1], [0, 2, 1], [0, -2, 1]]
    return V, [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]


def test_sentences_name_options_as_python_does():
    with pytest.raises(batten.InvalidInput, match="^simplify: give exactly one of faces, remove and error$"):
        batten.simplify(*two_crossing_squares())
    with pytest.raises(batten.InvalidInput, match="^gyroscope needs raw: a scan"):
        batten.simulate("torus", gyroscope=True)
    assert batten.InvalidInput.__module__ == "batten"


def parameters_of_stub(function):
    """Name, kind and default of each parameter of a definition in the stub."""
    a = function.args
    plain = [*a.posonlyargs, *a.args]
    defaults = [None] * (len(plain) - len(a.defaults)) + a.defaults
    yield from ((p.arg, "plain", d) for p, d in zip(plain, defaults))
    yield from ((p.arg, "keyword", d) for p, d in zip(a.kwonlyargs, a.kw_defaults))


def parameters_of(function):
    for p in inspect.signature(function).parameters.values():
        yield p.name, "keyword" if p.kind == p.KEYWORD_ONLY else "plain", p.default


def assert_same_signature(name, definition, function):
    stub, real = list(parameters_of_stub(definition)), list(parameters_of(function))
    assert [p[:2] for p in stub] == [p[:2] for p in real], name
    for (parameter, _, theirs), (_, _, ours) in zip(stub, real):
        assert (theirs is None) == (ours is inspect.Parameter.empty), f"{name}: {parameter}"
        if theirs is not None:
            assert ast.literal_eval(theirs) == ours, f"{name}: {parameter}"


def test_the_stub_names_everything_with_its_signature():
    tree = ast.parse(STUB.read_text(encoding="utf8"))
    functions = {n.name: n for n in tree.body if isinstance(n, ast.FunctionDef)}
    classes = {n.name: n for n in tree.body if isinstance(n, ast.ClassDef)}
    assert set(functions) | set(classes) | {"__version__"} == set(batten.__all__)
    for name, definition in functions.items():
        assert_same_signature(name, definition, getattr(batten, name))
    for name, definition in classes.items():
        kind = getattr(batten, name)
        assert [ast.unparse(b) for b in definition.bases] == [b.__name__ for b in kind.__bases__ if b is not object]
        members = {n.name: n for n in definition.body if isinstance(n, ast.FunctionDef)}
        own = {
            n: m
            for n, m in vars(kind).items()
            if (inspect.isfunction(m) or isinstance(m, property)) and (n[0] != "_" or n in ("__init__", "__iter__"))
        }
        assert set(members) == set(own), name
        for member, function in own.items():
            if inspect.isfunction(function):
                assert_same_signature(f"{name}.{member}", members[member], function)


def test_objects_have_the_attributes_of_the_stub():
    tree = ast.parse(STUB.read_text(encoding="utf8"))
    made = batten.simulate("dish", step="6%", raw=True, tumble=True, truth=True, truth_network=True, truth_edge="9%", truth_step="8%")
    surface = batten.surface(made.truth_network)
    samples = [
        made, made.scan, made.scan.curves[0], made.log, made.truth_network, made.truth, surface,
        batten.Cage([], []), batten.subdivide((made.truth.positions, made.truth.triangles), levels=0),
        batten.compare(surface, surface, samples=10),
    ]  # fmt: skip
    by_name = {type(sample).__name__: sample for sample in samples}
    for definition in tree.body:
        if isinstance(definition, ast.ClassDef) and definition.name in by_name:
            sample = by_name[definition.name]
            told = {n.target.id for n in definition.body if isinstance(n, ast.AnnAssign)}
            bases = [c.__name__ for c in type(sample).__mro__]
            for other in tree.body:
                if isinstance(other, ast.ClassDef) and other.name in bases:
                    told |= {n.target.id for n in other.body if isinstance(n, ast.AnnAssign)}
            assert told == {n for n in vars(sample) if n[0] != "_"}, definition.name


def test_everything_public_is_described():
    for name in batten.__all__:
        if name == "__version__":
            continue
        thing = getattr(batten, name)
        assert thing.__doc__ and thing.__doc__.strip().endswith((".", "]", "read_scan().")) or "----" in thing.__doc__, name
        if inspect.isfunction(thing) and name not in ("threads", "read_rawnet"):
            for parameter in inspect.signature(thing).parameters:
                assert re.search(rf"\b{parameter}\b", thing.__doc__), f"{name} does not describe {parameter}"
            assert "Raises" in thing.__doc__, name
        if inspect.isclass(thing):
            for member, value in vars(thing).items():
                if member[0] != "_" and (inspect.isfunction(value) or isinstance(value, property)):
                    assert value.__doc__, f"{name}.{member}"


TYPED = """
import numpy as np
import batten

mesh: batten.Mesh = batten.fair([[0.0, 0.0, 0.0]], [[0, 0, 0]], noise=0.1, progress=lambda stage, fraction: None)
other = batten.remesh(mesh, edge="2mm", sizes=np.ones(3))
V, F = other
found: float = batten.compare(mesh, (V, F), register="rigid").hausdorff
network = batten.network_from_scan(batten.read_rawnet("a.rawnet"), weights=(1.0, 100.0))
solver = batten.SurfaceSolver(network)
solver.move(network.positions, network.normals, reach="all")
try:
    batten.read_mesh("a.ply")
except batten.FileError as error:
    print(error.path, error.line)
"""
MISTYPED = """
import batten

batten.fair([[0.0]], [[0]], iterations="many")
batten.fair([[0.0]], [[0]], strength=1)
batten.reconstruct("scan.rawnet")
"""


def test_the_stub_satisfies_mypy(tmp_path):
    mypy = shutil.which("mypy", path="/usr/bin") or shutil.which("mypy")
    if mypy is None:
        pytest.skip("mypy is not installed: tools/setup python")
    (tmp_path / "typed.py").write_text(TYPED)
    (tmp_path / "mistyped.py").write_text(MISTYPED)
    # The package is looked at as one that is installed would be: by its stub and py.typed.
    package = pathlib.Path(batten.__file__).parent
    environment = {"MYPYPATH": str(package.parent), "PATH": "/usr/bin:/bin"}

    command = [mypy, "--strict", "--python-executable", sys.executable, "--cache-dir", tmp_path / "cache"]
    files = ["typed.py", "mistyped.py", STUB]  # at once: most of the time is for numpy's own stubs
    run = subprocess.run(
        [*command, *files], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    errors = re.findall(r"^(.*?):\d+: error: (.*)$", run.stdout, flags=re.MULTILINE)
    assert {file for file, _ in errors} == {"mistyped.py"}, run.stdout + run.stderr
    assert len(errors) == 3, run.stdout


def test_the_module_is_small_enough():
    size = pathlib.Path(batten._batten.__file__).stat().st_size / 1e6
    print(f"module: {size:.2f} MB")
    assert size <= 5.7  # 5.3 with all that the functions need; a room that slips in whole is seen


def test_the_package_in_the_build_folder_is_that_of_the_sources():
    sources = {p.name for p in (ROOT / "python" / "batten").iterdir() if p.suffix in (".py", ".pyi", ".typed")}
    built = {p.name for p in (BUILD / "python" / "batten").iterdir()}
    assert sources <= built


def test_the_file_for_other_build_tools_parses_and_names_what_there_is():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf8"))
    assert project["build-system"]["build-backend"] == "scikit_build_core.build"
    assert project["project"]["name"] == "batten"
    tool = project["tool"]["scikit-build"]
    for folder in tool["wheel"]["packages"]:
        assert (ROOT / folder / "__init__.py").exists()
    lists = (ROOT / "CMakeLists.txt").read_text(encoding="utf8")
    for define in tool["cmake"]["define"]:
        assert f"option({define} " in lists, define
    version = re.search(r"project\(batten VERSION (\S+)", lists)[1]
    assert version == batten.__version__
    pattern = tool["metadata"]["version"]
    found = re.search(project["tool"]["scikit-build"]["metadata"]["version"]["regex"], lists)
    assert found["value"] == version and pattern["input"] == "CMakeLists.txt"
    assert "version" in project["project"]["dynamic"]
