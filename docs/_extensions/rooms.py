"""The pages of the reference, written before the site is read: one for each room, and one for each
name in it.

The parts of a room, and the order in them, are those of its own table of contents, its docstring.
Pages of names stand in no list of contents: in the navigation of every page they would take most of
the build.
"""

import inspect
import pkgutil
from importlib import import_module
from pathlib import Path
from types import ModuleType

import cyclemap

ROOMS = ("collection", "protocol", "maps", "mechanics", "evidence", "resets", "sweeps")
# What is said of rooms whose docstring is no table of contents: their page shows module by module.
VIEWS = """Pictures and sentences. A drawing function takes Matplotlib axes and a result, and draws;
it computes nothing. Degrees and millimetres are on the axes only."""
THEORY = """SymPy derivations: pure functions that return expressions, in the folder ``theory`` of
the repository, beside the package. Nothing of the package needs them at run time. The
:doc:`notes <../../theory/index>` tell what they prove."""
ERRORS = """Every error that cyclemap raises on purpose is a ``CycleMapError``. Its message names
the value and says what to do."""
NAMES = "names"


def write_pages(folder: Path) -> None:
    """Write the pages that have changed, and take away those that are no more."""
    rooms = {name: room_parts(import_module(f"cyclemap.{name}")) for name in ROOMS}
    rooms["errors"] = ERRORS, {"": error_names()}
    texts: dict[Path, str] = {}
    for room, (words, parts) in rooms.items():
        texts[folder / f"{room}.rst"] = page(room.capitalize(), words, parts)
        for paths in parts.values():
            texts |= {folder / NAMES / f"{path}.rst": name_page(path, room) for path in paths}
    texts[folder / "views.rst"] = modules_page("Views", VIEWS, import_module("cyclemap.views"))
    texts[folder / "theory.rst"] = modules_page("Theory", THEORY, import_module("theory"))
    (folder / NAMES).mkdir(parents=True, exist_ok=True)
    for gone in set(folder.rglob("*.rst")) - set(texts):
        gone.unlink()
    for path, text in texts.items():
        # What is not touched is not read again.
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def room_parts(room: ModuleType) -> tuple[str, dict[str, list[str]]]:
    """The first words of a room, and where its names are public, by the parts of its table of
    contents.
    """
    words, parts = contents(inspect.getdoc(room) or "")
    return words, {
        title: [public_path(room, name) for name in names] for title, names in parts.items()
    }


def contents(doc: str) -> tuple[str, dict[str, list[str]]]:
    r"""The introduction of a table of contents, and the names of each of its parts.

    >>> orbits = "Orbits\n------\nfixed_points, Orbit : where a map rests\nbasins : where to\n"
    >>> contents(f"A room.\n\n{orbits}")
    ('A room.', {'Orbits': ['fixed_points', 'Orbit', 'basins']})
    """
    introduction: list[str] = []
    parts: dict[str, list[str]] = {}
    lines = doc.splitlines()
    for line, following in zip(lines, [*lines[1:], ""], strict=True):
        if following and set(following) == {"-"}:
            parts[line] = []
        elif not parts:
            introduction.append(line)
        elif " : " in line:
            names, _, _ = line.partition(" : ")
            parts[list(parts)[-1]] += names.split(", ")
    return "\n".join(introduction).strip(), parts


def page(title: str, words: str, parts: dict[str, list[str]]) -> str:
    """The page of a room: a table of links, with the first sentence of each, for each part."""
    lines = [title, "=" * len(title), "", words, ""]
    for heading, paths in parts.items():
        lines += [heading, "-" * len(heading), ""] if heading else []
        lines += [
            ".. autosummary::",
            "   :nosignatures:",
            "",
            *(f"   {path}" for path in paths),
            "",
        ]
    return "\n".join(lines)


def name_page(path: str, room: str) -> str:
    """The page of one name: a class with its members, a function, or a constant."""
    parent, _, name = path.rpartition(".")
    thing = getattr(import_module(parent), name)
    title = name.replace("_", r"\_")
    lines = [":orphan:", "", title, "=" * len(title), "", f"In :doc:`../{room}`.", ""]
    if inspect.isclass(thing):
        lines += [f".. autoclass:: {path}", "   :members:"]
    else:
        lines += [f".. auto{'function' if inspect.isroutine(thing) else 'data'}:: {path}"]
    return "\n".join([*lines, ""])


def modules_page(title: str, words: str, room: ModuleType) -> str:
    """The page of a room without exports: the public functions and classes of each module."""
    lines = [title, "=" * len(title), "", words, ""]
    for name in sorted(
        found.name for found in pkgutil.walk_packages(room.__path__, f"{room.__name__}.")
    ):
        if defines(import_module(name)):
            heading = name.rpartition(".")[2].replace("_", " ").capitalize()
            lines += [
                heading,
                "-" * len(heading),
                "",
                f".. automodule:: {name}",
                "   :members:",
                "",
            ]
    return "\n".join(lines)


def public_path(room: ModuleType, name: str) -> str:
    """Where a user finds a name: `cyclemap.name`, or in its room where the package does not export
    it.
    """
    return f"cyclemap.{name}" if name in cyclemap.__all__ else f"{room.__name__}.{name}"


def error_names() -> list[str]:
    """The errors, the most general first."""
    errors = import_module("cyclemap.errors")
    kinds = [
        name
        for name, thing in vars(errors).items()
        if getattr(thing, "__module__", "") == errors.__name__
    ]
    return [public_path(errors, name) for name in kinds if inspect.isclass(getattr(errors, name))]


def defines(module: ModuleType) -> bool:
    """Whether a module has public functions or classes of its own."""
    for name, thing in vars(module).items():
        own = (
            inspect.isfunction(thing) or inspect.isclass(thing)
        ) and thing.__module__ == module.__name__
        if own and not name.startswith("_"):
            return True
    return False
