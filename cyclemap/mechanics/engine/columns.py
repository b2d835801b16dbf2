"""Numbers that pass between Python and C one behind the other, and structures that hold them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import SimpleNamespace
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Columns:
    """A row of numbers: how C calls its length and, after a prefix, its places.

    entries : their names, with a space between; those of vectors with a colon and their length.

    >>> place = Columns("PLACE_SIZE", "PLACE_", "kind at:2")
    >>> place.names, place.size, place.at("at"), place.of([1, 2, 3]).at
    (('kind', 'at'), 3, 1, [2, 3])
    """

    size_name: str
    prefix: str
    entries: str

    @cached_property
    def _places(self) -> list[tuple[str, int, int]]:
        """Name, first place and length (0: a number) of each entry."""
        places, start = [], 0
        for entry in self.entries.split():
            name, _, length = entry.partition(":")
            places.append((name, start, int(length or 0)))
            start += int(length or 1)
        return places

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names in their order."""
        return tuple(name for name, _, _ in self._places)

    @cached_property
    def size(self) -> int:
        """How many numbers there are."""
        _, start, length = self._places[-1]
        return start + max(length, 1)

    def at(self, name: str) -> int:
        """Return the place of a number, or of a vector's first."""
        return next(start for other, start, _ in self._places if other == name)

    @cached_property
    def _where(self) -> dict[str, int | slice]:
        """By name: its place, or those of a vector."""
        return {
            name: slice(start, start + length) if length else start
            for name, start, length in self._places
        }

    def of(self, row: Any) -> Any:
        """Return the numbers of a row, or an expression, under their names; vectors as slices."""
        return SimpleNamespace(**{name: row[place] for name, place in self._where.items()})

    def columns_of(self, table: np.ndarray[Any, Any]) -> Any:
        """Return the columns of a table (n, size, ...) under their names."""
        return SimpleNamespace(**{name: table[:, place] for name, place in self._where.items()})

    def enum(self) -> str:
        """Return the enum of C: all places, and the length."""
        places = {f"{self.prefix}{name.upper()}": start for name, start, _ in self._places}
        return enum_of(places | {self.size_name: self.size})


@dataclass(frozen=True)
class Structure:
    """A structure of C: structures in it, with their names; then names of numbers, of whole numbers
    and of tables, with a space between, those of several with a colon and their count.
    """

    name: str
    numbers: str
    wholes: str
    tables: str
    inner: tuple[tuple[str, "Structure"], ...] = ()

    @cached_property
    def dtype(self) -> np.dtype[np.void]:
        """The structure as numpy lays it out; tables are addresses."""
        return self.laid_out(np.dtype(np.uintp))

    def laid_out(self, address: np.dtype[Any]) -> np.dtype[np.void]:
        """The structure where tables have addresses of that kind."""
        fields: list[Any] = [(name, inner.laid_out(address)) for name, inner in self.inner]
        for kind, names in (("f8", self.numbers), ("i8", self.wholes), (address, self.tables)):
            for entry in names.split():
                name, _, count = entry.partition(":")
                fields.append((name, kind, int(count)) if count else (name, kind))
        return np.dtype(fields, align=True)

    def definition(self) -> str:
        """Return the definition in C."""
        lines = [f"    {inner.name} {name};" for name, inner in self.inner]
        kinds = {"double ": self.numbers, "int64_t ": self.wholes, "const double *": self.tables}
        for kind, names in kinds.items():
            for entry in names.split():
                name, _, count = entry.partition(":")
                lines.append(f"    {kind}{name}{f'[{count}]' if count else ''};")
        return "\n".join([f"typedef struct {self.name} {{", *lines, f"}} {self.name};"])


def places_in(laid: np.dtype[Any]) -> dict[str, tuple[int, str]]:
    """Return where each number or table of a structure begins, bytes, and its kind, by dotted name.

    >>> inner = Structure("Inner", "", "count", "")
    >>> outer = Structure("Outer", "size", "", "at", (("in", inner),))
    >>> places_in(outer.laid_out(np.dtype("u4")))
    {'in.count': (0, 'whole'), 'size': (8, 'number'), 'at': (16, 'table')}
    """
    kinds = {"f": "number", "i": "whole", "u": "table"}
    places: dict[str, tuple[int, str]] = {}
    for name, (kind, start, *_) in (laid.fields or {}).items():
        for key, (at, of) in places_in(kind).items():
            places[f"{name}.{key}"] = (start + at, of)
        if not kind.fields:
            places[name] = (start, kinds[kind.base.kind])
    return places


def enum_of(values: dict[str, int]) -> str:
    """Return an enum of C.

    >>> enum_of({"STICK": 0, "SLIDE": 1})
    'enum { STICK = 0, SLIDE = 1 };'
    """
    return f"enum {{ {', '.join(f'{name} = {value}' for name, value in values.items())} }};"


def numbered(names: Sequence[str], prefix: str = "", size_name: str = "") -> str:
    """Return an enum of C that numbers names from 0 on, and how many there are where that has a
    name.
    """
    values = {f"{prefix}{name.upper()}": index for index, name in enumerate(names)}
    return enum_of(values | ({size_name: len(names)} if size_name else {}))


def braced(values: Iterable[object]) -> str:
    """Return an initializer of C."""
    return f"{{{', '.join(map(str, values))}}}"
