"""The site builds with its warnings as errors, without a network, and everything that its pages
point to is there.
"""

import inspect
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit
from xml.etree import ElementTree

import pytest

import cyclemap as cm
from cyclemap.cli.main import cli

pytestmark = pytest.mark.slow

DOCS = Path(__file__).parents[2] / "docs"
# What a page loads by itself; `a` only leads somewhere.
LOADS = {"img": "src", "script": "src", "link": "href", "source": "src", "iframe": "src"}


class PageReader(HTMLParser):
    """Anchors, links and loaded files of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if tag in LOADS and LOADS[tag] in given:
            self.loads.append(given[LOADS[tag]])


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """The site, built as `python3 run.py docs` does, but elsewhere; Sphinx has nothing to say."""
    folder = tmp_path_factory.mktemp("site")
    options = ["-W", "--keep-going", "-q", "-E", "-d", str(folder / "doctrees")]
    command = [sys.executable, "-m", "sphinx", *options, str(DOCS), str(folder / "html")]
    # Nothing listens at this address: a build that asks the network for something fails.
    blocked = dict.fromkeys(("https_proxy", "http_proxy", "all_proxy"), "127.0.0.1:9")
    env = {**os.environ, **blocked, "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(command, cwd=DOCS.parent, capture_output=True, text=True, env=env)
    assert (done.returncode, done.stderr) == (0, ""), f"the site does not build:\n{done.stderr}"
    return folder / "html"


@pytest.fixture(scope="module")
def pages(site) -> dict[Path, PageReader]:
    """Every page, read."""
    found = sorted(site.rglob("*.html"))
    return {path: PageReader(path.read_text(encoding="utf-8")) for path in found}


def inside(pages: dict[Path, PageReader]) -> Iterator[tuple[Path, str, Path, str]]:
    """Page, reference as written, file and anchor that it means, for all that stays in the site."""
    for page, read in pages.items():
        for reference in read.links + read.loads:
            parts = urlsplit(reference)
            if not parts.scheme and not parts.netloc:
                target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
                yield page, reference, target, unquote(parts.fragment)


def test_every_source_page_is_built(pages, site):
    left_out = {"_build", "_extensions", "_figures", "gallery"}
    sources = [path.relative_to(DOCS) for path in DOCS.rglob("*") if path.suffix in {".md", ".rst"}]
    wanted = {path.with_suffix(".html") for path in sources if not left_out & {*path.parts[:-1]}}
    assert len(wanted) >= 30
    assert wanted <= {page.relative_to(site) for page in pages}


def test_every_link_anchor_picture_and_file_inside_the_site_is_there(pages):
    checked = list(inside(pages))
    assert len(checked) > 2000
    lost = {(page.name, reference) for page, reference, target, _ in checked if not target.exists()}
    assert lost == set()
    anchored = [row for row in checked if row[3] and row[2] in pages]
    assert len(anchored) > 1000
    assert [row for row in anchored if row[3] not in pages[row[2]].anchors] == []


def test_pages_and_style_sheets_load_nothing_from_elsewhere(pages, site):
    loads = [reference for read in pages.values() for reference in read.loads]
    assert len(loads) > 200
    # What a page carries in itself is from nowhere else.
    asked = [urlsplit(reference) for reference in loads if not reference.startswith("data:")]
    assert [reference for reference in asked if reference.scheme or reference.netloc] == []
    sheets, elsewhere = list(site.rglob("*.css")), r"(?:@import|url\()\s*['\"]?(?:https?:)?//"
    assert len(sheets) >= 3
    assert [sheet for sheet in sheets if re.search(elsewhere, sheet.read_text("utf-8"))] == []


def test_every_public_name_and_command_is_in_the_reference(pages):
    anchors = {name for read in pages.values() for name in read.anchors}
    rooms = {name for name in cm.__all__ if inspect.ismodule(getattr(cm, name))}
    assert len(rooms) == 8
    paths = {f"cyclemap.{name}" for name in cm.__all__ if name not in rooms}
    for room in rooms - {"views"}:
        own = {*getattr(cm, room).__all__} - {*cm.__all__}
        paths |= {f"cyclemap.{room}.{name}" for name in own}
    assert len(paths) > 250
    assert len(cli.commands) >= 8
    assert sorted((paths | {f"cyclemap-{name}" for name in cli.commands}) - anchors) == []


def test_a_name_has_a_page_of_its_own_and_its_room_leads_to_it_in_the_rooms_order(pages, site):
    for room in ("maps", "collection", "protocol"):
        module = getattr(cm, room)
        told = [line.partition(" : ")[0] for line in module.__doc__.splitlines() if " : " in line]
        wanted = [name for names in told for name in names.split(", ")]
        page = site / "reference" / "api" / f"{room}.html"
        links = [link.partition("#")[0] for link in pages[page].links if link.startswith("names/")]
        shown = [link.removesuffix(".html").rpartition(".")[2] for link in links]
        assert [name for name in dict.fromkeys(shown) if name in wanted] == wanted
        assert all((page.parent / link).is_file() for link in links)


def test_formulas_are_well_formed_and_no_role_or_formula_comes_through_as_text(site):
    formulas = []
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        written = re.findall(r"<math .*?</math>", text, flags=re.DOTALL)
        formulas += [ElementTree.fromstring(formula) for formula in written]
        words = re.sub(r"<(script|pre|style)\b.*?</\1>|<[^>]+>", " ", text, flags=re.DOTALL)
        assert not re.search(r":py:\w+:|\{py:|\{doc\}|\$\$|``", words), page
    assert len(formulas) > 100 and all(formula.tag.endswith("math") for formula in formulas)
