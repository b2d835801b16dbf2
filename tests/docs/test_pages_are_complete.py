"""What the pages promise to list is all there: settings, materials, commands; and no page needs the
network.
"""

import json
import re
import runpy
from pathlib import Path

import cyclemap as cm
from cyclemap.cli.main import cli
from cyclemap.figures import entries
from cyclemap.mechanics import material_names
from cyclemap.protocol.protocol_file import ACTION_KEYS, STRATEGY_KEYS
from cyclemap.protocol.settings import SETTINGS

TESTS = Path(__file__).parents[1]
DOCS = TESTS.parent / "docs"
SOURCES = [
    path
    for path in DOCS.rglob("*")
    if path.suffix in {".md", ".rst", ".py", ".css"} and "_build" not in path.parts
]


def words(name: str) -> str:
    return (DOCS / name).read_text(encoding="utf-8")


def test_the_guide_shows_the_table_of_every_setting() -> None:
    assert "```{settings}\n" in words("how-to/own-protocol.md")
    table = runpy.run_path(str(DOCS / "_extensions" / "settings_table.py"))["markdown"]()
    keys = re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE)
    assert keys == list(SETTINGS) and len(keys) > 30


def test_the_page_of_materials_tells_every_built_in_one() -> None:
    table = words("materials.md").split("## A file of your own")[0]
    rows = re.findall(r"^\| (`.*`) \| ", table, re.MULTILINE)
    assert {*re.findall(r"`([\w-]+)`", " ".join(rows))} == {*material_names()}


def test_every_function_in_the_table_of_rooms_exists() -> None:
    rows = re.findall(
        r"^\| `cm\.(\w+)`(?:: \w+)? \| (.*) \|$", words("reference/index.md"), re.MULTILINE
    )
    assert len(rows) == 11
    for room, functions in rows:
        for name in re.findall(r"`(\w+)`", functions):
            assert hasattr(getattr(cm, room), name) or hasattr(cm.CircleMap, name), (
                f"cm.{room}.{name}"
            )


def test_every_key_of_a_strategy_is_in_the_guide_and_nothing_else_is() -> None:
    _, section = words("how-to/own-protocol.md").split("\n## Cycles that differ\n")
    lines = section.split("\n## ")[0].splitlines()
    keys = " ".join(line.split("|")[1] for line in lines if line.startswith("| `"))
    found = {*re.findall(r"`([\w-]+)`", keys)}
    assert found == {*STRATEGY_KEYS, *ACTION_KEYS}


def test_every_command_is_named_where_its_use_is_shown() -> None:
    guides = [*DOCS.glob("how-to/*.md"), *DOCS.glob("concepts/*.md"), DOCS / "quick-start.md"]
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
    assert [(line["name"], line["title"]) for line in lines] == [
        (entry.name, entry.title) for entry in entries()
    ]
    assert len(lines) == len(entries()) > 20
    assert all((gallery / line["file"]).is_file() for line in lines)


def test_every_claim_on_accuracy_names_a_test_that_is_there() -> None:
    """Rows of tables name one or more as `file::function`; what is run by hand is a module that can
    be run.
    """
    page = words("accuracy.md")
    tables = re.findall(r"^\| .* \| test \|\n\|[-|]+\|\n((?:\|.*\n)+)", page, re.MULTILINE)
    rows = [row for table in tables for row in table.splitlines()]
    named = re.findall(r"`([\w/]+\.py)::(\w+)`", page)
    assert len(rows) >= 35 and len(named) > len(rows)
    for row in rows:
        assert re.search(r"`[\w/]+\.py::test_\w+`", row.rsplit("|", 2)[1]), (
            f"no test stands beside: {row}"
        )
    for file, function in named:
        source = (TESTS / file).read_text(encoding="utf-8")
        assert f"\ndef {function}(" in source, f"{file} has no {function}"
    for module in re.findall(r"`python -m ([\w.]+)", page):
        place = TESTS.parent.joinpath(*module.split("."))
        assert place.with_suffix(".py").is_file() or (place / "__main__.py").is_file(), module
