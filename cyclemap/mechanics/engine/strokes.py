"""What the compiled engine reads, and its calls: pushes, drags and whole cycles of any loops, on all cores."""

import ctypes
import os
import signal
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.arrays import Array
from cyclemap.errors import InvalidInput
from cyclemap.mechanics.contact_curve import ContactCurve, CornerPiece, SidePiece
from cyclemap.mechanics.engine.library import load
from cyclemap.mechanics.footprint import INNER, Footprint, PatchFootprint, PointFootprint, side_arms
from cyclemap.mechanics.outline import Ellipse, Polygon, area_quadrature

# What a cycle can be differentiated by, in the order of cycle.c: angles in rad, lengths in extents, shares.
PARAMETERS = (
    *("theta", "mu_a", "mu_b", "m0", "n0", "phi", "pusher_friction", "pusher_radius", "fraction", "angle", "distance"),
    *("hitch_x", "hitch_y", "inner_share", "rim_share", "corner_share", "pin_friction_radius"),
)
# Kinds of pieces of a contact curve, and modes, in the order of the engine.
KINDS = ("side", "corner", "ellipse", "ring", "wedge")
MODES = (
    *("stick", "slide_left", "slide_right", "slide_free", "ring", "ring_left", "ring_right", "ring_stuck"),
    *("wedge_left", "wedge_right", "wedge_stuck"),
)
# Why a stroke cannot be run, as cycle.c and contact.c number it.
UNSOLVED, MANY_STEPS, NO_SLIP, POINTS_AWAY, NOT_ALONE, RING_STOPS, CHATTERS, RECORD_FULL, STOPPED = range(-1, -10, -1)
# Kinds of pieces of a pressure (its parts: even, inner, rim, corners, leaning, balance), in the order of pressure.c.
EDGE, LEAN, LINE, POINT, CHORD, ARC = range(6)
# Centres of rotation farther than this, in extents in the velocity plane, are summed by Gauss's rule of this order: it
# has more digits there than closed forms (tests/mechanics/test_pressure.py measures both). What leans cancels more.
_FAR, _FAR_ORDER, _LEANING_FAR, _LEANING_ORDER = 8.0, 6, 3.0, 12
_LINE_ORDER = 12
# Columns of rows that the engine reads or writes, and its structures.
_TASK_COLUMNS, _RESULT_COLUMNS, _OUTPUTS, _RECORD_COLUMNS = 4, 10, 7, 15
_PIECE_COLUMNS, _ROW_COLUMNS, _PARTS = 10, 10, 6
_PRESSURE = np.dtype(
    [
        *(("load", "f8", _PARTS), ("middle", "f8", 2), ("far", "f8")),
        *(("first_row", "i8", _PARTS + 1), ("first_node", "i8", _PARTS + 1), ("rows", np.uintp), ("nodes", np.uintp)),
    ],
    align=True,
)
_LOOP = np.dtype(
    [
        *(("pressure", _PRESSURE), ("friction", "f8", 8), ("radius", "f8"), ("tolerance", "f8")),
        *(("pieces", np.uintp), ("piece_count", "i8"), ("start_piece", "i8"), ("start_coordinate", "f8")),
        *(("by_fraction", "f8"), ("direction", "f8"), ("length", "f8"), ("rod_friction", "f8"), ("pin_friction", "f8")),
        *(("with_object", "i8"), ("goal_count", "i8"), ("goals", np.uintp)),
    ],
    align=True,
)
# What `cm_layout` of cycle.c must hold; a test compares them.
LAYOUT = (
    *(_LOOP.itemsize, _TASK_COLUMNS, _RESULT_COLUMNS, _OUTPUTS, _RECORD_COLUMNS, len(PARAMETERS)),
    *(_ROW_COLUMNS, _PARTS, _PIECE_COLUMNS),
)
# Threads that the engine may use, instead of one a core.
THREADS_VARIABLE = "CYCLEMAP_THREADS"
# Tasks for which a thread is worth its start.
_LEAST_SHARE = 4


@dataclass(frozen=True, eq=False)
class PressureTables:
    """A pressure as pieces that the engine sums over: rows (n, 10) and nodes (m, 3: x, y, share), in extents.

    record : what else it reads, without their addresses: loads of the six parts; `middle`, the outline's centroid;
    `far`, from where on nodes are summed, infinite where rows always hold; part i has the rows first_row[i] to [i + 1],
    and alike its nodes.
    """

    record: np.void
    rows: Array
    nodes: Array


@lru_cache(maxsize=256)
def pressure_tables(footprint: Footprint) -> PressureTables:
    """Return the tables of a footprint."""
    size, none, middle, far = footprint.extent, np.zeros((0, _ROW_COLUMNS)), np.zeros(2), np.inf
    nodes = [np.zeros((0, 3))] * _PARTS
    if isinstance(footprint, PointFootprint):
        points, weights = footprint.quadrature
        load = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        rows = [_rows(POINT, weights, points / size), none, none, none, none, none]
    else:
        outline, middle = footprint.outline.scaled(1.0 / size), np.array(footprint.outline.centroid) / size
        leaning = size * np.asarray(footprint.gradient)
        shares = (footprint.even_share, footprint.inner_share, footprint.rim_share, footprint.corner_share)
        load = (*shares, float(np.any(leaning != 0.0)), 0.0)
        if isinstance(outline, Ellipse):
            inside, semi = outline.scaled(INNER), (outline.semi_x, outline.semi_y)
            rows = [
                _rows(CHORD, 1.0, [(*semi, *middle, 0.0, 0.0, 1.0)]),
                _rows(CHORD, 1.0, [(inside.semi_x, inside.semi_y, *middle, 0.0, 0.0, 1.0)]),
                _rows(ARC, 1.0, [(*semi, *middle)]),
                none,
                _rows(CHORD, 1.0, [(*semi, *middle, *leaning, 0.0)]),
                none,
            ]
        else:
            far, order = (_LEANING_FAR, _LEANING_ORDER) if load[4] else (_FAR, _FAR_ORDER)
            rows, nodes = _polygon_parts(footprint, outline, middle, order)
    first_row, first_node = (np.cumsum([0, *map(len, parts)]) for parts in (rows, nodes))
    record = np.array([(load, middle, far, first_row, first_node, 0, 0)], _PRESSURE)[0]
    return PressureTables(record, np.concatenate(rows), np.concatenate(nodes))


def _polygon_parts(
    footprint: PatchFootprint, outline: Polygon, middle: Array, order: int
) -> tuple[list[Array], list[Array]]:
    """Rows and nodes of each part under a polygon, in extents."""
    corners, per_area = outline.array, 1.0 / outline.area
    ends = np.hstack([corners, np.roll(corners, -1, axis=0)])
    points, shares = area_quadrature(outline, order)
    rows, nodes = [_rows(EDGE, per_area, ends)], [np.column_stack([points, shares])]
    if footprint.has_frame:
        inside = outline.scaled(INNER, outline.centroid)
        inner = np.hstack([inside.array, np.roll(inside.array, -1, axis=0)])
        # A line's load goes with the distance of its side from the centroid: the even form's derivative by the scale.
        arms = side_arms(outline)
        arms /= arms.sum()
        rows += [_rows(EDGE, 1.0 / inside.area, inner), _rows(LINE, arms, ends)]
        node, weight = np.polynomial.legendre.leggauss(_LINE_ORDER)
        along = (node[:, None, None] + 1.0) / 2.0
        spread = ((1.0 - along) * ends[:, :2] + along * ends[:, 2:]).reshape(-1, 2)
        nodes.append(np.column_stack(area_quadrature(inside, order)))
        nodes.append(np.column_stack([spread, np.outer(weight / 2.0, arms).ravel()]))
    else:
        rows += [np.zeros((0, _ROW_COLUMNS))] * 2
        nodes += [np.zeros((0, 3))] * 2
    rows.append(_rows(POINT, 1.0 / len(corners), corners))
    nodes.append(np.column_stack([corners, np.full(len(corners), 1.0 / len(corners))]))
    for slope in (footprint.extent * np.asarray(lean) for lean in (footprint.gradient, footprint.balance)):
        k, m = (len(ends), len(points)) if any(slope != 0.0) else (0, 0)
        rows.append(_rows(LEAN, per_area, np.hstack([ends[:k], np.tile((*slope, *middle), (k, 1))])))
        nodes.append(np.column_stack([points, shares * ((points - middle) @ slope)])[:m])
    return rows, nodes


def _rows(kind: int, load: ArrayLike, geometry: ArrayLike) -> Array:
    """Rows of one kind: the kind, the share of the part's load, and up to eight numbers of geometry."""
    numbers = np.asarray(geometry, dtype=float)
    rows = np.zeros((len(numbers), _ROW_COLUMNS))
    rows[:, 0], rows[:, 1] = kind, load
    rows[:, 2 : 2 + numbers.shape[1]] = numbers
    return rows


@dataclass(frozen=True, eq=False)
class Strokes:
    """What is done with an object: a push from a place of its contact curve, a drag through goals, or both.

    friction : (mu_a, mu_b, m0, n0, phi, centre of pressure x, y). pieces : of the contact curve, table as
    `piece_table` makes it, the ring last. direction : of the push, from the object's x axis if `with_object`, else from
    the world's. length : of the push, 0: none. Lengths in extents, friction in mean coefficients.
    """

    pressure: PressureTables
    friction: tuple[float, ...]
    radius: float
    tolerance: float
    pieces: Array
    goals: tuple[tuple[float, float], ...] = ()
    start_piece: int = 0
    start_coordinate: float = 0.0
    by_fraction: float = 0.0
    direction: float = 0.0
    length: float = 0.0
    rod_friction: float = 0.0
    pin_friction: float = 0.0
    with_object: bool = False


@dataclass(frozen=True, eq=False)
class Ran:
    """What came of tasks (n,): status (1: done, else why not), whether the rod left, and in extents and rad

    travel (n,) of the push, poses (n, 3) after it and at the end, the ring's way (n,); derivatives (n, 7, k) of both
    poses and the way by the k parameters. nan where not done.
    """

    status: NDArray[np.int64]
    left: NDArray[np.bool_]
    travel: Array
    pushed: Array
    ended: Array
    way: Array
    derivatives: Array


def run(strokes: Sequence[Strokes], number: NDArray[np.intp], poses: Array, varied: Array | None = None) -> Ran:
    """Run tasks: strokes by their `number` (n,) from poses (n, 3), in extents and rad; on all cores, interruptibly.

    varied : (n, 3, k), the poses' derivatives by the first k of PARAMETERS; None: none are wanted.
    """
    loops, held = _packed(strokes)
    tasks = np.column_stack([np.asarray(number, float), poses])
    tasks = np.ascontiguousarray(tasks, dtype=float).reshape(-1, _TASK_COLUMNS)
    count = len(tasks)
    given = np.zeros((count, 3, 0)) if varied is None else np.ascontiguousarray(varied, dtype=float)
    derivatives = given.shape[2]
    results, by = np.empty((count, _RESULT_COLUMNS)), np.empty((count, _OUTPUTS, derivatives))
    queue, stop = ctypes.c_int64(0), ctypes.c_int64(0)
    library = load()

    def work() -> None:
        library.cm_run(
            *(loops.ctypes.data, _address(tasks), _address(given), count, derivatives),
            *(_address(results), _address(by), ctypes.byref(queue), ctypes.byref(stop)),
        )

    threads = min(thread_count(), -(-count // _LEAST_SHARE))
    # Ctrl-C raises in the main thread alone: a sweep's workers are spared handing their work to another one.
    is_main = threading.current_thread() is threading.main_thread()
    hears_interrupts = is_main and signal.getsignal(signal.SIGINT) != signal.SIG_IGN
    if count <= _LEAST_SHARE or (threads == 1 and not hears_interrupts):
        work()
    else:
        _on_threads(threads, work, stop)
    del held
    return Ran(
        results[:, 0].astype(np.int64), results[:, 1] == 1.0, results[:, 2], results[:, 3:6], results[:, 6:9],
        results[:, 9], by,
    )  # fmt: skip


def record(strokes: Strokes, pose: tuple[float, float, float], longest: float) -> Array:
    """Return the course of one task, rows (n, 15) as `record` of phase.c writes them, or the status as a number.

    Number of the stroke (0: the push), travel, the rod's place, theta, coordinate, piece, mode, compression and
    tangential force, residual of the balance; point and outward normal of the contact in the object's frame.
    """
    loops, held = _packed([strokes])
    task, room = np.array([0.0, *pose]), 512
    while True:
        rows = np.empty((room, _RECORD_COLUMNS))
        found = load().cm_record(loops.ctypes.data, _address(task), longest, _address(rows), room)
        if found != RECORD_FULL:
            del held
            return rows[:found] if found >= 0 else np.array(float(found))
        room *= 4


def friction_values(pressure: PressureTables, matrix: tuple[float, ...], twists: Array) -> Array:
    """Return D, wrench and Hessian (xx, xy, yy, xw, yw, ww), (n, 10), at twists (n, 3); `matrix`: M by columns."""
    packed, given, twists = np.array(_addressed(pressure)), np.array(matrix), np.ascontiguousarray(twists)
    values = np.empty((len(twists), 10))
    load().cm_friction(packed.ctypes.data, _address(given), _address(twists), len(twists), _address(values))
    return values


def piece_table(curve: ContactCurve, hitch: tuple[float, float]) -> Array:
    """Return a contact curve as rows: kind, geometry 5, range, piece before, piece after.

    Its pieces come first, then its wedges, the ring last.
    """
    rows = []
    for index, piece in enumerate(curve.pieces):
        if isinstance(piece, SidePiece):
            numbers = [KINDS.index("side"), *piece.start, *piece.direction, piece.normal]
        elif isinstance(piece, CornerPiece):
            numbers = [KINDS.index("corner"), *piece.corner, 0.0, 0.0, 0.0]
        else:
            numbers = [KINDS.index("ellipse"), piece.semi_x, piece.semi_y, 0.0, 0.0, 0.0]
        rows.append([*numbers, piece.low, piece.high, curve.before[index], curve.after[index]])
    for index in [i for i, junction in enumerate(curve.junctions) if junction == "wedge"]:
        (first, second), following = curve.contacts_at_end(index), curve.after[index]
        # The friction of a point lies between the outer edges of both cones.
        sense = 1.0 if curve.radius > 0.0 else -1.0
        place = (*first.rod_centre(curve.radius), first.normal, second.normal, sense)
        rows[index][-1] = rows[following][-2] = len(rows)
        rows.append([KINDS.index("wedge"), *place, -np.inf, np.inf, index, following])
    rows.append([KINDS.index("ring"), *hitch, 0.0, 0.0, 0.0, -np.inf, np.inf, -1, -1])
    return np.array(rows, dtype=float)


def _packed(strokes: Sequence[Strokes]) -> tuple[NDArray[np.void], list[Array]]:
    """Strokes as the engine reads them, and the tables that must live as long."""
    loops, held = np.zeros(max(len(strokes), 1), _LOOP), []
    for index, one in enumerate(strokes):
        goals = np.array(one.goals, dtype=float).reshape(-1, 2)
        held += [one.pieces, goals]
        loops[index] = (
            *(_addressed(one.pressure), (*one.friction, 0.0), one.radius, one.tolerance),
            *(_address(one.pieces), len(one.pieces) - 1, one.start_piece, one.start_coordinate, one.by_fraction),
            *(one.direction, one.length, one.rod_friction, one.pin_friction, one.with_object),
            *(len(goals), _address(goals)),
        )
    return loops, held


def _addressed(tables: PressureTables) -> np.void:
    """A copy of the record with the addresses of both tables."""
    record = tables.record.copy()
    record["rows"], record["nodes"] = _address(tables.rows), _address(tables.nodes)
    return record


def _address(table: Array) -> int:
    assert table.flags.c_contiguous and table.dtype == np.float64
    return table.ctypes.data


def thread_count() -> int:
    """Return how many threads the engine may use: CYCLEMAP_THREADS, else one a core that this process may use.

    Raises InvalidInput where the variable is not a whole number of at least 1.
    """
    named = os.environ.get(THREADS_VARIABLE)
    if not named:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if not (named.isascii() and named.isdecimal() and 1 <= len(named) <= 4 and int(named) >= 1):
        raise InvalidInput(f"{THREADS_VARIABLE} must be a whole number from 1 to 9999, not {named!r}")
    return int(named)


def _on_threads(count: int, work: Callable[[], None], stop: ctypes.c_int64) -> None:
    """Run the same work on `count` threads; it shares itself out. An interrupt stops all of them.

    The calling thread waits: it could not be interrupted while it is at work below Python.
    """
    others = [_pool(count).submit(work) for _ in range(count)]
    try:
        # Signals reach Python between the waits.
        while wait(others, timeout=0.1).not_done:
            pass
    finally:
        stop.value = 1
        for other in others:
            if not other.cancel():
                other.result()


@lru_cache(maxsize=4)
def _pool(count: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(count, thread_name_prefix="cyclemap")


# Threads do not come along into a fork of the process.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)
