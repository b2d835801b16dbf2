"""The values of a strategy as a protocol file holds them: numbers and spreads, schedules, pushes, points."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from cyclemap.checks import positive_number, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import SidePush
from cyclemap.resets.protocol.exact_units import DEGREES, MILLIMETRES, NUMBER, Unit
from cyclemap.resets.protocol.located import located
from cyclemap.resets.strategies.schedules import GoldenAngle, Independent, LatinBlocks, Schedule, Sobol, VanDerCorput
from cyclemap.resets.strategies.spread import Number, Spread
from cyclemap.suggestions import unknown_name

ANY, _WEIGHT = "any", "weight"
_PUSH_UNITS = {"fraction": NUMBER, "angle_deg": DEGREES, "push_mm": MILLIMETRES}
_PLAIN_SCHEDULES: dict[str, type[Schedule]] = {
    "independent": Independent,
    "golden-angle": GoldenAngle,
    "van-der-corput": VanDerCorput,
    "sobol": Sobol,
}
_BLOCKS = "latin-blocks"
SCHEDULE_NAMES = (*_PLAIN_SCHEDULES, _BLOCKS)


@dataclass(frozen=True)
class Codec:
    """How one value is written into a table, and read from it; `read` raises InvalidInput for what cannot be."""

    write: Callable[[Any], object]
    read: Callable[[object], Any]


# -- numbers -------------------------------------------------------------------------------------------------


def number_codec(unit: Unit) -> Codec:
    """Return how a fixed number of `unit` is kept."""
    return Codec(unit.written, unit.read)


def spread_codec(unit: Unit, turns: bool = False) -> Codec:
    """Return how a number of `unit` is kept that is fixed or drawn; of angles that `turns`, "any" is a full turn.

    A spread is [low, high]; where that does not say all, { low, high, around }.

    >>> length = spread_codec(MILLIMETRES)
    >>> length.read([20, 50])
    Spread(low=0.02, high=0.05, around=False)
    >>> spread_codec(DEGREES, turns=True).write(Spread.full_turn())
    'any'
    """
    return Codec(lambda value: _write_number(value, unit, turns), lambda value: _read_number(value, unit, turns))


def _write_number(value: Number, unit: Unit, turns: bool) -> object:
    if not isinstance(value, Spread):
        return unit.written(value)
    if turns and value == Spread.full_turn():
        return ANY
    ends = [unit.written(value.low), unit.written(value.high)]
    if _read_number(ends, unit, turns) == value:
        return ends
    return {"low": ends[0], "high": ends[1], "around": value.around}


def _read_number(value: object, unit: Unit, turns: bool) -> Number:
    if turns and value == ANY:
        return Spread.full_turn()
    if isinstance(value, list):
        if len(value) != 2:
            raise InvalidInput(f"a spread is [low, high], not a list of {len(value)}")
        low, high = (unit.read(end) for end in value)
        # All around the circle both ends are the same direction.
        return Spread(low, high, around=turns and abs((high - low) / (2.0 * math.pi) - 1.0) <= 1e-12)
    if isinstance(value, Mapping):
        given = checked_table(value, ("low", "high", "around"), ("low", "high"))
        return Spread(unit.read(given["low"]), unit.read(given["high"]), _boolean("around", given.get("around", False)))
    if isinstance(value, str):
        also = f" or {ANY!r}" if turns else ""
        raise InvalidInput(f"must be a number, [low, high]{also}, not {value!r}")
    return unit.read(value)


# -- tables --------------------------------------------------------------------------------------------------


def checked_table(value: object, known: tuple[str, ...], needed: tuple[str, ...] = ()) -> dict[str, object]:
    """Return a table with none but `known` keys and all the `needed` ones, or raise InvalidInput."""
    if not isinstance(value, Mapping):
        raise InvalidInput(f"must be a table with {', '.join(known)}, not {value!r}")
    for key in value:
        if key not in known:
            raise unknown_name("key", key, known)
    for key in needed:
        if key not in value:
            raise InvalidInput(f"{key} is missing")
    return dict(value)


def _whole(name: str, value: object, least: int) -> int:
    return whole_number(name, float(value) if isinstance(value, Decimal) else value, least=least)


def _boolean(name: str, value: object) -> bool:
    if not isinstance(value, bool):
        raise InvalidInput(f"{name} must be true or false, not {value!r}")
    return value


# -- schedules -----------------------------------------------------------------------------------------------


def write_schedule_value(schedule: Schedule) -> object:
    """Return the name of a schedule, with its numbers where it has some; InvalidInput for one of the user's own."""
    for name, kind in _PLAIN_SCHEDULES.items():
        if type(schedule) is kind:
            return name
    if type(schedule) is LatinBlocks:
        return {"kind": _BLOCKS, "size": schedule.size, "jitter": schedule.jitter}
    raise InvalidInput(
        f"{type(schedule).__name__} is a schedule of your own, which a protocol file cannot hold: write what it draws, "
        "cycle by cycle, as a CSV file with write_schedule, and give that to the robot"
    )


def read_schedule_value(value: object) -> Schedule:
    """Return the schedule of a name, or of a table with its kind.

    >>> read_schedule_value({"kind": "latin-blocks", "size": 8})
    LatinBlocks(size=8, jitter=True)
    """
    given = {"kind": value} if isinstance(value, str) else value
    table = checked_table(given, ("kind", "size", "jitter"), ("kind",))
    name = table.pop("kind")
    if not isinstance(name, str) or name not in SCHEDULE_NAMES:
        raise unknown_name("schedule", str(name), SCHEDULE_NAMES)
    if name in _PLAIN_SCHEDULES:
        if table:
            raise InvalidInput(f"{next(iter(table))} belongs to {_BLOCKS}, not to {name}")
        return _PLAIN_SCHEDULES[name]()
    blocks = LatinBlocks()
    size = _whole("size", table.get("size", blocks.size), least=1)
    return LatinBlocks(size, _boolean("jitter", table.get("jitter", blocks.jitter)))


# -- pushes and points ---------------------------------------------------------------------------------------


def write_push(push: SidePush) -> dict[str, object]:
    """Return a push as a table with the keys of --set."""
    numbers = zip(_PUSH_UNITS.items(), (push.fraction, push.angle, push.distance), strict=True)
    return {"side": push.side, **{key: unit.written(value) for (key, unit), value in numbers}}


def read_push(value: object) -> SidePush:
    """Return the push of a table: side, fraction and push_mm, and angle_deg where it is not 0.

    >>> read_push({"side": 2, "fraction": 0.6, "push_mm": 80})
    SidePush(side=2, fraction=0.6, angle=0.0, distance=0.08)
    """
    table = {"angle_deg": 0, **checked_table(value, ("side", *_PUSH_UNITS), ("side", "fraction", "push_mm"))}
    numbers = []
    for key, unit in _PUSH_UNITS.items():
        with located(f"{key} = {table[key]}"):
            numbers.append(unit.read(table[key]))
    return SidePush(_whole("side", table["side"], least=0), *numbers)


def write_weighted_pushes(pushes: tuple[SidePush, ...], weights: tuple[float, ...] | None) -> list[dict[str, object]]:
    """Return pushes as tables, each with its weight where they have any."""
    rows = [write_push(push) for push in pushes]
    if weights is None:
        return rows
    return [{**row, _WEIGHT: NUMBER.written(weight)} for row, weight in zip(rows, weights, strict=True)]


def read_weighted_pushes(value: object) -> tuple[tuple[SidePush, ...], tuple[float, ...] | None]:
    """Return the pushes of tables, and their weights: either all have one, or none."""
    rows = _rows(value)
    weighted = sum(_WEIGHT in row for row in rows)
    if weighted not in (0, len(rows)):
        raise InvalidInput(f"{weighted} of {len(rows)} pushes have a weight: give all of them one, or none")
    pushes, weights = [], []
    for index, row in enumerate(rows):
        with located(f"push {index + 1}"):
            checked_table(row, ("side", *_PUSH_UNITS, _WEIGHT))
            pushes.append(read_push({key: part for key, part in row.items() if key != _WEIGHT}))
            if weighted:
                weights.append(_weight(row[_WEIGHT]))
    return tuple(pushes), tuple(weights) if weighted else None


def _read_unweighted(value: object) -> tuple[SidePush, ...]:
    pushes, weights = read_weighted_pushes(value)
    if weights is not None:
        raise InvalidInput("pushes that come in turn have no weight: leave it out, or draw them (kind = drawn-pushes)")
    return pushes


def _weight(value: object) -> float:
    with located(f"{_WEIGHT} = {value}"):
        return positive_number(_WEIGHT, NUMBER.read(value))


def _rows(value: object) -> list[Mapping[str, object]]:
    if not isinstance(value, list) or not value or not all(isinstance(row, Mapping) for row in value):
        raise InvalidInput(f"must be one or more tables of a push (side, fraction, angle_deg, push_mm), not {value!r}")
    return value


def _write_point(point: tuple[float, float]) -> list[object]:
    return [MILLIMETRES.written(part) for part in point]


def _read_point(value: object) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise InvalidInput(f"must be a point [x, y], not {value!r}")
    return MILLIMETRES.read(value[0]), MILLIMETRES.read(value[1])


def _read_points(value: object) -> tuple[tuple[float, float], ...]:
    if not isinstance(value, list):
        raise InvalidInput(f"must be a list of points [[x, y], ...], not {value!r}")
    return tuple(_read_point(part) for part in value)


POINT = Codec(_write_point, _read_point)
POINTS = Codec(lambda points: [_write_point(point) for point in points], _read_points)
PUSH = Codec(write_push, read_push)
PUSHES = Codec(lambda pushes: write_weighted_pushes(pushes, None), _read_unweighted)
SCHEDULE = Codec(write_schedule_value, read_schedule_value)
