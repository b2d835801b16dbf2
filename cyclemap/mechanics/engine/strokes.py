"""Calls of the compiled engine: pushes, drags and whole cycles of any loops, on all cores."""

import ctypes
import os
import signal
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.errors import InvalidInput
from cyclemap.mechanics.contact_curve import ContactCurve
from cyclemap.mechanics.engine.library import load
from cyclemap.mechanics.pressure_tables import PARTS, ROW_COLUMNS, PressureTables

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
_TASK_COLUMNS, _RESULT_COLUMNS, _OUTPUTS, _RECORD_COLUMNS, _PIECE_COLUMNS = 4, 10, 7, 11, 10
# Threads that the engine may use, instead of one a core.
THREADS_VARIABLE = "CYCLEMAP_THREADS"
# Tasks for which a thread is worth its start.
_LEAST_SHARE = 4
_TABLE = ctypes.c_void_p


class _Pressure(ctypes.Structure):
    _fields_ = (
        ("load", ctypes.c_double * len(PARTS)),
        ("middle", ctypes.c_double * 2),
        ("far", ctypes.c_double),
        ("first_row", ctypes.c_int64 * (len(PARTS) + 1)),
        ("first_node", ctypes.c_int64 * (len(PARTS) + 1)),
        ("rows", _TABLE),
        ("nodes", _TABLE),
    )


class _Loop(ctypes.Structure):
    _fields_ = (
        ("pressure", _Pressure),
        ("friction", ctypes.c_double * 8),
        ("radius", ctypes.c_double),
        ("tolerance", ctypes.c_double),
        ("pieces", _TABLE),
        ("piece_count", ctypes.c_int64),
        ("start_piece", ctypes.c_int64),
        ("start_coordinate", ctypes.c_double),
        ("by_fraction", ctypes.c_double),
        ("direction", ctypes.c_double),
        ("length", ctypes.c_double),
        ("rod_friction", ctypes.c_double),
        ("pin_friction", ctypes.c_double),
        ("with_object", ctypes.c_int64),
        ("goal_count", ctypes.c_int64),
        ("goals", _TABLE),
    )


# What `cm_layout` of cycle.c must hold; a test compares them.
LAYOUT = (
    *(ctypes.sizeof(_Loop), _TASK_COLUMNS, _RESULT_COLUMNS, _OUTPUTS, _RECORD_COLUMNS, len(PARAMETERS)),
    *(ROW_COLUMNS, len(PARTS), _PIECE_COLUMNS),
)


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
    goals: tuple[tuple[float, float], ...]
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
            loops,
            _address(tasks),
            _address(given),
            ctypes.c_int64(count),
            ctypes.c_int64(derivatives),
            _address(results),
            _address(by),
            ctypes.byref(queue),
            ctypes.byref(stop),
        )

    threads = min(thread_count(), -(-count // _LEAST_SHARE))
    if count <= _LEAST_SHARE or (threads == 1 and not _hears_interrupts()):
        work()
    else:
        _on_threads(threads, work, stop)
    del held
    return Ran(
        results[:, 0].astype(np.int64), results[:, 1] == 1.0, results[:, 2], results[:, 3:6], results[:, 6:9],
        results[:, 9], by,
    )  # fmt: skip


def record(strokes: Strokes, pose: tuple[float, float, float], longest: float) -> Array:
    """Return the course of one task, rows (n, 11) as `record` of phase.c writes them, or the status as a number.

    Number of the stroke (0: the push), travel, the rod's place, theta, coordinate, piece, mode, compression and
    tangential force, residual of the balance.
    """
    loops, held = _packed([strokes])
    task, room = np.array([0.0, *pose]), 512
    while True:
        rows = np.empty((room, _RECORD_COLUMNS))
        found = load().cm_record(loops, _address(task), ctypes.c_double(longest), _address(rows), ctypes.c_int64(room))
        if found != RECORD_FULL:
            del held
            return rows[:found] if found >= 0 else np.array(float(found))
        room *= 4


def friction_values(pressure: PressureTables, matrix: tuple[float, ...], twists: Array) -> Array:
    """Return D, wrench and Hessian (xx, xy, yy, xw, yw, ww), (n, 10), at twists (n, 3); `matrix`: M by columns."""
    packed, given, twists = _pressure(pressure), np.array(matrix), np.ascontiguousarray(twists)
    values = np.empty((len(twists), 10))
    load().cm_friction(
        ctypes.byref(packed), _address(given), _address(twists), ctypes.c_int64(len(twists)), _address(values)
    )
    return values


def piece_table(curve: ContactCurve, hitch: tuple[float, float]) -> Array:
    """Return a contact curve as rows: kind, geometry 5, range, piece before, piece after.

    Its pieces come first, then its wedges, the ring last.
    """
    rows = []
    for index, piece in enumerate(curve.pieces):
        geometry = (*piece.geometry, *(0.0,) * (5 - len(piece.geometry)))
        ends = curve.before[index], curve.after[index]
        rows.append([KINDS.index(piece.kind), *geometry, piece.low, piece.high, *ends])
    for index in [i for i, junction in enumerate(curve.junctions) if junction == "wedge"]:
        (first, second), following = curve.contacts_at_end(index), curve.after[index]
        # The friction of a point lies between the outer edges of both cones.
        sense = 1.0 if curve.radius > 0.0 else -1.0
        place = (*first.rod_centre(curve.radius), first.normal, second.normal, sense)
        rows[index][-1] = rows[following][-2] = len(rows)
        rows.append([KINDS.index("wedge"), *place, -np.inf, np.inf, index, following])
    rows.append([KINDS.index("ring"), *hitch, 0.0, 0.0, 0.0, -np.inf, np.inf, -1, -1])
    return np.array(rows, dtype=float)


def _packed(strokes: Sequence[Strokes]) -> tuple[ctypes.Array[_Loop], list[Array]]:
    """Strokes as the engine reads them, and the tables that must live as long."""
    loops, held = (_Loop * max(len(strokes), 1))(), []
    for loop, one in zip(loops, strokes, strict=False):
        goals = np.array(one.goals, dtype=float).reshape(-1, 2)
        held += [one.pieces, goals]
        loop.pressure = _pressure(one.pressure)
        loop.friction[:7] = one.friction
        loop.pieces, loop.piece_count = _address(one.pieces), len(one.pieces) - 1
        loop.goals, loop.goal_count = _address(goals), len(goals)
        for name in ("radius", "tolerance", "start_coordinate", "by_fraction", "direction", "length"):
            setattr(loop, name, getattr(one, name))
        loop.start_piece, loop.with_object = one.start_piece, one.with_object
        loop.rod_friction, loop.pin_friction = one.rod_friction, one.pin_friction
    return loops, held


def _pressure(tables: PressureTables) -> _Pressure:
    packed = _Pressure(far=tables.far, rows=_address(tables.rows), nodes=_address(tables.nodes))
    packed.load[:], packed.middle[:] = tables.load, tables.middle
    packed.first_row[:], packed.first_node[:] = tables.first_row, tables.first_node
    return packed


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


def _hears_interrupts() -> bool:
    """Whether Ctrl-C raises in this thread: not in a sweep's workers, which are spared handing work to another one."""
    return threading.current_thread() is threading.main_thread() and signal.getsignal(signal.SIGINT) != signal.SIG_IGN


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
