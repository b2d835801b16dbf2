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
    """A structure of C: its name and fields: name, kind (number, whole, table or a structure),
    count (0: one).
    """

    name: str
    fields: tuple[tuple[str, "str | Structure", int], ...]

    @cached_property
    def dtype(self) -> np.dtype[np.void]:
        """The structure as numpy lays it out; tables are addresses."""
        return self.laid_out(np.dtype(np.uintp))

    def laid_out(self, address: np.dtype[Any]) -> np.dtype[np.void]:
        """The structure where tables have addresses of that kind."""
        kinds: dict[str, Any] = {"number": "f8", "whole": "i8", "table": address}
        fields = []
        for name, kind, count in self.fields:
            of = kind.laid_out(address) if isinstance(kind, Structure) else kinds[kind]
            fields.append((name, of, count) if count else (name, of))
        return np.dtype(fields, align=True)

    def places(self, address: np.dtype[Any]) -> dict[str, tuple[int, str]]:
        """Where each number or table of a structure begins, bytes, and its kind; by dotted names.

        >>> inner = Structure("Inner", (("count", "whole", 0),))
        >>> Structure("Outer", (("at", "table", 0), ("in", inner, 0))).places(np.dtype("u4"))
        {'at': (0, 'table'), 'in.count': (8, 'whole')}
        """
        laid = self.laid_out(address)
        places: dict[str, tuple[int, str]] = {}
        for name, kind, _ in self.fields:
            start = laid.fields[name][1] if laid.fields is not None else 0
            if isinstance(kind, Structure):
                inner = kind.places(address).items()
                places |= {f"{name}.{key}": (start + at, of) for key, (at, of) in inner}
            else:
                places[name] = (start, kind)
        return places

    def definition(self) -> str:
        """Return the definition in C."""
        kinds = {"number": "double ", "whole": "int64_t ", "table": "const double *"}
        lines = []
        for name, kind, count in self.fields:
            of = f"{kind.name} " if isinstance(kind, Structure) else kinds[kind]
            lines.append(f"    {of}{name}{f'[{count}]' if count else ''};")
        return "\n".join([f"typedef struct {self.name} {{", *lines, f"}} {self.name};"])


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
