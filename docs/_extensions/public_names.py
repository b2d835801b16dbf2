"""Directives that list the public names of a room, taken from the code when the site is built.

`.. room:: cyclemap.maps` documents what the room exports, a section for each of its parts, in alphabetical order;
`.. room-modules:: cyclemap.views` documents the public functions and classes of each module of a room without exports.
"""

import inspect
import pkgutil
import re
from collections.abc import Iterable, Iterator
from importlib import import_module
from types import ModuleType
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from house_docstrings import marked
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from sphinx.util.nodes import nested_parse_with_titles

import cyclemap

ARRAY_LIKE = re.compile(r"~?[\w.]*Buffer \| .*?_NestedSequence\[complex \| bytes \| str\]")
ARRAY = re.compile(r"~?(?:numpy\.)?ndarray\[tuple\[.*?\.\.\.\], ~?(?:numpy\.)?dtype\[[^\[\]]*(?:\[[^\]]*\])?\]\]")


class NamesDirective(SphinxDirective):
    """What both directives share: text is made from the code, and parsed where the directive stands."""

    required_arguments = 1
    has_content = False

    def text(self, room: ModuleType) -> Iterator[str]:
        """The reStructuredText that takes the directive's place."""
        raise NotImplementedError

    def run(self) -> list[nodes.Node]:
        """Parse the text that the room gives."""
        room = import_module(self.arguments[0])
        self.env.note_dependency(str(room.__file__))
        lines = StringList(list(self.text(room)), source=self.arguments[0])
        node = nodes.section()
        node.document = self.state.document
        nested_parse_with_titles(self.state, lines, node)
        return node.children


class Room(NamesDirective):
    """The exports of a room, by its parts."""

    def text(self, room: ModuleType) -> Iterator[str]:
        """A heading and the names for each part of the room."""
        for part, names in parts_of(room).items():
            if part:
                yield from heading(part.rpartition(".")[2].replace("_", " "))
                yield from (first_line(import_module(part)), "")
            things = {public_path(room, name): getattr(room, name) for name in names}
            yield from listed(things)
            for path, thing in things.items():
                yield from documented(path, thing)


class RoomModules(NamesDirective):
    """The public functions and classes of each module of a room."""

    def text(self, room: ModuleType) -> Iterator[str]:
        """A heading and the names for each module."""
        for module in modules_of(room):
            things = {f"{module.__name__}.{name}": thing for name, thing in defined_in(module).items()}
            if things:
                yield from heading(module.__name__.rpartition(".")[2].replace("_", " "))
                yield from (first_line(module), "", *listed(things))
                for path, thing in things.items():
                    yield from documented(path, thing)


def parts_of(room: ModuleType) -> dict[str, list[str]]:
    """The names that a room exports, by the part (sub-package) that defines them; "" for the room itself."""
    found: dict[str, list[str]] = {}
    for name in sorted(room.__all__, key=str.lower):
        home = getattr(getattr(room, name), "__module__", room.__name__)
        package = home.rpartition(".")[0]
        inside = package.startswith(f"{room.__name__}.")
        found.setdefault(package if inside else "", []).append(name)
    return dict(sorted(found.items()))


def public_path(room: ModuleType, name: str) -> str:
    """Where a user finds a name: `cyclemap.name`, or in its room where the package does not export it."""
    return f"cyclemap.{name}" if name in cyclemap.__all__ else f"{room.__name__}.{name}"


def modules_of(room: ModuleType) -> list[ModuleType]:
    """Every module of a room, by name."""
    names = [found.name for found in pkgutil.walk_packages(room.__path__, f"{room.__name__}.")]
    return [import_module(name) for name in sorted(names)]


def defined_in(module: ModuleType) -> dict[str, Any]:
    """The public functions and classes that a module defines itself, with a docstring."""
    return {
        name: thing
        for name, thing in vars(module).items()
        if not name.startswith("_")
        and (inspect.isfunction(thing) or inspect.isclass(thing))
        and thing.__module__ == module.__name__
        and thing.__doc__
    }


def listed(paths: Iterable[str]) -> Iterator[str]:
    """A line of links to what follows."""
    yield from (" · ".join(f":py:obj:`~{path}`" for path in paths), "")


def documented(path: str, thing: Any) -> Iterator[str]:
    """The autodoc directive of one thing."""
    if inspect.isclass(thing):
        yield from (f".. autoclass:: {path}", "   :members:", "")
    elif inspect.isroutine(thing):
        yield from (f".. autofunction:: {path}", "")
    else:
        yield from (f".. py:data:: {path}", f"   :value: {shown(thing)}", "", f"   {about(thing)}", "")


def shown(thing: Any) -> str:
    """The value of a constant, or the kind of a thing that is none."""
    return repr(thing) if isinstance(thing, (int, float, str, tuple, frozenset)) else type(thing).__name__


def about(thing: Any) -> str:
    """A line about a constant."""
    return "A constant." if isinstance(thing, (int, float, str, tuple)) else f"Of the kind {type(thing).__name__}."


def first_line(module: ModuleType) -> str:
    """The first paragraph of a module's docstring."""
    return marked((module.__doc__ or "").strip().split("\n\n")[0].replace("\n", " "))


def heading(title: str) -> tuple[str, ...]:
    """A section title."""
    title = title[:1].upper() + title[1:]
    return ("", title, "-" * max(len(title), 4), "")


def short_types(
    app: Sphinx, what: str, name: str, thing: Any, options: Any, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    """Write arrays as `ndarray` in signatures: shapes and units are in the words below them."""
    return (signature and short(signature), returned and short(returned))


def short(types: str) -> str:
    """Types without the inside of arrays.

    >>> short("(x: ~numpy.ndarray[tuple[~typing.Any, ...], ~numpy.dtype[~numpy.float64]]) -> int")
    '(x: ~numpy.ndarray) -> int'
    """
    return ARRAY.sub("~numpy.ndarray", ARRAY_LIKE.sub("~numpy.typing.ArrayLike", types))


def short_properties(app: Sphinx, doctree: nodes.document) -> None:
    """The same for the types of properties, which autodoc asks nobody about."""
    for node in doctree.findall(addnodes.desc_annotation):
        text = node.astext()
        if short(text) != text:
            node.children = [nodes.Text(short(text).replace("~numpy.", ""))]


def public_link(app: Sphinx, env: Any, node: Any, content: nodes.Node) -> nodes.Node | None:
    """Link `cyclemap.room.module.Name`, as types in signatures say it, to where `Name` is documented."""
    target = str(node.get("reftarget", ""))
    room, _, name = target.removeprefix("cyclemap.").partition(".")
    name = name.rpartition(".")[2] or room
    path = f"cyclemap.{name}" if name in cyclemap.__all__ else f"cyclemap.{room}.{name}"
    if node.get("refdomain") != "py" or target == path:
        return None
    return env.get_domain("py").resolve_xref(env, node["refdoc"], app.builder, "obj", path, node, content)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register both directives, and mend the types in signatures."""
    app.add_directive("room", Room)
    app.add_directive("room-modules", RoomModules)
    app.connect("autodoc-process-signature", short_types)
    app.connect("doctree-read", short_properties)
    app.connect("missing-reference", public_link)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
