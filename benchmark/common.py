"""What the programs of the benchmark share: their options, the cases and the tools."""

import argparse
import json
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
DATA = ROOT.parent / "shared" / "data"


def arguments(usage, *more):
    """The options --cases, --build and --batten, and `more`: names and keywords of add_argument()."""
    parser = argparse.ArgumentParser(description=usage, formatter_class=argparse.RawDescriptionHelpFormatter)
    for names, keywords in more:
        parser.add_argument(*names, **keywords)
    parser.add_argument("--cases", type=lambda text: text.split(","), help="some of the cases, joined by commas")
    built = ROOT / "build"
    parser.add_argument("--build", type=pathlib.Path, default=built / "benchmark", help="folder of cases and results")
    parser.add_argument("--batten", type=pathlib.Path, default=built / "release" / "bin" / "batten", help="the program")
    options = parser.parse_args()
    options.build, options.batten = options.build.resolve(), options.batten.resolve()
    if not options.batten.exists():
        sys.exit(f"{options.batten} is not built; run tools/build release batten_program, or give --batten PROGRAM")
    return options


def definitions(names=None):
    """The cases of cases.json, all or those named."""
    cases = json.loads((HERE / "cases.json").read_text())
    known = [case["name"] for case in cases]
    unknown = [name for name in names or [] if name not in known]
    if unknown:
        sys.exit(f"there is no case '{unknown[0]}'; there are {', '.join(known)}")
    return [case for case in cases if names is None or case["name"] in names]


def tools(names=None):
    """The tools of tools/*.json, by name."""
    found = {path.stem: json.loads(path.read_text()) for path in sorted((HERE / "tools").glob("*.json"))}
    for name in names or []:
        if name not in found:
            sys.exit(f"there is no tool '{name}'; there are {', '.join(found)}")
    return {name: tool for name, tool in found.items() if not names or name in names}


def has_data(file):
    """The path of public data, or None where it is missing."""
    path = DATA / file
    return path if path.exists() else None
