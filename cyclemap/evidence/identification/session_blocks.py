"""The blocks of one session, made of rows of measured data, with what stays out told between them;
what each of several plates and sessions has of its own, and which sessions are odd.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import cycle
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from cyclemap.arrays import Array, Place, evenly_spread
from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence.identification.data_block import DataBlock, Labels, session_block
from cyclemap.evidence.identification.force_blocks import (
    SCAN_FIELDS,
    force_ratio_block,
    friction_scan_block,
    read_wrench_twists,
    scan_traction,
    sliding_forces,
    wrench_twist_block,
)
from cyclemap.evidence.identification.stroke_block import (
    TIP_OFFSET,
    cycle_pair_block,
    drag_turn_block,
    push_end_block,
    surface_model,
)
from cyclemap.evidence.identification.surface_parameters import (
    FLOOR_NAMES,
    PLATE_NAMES,
    SURFACE,
    SurfaceParameters,
)
from cyclemap.evidence.laws.push_sets import PushSet, push_sets
from cyclemap.evidence.predicted_strokes import (
    by_contact,
    loop_of_plate,
    predicted_push_ends,
    push_from_contact,
)
from cyclemap.evidence.pushes.measured_strokes import (
    LARGEST_TIP_ERROR,
    NO_LENGTH,
    READ,
    ROD_OFF,
    MeasuredPush,
    ReadErrors,
    measured_drags,
    measured_pushes,
    push_noise,
    set_up_errors,
    told,
    told_push,
)
from cyclemap.evidence.pushes.push_files import read_push_file
from cyclemap.evidence.pushes.push_table import PushTable
from cyclemap.evidence.pushes.recordings import PushRecord, as_ours
from cyclemap.evidence.tables.columns import DRAG_ENDS, FRAMES_AGREE, READ_ERRORS, convention_of
from cyclemap.mechanics import Pose
from cyclemap.progress import Progress, part_of

if TYPE_CHECKING:
    import pandas

T = TypeVar("T")

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
# What belongs to a plate, or to the frame that its data are in, and what to a session.
PLATE_OWNED = (*SURFACE.select(PLATE_NAMES).parameters, *TIP_OFFSET)
SESSION_OWNED = SURFACE.select(FLOOR_NAMES).parameters
# A session whose robot was this far from where it was sent (m), and so many times further than in
# others, is odd.
_ASTRAY = 5e-4
_TIMES = 3.0
# So is one in which a plate turns by this share less or more than in another, and by so many
# standard errors; so many pushes, at least, tell.
_TURNS_APART = 0.15
_TURN_ERRORS = 4.0
_FEWEST_TURNS = 20


@dataclass(frozen=True)
class Wanted:
    """What is wanted of data, as `collected_blocks` was asked."""

    first: int
    wear: bool
    most: int
    push_length: float
    target: Place | None


@dataclass(frozen=True, eq=False)
class SessionBlock:
    """A block of data, of which plate it is, and in which session; empty where nothing tells.

    words : what it holds.
    read : how far readings are off, m and rad; None where that is not told.
    pushes : of the block, some of them.
    strayed : how far the robot was from where it was sent, m, on average; None where that is not
        known.
    scans : tractions of friction scans, (n, 2).
    last_cycle : how many the last cycle is behind the first.
    """

    block: DataBlock
    words: str
    read: ReadErrors | None = None
    pushes: Sequence[MeasuredPush] = ()
    strayed: float | None = None
    scans: Array | None = None
    last_cycle: float = 0.0
    plate: str = ""
    session: str = ""

    @property
    def set_up(self) -> dict[str, tuple[float, float]]:
        """What is believed of how each push was set up by hand, by name: 0 and a deviation."""
        unknown = (row.name for row in self.block.own_parameters if row.name.startswith(ROD_OFF))
        errors = cycle(set_up_errors(self.read or READ).tolist())
        return {name: (0.0, error) for name, error in zip(unknown, errors, strict=False)}

    @property
    def noise(self) -> dict[str, float]:
        """How far measurements are off, by kind of noise; infinite where that is not told.

        Of pushes that a robot made the angle before them is noise, too.
        """
        kinds = set(self.block.kinds.tolist())
        if self.read is None:
            return dict.fromkeys(kinds, math.inf)
        along, _, turned, dragged = push_noise(self.read).tolist()
        if not self.set_up:
            turned = math.hypot(turned, self.read[1])
        sizes = {"push place (m)": along, "push turn (rad)": turned, "drag turn (rad)": dragged}
        return {kind: sizes[kind] for kind in kinds}


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


def table_cycle_blocks(rows: pandas.DataFrame, loop: CollectionLoop, wanted: Wanted) -> Taken:
    """Give the cycles of a CSV table that tells the places of the rod, and of each push, as
    `PushTable.table` does, the start of the next.

    None where drag-backs are told as well, which are the other half of these cycles, nor of pushes
    that were set up by marks.
    """
    others = rows[[*DRAG_ENDS]].notna().all(axis=1) | rows[FRAMES_AGREE].notna()
    if others.any() or rows["theta_next"].isna().all():
        return
    reasons = Counter[str]()
    for contact in by_contact(rows, loop, reasons):
        own = replace(loop, push=told_push(loop.push, contact.iloc[0], math.nan))
        if contact is not rows:
            far = float(contact["length"].median())
            own = replace(own, push=replace(own.push, distance=far))
        for alike in push_sets(PushTable(contact, contact[:0], ())):
            yield from _cycle_blocks(alike, own, wanted)
    for reason, count in reasons.items():
        yield from left_out(f"cycles: {reason}", count)


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
    late = _late(table, wanted)
    posed = late[["x0", "dtheta"]].notna().all(axis=1)
    rows = late[posed].fillna({"length": wanted.push_length})
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
    late = _late(table, wanted)
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
    if count == 1:
        words = (
            f"{pieces} force ratios while the rod slides in one push: errors that they share are not "
            "told, and the interval of pusher_friction is too narrow by them"
        )
    yield SessionBlock(force_ratio_block(sliding), words)


def push_end_blocks(
    rows: pandas.DataFrame, loop: CollectionLoop, wanted: Wanted, first_set: int
) -> Taken:
    """Give the ends of pushes of a CSV table that tells the places of the rod.

    first_set : the number of the first that was set up by marks.
    """
    late = _late(rows, wanted)
    yield from left_out(f"pushes before {wanted.first}", len(rows) - len(late))
    if late.empty:
        return
    pushes = measured_pushes(late)
    errors = late["tip_error"].fillna(0.0)
    small = errors[errors <= LARGEST_TIP_ERROR]
    strayed = float(small.mean()) if len(small) else 0.0
    yield from left_out("the tip was not where it was sent", len(late) - len(pushes))
    by_marks = first_set if late[FRAMES_AGREE].notna().any() else None
    places = [push.contact for push in pushes]
    alone = np.arange(len(pushes))
    read = _read_errors(late)
    yield from _end_blocks(pushes, places, alone, loop, wanted, read, by_marks, strayed)


def _end_blocks(
    pushes: Sequence[MeasuredPush],
    places: Sequence[Place] | Sequence[int],
    otherwise: Labels,
    loop: CollectionLoop,
    wanted: Wanted,
    read: ReadErrors | None = None,
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
    late = _late(rows, wanted)
    yield from left_out(f"drag-backs before {wanted.first}", len(rows) - len(late))
    drags = measured_drags(late)
    kept = _thinned(drags, wanted.most)
    if kept:
        block = drag_turn_block(kept, loop.slider, wanted.target)
        yield SessionBlock(block, f"{_counted(kept, drags)} drag-backs", _read_errors(late))


def _late(rows: pandas.DataFrame, wanted: Wanted) -> pandas.DataFrame:
    """The rows but those that are numbered too early."""
    return rows[~(rows["repetition"] < wanted.first)]


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


def _read_errors(rows: pandas.DataFrame) -> ReadErrors | None:
    """How far readings are off, m and rad, where a table tells it."""
    length, angle = rows[[*READ_ERRORS]].max().tolist()
    return None if math.isnan(length + angle) else (length, angle)


def _runs(count: int) -> Labels:
    """Labels of rows that follow each other."""
    return np.arange(count) // min(max(count // _FEWEST_GROUPS, 1), _LONGEST_GROUP)


def _thinned(rows: Sequence[T], most: int) -> list[T]:
    """At most so many of the rows, evenly spread."""
    return [rows[place] for place in evenly_spread(len(rows), most)]


def _counted(kept: Sequence[object], rows: Sequence[object]) -> str:
    return str(len(kept)) if len(kept) == len(rows) else f"{len(kept)} of {len(rows)}"


def named_blocks(
    known: Sequence[SessionBlock], odd: Sequence[str], population: bool
) -> tuple[DataBlock, ...]:
    """Return the blocks, those of several plates or sessions with unknowns of their own, and how
    sessions differ.

    odd : sessions that do not count to the floor's mean.
    population : whether one session is taken as one of several. Equal names get a number behind.
    """
    # What tells no speed belongs to the first session of its plate that does.
    first: dict[str, str] = {}
    for row in known:
        if row.session:
            first.setdefault(row.plate, row.session)
    owners = [row.session or first.get(row.plate, row.plate) for row in known]
    owned = [*zip(owners, known, strict=True)]
    telling = (owner for owner, row in owned if {*FLOOR_NAMES} & {*row.block.parameters})
    sessions = list(dict.fromkeys(telling))
    has_sessions = len(sessions) > 1 or (population and bool(sessions))
    has_plates = len({row.plate for row in known}) > 1
    blocks = []
    for owner, row in owned:
        block = row.block
        whose = ""
        if has_plates:
            block = block.of_owner(row.plate, PLATE_OWNED)
            whose = row.plate
        if has_sessions:
            block = block.of_owner(owner, SESSION_OWNED)
            whose = owner
        blocks.append(replace(block, name=f"{whose} {block.name}".strip()))
    if has_sessions:
        blocks.append(session_block(sessions, odd))
    names = [block.name for block in blocks]
    for index, name in enumerate(names):
        if names.count(name) > 1:
            place = names[: index + 1].count(name)
            blocks[index] = replace(blocks[index], name=f"{name} {place}")
    return tuple(blocks)


def odd_sessions(
    loop: CollectionLoop, known: Sequence[SessionBlock]
) -> tuple[dict[str, str], dict[str, str]]:
    """Return sessions whose robot strayed, or whose plate turned, unlike in the others, each with
    the reason; and those of which nothing tells whether they or another one is odd.

    Of two sessions that turn a plate unlike the odd one is that whose robot strayed more.
    """
    tip_errors = {row.session: row.strayed for row in known if row.strayed is not None}
    pushes: dict[str, dict[str, Sequence[MeasuredPush]]] = {}
    for row in known:
        if len(row.pushes) >= _FEWEST_TURNS:
            pushes.setdefault(row.plate, {}).setdefault(row.session, row.pushes)
    usual = float(np.median([*tip_errors.values()])) if tip_errors else 0.0
    odd = dict[str, str]()
    doubtful = dict[str, str]()
    for session, size in tip_errors.items():
        if size > max(_ASTRAY, _TIMES * usual):
            odd[session] = (
                f"the rod was {1e3 * size:.2g} mm from where it was sent on average, "
                f"{1e3 * usual:.2g} mm in others"
            )
    for plate, sessions in pushes.items():
        if len(sessions) < 2:
            continue
        own_loop = loop_of_plate(loop, plate)
        turns = {name: flat_turns(own, own_loop) for name, own in sessions.items()}
        for session, reason in _turned_unlike(turns).items():
            astray = tip_errors.get(session, 0.0)
            others = max(tip_errors.get(name, 0.0) for name in turns if name != session)
            if len(turns) > 2 or astray > others:
                odd[session] = reason
            elif astray == others:
                doubtful[session] = reason
    return odd, doubtful


def _turned_unlike(turns: Mapping[str, tuple[float, float]]) -> dict[str, str]:
    """The sessions of one plate that turned it unlike the median of all, of two the other one."""
    unlike = {}
    for session, (ratio, error) in turns.items():
        ranked = sorted(known for name, known in turns.items() if len(turns) > 2 or name != session)
        usual, its_error = ranked[(len(ranked) - 1) // 2]
        least = _TURN_ERRORS * math.hypot(error, its_error)
        if abs(ratio - usual) > max(_TURNS_APART * max(ratio, usual), least):
            unlike[session] = (
                f"its turns are {ratio:.2f} of isotropic friction's on a flat floor, "
                f"{usual:.2f} in others"
            )
    return unlike


def flat_turns(pushes: Sequence[MeasuredPush], loop: CollectionLoop) -> tuple[float, float]:
    """Return the mean size of turns over that of isotropic friction on a flat floor, and its
    standard error; loop : whose object was pushed, by whose rod.
    """
    model = surface_model(SurfaceParameters(), loop.slider, rod_radius=loop.pusher.radius)
    ends = predicted_push_ends(model, pushes)[0]
    before, after = np.array([(push.start.theta, push.end.theta) for push in pushes]).T
    predicted = np.abs(ends[:, 2] - before)
    measured = np.abs(after - before)
    mean = max(float(np.mean(predicted)), 1e-9)
    ratio = float(np.mean(measured)) / mean
    return ratio, float(np.std(measured - ratio * predicted)) / math.sqrt(len(pushes)) / mean
