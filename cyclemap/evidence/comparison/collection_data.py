"""The data of a comparison: pushes by set, the cycles of one collection, and what was left out,
brought to one form.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.checks import positive_number, whole_number
from cyclemap.collection import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.motion_check import check_orientations, check_pushes
from cyclemap.evidence.predicted_strokes import loop_of_session
from cyclemap.evidence.pushes.conventions import OURS, written_convention
from cyclemap.evidence.pushes.measured_strokes import NO_LENGTH, told_push
from cyclemap.evidence.pushes.push_table import CSV_SUFFIX, SET_FACTS, PushTable, load_pushes
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs, read_theta0_pairs
from cyclemap.evidence.tables.push_sets import selected_pushes
from cyclemap.mechanics import SidePush, Slider, material_names
from cyclemap.mechanics.first_touch import first_contact
from cyclemap.mechanics.slider import MIT_SHAPE_NAMES
from cyclemap.text_files import file_stem, read_csv_table

if TYPE_CHECKING:
    import pandas

# The columns of a CSV table of poses.
_POSES = {"x0", "y0", "x1", "y1"}
# File names give fractions and angles to three decimals.
_ROUNDED = 6e-4
# A cycle map is compared with a set of cycles of at least so many: two or three tell nothing of a
# map.
FEWEST_CYCLES = 4
# Rods that go this much further or less far, m, make the same push.
_SAME_LENGTH = 0.5e-3
# A rod that seems to begin farther from the object, as a share of its way, is in another frame than
# the object.
_LONGEST_GAP = 0.2
_NO_POSES, _EARLY, _OTHER_SET = "no end pose", "among the first", "cycle of another set"
_NO_OUTLINE = (
    "its outline is not told: give its material file, or put it with the data as collection.toml"
)


@dataclass(frozen=True, eq=False)
class PushSet:
    """Pushes of one set that a loop predicts.

    facts : what the files say of the set: surface and object (None where unknown), acceleration
        (m/s²), speed (m/s), side, fraction, angle (rad), NaN where unknown. loop
        : the mechanics of its object. push : (n,) of that object: the data's place, direction and length.
    theta, dtheta : (n,) rad. displacement : (n, 2) m, in the initial object frame.
    """

    facts: Mapping[str, Any]
    loop: CollectionLoop
    push: tuple[SidePush, ...]
    theta: Array
    dtheta: Array
    displacement: Array


@dataclass(frozen=True, eq=False)
class CollectionData:
    """What a comparison takes from the data.

    Attributes
    ----------
    pushes : tuple of PushSet
        The sets with end poses.
    pairs : Theta0Pairs or None
        The cycles of the set that has most, with the numbers of their pushes and the longest
        path without a gap; None without any.
    left_out : mapping of str to int
        Pushes, by reason.
    loop : CollectionLoop or None
        That makes these cycles: the one given, brought to what the data tell of push and
        object.
    unreadable : int
        Files that could not be read.
    reading : tuple of str
        How angles and axes were read, and how well motions bear that out, in words.
    """

    pushes: tuple[PushSet, ...]
    pairs: Theta0Pairs | None
    left_out: Mapping[str, int]
    loop: Any = None
    unreadable: int = 0
    reading: tuple[str, ...] = ()


def collection_data(
    data: Any,
    loop: CollectionLoop | None,
    *,
    first: int = 0,
    select: Mapping[str, str | float] | None = None,
    push_length: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> CollectionData:
    """Bring a ``PushTable``, ``Theta0Pairs`` or a path to one form.

    loop : the mechanics that predict, or None. first : pushes numbered below it are left out; the
        number is the repetition, or where that is unknown
        the place in the data. select, push_length : see ``compare``.

    Raises InvalidInput where the data are something else or leave nothing to compare, DataFileError
    for a bad file.
    """
    start = whole_number("first", first, least=0)
    length = math.nan if push_length is None else positive_number("push_length", push_length)
    given = _read(Path(data), progress) if isinstance(data, str | Path) else data
    if isinstance(given, Theta0Pairs):
        if select:
            raise InvalidInput(
                f"the data are orientations alone and tell no {next(iter(select))}: select nothing"
            )
        convention = written_convention(data)[0] if isinstance(data, str | Path) else OURS
        reading = check_orientations(given.theta, given.theta_next, loop, convention)
        return replace(_of_pairs(given, loop, start), reading=reading)
    if isinstance(given, PushTable):
        chosen = replace(given, table=selected_pushes(given.table, select or {}))
        reading = () if loop is None else check_pushes(chosen, loop)
        return replace(_of_table(chosen, loop, start, length), reading=reading)
    raise InvalidInput(
        f"data is {type(given).__name__}: give a PushTable (load_pushes), Theta0Pairs, or a path"
    )


def _read(path: Path, progress: Callable[[float], None] | None = None) -> PushTable | Theta0Pairs:
    """A CSV file of θ0 alone as pairs, which keep their path; all else as a table of pushes."""
    if (
        path.suffix.lower() == CSV_SUFFIX
        and not path.is_dir()
        and not set(read_csv_table(path).header) >= _POSES
    ):
        return read_theta0_pairs(path)
    table = load_pushes(path, progress=progress)
    if not len(table.table):
        worst = (
            f"; the first: {table.unreadable[0].path}: {table.unreadable[0].reason}"
            if table.unreadable
            else ""
        )
        raise InvalidInput(
            f"{path}: no push could be read, {len(table.unreadable)} files are bad{worst}"
        )
    return table


def measured_pairs(path: str | Path) -> Theta0Pairs:
    """The pairs of θ0 in data of any form: a CSV table of θ0 or of poses, a file or folder in the
    MIT layout.

    Of several sets it takes the one with most cycles. Raises InvalidInput where no push tells what
    came before the next one, DataFileError for a bad file.
    """
    given = _read(Path(path))
    if isinstance(given, Theta0Pairs):
        return given
    if not np.isfinite(given.table["theta_next"]).any():
        raise InvalidInput(
            f"{path}: no push tells the orientation before the next one, and so what a cycle does"
        )
    pairs = collection_data(given, None).pairs
    assert pairs is not None  # or nothing would have been left
    return pairs


def _of_pairs(pairs: Theta0Pairs, loop: CollectionLoop | None, first: int) -> CollectionData:
    cycle = pairs.numbers
    kept = cycle >= first
    if not kept.any():
        raise InvalidInput(
            f"first is {first}: no cycle is left of {pairs.theta.size}; leave out fewer pushes"
        )
    path, number = pairs.unbroken.path, pairs.unbroken.path_cycle
    if path is not None:
        number = np.arange(float(path.size)) if number is None else number
        late = number >= first
        path, number = (path[late], number[late]) if np.sum(late) > 1 else (None, None)
    left_out = Counter(pairs.dropped) + Counter({_EARLY: int(np.sum(~kept))})
    found = Theta0Pairs(
        pairs.theta[kept], pairs.theta_next[kept], path, cycle=cycle[kept], path_cycle=number
    )
    return CollectionData((), found, dict(left_out), loop)


def _of_table(
    given: PushTable, loop: CollectionLoop | None, first: int, length: float
) -> CollectionData:
    table, left_out = given.table, Counter[str]()
    number = np.where(np.isnan(table["repetition"]), np.arange(len(table)), table["repetition"])
    left_out[_EARLY] = int(np.sum(number < first))
    # The rows of each set of equal facts.
    by_facts: dict[tuple[str, ...], list[int]] = {}
    for row, key in enumerate(zip(*(map(str, table[name]) for name in SET_FACTS), strict=True)):
        if number[row] >= first:
            by_facts.setdefault(key, []).append(row)
    sets = [_Rows(table, number, np.array(rows, dtype=np.int64)) for rows in by_facts.values()]
    if loop is not None:
        sets = _fitting(sets, loop, left_out)
    pushes = [] if loop is None else _push_sets(sets, loop, length, left_out)
    pairs, own = _cycles(sets, loop, length, left_out)
    counts = {reason: count for reason, count in left_out.items() if count}
    if not pushes and pairs is None:
        told = (
            "; ".join(f"{count}: {reason}" for reason, count in counts.items()) or "it holds none"
        )
        raise InvalidInput(f"nothing is left of {len(table)} pushes to compare with ({told})")
    return CollectionData(tuple(pushes), pairs, counts, own, len(given.unreadable))


@dataclass(frozen=True, eq=False)
class _Rows:
    """The rows of one set, in the order of their numbers."""

    table: pandas.DataFrame
    number: Array
    rows: NDArray[np.int64]

    def __getitem__(self, column: str) -> Array:
        return np.asarray(self.table[column].to_numpy()[self.rows], dtype=float)

    def lengths(self, length: float, loop: CollectionLoop) -> Array:
        """How far the rod of a push of the loop went from its first touch, m; `length` where that
        is unknown.

        Where it begins is told by its first place and the object's first pose, in the median of the
        set.
        """
        found, theta = self["length"], self["theta0"]
        if np.isnan(self["tip_x0"]).all():
            return np.where(np.isnan(found), length, found)
        push = told_push(loop.push, self.facts, loop.push.distance)
        place, way = first_contact(loop.slider, push, loop.pusher.radius)
        x, y = self["tip_x0"] - self["x0"], self["tip_y0"] - self["y0"]
        tip = np.stack(
            [np.cos(theta) * x + np.sin(theta) * y, np.cos(theta) * y - np.sin(theta) * x], axis=-1
        )
        gaps = (place - tip) @ way
        gap = float(np.median(gaps[np.isfinite(gaps)])) if np.isfinite(gaps).any() else 0.0
        found = np.where(abs(gap) < _LONGEST_GAP * found, found - gap, found)
        return np.where(np.isnan(found), length, found)

    @property
    def facts(self) -> dict[str, Any]:
        first = self.table.iloc[int(self.rows[0])]
        texts = {
            name: first[name] if isinstance(first[name], str) else None for name in SET_FACTS[:2]
        }
        return {**texts, **{name: float(first[name]) for name in SET_FACTS[2:]}}


def _fitting(sets: list[_Rows], loop: CollectionLoop, left_out: Counter[str]) -> list[_Rows]:
    """The sets of the loop's surface and of objects whose outline is known; the others are counted
    by name.
    """
    told = {one.facts["surface"] for one in sets} - {None}
    words = {loop.material.name, re.split(r"[-_ ]", loop.material.name)[0]}
    own = words & (told | {*material_names()} - {"isotropic"})
    if len(told) > 1 and not own:
        listed = ", ".join(sorted(told))
        raise InvalidInput(
            f"the data are of several surfaces ({listed}), and the material {loop.material.name!r} "
            "names none of them: select one, surface=NAME"
        )
    fitting = []
    for one in sets:
        surface, shape = one.facts["surface"], one.facts["object"]
        if own and surface is not None and surface not in own:
            left_out[f"on {surface}, not {min(own, key=len)}"] += one.rows.size
        elif shape not in (None, file_stem(loop.slider.name), *MIT_SHAPE_NAMES):
            left_out[_NO_OUTLINE] += one.rows.size
        else:
            fitting.append(one)
    return fitting


def _push_sets(
    sets: list[_Rows], loop: CollectionLoop, length: float, left_out: Counter[str]
) -> list[PushSet]:
    """The sets with end poses whose pushes are as long as is known, each with the pushes that the
    data tell.
    """
    loops, made = {None: loop, file_stem(loop.slider.name): loop}, []
    for rows in sets:
        posed = np.isfinite(rows["dtheta"]) & np.isfinite(rows["dx"])
        facts = rows.facts
        if facts["object"] not in loops:
            loops[facts["object"]] = loop_of_session(
                loop, Slider.mit(facts["object"], loop.slider.hitch)
            )
        loop_of_set = loops[facts["object"]]
        far = rows.lengths(length, loop_of_set)
        kept = posed & np.isfinite(far)
        left_out[_NO_POSES] += int(np.sum(~posed))
        left_out[NO_LENGTH] += int(np.sum(posed & ~kept))
        if not kept.any():
            continue
        push = tuple(told_push(loop.push, facts, one) for one in far[kept].tolist())
        displacement = np.stack([rows["dx"][kept], rows["dy"][kept]], axis=-1)
        made.append(
            PushSet(
                facts, loop_of_set, push, rows["theta0"][kept], rows["dtheta"][kept], displacement
            )
        )
    return made


def _cycles(
    sets: list[_Rows], loop: CollectionLoop | None, length: float, left_out: Counter[str]
) -> tuple[Theta0Pairs | None, CollectionLoop | None]:
    """The pairs of the set that has most cycles, and the loop that makes them."""
    counts = [int(np.sum(np.isfinite(one["theta_next"]))) for one in sets]
    most = max(counts, default=0)
    if most < FEWEST_CYCLES:
        left_out[f"cycles, fewer than {FEWEST_CYCLES} of one set"] += sum(counts)
        return None, loop
    left_out[_OTHER_SET] += sum(counts) - most
    rows = sets[counts.index(most)]
    if loop is not None:
        if rows.facts["object"] not in (None, file_stem(loop.slider.name)):
            loop = loop_of_session(loop, Slider.mit(rows.facts["object"], loop.slider.hitch))
        far = float(np.median(rows.lengths(length, loop)))
        if np.isnan(far) and not np.isnan(rows["dtheta"]).all():
            left_out[f"cycles: {NO_LENGTH}"] += most
            return None, loop
        own, push = (
            loop.push,
            told_push(loop.push, rows.facts, loop.push.distance if np.isnan(far) else far),
        )
        # One push, but for the three decimals of a file's name and the robot's own errors, is the
        # loop's.
        near = max(abs(push.fraction - own.fraction), abs(push.angle - own.angle)) <= _ROUNDED
        if push.side != own.side or not near or abs(push.distance - own.distance) > _SAME_LENGTH:
            loop = replace(loop, push=push)
    order = np.argsort(rows.number[rows.rows], kind="stable")
    theta, ahead, number = (
        rows["theta0"][order],
        rows["theta_next"][order],
        rows.number[rows.rows][order],
    )
    known = np.isfinite(ahead)
    # The longest run of pushes numbered without a gap.
    linked = np.isfinite(ahead[:-1]) & (np.diff(number) == 1.0)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], linked.astype(np.int8), [0]])))
    path = run = None
    if edges.size:
        longest = int(np.argmax(edges[1::2] - edges[::2]))
        low, high = edges[::2][longest], edges[1::2][longest]
        path = theta[low] + np.concatenate([[0.0], np.cumsum(ahead[low:high] - theta[low:high])])
        run = number[low : high + 1]
    return Theta0Pairs(theta[known], ahead[known], path, cycle=number[known], path_cycle=run), loop
