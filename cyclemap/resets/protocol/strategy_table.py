"""A strategy as a table of a protocol file, and back: every built-in one, and combinations of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cyclemap.errors import InvalidInput
from cyclemap.resets.protocol.exact_units import DEGREES, MILLIMETRES, NUMBER
from cyclemap.resets.protocol.located import located
from cyclemap.resets.protocol.scheduled_actions import ScheduledActions
from cyclemap.resets.protocol.strategy_values import (
    POINT,
    POINTS,
    PUSH,
    PUSHES,
    SCHEDULE,
    Codec,
    checked_table,
    number_codec,
    read_weighted_pushes,
    spread_codec,
    write_weighted_pushes,
)
from cyclemap.resets.strategies.combined import Combined
from cyclemap.resets.strategies.drag_strategies import (
    GripperTurn,
    RingPlace,
    ScatteredAim,
    StraightReset,
    TrailingLeg,
    WayPoints,
)
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes, VariedPush
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.suggestions import unknown_name

Table = dict[str, object]


@dataclass(frozen=True)
class Entry:
    """A key of a table: the field of the strategy that it holds, how, and whether it may be left out."""

    key: str
    field: str
    codec: Codec
    needed: bool = False


_SCHEDULE = Entry("schedule", "schedule", SCHEDULE)
_LENGTH, _DIRECTION = spread_codec(MILLIMETRES), spread_codec(DEGREES, turns=True)

_ENTRIES: dict[str, tuple[type, tuple[Entry, ...]]] = {
    "straight": (StraightReset, ()),
    "way-points": (WayPoints, (Entry("way_points_mm", "points", POINTS, needed=True),)),
    "ring-place": (RingPlace, (Entry("hitch_mm", "hitch", POINT, needed=True),)),
    "trailing-leg": (
        TrailingLeg,
        (
            Entry("length_mm", "length", _LENGTH, needed=True),
            Entry("direction_deg", "direction", _DIRECTION),
            Entry("side_step_mm", "side_step", _LENGTH),
            _SCHEDULE,
        ),
    ),
    "scattered-aim": (
        ScatteredAim,
        (Entry("radius_mm", "radius", number_codec(MILLIMETRES), needed=True), _SCHEDULE),
    ),
    "gripper-turn": (GripperTurn, (Entry("turn_deg", "turn", _DIRECTION), _SCHEDULE)),
    "alternating-pushes": (AlternatingPushes, (Entry("pushes", "pushes", PUSHES, needed=True),)),
    # Their weights stand with the pushes.
    "drawn-pushes": (DrawnPushes, (_SCHEDULE,)),
    "varied-push": (
        VariedPush,
        (
            Entry("push", "push", PUSH, needed=True),
            Entry("fraction", "fraction", spread_codec(NUMBER)),
            Entry("angle_deg", "angle", spread_codec(DEGREES)),
            Entry("push_mm", "distance", _LENGTH),
            _SCHEDULE,
        ),
    ),
}
_COMBINED, _DEEPEST = "combined", 8
STRATEGY_KINDS = (*_ENTRIES, _COMBINED)


def strategy_table(strategy: ResetStrategy) -> Table:
    """Return a strategy as a table with its `kind`, in millimetres and degrees that read back exactly.

    Raises InvalidInput for a strategy of the user's own.

    >>> table = strategy_table(TrailingLeg(0.05))
    >>> table["kind"], str(table["length_mm"]), table["direction_deg"], table["schedule"]
    ('trailing-leg', '50.0', 'any', 'independent')
    """
    if type(strategy) is Combined:
        return {"kind": _COMBINED, "parts": [strategy_table(part) for part in strategy.parts]}
    for kind, (made, entries) in _ENTRIES.items():
        if type(strategy) is made:
            return {"kind": kind, **_weighted(strategy), **_written(strategy, entries)}
    raise InvalidInput(_refusal(strategy))


def _refusal(strategy: object) -> str:
    way_out = "a protocol file cannot hold it: write its cycles as a CSV file with write_schedule"
    if isinstance(strategy, ScheduledActions):
        return f"a schedule of {len(strategy.scheduled)} cycles is no rule, and {way_out}"
    if isinstance(strategy, ResetStrategy):
        return (
            f"{strategy.name!r} ({type(strategy).__name__}) is a strategy of your own, so that {way_out}, which the "
            "robot program reads, and which ScheduledActions(read_schedule(FILE)) follows"
        )
    return f"{strategy!r} is no reset strategy; know {', '.join(STRATEGY_KINDS)}"


def _written(strategy: object, entries: tuple[Entry, ...]) -> Table:
    return {entry.key: entry.codec.write(getattr(strategy, entry.field)) for entry in entries}


def _weighted(strategy: object) -> Table:
    if not isinstance(strategy, DrawnPushes):
        return {}
    return {"pushes": write_weighted_pushes(strategy.pushes, strategy.weights)}


def strategy_from_table(table: object, place: str = "[strategy]") -> ResetStrategy:
    """Return the strategy of a table, `place` in its file.

    Raises InvalidInput that names the place, the key, its value, and what there is to choose from.

    >>> strategy_from_table({"kind": "gripper-turn", "turn_deg": [-90, 90]}).name
    'gripper turn'
    """
    with located(place):
        kind, given = _kind(table)
    if kind == _COMBINED:
        return _combined(given, place)
    made, entries = _ENTRIES[kind]
    pushes = ("pushes",) if made is DrawnPushes else ()
    known = (*pushes, *(entry.key for entry in entries))
    with located(f"{place} of kind {kind!r}"):
        checked_table(given, known, (*pushes, *(entry.key for entry in entries if entry.needed)))
        fields = _drawn_fields(given) if pushes else {}
        fields |= {entry.field: _read(entry, given[entry.key]) for entry in entries if entry.key in given}
        with located(f"with {', '.join(f'{key} = {_shown(value)}' for key, value in given.items())}"):
            strategy: ResetStrategy = made(**fields)
    return strategy


def _kind(table: object) -> tuple[str, Table]:
    if not isinstance(table, Mapping):
        raise InvalidInput(f"must be a table, not {table!r}")
    given = dict(table)
    kind = given.pop("kind", None)
    if not isinstance(kind, str):
        told = "has no kind" if kind is None else f"kind = {kind!r} is no text"
        raise InvalidInput(
            f"{told}: give kind, one of {', '.join(sorted(STRATEGY_KINDS))} (--set keys go into tables of other names)"
        )
    if kind not in STRATEGY_KINDS:
        raise unknown_name("kind of strategy", kind, STRATEGY_KINDS)
    return kind, given


def _combined(given: Table, place: str) -> Combined:
    with located(f"{place} of kind {_COMBINED!r}"):
        checked_table(given, ("parts",), ("parts",))
        parts = given["parts"]
        if not isinstance(parts, list) or not parts:
            raise InvalidInput("parts must be one or more tables [[strategy.parts]]")
        if place.count(".parts") >= _DEEPEST:
            raise InvalidInput(f"parts within parts are nested too deeply: {_DEEPEST} levels are enough for any")
    inner = place.strip("[]")
    made = tuple(strategy_from_table(part, f"[[{inner}.parts]] {n}") for n, part in enumerate(parts, 1))
    with located(place):
        return Combined(made)


def _drawn_fields(given: Table) -> dict[str, Any]:
    with located("pushes"):
        pushes, weights = read_weighted_pushes(given["pushes"])
    return {"pushes": pushes, "weights": weights}


def _read(entry: Entry, value: object) -> Any:
    with located(f"{entry.key} = {_shown(value)}"):
        return entry.codec.read(value)


def _shown(value: object) -> str:
    """A value as the file has it, cut short."""
    if isinstance(value, list):
        text = f"[{', '.join(map(_shown, value))}]"
    else:
        text = repr(value) if isinstance(value, str) else str(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
