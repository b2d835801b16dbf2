"""The data of a comparison: pushes by set, the cycles of one collection, and what was left out,
brought to one form.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cyclemap.arrays import Array, stretches
from cyclemap.checks import positive_number, whole_number
from cyclemap.collection import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.laws.push_sets import ordered_pairs, selected_pushes
from cyclemap.evidence.motion_check import check_orientations, check_pushes
from cyclemap.evidence.predicted_strokes import by_contact, contact_words, is_near, loop_of_plate
from cyclemap.evidence.pushes.measured_strokes import NO_LENGTH, told_push
from cyclemap.evidence.pushes.push_table import SET_FACTS, PushTable, load_pushes
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs, read_theta0_pairs
from cyclemap.evidence.tables.columns import OURS, Convention, Row, Selection, written_convention
from cyclemap.evidence.tables.data_kinds import tells_orientations_alone
from cyclemap.mechanics import SidePush, material_names
from cyclemap.mechanics.contact_curve import first_contact
from cyclemap.mechanics.slider import MIT_SHAPE_NAMES
from cyclemap.progress import Progress
from cyclemap.text_files import file_stem

if TYPE_CHECKING:
    import pandas

# A cycle map is compared with a set of cycles of at least so many: two or three tell nothing of a
# map.
FEWEST_CYCLES = 4
# Rods that go this much further or less far, m, make the same push.
_SAME_LENGTH = 0.5e-3
# A rod that seems to begin farther from the object, as a share of its way, is in another frame than
# the object.
_LONGEST_GAP = 0.2
_NO_POSES = "no end pose"
_EARLY = "among the first"
_OTHER_SET = "cycle of another set"
# What symmetric objects on isotropic friction cannot tell from the convention that is assumed.
_MIRRORED = Convention("clockwise", "mirrored")
_IN_A_MIRROR = (
    "were axes mirrored and angles clockwise, the rod's contact would be the protocol's: give "
    f"{_MIRRORED.options()} if they are"
)
_NO_OUTLINE = (
    "its outline is not told: give its material file, or put it with the data as collection.toml"
)


@dataclass(frozen=True, eq=False)
class PosedSet:
    """Pushes of one set whose ends are known, and the loop that predicts them.

    facts : what the files say of the set: surface and object (None where unknown), acceleration
        (m/s²), speed (m/s), side, fraction, angle (rad), NaN where unknown.
    loop : the mechanics of its object.
    push : (n,) of that object: the data's place, direction and length.
    theta : (n,) rad.
    motion : (n, 3) dtheta (rad), dx, dy (m, in the initial object frame).
    """

    facts: Row
    loop: CollectionLoop
    push: tuple[SidePush, ...]
    theta: Array
    motion: Array


@dataclass(frozen=True, eq=False)
class CollectionData:
    """What a comparison takes from the data.

    Attributes
    ----------
    pushes : tuple of PosedSet
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

    pushes: tuple[PosedSet, ...]
    pairs: Theta0Pairs | None
    left_out: Mapping[str, int]
    loop: CollectionLoop | None = None
    unreadable: int = 0
    reading: tuple[str, ...] = ()


def collection_data(
    data: object,
    loop: CollectionLoop | None,
    *,
    first: int = 0,
    select: Selection | None = None,
    push_length: float | None = None,
    progress: Progress | None = None,
) -> CollectionData:
    """Bring a ``PushTable``, ``Theta0Pairs`` or a path to one form.

    loop : the mechanics that predict, or None.
    first : pushes numbered below it are left out; the number is the repetition, or where that is
        unknown the place in the data.
    select, push_length : see ``compare``.

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
        taken = _of_table(chosen, loop, start, length)
        return replace(taken, reading=(*reading, *taken.reading))
    raise InvalidInput(
        f"data is {type(given).__name__}: give a PushTable (load_pushes), Theta0Pairs, or a path"
    )


def _read(path: Path, progress: Progress | None = None) -> PushTable | Theta0Pairs:
    """A CSV file of θ0 alone as pairs, which keep their path; all else as a table of pushes."""
    if tells_orientations_alone(path):
        return read_theta0_pairs(path)
    pushes = load_pushes(path, progress=progress)
    if len(pushes.table):
        return pushes
    bad = f"{len(pushes.unreadable)} files are bad"
    for first in pushes.unreadable[:1]:
        bad += f"; the first: {first.path}: {first.reason}"
    raise InvalidInput(f"{path}: no push could be read, {bad}")


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
    left_out = Counter(pairs.dropped) + Counter({_EARLY: int(np.sum(~kept))})
    return CollectionData((), _in_a_row(pairs, first), dict(left_out), loop)


def _in_a_row(pairs: Theta0Pairs, first: int) -> Theta0Pairs:
    """The pairs of pushes numbered from `first` on, with the longest stretch of their path that
    lacks no push: a simulated collection lacks none.
    """
    kept = pairs.numbers >= first
    whole = pairs.unbroken
    path = numbers = None
    if whole.path is not None:
        along = whole.path_cycle
        along = np.arange(float(whole.path.size)) if along is None else along
        runs = stretches((np.diff(along) == 1.0) & (along[:-1] >= first))
        if runs:
            low, high = max(runs, key=lambda run: run[1] - run[0])
            path = whole.path[low : high + 1]
            numbers = along[low : high + 1]
    theta, theta_next, cycle = (
        column[kept] for column in (pairs.theta, pairs.theta_next, pairs.numbers)
    )
    return Theta0Pairs(theta, theta_next, path, cycle=cycle, path_cycle=numbers)


def _of_table(
    given: PushTable, loop: CollectionLoop | None, first: int, length: float
) -> CollectionData:
    repetition = given.table["repetition"].to_numpy()
    numbers = np.where(np.isnan(repetition), np.arange(repetition.size), repetition)
    table = given.table.assign(number=numbers)[numbers >= first]
    left_out = Counter({_EARLY: int(np.sum(numbers < first))})
    sets = [rows for _, rows in table.groupby([*SET_FACTS], dropna=False, sort=False)]
    pushes = list[PosedSet]()
    words: tuple[str, ...] = ()
    if loop is not None:
        fitting = _fitting(sets, loop, left_out)
        sets, words = _at_contacts(fitting, loop, left_out)
        if words and given.convention.is_ours and not given.convention_told:
            mirrored = [_MIRRORED.rows(rows) for rows in fitting]
            if not _at_contacts(mirrored, loop, Counter())[1]:
                words += (_IN_A_MIRROR,)
        pushes = _posed_sets(sets, loop, length, left_out)
    pairs, own = _cycles(sets, loop, length, left_out)
    counts = {reason: count for reason, count in left_out.items() if count}
    if not pushes and pairs is None:
        reasons = "; ".join(f"{count}: {reason}" for reason, count in counts.items())
        raise InvalidInput(
            f"nothing is left of {numbers.size} pushes to compare with "
            f"({reasons or 'it holds none'})"
        )
    return CollectionData(tuple(pushes), pairs, counts, own, len(given.unreadable), words)


def _facts(rows: pandas.DataFrame) -> Row:
    """What all pushes of a set share: texts None, numbers NaN where unknown."""
    facts = {name: rows[name].iloc[0] for name in SET_FACTS}
    for name in ("surface", "object"):
        facts[name] = facts[name] if isinstance(facts[name], str) else None
    return facts


def _lengths(rows: pandas.DataFrame, length: float, loop: CollectionLoop) -> Array:
    """How far the rod of a push of the loop went from its first touch (n,), m; `length` where that
    is unknown.

    Where it begins is told by its first place and the object's first pose, in the median of the
    set.
    """
    far = rows["length"].to_numpy()
    tip_x, tip_y, x, y, theta = rows[["tip_x0", "tip_y0", "x0", "y0", "theta0"]].to_numpy().T
    begun = (tip_x - x + 1j * (tip_y - y)) * np.exp(-1j * theta)
    known = begun[np.isfinite(begun)]
    if known.size:
        push = told_push(loop.push, _facts(rows), loop.push.distance)
        touch, way = first_contact(loop.slider, push, loop.pusher.radius)
        gap = float(np.median(((complex(*touch) - known) * complex(*way).conjugate()).real))
        far = np.where(abs(gap) < _LONGEST_GAP * far, far - gap, far)
    return np.where(np.isnan(far), length, far)


def _fitting(
    sets: Sequence[pandas.DataFrame], loop: CollectionLoop, left_out: Counter[str]
) -> list[pandas.DataFrame]:
    """The sets of the loop's surface and of objects whose outline is known; the others are counted
    by name.
    """
    surfaces = {_facts(rows)["surface"] for rows in sets} - {None}
    words = {loop.material.name, re.split(r"[-_ ]", loop.material.name)[0]}
    own = words & (surfaces | {*material_names()} - {"isotropic"})
    if len(surfaces) > 1 and not own:
        listed = ", ".join(sorted(surfaces))
        raise InvalidInput(
            f"the data are of several surfaces ({listed}), and the material {loop.material.name!r} "
            "names none of them: select one, surface=NAME"
        )
    fitting = []
    for rows in sets:
        facts = _facts(rows)
        if own and facts["surface"] not in (None, *own):
            left_out[f"on {facts['surface']}, not {min(own, key=len)}"] += len(rows)
        elif facts["object"] not in (None, file_stem(loop.slider.name), *MIT_SHAPE_NAMES):
            left_out[_NO_OUTLINE] += len(rows)
        else:
            fitting.append(rows)
    return fitting


def _at_contacts(
    sets: Sequence[pandas.DataFrame], loop: CollectionLoop, left_out: Counter[str]
) -> tuple[list[pandas.DataFrame], tuple[str, ...]]:
    """The sets, those whose contacts the rod's places tell by these; and in words which they are
    where the protocol has another one.
    """
    placed: list[pandas.DataFrame] = []
    by_rod: list[pandas.DataFrame] = []
    for rows in sets:
        own = by_contact(rows, loop_of_plate(loop, _facts(rows)["object"]), left_out)
        placed += own
        by_rod += [contact for contact in own if contact is not rows]
    return placed, contact_words(by_rod, loop.push)


def _posed_sets(
    sets: Sequence[pandas.DataFrame], loop: CollectionLoop, length: float, left_out: Counter[str]
) -> list[PosedSet]:
    """The sets with end poses whose pushes are as long as is known, each with the pushes that the
    data tell.
    """
    loops = {name: loop_of_plate(loop, name) for name in {_facts(rows)["object"] for rows in sets}}
    posed_sets = []
    for rows in sets:
        facts = _facts(rows)
        own = loops[facts["object"]]
        posed = rows[["dtheta", "dx"]].notna().all(axis=1).to_numpy()
        far = _lengths(rows, length, own)
        kept = posed & np.isfinite(far)
        left_out[_NO_POSES] += int(np.sum(~posed))
        left_out[NO_LENGTH] += int(np.sum(posed & ~kept))
        if kept.any():
            push = tuple(told_push(loop.push, facts, distance) for distance in far[kept].tolist())
            columns = rows[["theta0", "dtheta", "dx", "dy"]].to_numpy()[kept]
            posed_sets.append(PosedSet(facts, own, push, columns[:, 0], columns[:, 1:]))
    return posed_sets


def _cycles(
    sets: Sequence[pandas.DataFrame],
    loop: CollectionLoop | None,
    length: float,
    left_out: Counter[str],
) -> tuple[Theta0Pairs | None, CollectionLoop | None]:
    """The pairs of the set that has most cycles, and the loop that makes them."""
    counts = [int(rows["theta_next"].count()) for rows in sets]
    most = max(counts, default=0)
    if most < FEWEST_CYCLES:
        left_out[f"cycles, fewer than {FEWEST_CYCLES} of one set"] += sum(counts)
        return None, loop
    left_out[_OTHER_SET] += sum(counts) - most
    rows = sets[counts.index(most)]
    if loop is not None:
        loop = loop_of_plate(loop, _facts(rows)["object"])
        far = float(np.median(_lengths(rows, length, loop)))
        if math.isnan(far) and rows["dtheta"].notna().any():
            left_out[f"cycles: {NO_LENGTH}"] += most
            return None, loop
        loop = _pushing(loop, told_push(loop.push, _facts(rows), far))
    rows = rows.sort_values("number", kind="stable")
    columns = rows[["theta0", "theta_next", "number"]].to_numpy().T
    return _in_a_row(ordered_pairs(*columns), 0), loop


def _pushing(loop: CollectionLoop, push: SidePush) -> CollectionLoop:
    """The loop with a push, its own where that is the same but for the three decimals of a file's
    name and the robot's own errors.
    """
    own = loop.push
    near = is_near(own, push.side, push.fraction, push.angle)
    if near and abs(push.distance - own.distance) <= _SAME_LENGTH:
        return loop
    return replace(loop, push=push)
