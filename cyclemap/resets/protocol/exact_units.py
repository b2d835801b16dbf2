"""Millimetres and degrees as decimals that lead back to the very metres and radians they were made from."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import ROUND_HALF_EVEN, Context, Decimal, DecimalException

from cyclemap.errors import InvalidInput

# More digits than any double needs beside the unit's factor.
_DIGITS = 60
_CONTEXT = Context(prec=_DIGITS, rounding=ROUND_HALF_EVEN)
_PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494")
# A decimal of at most this many digits is read as people's software reads it.
_SHORT = 15
_MOST_DIGITS = 40


@dataclass(frozen=True)
class Unit:
    """A unit of the files: its name, and what one of it is in SI units.

    Not every number of metres (or radians) is a thousandth (or pi/180) of a double. So numbers are written as decimals
    with as many digits as it takes, and read by exact arithmetic, rounded once.

    >>> MILLIMETRES.read(Decimal("49.75")), str(MILLIMETRES.written(0.04975))
    (0.04975, '49.75')
    >>> DEGREES.read(DEGREES.written(1.0)) == 1.0
    True
    """

    name: str
    in_si: Decimal

    def read(self, number: object) -> float:
        """Return a number of this unit in SI units; InvalidInput for what is not a finite number."""
        try:
            found = self._read(_checked_decimal(number))
        except DecimalException as error:
            raise InvalidInput("is too large or too small to be read") from error
        if not math.isfinite(found):
            raise InvalidInput(f"must be a finite number, not {number}")
        return found

    def _read(self, number: Decimal) -> float:
        # Noughts at the end say nothing, and a file leaves them out.
        given = number.normalize(_CONTEXT)
        if self.name == "degrees" and len(given.as_tuple().digits) <= _SHORT:
            # The same as a setting of the command line gives.
            return math.radians(float(given))
        return float(_CONTEXT.multiply(given, self.in_si))

    def written(self, value: float) -> Decimal:
        """Return the shortest decimal, of those tried, that `read` gives back as `value`."""
        exact = _CONTEXT.divide(Decimal(value), self.in_si)
        short = Decimal(repr(float(exact)))
        if self.read(short) == value:
            return short
        for digits in range(_SHORT, _MOST_DIGITS):
            found = Context(prec=digits, rounding=ROUND_HALF_EVEN).plus(exact)
            if self.read(found) == value:
                return found
        raise InvalidInput(f"{value!r} is too small or too large to be written in {self.name}")


MILLIMETRES = Unit("mm", Decimal("0.001"))
DEGREES = Unit("degrees", _CONTEXT.divide(_PI, Decimal(180)))
NUMBER = Unit("its own unit", Decimal(1))


def _checked_decimal(number: object) -> Decimal:
    """Return an int, float or Decimal as a Decimal; InvalidInput for anything else, and what is not finite."""
    if isinstance(number, bool) or not isinstance(number, (int, float, Decimal)):
        raise InvalidInput(f"must be a number, not {number!r}")
    found = Decimal(repr(number)) if isinstance(number, float) else Decimal(number)
    if not found.is_finite():
        raise InvalidInput(f"must be a finite number, not {number}")
    return found


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
