"""From files of measured data to the blocks that an identification takes, and a note on everything
left out.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from cyclemap.arrays import Array, Place, evenly_spread
from cyclemap.checks import whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import ConvergenceError, DataFileError, InvalidInput
from cyclemap.evidence.identification.data_block import DataBlock, Labels, usual_beliefs
from cyclemap.evidence.identification.force_blocks import (
    SCAN_FIELDS,
    force_ratio_block,
    friction_scan_block,
    read_wrench_twists,
    scan_traction,
    sliding_forces,
    wrench_twist_block,
)
from cyclemap.evidence.identification.identify import Identification, identify
from cyclemap.evidence.identification.known_floor import (
    FLOOR_TOLD,
    held_values,
    known_beliefs,
    known_spread,
)
from cyclemap.evidence.identification.session_blocks import (
    PLATE_OWNED,
    SESSION_OWNED,
    SessionBlock,
    named_blocks,
    odd_sessions,
)
from cyclemap.evidence.identification.stroke_block import (
    cycle_pair_block,
    drag_turn_block,
    push_end_block,
    set_ups,
)
from cyclemap.evidence.identification.surface_parameters import (
    FIELD_NAMES,
    SURFACE,
    ParameterSpace,
)
from cyclemap.evidence.laws.push_sets import PushSet, push_sets
from cyclemap.evidence.motion_check import check_pushes
from cyclemap.evidence.predicted_strokes import loop_of_plate, push_from_contact
from cyclemap.evidence.pushes.measured_strokes import (
    LARGEST_TIP_ERROR,
    NO_LENGTH,
    READ,
    ROD_OFF,
    MeasuredPush,
    RowSelection,
    measured_drags,
    measured_pushes,
    push_noise,
    pushes_of,
    select_pushes,
    selected,
    session_name,
    set_up_errors,
    told,
    told_push,
)
from cyclemap.evidence.pushes.push_files import read_push_file
from cyclemap.evidence.pushes.push_table import PushTable, UnreadableFile, table_pushes
from cyclemap.evidence.pushes.recordings import PushRecord, as_ours
from cyclemap.evidence.tables.columns import ENDS, RODS, Selection, known_columns
from cyclemap.evidence.tables.conventions import convention_of
from cyclemap.evidence.tables.data_kinds import (
    CYCLES,
    DRAG_BACKS,
    PUSH_ENDS,
    RECORDS,
    SORT_COLUMNS,
    WRENCHES,
    DataFile,
    files_of_data,
    recognise,
)
from cyclemap.evidence.tables.planned_table import FRAMES_AGREE
from cyclemap.mechanics import MIT_SHAPE_NAMES, Material, Pose
from cyclemap.progress import Progress, part_of
from cyclemap.protocol.settings import OWN_OUTLINE
from cyclemap.text_files import file_stem

if TYPE_CHECKING:
    import pandas

T = TypeVar("T")

MOST_STROKES = 2000
# How far off readings are.
ERRORS = ("read_error", "read_turn_error")
LAYOUTS = (
    "files of the MIT layout (.h5, .json), or a CSV table with the columns of poses "
    "(x0,y0,th0,x1,y1,th1), better with the tip (tip_x0,tip_y0,tip_x1,tip_y1), of drag-backs "
    "(x1,y1,th1,x0n,y0n,th0n), of orientations (theta0_deg), or of wrenches and twists "
    "(fx,fy,m_over_rho,vx,vy,w_times_rho)"
)

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
# So many sessions tell how the floor's shape varies with the place.
_SESSIONS_OF_A_FIELD = 4
# A push whose tip strays further from a straight line (m) is another experiment.
_STRAIGHT = 2e-3
# Pieces of sliding pushes, and cycles of a set, below which nothing can be told of their noise.
_FEWEST_PIECES = 3
_FEWEST_CYCLES = 5
# Files of which the same is told are named one by one up to so many.
_MOST_NAMED = 3


def joined_notes(notes: Iterable[tuple[str, str]]) -> tuple[str, ...]:
    """Return notes in words, each of a file or session and what is told of it; of many of which the
    same is told the first is named, the others are counted.

    >>> joined_notes([(f"scan{index}.h5", "1 friction scans") for index in range(144)])
    ('scan0.h5 and 143 more like it: 1 friction scans',)
    """
    alike: dict[str, list[str]] = {}
    for about, words in notes:
        alike.setdefault(words, []).append(about)
    joined = list[str]()
    for words, names in alike.items():
        if len(names) > _MOST_NAMED:
            names = [f"{names[0]} and {len(names) - 1} more like it"]
        joined += [f"{name}: {words}" for name in names]
    return tuple(joined)


@dataclass(eq=False)
class _Collected:
    """Blocks of data and notes on what they hold and what stays out, file by file and plate by
    plate.

    given, first, wear, most, push_length, target : see `collected_blocks`. path, plate,
        session, loop : of what is being read. filled : filled-in pushes by their numbers, and where
        each was read. set_up : see `CollectedBlocks`. noise : of each kind; infinite where some
        data do not tell it. surfaces, objects : that the data tell of.
    """

    given: CollectionLoop
    first: int
    wear: bool
    most: int
    push_length: float
    target: Place | None
    path: Path = Path()
    plate: str = ""
    session: str = ""
    loop: CollectionLoop = field(init=False)
    known_sessions: dict[tuple[str, str], Path] = field(default_factory=dict)
    blocks: list[SessionBlock] = field(default_factory=list)
    filled: dict[tuple[float, ...], str] = field(default_factory=dict)
    set_up: dict[str, tuple[float, float]] = field(default_factory=dict)
    notes: list[tuple[str, str]] = field(default_factory=list)
    scans: list[Array] = field(default_factory=list)
    last_cycle: float = 0.0
    noise: dict[str, float] = field(default_factory=dict)
    surfaces: set[str] = field(default_factory=set)
    objects: set[str] = field(default_factory=set)

    def add_files(
        self, files: Sequence[Path], selection: RowSelection, progress: Progress | None
    ) -> list[UnreadableFile]:
        """Add the blocks of all sorts of data in files; return the files of no use."""
        unused = list[UnreadableFile]()
        for index, file in enumerate(files):
            try:
                known = recognise(file)
            except DataFileError as error:
                reason = str(error).removeprefix(f"{file}").lstrip(":, ")
                unused.append(UnreadableFile(file, reason))
            else:
                for data in known:
                    self._add_file(data, selection, part_of(progress, index, len(files)))
        return unused

    def _add_file(self, file: DataFile, selection: RowSelection, progress: Progress) -> None:
        """Add the blocks of one sort of data in a file."""
        self.path, sort = file.path, file.sort
        pushes = None
        if sort in SORT_COLUMNS:
            assert file.table is not None
            every = known_columns(file.table, SORT_COLUMNS[sort])
            rows, left_out = selected(convention_of(file.path).rows(every), selection)
            frames = [rows]
        else:
            pushes, left_out = self._pushes_of(file, selection, part_of(progress, 0, 2))
            frames = [pushes.table, pushes.scans]
        for reason, count in left_out.items():
            self._leave_out(reason, count)
        self._check(file, pushes)
        surfaces = frozenset[str]().union(*(told(frame["surface"]) for frame in frames))
        self.surfaces |= surfaces
        self.objects |= frozenset[str]().union(*(told(frame["object"]) for frame in frames))
        owners = [_plates_and_speeds(frame, self.given.slider.name) for frame in frames]
        sessions = [] if len(surfaces) > 1 else sorted({*chain(*owners)})
        for index, session in enumerate(sessions):
            self.plate, speed = session
            self.loop = loop_of_plate(self.given, self.plate)
            self.session = self._session(sort, speed)
            own = []
            for frame, of_rows in zip(frames, owners, strict=True):
                kept = [of_row == session for of_row in of_rows]
                own.append(frame[np.array(kept, dtype=bool)].reset_index(drop=True))
            if pushes is None:
                self._add_table(sort, own[0])
            else:
                done = part_of(part_of(progress, 1, 2), index, len(sessions))
                self._add_pushes(replace(pushes, table=own[0], scans=own[1]), sort, done)

    def _pushes_of(
        self, file: DataFile, selection: RowSelection, progress: Progress
    ) -> tuple[PushTable, Counter[str]]:
        """The pushes of a file that take part, and how many stay out, by reason."""
        if file.table is None:
            pushes, left_out = select_pushes(file.path, selection, False, progress)
        else:
            left_out = Counter[str]()
            whole = table_pushes(file.table)
            kept = pushes_of(whole, selection, left_out)
            pushes = replace(kept, unreadable=whole.unreadable)
        if pushes.unreadable:
            bad = pushes.unreadable[0]
            reason = f"unreadable, the first {bad.path.name}: {bad.reason}"
            self._leave_out(reason, len(pushes.unreadable))
        return pushes, left_out

    def _check(self, file: DataFile, pushes: PushTable | None) -> None:
        """Note how pushes were read, and how well their motions bear that out."""
        if file.sort in (DRAG_BACKS, WRENCHES):
            return
        if pushes is None:
            assert file.table is not None
            pushes = table_pushes(file.table)
        # A table that was planned tells its axes and angles.
        by_marks = file.table is not None and FRAMES_AGREE in file.table.header
        for words in check_pushes(pushes, self.given):
            if not by_marks:
                self._note(words)

    def _session(self, sort: str, speed: float) -> str:
        """The name of a session: its plate and speed, of orientations alone its file; empty where
        nothing tells.
        """
        if math.isinf(speed):
            if sort != CYCLES:
                return ""
            speed = math.nan
        session = session_name(self.plate, speed, self.path.stem)
        if self.known_sessions.setdefault((session, sort), self.path) != self.path:
            session += f", {self.path.stem}"
        return session

    def _note(self, words: str) -> None:
        self.notes.append((str(self.path), words))

    def _leave_out(self, reason: str, count: int) -> None:
        """Note how many rows of the file stay out, and why."""
        if count > 0:
            self._note(f"{count} left out: {reason}")

    def _doubt_few(self, contacts: int, count: int) -> None:
        """Note where pushes are at too few contacts to be grouped by them."""
        if contacts < min(_FEWEST_CONTACTS, count):
            self._note(
                f"{count} pushes at {contacts} contact{'s' * (contacts > 1)} alone: what the model "
                "misses at a contact counts as evidence of every push there, so that intervals are "
                "too narrow"
            )

    def _add(
        self,
        block: DataBlock,
        words: str,
        noise: Mapping[str, float] | None = None,
        pushes: Sequence[MeasuredPush] = (),
        strayed: float | None = None,
    ) -> None:
        """Add a block of the session, and a note of what it holds; noise : of its kinds, where the
        data tell it.

        pushes, strayed : see `SessionBlock`.
        """
        for kind in set(block.kinds.tolist()):
            size = math.inf if noise is None else noise[kind]
            self.noise[kind] = max(size, self.noise.get(kind, 0.0))
        self.blocks.append(SessionBlock(block, self.plate, self.session, pushes, strayed))
        self._note(f"{words} of {self.plate}")

    def _add_pushes(self, pushes: PushTable, sort: str, progress: Progress) -> None:
        """Add what pushes tell: of cycles where they were repeated, of their ends; in files of the
        MIT layout also of forces, and of friction scans.
        """
        if sort == RECORDS:
            self._add_scans(pushes.scans)
        for rows in push_sets(pushes) if len(pushes.table) else ():
            if rows.pairs is not None and rows.contacts == 1:
                self._add_cycles(rows)
        if sort == RECORDS:
            self._add_records(pushes.table, progress)
        else:
            self._add_posed(pushes.table)

    def _add_scans(self, scans: pandas.DataFrame) -> None:
        known = scans[np.isfinite(scans[[*SCAN_FIELDS]].astype(float)).all(axis=1)]
        without = len(scans) - len(known)
        self._leave_out("friction scans without direction or force", without)
        if len(known):
            weight = self.loop.model.weight
            self.scans.append(scan_traction(known, weight))
            words = f"{len(known)} friction scans, weight {weight:.3g} N"
            self._add(friction_scan_block(known, weight), words)

    def _add_cycles(self, rows: PushSet) -> None:
        """Add the cycles of a set of pushes that were repeated at one contact."""
        pairs = rows.pairs
        assert pairs is not None
        late = pairs.numbers >= self.first
        count = int(np.sum(late))
        self._leave_out(f"cycles before {self.first}", late.size - count)
        for reason, dropped in pairs.dropped.items():
            self._leave_out(reason, dropped)
        if count < _FEWEST_CYCLES:
            self._note(f"{count} cycles of {rows.name} left out: too few")
            return
        place = {key: rows.facts[key] for key in ("side", "fraction", "angle") if key in rows.facts}
        loop = replace(self.loop, push=replace(self.loop.push, **place))
        since = pairs.numbers[late] - self.first
        elapsed = since / np.max(since) if self.wear else None
        groups = _cycle_groups(count)
        block = cycle_pair_block(loop, pairs.theta[late], pairs.turn[late], groups, elapsed)
        self.last_cycle = max(self.last_cycle, float(np.max(since)))
        self._add(block, f"{count} cycles of {rows.name}" + (", wearing" if self.wear else ""))

    def _add_posed(self, table: pandas.DataFrame) -> None:
        """Add ends of pushes without the places of the rod: it went from its first touch on as the
        loop's does.
        """
        posed = table[["x0", "dtheta"]].notna().all(axis=1) & ~(table["repetition"] < self.first)
        rows = table[posed].fillna({"length": self.push_length})
        known = rows[rows["length"].notna()]
        pushes: list[MeasuredPush] = []
        places: list[tuple[float, float]] = []
        for row in known.to_dict("records"):
            push = told_push(self.loop.push, row, row["length"])
            start = Pose(row["x0"], row["y0"], row["theta0"])
            end = Pose(row["x1"], row["y1"], row["theta1"])
            radius = self.loop.pusher.radius
            pushes.append(push_from_contact(self.loop.slider, radius, push, start, end))
            places.append((push.side, push.fraction))
        self._leave_out(f"ends of pushes: {NO_LENGTH}", len(rows) - len(known))
        self._doubt_few(len({*places}), len(pushes))
        self._add_push_ends(_by_contact(pushes, places))

    def _add_records(self, table: pandas.DataFrame, progress: Progress) -> None:
        """Add ends and forces of recorded pushes."""
        late = table[~(table["repetition"] < self.first)]
        steady = late[late["acceleration"].fillna(0.0) == 0.0]
        self._leave_out("pushed with acceleration", len(late) - len(steady))
        rows = steady.to_dict("records")
        chosen = _thinned(rows, self.most)
        if len(chosen) < len(rows):
            self._note(f"every {len(rows) / len(chosen):.3g}th of {len(rows)} pushes taken")
        places: list[tuple[float, float]] = []
        pushes: list[MeasuredPush] = []
        records: list[PushRecord] = []
        for index, row in enumerate(chosen):
            record = as_ours(read_push_file(row["path"]), convention_of(row["path"]))
            assert isinstance(record, PushRecord)
            push = _straight_push(record)
            if push is not None:
                pushes.append(push)
                places.append((row["side"], row["fraction"]))
                records.append(record)
            part_of(progress, index, len(chosen))(1.0)
        self._leave_out("pushes whose tip did not go straight", len(chosen) - len(records))
        if records:
            self._doubt_few(len({*places}), len(pushes))
            self._add_push_ends(_by_contact(pushes, places))
            self._add_forces(records)

    def _add_forces(self, records: Sequence[PushRecord]) -> None:
        outline = self.loop.slider.outline_points(360)
        sliding = sliding_forces([(record, outline) for record in records], self.loop.pusher.radius)
        pieces = sliding.ratio.size
        count = len(np.unique(sliding.push))
        if pieces < _FEWEST_PIECES:
            self._note(f"forces not used: the rod slides in {pieces} pieces of pushes")
            return
        words = f"{pieces} force ratios while the rod slides, in {count} pushes"
        self._add(force_ratio_block(sliding), words)

    def _add_push_ends(
        self,
        pushes: Sequence[MeasuredPush],
        read: tuple[float, float] | None = None,
        set_by_marks: bool = False,
        strayed: float | None = None,
    ) -> None:
        kept = _thinned(pushes, min(self.most, _MOST_SET) if set_by_marks else self.most)
        if not kept:
            return
        first_set = None
        if set_by_marks:
            errors = set_up_errors(read or READ).tolist()
            first_set = len(self.set_up) // len(errors) + 1
            unknown = set_ups(first_set, len(kept))
            for parameter, error in zip(unknown, errors * len(kept), strict=True):
                self.set_up[parameter.name] = 0.0, error
        block = push_end_block(
            kept, self.loop.slider, self.target, first_set, self.loop.pusher.radius
        )
        words = f"{_counted(kept, pushes)} push ends"
        self._add(
            block, words, _told_noise(read, set_by_marks), _thinned(pushes, _MOST_TURNS), strayed
        )

    def _refuse_repeated(self, rows: pandas.DataFrame) -> None:
        """Refuse a filled-in push that was read before, which would count twice: ten readings never
        come again.
        """
        if rows[[FRAMES_AGREE, *ERRORS]].isna().all(axis=None):
            return
        for row in rows.to_dict("records"):
            readings = tuple(row[name] for name in (*ENDS, *RODS))
            here = f"{row['path']}, line {row['line']}"
            if readings in self.filled:
                raise DataFileError(
                    f"{here}: the push of {self.filled[readings]}, again, all readings the same, "
                    "would count twice: leave one of them out"
                )
            self.filled[readings] = here

    def _add_table(self, sort: str, rows: pandas.DataFrame) -> None:
        """Add what rows of a CSV table of push ends, drag-backs, or wrenches and twists tell."""
        if sort == PUSH_ENDS:
            self._refuse_repeated(rows)
            pushes = measured_pushes(rows)
            errors = rows["tip_error"].fillna(0.0)
            small = errors[errors <= LARGEST_TIP_ERROR]
            strayed = float(small.mean()) if len(small) else 0.0
            self._leave_out("the tip was not where it was sent", len(rows) - len(pushes))
            contacts = len({push.contact for push in pushes})
            self._doubt_few(contacts, len(pushes))
            if contacts < _FEWEST_CONTACTS:
                pushes = tuple(replace(push, contact=index) for index, push in enumerate(pushes))
            by_marks = bool(rows[FRAMES_AGREE].notna().any())
            self._add_push_ends(pushes, _told_errors(rows), by_marks, strayed)
        elif sort == DRAG_BACKS:
            drags = measured_drags(rows)
            kept = _thinned(drags, self.most)
            block = drag_turn_block(kept, self.loop.slider, self.target)
            noise = _told_noise(_told_errors(rows))
            self._add(block, f"{_counted(kept, drags)} drag-backs", noise)
        else:
            self._add_wrenches(rows)

    def _add_wrenches(self, rows: pandas.DataFrame) -> None:
        extent = self.loop.slider.outline.extent
        data = read_wrench_twists(rows, extent)
        words = (
            f"{len(data.twist)} pairs of wrench and twist, torque and turning rate scaled by "
            f"{1e3 * extent:.2f} mm"
        )
        self._add(wrench_twist_block(data, self.loop.slider), words)
        sources = told(rows["source"])
        if len(sources) > 1:
            listed = ", ".join(sorted(sources))
            self._note(f"pairs are of several sources ({listed}): what stands in two counts twice")

    def named(self, population: bool) -> tuple[DataBlock, ...]:
        """Return the blocks of all files, with notes on odd sessions; see `named_blocks`."""
        odd, open_ones = odd_sessions(self.given, self.blocks)
        for session, reason in open_ones.items():
            self.notes.append((session, f"{reason}; nothing tells which of the two is odd"))
        for session, reason in odd.items():
            words = f"an odd session, {reason}: it does not count to the floor's mean"
            self.notes.append((session, words))
        return named_blocks(self.blocks, [*odd], population)


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


def _by_contact(
    pushes: Sequence[MeasuredPush], places: Sequence[tuple[float, float]]
) -> list[MeasuredPush]:
    """Pushes labelled by side and fraction where there are many such places, else by runs of
    repetitions.
    """
    labels = _cycle_groups(len(places))
    if len({*places}) >= _FEWEST_CONTACTS and not np.isnan(places).any():
        labels = np.unique(places, axis=0, return_inverse=True)[1].reshape(-1)
    both = zip(pushes, labels.tolist(), strict=True)
    return [replace(push, contact=label) for push, label in both]


def _told_errors(rows: pandas.DataFrame) -> tuple[float, float] | None:
    """How far readings are off, m and rad, where a table tells it."""
    length, angle = rows[[*ERRORS]].max().tolist()
    return None if math.isnan(length) or math.isnan(angle) else (length, angle)


def _told_noise(
    read: tuple[float, float] | None, set_by_marks: bool = False
) -> dict[str, float] | None:
    """How far measured pushes and drags are off, by kind of noise, where it is told how far
    readings are; of pushes that a robot made the angle before them is noise, too.
    """
    if read is None:
        return None
    along, _, turned, dragged = push_noise(read).tolist()
    if not set_by_marks:
        turned = math.hypot(turned, read[1])
    return {"push place (m)": along, "push turn (rad)": turned, "drag turn (rad)": dragged}


def _plates_and_speeds(rows: pandas.DataFrame, plate: str) -> list[tuple[str, float]]:
    """The plate and the speed, m/s, of each row: the plate given where it names none, and no end of
    speed where it tells none.
    """
    speeds = rows["speed"].astype(float).fillna(math.inf).round(9)
    names = [name if isinstance(name, str) and name else plate for name in rows["object"]]
    return list(zip(names, speeds.tolist(), strict=True))


def _cycle_groups(count: int) -> Labels:
    return np.arange(count) // min(max(count // _FEWEST_GROUPS, 1), _LONGEST_GROUP)


def _thinned(rows: Sequence[T], most: int) -> list[T]:
    """At most so many of the rows, evenly spread."""
    return [rows[place] for place in evenly_spread(len(rows), most)]


def _counted(kept: Sequence[object], rows: Sequence[object]) -> str:
    return str(len(kept)) if len(kept) == len(rows) else f"{len(kept)} of {len(rows)}"


@dataclass(frozen=True, eq=False)
class CollectedBlocks:
    """Blocks of data of one surface, of one object or of several.

    Attributes
    ----------
    blocks : tuple of DataBlock
        Of unlike names; of several objects each is that of a plate, of several sessions each is
        that of one, and a last one tells how sessions may differ.
    notes : tuple of str
        What was recognised, what was left out and why, in words.
    surface : str or None
        Its name where the data tell it.
    loop : CollectionLoop
        With the data's object, where it is one.
    scans : ndarray, shape (n, 2), or None
        Tractions of friction scans.
    last_cycle : float
        How many the last is behind the first; 0 where unknown.
    noise : mapping of str to float
        Of the kinds of noise that all of their data tell.
    set_up : mapping of str to tuple[float, float]
        What is believed of how each push was set up by hand, by name: 0 and a deviation, SI units.
    """

    blocks: tuple[DataBlock, ...]
    notes: tuple[str, ...]
    surface: str | None
    loop: CollectionLoop
    scans: Array | None
    last_cycle: float
    noise: Mapping[str, float]
    set_up: Mapping[str, tuple[float, float]]

    def beliefs(self, names: Sequence[str]) -> dict[str, tuple[float, float]]:
        """Return what is usual of parameters (see `usual_beliefs`), and of how pushes were set
        up."""
        of_pushes = {name: self.set_up[name] for name in names if name in self.set_up}
        return usual_beliefs(names) | of_pushes


def collected_blocks(
    paths: Sequence[str | Path],
    loop: CollectionLoop,
    select: Selection | None = None,
    *,
    first: int = 0,
    wear: bool = False,
    most: int = MOST_STROKES,
    push_length: float | None = None,
    population: bool = False,
    target: Place | None = None,
    progress: Progress | None = None,
) -> CollectedBlocks:
    """Return the blocks of all data in files, folders and trees.

    Parameters
    ----------
    paths : sequence of str or Path
        Files of the MIT layout (friction scans; pushes: their ends, their forces, and cycles
        where they are repeated), CSV tables of push ends with the tip's places or without (then
        it went as the loop's does, from its first touch on), of drag-backs, of orientations, of
        wrenches and twists.
    loop : CollectionLoop
        Who is pushed where, with which rod and ring.
    select : mapping of str to str or float or None, optional
        Values of surface, object, speed, side, fraction, angle (SI, rad) to keep. Objects are
        all those of the MIT dataset that the data name, or the selected one; of an outline of
        the loop's own, that one alone.
    first : int, default 0
        The first cycle (repetition) used.
    wear : bool, default False
        Let the surface of the cycles wear.
    most : int, optional
        Strokes of one sort in a session, at most: beyond, every so many-th is taken.
    push_length : float or None, optional
        How far the rod of pushes went from its first touch, m, where tables of poses do not
        tell; None leaves the ends of such pushes out.
    population : bool, default False
        Whether the floor is known from other sessions, so that a single one is one of several.
    target : tuple[float, float] or None, optional
        (x, y), m, in the frame of the data, where resets end: how the floor's shape varies with
        the place about it is then an unknown of pushes and drags.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    CollectedBlocks
        The blocks, and what was made of each path.

    Raises
    ------
    InvalidInput
        Where nothing is recognised, naming what each path was, where the data are of several
        surfaces or of several objects of unknown outline, and for a number that does not fit.

    Notes
    -----
    What one file tells of one plate at one speed is a session, in which the floor has a shape
    of its own; drags count to the session of pushes of that plate and speed, and what tells no
    speed to the first session of its plate. A push of a repeated set tells its end and its
    cycle's end: their errors are taken as independent.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import numpy as np
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.evidence import collected_blocks
    >>> loop = CollectionLoop.mit("plywood")
    >>> theta = [0.0]
    >>> for cycle in range(30):
    ...     theta.append(float(loop.cycle(theta[-1]).theta_next) + 0.5)
    >>> with tempfile.TemporaryDirectory() as place:
    ...     text = "theta0_deg\\n" + "".join(f"{np.degrees(angle):.3f}\\n" for angle in theta)
    ...     count = Path(place, "mine.csv").write_text(text)
    ...     collected = collected_blocks([f"{place}/mine.csv"], loop)
    >>> [block.name for block in collected.blocks]
    ['cycles']
    """
    whole_number("first cycle", first, least=0)
    chosen = dict(select or {})
    if isinstance(chosen.get("object"), str):
        loop = loop_of_plate(loop, str(chosen["object"]))
    selection = RowSelection(_known_objects(loop, chosen), chosen)
    length = math.nan if push_length is None else push_length
    collected = _Collected(
        loop, first, wear, whole_number("most strokes", most, least=2), length, target
    )
    files = list(dict.fromkeys(file for path in paths for file in files_of_data(path)))
    unused = collected.add_files(files, selection, progress)
    surfaces, shapes = collected.surfaces, collected.objects
    if len(surfaces) > 1:
        listed = ", ".join(sorted(surfaces))
        raise InvalidInput(f"the data are of several surfaces: {listed}; select one, surface=NAME")
    if len(shapes) > 1 and loop.slider.name not in MIT_SHAPE_NAMES:
        listed = ", ".join(sorted(shapes))
        raise InvalidInput(f"the data are of several objects: {listed}; select one")
    if not collected.blocks:
        reasons = joined_notes([*collected.notes, *_told(unused)]) or tuple(map(str, paths))
        raise _nothing(reasons, loop, chosen, bool(unused))
    others = [(about, f"not used: {reason}") for about, reason in _told(unused)]
    blocks = collected.named(population)
    plates = {own.plate for own in collected.blocks}
    return CollectedBlocks(
        blocks,
        joined_notes([*collected.notes, *others]),
        next(iter(surfaces), None),
        loop if len(plates) > 1 else loop_of_plate(loop, *plates),
        np.concatenate(collected.scans) if collected.scans else None,
        collected.last_cycle,
        {kind: size for kind, size in collected.noise.items() if math.isfinite(size)},
        collected.set_up,
    )


def _told(files: Sequence[UnreadableFile]) -> list[tuple[str, str]]:
    return [(str(file.path), file.reason) for file in files]


def _nothing(
    notes: Sequence[str], loop: CollectionLoop, chosen: Selection, is_told: bool
) -> InvalidInput:
    """What is said where nothing is left of the data; is_told : whether the notes tell of files of
    no use.
    """
    listed = "; ".join(notes)
    facts = [f"{name}: {value}" for name, value in chosen.items() if name != "object"]
    if facts and not is_told:
        return InvalidInput(f"no such {', '.join(facts)}; {listed}")
    return InvalidInput(f"no data of {loop.slider.name} recognised: {listed}. Give {LAYOUTS}")


def _known_objects(loop: CollectionLoop, chosen: Selection) -> tuple[str, ...]:
    """The objects whose rows are kept; () where it is not told which is the loop's."""
    if isinstance(chosen.get("object"), str):
        return (str(chosen["object"]),)
    name = loop.slider.name
    if name in MIT_SHAPE_NAMES:
        return MIT_SHAPE_NAMES
    return () if name == OWN_OUTLINE else (file_stem(name),)


def telling_parameters(
    blocks: Sequence[DataBlock], believed: Collection[str] | None = None
) -> tuple[str, ...]:
    """Return the names of what blocks of data can usually tell, for a start: not what mostly trades
    off.

    The friction ellipse, its size only where scans or forces tell it; shapes of floor and plates,
    the rod, how each data set's frame is shifted, friction in the ring with cycles, how the surface
    wears; of four sessions and more, how the floor's shape varies with the place. believed : of a
    known floor, what its samples tell of ellipse and ring (`FLOOR_TOLD`); single pushes and drags
    take the rest of it as it stands, and drags the ring: they scatter by more than any ring
    explains, and would take that for friction in it.

    >>> ratios = DataBlock("ratios", ("pusher_friction",), lambda v: None, [0, 1], "ratio")
    >>> telling_parameters([ratios])
    ('pusher_friction',)
    """
    asked = {name for block in blocks for name in block.parameters}
    by_cycles = {name for block in blocks if block.curve for name in block.parameters}
    of_ellipse = by_cycles | {
        name for block in blocks if block.motions is None for name in block.parameters
    }
    by_motions = asked & {*SURFACE.names[1:5]} & {*(asked if believed is None else believed)}
    free = [name for name in SURFACE.names[:5] if name in of_ellipse | by_motions]
    owned = {row.name for row in (*PLATE_OWNED, *SESSION_OWNED)}
    beside = asked & {"pusher_friction", *by_cycles, *(believed or ())}
    free += [name for name in ("pusher_friction", "pin_friction_radius") if name in beside]
    free += sorted(name for name in asked if name.partition("[")[0] in owned)
    free += [name for block in blocks for name in block.parameters if name.startswith(ROD_OFF)]
    if len([name for name in asked if name.startswith("floor_dome[")]) >= _SESSIONS_OF_A_FIELD:
        free += [name for name in FIELD_NAMES if name in asked]
    return (*free, *sorted(name for name in asked if name.startswith(("worn_", "wear_pace_"))))


def identify_collected(
    collected: CollectedBlocks,
    known: Material | None,
    fixed: Mapping[str, float],
    space: ParameterSpace,
    *,
    free: Sequence[str] = (),
    believes: bool = True,
    folds: int = 0,
    starts: int = 2,
    student: float | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Identification:
    """Identify the parameters named, or else all that the data tell and is not fixed; raises
    ConvergenceError where no start converges.

    known : the floor whose samples are what is believed before. fixed : values that stay, but of
    parameters named. space : where the search begins. believes : whether usual beliefs and those of
    the known floor count; folds, starts, student, seed, progress : see `identify`.
    """
    blocks = collected.blocks
    by_floor = None if known is None else known_beliefs(known, FLOOR_TOLD)
    if not free:
        free = [name for name in telling_parameters(blocks, by_floor) if name not in fixed]
    beliefs = collected.beliefs(free) | known_beliefs(known, free, collected.loop.slider.name)
    held = {name: value for name, value in fixed.items() if name not in free}
    identified = identify(
        blocks,
        free,
        held_values(blocks, space, free, known) | held,
        priors=beliefs if believes else {},
        noise={**collected.noise, **known_spread(known, blocks)},
        folds=folds,
        starts=starts,
        student=student,
        seed=seed,
        space=space,
        progress=progress,
    )
    if not identified.fit.converged:
        raise ConvergenceError(
            f"no start converged: {identified.fit.message}; take more starts, or free fewer "
            "parameters"
        )
    return identified
