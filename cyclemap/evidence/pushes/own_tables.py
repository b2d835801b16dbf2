"""Tables of one's own, as `own_files` reads them, brought to the columns of `read_push_csv`.

What a column means is told or guessed by its name, its unit by name or size; every guess is said, and nothing that two
readings are possible of is guessed. A stream of one object's poses becomes pushes by its episodes, or by its rests.
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
from cyclemap.evidence.pushes.own_files import BAGS, EXCEL, PARQUET, QUATERNION, Columns, raw_columns
from cyclemap.evidence.pushes.push_files import SUFFIXES

TEXTS = (".csv", ".tsv", ".txt", ".dat")
_ANGLES, _PLACES = ("theta0", "theta1", "theta_next", "theta"), ("x0", "y0", "x1", "y1", "x", "y")
_LENGTHS = (*_PLACES, "length")
_OTHERS = ("t", "episode", "repetition", "side", "fraction")
_KNOWN = (*_ANGLES, *_LENGTHS, *_OTHERS, *QUATERNION)
_ANGLE_UNITS, _LENGTH_UNITS = {"deg": math.pi / 180.0, "rad": 1.0}, {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
_TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_UNITS = _ANGLE_UNITS | _LENGTH_UNITS | _TIME_UNITS
_UNITS_OF = dict.fromkeys(_ANGLES, _ANGLE_UNITS) | dict.fromkeys(_LENGTHS, _LENGTH_UNITS) | {"t": _TIME_UNITS}

_ANGLE = r"(?:yaw|theta|th|angle|orientation|heading|rot|rotation|rz|winkel)"
_BEFORE, _AFTER = r"(?:0|before|start|initial|init|pre|vorher|first)", r"(?:1|after|end|final|post|nachher|last)"
_MEANING = {
    "theta0": (rf"{_ANGLE}_?{_BEFORE}", rf"{_BEFORE}_{_ANGLE}"),
    "theta1": (rf"{_ANGLE}_?{_AFTER}", rf"{_AFTER}_{_ANGLE}"),
    "theta_next": (rf"(?:{_ANGLE}_next|next_{_ANGLE}|th0n)(?:_?0)?",),
    "theta": (rf"{_ANGLE}",),
    **{
        f"{axis}{end}": (rf"(?:pos_?)?{axis}_?{words}", rf"{words}_(?:pos_)?{axis}")
        for axis in "xy"
        for end, words in (("0", _BEFORE), ("1", _AFTER))
    },
    "x": (r"(?:pos(?:ition)?_)?x",),
    "y": (r"(?:pos(?:ition)?_)?y",),
    "t": (r"t|time|timestamp|stamp|secs?|seconds|zeit",),
    "episode": (r"episode(?:_index|_id)?|trial|push_id",),
    "repetition": (r"rep|repetition|push|cycle|nr|no|number",),
    "length": (r"push_?length|push_?distance",),
    **{
        name: (rf"(?:orientation_|quat(?:ernion)?_)?{name}", rf"(?:orientation|quat(?:ernion)?)_{name[1]}")
        for name in QUATERNION
    },
}
_UNIT_WORDS = dict.fromkeys(("degrees", "degree", "°", "grad"), "deg") | {
    "radians": "rad",
    "metres": "m",
    "meters": "m",
}
# Columns by which a table is known to be one that `load_pushes` and its like read as it is.
_POSES = {"x0", "y0", "x1", "y1"}
_OURS = ({"theta0_deg"}, {"theta0_accum_deg"}, _POSES, {"x1", "y1", "x0n", "y0n"}, {"fx", "fy", "vx", "vy"})
# A rest of a stream of poses, and what counts as one: slower than m/s and rad/s for so many seconds.
_REST_SECONDS, _SLOW, _SLOW_TURN, _SMOOTHED_SECONDS = 0.4, 0.003, 0.03, 0.2
_LONGEST_HEADER = 100_000
# Angles beyond this are no radians, not even where they go on past a turn; places beyond this no metres of a table.
_NO_RADIANS, _NO_RADIANS_UNWRAPPED, _NO_METRES = 7.0, 4.0 * math.pi, 3.0
# Times beyond this count from 1970, seconds to 1e11, thousandths of them from there to 1e14, and so on.
_AN_EPOCH = 1e8
# Pairs from which on it is told that they look random: 96 % of random ones do.
_FEWEST_AT_RANDOM = 20
# Seconds from row to row: beyond this a row is a push of its own.
_A_CYCLE = 3.0


@dataclass(frozen=True)
class OwnTable:
    """Columns of pushes in SI units by the names of `read_push_csv`; words: what was read as what, and left out."""

    columns: Mapping[str, Array]
    words: tuple[str, ...]
    guessed: bool

    def csv_text(self) -> str:
        """The table as a CSV file that every reader of pushes takes."""
        pandas: Any = import_module("pandas")
        columns = self.columns
        if "theta1" not in columns:
            angles = (name for name in ("theta0", "theta_next") if name in columns)
            columns = {f"{name}_deg": math.degrees(1.0) * columns[name] for name in angles}
        return str(pandas.DataFrame(columns).to_csv(index=False, lineterminator="\n"))


def is_own(path: str | Path) -> bool:
    """Whether data are of a kind or with columns that `load_pushes` and its like do not read as they are."""
    place = Path(path)
    if place.is_dir():
        return (place / "meta" / "info.json").is_file() or (place / "metadata.yaml").is_file()
    kind = place.suffix.lower()
    if kind in (*EXCEL, *PARQUET, *BAGS):
        return True
    if kind not in TEXTS or kind in SUFFIXES or not place.is_file():
        return False
    with place.open(encoding="utf-8-sig", errors="replace") as file:
        header = file.readline(_LONGEST_HEADER).lower()
    names = {name.strip().strip('"') for name in header.split(",")}
    # A header that is still being written tells nothing.
    return header.endswith("\n") and not any(names >= wanted for wanted in _OURS)


def read_own_table(path: str | Path, columns: Mapping[str, str] | None = None, units: Sequence[str] = ()) -> OwnTable:
    """Read a table of one's own, or a stream of poses, as pushes.

    columns : the file's column of each of theta0, theta1, theta_next, x0, y0, x1, y1, of a stream t, x, y, theta (or
    the quaternion qx, qy, qz, qw) and episode; for a bag pose = its topic. A part of a list is named[i]. units : of
    angles (deg, rad), lengths (mm, cm, m) and times (s, ms, us, ns). What is not told is guessed.
    Raises DataFileError, saying what the file has and what is wanted, where that cannot be done.
    """
    found, words, guessed = _understood(Path(path), dict(columns or {}), units)
    pushes, more_words = _cleaned(Path(path), found)
    return OwnTable(pushes, (*words, *more_words), guessed)


def read_orientations(
    path: str | Path, columns: Mapping[str, str] | None = None, units: Sequence[str] = (), growing: bool = False
) -> OwnTable:
    """Read θ0 alone of a table of one's own, as `read_own_table` does: every one known, in the order of the rows.

    growing : a CSV file that is written to, whose last line waits for its end. Then DataFileError also where rows to
    come could change what earlier ones mean: a stream of poses, or a unit that would be guessed.
    """
    found, words, guessed = _understood(Path(path), dict(columns or {}), units, growing)
    known = np.isfinite(found["theta0"])
    return OwnTable({"theta0": found["theta0"][known]}, (*words, *_without_orientation(known)), guessed)


def _without_orientation(known: Mask) -> list[str]:
    count = int(np.sum(~known))
    return [f"left out for want of an orientation: {count} of {known.size} rows"] if count else []


def _understood(
    place: Path, told: dict[str, str], units: Sequence[str], growing: bool = False
) -> tuple[Columns, list[str], bool]:
    """The columns in SI units by our names, what was read as what, and whether any of that is a guess."""
    if growing and place.suffix.lower() not in TEXTS:
        raise DataFileError(f"{place}: read once it is whole, without --follow: only a CSV file is read while it grows")
    for name in told:
        if name not in (*_KNOWN, "pose"):
            raise InvalidInput(f"--columns {name}=...: know {', '.join((*_KNOWN, 'pose'))}")
    for unit in units:
        if unit not in _UNITS:
            raise InvalidInput(f"--units {unit}: know {', '.join(_UNITS)}")
    raw = raw_columns(place, told, growing)
    meaning = _meaning(place, raw, told)
    if growing and "theta0" not in meaning and ({"t", "episode", "qw"} & set(meaning)):
        raise DataFileError(f"{place}: a stream of poses is cut into pushes once it is whole: without --follow")
    words = [f"{place.name}: {len(next(iter(raw.values())))} rows"]
    found: Columns = {}
    for name, column in meaning.items():
        factor, said = _factor(name, meaning, raw, units)
        if growing and name in _ANGLES and "guessed" in said:
            raise DataFileError(f"{place}: later rows may tell another unit of {column}: say it, --units deg or rad")
        found[name] = factor * raw[column]
        words.append(f"{column} read as {name}{said}")
    if "qw" in found:
        x, y, z, w = (found.pop(name) for name in QUATERNION)
        size = x * x + y * y + z * z + w * w
        found["theta"] = np.arctan2(2.0 * (w * z + x * y) / size, 1.0 - 2.0 * (y * y + z * z) / size)
    if "theta" in found and "theta0" not in found:
        if _is_stream(place, found, any(" as t in s, guessed" in line for line in words)):
            found, more = _pushes(place, found)
            words.append(more)
        else:
            found["theta0"] = found.pop("theta")
            if "t" in found or "episode" in found:
                words.append("a row a push: its orientation the one before the push")
    return found, words, len(meaning) > len(told) or not units


def _bare(column: str) -> tuple[str, str]:
    """A column's name without its unit, and the unit; both in small letters."""
    name = re.sub(r"[\s.\-/]+", "_", column.strip().lower())
    # One bracket, not a run of them: the search takes no longer than the name is.
    found = re.search(r"[_\[(](deg|degrees?|rad|radians|grad|°|mm|cm|m|metres|meters|s|ms|us|ns)[\])]*$", name)
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
    for name, patterns in _MEANING.items():
        if name in meaning:
            continue
        free = [column for column in raw if column not in meaning.values()]
        hits = [column for column in free if any(re.fullmatch(one, _bare(column)[0]) for one in patterns)]
        if len(hits) > 1:
            both = f"{' and '.join(hits)} may both be {name}"
            raise DataFileError(f"{path}: {both}: say which, --columns {name}={hits[0]}")
        if hits:
            meaning[name] = hits[0]
    if "theta1" in meaning and "theta1" not in told and not set(meaning) >= _POSES:
        after = meaning["theta1"]
        told_by = f"Say --columns theta1={after} or theta_next={after}"
        raise DataFileError(f"{path}: is {after} the orientation after the push, or before the next one? {told_by}")
    quaternion = set(QUATERNION) & set(meaning)
    if quaternion and quaternion != set(QUATERNION):
        raise DataFileError(f"{path}: of a quaternion all of qx, qy, qz, qw are wanted; it has {have}")
    if not {"theta0", "theta", "qw"} & set(meaning):
        mend = "say which, --columns theta0=NAME"
        raise DataFileError(f"{path}: no column of the object's orientation before each push: {mend}; it has {have}")
    return meaning


def _factor(name: str, meaning: Mapping[str, str], raw: Columns, units: Sequence[str]) -> tuple[float, str]:
    """SI units of one unit of a column, and how that is said. All angles, and all places, are guessed to be alike."""
    alike = _ANGLES if name in _ANGLES else _PLACES if name in _PLACES else (name,)
    kinds = (
        _ANGLE_UNITS if name in _ANGLES else _LENGTH_UNITS if name in _LENGTHS else _TIME_UNITS if name == "t" else {}
    )
    if not kinds:
        return 1.0, ""
    told = next((unit for unit in units if unit in kinds), None)
    if told is not None:
        return _UNITS[told], f" in {told}"
    named = {one: _bare(meaning[one])[1] for one in alike if one in meaning}
    if named[name] in kinds:
        return _UNITS[named[name]], f" in {named[name]}, by its name"
    others = {unit for unit in named.values() if unit in kinds}
    if len(others) == 1:
        return _UNITS[unit := others.pop()], f" in {unit}, as its like"
    values = [raw[meaning[one]] for one, unit in named.items() if unit not in kinds]
    reaches = [float(np.abs(column[np.isfinite(column)]).max(initial=0.0)) for column in values]
    least, most = min(reaches), max(reaches)
    if name == "t" and most > _AN_EPOCH:
        # A count since 1970: its size tells the unit.
        unit = list(_TIME_UNITS)[min(3, math.floor(math.log10(most / _AN_EPOCH) / 3.0))]
        return _UNITS[unit], f" in {unit} since 1970"
    if name == "t":
        unit = "s"
    elif name in _ANGLES:
        unit = "rad" if least <= _NO_RADIANS and most <= _NO_RADIANS_UNWRAPPED else "deg"
    else:
        unit = "m" if most <= _NO_METRES else "mm"
    return _UNITS[unit], f" in {unit}, guessed: {'they reach' if len(values) > 1 else 'it reaches'} {most:.4g}"


# -- from streams and rows to pushes ---------------------------------------------------------------------------------


def _is_stream(path: Path, found: Columns, guessed: bool) -> bool:
    """Whether rows follow a moving object, several to a push; `guessed`: the unit of its times is."""
    if "episode" in found:
        return bool((np.diff(found["episode"]) == 0.0).any())
    if "t" not in found:
        return False
    step = float(np.median(np.diff(found["t"])))
    if not step > 0.0:
        raise DataFileError(f"{path}: its times do not rise from row to row; mend them, or say --columns theta0=NAME")
    if _REST_SECONDS < step < _A_CYCLE or (guessed and step >= _A_CYCLE and (found["t"] % 1.0 == 0.0).all()):
        raise DataFileError(
            f"{path}: {step:g} s from row to row: do several rows follow one push, or is each a push of its own? Say "
            "the unit of its times, --units s or ms; where each row is a push, leave the times out"
        )
    return step <= _REST_SECONDS


def _pushes(path: Path, stream: Columns) -> tuple[Columns, str]:
    """The pushes of a stream of poses: one an episode, else every other motion between rests, the first a push."""
    good = np.isfinite(stream["theta"])
    stream = {name: values[good] for name, values in stream.items()}
    if "episode" in stream:
        cuts = np.flatnonzero(np.diff(stream["episode"])) + 1
        parts = np.split(np.arange(stream["theta"].size), cuts)
        spans = [(int(part[0]), int(part[-1])) for part in parts if part.size > 1]
        words = f"{len(spans)} pushes, one an episode"
    else:
        motions = _motions(stream)
        spans = motions[::2]
        words = f"{len(motions)} motions between rests: the first and every other one a push, the rest drags back"
    if not spans:
        raise DataFileError(f"{path}: no push in it: its object never moves, or never rests")
    theta = np.concatenate([np.unwrap(stream["theta"][a : b + 1])[[0, -1]] for a, b in spans]).reshape(-1, 2)
    found: Columns = {"theta0": theta[:, 0], "theta1": theta[:, 1]}
    ends = np.array(spans)
    for axis in ("x", "y"):
        place = stream.get(axis, np.zeros(stream["theta"].size))
        found |= {f"{axis}{end}": place[ends[:, end]] for end in (0, 1)}
    return found, words


def _motions(stream: Columns) -> list[tuple[int, int]]:
    """First and last sample of each motion that rests divide."""
    from scipy.ndimage import uniform_filter1d

    t, zero = stream["t"], np.zeros(stream["t"].size)
    width = max(1, round(_SMOOTHED_SECONDS / max(float(np.median(np.diff(t))), 1e-6)))
    courses = stream.get("x", zero), stream.get("y", zero), np.unwrap(stream["theta"])
    x, y, turn = (np.gradient(uniform_filter1d(one, 2 * width + 1, mode="nearest"), t) for one in courses)
    moves = (np.hypot(x, y) > _SLOW) | (np.abs(turn) > _SLOW_TURN)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], moves.astype(np.int8), [0]])))
    begin, end = edges[::2], edges[1::2] - 1
    rests = t[begin[1:]] - t[end[:-1]] >= _REST_SECONDS
    begin, end = begin[np.append(True, rests)[: begin.size]], end[np.append(rests, True)[: end.size]]
    # Where smoothing begins to see a motion the object may be on its way: go out to the rests' own samples.
    return list(zip(np.maximum(begin - width, 0).tolist(), np.minimum(end + width, t.size - 1).tolist(), strict=True))


def _cleaned(path: Path, found: Columns) -> tuple[Columns, list[str]]:
    """Rows with an orientation, and with it the next one's where that follows; what was left out is told."""
    known = np.isfinite(found["theta0"])
    words, posed = _without_orientation(known), set(found) >= {"theta1", *_POSES}
    number, at_random = found.get("repetition", np.arange(known.size, dtype=float)), False
    if "theta_next" not in found and not posed and known.all() and (np.diff(number) == 1.0).all() and known.size > 1:
        return {"theta0": found["theta0"]}, words
    if "theta_next" not in found:
        following = np.append(found["theta0"][1:], math.nan)
        follows = np.append(np.diff(number) == 1.0, False)
        found["theta_next"] = np.where(follows, following, math.nan)
        if not follows[:-1].all():
            words.insert(0, f"no pair across gaps in the numbers of the pushes: {int((~follows[:-1]).sum())}")
        pairs = np.isfinite(found["theta0"]) & np.isfinite(found["theta_next"])
        now, later = found["theta0"][pairs], found["theta_next"][pairs]
        # Where a reset makes them they gather somewhere, or turns have a mean.
        gather = max((abs(np.exp(1j * angle).mean()) for angle in (later, later - now) if now.size), default=1.0)
        at_random = posed and now.size >= _FEWEST_AT_RANDOM and gather < 2.0 / math.sqrt(now.size)
        if at_random:
            words.append("orientations before pushes go with nothing: taken as set at random, no cycle among them")
            del found["theta_next"]
    wanted = ("theta1", *_POSES) if posed else ("theta_next",)
    kept = known & np.all([np.isfinite(found[name]) for name in wanted], axis=0)
    if int(kept.sum()) < 2:
        told = f"{int(kept.sum())} pushes with an orientation and what follows it"
        raise DataFileError(f"{path}: {told}; two or more are wanted")
    poses = ("x0", "y0", "theta0", "x1", "y1", "theta1", "theta_next", "repetition", "side", "fraction", "length")
    if at_random:
        found.pop("repetition", None)
    elif posed:
        found["repetition"] = number
    named = [name for name in (poses if posed else ("theta0", "theta_next")) if name in found]
    return {name: found[name][kept] for name in named}, words
