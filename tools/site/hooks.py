"""What MkDocs does to the pages on their way to the site (mkdocs.yml).

The pages are written to be read in the repository: links go to files of it, headings are named as GitHub names them, drawings are
Mermaid. Here links to what lies outside docs/ are given a place in the site, lists get the empty line that Python's Markdown
wants, drawings become pictures (Mermaid would be loaded from another host), and pages of commands get the program's own options.
"""

import html
import logging
import os
import pathlib
import re
import subprocess
import sys

from mkdocs.structure.files import File

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import options  # noqa: E402

ROOT = options.ROOT
OUTSIDE = "source/"  # where files of the repository go that pages link to
API = ROOT / "build" / "api" / "html"  # what Doxygen has made
log = logging.getLogger("mkdocs.batten")  # a warning ends a strict build
placed = {}  # place in the site, of what comes from outside docs/ -> path in the repository


def slug(heading, separator="-"):
    """The name of a heading in links, as GitHub makes it and tests/docs holds links against."""
    heading = re.sub(r"[^\w\- ]", "", html.unescape(re.sub(r"<[^>]*>", "", heading)).strip())
    return heading.lower().replace(" ", separator)


def repository_path(src_path):
    """Where a page of the site stands in the repository."""
    return placed.get(src_path, f"docs/{src_path}")


def place_of(path):
    """Where a file of the repository stands in the site."""
    if path.startswith("docs/"):
        return path.removeprefix("docs/")
    return path if path.endswith(".md") and "/" not in path else OUTSIDE + path


def links_of(text):
    return re.findall(r"\]\(([^()\s:#]+)(?:#[^()\s]*)?\)", text)


def listing(folder):
    """A page that lists a folder of the repository."""
    rows = "\n".join(f"- [{path.name}]({path.name})" for path in sorted(folder.iterdir()) if path.is_file())
    return f"# {folder.relative_to(ROOT)}\n\n{rows}\n"


def on_config(config):
    config["mdx_configs"]["toc"]["slugify"] = slug
    return config


def on_files(files, config):
    """Adds the pages of the root, what pages link to outside docs/, and the reference of the library."""

    def add(path, place=None, source=None):
        """A file of the repository, at its place in the site; with `source`, from there."""
        place = place or place_of(path)
        if place in placed:
            return
        placed[place] = path
        source = source or ROOT / path
        file = File(place, str(source.parent), config["site_dir"], False)
        file.abs_src_path = str(source)
        files.append(file)
        if place.endswith(".md"):
            add_linked(path, source)

    def add_linked(path, source):
        for link in links_of(source.read_text(encoding="utf8")):
            target = os.path.normpath(os.path.join(os.path.dirname(path), link))
            if target.startswith(("docs/", "..")):
                continue
            if (ROOT / target).is_dir():
                made = ROOT / "build" / "site.listings" / target / "index.md"
                made.parent.mkdir(parents=True, exist_ok=True)
                made.write_text(listing(ROOT / target), encoding="utf8")
                add(f"{target}/index.md", source=made)
            elif (ROOT / target).is_file():
                add(target)

    for file in files.documentation_pages():
        add_linked(f"docs/{file.src_path}", ROOT / "docs" / file.src_path)
    for page in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md"):
        add(page)
    add("tools/site/api.md", place="api.md")
    for path in sorted(API.rglob("*")):
        if path.is_file():
            add(f"api/{path.relative_to(API)}", place=f"api/{path.relative_to(API)}", source=path)
    return files


def on_nav(nav, config, files):
    listed = {page.file.src_path for page in nav.pages}
    for file in files.documentation_pages():
        if not file.src_path.startswith(OUTSIDE) and file.src_path not in listed:
            log.warning("mkdocs.yml has no place for the page %s", file.src_path)
    return nav


def with_links_of_the_site(text, page):
    here = repository_path(page)

    def moved(match):
        link, anchor = match[1], match[2] or ""
        target = os.path.normpath(os.path.join(os.path.dirname(here), link))
        place = place_of(target)
        if (ROOT / target).is_dir():
            place = f"{place}/index.md"
        return f"]({os.path.relpath(place, os.path.dirname(page) or '.')}{anchor})"

    return re.sub(r"\]\(([^()\s:#]+)(#[^()\s]*)?\)", moved, text)


def with_drawings(text):
    """Flowcharts as pictures, drawn by Graphviz."""

    def drawn(match):
        direction, body = match[1], match[2]
        graph = [f"digraph {{ rankdir={direction}; bgcolor=transparent; node [shape=box, style=rounded]; edge [arrowsize=0.6];"]
        for line in body.splitlines():
            names = []
            for name, label in re.findall(r"(\w+)(?:\[([^\]]*)\])?(?= *(?:-->|$))", line.strip()):
                names.append(f'"{name}"')
                if label:
                    graph.append(f'"{name}" [label="{label}"];')
            said = re.search(r"-->\|([^|]*)\|", line)
            if said:
                target = re.search(r"\| *(\w+)(?:\[([^\]]*)\])?", line[said.start() + 4 :])
                source = re.match(r" *(\w+)", line)
                names = [f'"{source[1]}"', f'"{target[1]}"']
                if target[2]:
                    graph.append(f'"{target[1]}" [label="{target[2]}"];')
            attributes = f' [label="{said[1]}"]' if said else ""
            graph.append(" -> ".join(names) + attributes + ";")
        graph.append("}")
        svg = subprocess.run(["dot", "-Tsvg"], input="\n".join(graph), capture_output=True, text=True, check=True).stdout
        return f'<div class="drawing">{svg[svg.index("<svg"):]}</div>\n'

    return re.sub(r"^```mermaid\nflowchart (\w\w)\n(.*?)^```\n", drawn, text, flags=re.DOTALL | re.MULTILINE)


def with_spaced_lists(text):
    """Python's Markdown begins a list after an empty line only, and nests what is indented by four."""
    lines, fenced, in_list = [], False, False
    for line in text.split("\n"):
        if line.startswith("```"):
            fenced = not fenced
        item = re.match(r"( {0,3})([-*]|\d+\.) ", line)
        if not fenced and item and not in_list and lines and lines[-1].strip():
            lines.append("")
        if item:
            in_list = True
        elif not line.strip() or not line.startswith(" "):
            in_list = False
        lines.append(line)
    return "\n".join(lines)


def on_page_markdown(text, page, config, files):
    src = page.file.src_path
    text = with_links_of_the_site(text, src)
    text = with_drawings(with_spaced_lists(text))
    for command in options.commands():
        if options.page_of(command) == src:
            text += "\n" + options.table(command)
    return text
