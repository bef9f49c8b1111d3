"""The site of the documentation: it is built strictly, and opens without a network."""

import importlib
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
API = sorted((ROOT / "docs" / "reference" / "api").glob("*.md"))


def build(folder):
    """Build the site of the checkout ``folder``; the process's result."""
    return subprocess.run([sys.executable, "-m", "mkdocs", "build"], cwd=folder,
                          env=os.environ | {"NO_MKDOCS_2_WARNING": "1"}, text=True,
                          capture_output=True)


@pytest.fixture
def checkout(tmp_path):
    """A copy of what the site is made of."""
    pytest.importorskip("material", reason="pip install 'ncdc[docs]'")
    shutil.copy(ROOT / "mkdocs.yml", tmp_path)
    shutil.copytree(ROOT / "docs", tmp_path / "docs")
    for folder in ("model", "host", "ncdc_hdl"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    return tmp_path


@pytest.mark.longer
def test_the_site_is_built_and_loads_nothing_from_the_network(checkout):
    done = build(checkout)
    assert not done.returncode, done.stderr
    site = checkout / "build" / "site"
    pages = [path.read_text() for path in site.rglob("*.html")]
    assert len(pages) > 60
    loaded = re.compile(r"<(?:script|img|iframe)[^>]*\bsrc=\"?(?:https?:)?//"
                        r"|<link[^>]*stylesheet[^>]*href=\"?(?:https?:)?//")
    assert not any(map(loaded.search, pages))
    assert not any('class="mermaid"' in page for page in pages)     # its program would be loaded
    found = json.loads((site / "search" / "search_index.json").read_text())["docs"]
    assert any("tan-sigmoid" in entry["text"] for entry in found)
    assert (site / "search" / "search_index.js").is_file()      # for pages opened from disk


@pytest.mark.longer
@pytest.mark.parametrize("page,planted", [
    ("index.md", "\n[dead](start/tutorial.md#none)\n"),
    ("index.md", "\n![loaded](https://example.org/picture.png)\n"),
    *(pytest.param(*fault, marks=pytest.mark.regress) for fault in (
        ("index.md", "\n[dead](start/none.md)\n"),
        ("start/none.md", "# A page that no menu names\n"),
        ("reference/api/client.md", "\n::: ncdc_host.client.none\n")))],
    ids=["anchor", "network", "page", "menu", "name"])
def test_a_planted_fault_ends_the_build(checkout, page, planted):
    with open(checkout / "docs" / page, "a") as text:
        text.write(planted)
    assert build(checkout).returncode


def test_every_page_is_in_the_menu():
    """Without MkDocs; with it the strict build says so."""
    named = re.findall(r"^ +- .*?: ([\w/]+\.md)$", (ROOT / "mkdocs.yml").read_text(), re.MULTILINE)
    docs = ROOT / "docs"
    assert sorted(named) == sorted(str(path.relative_to(docs)) for path in docs.rglob("*.md"))


@pytest.mark.parametrize("page", API, ids=lambda page: page.stem)
def test_names_of_the_python_pages_exist(page):
    names = re.findall(r"^::: ([\w.]+)$", page.read_text(), re.MULTILINE)
    assert names
    for name in names:
        module, _, member = name.rpartition(".")
        assert getattr(importlib.import_module(module), member).__doc__
