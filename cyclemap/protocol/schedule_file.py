"""The schedule of a collection as a CSV file for the robot's program: one row a cycle; and back to
its actions.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from decimal import Decimal, InvalidOperation
from itertools import chain, pairwise
from pathlib import Path

from cyclemap.checks import whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import DataFileError, InvalidInput, located, unknown_name
from cyclemap.mechanics import SidePush
from cyclemap.mechanics.contact_curve import first_contact
from cyclemap.protocol.protocol_file import PUSH_UNITS, push_numbers
from cyclemap.protocol.strategy import CycleAction, Points, ResetStrategy
from cyclemap.text_files import (
    CsvRow,
    CsvTable,
    csv_table,
    read_text,
    require_columns,
    write_whole,
)
from cyclemap.written import (
    DEGREES,
    MILLIMETRES,
    FileUnit,
    check_checksum,
    decimal_text,
    with_checksum,
)

ROD_COLUMNS = ("rod_x_mm", "rod_y_mm", "push_dx", "push_dy")
PUSH_COLUMNS = ("cycle", "side", *PUSH_UNITS, *ROD_COLUMNS)
TURN_COLUMN = "gripper_turn_deg"
_LEG_COLUMNS = ("way_point_{}_x_mm", "way_point_{}_y_mm", "leg_{}_direction_deg", "leg_{}_mm")
# Told twice, as way-points and as legs: how far the two may be apart (mm).
_AGREE_MM = 1e-6
_DECIMALS = 9
_MOST_DIGITS = 18  # of a whole number

_COMMENTS = (
    "Schedule of a data collection: what the robot does, one row a cycle. Lengths in mm, angles "
    "in degrees,",
    "counter-clockwise. The rod's centre touches the object at (rod_x_mm, rod_y_mm) and moves "
    "push_mm straight along",
    "(push_dx, push_dy), both in the object's frame as it lies before the push; the same push by "
    "side, fraction of it,",
    "and angle from its inward normal. Then the rod drags the object by its ring, straight to "
    "way_point_1, and on",
    "to the target, which is (0, 0) of the world: leg_k runs from way_point_k to the next one, "
    "the last to the target.",
    "Blank: no such leg; none at all: straight to the target. At last a gripper turns the object "
    "about its ring.",
)


def write_schedule(
    path: str | Path, loop: CollectionLoop, strategy: ResetStrategy, cycles: int, seed: int = 0
) -> None:
    """Write what the robot does, cycle by cycle, as CSV; whole, or not at all.

    Parameters
    ----------
    path : str or Path
        The file to write.
    loop : CollectionLoop
        The loop.
    strategy : ResetStrategy
        What is run on it.
    cycles : int
        How many cycles.
    seed : int, default 0
        That of `run_strategy`, whose cycles they are.

    Raises
    ------
    InvalidInput
        For a bad value or a push that the object does not allow.
    OSError
        Where it cannot be written.

    Notes
    -----
    Columns: `PUSH_COLUMNS`; for each way-point its place and the direction and length of the leg
    that leaves it (way_point_1_x_mm, way_point_1_y_mm, leg_1_direction_deg, leg_1_mm, ...);
    gripper_turn_deg. The first line is a checksum of the rest. Every number that `read_schedule`
    needs has the digits that give it back exactly.

    Examples
    --------
    >>> import tempfile
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.protocol import read_schedule, write_schedule
    >>> from cyclemap.resets import ResetStrategy
    >>> loop = CollectionLoop.mit()
    >>> coin = ResetStrategy.pushes(loop.push, (1, 2))
    >>> with tempfile.TemporaryDirectory() as place:
    ...     write_schedule(f"{place}/run.csv", loop, coin, 3, seed=1)
    ...     found = read_schedule(f"{place}/run.csv")
    >>> found == tuple(action.filled(loop) for action in coin.run(3, seed=1))
    True
    """
    count = whole_number("cycles", cycles, least=1)
    stream = whole_number("seed", seed, least=0)
    prepared = strategy.prepared(loop)
    actions = tuple(action.filled(prepared) for action in strategy.run(count, stream))
    ring = ", ".join(
        decimal_text(MILLIMETRES.written(coordinate)) for coordinate in prepared.slider.hitch
    )
    facts = {
        "strategy": f"{len(strategy.actions)} actions, {strategy.order}",
        "needs": ", ".join(strategy.needs) or "nothing else",
        "object": f"{prepared.slider.name}, its ring at ({ring}) mm of its frame",
        "surface": " ".join(prepared.material.name.split()),
        "seed": str(stream),
        "cycles": str(count),
    }
    write_whole(Path(path), with_checksum(_text(prepared, actions, facts)).encode())


def _text(loop: CollectionLoop, actions: Sequence[CycleAction], facts: dict[str, str]) -> str:
    columns = _columns(max(len(action.way_points or ()) for action in actions))
    table = io.StringIO()
    writer = csv.DictWriter(table, columns, restval="", lineterminator="\n")
    writer.writeheader()
    pushes = {action.push: _push_cells(loop, action.push) for action in actions if action.push}
    for cycle, action in enumerate(actions):
        assert action.push is not None and action.way_points is not None
        row = {"cycle": cycle, **pushes[action.push], **_leg_cells(action.way_points)}
        writer.writerow({**row, TURN_COLUMN: decimal_text(DEGREES.written(action.turn))})
    head = [
        f"# {line}" for line in (*_COMMENTS, *(f"{name}: {fact}" for name, fact in facts.items()))
    ]
    return "\n".join([*head, table.getvalue()])


def _push_cells(loop: CollectionLoop, push: SidePush) -> dict[str, object]:
    """The push of a cycle by column: as `read_schedule` needs it, and as the robot does."""
    place, way = first_contact(loop.slider, push, loop.pusher.radius)
    motion = map(_rounded, (1e3 * place).tolist() + way.tolist())
    numbers = {key: decimal_text(number) for key, number in push_numbers(push).items()}
    return {"side": push.side, **numbers, **dict(zip(ROD_COLUMNS, motion, strict=True))}


def _leg_cells(way_points: Points) -> dict[str, str]:
    """The way-points of a cycle, and the legs between them and to the target, by column."""
    cells: dict[str, str] = {}
    for leg, ((x, y), (onward_x, onward_y)) in enumerate(pairwise((*way_points, (0.0, 0.0))), 1):
        dx = onward_x - x
        dy = onward_y - y
        texts = (
            decimal_text(MILLIMETRES.written(x)),
            decimal_text(MILLIMETRES.written(y)),
            _rounded(math.degrees(math.atan2(dy, dx))),
            _rounded(1e3 * math.hypot(dx, dy)),
        )
        cells |= dict(zip(_leg_columns(leg), texts, strict=True))
    return cells


def _leg_columns(leg: int) -> list[str]:
    return [name.format(leg) for name in _LEG_COLUMNS]


def _columns(legs: int) -> list[str]:
    of_legs = chain.from_iterable(map(_leg_columns, range(1, legs + 1)))
    return [*PUSH_COLUMNS, *of_legs, TURN_COLUMN]


def _rounded(value: float) -> str:
    """A number that only the robot needs: to a picometre, or a billionth of a degree."""
    return repr(round(value, _DECIMALS) + 0.0)


def read_schedule(path: str | Path) -> tuple[CycleAction, ...]:
    """Return the actions of a file of `write_schedule`, equal to those written.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    tuple of CycleAction
        One a cycle, with its push and way-points.

    Raises
    ------
    DataFileError
        Naming the line, where the file is cut short, damaged or edited: a cycle missing or out
        of order, a field that is no number, legs that do not run between the way-points beside
        them.

    Notes
    -----
    `ResetStrategy(actions, order="in turn")` follows them. The ring's place is not among them:
    give the loop the one that the file's comments name.

    Examples
    --------
    >>> import tempfile
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.protocol import read_schedule, write_schedule
    >>> from cyclemap.resets import ResetStrategy
    >>> loop = CollectionLoop.mit()
    >>> coin = ResetStrategy.pushes(loop.push, (1, 2))
    >>> with tempfile.TemporaryDirectory() as place:
    ...     write_schedule(f"{place}/run.csv", loop, coin, 4, seed=1)
    ...     actions = read_schedule(f"{place}/run.csv")
    >>> [action.push.side for action in actions]
    [2, 2, 1, 2]
    """
    table, facts = _read_commented(path)
    legs = 0
    while _LEG_COLUMNS[0].format(legs + 1) in table.header:
        legs += 1
    require_columns(table, _columns(legs))
    for name in table.header:
        if name not in _columns(legs):
            # A way-point whose name is damaged would be left out in silence.
            raise DataFileError(f"{path}: {unknown_name('column', name, _columns(legs + 1))}")
    text = facts.get("cycles", "")
    if not text.isdecimal() or len(text) > _MOST_DIGITS or int(text) < 1:
        raise DataFileError(
            f"{path}: the comment '# cycles: N' is missing or damaged; write the file anew"
        )
    count = int(text)
    for cycle, row in enumerate(table.rows):
        if table.text(row, "cycle") != str(cycle):
            raise table.error(
                row.line, f"cycle is {table.text(row, 'cycle')!r} where {cycle} should follow"
            )
    if len(table.rows) != count:
        last = table.rows[-1].line
        raise table.error(
            last,
            f"{len(table.rows)} cycles of the {count} that the comments promise; write it anew",
        )
    return tuple(_action(table, row, legs) for row in table.rows)


def _action(table: CsvTable, row: CsvRow, legs: int) -> CycleAction:
    with located(f"{table.path}, line {row.line}", DataFileError):
        side = table.text(row, "side")
        if not side.isdecimal() or len(side) > _MOST_DIGITS:
            raise table.error(
                row.line, f"side is {side[:_MOST_DIGITS]!r}; it must be a whole number"
            )
        numbers = [_number(table, row, key, unit) for key, unit in PUSH_UNITS.items()]
        for column in ROD_COLUMNS:
            table.number(row, column)
        turn = _number(table, row, TURN_COLUMN, DEGREES)
        return CycleAction(_way_points(table, row, legs), SidePush(int(side), *numbers), turn)


def _way_points(table: CsvTable, row: CsvRow, legs: int) -> Points:
    places: list[tuple[float, float]] = []
    given_legs: list[tuple[float, float]] = []
    for leg in range(1, legs + 1):
        x, y, direction, length = columns = _leg_columns(leg)
        if not any(table.text(row, column) for column in columns):
            continue
        if len(places) < leg - 1:
            raise table.error(row.line, f"{x} is given, but the way-point before it is blank")
        places.append((_number(table, row, x, MILLIMETRES), _number(table, row, y, MILLIMETRES)))
        given_legs.append((math.radians(table.number(row, direction)), table.number(row, length)))
    runs = zip(pairwise((*places, (0.0, 0.0))), given_legs, strict=True)
    for leg, ((place, onward), (bearing, distance)) in enumerate(runs, 1):
        dx = 1e3 * (onward[0] - place[0])
        dy = 1e3 * (onward[1] - place[1])
        if (
            math.hypot(dx - distance * math.cos(bearing), dy - distance * math.sin(bearing))
            > _AGREE_MM
        ):
            words = f"leg_{leg} does not run from way_point_{leg} to the next; mend one of them"
            raise table.error(row.line, words)
    return tuple(places)


def _number(table: CsvTable, row: CsvRow, column: str, unit: FileUnit) -> float:
    """A field of `unit` in SI units, rounded once."""
    text = table.text(row, column)
    try:
        return unit.read(Decimal(text))
    except (InvalidOperation, InvalidInput) as error:
        raise table.error(row.line, f"{column} is '{text}'; it must be a finite number") from error


def _read_commented(path: str | Path) -> tuple[CsvTable, dict[str, str]]:
    """A CSV file whose header may follow comments, and their facts `# name: text`.

    An unended last line, cut off in a number, still looks like one.
    """
    text = read_text(Path(path), "plain CSV")
    check_checksum(path, text)
    lines = text.split("\n")
    if lines.pop():
        raise DataFileError(
            f"{path}, line {len(lines) + 1}: the line is cut off (it has no end); write the file "
            "anew"
        )
    rows = "\n".join("" if line.startswith("#") else line for line in lines)
    comments = [line.lstrip("#").strip() for line in lines if line.startswith("#")]
    named = (comment.partition(":") for comment in comments)
    facts = {name.strip(): fact.strip() for name, colon, fact in named if colon}
    return csv_table(Path(path), rows), facts
