"""Blocks of data from the rows of files: cycles, ends and forces of pushes, friction scans, and tables of strokes."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.data_blocks.cycle_pair_block import CyclePairBlock, blocks_of_cycles
from cyclemap.evidence.data_blocks.force_blocks import (
    SCAN_FIELDS,
    TWIST_COLUMNS,
    WRENCH_COLUMNS,
    ScanForces,
    friction_scan_block,
    read_wrench_twists,
    wrench_twist_block,
)
from cyclemap.evidence.data_blocks.force_ratio_block import force_ratio_block, sliding_forces
from cyclemap.evidence.data_blocks.stroke_block import TIP_OFFSET, drag_turn_block, push_end_block
from cyclemap.evidence.identification.data_block import DataBlock, PlateBlock, Progress, part_of
from cyclemap.evidence.identification.surface_parameters import SHARE_NAMES, SURFACE
from cyclemap.evidence.pushes.measured_strokes import (
    CsvSelection,
    MeasuredPush,
    read_measured_drags,
    read_measured_pushes,
)
from cyclemap.evidence.pushes.push_files import SUFFIXES, PushRecord, read_push_file
from cyclemap.evidence.pushes.push_table import CSV_SUFFIX, PushTable, UnreadableFile
from cyclemap.evidence.tables.push_sets import PushSet, push_sets
from cyclemap.mechanics import Pose
from cyclemap.text_files import read_csv_table

if TYPE_CHECKING:
    import pandas

PUSH_ENDS, DRAG_BACKS, WRENCHES, CYCLES, RECORDS = "push ends", "drag-backs", "wrenches", "cycles", "records"

_START, _END = ({"x0", "y0", "th0"}, {"x1", "y1", "th1"})
_TIP = {"tip_x0", "tip_y0", "tip_x1", "tip_y1"}
_RESET = {"x0n", "y0n", "th0n"}
_ORIENTATIONS = ({"theta0_accum_deg"}, {"theta0_deg"})
LAYOUTS = (
    "files of the MIT layout (.h5, .json), or a CSV table with the columns of poses and tip "
    "(x0,y0,th0,x1,y1,th1,tip_x0,tip_y0,tip_x1,tip_y1), of drag-backs (x1,y1,th1,x0n,y0n,th0n), of orientations "
    "(theta0_deg), or of wrenches and twists (fx,fy,m_over_rho,vx,vy,w_times_rho)"
)

# Cycles that follow each other have errors alike: they form groups of this many, or smaller ones where data are few.
_LONGEST_GROUP, _FEWEST_GROUPS = 25, 20
# With pushes at fewer contacts than this each push is a group of its own.
_FEWEST_CONTACTS = 8
# A push whose tip strays further from a straight line (m) is another experiment.
_STRAIGHT = 2e-3
# Pieces of sliding pushes, and cycles of a set, below which nothing can be told of their noise.
_FEWEST_PIECES, _FEWEST_CYCLES = 3, 5


@dataclass(frozen=True)
class DataFile:
    """A CSV file, or a file or folder of the MIT layout, and the sort of data it holds."""

    path: Path
    sort: str


def recognise(path: str | Path) -> tuple[tuple[DataFile, ...], tuple[UnreadableFile, ...]]:
    """Return what a file, folder or tree holds; a file may hold two sorts, files of no known kind are passed over.

    Raises InvalidInput where there is nothing at `path`.
    """
    place = Path(path)
    if not place.exists():
        raise InvalidInput(f"{place}: there is nothing there; give a file or a folder of data")
    if not place.is_dir():
        return _file(place)
    below = sorted(Path(folder, name) for folder, _, names in os.walk(place) for name in names)
    found: list[DataFile] = []
    unused: list[UnreadableFile] = []
    if any(file.suffix.lower() in SUFFIXES for file in below):
        found.append(DataFile(place, RECORDS))
    for file in below:
        if file.suffix.lower() == CSV_SUFFIX:
            sorts, not_used = _file(file)
            found += sorts
            unused += not_used
    if not found and not unused:
        unused.append(UnreadableFile(place, "the folder holds no .h5, .json or .csv file"))
    return tuple(found), tuple(unused)


def _file(path: Path) -> tuple[tuple[DataFile, ...], tuple[UnreadableFile, ...]]:
    if path.suffix.lower() in SUFFIXES:
        return (DataFile(path, RECORDS),), ()
    if path.suffix.lower() != CSV_SUFFIX:
        return (), (UnreadableFile(path, f"a file of another kind ({path.suffix or 'no suffix'})"),)
    try:
        header = read_csv_table(path).header
    except DataFileError as error:
        return (), (UnreadableFile(path, str(error).removeprefix(f"{path}").lstrip(":, ")),)
    sorts = csv_sorts(header)
    if not sorts:
        return (), (UnreadableFile(path, f"a CSV table of unknown columns ({', '.join(header[:8])})"),)
    return tuple(DataFile(path, sort) for sort in sorts), ()


def csv_sorts(header: tuple[str, ...]) -> tuple[str, ...]:
    """Return the sorts of data that a CSV header announces.

    >>> csv_sorts(("surface", "x1", "y1", "th1", "x0n", "y0n", "th0n"))
    ('drag-backs',)
    """
    columns, sorts = set(header), []
    if columns >= _START | _END | _TIP:
        sorts.append(PUSH_ENDS)
    if columns >= _END | _RESET:
        sorts.append(DRAG_BACKS)
    if columns >= {*WRENCH_COLUMNS, *TWIST_COLUMNS}:
        sorts.append(WRENCHES)
    if any(columns >= names for names in _ORIENTATIONS) or (not sorts and columns >= _START | _END):
        sorts.append(CYCLES)
    return tuple(sorts)


@dataclass(frozen=True)
class BlockChoices:
    """What blocks are made with: see `collected_blocks`."""

    loop: CollectionLoop
    first: int
    wear: bool
    most: int
    nodes: int


@dataclass(eq=False)
class Built:
    """What has been built so far; it grows file by file."""

    blocks: list[DataBlock] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    scans: list[ScanForces] = field(default_factory=list)
    objects: frozenset[str] = frozenset()
    plates: list[str] = field(default_factory=list)
    last_cycle: float = 0.0
    _plate: str = ""

    @contextmanager
    def plate(self, name: str) -> Iterator[None]:
        """Blocks added meanwhile are of this plate."""
        self._plate = name
        yield

    def of_plates(self) -> list[DataBlock]:
        """The blocks, each of its plate."""
        owned = (*SURFACE.select(SHARE_NAMES).parameters, *TIP_OFFSET)
        return [PlateBlock(block, plate, owned) for block, plate in zip(self.blocks, self.plates, strict=True)]

    def add(self, path: Path, block: DataBlock, words: str) -> None:
        """Add a block, and a note of what it holds."""
        self.blocks.append(block)
        self.plates.append(self._plate)
        self.notes.append(f"{path}: {words} of {self._plate}")

    def left_out(self, path: Path, counts: Counter[str]) -> None:
        """Note how many rows of a file stay out, and why."""
        self.notes += [f"{path}: {count} left out: {reason}" for reason, count in counts.items()]


def record_parts(
    built: Built, path: Path, pushes: PushTable, choices: BlockChoices, progress: Progress | None = None
) -> None:
    """Add what files of the MIT layout tell: friction scans, cycles of repeated pushes, ends and forces of pushes."""
    unreadable = len(pushes.unreadable)
    if unreadable:
        one = pushes.unreadable[0]
        built.left_out(path, Counter({f"unreadable, the first {one.path.name}: {one.reason}": unreadable}))
    _add_scans(built, path, pushes.scans, choices)
    cycle_parts(built, path, pushes, choices)
    _add_pushes(built, path, pushes.table, choices, progress)


def cycle_parts(built: Built, path: Path, pushes: PushTable, choices: BlockChoices) -> None:
    """Add a block of cycles for each set of pushes that were repeated at one contact."""
    if not len(pushes.table):
        return
    for one in push_sets(pushes):
        if one.pairs is not None and one.contacts == 1:
            _add_cycles(built, path, one, choices)


def csv_part(built: Built, file: DataFile, rows: CsvSelection, choices: BlockChoices) -> None:
    """Add what a CSV table of push ends, drag-backs, or wrenches and twists tells."""
    if file.sort == PUSH_ENDS:
        found = [read_measured_pushes(file.path, texts) for texts in rows.texts]
        far = sum(rows.rows) - sum(map(len, found))
        built.left_out(file.path, +Counter({"the tip was not where it was sent": far}))
        _add_push_ends(built, file.path, _with_contacts_apart(found), choices)
    elif file.sort == DRAG_BACKS:
        drags = [drag for texts in rows.texts for drag in read_measured_drags(file.path, texts)]
        kept = _thinned([replace(drag, contact=k) for k, drag in enumerate(drags)], choices.most)
        block = drag_turn_block(kept, choices.loop.slider)
        built.add(file.path, block, f"{_counted(len(kept), len(drags))} drag-backs")
    else:
        _add_wrenches(built, file.path, rows, choices)


def _add_wrenches(built: Built, path: Path, rows: CsvSelection, choices: BlockChoices) -> None:
    outline, surface = choices.loop.slider.outline, next(iter(rows.surfaces), None)
    if rows.left_out and surface is None:
        built.notes.append(f"{path}: not used: rows of several objects, and no surface to tell them apart")
        return
    data = read_wrench_twists(path, rho=outline.extent, surface=surface)
    block = wrench_twist_block(data, outline, choices.loop.model.weight)
    scaled = f"torque and turning rate scaled by {1e3 * outline.extent:.2f} mm"
    built.add(path, block, f"{len(data.twist)} pairs of wrench and twist, {scaled}")
    table = read_csv_table(path)
    if "source" in table.header:
        same = [row for row in table.rows if surface is None or table.text(row, "surface") == surface]
        sources = sorted({table.text(row, "source") for row in same})
        if len(sources) > 1:
            told = f"pairs are of several sources ({', '.join(sources)}): what stands in two counts twice"
            built.notes.append(f"{path}: {told}")


def _add_scans(built: Built, path: Path, scans: pandas.DataFrame, choices: BlockChoices) -> None:
    columns = [scans[name].to_numpy(dtype=float) for name in SCAN_FIELDS]
    known = np.all(np.isfinite(columns), axis=0)
    built.left_out(path, +Counter({"friction scans without direction or force": int(np.sum(~known))}))
    if np.any(known):
        weight = choices.loop.model.weight
        direction, along, across = (column[known] for column in columns)
        found = ScanForces(direction, along, across, weight)
        built.scans.append(found)
        table = {name: getattr(found, name) for name in SCAN_FIELDS}
        built.add(path, friction_scan_block(table, weight), f"{np.sum(known)} friction scans, weight {weight:.3g} N")


def _add_cycles(built: Built, path: Path, one: PushSet, choices: BlockChoices) -> None:
    pairs = one.pairs
    assert pairs is not None
    number = np.arange(float(pairs.theta.size)) if pairs.cycle is None else pairs.cycle
    late = number >= choices.first
    count, early = int(np.sum(late)), int(np.sum(~late))
    built.left_out(path, +Counter({f"cycles before {choices.first}": early, **pairs.dropped}))
    if count < _FEWEST_CYCLES:
        built.notes.append(f"{path}: {count} cycles of {one.name} left out: too few")
        return
    place = {name: one.facts[name] for name in ("side", "fraction", "angle") if name in one.facts}
    loop = replace(choices.loop, push=replace(choices.loop.push, **place))
    since = number[late] - choices.first
    share = since / np.max(since) if choices.wear else None
    block = CyclePairBlock(
        "cycles", loop, pairs.theta[late], pairs.turn[late], _cycle_groups(count), share, choices.nodes
    )
    built.last_cycle = max(built.last_cycle, float(np.max(since)))
    built.add(path, block, f"{count} cycles of {one.name}" + (", wearing" if choices.wear else ""))


def _cycle_groups(count: int) -> NDArray[np.int64]:
    return blocks_of_cycles(count, min(max(count // _FEWEST_GROUPS, 1), _LONGEST_GROUP))


def _add_pushes(
    built: Built, path: Path, table: pandas.DataFrame, choices: BlockChoices, progress: Progress | None
) -> None:
    """Add ends and forces of recorded pushes."""
    repetition = table["repetition"].to_numpy(dtype=float)
    quasi_static = np.nan_to_num(table["acceleration"].to_numpy(dtype=float)) == 0.0
    early = repetition < choices.first
    built.left_out(path, +Counter({"pushed with acceleration": int(np.sum(~quasi_static & ~early))}))
    rows = table[quasi_static & ~early].to_dict("records")
    chosen = _thinned(rows, choices.most)
    if len(chosen) < len(rows):
        built.notes.append(f"{path}: every {len(rows) / len(chosen):.3g}th of {len(rows)} pushes taken")
    places: list[tuple[float, float]] = []
    pushes: list[MeasuredPush] = []
    records: list[PushRecord] = []
    for number, row in enumerate(chosen):
        record = read_push_file(row["path"])
        assert isinstance(record, PushRecord)
        if _is_straight(record):
            (x0, y0), (x1, y1) = record.tip_pose[[0, -1], 1:3].tolist()
            pushes.append(MeasuredPush(Pose(*record.start), Pose(*record.end), (x0, y0), (x1, y1), len(pushes)))
            places.append((row["side"], row["fraction"]))
            records.append(record)
        part_of(progress, number, len(chosen))(1.0)
    built.left_out(path, +Counter({"pushes whose tip did not go straight": len(chosen) - len(records)}))
    if records:
        _add_push_ends(built, path, _at_contacts(pushes, places), choices)
        _add_forces(built, path, records, choices)


def _is_straight(record: PushRecord) -> bool:
    place = record.tip_pose[:, 1:3] - record.tip_pose[0, 1:3]
    length = float(np.hypot(*place[-1]))
    if length <= _STRAIGHT:
        return False
    along = place[-1] / length
    return bool(np.max(np.abs(place @ (-along[1], along[0]))) <= _STRAIGHT)


def _at_contacts(pushes: Sequence[MeasuredPush], places: Sequence[tuple[float, float]]) -> list[MeasuredPush]:
    """Pushes grouped by contact (side, fraction) where there are many contacts, else by runs of repetitions."""
    known = sorted(set(places))
    if len(known) >= _FEWEST_CONTACTS and not any(math.isnan(number) for place in known for number in place):
        return [replace(push, contact=known.index(place)) for push, place in zip(pushes, places, strict=True)]
    groups = _cycle_groups(len(pushes)).tolist()
    return [replace(push, contact=group) for push, group in zip(pushes, groups, strict=True)]


def _with_contacts_apart(parts: Sequence[Sequence[MeasuredPush]]) -> list[MeasuredPush]:
    """Pushes of several selections, their contacts numbered on; each its own where there are few."""
    pushes, count = [], 0
    for part in parts:
        pushes += [replace(push, contact=count + push.contact) for push in part]
        count = max((push.contact for push in pushes), default=-1) + 1
    if count < _FEWEST_CONTACTS:
        return [replace(push, contact=number) for number, push in enumerate(pushes)]
    return pushes


def _add_push_ends(built: Built, path: Path, pushes: Sequence[MeasuredPush], choices: BlockChoices) -> None:
    kept = _thinned(pushes, choices.most)
    if kept:
        built.add(path, push_end_block(kept, choices.loop.slider), f"{_counted(len(kept), len(pushes))} push ends")


def _add_forces(built: Built, path: Path, records: Sequence[PushRecord], choices: BlockChoices) -> None:
    outline = choices.loop.slider.outline_points(360)
    sliding = sliding_forces([(record, outline) for record in records], choices.loop.pusher.radius)
    pieces = sliding.ratio.size
    if pieces < _FEWEST_PIECES:
        built.notes.append(f"{path}: forces not used: the rod slides in {pieces} pieces of pushes")
        return
    try:
        block = force_ratio_block(sliding)
    except InvalidInput as cause:
        built.notes.append(f"{path}: forces not used: {cause}")
        return
    built.add(path, block, f"{pieces} force ratios while the rod slides, in {len(np.unique(sliding.push))} pushes")


def _thinned(rows: Sequence[Any], most: int) -> list[Any]:
    """At most so many of the rows, evenly spread."""
    if len(rows) <= most:
        return list(rows)
    return [rows[k] for k in np.unique(np.linspace(0, len(rows) - 1, most).round().astype(int)).tolist()]


def _counted(kept: int, count: int) -> str:
    return str(kept) if kept == count else f"{kept} of {count}"
