"""From rows of measured data to blocks of one session; what stays out is told between them, in words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from cyclemap.arrays import Place, evenly_spread
from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence.identification.data_block import Labels
from cyclemap.evidence.identification.force_blocks import (
    SCAN_FIELDS,
    force_ratio_block,
    friction_scan_block,
    read_wrench_twists,
    scan_traction,
    sliding_forces,
    wrench_twist_block,
)
from cyclemap.evidence.identification.session_blocks import SessionBlock
from cyclemap.evidence.identification.stroke_block import (
    cycle_pair_block,
    drag_turn_block,
    push_end_block,
)
from cyclemap.evidence.laws.push_sets import PushSet, push_sets
from cyclemap.evidence.predicted_strokes import push_from_contact
from cyclemap.evidence.pushes.measured_strokes import (
    LARGEST_TIP_ERROR,
    NO_LENGTH,
    MeasuredPush,
    measured_drags,
    measured_pushes,
    told,
    told_push,
)
from cyclemap.evidence.pushes.push_files import read_push_file
from cyclemap.evidence.pushes.push_table import PushTable
from cyclemap.evidence.pushes.recordings import PushRecord, as_ours
from cyclemap.evidence.tables.conventions import convention_of
from cyclemap.evidence.tables.planned_table import FRAMES_AGREE
from cyclemap.mechanics import Pose
from cyclemap.progress import Progress, part_of

if TYPE_CHECKING:
    import pandas

T = TypeVar("T")

# How far off readings are.
ERRORS = ("read_error", "read_turn_error")
# Cycles that follow each other have errors alike: they form groups of this many, or smaller ones
# where data are few.
_LONGEST_GROUP = 25
_FEWEST_GROUPS = 20
# With pushes at fewer contacts than this each push is a group of its own.
_FEWEST_CONTACTS = 8
# Pushes of rods that were set by marks, at most: each has two unknowns of its own. Pushes of a
# session that are asked, at most, how far they turn.
_MOST_SET = 200
_MOST_TURNS = 200
# A push whose tip strays further from a straight line (m) is another experiment.
_STRAIGHT = 2e-3
# Pieces of sliding pushes, and cycles of a set, below which nothing can be told of their noise.
_FEWEST_PIECES = 3
_FEWEST_CYCLES = 5


@dataclass(frozen=True)
class Wanted:
    """What is wanted of data, as `collected_blocks` was asked."""

    first: int
    wear: bool
    most: int
    push_length: float
    target: Place | None


Taken = Iterator[str | SessionBlock]


def left_out(reason: str, count: int) -> list[str]:
    """Return how many rows stay out, and why, in words; nothing where none do."""
    return [f"{count} left out: {reason}"] if count > 0 else []


def push_blocks(
    pushes: PushTable, loop: CollectionLoop, wanted: Wanted, recorded: bool, progress: Progress
) -> Taken:
    """Give what pushes tell: of cycles where they were repeated, of their ends; recorded ones also
    of forces, and of friction scans.
    """
    yield from _scan_blocks(pushes.scans, loop)
    for rows in push_sets(pushes) if len(pushes.table) else ():
        yield from _cycle_blocks(rows, loop, wanted)
    if recorded:
        yield from _recorded_blocks(pushes.table, loop, wanted, progress)
    else:
        yield from _posed_blocks(pushes.table, loop, wanted)


def _scan_blocks(scans: pandas.DataFrame, loop: CollectionLoop) -> Taken:
    known = scans[np.isfinite(scans[[*SCAN_FIELDS]].astype(float)).all(axis=1)]
    yield from left_out("friction scans without direction or force", len(scans) - len(known))
    if len(known):
        weight = loop.model.weight
        words = f"{len(known)} friction scans, weight {weight:.3g} N"
        traction = scan_traction(known, weight)
        yield SessionBlock(friction_scan_block(known, weight), words, scans=traction)


def _cycle_blocks(rows: PushSet, loop: CollectionLoop, wanted: Wanted) -> Taken:
    """Give the cycles of a set of pushes that were repeated at one contact."""
    pairs = rows.pairs
    if pairs is None or rows.contacts != 1:
        return
    late = pairs.numbers >= wanted.first
    count = int(np.sum(late))
    yield from left_out(f"cycles before {wanted.first}", late.size - count)
    for reason, dropped in pairs.dropped.items():
        yield from left_out(reason, dropped)
    if count < _FEWEST_CYCLES:
        yield f"{count} cycles of {rows.name} left out: too few"
        return
    place = {key: rows.facts[key] for key in ("side", "fraction", "angle") if key in rows.facts}
    pushed = replace(loop, push=replace(loop.push, **place))
    since = pairs.numbers[late] - wanted.first
    last = float(np.max(since))
    elapsed = since / last if wanted.wear else None
    groups = _runs(count)
    block = cycle_pair_block(pushed, pairs.theta[late], pairs.turn[late], groups, elapsed)
    words = f"{count} cycles of {rows.name}" + ", wearing" * wanted.wear
    yield SessionBlock(block, words, last_cycle=last)


def _posed_blocks(table: pandas.DataFrame, loop: CollectionLoop, wanted: Wanted) -> Taken:
    """Give ends of pushes without the places of the rod: it went from its first touch on as the
    loop's does.
    """
    posed = table[["x0", "dtheta"]].notna().all(axis=1) & ~(table["repetition"] < wanted.first)
    rows = table[posed].fillna({"length": wanted.push_length})
    known = rows[rows["length"].notna()]
    yield from left_out(f"ends of pushes: {NO_LENGTH}", len(rows) - len(known))
    pushes: list[MeasuredPush] = []
    places: list[Place] = []
    for row in known.to_dict("records"):
        push = told_push(loop.push, row, row["length"])
        start = Pose(row["x0"], row["y0"], row["theta0"])
        end = Pose(row["x1"], row["y1"], row["theta1"])
        pushes.append(push_from_contact(loop.slider, loop.pusher.radius, push, start, end))
        places.append((push.side, push.fraction))
    yield from _end_blocks(pushes, places, _runs(len(pushes)), loop, wanted)


def _recorded_blocks(
    table: pandas.DataFrame, loop: CollectionLoop, wanted: Wanted, progress: Progress
) -> Taken:
    """Give ends and forces of recorded pushes."""
    late = table[~(table["repetition"] < wanted.first)]
    steady = late[late["acceleration"].fillna(0.0) == 0.0]
    yield from left_out("pushed with acceleration", len(late) - len(steady))
    chosen = steady.iloc[evenly_spread(len(steady), wanted.most)]
    if len(chosen) < len(steady):
        yield f"every {len(steady) / len(chosen):.3g}th of {len(steady)} pushes taken"
    places: list[Place] = []
    pushes: list[MeasuredPush] = []
    records: list[PushRecord] = []
    for index, row in enumerate(chosen.to_dict("records")):
        record = as_ours(read_push_file(row["path"]), convention_of(row["path"]))
        assert isinstance(record, PushRecord)
        push = _straight_push(record)
        if push is not None:
            pushes.append(push)
            places.append((row["side"], row["fraction"]))
            records.append(record)
        part_of(progress, index, len(chosen))(1.0)
    yield from left_out("pushes whose tip did not go straight", len(chosen) - len(records))
    if records:
        yield from _end_blocks(pushes, places, _runs(len(pushes)), loop, wanted)
        yield from _force_blocks(records, loop)


def _straight_push(record: PushRecord) -> MeasuredPush | None:
    """The push of a record whose tip went straight; None of another one."""
    tip = record.tip_pose[:, 1:3]
    way = tip[-1] - tip[0]
    length = float(np.hypot(*way))
    # How far the tip strays from the straight line between its ends, times its length.
    beside = np.abs((tip - tip[0]) @ [-way[1], way[0]])
    if length <= _STRAIGHT or np.max(beside) > _STRAIGHT * length:
        return None
    first, last = (tuple(place) for place in tip[[0, -1]].tolist())
    return MeasuredPush(Pose(*record.start), Pose(*record.end), first, last)


def _force_blocks(records: Sequence[PushRecord], loop: CollectionLoop) -> Taken:
    outline = loop.slider.outline_points(360)
    sliding = sliding_forces([(record, outline) for record in records], loop.pusher.radius)
    pieces = sliding.ratio.size
    if pieces < _FEWEST_PIECES:
        yield f"forces not used: the rod slides in {pieces} pieces of pushes"
        return
    count = len(np.unique(sliding.push))
    words = f"{pieces} force ratios while the rod slides, in {count} pushes"
    yield SessionBlock(force_ratio_block(sliding), words)


def push_end_blocks(
    rows: pandas.DataFrame, loop: CollectionLoop, wanted: Wanted, first_set: int
) -> Taken:
    """Give the ends of pushes of a CSV table that tells the places of the rod.

    first_set : the number of the first that was set up by marks.
    """
    pushes = measured_pushes(rows)
    errors = rows["tip_error"].fillna(0.0)
    small = errors[errors <= LARGEST_TIP_ERROR]
    strayed = float(small.mean()) if len(small) else 0.0
    yield from left_out("the tip was not where it was sent", len(rows) - len(pushes))
    number = first_set if rows[FRAMES_AGREE].notna().any() else None
    places = [push.contact for push in pushes]
    alone = np.arange(len(pushes))
    read = _read_errors(rows)
    yield from _end_blocks(pushes, places, alone, loop, wanted, read, number, strayed)


def _end_blocks(
    pushes: Sequence[MeasuredPush],
    places: Sequence[Place] | Sequence[int],
    otherwise: Labels,
    loop: CollectionLoop,
    wanted: Wanted,
    read: tuple[float, float] | None = None,
    first_set: int | None = None,
    strayed: float | None = None,
) -> Taken:
    """Give the ends of pushes, grouped by their places of contact where there are many such, else
    as it is said `otherwise`; where they are too few for that, it is told.
    """
    contacts = len({*places})
    if contacts < min(_FEWEST_CONTACTS, len(pushes)):
        yield (
            f"{len(pushes)} pushes at {contacts} contact{'s' * (contacts > 1)} alone: what the "
            "model misses at a contact counts as evidence of every push there, so that intervals "
            "are too narrow"
        )
    labels = otherwise
    if contacts >= _FEWEST_CONTACTS and not np.isnan(places).any():
        labels = np.unique(places, axis=0, return_inverse=True)[1].reshape(-1)
    grouped = []
    for push, label in zip(pushes, labels.tolist(), strict=True):
        grouped.append(replace(push, contact=label))
    most = wanted.most if first_set is None else min(wanted.most, _MOST_SET)
    kept = _thinned(grouped, most)
    if kept:
        radius = loop.pusher.radius
        block = push_end_block(kept, loop.slider, wanted.target, first_set, radius)
        words = f"{_counted(kept, pushes)} push ends"
        yield SessionBlock(block, words, read, _thinned(grouped, _MOST_TURNS), strayed)


def drag_blocks(rows: pandas.DataFrame, loop: CollectionLoop, wanted: Wanted) -> Taken:
    """Give the drag-backs of a CSV table."""
    drags = measured_drags(rows)
    kept = _thinned(drags, wanted.most)
    block = drag_turn_block(kept, loop.slider, wanted.target)
    yield SessionBlock(block, f"{_counted(kept, drags)} drag-backs", _read_errors(rows))


def wrench_blocks(rows: pandas.DataFrame, loop: CollectionLoop) -> Taken:
    """Give the pairs of wrench and twist of a CSV table."""
    extent = loop.slider.outline.extent
    data = read_wrench_twists(rows, extent)
    words = (
        f"{len(data.twist)} pairs of wrench and twist, torque and turning rate scaled by "
        f"{1e3 * extent:.2f} mm"
    )
    yield SessionBlock(wrench_twist_block(data, loop.slider), words)
    sources = told(rows["source"])
    if len(sources) > 1:
        listed = ", ".join(sorted(sources))
        yield f"pairs are of several sources ({listed}): what stands in two counts twice"


def _read_errors(rows: pandas.DataFrame) -> tuple[float, float] | None:
    """How far readings are off, m and rad, where a table tells it."""
    length, angle = rows[[*ERRORS]].max().tolist()
    return None if math.isnan(length + angle) else (length, angle)


def _runs(count: int) -> Labels:
    """Labels of rows that follow each other."""
    return np.arange(count) // min(max(count // _FEWEST_GROUPS, 1), _LONGEST_GROUP)


def _thinned(rows: Sequence[T], most: int) -> list[T]:
    """At most so many of the rows, evenly spread."""
    return [rows[place] for place in evenly_spread(len(rows), most)]


def _counted(kept: Sequence[object], rows: Sequence[object]) -> str:
    return str(len(kept)) if len(kept) == len(rows) else f"{len(kept)} of {len(rows)}"
