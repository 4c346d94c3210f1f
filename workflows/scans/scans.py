#!/usr/bin/env python3
"""One scan after another: simulated where a table says so, reconstructed, compared with the truth; then all of them as a table.

usage: scans.py list INPUT                              the names of all scans
       scans.py run INPUT OUTPUT [NAME...] [options]     some scans, or all
       scans.py table INPUT OUTPUT                       scores.csv and index.html of what has been run
What has a row, made by the same program with the same options, is not run again. A scan that cannot be reconstructed is a row with
the program's sentence. Only what says nothing of the scan ends a run: a program that is not there, is killed or does not know an option.
"""

import argparse
import base64
import csv
import html
import json
import os
import pathlib
import shlex
import subprocess
import sys

# Columns of scores.csv: no times, so that the same scans give the same bytes wherever they are run.
COUNTS = ["curves", "nodes", "vertices", "faces", "genus", "watertight", "boundary_loops"]
DISTANCES = ["mean", "rms", "max"]  # of the surface from the truth, % of the diameter
COLUMNS = ["name", "status", *COUNTS, *(f"{which}_percent" for which in DISTANCES), "sentence"]
TRUTHS = [".truth.ply", ".truth.obj", ".truth.json", ".truth.net"]


def scans_of(source):
    """Name to what is known of a scan: its file, or the row of a table of simulations."""
    source = pathlib.Path(source)
    if source.is_dir():
        files = sorted(path for path in source.iterdir() if path.suffix in (".rawnet", ".csv"))
        found = [(path.stem, path) for path in files]
    elif source.suffix == ".csv":
        with source.open(encoding="utf8", newline="") as table:
            found = [(row["name"], row) for row in csv.DictReader(table)]
    else:
        sys.exit(f"{source} is neither a folder of scans nor a table of simulations (.csv)")
    names = [name for name, _ in found]
    for name in names:
        if names.count(name) > 1 or not name or set(name) & set("/ "):
            sys.exit(f"{source}: the name {name!r} of a scan has to be there once, without blanks and slashes")
    if not found:
        sys.exit(f"{source} holds no scan: .rawnet and .csv files are looked for, or the rows of a table")
    return dict(found)


class Failed(Exception):
    """What the program says of a scan, in a sentence."""


def batten(program, *arguments):
    """The object of --json."""
    run = subprocess.run([program, *map(str, arguments), "--json"], capture_output=True, text=True, check=False)
    if run.returncode in (1, 3):  # the work or the input: docs/command-line.md
        error = json.loads(run.stdout).get("error") or {}
        raise Failed(error.get("message") or "; ".join(json.loads(run.stdout).get("flaws", [])) or run.stderr.strip())
    if run.returncode != 0:
        sys.exit(f"batten {shlex.join(map(str, arguments))} ended with {run.returncode}: {run.stdout}{run.stderr}")
    return json.loads(run.stdout)


def simulated(program, row, scan, truth):
    """Writes the scan that a row of a table describes: its object, and columns that are options of batten simulate."""
    options = []
    for column, value in row.items():
        if column not in ("name", "object") and value:
            options += [f"--{column}", value]
    batten(program, "simulate", row["object"], "-o", scan, "--truth", truth, *options)


def run_scan(name, known, output, program, options):
    """The row of one scan; its mesh and picture are written on the way."""
    scans, meshes, pictures = (output / folder for folder in ("scans", "meshes", "pictures"))
    mesh, picture = meshes / f"{name}.ply", pictures / f"{name}.png"
    row = dict.fromkeys(COLUMNS, "")
    row.update(name=name, status="ok")
    try:
        if isinstance(known, dict):
            scans.mkdir(parents=True, exist_ok=True)
            scan, truth = scans / f"{name}.rawnet", scans / f"{name}.truth.ply"
            simulated(program, known, scan, truth)
        else:
            scan = known
            truth = next((path for end in TRUTHS if (path := known.with_suffix(end)).exists()), None)
        meshes.mkdir(parents=True, exist_ok=True)
        figures = batten(program, "reconstruct", scan, "-o", mesh, *shlex.split(options))
        row.update({column: figures.get(column, "") for column in COUNTS})
        pictures.mkdir(parents=True, exist_ok=True)
        batten(program, "render", mesh, "-o", picture, "--shading", "isophotes", "--size", "240x180")
        if truth:
            found = batten(program, "compare", mesh, truth, "--register", "rigid", "--samples", 20000)
            distances = found["relative"]["a_to_b"]
            row.update({f"{which}_percent": f"{100 * distances[which]:.6g}" for which in DISTANCES})
    except Failed as failure:
        row.update(status="failed", sentence=" ".join(str(failure).split()))
    return row


def write_whole(path, text):
    """Puts the file in its place when it is whole: what is killed leaves none."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    part.write_text(text, encoding="utf8")
    part.replace(path)


def row_file(output, name):
    return output / "rows" / f"{name}.json"


def is_done(path, known, made_of):
    """Whether a row is that of the scan as it is."""
    if not path.exists() or json.loads(path.read_text(encoding="utf8"))["of"] != made_of:
        return False
    return isinstance(known, dict) or path.stat().st_mtime_ns > known.stat().st_mtime_ns


def run_all(names, known, given):
    """A row for each of the scans that have none."""
    version = subprocess.run([given.batten, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    for name in names:
        path = row_file(given.output, name)
        made_of = {"scan": known[name] if isinstance(known[name], dict) else str(known[name]), "options": given.options, "program": version}
        if not is_done(path, known[name], made_of):
            row = run_scan(name, known[name], given.output, given.batten, given.options)
            write_whole(path, json.dumps({"of": made_of, "row": row}) + "\n")


def page_of(rows, output):
    """One page with all scans, the pictures in it."""
    body = []
    for row in rows:
        picture = output / "pictures" / f"{row['name']}.png"
        shown = ""
        if row["status"] == "ok" and picture.exists():
            shown = f'<img alt="" src="data:image/png;base64,{base64.b64encode(picture.read_bytes()).decode()}">'
        cells = "".join(f"<td>{html.escape(str(row[column]))}</td>" for column in COLUMNS)
        body.append(f'<tr class="{row["status"]}"><td>{shown}</td>{cells}</tr>')
    failed = sum(row["status"] != "ok" for row in rows)
    head = "".join(f"<th>{column.replace('_percent', ', %')}</th>" for column in ["", *COLUMNS])
    return f"""<!DOCTYPE html>
<html lang="en"><meta charset="utf-8"><title>{len(rows)} scans</title>
<style>body {{font: 15px sans-serif; margin: 2em}} td, th {{padding: .3em .6em; text-align: left; border-bottom: 1px solid #ccc}}
table {{border-collapse: collapse}} .failed {{background: #fdecea}} img {{width: 120px}}</style>
<h1>{len(rows)} scans, {failed} failed</h1>
<p>Distances are those of the surface from the truth, in per cent of its diameter.</p>
<table><tr>{head}</tr>
{chr(10).join(body)}
</table></html>
"""


def write_table(names, output):
    rows = []
    for name in names:
        path = row_file(output, name)
        if not path.exists():
            sys.exit(f"{name} has not been run: there is no {path}")
        rows.append(json.loads(path.read_text(encoding="utf8"))["row"])
    lines = [",".join(COLUMNS)]
    for row in rows:
        lines.append(",".join('"' + str(row[c]).replace('"', '""') + '"' if c == "sentence" else str(row[c]) for c in COLUMNS))
    write_whole(output / "scores.csv", "\n".join(lines) + "\n")
    write_whole(output / "index.html", page_of(rows, output))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    actions = parser.add_subparsers(dest="action", required=True)
    parts = {name: actions.add_parser(name) for name in ("list", "run", "table")}
    for part in parts.values():
        part.add_argument("input")
    for name in ("run", "table"):
        parts[name].add_argument("output", type=pathlib.Path)
    parts["run"].add_argument("names", nargs="*", help="all, when left out")
    parts["run"].add_argument("--batten", default="batten", help="the program")
    parts["run"].add_argument("--options", default="", help="of batten reconstruct")
    parts["run"].add_argument("--part", default="0/1", help="I/N: every N-th scan, from the I-th on")
    given = parser.parse_args()

    known = scans_of(given.input)
    if given.action == "list":
        print("\n".join(known))
    elif given.action == "table":
        write_table(known, given.output)
    else:
        part, n_parts = map(int, given.part.split("/"))
        run_all(given.names or list(known)[part::n_parts], known, given)


if __name__ == "__main__":
    main()
