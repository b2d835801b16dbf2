"""What the pages promise to list is all there: settings, materials, commands; and no page needs the network."""

import json
import re
import runpy
from pathlib import Path

from cyclemap.cli.main import cli
from cyclemap.figures.catalogue import entries
from cyclemap.mechanics import material_names
from cyclemap.protocol.protocol_file import ACTION_KEYS, STRATEGY_KEYS

DOCS = Path(__file__).parents[2] / "docs"
SOURCES = [
    path for path in DOCS.rglob("*") if path.suffix in {".md", ".rst", ".py", ".css"} and "_build" not in path.parts
]


def words(name: str) -> str:
    return (DOCS / name).read_text(encoding="utf-8")


def test_the_readme_tells_every_setting_as_the_guide_does() -> None:
    readme = (DOCS.parent / "README.md").read_text(encoding="utf-8")
    assert runpy.run_path(str(DOCS / "_extensions" / "settings_table.py"))["markdown"]() in readme


def test_every_key_of_a_strategy_is_in_the_guide_and_nothing_else_is() -> None:
    section = words("how-to/own-protocol.md").split("\n## Cycles that differ\n")[1].split("\n## ")[0]
    rows = [line for line in section.splitlines() if line.startswith("| `")]
    found = {key for line in rows for key in re.findall(r"`([\w-]+)`", line.split("|")[1])}
    assert found == {*STRATEGY_KEYS, *ACTION_KEYS}


def test_every_command_is_named_where_its_use_is_shown() -> None:
    guides = [*(DOCS / "how-to").glob("*.md"), *(DOCS / "concepts").glob("*.md"), DOCS / "quick-start.md"]
    text = " ".join(page.read_text(encoding="utf-8") for page in guides)
    assert len(cli.commands) >= 8
    assert [name for name in cli.commands if f"cyclemap {name}" not in text] == []


def test_every_inferred_material_is_told_among_the_limits() -> None:
    names = [name for name in material_names() if name != "isotropic"]
    assert len(names) >= 5
    assert [name for name in names if name not in words("limits.md")] == []


def test_no_source_names_an_address() -> None:
    assert len(SOURCES) > 40
    # The namespaces of MathML and SVG are names, not places.
    address = re.compile(r"\w+://(?!www\.w3\.org/(1998/Math|2000/svg))")
    assert [path.name for path in SOURCES if address.search(path.read_text(encoding="utf-8"))] == []


def test_the_gallery_shows_every_figure_and_table_under_its_present_title() -> None:
    gallery = DOCS / "gallery"
    lines = json.loads((gallery / "figures.json").read_text(encoding="utf-8"))["figures"]
    assert [(line["name"], line["title"]) for line in lines] == [(entry.name, entry.title) for entry in entries()]
    assert len(lines) == len(entries()) > 20
    assert all((gallery / line["file"]).is_file() for line in lines)
