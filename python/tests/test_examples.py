"""The examples and the blocks of docs/python.md run."""

import os
import pathlib
import re
import runpy
import shutil

import matplotlib
import pytest
from conftest import ROOT

EXAMPLES = sorted((ROOT / "python" / "examples").glob("*.py"))


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """In a folder of its own, with the sample scan and without a screen."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(ROOT / "data" / "sample.rawnet", tmp_path)
    (tmp_path / "data").mkdir()
    shutil.copy(ROOT / "data" / "sample.rawnet", tmp_path / "data")
    matplotlib.use("Agg")
    yield
    matplotlib.pyplot.close("all")


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_run_and_draw(path, tmp_path):
    text = path.read_text(encoding="utf8")
    assert text.count("# %%") >= 3, "an example is a notebook of cells"
    runpy.run_path(str(path), run_name="__main__")
    pictures = list(tmp_path.glob("*.png"))
    assert pictures, "no picture was drawn"
    for picture in pictures:
        assert picture.stat().st_size > 5000


def test_there_are_five():
    assert len(EXAMPLES) >= 5


@pytest.mark.parametrize("document, least", [("docs/python.md", 6), ("README.md", 1)])
def test_the_blocks_of_documents_run_one_after_the_other(document, least):
    text = (ROOT / document).read_text(encoding="utf8")
    blocks = re.findall(r"^```python\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)
    assert len(blocks) >= least
    names = {"__name__": "document"}
    for number, block in enumerate(blocks):
        exec(compile(block, f"{document}, block {number + 1}", "exec"), names)


def test_the_document_and_the_readme_name_every_function():
    import batten

    text = (ROOT / "docs" / "python.md").read_text(encoding="utf8")
    for name in batten.__all__:
        if name != "__version__":
            assert re.search(rf"\b{name}\b", text), f"docs/python.md does not name {name}"
    for example in EXAMPLES:
        assert example.name in text, example.name
