"""Imports run one way: mechanics, maps <- collection <- protocol <- evidence <- resets <- views <-
figures <- cli.
"""

import ast
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib.util import resolve_name
from pathlib import Path

import pytest

import cyclemap

PACKAGE = Path(cyclemap.__file__).parent
# The room that lies beside the package and is installed in it.
FIGURES = PACKAGE.parent / "figures"
# A room may import itself and rooms of lower rank; two rooms of one rank do not know each other.
ROOMS = "mechanics maps", "collection", "protocol", "evidence sweeps", "resets", "views", "figures"
RANK = {name: rank for rank, names in enumerate((*ROOMS, "cli"), 3) for name in names.split()}
# Modules beside the rooms: small things that every room may use, and the doors of the package.
SMALL = (
    "arrays errors lazy_names one_thread progress",
    "plain_text written",
    "checks inline_svg text_files",
)
SHARED = {name: rank for rank, names in enumerate(SMALL) for name in names.split()}
ALL_RANKS = RANK | SHARED | {"__init__": 11, "__main__": 11}


def room(module: str) -> str:
    """The part of `cyclemap.part.anything`; the package itself is the door `__init__`."""
    return (*module.split(".")[1:], "__init__")[0]


@cache
def imports(source: str, module: str, is_package: bool) -> list[tuple[str, list[str]]]:
    """What `source`, the text of `module`, imports of this package, wherever it does so: modules,
    and the names taken from each.
    """
    found: list[tuple[str, list[str]]] = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found += [(alias.name, []) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            package = module if is_package else module.rpartition(".")[0]
            base = resolve_name("." * node.level + (node.module or ""), package)
            found.append((base, [alias.name for alias in node.names]))
        elif isinstance(node, ast.Call) and "import_module" in (
            getattr(node.func, "id", ""),
            getattr(node.func, "attr", ""),
        ):
            found += [(str(getattr(argument, "value", "")), []) for argument in node.args[:1]]
    return [(base, names) for base, names in found if base.split(".")[0] == "cyclemap"]


def imported_modules(source: str, module: str, is_package: bool) -> Iterator[str]:
    """The modules; of `from cyclemap import maps` the room, while `from cyclemap import CircleMap`
    goes through the door.
    """
    for base, names in imports(source, module, is_package):
        rooms = [f"cyclemap.{name}" if name in RANK | SHARED else base for name in names]
        yield from rooms if base == "cyclemap" and names else [base]


def violations(source: str, module: str, is_package: bool = False) -> list[str]:
    own, targets = room(module), imported_modules(source, module, is_package)
    return [
        f"{module} imports {target}"
        for target in targets
        if room(target) != own and ALL_RANKS[room(target)] >= ALL_RANKS[own]
    ]


def files() -> Iterator[tuple[str, str, bool]]:
    """Text and name of each module, and whether it is a package."""
    for path in sorted([*PACKAGE.rglob("*.py"), *FIGURES.rglob("*.py")]):
        root = PACKAGE.parent if FIGURES in path.parents else PACKAGE
        name = ".".join(["cyclemap", *path.relative_to(root).with_suffix("").parts])
        text = path.read_text(encoding="utf-8")
        yield text, name.removesuffix(".__init__"), name.endswith(".__init__")


FILES = list(files())


def test_every_file_belongs_to_a_known_room() -> None:
    parts = {room(module) for _, module, _ in FILES}
    assert parts <= set(ALL_RANKS), "a new room or shared module: give it a rank here"
    assert set(RANK) <= parts


@pytest.mark.slow
def test_imports_never_run_upward_or_sideways() -> None:
    assert [line for file in FILES for line in violations(*file)] == []


def import_graph(sources: list[tuple[str, str, bool]]) -> dict[str, set[str]]:
    """What each module imports of the others, wherever it does so."""
    graph: dict[str, set[str]] = {}
    known = {module for _, module, _ in sources}
    for source in sources:
        targets = set(imported_modules(*source))
        # `from room import part` may name a file of the room.
        targets |= {f"{base}.{name}" for base, names in imports(*source) for name in names}
        graph[source[1]] = targets & known - {source[1]}
    return graph


@pytest.mark.slow
def test_no_file_imports_itself_through_others() -> None:
    """All imports count: those that a function makes later, and those that type checkers alone
    see.
    """
    TopologicalSorter(import_graph(FILES)).prepare()  # CycleError names the files


@pytest.mark.parametrize(
    "back",
    [
        "from cyclemap.room.first import x",
        "from cyclemap.room import first",
        "from .first import x",
        "def f():\n    from cyclemap.room.first import x",
        "if TYPE_CHECKING:\n    from cyclemap.room.first import x",
        "import cyclemap.room.first",
    ],
)
def test_a_circle_of_imports_is_seen_wherever_they_stand(back: str) -> None:
    there = "from cyclemap.room.second import y"
    sources = [(there, "cyclemap.room.first", False), (back, "cyclemap.room.second", False)]
    with pytest.raises(CycleError):
        TopologicalSorter(import_graph(sources)).prepare()


LATER = "from importlib import import_module\nimport_module('cyclemap.cli.main')"


@pytest.mark.parametrize(
    ("source", "module", "wrong"),
    [
        ("from cyclemap.maps import CircleMap", "mechanics.push", True),
        ("from ..cli import main", "views.page", True),
        ("from .. import views", "collection.loop", True),
        ("def f():\n    from cyclemap.evidence import x", "collection.loop", True),
        ("from cyclemap import CircleMap", "cli.main", True),
        ("import cyclemap", "maps.orbits.periodic_points", True),
        (LATER, "views.page", True),
        ("from cyclemap.maps import CircleMap", "errors", True),
        ("from .portrait import x", "collection.__init__", False),
        ("from .push import Push\nfrom . import drag", "mechanics.cycle", False),
        ("from ..maps import CircleMap", "collection.loop", False),
        ("from cyclemap.cli.main import main", "__main__", False),
        ("import numpy\nfrom scipy import optimize", "maps.orbits.periodic_points", False),
    ],
)
def test_checker_catches_planted_violations_and_lets_downward_imports_pass(
    source, module, wrong
) -> None:
    name = f"cyclemap.{module}".removesuffix(".__init__")
    assert len(violations(source, name, module.endswith("__init__"))) == wrong


# What the parts of a crowded room may import: themselves, those before them in their row, and what
# all share.
ROWS = {
    "maps": (
        "lifts operator orbits passages families",
        "lifts operator orbits passages staircases",
    ),
    "evidence": ("tables pushes laws comparison", "tables pushes laws identification"),
}
PARTS_SHARED = {
    "maps": "estimate quadrature noise",
    "evidence": "motion_check predicted_strokes",
}


def allowed(place: str, part: str) -> set[str]:
    rows = [row.split() for row in ROWS[place]]
    before = {name for row in rows if part in row for name in row[: row.index(part) + 1]}
    return before | set(PARTS_SHARED[place].split())


@pytest.mark.slow
@pytest.mark.parametrize("place", ROWS)
def test_the_parts_of_a_room_import_one_way(place: str) -> None:
    """A lift knows no orbit, a noise no operator; nothing inside a room goes through its door."""
    found, seen = [], set()
    for source, module, is_package in FILES:
        parts = module.split(".")[2:]
        if room(module) != place or len(parts) + is_package < 2:
            continue
        seen.add(parts[0])
        for target in imported_modules(source, module, is_package):
            inside = (*target.split(".")[2:3], "")[0]
            if room(target) == place and inside not in allowed(place, parts[0]):
                found.append(f"{module} imports {target}")
    assert found == []
    assert seen == {name for row in ROWS[place] for name in row.split()}
