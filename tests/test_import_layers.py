"""Imports run one way: mechanics, maps <- collection <- evidence <- resets <- views <- figures <- cli."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import cyclemap

PACKAGE = Path(cyclemap.__file__).parent
# The room that lies beside the package and is installed in it.
FIGURES = PACKAGE.parent / "figures"
# A room may import itself and rooms of lower rank; two rooms of one rank do not know each other.
RANK = {
    "mechanics": 2,
    "maps": 2,
    "collection": 3,
    "evidence": 4,
    "sweeps": 4,
    "resets": 5,
    "views": 6,
    "figures": 7,
    "cli": 8,
}
# Modules beside the rooms: small things that every room may use, and the doors of the package.
SHARED = {
    "arrays": 0,
    "errors": 0,
    "lazy_names": 0,
    "plain_text": 0,
    "checks": 1,
    "file_text": 1,
    "inline_svg": 1,
    "text_files": 1,
}
DOORS = {"__init__": 9, "__main__": 9}
ALL_RANKS = RANK | SHARED | DOORS


def room(module: str) -> str:
    """The part of `cyclemap.part.anything`; the package itself is the door `__init__`."""
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else "__init__"


def imported_modules(source: str, module: str, is_package: bool) -> Iterator[str]:
    """Every module of this package that `source` (the text of `module`) imports, wherever it does so."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.split(".")[0] == "cyclemap")
        elif isinstance(node, ast.ImportFrom):
            yield from imported_from(node, module, is_package)
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module") and node.args:
            name = node.args[0]
            if isinstance(name, ast.Constant) and str(name.value).split(".")[0] == "cyclemap":
                yield str(name.value)


def imported_from(node: ast.ImportFrom, module: str, is_package: bool) -> Iterator[str]:
    base = node.module or ""
    if node.level:
        above = module.split(".") if is_package else module.split(".")[:-1]
        above = above[: len(above) - node.level + 1]
        base = ".".join([*above, base]) if base else ".".join(above)
    if base == "cyclemap":
        # `from cyclemap import maps` names a room; `from cyclemap import CircleMap` goes through the door.
        for alias in node.names:
            known = alias.name in RANK or alias.name in SHARED
            yield f"cyclemap.{alias.name}" if known else "cyclemap"
    elif base.split(".")[0] == "cyclemap":
        yield base


def violations(source: str, module: str, is_package: bool = False) -> list[str]:
    own = room(module)
    return [
        f"{module} imports {target}"
        for target in imported_modules(source, module, is_package)
        if room(target) != own and ALL_RANKS[room(target)] >= ALL_RANKS[own]
    ]


def module_name(path: Path) -> tuple[str, bool]:
    root = PACKAGE.parent if FIGURES in path.parents else PACKAGE
    parts = ["cyclemap", *path.relative_to(root).with_suffix("").parts]
    is_package = parts[-1] == "__init__"
    return ".".join(parts[:-1] if is_package else parts), is_package


FILES = sorted([*PACKAGE.rglob("*.py"), *FIGURES.rglob("*.py")])


def test_every_file_belongs_to_a_known_room() -> None:
    parts = {room(module_name(path)[0]) for path in FILES}
    assert parts <= set(ALL_RANKS), "a new room or shared module: give it a rank here"
    assert {"mechanics", "maps", "collection", "evidence", "views", "figures", "cli"} <= parts


@pytest.mark.slow
def test_imports_never_run_upward_or_sideways() -> None:
    found = [violations(path.read_text(encoding="utf-8"), *module_name(path)) for path in FILES]
    assert [line for lines in found for line in lines] == []


@pytest.mark.slow
def test_no_file_imports_itself_through_others() -> None:
    """Files none of whose imports is left are taken away until none is; what a function imports, it imports later."""
    left = {}
    for path in FILES:
        module, is_package = module_name(path)
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for block in ast.walk(tree):
            later = isinstance(block, ast.If) and ast.unparse(block.test) == "TYPE_CHECKING"
            if later or isinstance(block, ast.FunctionDef):
                block.body = [ast.Pass()]
        left[module] = set(imported_modules(ast.unparse(tree), module, is_package)) - {module}
    left = {module: names & left.keys() for module, names in left.items()}
    while free := {module for module, names in left.items() if not names}:
        left = {module: names - free for module, names in left.items() if module not in free}
    assert sorted(left) == []


@pytest.mark.parametrize(
    ("source", "module"),
    [
        ("from cyclemap.maps import CircleMap", "cyclemap.mechanics.push"),
        ("from cyclemap.mechanics import Slider", "cyclemap.maps.orbits.periodic_points"),
        ("import cyclemap.views.style as s", "cyclemap.evidence.tables"),
        ("from ..cli import main", "cyclemap.views.page"),
        ("from .. import views", "cyclemap.collection.loop"),
        ("def f():\n    from cyclemap.evidence import x", "cyclemap.collection.loop"),
        ("from cyclemap import CircleMap", "cyclemap.cli.main"),
        ("import cyclemap", "cyclemap.maps.orbits.periodic_points"),
        ("from importlib import import_module\nimport_module('cyclemap.cli.main')", "cyclemap.views.page"),
        ("from cyclemap.maps import CircleMap", "cyclemap.errors"),
    ],
)
def test_checker_catches_a_planted_violation(source: str, module: str) -> None:
    assert len(violations(source, module)) == 1


@pytest.mark.parametrize(
    ("source", "module"),
    [
        ("from cyclemap.errors import InvalidInput", "cyclemap.mechanics.push"),
        ("from .push import Push\nfrom . import drag", "cyclemap.mechanics.cycle"),
        ("from ..maps import CircleMap", "cyclemap.collection.loop"),
        ("from cyclemap.cli.main import main", "cyclemap.__main__"),
        ("import numpy\nfrom scipy import optimize", "cyclemap.maps.orbits.periodic_points"),
    ],
)
def test_checker_lets_downward_imports_pass(source: str, module: str) -> None:
    assert violations(source, module) == []


def test_relative_import_inside_a_package_init_resolves_to_that_package() -> None:
    assert violations("from .portrait import x", "cyclemap.collection", is_package=True) == []
    assert violations("from ..views import x", "cyclemap.collection", is_package=True) != []


# What the parts of a crowded room may import: themselves, those before them in their row, and what all share.
ROWS = {
    "maps": (
        ("lifts", "orbits", "noise", "passages", "operator", "families"),
        ("lifts", "orbits", "noise", "passages", "operator", "staircases"),
    ),
    "evidence": (
        ("pushes", "laws", "orientations", "tables", "comparison"),
        ("pushes", "replay"),
        ("pushes", "laws", "tables", "identification", "data_blocks"),
    ),
    "resets": (("monitor", "design", "protocol"),),
}
PARTS_SHARED: dict[str, set[str]] = {"maps": {"estimate", "quadrature"}, "evidence": set(), "resets": set()}


def allowed(place: str, part: str) -> set[str]:
    before = [row[: row.index(part) + 1] for row in ROWS[place] if part in row]
    return {name for row in before for name in row} | PARTS_SHARED[place]


@pytest.mark.slow
@pytest.mark.parametrize("place", ROWS)
def test_the_parts_of_a_room_import_one_way(place: str) -> None:
    """A lift knows no orbit, a noise no operator; nothing inside a room goes through its door."""
    found, seen = [], set()
    for path in sorted((PACKAGE / place).glob("*/*.py")):
        part, module = path.parent.name, ".".join(("cyclemap", *path.relative_to(PACKAGE).with_suffix("").parts))
        seen.add(part)
        for target in imported_modules(path.read_text(encoding="utf-8"), module, path.name == "__init__.py"):
            inside = (*target.split(".")[2:3], "")[0]
            if room(target) == place and inside not in allowed(place, part):
                found.append(f"{module} imports {target}")
    assert found == []
    assert seen == {name for row in ROWS[place] for name in row}
