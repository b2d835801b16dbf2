"""Tables of one's own, as `own_files` reads them, brought to the columns of `read_push_csv`.

What a column means is told or guessed by its name, its unit by name or size; every guess is said,
and nothing that two readings are possible of is guessed. A stream of one object's poses becomes
pushes by its episodes, or by its rests.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from cyclemap.arrays import Array, Mask
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.pushes.columns import (
    COLUMNS,
    ENDS,
    QUATERNION,
    RODS,
    TIME_UNITS,
    UNITS,
    UNITS_OF,
    Kind,
)
from cyclemap.evidence.pushes.conventions import OURS, Convention, convention_of
from cyclemap.evidence.pushes.own_files import (
    BAGS,
    EXCEL,
    JSON_LINES,
    PARQUET,
    Columns,
    raw_columns,
)
from cyclemap.evidence.pushes.pose_streams import Segments, cut_stream
from cyclemap.evidence.pushes.push_files import SUFFIXES, TABLES
from cyclemap.plain_text import json_value

TEXTS = (".csv", ".tsv", ".txt", ".dat", *JSON_LINES)
# What may be told of a table: the angle of pushes goes by no name of its own.
_KNOWN = tuple(name for name, column in COLUMNS.items() if column.patterns or name == "angle")
_UNIT_WORDS = dict.fromkeys(("degrees", "degree", "°", "grad"), "deg") | {
    "radians": "rad",
    "metres": "m",
    "meters": "m",
    **dict.fromkeys(("in", "inches"), "inch"),
    **dict.fromkeys(("turns", "rev", "revs", "revolutions"), "turn"),
}
# Columns by which a table is known to be one that `load_pushes` and its like read as it is.
_POSES = {"x0", "y0", "x1", "y1"}
_OURS = (
    {"theta0_deg"},
    {"theta0_accum_deg"},
    _POSES,
    {"x1", "y1", "x0n", "y0n"},
    {"fx", "fy", "vx", "vy"},
)
# Seconds from row to row: up to this many rows follow a moving object.
_STREAM_STEP = 0.4
_LONGEST_HEADER = 100_000
# Angles beyond this are no radians, not even where they go on past a turn; places beyond this no
# metres of a table.
_NO_RADIANS, _NO_RADIANS_UNWRAPPED, _NO_METRES = 7.0, 4.0 * math.pi, 3.0
# So many angles that fill so much of one and no more are turns as likely as radians.
_TELLING, _MOST_OF_A_TURN = 8, 0.7
# Times beyond this count from 1970, seconds to 1e11, thousandths of them from there to 1e14, and so
# on.
_AN_EPOCH = 1e8
# Pairs from which on it is told that they look random: 96 % of random ones do.
_FEWEST_AT_RANDOM = 20
# No reset turns an object alike to this (rad).
_EVENLY = 1e-6
# Seconds from row to row: beyond this a row is a push of its own.
_A_CYCLE = 3.0


@dataclass(frozen=True)
class OwnTable:
    """Columns of pushes in SI units by the names of `read_push_csv`, in our convention.

    words : what was read as what, and left out. segments : of a stream of poses, how it was cut.
    """

    columns: Mapping[str, Array]
    words: tuple[str, ...]
    guessed: bool
    segments: Segments | None = None

    def csv_text(self) -> str:
        """The table as a CSV file that every reader of pushes takes."""
        pandas: Any = import_module("pandas")
        columns = self.columns
        if "theta1" not in columns:
            angles = (name for name in ("theta0", "theta_next") if name in columns)
            columns = {f"{name}_deg": math.degrees(1.0) * columns[name] for name in angles}
        elif "tip_x1" in columns:
            # The names by which rods' places are read, too.
            columns = {
                {"theta0": "th0", "theta1": "th1"}.get(name, name): one
                for name, one in columns.items()
            }
        return str(pandas.DataFrame(columns).to_csv(index=False, lineterminator="\n"))


def is_own(path: str | Path) -> bool:
    """Whether data are of a kind or with columns that `load_pushes` and its like do not read as
    they are.
    """
    place = Path(path)
    if place.is_dir():
        return (place / "meta" / "info.json").is_file() or (place / "metadata.yaml").is_file()
    kind = place.suffix.lower()
    if kind in (*EXCEL, *PARQUET, *BAGS):
        return True
    if kind == ".json" and place.is_file():
        return _is_json_lines(place)
    if kind in JSON_LINES:
        return True
    if kind not in TEXTS or kind in SUFFIXES or not place.is_file():
        return False
    with place.open(encoding="utf-8-sig", errors="replace") as file:
        header = file.readline(_LONGEST_HEADER).lower()
    names = {name.strip().strip('"') for name in header.split(",")}
    # A header that is still being written tells nothing.
    return header.endswith("\n") and not any(names >= wanted for wanted in _OURS)


def _is_json_lines(place: Path) -> bool:
    """Whether a JSON file has a row a line, and not the tables of a push."""
    with place.open(encoding="utf-8-sig", errors="replace") as file:
        line = file.readline(_LONGEST_HEADER)
    try:
        row = json_value(line)
    except ValueError:
        return False
    return isinstance(row, dict) and not set(row) & set(TABLES)


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
        t, x, y, theta (or the quaternion qx, qy, qz, qw) and episode; for a bag pose = its topic. A
        part of a list is named[i]. units : of angles (deg, rad, turn), lengths (mm, cm, m, inch)
        and times (s, ms, us, ns). What is not told is guessed.
    angles, frame, offset_deg : how the file counts angles and lays its axes, as in `Convention`;
        what is not told is what a collection.toml with the data says, else counter-clockwise and
        right-handed, 0.
    Raises DataFileError, saying what the file has and what is wanted, where that cannot be done.
    """
    convention = convention_of(path, angles, frame, offset_deg)
    found, words, guessed, segments = _understood(
        Path(path), dict(columns or {}), units, convention
    )
    pushes, more_words = _cleaned(Path(path), found)
    return OwnTable(pushes, (*words, *more_words, _assumed(pushes, convention)), guessed, segments)


def _assumed(pushes: Columns, convention: Convention) -> str:
    """What is said of the convention:
    orientations alone cannot tell whether it is the right one."""
    if set(pushes) >= _POSES:
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
    found, words, guessed, _ = _understood(
        Path(path), dict(columns or {}), units, convention, growing
    )
    known = np.isfinite(found["theta0"])
    said = (*words, *_without_orientation(known), _assumed({}, convention))
    return OwnTable({"theta0": found["theta0"][known]}, said, guessed)


def _without_orientation(known: Mask) -> list[str]:
    count = int(np.sum(~known))
    return [f"left out for want of an orientation: {count} of {known.size} rows"] if count else []


def _understood(
    place: Path,
    told: dict[str, str],
    units: Sequence[str],
    convention: Convention,
    growing: bool = False,
) -> tuple[Columns, list[str], bool, Segments | None]:
    """The columns in SI units and our convention by our names, what was read as what, whether any
    of that is a guess, and how a stream was cut.
    """
    units = [_UNIT_WORDS.get(unit, unit) for unit in units]
    if growing and place.suffix.lower() not in TEXTS:
        raise DataFileError(
            f"{place}: read once it is whole, without --follow: only a CSV file is read while it "
            "grows"
        )
    for name in told:
        if name not in (*_KNOWN, "pose"):
            raise InvalidInput(f"--columns {name}=...: know {', '.join((*_KNOWN, 'pose'))}")
    for unit in units:
        if unit not in UNITS:
            raise InvalidInput(f"--units {unit}: know {', '.join(UNITS)}")
    raw = raw_columns(place, told, growing)
    meaning = _meaning(place, raw, told)
    if growing and "theta0" not in meaning and ({"t", "episode", "qw"} & set(meaning)):
        raise DataFileError(
            f"{place}: a stream of poses is cut into pushes once it is whole: without --follow"
        )
    words = [f"{place.name}: {len(next(iter(raw.values())))} rows"]
    found: Columns = {}
    for name, column in meaning.items():
        if COLUMNS[name].kind is Kind.TEXT:
            found[name] = raw[column]
            continue
        factor, said = _factor(name, meaning, raw, units)
        if growing and COLUMNS[name].kind is Kind.ANGLE and "guessed" in said:
            raise DataFileError(
                f"{place}: later rows may tell another unit of {column}: say it, --units deg or rad"
            )
        found[name] = factor * raw[column]
        words.append(f"{column} read as {name}{said}")
    if unread := [column for column in raw if column not in meaning.values()]:
        words.append(f"not read: {', '.join(unread)[:400]}")
    if "qw" in found:
        x, y, z, w = (found.pop(name) for name in QUATERNION)
        size = x * x + y * y + z * z + w * w
        found["theta"] = np.arctan2(
            2.0 * (w * z + x * y) / size, 1.0 - 2.0 * (y * y + z * z) / size
        )
    found = convention.columns(found)
    segments, sure = None, len(meaning) > len(told) or not units
    if "theta" in found and "theta0" not in found:
        if _is_stream(place, found, any(" as t in s, guessed" in line for line in words)):
            found, more, segments = _pushes(place, found)
            return found, [*words, *more], sure, segments
        found["theta0"] = found.pop("theta")
        if "t" in found or "episode" in found:
            words.append("a row a push: its orientation the one before the push")
    if "t" in found and len(found["t"]) > _TELLING and "theta1" not in found:
        step = float(np.median(np.abs(np.diff(found["t"]))))
        if 0.0 < step <= _STREAM_STEP:
            line = f"{place}: {step:.2g} s from row to row, so that many rows follow one push"
            mend = (
                f"say --columns theta={meaning.get('theta0', 'NAME')} in place of theta0, or "
                "leave the times out"
            )
            raise DataFileError(f"{line}: {mend}")
    if not growing:
        found, more = _ordered(found)
        words += more
    return found, words, sure, segments


def _ordered(found: Columns) -> tuple[Columns, list[str]]:
    """Rows a push in the order of their numbers, else of their times, and what was done."""
    for name, what in (("repetition", "numbers"), ("episode", "numbers"), ("t", "times")):
        numbers = found.get(name)
        if numbers is None:
            continue
        if not np.isfinite(numbers).all() or np.unique(numbers).size < numbers.size:
            # Of a push that is there twice, or has no number, nobody knows the place.
            if name == "repetition":
                found.pop(name)
                return found, [
                    f"{what} of pushes are missing or there twice: rows are taken in their own "
                    "order"
                ]
            continue
        if (np.diff(numbers) < 0.0).any():
            order = np.argsort(numbers, kind="stable")
            return {one: column[order] for one, column in found.items()}, [
                f"rows put in the order of their {what}"
            ]
        return found, []
    return found, []


def _bare(column: str) -> tuple[str, str]:
    """A column's name without its unit, and the unit; both in small letters."""
    name = re.sub(r"[\s.\-/]+", "_", column.strip().lower())
    # One bracket, not a run of them: the search takes no longer than the name is.
    found = re.search(
        r"[_\[(](deg|degrees?|rad|radians|grad|°|mm|cm|m|metres|meters|in|inch|inches|turns?|revs?|revolutions|s|ms|us|ns)[\])]*$",
        name,
    )
    told = name[: found.start()].rstrip("_[(") if found else ""
    if found and told:
        return told.strip("_"), _UNIT_WORDS.get(found.group(1), found.group(1))
    return name.strip("_"), ""


def _meaning(path: Path, raw: Columns, told: Mapping[str, str]) -> dict[str, str]:
    """The file's column for each name that is told or recognised."""
    have = ", ".join(list(raw)[:20])
    meaning = {name: column for name, column in told.items() if name != "pose"}
    for name, column in meaning.items():
        if column not in raw:
            raise DataFileError(f"{path}: no column {column} for {name}; it has {have}")
    for name, known in COLUMNS.items():
        if name in meaning:
            continue
        free = [column for column in raw if column not in meaning.values()]
        hits = [column for column in free if known.fits(_bare(column)[0])]
        if len(hits) > 1:
            both = f"{' and '.join(hits)} may both be {name}"
            raise DataFileError(f"{path}: {both}: say which, --columns {name}={hits[0]}")
        if hits:
            meaning[name] = hits[0]
    if "theta1" in meaning and "theta1" not in told and not set(meaning) >= _POSES:
        after = meaning["theta1"]
        told_by = f"Say --columns theta1={after} or theta_next={after}"
        raise DataFileError(
            f"{path}: is {after} the orientation after the push, or before the next one? {told_by}"
        )
    quaternion = set(QUATERNION) & set(meaning)
    if quaternion and quaternion != set(QUATERNION):
        raise DataFileError(
            f"{path}: of a quaternion all of qx, qy, qz, qw are wanted; it has {have}"
        )
    if not {"theta0", "theta", "qw"} & set(meaning):
        # Of a moving object the orientation is wanted at every moment, and pushes are found in it.
        one = "theta" if {"t", "episode"} & set(meaning) else "theta0"
        mend = f"say which, --columns {one}=NAME"
        raise DataFileError(
            f"{path}: no column of the object's orientation before each push: {mend}; it has {have}"
        )
    return meaning


def _factor(
    name: str, meaning: Mapping[str, str], raw: Columns, units: Sequence[str]
) -> tuple[float, str]:
    """SI units of one unit of a column, and how that is said. All angles, and all places, are
    guessed to be alike.
    """
    kind = COLUMNS[name].kind
    alike = [one for one in meaning if COLUMNS[one].kind is kind]
    if kind not in (Kind.ANGLE, Kind.PLACE):
        alike = [name]
    kinds = UNITS_OF.get(kind, {})
    if not kinds:
        return 1.0, ""
    told = next((unit for unit in units if unit in kinds), None)
    if told is not None:
        return UNITS[told], f" in {told}"
    named = {one: _bare(meaning[one])[1] for one in alike}
    if named[name] in kinds:
        return UNITS[named[name]], f" in {named[name]}, by its name"
    others = {unit for unit in named.values() if unit in kinds}
    if len(others) == 1:
        return UNITS[unit := others.pop()], f" in {unit}, as its like"
    values = [raw[meaning[one]] for one, unit in named.items() if unit not in kinds]
    reaches = [float(np.abs(column[np.isfinite(column)]).max(initial=0.0)) for column in values]
    least, most = min(reaches), max(reaches)
    if name == "t" and most > _AN_EPOCH:
        # A count since 1970: its size tells the unit.
        unit = list(TIME_UNITS)[min(3, math.floor(math.log10(most / _AN_EPOCH) / 3.0))]
        return UNITS[unit], f" in {unit} since 1970"
    if name == "t":
        unit = "s"
    elif kind is Kind.ANGLE:
        turns = values[0][np.isfinite(values[0])]
        if most <= 1.0 and turns.size >= _TELLING and float(np.ptp(turns)) > _MOST_OF_A_TURN:
            told = f"{meaning[name]} runs from {turns.min():.3g} to {turns.max():.3g}"
            raise DataFileError(
                f"{told}: are these turns, or radians? Say --units turn or --units rad"
            )
        unit = "rad" if least <= _NO_RADIANS and most <= _NO_RADIANS_UNWRAPPED else "deg"
    else:
        unit = "m" if most <= _NO_METRES else "mm"
    return UNITS[
        unit
    ], f" in {unit}, guessed: {'they reach' if len(values) > 1 else 'it reaches'} {most:.4g}"


# -- from streams and rows to pushes
# ---------------------------------------------------------------------------------


def _is_stream(path: Path, found: Columns, guessed: bool) -> bool:
    """Whether rows follow a moving object, several to a push; `guessed`:
    the unit of its times is."""
    if "episode" in found:
        return bool((np.diff(found["episode"]) == 0.0).any())
    if "t" not in found:
        return False
    step = (
        float(np.median(np.diff(np.sort(found["t"][np.isfinite(found["t"])]))))
        if found["t"].size > 1
        else 0.0
    )
    if not step > 0.0:
        raise DataFileError(
            f"{path}: its times do not rise from row to row; mend them, or say --columns "
            "theta0=NAME"
        )
    if _STREAM_STEP < step < _A_CYCLE or (
        guessed and step >= _A_CYCLE and (found["t"] % 1.0 == 0.0).all()
    ):
        raise DataFileError(
            f"{path}: {step:g} s from row to row: do several rows follow one push, or is each a "
            "push of its own? Say the unit of its times, --units s or ms; where each row is a "
            "push, leave the times out"
        )
    return step <= _STREAM_STEP


def _pushes(path: Path, stream: Columns) -> tuple[Columns, list[str], Segments | None]:
    """The pushes of a stream of poses: one an episode, else what its rests and its ring's place
    tell.
    """
    good = np.isfinite(stream["theta"])
    for name in ("t", "x", "y"):
        good &= np.isfinite(stream.get(name, stream["theta"]))
    lost = (
        [f"left out for want of a pose: {int((~good).sum())} of {good.size} rows"]
        if not good.all()
        else []
    )
    stream = {name: values[good] for name, values in stream.items()}
    if "episode" not in stream:
        order = np.argsort(stream["t"], kind="stable")
        if (np.diff(stream["t"]) < 0.0).any():
            lost.append("rows put in the order of their times")
        moving = {name: values[order] for name, values in stream.items()}
        found, seen = cut_stream(path, moving)
        return found, [*lost, seen.words], seen
    known = np.isfinite(stream["episode"])
    stream = {name: values[known] for name, values in stream.items()}
    cuts = np.flatnonzero(np.diff(stream["episode"])) + 1
    parts = np.split(np.arange(stream["theta"].size), cuts)
    spans = [(int(one[0]), int(one[-1])) for one in parts if one.size > 1]
    if not spans:
        raise DataFileError(f"{path}: no push in it: no episode has two rows")
    theta = np.concatenate(
        [np.unwrap(stream["theta"][a : b + 1])[[0, -1]] for a, b in spans]
    ).reshape(-1, 2)
    pushes: Columns = {"theta0": theta[:, 0], "theta1": theta[:, 1]}
    ends = np.array(spans)
    for axis in ("x", "y"):
        place = stream.get(axis, np.zeros(stream["theta"].size))
        pushes |= {f"{axis}{end}": place[ends[:, end]] for end in (0, 1)}
    return pushes, [*lost, f"{len(spans)} pushes, one an episode"], None


def _cleaned(path: Path, found: Columns) -> tuple[Columns, list[str]]:
    """Rows with an orientation, and with it the next one's where that follows; what was left out is
    told.
    """
    known = np.isfinite(found["theta0"])
    words, posed = _without_orientation(known), set(found) >= {"theta1", *_POSES}
    number, at_random = found.get("repetition", np.arange(known.size, dtype=float)), False
    if (
        "theta_next" not in found
        and not posed
        and known.all()
        and (np.diff(number) == 1.0).all()
        and known.size > 1
    ):
        return {"theta0": found["theta0"]}, words
    if "theta_next" not in found:
        following = np.append(found["theta0"][1:], math.nan)
        follows = np.append(np.diff(number) == 1.0, False)
        found["theta_next"] = np.where(follows, following, math.nan)
        if not follows[:-1].all():
            words.insert(
                0, f"no pair across gaps in the numbers of the pushes: {int((~follows[:-1]).sum())}"
            )
        pairs = np.isfinite(found["theta0"]) & np.isfinite(found["theta_next"])
        now, later = found["theta0"][pairs], found["theta_next"][pairs]
        # Where a reset makes them they gather somewhere, or turns have a mean.
        gather = max(
            (abs(np.exp(1j * angle).mean()) for angle in (later, later - now) if now.size),
            default=1.0,
        )
        at_random = posed and now.size >= _FEWEST_AT_RANDOM and gather < 2.0 / math.sqrt(now.size)
        even = posed and now.size > 2 and float(np.ptp(later - now)) < _EVENLY
        if at_random or even:
            how = (
                "are evenly spaced: taken as set one by one"
                if even
                else "go with nothing: taken as set at random"
            )
            words.append(f"orientations before pushes {how}, no cycle among them")
            at_random = True
            del found["theta_next"]
    wanted = ("theta1", *_POSES) if posed else ("theta_next",)
    kept = known & np.all([np.isfinite(found[name]) for name in wanted], axis=0)
    if int(kept.sum()) < 2:
        told = f"{int(kept.sum())} pushes with an orientation and what follows it"
        raise DataFileError(f"{path}: {told}; two or more are wanted")
    facts = ("side", "fraction", "angle", "length")
    poses = ("surface", "object", *ENDS, "theta_next", "repetition", *facts, *RODS)
    if at_random:
        found.pop("repetition", None)
    elif posed:
        found["repetition"] = number
    named = [name for name in (poses if posed else ("theta0", "theta_next")) if name in found]
    return {name: found[name][kept] for name in named}, words
