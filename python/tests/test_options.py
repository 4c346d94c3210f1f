"""The options have the names, defaults and words of the command line."""

import pytest
from conftest import help_of_program, keywords_of, options_of_program

import batten

# What the command line does with files and terminals, which have other names here: paths are arguments of
# read_... and write_..., STEP is written by the program alone.
FILES = {"help", "json", "quiet", "report", "threads", "output"}
CAD = {"step_tolerance", "max_patches", "unit"}
READING = {"calibration", "columns"}  # of read_scan()

COMMANDS = {
    "repair": (batten.repair, FILES, {"progress"}),
    "fair": (batten.fair, FILES, {"progress"}),
    "remesh": (batten.remesh, FILES, {"progress"}),
    "simplify": (batten.simplify, FILES, {"progress"}),
    "deform": (batten.deform, FILES, {"progress"}),
    "subdivide": (batten.subdivide, FILES | {"step"} | CAD - {"max_patches"}, {"progress"}),
    "compare": (batten.compare, FILES | {"distances"}, {"progress"}),
    "check": (batten.check, FILES | {"network", "pictures"}, {"progress"}),
    "surface": (batten.surface, FILES | CAD | {"write_network"}, {"progress"}),
    "network": (batten.network_from_scan, FILES | READING | {"numbered"}, {"progress"}),
    "reconstruct": (batten.reconstruct, FILES | CAD | READING | {"network", "numbered"}, {"progress"}),
    "simulate": (batten.simulate, FILES, {"progress"}),
}
# Arrays and objects stand where the command line names a file.
OBJECTS = {"handles", "against", "truth", "truth_network", "tumble", "sizes", "keep_all_levels"}


@pytest.mark.parametrize("command", COMMANDS)
def test_names_are_those_of_the_command_line(command):
    function, left_out, more = COMMANDS[command]
    assert set(keywords_of(function)) - more == set(options_of_program(command)) - left_out


def same(ours, theirs):
    """Whether a default is the one that --help shows."""
    if isinstance(ours, bool):
        return ours is bool(theirs)
    if ours is None:
        return theirs == ""
    if isinstance(ours, str):
        return ours == theirs
    return float(ours) == float(theirs)


@pytest.mark.parametrize("command", COMMANDS)
def test_defaults_are_those_of_the_command_line(command):
    function, left_out, more = COMMANDS[command]
    theirs = options_of_program(command)
    for name, default in keywords_of(function).items():
        if name in more or name in OBJECTS:
            continue
        assert same(default, theirs[name]), f"{name}: {default!r} here, {theirs[name]!r} there"


@pytest.mark.parametrize("command", COMMANDS)
def test_defaults_are_those_of_the_compiled_part(command):
    function, _, more = COMMANDS[command]
    ours = keywords_of(function)
    for name, default in batten._batten.default_options(command).items():
        assert name in ours, name
        if isinstance(default, str) and not isinstance(ours[name], str):
            assert float(default) == ours[name], name  # a number may stand for its text
        else:
            assert ours[name] == default, name
    assert set(ours) - more - OBJECTS <= set(batten._batten.default_options(command))


def words_of(command, option):
    """The words that --help lists in braces for an option."""
    line = next(line for line in help_of_program(command).splitlines() if line.lstrip().startswith(f"--{option.replace('_', '-')} "))
    return line[line.index("{") + 1 : line.index("}")].split(",")


@pytest.mark.parametrize(
    "command, option",
    [
        ("fair", "method"),
        ("remesh", "method"),
        ("remesh", "keep_border"),
        ("simplify", "method"),
        ("simplify", "weight"),
        ("simplify", "keep_border"),
        ("deform", "energy"),
        ("deform", "nonlinear"),
        ("subdivide", "corners"),
        ("compare", "register"),
        ("check", "continuity"),
        ("surface", "method"),
        ("surface", "constraints"),
        ("surface", "map"),
        ("surface", "crossings"),
        ("surface", "topology"),
        ("surface", "closed"),
        ("surface", "symmetry"),
        ("network", "energy"),
        ("network", "robust"),
        ("network", "scheme"),
        ("network", "nodes"),
        ("network", "lengths"),
        ("simulate", "nodes"),
    ],
)
def test_words_are_those_of_the_command_line(command, option):
    function = COMMANDS[command][0]
    words = words_of(command, option)
    assert len(words) > 1
    for word in words:
        assert f'"{word}"' in function.__doc__, f"the docstring of {command} does not name {word}"
    empty = batten.Mesh([], [])
    first = {
        "deform": dict(V=empty, handles={}),
        "subdivide": dict(cage=([], [])),
        "compare": dict(A=empty, B=empty),
        "check": dict(surface=empty, network=batten.Network([], [])),
        "surface": dict(network=batten.Network([], [])),
        "network": dict(scan=batten.Scan([])),
        "simulate": dict(object="torus"),
        "simplify": dict(V=empty, faces=3),
    }.get(command, dict(V=empty))
    # An unknown word is refused before anything else is looked at.
    with pytest.raises(batten.InvalidInput, match="no-such-word"):
        function(**first, **{option: "no-such-word"})
