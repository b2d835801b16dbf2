"""The data of a comparison: pushes by set, the cycles of one collection, and what was left out, brought to one form."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import whole_number
from cyclemap.collection import CollectionLoop
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.evidence.orientations.circular_law import Array
from cyclemap.evidence.pushes.push_table import CSV_SUFFIX, PushTable, load_pushes
from cyclemap.evidence.theta0.theta0_pairs import Theta0Pairs, read_theta0_pairs
from cyclemap.mechanics.slider import MIT_SHAPE_NAMES
from cyclemap.text_files import read_csv_table

if TYPE_CHECKING:
    import pandas

SET_COLUMNS = ("surface", "object", "acceleration", "speed", "side", "fraction", "angle")
# File names give fractions and angles to three decimals.
_ROUNDED = 6e-4
_NO_POSES, _EARLY, _PROTOCOL, _OTHER_SET = "no end pose", "among the first", "another protocol", "cycle of another set"
_CANNOT = "no loop can be made for it"


@dataclass(frozen=True, eq=False)
class PushSet:
    """Pushes of one set that a loop predicts.

    facts : what the files say of the set: surface and object (None where unknown), acceleration (m/s²), speed (m/s),
        side, fraction, angle (rad), NaN where unknown. loop : the mechanics of these pushes.
    theta, dtheta : (n,) rad. displacement : (n, 2) m, in the initial object frame. adapted : whether the loop is not
        the one that was given.
    """

    facts: Mapping[str, Any]
    loop: CollectionLoop
    theta: Array
    dtheta: Array
    displacement: Array
    adapted: bool


@dataclass(frozen=True, eq=False)
class CollectionData:
    """What a comparison takes from the data.

    pushes : the sets with end poses. pairs : the cycles of the set that has most, and the push that each begins with
    (``cycle``, whole numbers); None without any. path : (m,) rad, unwrapped, θ0 of push ``path_first`` and those that
    follow it without a gap, flagged ones too; None where their order is unknown. left_out : pushes, by reason.
    unreadable : files.
    """

    pushes: tuple[PushSet, ...]
    pairs: Theta0Pairs | None
    cycle: Array
    path: Array | None
    path_first: int
    left_out: Mapping[str, int]
    unreadable: int = 0


def collection_data(
    data: Any,
    loop: CollectionLoop | None,
    *,
    first: int = 0,
    adapt: bool = False,
    progress: Callable[[float], None] | None = None,
) -> CollectionData:
    """Bring a ``PushTable``, ``Theta0Pairs`` or a path to one form.

    loop : the mechanics that predict, or None. first : pushes numbered below it are left out; the number is the
    repetition, or where that is unknown the place in the data. adapt : see ``compare``.

    Raises InvalidInput where the data are something else or leave nothing to compare, DataFileError for a bad file.
    """
    start = whole_number("first", first, least=0)
    given = _read(Path(data), progress) if isinstance(data, str | Path) else data
    if isinstance(given, Theta0Pairs):
        return _of_pairs(given, start)
    if isinstance(given, PushTable):
        return _of_table(given, loop, start, adapt)
    raise InvalidInput(f"data is {type(given).__name__}: give a PushTable (load_pushes), Theta0Pairs, or a path")


def _read(path: Path, progress: Callable[[float], None] | None) -> PushTable | Theta0Pairs:
    """A CSV file of θ0 as pairs, which keep their path; all else as a table of pushes."""
    if path.suffix.lower() == CSV_SUFFIX and not path.is_dir() and not _has_poses(read_csv_table(path).header):
        return read_theta0_pairs(path)
    table = load_pushes(path, progress=progress)
    if not len(table.table):
        worst = f"; the first: {table.unreadable[0].path}: {table.unreadable[0].reason}" if table.unreadable else ""
        raise InvalidInput(f"{path}: no push could be read, {len(table.unreadable)} files are bad{worst}")
    return table


def _has_poses(header: tuple[str, ...]) -> bool:
    return {"x0", "y0", "x1", "y1"} <= set(header)


# -- pairs of θ0 ---------------------------------------------------------------------------------------------------


def _of_pairs(pairs: Theta0Pairs, first: int) -> CollectionData:
    cycle = np.arange(pairs.theta.size, dtype=float) if pairs.path is None else _places(pairs, pairs.path)
    kept = cycle >= first
    path = None if pairs.path is None or pairs.path.size - first < 2 else pairs.path[first:]
    left_out = Counter(pairs.dropped) + Counter({_EARLY: int(np.sum(~kept))})
    if not kept.any():
        raise InvalidInput(f"first is {first}: no cycle is left of {pairs.theta.size}; leave out fewer pushes")
    rest = Theta0Pairs(pairs.theta[kept], pairs.theta_next[kept], path)
    return CollectionData((), rest, cycle[kept], path, first, MappingProxyType(dict(left_out)))


def _places(pairs: Theta0Pairs, path: Array) -> Array:
    """The place in the path of each pair, in order; the pairs' own order where they are not of the path."""
    places: list[int] = []
    angles = iter(enumerate(path[:-1].tolist()))
    for theta in pairs.theta.tolist():
        found = next((place for place, angle in angles if angle == theta), None)
        if found is None:
            return np.arange(pairs.theta.size, dtype=float)
        places.append(found)
    return np.array(places, dtype=float)


# -- tables of pushes ----------------------------------------------------------------------------------------------


def _of_table(given: PushTable, loop: CollectionLoop | None, first: int, adapt: bool) -> CollectionData:
    table, left_out = given.table, Counter[str]()
    number = np.where(np.isnan(table["repetition"]), np.arange(len(table)), table["repetition"])
    left_out[_EARLY] = int(np.sum(number < first))
    sets = [_Rows(table, number, rows) for rows in _set_rows(table, number >= first)]
    pushes = [] if loop is None else [_push_set(one, loop, adapt, left_out) for one in sets]
    pairs, cycle, path, begin = _cycles(sets, loop, left_out)
    made = tuple(one for one in pushes if one is not None)
    if not made and pairs is None:
        raise InvalidInput(f"nothing is left of {len(table)} pushes to compare with ({_listed(left_out)})")
    counts = MappingProxyType({reason: count for reason, count in left_out.items() if count})
    return CollectionData(made, pairs, cycle, path, begin, counts, len(given.unreadable))


@dataclass(frozen=True, eq=False)
class _Rows:
    """The rows of one set, in the order of their numbers."""

    table: pandas.DataFrame
    number: Array
    rows: NDArray[np.int64]

    def __getitem__(self, column: str) -> Array:
        return np.asarray(self.table[column].to_numpy()[self.rows], dtype=float)

    @property
    def facts(self) -> dict[str, Any]:
        first = self.table.iloc[int(self.rows[0])]
        texts = {name: first[name] if isinstance(first[name], str) else None for name in SET_COLUMNS[:2]}
        return {**texts, **{name: float(first[name]) for name in SET_COLUMNS[2:]}}


def _set_rows(table: pandas.DataFrame, kept: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """The rows of each set of equal facts, where ``kept``."""
    sets: dict[tuple[str, ...], list[int]] = {}
    keys = zip(*(map(str, table[name]) for name in SET_COLUMNS), strict=True)
    for row, key in enumerate(keys):
        if kept[row]:
            sets.setdefault(key, []).append(row)
    return [np.array(rows, dtype=np.int64) for rows in sets.values()]


def _push_set(rows: _Rows, loop: CollectionLoop, adapt: bool, left_out: Counter[str]) -> PushSet | None:
    posed = np.isfinite(rows["dtheta"]) & np.isfinite(rows["dx"])
    left_out[_NO_POSES] += int(np.sum(~posed))
    count = int(np.sum(posed))
    if not count:
        return None
    facts, own = rows.facts, loop
    adapted = not _same_protocol(facts, loop)
    if adapted and not adapt:
        left_out[_PROTOCOL] += count
        return None
    if adapted:
        try:
            own = CollectionLoop.from_settings(_settings(facts, loop), loop)
        except CycleMapError:
            left_out[_CANNOT] += count
            return None
    displacement = np.stack([rows["dx"][posed], rows["dy"][posed]], axis=-1)
    return PushSet(facts, own, rows["theta0"][posed], rows["dtheta"][posed], displacement, adapted)


def _same_protocol(facts: Mapping[str, Any], loop: CollectionLoop) -> bool:
    """Whether what is known of a set is what the loop does; what is unknown is taken to be."""
    push, name = loop.push, facts["object"]
    numbers = {"side": push.side, "fraction": push.fraction, "angle": push.angle}
    near = all(not abs(facts[key] - own) > _ROUNDED for key, own in numbers.items())
    return near and (name is None or name == loop.slider.name)


def _settings(facts: Mapping[str, Any], loop: CollectionLoop) -> dict[str, object]:
    """The settings that make the loop do what is known of a set."""
    settings: dict[str, object] = {key: facts[key] for key in ("side", "fraction") if not np.isnan(facts[key])}
    if not np.isnan(facts["angle"]):
        settings["angle_deg"] = float(np.degrees(facts["angle"]))
    if facts["object"] is not None and facts["object"] != loop.slider.name:
        if facts["object"] not in MIT_SHAPE_NAMES:
            raise InvalidInput(f"object {facts['object']!r} is no MIT shape")
        settings["shape"] = facts["object"]
    return settings


def _cycles(
    sets: list[_Rows], loop: CollectionLoop | None, left_out: Counter[str]
) -> tuple[Theta0Pairs | None, Array, Array | None, int]:
    """The pairs of the set that has most cycles of the loop's protocol, their pushes, and the path through them."""
    own = [one for one in sets if loop is None or _same_protocol(one.facts, loop)]
    counts = [int(np.sum(np.isfinite(one["theta_next"]))) for one in own]
    if not any(counts):
        return None, np.empty(0), None, 0
    most = int(np.argmax(counts))
    left_out[_OTHER_SET] += sum(counts) - counts[most]
    rows = own[most]
    order = np.argsort(rows.number[rows.rows], kind="stable")
    theta, ahead, number = rows["theta0"][order], rows["theta_next"][order], rows.number[rows.rows][order]
    known = np.isfinite(ahead)
    path, begin = _longest_path(theta, ahead, number)
    return Theta0Pairs(theta[known], ahead[known], path), number[known], path, begin


def _longest_path(theta: Array, ahead: Array, number: Array) -> tuple[Array | None, int]:
    """The longest run of pushes numbered without a gap, as an unwrapped path, and its first number."""
    linked = np.isfinite(ahead[:-1]) & (np.diff(number) == 1.0)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], linked.astype(np.int8), [0]])))
    if not edges.size:
        return None, 0
    longest = int(np.argmax(edges[1::2] - edges[::2]))
    low, high = edges[::2][longest], edges[1::2][longest]
    turns = ahead[low:high] - theta[low:high]
    return theta[low] + np.concatenate([[0.0], np.cumsum(turns)]), int(number[low])


def _listed(left_out: Mapping[str, int]) -> str:
    return ", ".join(f"{count} {reason}" for reason, count in left_out.items() if count) or "it holds none"
