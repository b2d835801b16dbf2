"""Tables of one's own, as `own_files` reads them, brought to the columns of `read_push_csv`.

What a column means is told or guessed by its name, its unit by name or size; every guess is said,
and nothing that two readings are possible of is guessed. A stream of one object's poses becomes
pushes by its episodes, or by its rests.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cyclemap.arrays import Array, Mask, Whole
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.pushes.columns import (
    COLUMNS,
    ENDS,
    OF_THE_FILE,
    PLACES,
    QUATERNION,
    RODS,
    UNIT_WORDS,
    UNITS,
    UNITS_OF,
    Kind,
    meaning_of,
    our_text,
    unit_of,
)
from cyclemap.evidence.pushes.conventions import OURS, Convention, convention_of
from cyclemap.evidence.pushes.data_kinds import TEXTS
from cyclemap.evidence.pushes.own_files import JSON_LINES, raw_columns
from cyclemap.evidence.pushes.pose_streams import Segments, cut_stream
from cyclemap.evidence.pushes.text_tables import Columns
from cyclemap.file_text import located

# What may be told of a table: the angle of pushes goes by no name of its own.
_READ = [name for name, column in COLUMNS.items() if column.patterns]
_KNOWN = (*_READ, "angle", *OF_THE_FILE)
# What is taken of a table of poses.
_FACTS = ("side", "fraction", "angle", "length")
_POSED = ("surface", "object", *ENDS, "theta_next", "repetition", *_FACTS, *RODS)
# The cosine of an axis' tilt from which on it is upright.
_UPRIGHT = 0.9
# Columns that say of a row whether it counts, and the value with which it does.
_FLAGS = {"good": 1.0, "bad": 0.0}
# So many orientations tell whether they begin anew each half a turn.
_MANY_OF_HALVES = 20
# So many rows a push are many; of a stream, places bend by less than this share of their spread.
_MANY_ROWS, _SMOOTH = 200, 0.05
# What robots write where they have no number.
_NO_NUMBERS = (-999.0, -9999.0, -99999.0, 9999.0, 99999.0)
# Seconds from row to row: up to this many rows follow a moving object.
_STREAM_STEP = 0.4
_LONGEST_HEADER = 100_000
# Fewer rows than this may follow each other as they like.
_TELLING = 8
# Pairs from which on it is told that they look random: 96 % of random ones do.
_FEWEST_AT_RANDOM = 20
# No reset turns an object alike to this (rad).
_EVENLY = 1e-6
# Seconds from row to row: beyond this a row is a push of its own.
_A_CYCLE = 3.0


@dataclass(frozen=True)
class OwnTable:
    """Columns of pushes in SI units by the names of `read_push_csv`, in our convention.

    words : what was read as what, and left out.
    segments : of a stream of poses, how it was cut.
    """

    columns: Mapping[str, Array]
    words: tuple[str, ...]
    guessed: bool
    segments: Segments | None = None

    def then(self, columns: Mapping[str, Array], *words: str) -> OwnTable:
        """The table with other columns, after what was said these words."""
        return replace(self, columns=columns, words=(*self.words, *words))

    def csv_text(self) -> str:
        """The table as a CSV file that every reader of pushes takes."""
        columns = self.columns
        if "theta1" not in columns:
            angles = (name for name in ("theta0", "theta_next") if name in columns)
            columns = {name: columns[name] for name in angles}
        return our_text(columns)


def read_own_table(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    units: Sequence[str] = (),
    *,
    angles: str | None = None,
    frame: str | None = None,
    offset_deg: float | None = None,
) -> OwnTable:
    """Read a table of one's own, or a stream of poses, as pushes.

    columns : the file's column of each of theta0, theta1, theta_next, x0, y0, x1, y1, of a stream
        t, x, y, theta (or the quaternion qx, qy, qz, qw) and episode; of a bag pose = its topic, of
        a workbook sheet = its name. A part of a list is named[i].
    units : of angles (deg, rad, turn), lengths (mm, cm, m, inch) and times (s, ms, us, ns). What is
        not told is guessed.
    angles, frame, offset_deg : how the file counts angles and lays its axes, as in `Convention`;
        what is not told is what a collection.toml with the data says, else counter-clockwise and
        right-handed, 0.

    Raises DataFileError, saying what the file has and what is wanted, where that cannot be done.
    """
    convention = convention_of(path, angles, frame, offset_deg)
    table = _understood(Path(path), columns or {}, units, convention)
    with located(str(path), DataFileError):
        table = _cleaned(table)
    return table.then(table.columns, _assumed(set(table.columns) >= PLACES, convention))


def _assumed(posed: bool, convention: Convention) -> str:
    """What is said of the convention:
    orientations alone cannot tell whether it is the right one."""
    if posed:
        return f"read with {convention.words()}"
    angles = convention.words().partition("angles ")[2]
    return (
        f"angles taken as {angles}: orientations alone cannot tell, --angles clockwise or "
        "compass says otherwise"
    )


def read_orientations(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    units: Sequence[str] = (),
    growing: bool = False,
    convention: Convention = OURS,
) -> OwnTable:
    """Read θ0 alone of a table of one's own, as `read_own_table` does: every one known, in the
    order of the rows.

    growing : a CSV file that is written to, whose last line waits for its end. Then DataFileError
        also where rows to come could change what earlier ones mean: a stream of poses, or a unit
        that would be guessed.
    """
    table = _understood(Path(path), columns or {}, units, convention, growing)
    theta = table.columns["theta0"]
    known = np.isfinite(theta)
    words = (*_without_orientation(known), _assumed(False, convention))
    return table.then({"theta0": theta[known]}, *words)


def _without_orientation(known: Mask) -> list[str]:
    count = int(np.sum(~known))
    return [f"left out for want of an orientation: {count} of {known.size} rows"] if count else []


def _understood(
    place: Path,
    told: Mapping[str, str],
    units: Sequence[str],
    convention: Convention,
    growing: bool = False,
) -> OwnTable:
    """The columns in SI units and our convention by our names, a row a push in their order."""
    units = [UNIT_WORDS.get(unit, unit) for unit in units]
    _refuse_unknown(told, units)
    if growing and place.suffix.lower() not in (*TEXTS, *JSON_LINES):
        raise DataFileError(
            f"{place}: read once it is whole, without --follow: only a CSV file is read while it "
            "grows"
        )
    raw = raw_columns(place, told, growing)
    with located(str(place), DataFileError):
        meaning = meaning_of(raw, told)
        if growing and "theta0" not in meaning and {"t", "episode", "qw"} & set(meaning):
            raise InvalidInput(
                "a stream of poses is cut into pushes once it is whole: without --follow"
            )
        columns, words, guessed = _in_si_units(raw, meaning, units, growing)
        if "nanoseconds" in columns:
            columns["t"] = columns.get("t", 0.0) + 1e-9 * columns.pop("nanoseconds")
        columns, left_out = _counting(columns)
        columns, turned = _with_headings(columns)
        words += (*left_out, *turned)
        rows = f"{place.name}: {len(next(iter(raw.values())))} rows"
        table = OwnTable(
            convention.columns(columns), (rows, *words), len(meaning) > len(told) or not units
        )
        if "theta" in columns and "theta0" not in columns:
            if _is_stream(columns, "t" in guessed):
                return _pushes(place, table)
            if _has_two_rows_a_push(columns):
                columns = dict(table.columns)
                columns["episode"] = columns.pop("repetition")
                return _pushes(place, table.then(columns, "two rows a push: before and after it"))
            _refuse_a_stream_without_times(columns)
            table = _a_row_a_push(table)
        elif "theta1" not in columns:
            _refuse_a_stream(columns, meaning)
        if "theta1" not in columns:
            _refuse_several(columns)
            _refuse_half_turns(table.columns["theta0"])
        return table if growing else _ordered(table)


def _refuse_unknown(told: Mapping[str, str], units: Sequence[str]) -> None:
    """Refuse columns and units that nobody knows."""
    for name in told:
        if name not in _KNOWN:
            raise InvalidInput(f"--columns {name}=...: know {', '.join(_KNOWN)}")
    for unit in units:
        if unit not in UNITS:
            raise InvalidInput(f"--units {unit}: know {', '.join(UNITS)}")


def _in_si_units(
    raw: Columns, meaning: Mapping[str, str], units: Sequence[str], growing: bool
) -> tuple[Columns, list[str], set[str]]:
    """The columns by our names, what is said of them, and whose unit is a guess."""
    columns, words, guessed = Columns(), list[str](), set[str]()
    for name, column in meaning.items():
        kind, said = COLUMNS[name].kind, ""
        if kind in (Kind.ANGLE, Kind.PLACE) and (none := np.isin(raw[column], _NO_NUMBERS)).any():
            raw = {**raw, column: np.where(none, math.nan, raw[column])}
            words.append(f"{column}: {int(none.sum())} of -999 or the like taken as no number")
        columns[name] = raw[column]
        if kind is Kind.TEXT:
            continue
        if raw[column].dtype.kind == "O":
            raise InvalidInput(f"{column} holds texts, and {name} wants numbers")
        if kind in UNITS_OF:
            unit, said = unit_of(name, meaning, raw, units)
            columns[name] = UNITS[unit] * raw[column]
        if "guessed" in said:
            guessed.add(name)
            if growing and kind is Kind.ANGLE:
                raise InvalidInput(
                    f"later rows may tell another unit of {column}: say it, --units deg or rad"
                )
        words.append(f"{column} read as {name}{said}")
    unread = [column for column in raw if column not in meaning.values()]
    if unread:
        words.append(f"not read: {', '.join(unread)[:400]}")
    return columns, words, guessed


def _counting(columns: Columns) -> tuple[Columns, list[str]]:
    """The rows that count where a column tells that some do not, and how many were left out."""
    kept, rows = np.bool_(True), len(next(iter(columns.values())))
    for name, counts in _FLAGS.items():
        flag = columns.pop(name, np.full(rows, counts))
        if set(flag[np.isfinite(flag)].tolist()) <= {0.0, 1.0}:
            kept = kept & (flag != 1.0 - counts)
    if np.all(kept):
        return columns, []
    if not {"repetition", "t", "episode"} & set(columns):
        # What was left out is a gap.
        columns["repetition"] = np.arange(rows, dtype=float)
    told = f"left out, for the table says they failed: {rows - int(kept.sum())} of {rows} rows"
    return {name: values[kept] for name, values in columns.items()}, [told]


def _with_headings(columns: Columns) -> tuple[Columns, list[str]]:
    """Orientations in place of quaternions, y to the right of x where that is up, as it is said."""
    words = list[str]()
    found = dict(columns)
    height = found.pop("z", None)
    for end in ("", "0", "1"):
        parts = [f"{part}{end}" for part in QUATERNION]
        if not set(parts) <= set(found):
            continue
        found[f"theta{end}"], is_y_up = _heading(*(found.pop(part) for part in parts))
        if is_y_up:
            if end or height is None or "y" not in found:
                raise InvalidInput("turns about y, which is up: give x, y, z with z up")
            found["y"] = -height
            words.append("turns about y: taken as up, -z for y")
    return found, words


def _heading(x: Array, y: Array, z: Array, w: Array) -> tuple[Array, bool]:
    """The turn about the upright axis (n,), rad, of quaternions of any length, and whether that is
    y.
    """
    size = x * x + y * y + z * z + w * w
    size = np.where(size > 0.0, size, math.nan)
    z_up, y_up = 1.0 - 2.0 * (x * x + y * y) / size, 1.0 - 2.0 * (x * x + z * z) / size
    known = np.isfinite(size)
    if not known.any() or float(np.quantile(np.abs(z_up[known]), 0.1)) > _UPRIGHT:
        across = 1.0 - 2.0 * (y * y + z * z) / size
        return np.arctan2(2.0 * (w * z + x * y) / size, across), False
    if float(np.quantile(np.abs(y_up[known]), 0.1)) > _UPRIGHT:
        return np.arctan2(2.0 * (w * y + x * z) / size, z_up), True
    raise InvalidInput(
        "its quaternions turn about neither z nor y: bring its poses into the frame of the table, "
        "z up"
    )


# -- from streams and rows to pushes


def _a_row_a_push(table: OwnTable) -> OwnTable:
    """Orientations of a moving object that are those before pushes."""
    columns = dict(table.columns)
    columns["theta0"] = columns.pop("theta")
    if not {"t", "episode"} & set(columns):
        return table.then(columns)
    return table.then(columns, "a row a push: its orientation the one before the push")


def _refuse_a_stream(columns: Columns, meaning: Mapping[str, str]) -> None:
    """Refuse orientations before pushes that come too fast to be that."""
    if "t" not in columns or len(columns["t"]) <= _TELLING:
        return
    step = float(np.median(np.abs(np.diff(columns["t"]))))
    if 0.0 < step <= _STREAM_STEP:
        line = f"{step:.2g} s from row to row, so that many rows follow one push"
        mend = (
            f"say --columns theta={meaning.get('theta0', 'NAME')} in place of theta0, or "
            "leave the times out"
        )
        raise InvalidInput(f"{line}: {mend}")


def _refuse_several(columns: Columns) -> None:
    """Refuse orientations of several objects or surfaces, which follow no one map."""
    for name in ("surface", "object"):
        listed = sorted({str(value) for value in columns.get(name, ())})
        if len(listed) > 1:
            told = f"orientations on several {name}s, {', '.join(listed)[:80]}"
            raise InvalidInput(f"{told}: split them, a table each")


def _refuse_half_turns(theta: Array) -> None:
    """Refuse orientations that begin anew each half a turn, as those of an axis without a head."""
    known = theta[np.isfinite(theta)]
    if known.size < _MANY_OF_HALVES or float(np.ptp(known)) > 1.01 * math.pi:
        return
    steps = np.diff(known)
    jumps = np.abs(steps) > 0.6 * math.pi
    rest = np.abs(steps[~jumps])
    ahead = np.abs(math.pi - np.abs(steps[jumps]))
    if jumps.sum() >= 2 and (ahead <= 1.5 * rest.max(initial=0.0)).all() and not jumps.mean() > 0.3:
        raise InvalidInput(
            "its orientations jump back by half a turn: those of an axis without a head? All "
            "around are wanted, 0 to 360 degrees"
        )


def _collections(columns: Mapping[str, Array]) -> Whole:
    """Which of the collections in a table each row (n,) is of."""
    names: list[str] = [name for name in ("surface", "object", "run") if name in columns]
    episode = columns.get("episode")
    if episode is not None and np.unique(episode).size < episode.size:
        names.append("episode")
    labels = np.zeros(len(next(iter(columns.values()))), dtype=np.int64)
    for name in names:
        _, own = np.unique(columns[name].astype(str), return_inverse=True)
        labels = labels * (own.max(initial=0) + 1) + own
    return labels


def _ordered(table: OwnTable) -> OwnTable:
    """Rows a push in the order of their numbers, else of their times, collection by collection."""
    columns, labels = dict(table.columns), _collections(table.columns)
    for name, what in (("repetition", "numbers"), ("episode", "numbers"), ("t", "times")):
        if name not in columns:
            continue
        numbers = columns[name]
        order = np.lexsort((numbers, labels))
        pairs = np.stack([labels, numbers])
        if np.isfinite(numbers).all() and np.unique(pairs, axis=1).shape[1] == numbers.size:
            if name == "episode":
                # A number that is missing is a gap.
                columns["repetition"] = numbers
                table = table.then(columns)
            if (np.diff(order) == 1).all():
                return table
            columns = {column: values[order] for column, values in columns.items()}
            return table.then(columns, f"rows put in the order of their {what}")
        if name == "repetition":
            follows = np.diff(numbers) == 1.0
            told = f"{what} of pushes are missing or there twice: rows are taken in their own order"
            if 2 * follows.sum() > follows.size:
                columns[name] = np.cumsum(np.append(0.0, np.where(follows, 1.0, 2.0)))
            else:
                # Nobody knows what follows what.
                del columns[name]
            return table.then(columns, told)
    return table


def _is_stream(columns: Columns, guessed: bool) -> bool:
    """Whether rows follow a moving object, several to a push; `guessed`:
    the unit of its times is."""
    if "episode" in columns and ("t" in columns or "repetition" not in columns):
        return bool((np.diff(columns["episode"]) == 0.0).any())
    if "t" not in columns:
        return False
    t = columns["t"]
    step = float(np.median(np.diff(np.sort(t[np.isfinite(t)])))) if t.size > 1 else 0.0
    if not step > 0.0:
        raise InvalidInput(
            "its times do not rise from row to row: keep the rows of the object alone, in order"
        )
    is_whole = guessed and step >= _A_CYCLE and (t % 1.0 == 0.0).all()
    if is_whole or _STREAM_STEP < step < _A_CYCLE:
        raise InvalidInput(
            f"{step:g} s from row to row: do several rows follow one push, or is each a push of "
            "its own? Say the unit of its times, --units s or ms; where each row is a push, leave "
            "the times out"
        )
    return step <= _STREAM_STEP


def _has_two_rows_a_push(columns: Columns) -> bool:
    """Whether each number of a push stands twice, one row below the other, with a place."""
    number = columns.get("repetition", np.zeros(0))
    if not {"x", "y"} <= set(columns) or number.size < 4 or number.size % 2:
        return False
    return bool((number[::2] == number[1::2]).all() and np.unique(number).size * 2 == number.size)


def _refuse_a_stream_without_times(columns: Columns) -> None:
    """Refuse poses that follow a moving object row by row: places that change smoothly, and not as
    those of an object whose ring is at the target do.
    """
    if not {"x", "y"} <= set(columns) or {"t", "episode", "repetition"} & set(columns):
        return
    known = np.isfinite(columns["x"] + columns["y"] + columns["theta"])
    place = (columns["x"] + 1j * columns["y"])[known]
    if place.size < _MANY_ROWS:
        return
    way = np.exp(1j * columns["theta"][known])
    spread, turned = float(np.std(place)), np.inf
    for turn in (way, way.conj()):
        rows = np.stack([turn, np.ones(turn.size)], axis=-1)
        ring, *_ = np.linalg.lstsq(rows, place, rcond=None)
        turned = min(turned, float(np.std(place - rows @ ring)))
    if float(np.median(np.abs(np.diff(place, n=2)))) < _SMOOTH * spread < turned:
        raise InvalidInput(
            "its rows follow a moving object, and no column tells their times: add one in "
            "seconds, t, such as the number of the frame by the rate"
        )


def _pushes(path: Path, table: OwnTable) -> OwnTable:
    """The pushes of a stream of poses: one an episode, else what its rests and its ring's place
    tell.
    """
    stream, words = table.columns, list[str]()
    known = {"theta", "t", "x", "y"} & set(stream)
    good = np.all([np.isfinite(stream[name]) for name in known], axis=0)
    if not good.all():
        words.append(f"left out for want of a pose: {int((~good).sum())} of {good.size} rows")
    stream = {name: values[good] for name, values in stream.items()}
    if "episode" in stream:
        pushes = _episodes(stream)
        return table.then(pushes, *words, f"{pushes['theta0'].size} pushes, one an episode")
    if (np.diff(stream["t"]) < 0.0).any():
        words.append("rows put in the order of their times")
    order = np.argsort(stream["t"], kind="stable")
    pushes, seen = cut_stream(path, {name: values[order] for name, values in stream.items()})
    return replace(table.then(pushes, *words, seen.words), segments=seen)


def _episodes(stream: Columns) -> Columns:
    """The first and the last pose of each episode."""
    known = np.isfinite(stream["episode"])
    stream = {name: values[known] for name, values in stream.items()}
    cuts = np.flatnonzero(np.diff(stream["episode"])) + 1
    rows = [own for own in np.split(np.arange(stream["theta"].size), cuts) if own.size > 1]
    if not rows:
        raise InvalidInput("no push in it: no episode has two rows")
    theta = np.array([np.unwrap(stream["theta"][own])[[0, -1]] for own in rows])
    # An episode that is missing is a gap.
    pushes: Columns = {"repetition": stream["episode"][[own[0] for own in rows]]}
    for end, place in (("0", 0), ("1", -1)):
        pushes[f"theta{end}"] = theta[:, place]
        ends = [own[place] for own in rows]
        for axis in {"x", "y"} & {*stream}:
            pushes[f"{axis}{end}"] = stream[axis][ends]
    return pushes


def _cleaned(table: OwnTable) -> OwnTable:
    """Rows with an orientation, and with it the next one's where that follows; what was left out is
    told.
    """
    columns = dict(table.columns)
    theta = columns["theta0"]
    known, posed = np.isfinite(theta), set(columns) >= {"theta1", *PLACES}
    number = columns.get("repetition", np.arange(known.size, dtype=float))
    follows = np.append((np.diff(number) == 1.0) & (np.diff(_collections(columns)) == 0), False)
    gaps = int((~follows[:-1]).sum())
    words, how = _without_orientation(known), None
    if "theta_next" not in columns:
        if not posed and known.all() and not gaps and known.size > 1:
            return table.then({"theta0": theta}, *words)
        if gaps:
            words = [f"no pair across gaps in the numbers of the pushes: {gaps}", *words]
        columns["theta_next"] = np.where(follows, np.append(theta[1:], math.nan), math.nan)
        how = _how_set(theta, columns["theta_next"]) if posed else None
    columns["repetition"] = number
    named: tuple[str, ...] = _POSED if posed else ("theta0", "theta_next")
    if how is not None:
        words.append(f"orientations before pushes {how}, no cycle among them")
        named = tuple(name for name in named if name not in ("theta_next", "repetition"))
    wanted = ENDS if posed else ("theta0", "theta_next")
    kept = np.all([np.isfinite(columns[name]) for name in wanted], axis=0)
    if int(kept.sum()) < 2:
        told = f"{int(kept.sum())} pushes with an orientation and what follows it"
        mend = ": their numbers do not go up by 1, leave them out where rows do" if gaps else ""
        raise InvalidInput(f"{told}; two or more are wanted{mend}")
    pushes = {name: columns[name][kept] for name in named if name in columns}
    return table.then(pushes, *words)


def _how_set(theta: Array, theta_next: Array) -> str | None:
    """How orientations (n,), rad, before pushes were set, if not by a reset; `theta_next`: NaN
    where none follows.
    """
    pairs = np.isfinite(theta) & np.isfinite(theta_next)
    later, turn = theta_next[pairs], (theta_next - theta)[pairs]
    if turn.size > 2 and float(np.ptp(turn)) < _EVENLY:
        return "are evenly spaced: taken as set one by one"
    # Where a reset makes them they gather somewhere, or turns have a mean.
    gather = max(
        (abs(np.exp(1j * angle).mean()) for angle in (later, turn) if turn.size), default=1.0
    )
    if turn.size >= _FEWEST_AT_RANDOM and gather < 2.0 / math.sqrt(turn.size):
        return "go with nothing: taken as set at random"
    return None
