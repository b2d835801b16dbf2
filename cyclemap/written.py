"""How results and files are written: fields in the unit and by the name that their metadata say,
decimals that lead back exactly, TOML, and checksums.

Results hold SI units and radians; files and JSON hold degrees and millimetres, and tell so in their
names.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from decimal import ROUND_HALF_EVEN, Context, Decimal, DecimalException
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from cyclemap.errors import DataFileError, InvalidInput

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Known = TypeVar("Known")
Report = TypeVar("Report")
Json = dict[str, object]
Table = Mapping[str, object]

# More digits than any double needs beside the unit's factor.
_DIGITS = 60
_CONTEXT = Context(prec=_DIGITS, rounding=ROUND_HALF_EVEN)
_PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494")
# A decimal of at most this many digits is read as people's software reads it.
_SHORT = 15
_MOST_DIGITS = 40
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_CHECKSUM = re.compile(r"^# checksum: ([0-9a-f]{16})\n", re.MULTILINE)


@dataclass(frozen=True)
class Unit:
    """What written numbers are in: the ending of their names, and what makes them of SI units."""

    ending: str
    of_si: Callable[[float], float]

    @property
    def sign(self) -> str:
        """What follows a number in a sentence."""
        return "°" if self.ending == "deg" else f" {self.ending}".rstrip()

    def named(self, name: str) -> str:
        """Return the name of a number that is written in this unit."""
        return f"{name}_{self.ending}" if self.ending else name


def direction_deg(radians: float) -> float:
    """Return a direction in degrees in [0, 360); a hair below zero must not round to 360."""
    return math.degrees(radians) % 360.0 % 360.0


@dataclass(frozen=True)
class FileUnit(Unit):
    """A unit of the files that people edit: what one of it is in SI units.

    Not every number of metres (or radians) is a thousandth (or pi/180) of a double. So numbers are
    written as decimals with as many digits as it takes, and read by exact arithmetic, rounded once.

    >>> MILLIMETRES.read(Decimal("49.75")), str(MILLIMETRES.written(0.04975))
    (0.04975, '49.75')
    >>> str(MILLIMETRES.written(0.01378)), 1000 * 0.01378
    ('13.78', 13.780000000000001)
    >>> DEGREES.read(DEGREES.written(1.0)) == 1.0
    True
    """

    in_si: Decimal

    def read(self, number: object) -> float:
        """Return a number of this unit in SI units;
        InvalidInput for what is not a finite number."""
        if isinstance(number, bool) or not isinstance(number, (int, float, Decimal)):
            raise InvalidInput(f"must be a number, not {number!r}")
        decimal = Decimal(repr(number)) if isinstance(number, float) else Decimal(number)
        if not decimal.is_finite():
            raise InvalidInput(f"must be a finite number, not {number}")
        try:
            # Noughts at the end say nothing, and a file leaves them out.
            given = decimal.normalize(_CONTEXT)
            if self.ending == "deg" and len(given.as_tuple().digits) <= _SHORT:
                # The same as a setting of the command line gives.
                read = math.radians(float(given))
            else:
                read = float(_CONTEXT.multiply(given, self.in_si))
        except DecimalException as error:
            raise InvalidInput("is too large or too small to be read") from error
        if not math.isfinite(read):
            raise InvalidInput(f"must be a finite number, not {number}")
        return read

    def written(self, value: float) -> Decimal:
        """Return the shortest decimal, of those tried, that `read` gives back as `value`."""
        exact = _CONTEXT.divide(Decimal(value), self.in_si)
        # The double next to it may be 13.780000000000001 where 13.78 leads back, too.
        for short in (float(Context(prec=_SHORT).plus(exact)), float(exact)):
            if self.read(short) == value:
                return Decimal(repr(short))
        for digits in range(_SHORT, _MOST_DIGITS):
            decimal = Context(prec=digits, rounding=ROUND_HALF_EVEN).plus(exact)
            if self.read(decimal) == value:
                return decimal
        raise InvalidInput(
            f"{value!r} is too small or too large to be written in {self.ending or 'a file'}"
        )


NUMBER = FileUnit("", float, Decimal(1))
DEGREES = FileUnit("deg", math.degrees, _CONTEXT.divide(_PI, Decimal(180)))
MILLIMETRES = FileUnit("mm", lambda metres: 1e3 * metres, Decimal("0.001"))
# What people are told SI units in.
_READABLE = {"rad": DEGREES, "m": MILLIMETRES, "1": NUMBER}
# Metadata of fields: angles, directions of the circle, cycles, and what is not written.
ANGLE = {"unit": DEGREES}
DIRECTION = {"unit": Unit("deg", direction_deg)}
CYCLES = {"unit": Unit("cycles", float)}
UNWRITTEN = {"name": ""}


def readable_unit(unit: str) -> Unit:
    """Return the unit that people are told numbers of an SI unit in."""
    return _READABLE.get(unit, Unit(unit, float))


def written(value: Any, unit: Unit = NUMBER) -> Any:
    """Return what JSON holds of a value: numbers in their unit, None for those that are not finite.

    >>> written((0.5, math.inf, np.array([1, 2]), "words"))
    [0.5, None, [1, 2], 'words']
    """
    if value is None or isinstance(value, (str, int)):
        return value
    if isinstance(value, float):
        return unit.of_si(value) if math.isfinite(value) else None
    if isinstance(value, (np.ndarray, np.generic)):
        return written(value.tolist(), unit)
    if isinstance(value, Path):
        return str(value)
    if is_dataclass(value) and not isinstance(value, type):
        return json_of(value, unit=unit)
    if isinstance(value, Mapping):
        return {str(name): written(entry, unit) for name, entry in value.items()}
    return [written(entry, unit) for entry in value]


def if_known(report: Callable[[Known], Report], result: Known | None) -> Report | None:
    """Return the report of a result, None where there is none.

    >>> if_known(math.degrees, None), if_known(abs, -1)
    (None, 1)
    """
    return None if result is None else report(result)


def json_of(result: DataclassInstance, *names: str, unit: Unit = NUMBER, **units: Unit) -> Json:
    """Return the fields of a result by their written names, in their units; or those of `names`.

    A name may be a property's, too.
    unit : of what has none in its metadata.
    units : the same of single names.

    >>> from cyclemap.maps import RestMultiplier
    >>> json_of(RestMultiplier(0.5, 0.4, 0.6, 50, math.pi), "value", "theta")
    {'value': 0.5, 'theta_deg': 180.0}
    """
    metadata = {field.name: field.metadata for field in fields(result)}
    entries: Json = {}
    for name in names or metadata:
        said: Mapping[str, Any] = metadata.get(name, {})
        base = said.get("name", name)
        own = said.get("unit", units.get(name, unit))
        if base:
            entries[own.named(base)] = written(getattr(result, name), own)
    return entries


def json_text(report: Json) -> str:
    """The text of a report, ending with a line break; NaN and infinities are refused."""
    return json.dumps(report, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def rows(**columns: object) -> list[Json]:
    """Return columns of the same length as rows.

    >>> rows(cycle=[0, 1], turn_deg=np.array([0.5, 0.25]))
    [{'cycle': 0, 'turn_deg': 0.5}, {'cycle': 1, 'turn_deg': 0.25}]
    """
    cells = zip(*map(written, columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in cells]


def degrees(radians: object) -> Any:
    """Return an angle, or angles in an array or list, as `written` in degrees."""
    return written(radians, DEGREES)


def decimal_text(number: Decimal) -> str:
    """Return a decimal as people, TOML and CSV write it, with all its digits.

    >>> decimal_text(Decimal("5E+1")), decimal_text(Decimal("0.50")), decimal_text(Decimal("1e-30"))
    ('50', '0.5', '1e-30')
    """
    if number == 0:
        return "0"
    if not -12 < number.adjusted() < 20:
        return f"{number:e}"
    plain = f"{number:f}"
    return plain.rstrip("0").rstrip(".") if "." in plain else plain


def toml_text(
    tables: Mapping[str, Table],
    comments: tuple[str, ...] = (),
    notes: Mapping[str, str] | None = None,
) -> str:
    """Return named tables as TOML, `comments` before them, one a line, and `notes` on keys of
    tables above these.

    Values are texts, booleans, numbers, lists of them, small tables (written inline) and lists of
    tables (arrays of tables). Decimals keep all their digits. Raises InvalidInput for any other
    value.

    >>> push = {"side": 2, "push_mm": Decimal("80.5"), "parts": [{"kind": "straight"}]}
    >>> print(toml_text({"push": push}, ("Mine.",)))
    # Mine.
    <BLANKLINE>
    [push]
    side = 2
    push_mm = 80.5
    <BLANKLINE>
    [[push.parts]]
    kind = "straight"
    <BLANKLINE>
    """
    lines = [f"# {line}".rstrip() for comment in comments for line in comment.splitlines() or [""]]
    for name, table in tables.items():
        lines += ["", f"[{toml_key(name)}]", *_body(toml_key(name), table, notes or {})]
    return "\n".join(lines).lstrip("\n") + "\n"


def _body(path: str, table: Table, notes: Mapping[str, str]) -> Iterator[str]:
    """The lines of one table: its values first, notes above them, then its arrays of tables."""
    nested = {
        key: value
        for key, value in table.items()
        if isinstance(value, (list, tuple))
        and value
        and all(isinstance(row, Mapping) for row in value)
    }
    for key, value in table.items():
        if key not in nested:
            yield from [f"# {notes[key]}"] if key in notes else []
            yield f"{toml_key(key)} = {toml_value(value)}"
    for key, rows in nested.items():
        inner = f"{path}.{toml_key(key)}"
        for row in rows:
            yield from ("", f"[[{inner}]]", *_body(inner, row, {}))


def toml_value(value: object) -> str:
    """Return a value as TOML has it; InvalidInput for what it cannot have.

    >>> toml_value([True, 0.5, "rust"])
    '[true, 0.5, "rust"]'
    """
    if isinstance(value, (bool, int, str)):
        # As in JSON, which leaves one control character as it is.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Decimal):
        return decimal_text(value)
    if isinstance(value, float):
        return float.__repr__(value)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(toml_value, value))}]"
    if isinstance(value, Mapping):
        entries = (f"{toml_key(key)} = {toml_value(entry)}" for key, entry in value.items())
        return f"{{ {', '.join(entries)} }}"
    raise InvalidInput(
        f"{value!r} cannot be written as TOML: give a text, number, boolean, list or table"
    )


def toml_key(name: str) -> str:
    """Return a name as the key of a table."""
    return name if _BARE_KEY.fullmatch(name) else toml_value(name)


def with_checksum(text: str) -> str:
    """Return a text whose first line, a comment, tells the checksum of the rest.

    >>> len(with_checksum("side = 2").splitlines()[0])
    28
    """
    return f"# checksum: {_digest(text)}\n{text}"


def check_checksum(path: str | Path, text: str) -> None:
    """Raise DataFileError where a text has a checksum and is not what it was made of; one without
    is any text.
    """
    line = _CHECKSUM.search(text)
    if line is not None and _digest(text[: line.start()] + text[line.end() :]) != line.group(1):
        raise DataFileError(
            f"{path}: not as it was written (its checksum differs): write it anew, or take the "
            f"line '{line.group(0).rstrip()}' out where the change is meant"
        )


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]
