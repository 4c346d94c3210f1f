"""The options of every command, as the program itself lists them: read from `batten manual`, as man pages and completions are made."""

import functools
import os
import pathlib
import re
import subprocess
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(os.environ.get("BATTEN_PROGRAM", ROOT / "build" / "release" / "bin" / "batten"))

# The page of a command is docs/<command>.md but for these.
PAGES = {
    "replay": "capture",
    "track": "pen",
    "studio": "studio-server",
    "completion": "command-line",
    "manual": "command-line",
}
# What every command has, docs/command-line.md says once.
COMMON = {"--help", "--json", "--quiet", "--report", "--threads"}


class Option(NamedTuple):
    names: list  # "-o" and "--output"; of an argument its one name
    takes: str  # "curve|exact", "LENGTH"; empty for a switch
    meaning: str
    default: str
    required: bool
    argument: bool


def manual(*command):
    text = subprocess.run([PROGRAM, "manual", *command], capture_output=True, text=True, check=True).stdout
    for roff, plain in ((r"\-", "-"), (r"\(aq", "'"), (r"\&", ""), (r"\:", ""), (r"\e", "\\")):
        text = text.replace(roff, plain)
    return text


@functools.lru_cache(maxsize=None)
def commands():
    """The words that the program lists behind COMMANDS."""
    listed = manual().split(".SH COMMANDS\n")[1].split(".SH")[0]
    return re.findall(r"^\.B (\S+)$", listed, flags=re.MULTILINE)


def parsed(entry, argument):
    """An option from "-o, --output \\fITEXT\\fR" and the text below it."""
    head, _, text = entry.partition("\n")
    names, _, takes = head.partition(" \\fI")
    takes = takes.removesuffix("\\fR")
    # CLI11 writes the type, a colon and what is asked of the value; the latter tells more.
    kind, _, asked = takes.partition(":")
    takes = f"{kind} {asked.removeprefix(kind).strip()}".strip() if asked.startswith(kind) else asked or kind
    text = " ".join(text.split())
    required = text.endswith(" (required)")
    text = text.removesuffix(" (required)")
    default = ""
    if found := re.search(r" \[(\S+)\]$", text):
        default, text = found[1], text[: found.start()]
    return Option(names.split(", "), takes.lower(), text, "" if default == "[]" else default, required, argument)


@functools.lru_cache(maxsize=None)
def options_of(command):
    """Of "rig" or "remesh": the words of each command that does work, with its arguments and options."""
    found = {}
    words, argument = command, False
    for part in re.split(r"^\.S[HS] ", manual(command), flags=re.MULTILINE)[1:]:
        title, _, body = part.partition("\n")
        if title.startswith(command + " "):
            words = title
        if title.lower() in ("arguments", "options"):
            argument = title.lower() == "arguments"
            entries = re.split(r"^\.TP\n\.B ", body, flags=re.MULTILINE)[1:]
            found.setdefault(words, []).extend(parsed(entry, argument) for entry in entries)
    return found


def page_of(command):
    return f"{PAGES.get(command, command)}.md"


def cell(text):
    return text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*").replace("_", "\\_")


def table(command):
    """A table in Markdown for each command that does work: what it takes, with defaults."""
    lines = []
    for words, options in options_of(command).items():
        lines += [f"## Every option of `batten {words}`", "", "| option | takes | meaning | default |", "|---|---|---|---|"]
        for option in options:
            names = ", ".join(f"`{name}`" for name in option.names)
            default = "required" if option.required else f"`{option.default}`" if option.default else ""
            lines.append(f"| {names} | {cell(option.takes)} | {cell(option.meaning)} | {default} |")
        lines.append("")
    return "\n".join(lines)
