"""The blocks of the documents that a reader would copy."""

import os
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(os.environ.get("BATTEN_PROGRAM", ROOT / "build" / "release" / "bin" / "batten"))
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").rglob("*.md")])


def name_of(page):
    return page.relative_to(ROOT).as_posix()


def fenced(page, language):
    """The blocks between ```language and ```."""
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf8"), flags=re.DOTALL | re.MULTILINE)


def indented_commands(page):
    """The lines of blocks set off by four blanks that call the program, continued lines joined."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf8"), flags=re.DOTALL | re.MULTILINE)
    text = text.replace("\\\n", " ")
    return re.findall(r"^ {4}((?:\S+ .*\| )?batten .*)$", text, flags=re.MULTILINE)
