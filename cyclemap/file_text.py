"""What the files are made of: decimals that lead back exactly, TOML text, checksums, places of
errors.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from decimal import ROUND_HALF_EVEN, Context, Decimal, DecimalException
from pathlib import Path

from cyclemap.errors import DataFileError, InvalidInput

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
class FileUnit:
    """A unit of the files: its name, and what one of it is in SI units.

    Not every number of metres (or radians) is a thousandth (or pi/180) of a double. So numbers are
    written as decimals with as many digits as it takes, and read by exact arithmetic, rounded once.

    >>> MILLIMETRES.read(Decimal("49.75")), str(MILLIMETRES.written(0.04975))
    (0.04975, '49.75')
    >>> str(MILLIMETRES.written(0.01378)), 1000 * 0.01378
    ('13.78', 13.780000000000001)
    >>> DEGREES.read(DEGREES.written(1.0)) == 1.0
    True
    """

    name: str
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
            if self.name == "degrees" and len(given.as_tuple().digits) <= _SHORT:
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
        raise InvalidInput(f"{value!r} is too small or too large to be written in {self.name}")


MILLIMETRES = FileUnit("mm", Decimal("0.001"))
DEGREES = FileUnit("degrees", _CONTEXT.divide(_PI, Decimal(180)))
NUMBER = FileUnit("its own unit", Decimal(1))


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
        lines += ["", f"[{_key(name)}]", *_body(_key(name), table, notes or {})]
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
            yield f"{_key(key)} = {_value(value)}"
    for key, rows in nested.items():
        inner = f"{path}.{_key(key)}"
        for row in rows:
            yield from ("", f"[[{inner}]]", *_body(inner, row, {}))


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # A basic string is that of JSON, which leaves one control character as it is.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Decimal):
        return decimal_text(value)
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, Mapping):
        return (
            f"{{ {', '.join(f'{_key(key)} = {_value(entry)}' for key, entry in value.items())} }}"
        )
    raise InvalidInput(
        f"{value!r} cannot be written as TOML: give a text, number, boolean, list or table"
    )


def _key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else _value(name)


@contextmanager
def located(place: str, kind: type[InvalidInput] = InvalidInput) -> Iterator[None]:
    """Say `place` before what is said of a bad value; raise it as `kind`.

    >>> with located("length_mm = -5"):
    ...     raise InvalidInput("must be positive")
    Traceback (most recent call last):
    ...
    cyclemap.errors.InvalidInput: length_mm = -5: must be positive
    """
    try:
        yield
    except DataFileError:
        raise
    except InvalidInput as error:
        raise kind(f"{place}: {error}") from error


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
