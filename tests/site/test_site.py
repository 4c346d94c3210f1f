"""The site that tools/build site has made: complete, without another host, with no link that leads nowhere."""

import html.parser
import pathlib
import re
import urllib.parse

import pytest
from documents import PAGES, ROOT, name_of

SITE = ROOT / "build" / "site"
needs_site = pytest.mark.skipif(not (SITE / "index.html").exists(), reason="the site is not built: tools/build site")


class Page(html.parser.HTMLParser):
    """What a page loads, where it leads, and the places in it."""

    def __init__(self, path):
        super().__init__()
        self.loads, self.links, self.anchors = [], [], {""}
        self.feed(path.read_text(encoding="utf8"))

    def handle_starttag(self, tag, attributes):
        of = dict(attributes)
        self.anchors |= {of[key] for key in ("id", "name") if of.get(key)}
        if tag == "a" and of.get("href"):
            self.links.append(of["href"])
        elif tag == "link" and of.get("rel") not in ("canonical",) and of.get("href"):
            self.loads.append(of["href"])
        elif tag != "a" and of.get("src"):
            self.loads.append(of["src"])


@pytest.fixture(scope="module")
def pages():
    return {path: Page(path) for path in SITE.rglob("*.html")}


def is_elsewhere(address):
    return re.match(r"(https?:)?//", address) is not None


@needs_site
def test_no_page_loads_anything_from_another_host(pages):
    assert len(pages) > 300
    for path, page in pages.items():
        for address in page.loads:
            assert not is_elsewhere(address), f"{path.relative_to(SITE)} loads {address}"
    for path in SITE.rglob("*.css"):
        for address in re.findall(r"(?:url\(|@import)\s*[\"']?([^\"')\s]+)", path.read_text(encoding="utf8")):
            assert not is_elsewhere(address), f"{path.relative_to(SITE)} loads {address}"
    # The theme loads Mermaid from another host where a page has a drawing in that language.
    assert not any('class="mermaid"' in path.read_text(encoding="utf8") for path in pages)


@needs_site
def test_every_link_of_the_documents_leads_somewhere(pages):
    n = 0
    for path, page in pages.items():
        if "api" in path.relative_to(SITE).parts[:1]:
            continue  # Doxygen's own; what it could not resolve is a warning of its run
        for link in page.links + page.loads:
            address = urllib.parse.urlsplit(link)
            if address.scheme or address.netloc:
                continue
            if path.name == "404.html":
                continue  # its links are those of the root of a server
            target = (path.parent / urllib.parse.unquote(address.path)).resolve() if address.path else path
            assert target.exists(), f"{path.relative_to(SITE)} links to {link}"
            n += 1
            if address.fragment and target.suffix == ".html":
                assert urllib.parse.unquote(address.fragment) in pages[target].anchors, f"{path.relative_to(SITE)} links to {link}"
    assert n > 1000


@needs_site
def test_pages_of_commands_have_the_options_of_the_program():
    assert "Every option of <code>batten remesh</code>" in (SITE / "remesh.html").read_text(encoding="utf8")
    assert "Every option of <code>batten rig wand</code>" in (SITE / "rig.html").read_text(encoding="utf8")


@needs_site
def test_tables_lists_and_drawings_are_drawn():
    for path in SITE.glob("*.html"):
        text = re.sub(r"<(pre|code|svg)\b.*?</\1>", "", path.read_text(encoding="utf8"), flags=re.DOTALL)
        assert not re.search(r"^\|.*\|$|<p>[-*] |\n[-*] \S", text, flags=re.MULTILINE), f"{path.name} shows a table or list as text"
    assert "<svg" in (SITE / "architecture.html").read_text(encoding="utf8").split('class="drawing"')[1][:400]


def test_the_readme_is_short_and_begins_with_a_picture_two_commands_and_three_links():
    text = (ROOT / "README.md").read_text(encoding="utf8")
    assert text.count("\n") <= 120
    first = text[: text.index("\n- ")]
    assert len(re.findall(r"!\[[^\]]*\]\(", first)) == 1
    assert len(re.findall(r"^\./", first, flags=re.MULTILINE)) == 2
    assert len(re.findall(r"(?<!!)\[[^\]]*\]\(", first)) == 3


@pytest.mark.parametrize("page", [page for page in PAGES if "tutorials" in page.parts], ids=name_of)
def test_a_tutorial_fits_on_two_screens_and_has_a_picture(page):
    text = page.read_text(encoding="utf8")
    assert text.count("\n") <= 85
    pictures = re.findall(r"!\[[^\]]*\]\(([^)]*)\)", text)
    assert pictures
    for picture in pictures:
        assert (page.parent / picture).stat().st_size > 5000
