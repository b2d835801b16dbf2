"""How results are written: fields in the unit and by the name that their metadata say.

Results hold SI units and radians; files and JSON hold degrees and millimetres, and tell so in their
names.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Json = dict[str, object]


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


NUMBER = Unit("", float)
DEGREES = Unit("deg", math.degrees)
MILLIMETRES = Unit("mm", lambda metres: 1e3 * metres)
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
