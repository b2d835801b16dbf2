"""From files of measured data to the blocks that an identification takes, and a note on everything
left out.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.data_blocks.force_blocks import (
    SCAN_FIELDS,
    TWIST_COLUMNS,
    WRENCH_COLUMNS,
    force_ratio_block,
    friction_scan_block,
    read_wrench_twists,
    scan_traction,
    sliding_forces,
    wrench_twist_block,
)
from cyclemap.evidence.data_blocks.stroke_block import (
    NODES,
    TIP_OFFSET,
    cycle_pair_block,
    drag_turn_block,
    predicted_push_ends,
    push_end_block,
    surface_model,
)
from cyclemap.evidence.identification.data_block import (
    DataBlock,
    Labels,
    Progress,
    part_of,
    session_block,
)
from cyclemap.evidence.identification.surface_parameters import (
    FIELD_NAMES,
    FLOOR_NAMES,
    PLATE_NAMES,
    SURFACE,
    SurfaceParameters,
)
from cyclemap.evidence.motion_check import check_pushes
from cyclemap.evidence.pushes.columns import ENDS, named_column
from cyclemap.evidence.pushes.conventions import convention_of
from cyclemap.evidence.pushes.measured_strokes import (
    DRAG_COLUMNS,
    LARGEST_TIP_ERROR,
    NO_LENGTH,
    PUSH_END_COLUMNS,
    ROD_OFF,
    MeasuredPush,
    Place,
    RowSelection,
    push_noise,
    pushes_of,
    read_measured_drags,
    read_measured_pushes,
    select_pushes,
    selected_rows,
    session_name,
    tip_error,
    told,
    told_push,
)
from cyclemap.evidence.pushes.planned_table import ERRORS, FRAMES_AGREE
from cyclemap.evidence.pushes.push_files import SUFFIXES, PushRecord, read_push_file
from cyclemap.evidence.pushes.push_table import (
    CSV_SUFFIX,
    PushTable,
    UnreadableFile,
    load_pushes,
)
from cyclemap.evidence.tables.push_sets import push_sets
from cyclemap.mechanics import MIT_SHAPE_NAMES, Pose, Slider
from cyclemap.mechanics.first_touch import first_contact
from cyclemap.protocol.settings import OWN_OUTLINE
from cyclemap.text_files import CsvRow, CsvTable, file_stem, read_csv_table

if TYPE_CHECKING:
    import pandas

MOST_STROKES = 2000
# What belongs to a plate, or to the frame that its data are in, and what to a session.
PLATE_OWNED = (*SURFACE.select(PLATE_NAMES).parameters, *TIP_OFFSET)
SESSION_OWNED = SURFACE.select(FLOOR_NAMES).parameters
PUSH_ENDS, DRAG_BACKS, WRENCHES, CYCLES, RECORDS = (
    "push ends",
    "drag-backs",
    "wrenches",
    "cycles",
    "records",
)

_COLUMNS = {
    PUSH_ENDS: {*PUSH_END_COLUMNS},
    DRAG_BACKS: {*DRAG_COLUMNS},
    WRENCHES: {*WRENCH_COLUMNS, *TWIST_COLUMNS},
}
_ORIENTATIONS = ({"theta0_accum_deg"}, {"theta0_deg"})
LAYOUTS = (
    "files of the MIT layout (.h5, .json), or a CSV table with the columns of poses "
    "(x0,y0,th0,x1,y1,th1), better with the tip (tip_x0,tip_y0,tip_x1,tip_y1), of drag-backs "
    "(x1,y1,th1,x0n,y0n,th0n), of orientations (theta0_deg), or of wrenches and twists "
    "(fx,fy,m_over_rho,vx,vy,w_times_rho)"
)

# Cycles that follow each other have errors alike: they form groups of this many, or smaller ones
# where data are few.
_LONGEST_GROUP, _FEWEST_GROUPS = 25, 20
# With pushes at fewer contacts than this each push is a group of its own.
_FEWEST_CONTACTS = 8
# Pushes of rods that were set by marks, at most: each has two unknowns of its own.
_MOST_SET = 200
# A session whose robot was this far from where it was sent (m), and so many times further than in
# others, is odd.
_ASTRAY, _TIMES, _SESSIONS_OF_A_FIELD = 5e-4, 3.0, 4
# So is one in which a plate turns by this share less or more than in another, and by so many
# standard errors; so many pushes, at least and at most, tell.
_TURNS_APART, _TURN_ERRORS, _FEWEST_TURNS, _MOST_TURNS = 0.15, 4.0, 20, 200
# A push whose tip strays further from a straight line (m) is another experiment.
_STRAIGHT = 2e-3
# Pieces of sliding pushes, and cycles of a set, below which nothing can be told of their noise.
_FEWEST_PIECES, _FEWEST_CYCLES = 3, 5
# Files of which the same is told are named one by one up to so many.
_MOST_NAMED = 3


def recognise(path: str | Path) -> tuple[list[tuple[Path, str]], list[UnreadableFile]]:
    """Return the files that a file, folder or tree holds, each with its sort of data, and those of
    unknown kind.

    A CSV file may hold two sorts; a folder of the MIT layout counts as one file; files of other
    kinds in a folder are passed over. Raises InvalidInput where there is nothing at `path`.
    """
    place = Path(path)
    if not place.exists():
        raise InvalidInput(f"{place}: there is nothing there; give a file or a folder of data")
    found: list[tuple[Path, str]] = []
    unused: list[UnreadableFile] = []
    files = [place]
    if place.is_dir():
        below = sorted(Path(folder, name) for folder, _, names in os.walk(place) for name in names)
        found += (
            [(place, RECORDS)] if any(file.suffix.lower() in SUFFIXES for file in below) else []
        )
        files = [file for file in below if file.suffix.lower() == CSV_SUFFIX]
    for file in files:
        if file.suffix.lower() in SUFFIXES:
            found.append((file, RECORDS))
            continue
        if file.suffix.lower() != CSV_SUFFIX:
            unused.append(
                UnreadableFile(file, f"a file of another kind ({file.suffix or 'no suffix'})")
            )
            continue
        try:
            table = read_csv_table(file)
        except DataFileError as error:
            unused.append(UnreadableFile(file, str(error).removeprefix(f"{file}").lstrip(":, ")))
            continue
        columns = set(table.header)
        sorts = [sort for sort, wanted in _COLUMNS.items() if columns >= wanted]
        posed = not sorts and all(named_column(table, one) for one in ENDS)
        if posed or any(columns >= names for names in _ORIENTATIONS):
            sorts.append(CYCLES)
        found += [(file, sort) for sort in sorts]
        if not sorts:
            unused.append(
                UnreadableFile(
                    file, f"a CSV table of unknown columns ({', '.join(table.header[:8])})"
                )
            )
    if not found and not unused:
        unused.append(UnreadableFile(place, "the folder holds no .h5, .json or .csv file"))
    return found, unused


@dataclass(frozen=True)
class FileNote:
    """What is told of a file, or of a session: its name, and words."""

    about: str
    words: str


def joined_notes(notes: Iterable[FileNote]) -> tuple[str, ...]:
    """Return notes in words; of many files that are told the same the first is named, the others
    are counted.

    >>> joined_notes([FileNote(f"scan{number}.h5", "1 friction scans") for number in range(144)])
    ('scan0.h5 and 143 more like it: 1 friction scans',)
    """
    alike: dict[str, list[str]] = {}
    for note in notes:
        alike.setdefault(note.words, []).append(note.about)
    told = list[str]()
    for words, names in alike.items():
        if len(names) <= _MOST_NAMED:
            told += [f"{name}: {words}" for name in names]
        else:
            told.append(f"{names[0]} and {len(names) - 1} more like it: {words}")
    return tuple(told)


class BlockBuilder:
    """Blocks of data and notes on what they hold and what stays out, file by file and plate by
    plate.

    What blocks are made with: see `collected_blocks`.
    """

    def __init__(
        self,
        loop: CollectionLoop,
        first: int,
        wear: bool,
        most: int,
        nodes: int,
        push_length: float | None,
        target: Place | None = None,
    ) -> None:
        self.given, self.first, self.wear, self.most, self.nodes = loop, first, wear, most, nodes
        self.target = target
        self.push_length = math.nan if push_length is None else push_length
        self.path, self.plate, self.loop = Path(), loop.slider.name, loop
        self.session, self.known_sessions = "", dict[tuple[str, str], Path]()
        self.blocks: list[DataBlock] = []
        self.plates: list[str] = []
        self.sessions: list[str] = []
        self.tip_errors: dict[str, float] = {}
        # Pushes by plate and session.
        self.pushes: dict[str, dict[str, list[MeasuredPush]]] = {}
        # Filled-in pushes by their numbers: where each was read.
        self.filled: dict[tuple[str, ...], str] = {}
        self.rods_set = 0
        self.notes: list[FileNote] = []
        self.scans: list[Array] = []
        self.last_cycle = 0.0
        self.known_noise, self.unknown_noise = dict[str, float](), set[str]()

    def add_file(
        self, path: Path, sort: str, selection: RowSelection, progress: Progress
    ) -> tuple[frozenset[str], frozenset[str]]:
        """Add the blocks of one sort of data in a file; return the surfaces and the objects that it
        tells of.
        """
        self.path = path
        is_table = sort not in (RECORDS, CYCLES)
        if is_table:
            table = convention_of(path).table(read_csv_table(path))
            _, facts, left_out = selected_rows(table, selection)
        else:
            pushes, left_out = select_pushes(
                path, selection, sort == CYCLES, part_of(progress, 0, 2)
            )
            facts = [
                row for frame in (pushes.table, pushes.scans) for row in frame.to_dict("records")
            ]
            self._add_unreadable(pushes)
        surfaces, objects = (told(one.get(name) for one in facts) for name in ("surface", "object"))
        self._leave_out(left_out)
        if sort in (RECORDS, CYCLES, PUSH_ENDS):
            for words in check_pushes(load_pushes(path) if is_table else pushes, self.given):
                self._note(words)
        sessions = [] if len(surfaces) > 1 else _plates_and_speeds(facts, self.given.slider.name)
        for number, (plate, speed) in enumerate(sessions):
            self.plate, self.loop = plate, loop_of_plate(self.given, plate)
            self.session = self._session(sort, speed)
            chosen = (
                dict(selection.chosen) if speed is None else {**selection.chosen, "speed": speed}
            )
            own = RowSelection((plate,) if len(objects) > 1 else selection.objects, chosen)
            if is_table:
                self._add_table(sort, table, selected_rows(table, own)[0])
            elif sort == CYCLES:
                strokes = pushes_of(pushes, own)
                self._add_cycles(strokes)
                self._add_posed(strokes.table)
            else:
                self._add_records(
                    pushes_of(pushes, own), part_of(part_of(progress, 1, 2), number, len(sessions))
                )
        return surfaces, objects

    def _session(self, sort: str, speed: float | None) -> str:
        """The name of a session: its plate and speed, of orientations alone its file; empty where
        nothing tells.
        """
        if speed is None and sort != CYCLES:
            return ""
        session = session_name(self.plate, speed, self.path.stem)
        if self.known_sessions.setdefault((session, sort), self.path) != self.path:
            session += f", {self.path.stem}"
        return session

    def named(self, population: bool) -> tuple[DataBlock, ...]:
        """Return the blocks, those of several plates or sessions with unknowns of their own, and
        how sessions differ.

        population : whether one session is taken as one of several. Equal names get a number
            behind.
        """
        names = {one.name for one in SESSION_OWNED}
        of_floor = [bool(names & {*block.parameters}) for block in self.blocks]
        # What tells no speed belongs to the first session of its plate that does.
        first = dict(
            reversed([both for both in zip(self.plates, self.sessions, strict=True) if both[1]])
        )
        own = [
            one or first.get(plate, plate)
            for plate, one in zip(self.plates, self.sessions, strict=True)
        ]
        sessions = list(dict.fromkeys(one for one, told in zip(own, of_floor, strict=True) if told))
        several = len(sessions) > 1 or (population and len(sessions) == 1)
        blocks = []
        for block, plate, session in zip(self.blocks, self.plates, own, strict=True):
            if len({*self.plates}) > 1 or several:
                block = replace(block, name=f"{session if several else plate} {block.name}")
            if len({*self.plates}) > 1:
                block = block.of_owner(plate, PLATE_OWNED)
            blocks.append(block.of_owner(session, SESSION_OWNED) if several else block)
        if several:
            blocks.append(session_block(sessions, self._odd_sessions()))
        used = [block.name for block in blocks]
        return tuple(
            replace(block, name=f"{block.name} {used[: number + 1].count(block.name)}")
            if used.count(block.name) > 1
            else block
            for number, block in enumerate(blocks)
        )

    def _odd_sessions(self) -> list[str]:
        """Sessions whose robot strayed, or whose plate turned, unlike in the others, with a note of
        each.
        """
        usual = float(np.median([*self.tip_errors.values()])) if self.tip_errors else 0.0
        odd = {}
        for session, size in self.tip_errors.items():
            if size > max(_ASTRAY, _TIMES * usual):
                strayed = (
                    f"{1e3 * size:.2g} mm from where it was sent on average, {1e3 * usual:.2g} mm "
                    "in others"
                )
                odd[session] = f"the rod was {strayed}"
        for plate, sessions in self.pushes.items():
            counted = {
                session: own for session, own in sessions.items() if len(own) >= _FEWEST_TURNS
            }
            if len(counted) > 1:
                slider = loop_of_plate(self.given, plate).slider
                odd |= self._turned_unlike(
                    {session: flat_turns(own, slider) for session, own in counted.items()}
                )
        for session, reason in odd.items():
            words = f"an odd session, {reason}: it does not count to the floor's mean"
            self.notes.append(FileNote(session, words))
        return [*odd]

    def _turned_unlike(self, turns: Mapping[str, tuple[float, float]]) -> dict[str, str]:
        """Of sessions of one plate those that turned it unlike the others, and why; turns : of
        each, see `flat_turns`.

        Of two that differ the odd one is that whose robot strayed more; where nothing tells, both
        are noted only.
        """
        odd = {}
        for session, (ratio, error) in turns.items():
            # The median of all, of two the other one.
            ranked = sorted(
                both for name, both in turns.items() if len(turns) > 2 or name != session
            )
            other, its_error = ranked[(len(ranked) - 1) // 2]
            apart = abs(ratio - other)
            if apart <= _TURNS_APART * max(ratio, other) or apart <= _TURN_ERRORS * math.hypot(
                error, its_error
            ):
                continue
            astray = [self.tip_errors.get(name, 0.0) for name in turns if name != session]
            reason = (
                f"its turns are {ratio:.2f} of isotropic friction's on a flat floor, "
                f"{other:.2f} in others"
            )
            if len(turns) > 2 or self.tip_errors.get(session, 0.0) > max(astray):
                odd[session] = reason
            elif self.tip_errors.get(session, 0.0) == max(astray):
                self.notes.append(
                    FileNote(session, f"{reason}; nothing tells which of the two is odd")
                )
        return odd

    def _add_unreadable(self, pushes: PushTable) -> None:
        """Note files of the MIT layout that could not be read."""
        if pushes.unreadable:
            one = pushes.unreadable[0]
            reason = f"unreadable, the first {one.path.name}: {one.reason}"
            self._leave_out(Counter({reason: len(pushes.unreadable)}))

    def _note(self, words: str) -> None:
        self.notes.append(FileNote(str(self.path), words))

    def _add(self, block: DataBlock, words: str, noise: Mapping[str, float] | None = None) -> None:
        """Add a block of the session, and a note of what it holds; noise : of its kinds, where the
        data tell it.
        """
        for kind in set(block.kinds.tolist()):
            if noise is None:
                self.unknown_noise.add(kind)
            else:
                self.known_noise[kind] = max(noise[kind], self.known_noise.get(kind, 0.0))
        self.blocks.append(block)
        self.plates.append(self.plate)
        self.sessions.append(self.session)
        self._note(f"{words} of {self.plate}")

    def _leave_out(self, counts: Counter[str]) -> None:
        """Note how many rows of the file stay out, and why."""
        for reason, count in (+counts).items():
            self._note(f"{count} left out: {reason}")

    def _add_records(self, pushes: PushTable, progress: Progress) -> None:
        """Add what files of the MIT layout tell: friction scans, cycles of repeated pushes, their
        ends and forces.
        """
        columns = {name: pushes.scans[name].to_numpy(dtype=float) for name in SCAN_FIELDS}
        known = np.all(np.isfinite([*columns.values()]), axis=0)
        self._leave_out(Counter({"friction scans without direction or force": int(np.sum(~known))}))
        if np.any(known):
            table, weight = (
                {name: column[known] for name, column in columns.items()},
                self.loop.model.weight,
            )
            self.scans.append(scan_traction(table, weight))
            self._add(
                friction_scan_block(table, weight),
                f"{np.sum(known)} friction scans, weight {weight:.3g} N",
            )
        self._add_cycles(pushes)
        self._add_pushes(pushes.table, progress)

    def _add_cycles(self, pushes: PushTable) -> None:
        """Add a block of cycles for each set of pushes that were repeated at one contact."""
        for one in push_sets(pushes) if len(pushes.table) else ():
            pairs = one.pairs
            if pairs is None or one.contacts != 1:
                continue
            number = np.arange(float(pairs.theta.size)) if pairs.cycle is None else pairs.cycle
            late = number >= self.first
            count = int(np.sum(late))
            self._leave_out(
                Counter({f"cycles before {self.first}": late.size - count, **pairs.dropped})
            )
            if count < _FEWEST_CYCLES:
                self._note(f"{count} cycles of {one.name} left out: too few")
                continue
            place = {
                name: one.facts[name] for name in ("side", "fraction", "angle") if name in one.facts
            }
            loop = replace(self.loop, push=replace(self.loop.push, **place))
            since = number[late] - self.first
            share, groups = since / np.max(since) if self.wear else None, _cycle_groups(count)
            block = cycle_pair_block(
                loop, pairs.theta[late], pairs.turn[late], groups, share, self.nodes
            )
            self.last_cycle = max(self.last_cycle, float(np.max(since)))
            self._add(block, f"{count} cycles of {one.name}" + (", wearing" if self.wear else ""))

    def _add_posed(self, table: pandas.DataFrame) -> None:
        """Add ends of pushes without the places of the rod: it went from its first touch on as the
        loop's does.
        """
        posed = table[["x0", "dtheta"]].notna().all(axis=1) & ~(table["repetition"] < self.first)
        rows = table[posed].to_dict("records")
        pushes: list[MeasuredPush] = []
        for row in rows:
            length = self.push_length if math.isnan(row["length"]) else row["length"]
            if math.isnan(length):
                continue
            push = told_push(self.loop.push, row, length)
            place, way = first_contact(self.loop.slider, push, self.loop.pusher.radius)
            start = Pose(row["x0"], row["y0"], row["theta0"])
            end = Pose(row["x1"], row["y1"], row["theta1"])
            tips = start.to_world(*place), start.to_world(*(place + push.distance * way))
            pushes.append(MeasuredPush(start, end, *tips, contact=len(pushes)))
        self._leave_out(Counter({f"ends of pushes: {NO_LENGTH}": len(rows) - len(pushes)}))
        self._add_push_ends(pushes)

    def _add_pushes(self, table: pandas.DataFrame, progress: Progress) -> None:
        """Add ends and forces of recorded pushes."""
        late = ~(table["repetition"].to_numpy(dtype=float) < self.first)
        steady = np.nan_to_num(table["acceleration"].to_numpy(dtype=float)) == 0.0
        self._leave_out(Counter({"pushed with acceleration": int(np.sum(~steady & late))}))
        rows = table[steady & late].to_dict("records")
        chosen = _thinned(rows, self.most)
        if len(chosen) < len(rows):
            self._note(f"every {len(rows) / len(chosen):.3g}th of {len(rows)} pushes taken")
        places: list[tuple[float, float]] = []
        pushes: list[MeasuredPush] = []
        records: list[PushRecord] = []
        for number, row in enumerate(chosen):
            record = convention_of(row["path"]).record(read_push_file(row["path"]))
            assert isinstance(record, PushRecord)
            tip = record.tip_pose[:, 1:3]
            length = float(np.hypot(*(tip[-1] - tip[0])))
            # How far the tip strays from the straight line between its ends.
            beside = (tip - tip[0]) @ [tip[0, 1] - tip[-1, 1], tip[-1, 0] - tip[0, 0]]
            if length > _STRAIGHT and np.max(np.abs(beside)) <= _STRAIGHT * length:
                first, last = (tuple(place) for place in tip[[0, -1]].tolist())
                pushes.append(MeasuredPush(Pose(*record.start), Pose(*record.end), first, last))
                places.append((row["side"], row["fraction"]))
                records.append(record)
            part_of(progress, number, len(chosen))(1.0)
        self._leave_out(
            Counter({"pushes whose tip did not go straight": len(chosen) - len(records)})
        )
        if not records:
            return
        # Pushes are grouped by contact where there are many contacts, else by runs of repetitions.
        known, groups = sorted(set(places)), _cycle_groups(len(pushes)).tolist()
        if len(known) >= _FEWEST_CONTACTS and not any(
            math.isnan(number) for place in known for number in place
        ):
            groups = [known.index(place) for place in places]
        self._add_push_ends(
            [replace(push, contact=group) for push, group in zip(pushes, groups, strict=True)]
        )
        outline = self.loop.slider.outline_points(360)
        sliding = sliding_forces([(record, outline) for record in records], self.loop.pusher.radius)
        pieces, count = sliding.ratio.size, len(np.unique(sliding.push))
        if pieces < _FEWEST_PIECES:
            self._note(f"forces not used: the rod slides in {pieces} pieces of pushes")
        else:
            self._add(
                force_ratio_block(sliding),
                f"{pieces} force ratios while the rod slides, in {count} pushes",
            )

    def _add_push_ends(
        self,
        pushes: Sequence[MeasuredPush],
        noise: Mapping[str, float] | None = None,
        set_by_marks: bool = False,
    ) -> None:
        kept = _thinned(pushes, min(self.most, _MOST_SET) if set_by_marks else self.most)
        if kept:
            self.pushes.setdefault(self.plate, {}).setdefault(
                self.session, _thinned(pushes, _MOST_TURNS)
            )
            first_set = self.rods_set + 1 if set_by_marks else None
            block = push_end_block(kept, self.loop.slider, self.target, first_set)
            self.rods_set += len(kept) if set_by_marks else 0
            self._add(block, f"{_counted(kept, pushes)} push ends", noise)

    def _refuse_repeated(self, table: CsvTable, rows: Sequence[CsvRow]) -> None:
        """Refuse a filled-in push that was read before, which would count twice: ten readings never
        come again.
        """
        if not {FRAMES_AGREE, *ERRORS} & {*table.header}:
            return
        for row in rows:
            readings = tuple(table.text(row, name) for name in PUSH_END_COLUMNS)
            if readings in self.filled:
                again = (
                    f"the push of {self.filled[readings]} again, all readings the same, "
                    "would count twice"
                )
                raise table.error(row.line, f"{again}: leave one of them out")
            self.filled[readings] = f"{table.path}, line {row.line},"

    def _add_table(self, sort: str, table: CsvTable, rows: Sequence[CsvRow]) -> None:
        """Add what rows of a CSV table of push ends, drag-backs, or wrenches and twists tell."""
        if sort == PUSH_ENDS:
            self._refuse_repeated(table, rows)
            pushes = read_measured_pushes(table, rows)
            astray = [
                error for row in rows if (error := tip_error(table, row)) <= LARGEST_TIP_ERROR
            ]
            self.tip_errors[self.session] = float(np.mean(astray)) if astray else 0.0
            self._leave_out(Counter({"the tip was not where it was sent": len(rows) - len(pushes)}))
            if len({push.contact for push in pushes}) < _FEWEST_CONTACTS:
                pushes = tuple(replace(push, contact=number) for number, push in enumerate(pushes))
            self._add_push_ends(pushes, _told_noise(table, rows), FRAMES_AGREE in table.header)
        elif sort == DRAG_BACKS:
            drags = read_measured_drags(table, rows)
            kept, noise = _thinned(drags, self.most), _told_noise(table, rows)
            block = drag_turn_block(kept, self.loop.slider, self.target)
            self._add(block, f"{_counted(kept, drags)} drag-backs", noise)
        else:
            outline = self.loop.slider.outline
            data = read_wrench_twists(table, rows, outline.extent)
            scaled = f"torque and turning rate scaled by {1e3 * outline.extent:.2f} mm"
            block = wrench_twist_block(data, self.loop.slider)
            self._add(block, f"{len(data.twist)} pairs of wrench and twist, {scaled}")
            sources = (
                sorted({table.text(row, "source") for row in rows})
                if "source" in table.header
                else []
            )
            if len(sources) > 1:
                listed = ", ".join(sources)
                self._note(
                    f"pairs are of several sources ({listed}): what stands in two counts twice"
                )


def _told_noise(table: CsvTable, rows: Sequence[CsvRow]) -> dict[str, float] | None:
    """How far measured pushes and drags are off, by kind of noise, where a table tells how far its
    readings are.
    """
    if not {*ERRORS} <= set(table.header):
        return None
    read = np.array([[table.number(row, name) for name in ERRORS] for row in rows])
    worst = 1e-3 * float(read[:, 0].max()), math.radians(float(read[:, 1].max()))
    along, _, turned, dragged = push_noise(worst)
    return {
        "push place (m)": float(along),
        "push turn (rad)": float(turned),
        "drag turn (rad)": float(dragged),
    }


def _plates_and_speeds(
    facts: Sequence[Mapping[str, Any]], plate: str
) -> list[tuple[str, float | None]]:
    """The plates that rows tell of, else the one given, each with every speed that they tell,
    m/s."""
    speeds: dict[str, set[float]] = {}
    for row in facts:
        known, speed = row.get("object"), row.get("speed")
        own = speeds.setdefault(known if isinstance(known, str) and known else plate, set())
        if speed is not None and not math.isnan(speed):
            own.add(float(speed))
    return [
        (own, speed)
        for own in sorted(speeds)
        for speed in (sorted(speeds[own]) if speeds[own] else (None,))
    ]


def loop_of_plate(loop: CollectionLoop, plate: str) -> CollectionLoop:
    """Return the loop with a plate of the MIT dataset, its ring where it was; with its own object
    for another name.
    """
    if plate == loop.slider.name or plate not in MIT_SHAPE_NAMES:
        return loop
    return replace(loop, slider=Slider.mit(plate, loop.slider.hitch), footprint=None)


def flat_turns(pushes: Sequence[MeasuredPush], slider: Slider) -> tuple[float, float]:
    """Return the mean size of turns over that of isotropic friction on a flat floor, and its
    standard error.
    """
    ends = predicted_push_ends(surface_model(SurfaceParameters(), slider), pushes)[0]
    predicted = np.abs(ends[:, 2] - [push.start.theta for push in pushes])
    measured = np.abs([push.end.theta - push.start.theta for push in pushes])
    mean = max(float(np.mean(predicted)), 1e-9)
    ratio = float(np.mean(measured)) / mean
    return ratio, float(np.std(measured - ratio * predicted)) / math.sqrt(len(pushes)) / mean


def _cycle_groups(count: int) -> Labels:
    return np.arange(count) // min(max(count // _FEWEST_GROUPS, 1), _LONGEST_GROUP)


def _thinned(rows: Sequence[Any], most: int) -> list[Any]:
    """At most so many of the rows, evenly spread."""
    return [
        rows[k]
        for k in np.unique(np.linspace(0, len(rows) - 1, min(most, len(rows))).round().astype(int))
    ]


def _counted(kept: Sequence[Any], rows: Sequence[Any]) -> str:
    return str(len(kept)) if len(kept) == len(rows) else f"{len(kept)} of {len(rows)}"


@dataclass(frozen=True, eq=False)
class CollectedBlocks:
    """Blocks of data of one surface, of one object or of several.

    blocks : of unlike names; of several objects each is that of a plate, of several sessions each
        is that of one, and a last one tells how sessions may differ. notes : what was recognised,
        what was left out
    and why, in words. surface : its name where the data tell it. loop : with the data's object,
        where it is one.
    scans : (n, 2) tractions of friction scans. last_cycle : how many the last is behind the first;
        0 where unknown.
    noise : of the kinds of noise that all of their data tell.
    """

    blocks: tuple[DataBlock, ...]
    notes: tuple[str, ...]
    surface: str | None
    loop: CollectionLoop
    scans: Array | None
    last_cycle: float
    noise: Mapping[str, float]


def collected_blocks(
    paths: Sequence[str | Path],
    loop: CollectionLoop,
    select: Mapping[str, str | float] | None = None,
    *,
    first: int = 0,
    wear: bool = False,
    most: int = MOST_STROKES,
    nodes: int = NODES,
    push_length: float | None = None,
    population: bool = False,
    target: Place | None = None,
    progress: Progress | None = None,
) -> CollectedBlocks:
    """Return the blocks of all data in files, folders and trees.

    Parameters
    ----------
    paths : Sequence[str or Path]
        Files of the MIT layout (friction scans; pushes: their ends, their forces, and cycles
        where they are repeated), CSV tables of push ends with the tip's places or without (then
        it went as the loop's does, from its first touch on), of drag-backs, of orientations, of
        wrenches and twists.
    loop : CollectionLoop
        Who is pushed where, with which rod and ring.
    select : mapping, optional
        Values of surface, object, speed, side, fraction, angle (SI, rad) to keep. Objects are
        all those of the MIT dataset that the data name, or the selected one; of an outline of
        the loop's own, that one alone.
    first : int, optional
        The first cycle (repetition) used.
    wear : bool, optional
        Let the surface of the cycles wear.
    push_length : float, optional
        How far the rod of pushes went from its first touch, m, where tables of poses do not
        tell; None leaves the ends of such pushes out.
    target : Place, optional
        m, in the frame of the data, where resets end: how the floor's shape varies with the
        place about it is then an unknown of pushes and drags.
    population : bool, optional
        Whether the floor is known from other sessions, so that a single one is one of several.
    most : int, optional
        Strokes of one sort in a session, at most: beyond, every so many-th is taken.
    nodes : int, optional
        See `cycle_pair_block`; with 9 the ring's lever comes out 3 % short on a map with strong
        second harmonics, with 15 it does not.

    Returns
    -------
    CollectedBlocks
        The blocks of all data in files, folders and trees.

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
    """
    whole_number("first cycle", first, least=0)
    chosen = dict(select or {})
    wanted, objects = chosen.get("object"), MIT_SHAPE_NAMES
    if isinstance(wanted, str):
        loop, objects = loop_of_plate(loop, wanted), (wanted,)
    elif loop.slider.name not in MIT_SHAPE_NAMES:
        objects = () if loop.slider.name == OWN_OUTLINE else (file_stem(loop.slider.name),)
    selection = RowSelection(objects, chosen)
    builder = BlockBuilder(
        loop, first, wear, whole_number("most strokes", most, least=2), nodes, push_length, target
    )
    found = [recognise(path) for path in paths]
    files = list(dict.fromkeys(file for known, _ in found for file in known))
    unused = list(dict.fromkeys(file for _, others in found for file in others))
    surfaces, shapes = set[str](), set[str]()
    for number, (path, sort) in enumerate(files):
        on, of = builder.add_file(path, sort, selection, part_of(progress, number, len(files)))
        surfaces, shapes = surfaces | on, shapes | of
    if len(surfaces) > 1:
        raise InvalidInput(
            f"the data are of several surfaces: {', '.join(sorted(surfaces))}; select one, "
            "surface=NAME"
        )
    if len(shapes) > 1 and loop.slider.name not in MIT_SHAPE_NAMES:
        raise InvalidInput(
            f"the data are of several objects: {', '.join(sorted(shapes))}; select one"
        )
    if not builder.blocks:
        reasons = joined_notes(
            [*builder.notes, *(FileNote(str(file.path), file.reason) for file in unused)]
        )
        listed = "; ".join(reasons) or ", ".join(str(path) for path in paths)
        facts = ", ".join(f"{name}: {value}" for name, value in chosen.items() if name != "object")
        if facts and not unused:
            raise InvalidInput(f"no such {facts}; {listed}")
        raise InvalidInput(f"no data of {loop.slider.name} recognised: {listed}. Give {LAYOUTS}")
    blocks = builder.named(population)
    notes = joined_notes(
        [*builder.notes, *(FileNote(str(file.path), f"not used: {file.reason}") for file in unused)]
    )
    scans = np.concatenate(builder.scans) if builder.scans else None
    loop = loop if len(set(builder.plates)) > 1 else loop_of_plate(loop, builder.plates[0])
    noise = {
        kind: size
        for kind, size in builder.known_noise.items()
        if kind not in builder.unknown_noise
    }
    return CollectedBlocks(
        blocks, notes, next(iter(surfaces), None), loop, scans, builder.last_cycle, noise
    )


def telling_parameters(
    blocks: Sequence[DataBlock], believed: Collection[str] | None = None
) -> tuple[str, ...]:
    """Return the names of what blocks of data can usually tell, for a start: not what mostly trades
    off.

    The friction ellipse, its size only where scans or forces tell it; shapes of floor and plates,
    the rod, how each data set's frame is shifted, friction in the ring with drags or cycles, how
    the surface wears; of four sessions and more, how the
    floor's shape varies with the place. believed : of a known floor, what its samples tell of the
    ellipse; single pushes and drags take
    the rest of it as it stands.

    >>> telling_parameters([DataBlock("ratios", ("pusher_friction",), lambda v: None, [0, 1], "ratio")])
    ('pusher_friction',)
    """
    asked = {name for block in blocks for name in block.parameters}
    of_ellipse = {
        name
        for block in blocks
        if block.curve or block.motions is None
        for name in block.parameters
    }
    by_motions = asked & {*SURFACE.names[1:5]} & {*(asked if believed is None else believed)}
    free = [name for name in SURFACE.names[:5] if name in of_ellipse | by_motions]
    owned = {one.name for one in (*PLATE_OWNED, *SESSION_OWNED)}
    free += [name for name in ("pusher_friction", "pin_friction_radius") if name in asked]
    free += sorted(name for name in asked if name.partition("[")[0] in owned)
    free += [name for block in blocks for name in block.parameters if name.startswith(ROD_OFF)]
    if len([name for name in asked if name.startswith("floor_dome[")]) >= _SESSIONS_OF_A_FIELD:
        free += [name for name in FIELD_NAMES if name in asked]
    return (*free, *sorted(name for name in asked if name.startswith("worn_")))
