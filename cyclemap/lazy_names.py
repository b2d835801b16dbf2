"""The public names of a room, each imported from its module when it is first used.

A command that needs one name of a room then does not wait for the modules of all the others.
"""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Iterator
from types import ModuleType
from typing import Any


def import_on_first_use(package: str) -> None:
    """Have `package` import each of its names when it is first used.

    The names, and the modules that they come from, are those of its imports under ``if
    TYPE_CHECKING``, which type checkers read too: there is no second list. Called from the
    package's own ``__init__``.
    """
    module = sys.modules[package]
    places = dict(_imports(_source(module)))
    module._places = places  # type: ignore[attr-defined]
    module.__all__ = list(places)  # type: ignore[attr-defined]
    module.__class__ = _LazyRoom


class _LazyRoom(ModuleType):
    """A package whose names are imported when they are first used.

    >>> import cyclemap.maps
    >>> cyclemap.maps.CircleMap.__module__
    'cyclemap.maps.lifts.circle_map'
    """

    _places: dict[str, str]

    def __getattr__(self, name: str) -> Any:
        if name not in self._places:
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        place = self._places[name]
        inside = place == self.__name__
        value = (
            importlib.import_module(f"{place}.{name}")
            if inside
            else getattr(importlib.import_module(place), name)
        )
        super().__setattr__(name, value)
        return value

    def __setattr__(self, name: str, value: object) -> None:
        # Python binds every submodule that is imported; a function that is called like its module
        # stays the function.
        elsewhere = self._places.get(name, self.__name__) != self.__name__
        if not (elsewhere and isinstance(value, ModuleType)):
            super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return sorted(
            {name for name in super().__dir__() if name.startswith("__")} | {*self._places}
        )


def _source(module: ModuleType) -> str:
    """The text of `module`, wherever its loader has it from."""
    # Asked by its method: the class of loaders that have it takes longer to import than all rooms.
    reader = getattr(module.__spec__ and module.__spec__.loader, "get_source", None)
    text: str | None = None if reader is None else reader(module.__name__)
    if text is None:
        raise ImportError(
            f"the source text of {module.__name__} is missing, which tells where its names are"
        )
    return text


def _imports(source: str) -> Iterator[tuple[str, str]]:
    """(name, module) of every import in the blocks ``if TYPE_CHECKING`` of `source`."""
    for block in ast.parse(source).body:
        if (
            isinstance(block, ast.If)
            and isinstance(block.test, ast.Name)
            and block.test.id == "TYPE_CHECKING"
        ):
            for line in block.body:
                if isinstance(line, ast.ImportFrom) and line.module and not line.level:
                    yield from ((name.asname or name.name, line.module) for name in line.names)
