"""The catalogue lists every exhibit of the room, in order, under a name, a source and a title."""

import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import cyclemap.figures
from cyclemap.errors import InvalidInput
from cyclemap.figures.catalogue import (
    CATALOGUE,
    EXPORTS,
    PaperAnimation,
    PaperFigure,
    PaperTable,
    entries,
    load_exhibit,
)

FOLDER = Path(cyclemap.figures.__file__).parent
KINDS = {"FIGURE": PaperFigure, "TABLE": PaperTable, "ANIMATION": PaperAnimation}


def _exhibiting() -> dict[str, list[str]]:
    """Modules of the room that export an exhibit, and what they call it."""
    found = {}
    for path in sorted(FOLDER.glob("*.py")):
        module = import_module(f"cyclemap.figures.{path.stem}")
        if exports := [name for name in EXPORTS if hasattr(module, name)]:
            found[path.stem] = exports
    return found


def test_every_exhibit_is_in_the_catalogue_once_and_the_other_way_round() -> None:
    found = _exhibiting()
    assert sorted(found) == sorted(entry.module for entry in CATALOGUE)
    assert all(len(exports) == 1 for exports in found.values())
    assert len(CATALOGUE) == 21


def test_every_entry_has_a_source_and_a_title_of_its_own_and_loads_what_its_module_exports() -> None:
    for entry in CATALOGUE:
        exhibit = load_exhibit(entry.name)
        assert entry.title.strip()
        assert entry.source.strip()
        (export,) = _exhibiting()[entry.module]
        assert isinstance(exhibit, KINDS[export])
    assert len({entry.title for entry in CATALOGUE}) == len(CATALOGUE)


def test_names_come_in_the_gallerys_order_and_each_once() -> None:
    order = [entry.name for entry in CATALOGUE]
    assert [entry.name for entry in entries()] == order
    assert [entry.name for entry in entries(("all", "saddle-node"))] == order
    asked = ("locking-in", "setup-and-cycle", "locking-in")
    assert [entry.name for entry in entries(asked)] == ["setup-and-cycle", "locking-in"]


def test_an_unknown_name_is_refused_with_the_nearest() -> None:
    with pytest.raises(InvalidInput, match="did you mean 'saddle-node'"):
        entries(("sadle-node",))
    for name in ("all", "nothing"):
        with pytest.raises(InvalidInput, match="unknown figure"):
            load_exhibit(name)


def test_the_catalogue_imports_no_exhibit_and_no_matplotlib() -> None:
    code = (
        "import sys; from cyclemap.figures.catalogue import entries; entries();"
        "assert 'cyclemap.figures.saddle_node' not in sys.modules; print('matplotlib' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
