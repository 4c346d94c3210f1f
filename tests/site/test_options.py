"""The tables of options in the documents, held against the program."""

import re
import sys

import pytest
from documents import PROGRAM, ROOT

sys.path.insert(0, str(ROOT / "tools" / "site"))
import options  # noqa: E402

pytestmark = pytest.mark.skipif(not PROGRAM.exists(), reason=f"the program is not built: {PROGRAM}")

# Pages on which one command tells of another, beside those of options.PAGES.
ALSO_TOLD = {"pen": ["simulate"], "reconstruct": [], "rig": []}
# Their options stand on the pages that theirs link to.
LINKED = {"reconstruct": ["network", "surface"], "simulate": ["pen"], "network": ["files"], "capture": ["pen"]}


def page(name):
    return (ROOT / "docs" / f"{name}.md").read_text(encoding="utf8")


def commands_of(name):
    return [c for c in options.commands() if options.page_of(c) == f"{name}.md"] + ALSO_TOLD.get(name, [])


def program_options(commands):
    return [o for c in commands for each in options.options_of(c).values() for o in each if not o.argument]


PAGES = sorted({options.page_of(c).removesuffix(".md") for c in options.commands()} - {"command-line"}) if PROGRAM.exists() else []


def rows(name):
    """Rows of the tables whose first column is headed "option": the names in the first cell, and the cell below "default"."""
    header = None
    for line in page(name).splitlines():
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        if not cells:
            header = None
        elif header is None:
            header = cells
        elif header[0] == "option" and not set(cells[0]) <= set("-:"):
            names = re.findall(r"(?<![\w-])--?[a-z][a-z-]*", " ".join(re.findall(r"`([^`]*)`", cells[0])))
            yield names, cells[header.index("default")] if "default" in header else ""


@pytest.mark.parametrize("name", PAGES)
def test_a_table_has_only_options_that_the_program_has(name):
    known = {n for o in program_options(commands_of(name)) for n in o.names}
    n = 0
    for names, _ in rows(name):
        for each in names:
            n += 1
            assert each in known, f"docs/{name}.md: batten {name} has no {each}"
    assert n or name in ("info",)


@pytest.mark.parametrize("name", PAGES)
def test_a_table_has_the_defaults_of_the_program(name):
    defaults = {}
    for option in program_options(commands_of(name)):
        for each in option.names:
            defaults.setdefault(each, set()).add(option.default)
    for names, said in rows(name):
        said = re.findall(r"^`?([^`\s]+)`?$", said)
        for each in names:
            if said and said[0] not in ("off", "–", "required", "all", "text") and defaults[each] != {""}:
                assert said[0] in defaults[each], f"docs/{name}.md: {each} is {defaults[each]} by default, not {said[0]}"


@pytest.mark.parametrize("name", PAGES)
def test_a_page_names_every_option(name):
    text = "".join(page(each) for each in [name, *LINKED.get(name, [])])
    own = [c for c in options.commands() if options.page_of(c) == f"{name}.md"]
    for option in program_options(own):
        if not set(option.names) & (options.COMMON | {"--output"}):
            assert any(re.search(rf"{re.escape(each)}(?![\w-])", text) for each in option.names), f"docs/{name}.md does not name {option.names}"
