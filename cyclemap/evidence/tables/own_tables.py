"""Tables of one's own, as `own_files` reads them, brought to pushes by our names: what a row is, in
which order they were made, and which orientation follows which.

What a column means is told or guessed by its name, its unit by name or size (`meaning`); every
guess is said, and nothing that two readings are possible of is guessed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cyclemap.arrays import Array
from cyclemap.errors import DataFileError, InvalidInput, located
from cyclemap.evidence.tables.columns import (
    ENDS,
    OURS,
    PLACES,
    RODS,
    Convention,
    convention_of,
    our_text,
    without_repeats,
)
from cyclemap.evidence.tables.data_kinds import TEXTS
from cyclemap.evidence.tables.meaning import known_units, meaning_of, si_rows, with_headings
from cyclemap.evidence.tables.own_files import JSON_LINES, raw_columns
from cyclemap.evidence.tables.pose_streams import Segments, cut_stream

if TYPE_CHECKING:
    import pandas

# What is taken of a table of poses.
_FACTS = ("side", "fraction", "angle", "length", *RODS, "speed", "acceleration", "tip_error")
_POSED = ("surface", "object", *ENDS, "theta_next", "repetition", *_FACTS)
# So many orientations tell whether they begin anew each half a turn.
_MANY_OF_HALVES = 20
# So many rows a push are many; of a stream, places bend by less than this share of their spread.
_MANY_ROWS = 200
_SMOOTH = 0.05
# Seconds from row to row: up to this many rows follow a moving object, beyond the other a row is a
# push of its own.
_STREAM_STEP = 0.4
_A_CYCLE = 3.0
# Fewer rows than this may follow each other as they like.
_TELLING = 8
# Pairs from which on it is told that they look random: 96 % of random ones do.
_FEWEST_AT_RANDOM = 20
# No reset turns an object alike to this (rad).
_EVENLY = 1e-6
# Columns that say of a row whether it counts, and the value with which it does.
_FLAGS = {"good": 1.0, "bad": 0.0}


@dataclass(frozen=True, eq=False)
class OwnTable:
    """Rows in SI units by our names, in our convention.

    words : what was read as what, and left out.
    segments : of a stream of poses, how it was cut.
    """

    rows: pandas.DataFrame
    words: tuple[str, ...]
    guessed: bool
    segments: Segments | None = None

    @property
    def columns(self) -> dict[str, Array]:
        """The rows, column by column."""
        return {str(name): values.to_numpy() for name, values in self.rows.items()}

    def then(self, rows: pandas.DataFrame, *words: str) -> OwnTable:
        """The table with other rows, after what was said these words."""
        return replace(self, rows=rows, words=(*self.words, *words))

    def with_orientation(self) -> OwnTable:
        """The rows that have one, and how many have none."""
        known = self.rows["theta0"].notna()
        lost = f"left out for want of an orientation: {(~known).sum()} of {known.size} rows"
        return self.then(self.rows[known], *([] if known.all() else [lost]))

    def csv_text(self) -> str:
        """The table as a CSV file that every reader of pushes takes."""
        if "theta1" in self.rows:
            return our_text(self.rows)
        return our_text(self.rows.filter(["theta0", "theta_next"]))


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
    table = _pushes(Path(path), columns or {}, units, convention)
    with located(str(path), DataFileError):
        table = _with_what_follows(table)
    return table.then(table.rows, _assumed({*table.rows} >= PLACES, convention))


def _assumed(posed: bool, convention: Convention) -> str:
    """What is said of the convention: orientations alone cannot tell whether it is the right
    one.
    """
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
    table = _pushes(Path(path), columns or {}, units, convention, growing)
    known = table.with_orientation()
    if known.rows.empty and not growing:
        raise DataFileError(f"{path}: no row has an orientation that counts")
    is_posed = not growing and {*known.rows} >= PLACES
    return known.then(known.rows[["theta0"]], _assumed(is_posed, convention))


def _pushes(
    place: Path,
    given: Mapping[str, str],
    units: Sequence[str],
    convention: Convention,
    growing: bool = False,
) -> OwnTable:
    """The pushes of a file in SI units and our convention by our names, in their order."""
    known = known_units(units)
    if growing and place.suffix.lower() not in (*TEXTS, *JSON_LINES):
        raise DataFileError(
            f"{place}: read once it is whole, without --follow: only a CSV file is read while it "
            "grows"
        )
    raw = raw_columns(place, given, growing)
    with located(str(place), DataFileError):
        meaning = meaning_of(raw, given)
        if growing and "theta0" not in meaning and {"t", "episode", "qw"} & {*meaning}:
            raise InvalidInput(
                "a stream of poses is cut into pushes once it is whole: without --follow"
            )
        rows, words, guessed = si_rows(raw, meaning, known, growing)
        begin = f"{place.name}: {len(rows)} rows"
        rows, left_out = _counting(rows)
        rows, turned = with_headings(rows)
        is_guessed = len(meaning) > len(given) or not units
        said = (begin, *words, *left_out, *turned)
        table = OwnTable(convention.rows(rows), said, is_guessed)
        table = _as_pushes(place, table, "t" in guessed, meaning.get("theta0", "NAME"))
        if "theta1" not in table.rows:
            _refuse_several(table.rows)
            _refuse_half_turns(table.rows["theta0"].to_numpy())
        return table if growing else _in_order(_counted_once(table))


def _counting(rows: pandas.DataFrame) -> tuple[pandas.DataFrame, list[str]]:
    """The rows that count where a column tells that some do not, and what is said of it."""
    kept = np.ones(len(rows), dtype=bool)
    words = list[str]()
    for name, counts in _FLAGS.items():
        if name not in rows:
            continue
        flag = rows.pop(name)
        known = flag.dropna()
        if len(known) and known.isin((0.0, 1.0)).all():
            kept &= flag.to_numpy() != 1.0 - counts
        else:
            words.append(f"what is read as {name} is neither yes nor no, and leaves no row out")
    if kept.all():
        return rows, words
    if not {"repetition", "t", "episode"} & {*rows}:
        # What was left out is a gap.
        rows["repetition"] = np.arange(len(rows), dtype=float)
    words.append(
        f"left out, for the table says they failed: {len(rows) - kept.sum()} of {len(rows)} rows"
    )
    return rows[kept].reset_index(drop=True), words


# -- what a row is


def _as_pushes(path: Path, table: OwnTable, is_time_guessed: bool, theta0_column: str) -> OwnTable:
    """Return a table with a row a push: of a stream those that it is cut into, of two rows a push
    one. InvalidInput where rows may be either.

    is_time_guessed : whether the unit of times is. theta0_column : how the file calls theta0.
    """
    rows = table.rows
    if "theta" not in rows or "theta0" in rows:
        if "theta1" not in rows:
            _refuse_a_stream(rows, theta0_column)
        return table
    if _is_stream(rows, is_time_guessed):
        return _cut(path, table)
    if _has_two_rows_a_push(rows):
        paired = rows.rename(columns={"repetition": "episode"})
        return _cut(path, table.then(paired, "two rows a push: before and after it"))
    _refuse_a_stream_without_times(rows)
    words = ["a row a push: its orientation the one before the push"]
    is_moving = {"t", "episode"} & {*rows}
    return table.then(rows.rename(columns={"theta": "theta0"}), *(words if is_moving else ()))


def _is_stream(rows: pandas.DataFrame, is_time_guessed: bool) -> bool:
    """Whether rows follow a moving object, several to a push."""
    if "episode" in rows and ("t" in rows or "repetition" not in rows):
        return bool((rows["episode"].diff() == 0.0).any())
    if "t" not in rows:
        return False
    t = rows["t"]
    step = t.dropna().sort_values().diff().median()
    if not step > 0.0:
        raise InvalidInput(
            "its times do not rise from row to row: keep the rows of the object alone, in order"
        )
    is_whole = is_time_guessed and step >= _A_CYCLE and bool((t % 1.0 == 0.0).all())
    if is_whole or _STREAM_STEP < step < _A_CYCLE:
        raise InvalidInput(
            f"{step:g} s from row to row: do several rows follow one push, or is each a push of "
            "its own? Say the unit of its times, --units s or ms; where each row is a push, leave "
            "the times out"
        )
    return bool(step <= _STREAM_STEP)


def _has_two_rows_a_push(rows: pandas.DataFrame) -> bool:
    """Whether each number of a push stands twice, one row below the other, with a place."""
    if not {"x", "y", "repetition"} <= {*rows} or len(rows) < 4 or len(rows) % 2:
        return False
    repetition = rows["repetition"].to_numpy()
    is_twice = bool((repetition[::2] == repetition[1::2]).all())
    return is_twice and np.unique(repetition).size * 2 == repetition.size


def _refuse_a_stream(rows: pandas.DataFrame, theta0_column: str) -> None:
    """Refuse orientations before pushes that come too fast to be that."""
    if "t" not in rows or len(rows) <= _TELLING:
        return
    step = float(np.median(np.abs(np.diff(rows["t"]))))
    if 0.0 < step <= _STREAM_STEP:
        raise InvalidInput(
            f"{step:.2g} s from row to row, so that many rows follow one push: say --columns "
            f"theta={theta0_column} in place of theta0, or leave the times out"
        )


def _refuse_a_stream_without_times(rows: pandas.DataFrame) -> None:
    """Refuse poses that follow a moving object row by row: places that change smoothly, and not as
    those of an object whose ring is at the target do.
    """
    if not {"x", "y"} <= {*rows} or {"t", "episode", "repetition"} & {*rows}:
        return
    x, y, theta = rows[["x", "y", "theta"]].dropna().to_numpy().T
    if x.size < _MANY_ROWS:
        return
    place = x + 1j * y
    way = np.exp(1j * theta)
    spread = float(np.std(place))
    turned = math.inf
    for turn in (way, way.conj()):
        unknown = np.stack([turn, np.ones(turn.size)], axis=-1)
        ring, *_ = np.linalg.lstsq(unknown, place, rcond=None)
        turned = min(turned, float(np.std(place - unknown @ ring)))
    if float(np.median(np.abs(np.diff(place, n=2)))) < _SMOOTH * spread < turned:
        raise InvalidInput(
            "its rows follow a moving object, and no column tells their times: add one in "
            "seconds, t, such as the number of the frame by the rate"
        )


def _refuse_several(rows: pandas.DataFrame) -> None:
    """Refuse orientations of several objects or surfaces, which follow no one map."""
    for name in ("surface", "object"):
        listed = sorted({str(value) for value in rows.get(name, ())})
        if len(listed) > 1:
            raise InvalidInput(
                f"orientations on several {name}s, {', '.join(listed)[:80]}: split them, a "
                "table each"
            )


def _refuse_half_turns(theta: Array) -> None:
    """Refuse orientations (n,), rad, that begin anew each half a turn, as those of an axis without
    a head.
    """
    known = theta[np.isfinite(theta)]
    if known.size < _MANY_OF_HALVES or float(np.ptp(known)) > 1.01 * math.pi:
        return
    steps = np.diff(known)
    jumps = np.abs(steps) > 0.6 * math.pi
    largest = np.abs(steps[~jumps]).max(initial=0.0)
    off = np.abs(math.pi - np.abs(steps[jumps]))
    if 2 <= jumps.sum() <= 0.3 * jumps.size and (off <= 1.5 * largest).all():
        raise InvalidInput(
            "its orientations jump back by half a turn: those of an axis without a head? All "
            "around are wanted, 0 to 360 degrees"
        )


# -- from several rows a push to one


def _cut(path: Path, table: OwnTable) -> OwnTable:
    """The pushes of a stream of poses: one an episode, else what its rests and its ring's place
    tell.
    """
    words: list[str] = []
    stream = table.rows.dropna(subset=_known(table.rows, "theta", "t", "x", "y"))
    lost = len(table.rows) - len(stream)
    if lost:
        words.append(f"left out for want of a pose: {lost} of {len(table.rows)} rows")
    if "episode" in stream:
        pushes = _episodes(stream)
        return table.then(pushes, *words, f"{len(pushes)} pushes, one an episode")
    if not stream["t"].is_monotonic_increasing:
        words.append("rows put in the order of their times")
    pushes, seen = cut_stream(path, stream.sort_values("t", kind="stable"))
    return replace(table.then(pushes, *words, seen.words), segments=seen)


def _known(rows: pandas.DataFrame, *names: str) -> list[str]:
    return [name for name in names if name in rows]


def _episodes(stream: pandas.DataFrame) -> pandas.DataFrame:
    """The first and the last pose of each episode."""
    import pandas

    stream = stream.dropna(subset="episode")
    runs = (stream["episode"].diff() != 0.0).cumsum()
    stream = stream[runs.groupby(runs).transform("size") > 1]
    if stream.empty:
        raise InvalidInput("no push in it: no episode has two rows")
    unwrapped = stream.groupby(runs)["theta"].transform(np.unwrap)
    episodes = stream.assign(theta=unwrapped).groupby(runs)
    poses = episodes[_known(stream, "theta", "x", "y")]
    # An episode that is missing is a gap.
    columns = [episodes["episode"].first().rename("repetition")]
    columns += [poses.first().add_suffix("0"), poses.last().add_suffix("1")]
    return pandas.concat(columns, axis="columns").reset_index(drop=True)


# -- in which order


def _counted_once(table: OwnTable) -> OwnTable:
    """The table without rows that are there again."""
    rows = table.rows
    kept, words = without_repeats(rows, range(1, len(rows) + 1), "row")
    return table.then(rows[kept].reset_index(drop=True), words) if words else table


def _in_order(table: OwnTable) -> OwnTable:
    """Return the rows in the order of their numbers, else of their times, collection by
    collection.
    """
    rows = table.rows
    labels = _collections(table.rows)
    for name, what in (("repetition", "numbers"), ("episode", "numbers"), ("t", "times")):
        if name not in rows:
            continue
        numbers = rows[name].to_numpy()
        pairs = np.stack([labels, numbers])
        if np.isfinite(numbers).all() and np.unique(pairs, axis=1).shape[1] == numbers.size:
            if name == "episode":
                # A number that is missing is a gap.
                rows = rows.assign(repetition=numbers)
            order = np.lexsort((numbers, labels))
            is_as_it_was = (np.diff(order) == 1).all()
            words = [] if is_as_it_was else [f"rows put in the order of their {what}"]
            return table.then(rows.iloc[order].reset_index(drop=True), *words)
        if name == "repetition":
            follows = np.diff(numbers) == 1.0
            # Where few follow each other nobody knows what follows what.
            rows = rows.drop(columns=name)
            if 2 * follows.sum() > follows.size:
                counted = np.cumsum(np.append(0.0, np.where(follows, 1.0, 2.0)))
                rows = rows.assign(repetition=counted)
            return table.then(
                rows,
                f"{what} of pushes are missing or there twice: rows are taken in their own order",
            )
    return table


def _parted_by(rows: pandas.DataFrame) -> list[str]:
    """The columns that tell the collections in a table apart."""
    names = _known(rows, "surface", "object", "run")
    is_shared = "episode" in rows and not rows["episode"].is_unique
    return [*names, "episode"] if is_shared else names


def _collections(rows: pandas.DataFrame) -> Array:
    """Which of the collections in a table each row (n,) is of."""
    names = _parted_by(rows)
    if not names:
        return np.zeros(len(rows))
    return np.asarray(rows[names].astype(str).groupby(names).ngroup(), dtype=float)


# -- what follows


def _with_what_follows(table: OwnTable) -> OwnTable:
    """Return the rows with an orientation, and with it the next one's where that follows; what was
    left out is told.
    """
    rows = table.rows.copy()
    is_posed = {*table.rows} >= {*ENDS}
    theta = rows["theta0"].to_numpy()
    words = list[str]()
    repetition = np.arange(float(len(rows)))
    if "repetition" in rows:
        repetition = rows["repetition"].to_numpy()
    follows = (np.diff(repetition) == 1.0) & (np.diff(_collections(rows)) == 0.0)
    gaps = int((~follows).sum())
    rows["repetition"] = _numbers_apart(repetition, rows)
    taken: tuple[str, ...] = _POSED if is_posed else ("theta0", "theta_next")
    if "theta_next" not in rows:
        if not is_posed and not gaps and np.isfinite(theta).all() and len(rows) > 1:
            return table.then(rows[["theta0"]])
        if gaps:
            words.append(f"no pair across gaps in the numbers of the pushes: {gaps}")
        later = np.append(np.where(follows, theta[1:], math.nan), math.nan)
        rows["theta_next"] = later
        how = _how_set(theta, later) if is_posed else None
        if how is not None:
            words.append(f"orientations before pushes {how}, no cycle among them")
            taken = tuple(name for name in _POSED if name not in ("theta_next", "repetition"))
    whole = rows.dropna(subset=ENDS if is_posed else ("theta0", "theta_next"))
    if len(whole) < 2:
        few = f"{len(whole)} pushes with an orientation and what follows it; two or more are wanted"
        mend = ": their numbers do not go up by 1, leave them out where rows do" if gaps else ""
        raise InvalidInput(f"{few}{mend}")
    lost = len(rows) - len(whole if is_posed else rows["theta0"].dropna())
    if lost:
        what = "a pose" if is_posed else "an orientation"
        words.append(f"left out for want of {what}: {lost} of {len(rows)} rows")
    return table.then(whole[_known(whole, *taken)], *words)


def _numbers_apart(repetition: Array, rows: pandas.DataFrame) -> Array:
    """Numbers of pushes (n,), those of later runs behind those of earlier ones: no push of a run
    follows one of another.
    """
    import pandas

    if not {"run", "episode"} & {*_parted_by(rows)}:
        return repetition
    labels = _collections(rows)
    spans = pandas.Series(repetition).groupby(labels).agg(["min", "max"])
    lengths = spans["max"] - spans["min"] + 2.0
    begins = spans["min"].iloc[0] + lengths.cumsum().shift(fill_value=0.0)
    return np.asarray(repetition + (begins - spans["min"])[labels].to_numpy())


def _how_set(theta: Array, theta_next: Array) -> str | None:
    """How orientations (n,), rad, before pushes were set, if not by a reset; `theta_next`: NaN
    where none follows.
    """
    pairs = np.isfinite(theta) & np.isfinite(theta_next)
    later = theta_next[pairs]
    turn = (theta_next - theta)[pairs]
    if turn.size > 2 and float(np.ptp(turn)) < _EVENLY:
        return "are evenly spaced: taken as set one by one"
    # Where a reset makes them they gather somewhere, or turns have a mean.
    if turn.size >= _FEWEST_AT_RANDOM:
        gather = max(abs(np.exp(1j * angle).mean()) for angle in (later, turn))
        if gather < 2.0 / math.sqrt(turn.size):
            return "go with nothing: taken as set at random"
    return None
