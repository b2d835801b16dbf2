"""From files of measured data to the blocks that an identification takes, and a note on everything
left out.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cyclemap.arrays import Array, Place
from cyclemap.checks import whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.identification.data_block import DataBlock, usual_beliefs
from cyclemap.evidence.identification.session_blocks import (
    SessionBlock,
    Taken,
    Wanted,
    drag_blocks,
    named_blocks,
    odd_sessions,
    push_blocks,
    push_end_blocks,
    table_cycle_blocks,
    wrench_blocks,
)
from cyclemap.evidence.laws.push_sets import QUANTITIES
from cyclemap.evidence.motion_check import check_pushes
from cyclemap.evidence.predicted_strokes import loop_of_plate
from cyclemap.evidence.pushes.measured_strokes import (
    RowSelection,
    pushes_of,
    select_pushes,
    selected,
    session_name,
    told,
)
from cyclemap.evidence.pushes.push_table import PushTable, table_pushes
from cyclemap.evidence.tables.columns import (
    ENDS,
    FRAMES_AGREE,
    READ_ERRORS,
    RODS,
    Selection,
    convention_of,
    known_columns,
)
from cyclemap.evidence.tables.data_kinds import (
    CYCLES,
    DRAG_BACKS,
    PUSH_ENDS,
    RECORDS,
    SORT_COLUMNS,
    DataFile,
    files_of_data,
    recognise,
)
from cyclemap.mechanics import MIT_SHAPE_NAMES
from cyclemap.progress import Progress, part_of
from cyclemap.protocol.settings import OWN_OUTLINE
from cyclemap.text_files import file_stem

if TYPE_CHECKING:
    import pandas

MOST_STROKES = 2000
LAYOUTS = (
    "files of the MIT layout (.h5, .json), or a CSV table with the columns of poses "
    "(x0,y0,th0,x1,y1,th1), better with the tip (tip_x0,tip_y0,tip_x1,tip_y1), of drag-backs "
    "(x1,y1,th1,x0n,y0n,th0n), of orientations (theta0_deg), or of wrenches and twists "
    "(fx,fy,m_over_rho,vx,vy,w_times_rho)"
)
# Files of which the same is told are named one by one up to so many.
_MOST_NAMED = 3


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
    taken : sequence of SessionBlock
        The blocks of data as they were read.
    """

    blocks: tuple[DataBlock, ...]
    notes: tuple[str, ...]
    surface: str | None
    loop: CollectionLoop
    taken: Sequence[SessionBlock]

    @property
    def scans(self) -> Array | None:
        """Tractions of friction scans (n, 2), where there are any."""
        tractions = [row.scans for row in self.taken if row.scans is not None]
        return np.concatenate(tractions) if tractions else None

    @property
    def last_cycle(self) -> float:
        """How many the last cycle is behind the first; 0 where unknown."""
        return max(row.last_cycle for row in self.taken)

    @property
    def noise(self) -> dict[str, float]:
        """Sizes of the kinds of noise that all of their data tell."""
        sizes = dict[str, float]()
        for row in self.taken:
            for kind, size in row.noise.items():
                sizes[kind] = max(size, sizes.get(kind, 0.0))
        return {kind: size for kind, size in sizes.items() if math.isfinite(size)}

    def beliefs(self, names: Sequence[str]) -> dict[str, tuple[float, float]]:
        """Return what is usual of parameters (see `usual_beliefs`), and of how pushes were set
        up."""
        set_up = {name: belief for row in self.taken for name, belief in row.set_up.items()}
        return usual_beliefs(names) | {name: set_up[name] for name in names if name in set_up}


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
        where they are repeated), CSV tables of push ends (and cycles, where a column numbers
        them) with the tip's places or without (then it went as the loop's does, from its first
        touch on), of drag-backs, of orientations, of wrenches and twists.
    loop : CollectionLoop
        Who is pushed where, with which rod and ring.
    select : mapping of str to str or float or None, optional
        Values of surface, object, speed, side, fraction, angle (SI, rad) to keep. Objects are
        all those of the MIT dataset that the data name, or the selected one; of an outline of
        the loop's own, that one alone.
    first : int, default 0
        The first cycle (repetition) used, and the first push of those that are numbered.
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
    length = math.nan if push_length is None else push_length
    wanted = Wanted(first, wear, whole_number("most strokes", most, least=2), length, target)
    chosen = dict(select or {})
    plate = chosen.get("object")
    if isinstance(plate, str):
        loop = loop_of_plate(loop, plate)
    data = _Data(loop, RowSelection(_known_objects(loop, chosen), chosen), wanted)
    unused = data.add_paths(paths, progress)
    if len(data.surfaces) > 1:
        listed = ", ".join(sorted(data.surfaces))
        raise InvalidInput(f"the data are of several surfaces: {listed}; select one, surface=NAME")
    if len(data.objects) > 1 and loop.slider.name not in MIT_SHAPE_NAMES:
        listed = ", ".join(sorted(data.objects))
        raise InvalidInput(f"the data are of several objects: {listed}; select one")
    if first > data.last >= 0.0:
        raise InvalidInput(f"first is {first}: the last push is {data.last:g}; leave out fewer")
    if first and data.last < 0.0 and data.taken:
        raise InvalidInput(
            f"first is {first}: the data number no pushes: add a column rep, or leave --first out"
        )
    if not data.taken:
        reasons = joined_notes([*data.notes, *unused]) or tuple(map(str, paths))
        raise _nothing(reasons, loop, chosen, bool(unused))
    if wear and not any(row.last_cycle for row in data.taken):
        raise InvalidInput(
            "wear is that of cycles, and the data have none: number the pushes of a collection in "
            "a column rep, or leave --wear out"
        )
    odd, doubtful = odd_sessions(loop, data.taken)
    for session, reason in doubtful.items():
        data.notes.append((session, f"{reason}; nothing tells which of the two is odd"))
    for session, reason in odd.items():
        words = f"an odd session, {reason}: it does not count to the floor's mean"
        data.notes.append((session, words))
    others = [(about, f"not used: {reason}") for about, reason in unused]
    plates = {row.plate for row in data.taken}
    return CollectedBlocks(
        named_blocks(data.taken, [*odd], population),
        joined_notes([*data.notes, *others]),
        next(iter(data.surfaces), None),
        loop if len(plates) > 1 else loop_of_plate(loop, *plates),
        data.taken,
    )


@dataclass(eq=False)
class _Data:
    """The blocks of files read so far, and notes on what they hold and what stays out.

    loop, wanted : see `collected_blocks`.
    sessions : the file that a session is of, by its name and the sort of its data.
    filled : filled-in pushes by their numbers, and where each was read.
    surfaces, objects : that the data tell of.
    last : the largest number of a push, negative where they tell none.
    """

    loop: CollectionLoop
    selection: RowSelection
    wanted: Wanted
    notes: list[tuple[str, str]] = field(default_factory=list)
    taken: list[SessionBlock] = field(default_factory=list)
    sessions: dict[tuple[str, str], Path] = field(default_factory=dict)
    filled: dict[tuple[float, ...], str] = field(default_factory=dict)
    surfaces: set[str] = field(default_factory=set)
    objects: set[str] = field(default_factory=set)
    last: float = -1.0

    def add_paths(
        self, paths: Sequence[str | Path], progress: Progress | None
    ) -> list[tuple[str, str]]:
        """Add the blocks of all that paths hold; return the files of no use, with the reason."""
        files = list(dict.fromkeys(file for path in paths for file in files_of_data(path)))
        unused = []
        for index, file in enumerate(files):
            try:
                known = recognise(file)
            except DataFileError as error:
                unused.append((str(file), str(error).removeprefix(f"{file}").lstrip(":, ")))
                continue
            for row in known:
                self.add_file(row, part_of(progress, index, len(files)))
        return unused

    def add_file(self, file: DataFile, progress: Progress) -> None:
        """Add the blocks of one sort of data in a file, session by session."""
        about = str(file.path)
        pushes, reasons, moved = self._rows(file, part_of(progress, 0, 2))
        words = [f"{count} left out: {reason}" for reason, count in reasons.items()]
        if moved is not None:
            words += self._checked(file, moved)
        self.notes += [(about, note) for note in words]
        self.last = max(self.last, _last_number(pushes.table, file.sort == CYCLES))
        self.surfaces |= {*told(pushes.table["surface"]), *told(pushes.scans["surface"])}
        self.objects |= {*told(pushes.table["object"]), *told(pushes.scans["object"])}
        if len(self.surfaces) > 1:
            return
        tables = _by_session(pushes.table, self.loop.slider.name)
        scans = _by_session(pushes.scans, self.loop.slider.name)
        sessions = sorted({*tables, *scans})
        for index, (plate, speed) in enumerate(sessions):
            own = replace(
                pushes,
                table=tables.get((plate, speed), pushes.table[:0]),
                scans=scans.get((plate, speed), pushes.scans[:0]),
            )
            loop = loop_of_plate(self.loop, plate)
            name = self._session_name(file, plate, speed)
            done = part_of(part_of(progress, 1, 2), index, len(sessions))
            for row in self._blocks(file.sort, own, loop, done):
                if isinstance(row, str):
                    self.notes.append((about, row))
                else:
                    self.taken.append(replace(row, plate=plate, session=name))
                    self.notes.append((about, f"{row.words} of {plate}"))

    def _rows(
        self, file: DataFile, progress: Progress
    ) -> tuple[PushTable, Counter[str], PushTable | None]:
        """The rows of a file that take part, how many stay out, by reason, and the pushes whose
        motions bear out how it was read; None where there are none.
        """
        moved = None
        if file.table is None:
            pushes, reasons = select_pushes(file.path, self.selection, False, progress)
            moved = pushes
        elif file.sort in SORT_COLUMNS:
            every = known_columns(file.table, SORT_COLUMNS[file.sort])
            known = convention_of(file.path).rows(every)
            if file.sort == PUSH_ENDS:
                moved = table_pushes(file.table)
                known = _followed(known, moved)
            rows, reasons = selected(known, self.selection)
            pushes = PushTable(rows, rows[:0], ())
        else:
            reasons = Counter[str]()
            whole = table_pushes(file.table)
            kept = pushes_of(whole, self.selection, reasons)
            pushes = replace(kept, unreadable=whole.unreadable)
            moved = pushes
        for bad in pushes.unreadable[:1]:
            reasons[f"unreadable, the first {bad.path.name}: {bad.reason}"] = len(pushes.unreadable)
        return pushes, reasons, moved

    def _checked(self, file: DataFile, pushes: PushTable) -> tuple[str, ...]:
        """How pushes were read, and how well their motions bear that out."""
        words = check_pushes(pushes, self.loop)
        # A table that was planned tells its axes and angles.
        by_marks = file.table is not None and FRAMES_AGREE in file.table.header
        return () if by_marks else words

    def _session_name(self, file: DataFile, plate: str, speed: float) -> str:
        """The name of a session: its plate and speed, of orientations alone its file; empty where
        nothing tells.
        """
        if math.isinf(speed):
            if file.sort != CYCLES:
                return ""
            speed = math.nan
        session = session_name(plate, speed, file.path.stem)
        if self.sessions.setdefault((session, file.sort), file.path) != file.path:
            session += f", {file.path.stem}"
        return session

    def _blocks(
        self, sort: str, pushes: PushTable, loop: CollectionLoop, progress: Progress
    ) -> Taken:
        """What rows of one session tell."""
        wanted = self.wanted
        rows = pushes.table
        if sort == PUSH_ENDS:
            self._refuse_repeated(rows)
            first_set = 1 + sum(len(row.set_up) for row in self.taken) // 3
            ends = push_end_blocks(rows, loop, wanted, first_set)
            return chain(ends, table_cycle_blocks(rows, loop, wanted))
        if sort == DRAG_BACKS:
            return drag_blocks(rows, loop, wanted)
        if sort in SORT_COLUMNS:
            return wrench_blocks(rows, loop)
        return push_blocks(pushes, loop, wanted, sort == RECORDS, progress)

    def _refuse_repeated(self, rows: pandas.DataFrame) -> None:
        """Refuse a filled-in push that was read before, which would count twice: ten readings never
        come again.
        """
        if rows[[FRAMES_AGREE, *READ_ERRORS]].isna().all(axis=None):
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


def _last_number(rows: pandas.DataFrame, are_cycles: bool) -> float:
    """The largest number of a push, without end where the order of rows may tell it, negative where
    nothing does.
    """
    numbers = rows["repetition"].dropna()
    if len(numbers):
        return float(numbers.max())
    return math.inf if are_cycles and rows["theta_next"].notna().any() else -1.0


def _followed(rows: pandas.DataFrame, pushes: PushTable) -> pandas.DataFrame:
    """Rows of a table with what its pushes did, and what followed each of them."""
    by_line = pushes.table.set_index("line")[[*QUANTITIES, "theta_next", "length"]]
    following = by_line.reindex(rows["line"])
    return rows.assign(**{name: values.to_numpy() for name, values in following.items()})


def _by_session(rows: pandas.DataFrame, plate: str) -> dict[tuple[str, float], pandas.DataFrame]:
    """Rows by plate and speed, m/s: the plate given where they name none, and no end of speed where
    they tell none.
    """
    speeds = rows["speed"].astype(float).fillna(math.inf).round(9)
    names = [name if isinstance(name, str) and name else plate for name in rows["object"]]
    groups = rows.groupby([np.array(names, dtype=object), speeds.to_numpy()])
    return {owner: own.reset_index(drop=True) for owner, own in groups}


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
    plate = chosen.get("object")
    if isinstance(plate, str):
        return (plate,)
    name = loop.slider.name
    if name in MIT_SHAPE_NAMES:
        return MIT_SHAPE_NAMES
    return () if name == OWN_OUTLINE else (file_stem(name),)
