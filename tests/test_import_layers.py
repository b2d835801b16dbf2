"""Imports run one way: mechanics, maps <- collection <- protocol <- evidence <- resets <- views <-
figures <- cli.
"""

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from importlib.util import resolve_name
from pathlib import Path

import pytest

import cyclemap

PACKAGE = Path(cyclemap.__file__).parent
# The room that lies beside the package and is installed in it.
FIGURES = PACKAGE.parent / "figures"
# A room may import itself and rooms of lower rank; two rooms of one rank do not know each other.
ROOMS = (
    "mechanics maps",
    "collection",
    "protocol",
    "evidence sweeps",
    "resets",
    "views",
    "figures",
    "cli",
)
RANK = {name: rank for rank, names in enumerate(ROOMS, 3) for name in names.split()}
# Modules beside the rooms: small things that every room may use, and the doors of the package.
SMALL = (
    "arrays errors lazy_names one_thread progress",
    "plain_text written",
    "checks inline_svg text_files",
)
SHARED = {name: rank for rank, names in enumerate(SMALL) for name in names.split()}
DOORS = {"__init__": 11, "__main__": 11}
ALL_RANKS = RANK | SHARED | DOORS


def room(module: str) -> str:
    """The part of `cyclemap.part.anything`; the package itself is the door `__init__`."""
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else "__init__"


def imported_modules(source: str, module: str, is_package: bool) -> Iterator[str]:
    """Every module of this package that `source` (the text of `module`) imports, wherever it does
    so.
    """
    for node in ast.walk(ast.parse(source)):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            package = module if is_package else parent(module)
            base = resolve_name("." * node.level + (node.module or ""), package)
            # `from cyclemap import maps` names a room; `from cyclemap import CircleMap` goes
            # through the door.
            rooms = [
                f"cyclemap.{one.name}" if one.name in RANK | SHARED else base for one in node.names
            ]
            names = rooms if base == "cyclemap" else [base]
        elif (
            isinstance(node, ast.Call)
            and ast.unparse(node.func).endswith("import_module")
            and node.args
        ):
            names = [str(node.args[0].value)] if isinstance(node.args[0], ast.Constant) else []
        yield from (name for name in names if name.split(".")[0] == "cyclemap")


def violations(source: str, module: str, is_package: bool = False) -> list[str]:
    own, targets = room(module), imported_modules(source, module, is_package)
    return [
        f"{module} imports {target}"
        for target in targets
        if room(target) != own and ALL_RANKS[room(target)] >= ALL_RANKS[own]
    ]


def module_name(path: Path) -> tuple[str, bool]:
    root = PACKAGE.parent if FIGURES in path.parents else PACKAGE
    name = ".".join(["cyclemap", *path.relative_to(root).with_suffix("").parts])
    return name.removesuffix(".__init__"), name.endswith(".__init__")


FILES = sorted([*PACKAGE.rglob("*.py"), *FIGURES.rglob("*.py")])


def test_every_file_belongs_to_a_known_room() -> None:
    parts = {room(module_name(path)[0]) for path in FILES}
    assert parts <= set(ALL_RANKS), "a new room or shared module: give it a rank here"
    assert {
        "mechanics",
        "maps",
        "collection",
        "protocol",
        "evidence",
        "views",
        "figures",
        "cli",
    } <= parts


@pytest.mark.slow
def test_imports_never_run_upward_or_sideways() -> None:
    found = [violations(path.read_text(encoding="utf-8"), *module_name(path)) for path in FILES]
    assert [line for lines in found for line in lines] == []


def import_graph(sources: dict[str, tuple[str, bool]]) -> dict[str, set[str]]:
    """What each module of `sources` (text, and whether it is a package) imports of the others,
    wherever it does so.
    """
    graph: dict[str, set[str]] = {}
    for module, (source, is_package) in sources.items():
        targets = set(imported_modules(source, module, is_package))
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.ImportFrom):
                # `from room import part` may name a file of the room.
                base = resolve_name(
                    "." * node.level + (node.module or ""), module if is_package else parent(module)
                )
                targets |= {f"{base}.{alias.name}" for alias in node.names}
        graph[module] = targets & set(sources) - {module}
    return graph


def parent(module: str) -> str:
    return module.rpartition(".")[0]


@pytest.mark.slow
def test_no_file_imports_itself_through_others() -> None:
    """All imports count: those that a function makes later,
    and those that type checkers alone see."""
    sources = {}
    for path in FILES:
        module, is_package = module_name(path)
        sources[module] = path.read_text(encoding="utf-8"), is_package
    TopologicalSorter(import_graph(sources)).prepare()  # CycleError names the files


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
    sources = {"cyclemap.room.first": (there, False), "cyclemap.room.second": (back, False)}
    with pytest.raises(CycleError):
        TopologicalSorter(import_graph(sources)).prepare()


@pytest.mark.parametrize(
    ("source", "module", "wrong"),
    [
        ("from cyclemap.maps import CircleMap", "mechanics.push", True),
        ("from ..cli import main", "views.page", True),
        ("from .. import views", "collection.loop", True),
        ("def f():\n    from cyclemap.evidence import x", "collection.loop", True),
        ("from cyclemap import CircleMap", "cli.main", True),
        ("import cyclemap", "maps.orbits.periodic_points", True),
        (
            "from importlib import import_module\nimport_module('cyclemap.cli.main')",
            "views.page",
            True,
        ),
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
    name = f"cyclemap.{module}"
    found = violations(
        source, name.removesuffix(".__init__"), is_package=name.endswith(".__init__")
    )
    assert len(found) == wrong


# What the parts of a crowded room may import: themselves, those before them in their row, and what
# all share.
ROWS = {
    "maps": (
        ("lifts", "operator", "orbits", "passages", "families"),
        ("lifts", "operator", "orbits", "passages", "staircases"),
    ),
    "evidence": (
        ("tables", "pushes", "laws", "comparison"),
        ("tables", "pushes", "laws", "identification"),
    ),
}
PARTS_SHARED: dict[str, set[str]] = {
    "maps": {"estimate", "quadrature", "noise"},
    "evidence": {"motion_check", "predicted_strokes", "rod_contacts"},
}


def allowed(place: str, part: str) -> set[str]:
    before = [row[: row.index(part) + 1] for row in ROWS[place] if part in row]
    return {name for row in before for name in row} | PARTS_SHARED[place]


@pytest.mark.slow
@pytest.mark.parametrize("place", ROWS)
def test_the_parts_of_a_room_import_one_way(place: str) -> None:
    """A lift knows no orbit, a noise no operator; nothing inside a room goes through its door."""
    found, seen = [], set()
    for path in sorted((PACKAGE / place).glob("*/*.py")):
        part, module = (
            path.parent.name,
            ".".join(("cyclemap", *path.relative_to(PACKAGE).with_suffix("").parts)),
        )
        seen.add(part)
        for target in imported_modules(
            path.read_text(encoding="utf-8"), module, path.name == "__init__.py"
        ):
            inside = (*target.split(".")[2:3], "")[0]
            if room(target) == place and inside not in allowed(place, part):
                found.append(f"{module} imports {target}")
    assert found == []
    assert seen == {name for row in ROWS[place] for name in row}
