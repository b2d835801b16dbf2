"""The catalogue lists every exhibit of the room, in order, under a name, a source and a title."""

import subprocess
import sys
from importlib import import_module
from pkgutil import walk_packages

import pytest
from refusals import refused

import cyclemap.figures
from cyclemap.figures import CATALOGUE, entries, load_exhibit

NAMES = [entry.name for entry in CATALOGUE]


def test_every_exhibit_is_in_the_catalogue_once_and_is_a_figure_a_table_or_an_animation() -> None:
    modules = [
        import_module(name)
        for _, name, _ in walk_packages(cyclemap.figures.__path__, "cyclemap.figures.")
    ]
    found = [getattr(module, "EXHIBITS", {}) for module in modules]
    exhibits = {name: exhibit for made in found for name, exhibit in made.items()}
    assert {name: load_exhibit(name) for name in NAMES} == exhibits
    assert len(exhibits) == sum(map(len, found)) == len(NAMES) == 22
    for exhibit in exhibits.values():
        made = [kind for kind in ("draw", "rows", "frames") if getattr(exhibit, kind) is not None]
        assert len(made) == 1
        assert bool(exhibit.header) == (made == ["rows"])
    assert all(entry.title.strip() and entry.source.strip() for entry in CATALOGUE)
    assert len({entry.title for entry in CATALOGUE}) == len(CATALOGUE)


@pytest.mark.parametrize(
    ("asked", "found"),
    [
        ((), NAMES),
        (("all", "saddle-node"), NAMES),
        (("locking-in", "setup-and-cycle", "locking-in"), ["setup-and-cycle", "locking-in"]),
    ],
)
def test_names_come_in_the_gallerys_order_and_each_once(asked, found) -> None:
    assert [entry.name for entry in entries(asked)] == found


def test_an_unknown_name_is_refused_with_the_nearest() -> None:
    refused(entries, ("sadle-node",), told="did you mean 'saddle-node'")
    for name in ("all", "nothing"):
        refused(load_exhibit, name, told="unknown figure")


def test_the_catalogue_imports_no_exhibit_and_no_matplotlib() -> None:
    code = (
        "import sys; from cyclemap.figures import entries; entries();assert "
        "'cyclemap.figures.ring_distance' not in sys.modules; print('matplotlib' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
