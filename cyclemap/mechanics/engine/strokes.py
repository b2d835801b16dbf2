"""What the compiled engine reads, and its calls: pushes, drags and whole cycles of any loops, on
all cores.
"""

import ctypes
import os
import signal
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.mechanics.contact_curve import ContactCurve, CornerPiece, SidePiece
from cyclemap.mechanics.engine.library import load
from cyclemap.mechanics.engine.parts import NODE, PARTS, ROW, loads_of
from cyclemap.mechanics.engine.schema import (
    BALANCE,
    FRICTION,
    KINDS,
    LOOP,
    OBJECT,
    OUTPUT,
    PIECE,
    PRESSURE,
    QUADRATIC,
    RECORD,
    RESULT,
    TASK,
    Status,
)
from cyclemap.mechanics.footprint import Footprint
from cyclemap.mechanics.foundation import PressedFootprint
from cyclemap.mechanics.outline import Polygon

# What `cm_layout` of cycle.c must hold; a test compares them.
LAYOUT = tuple(each.dtype.itemsize for each in (PRESSURE, OBJECT, LOOP))
# Orientations over half a turn at which a foundation is balanced: in between, one correction by
# Newton's method leaves nothing.
BALANCE_ROWS = 720
# Threads that the engine may use, instead of one a core.
THREADS_VARIABLE = "CYCLEMAP_THREADS"
# Tasks for which a thread is worth its start.
_LEAST_SHARE = 4


@dataclass(frozen=True, eq=False)
class PressureTables:
    """A pressure as the engine sums over it, in extents: rows and nodes of all parts, and PRESSURE
    without addresses.
    """

    record: np.void
    rows: Array
    nodes: Array
    outline: Array = field(default_factory=lambda: np.zeros((0, 2)))
    balance: Array = field(default_factory=lambda: np.zeros((0, BALANCE.size)))


@lru_cache(maxsize=256)
def pressure_tables(footprint: Footprint) -> PressureTables:
    """Return the tables of a footprint; InvalidInput where its load cannot be balanced."""
    if isinstance(footprint, PressedFootprint):
        return _foundation_tables(footprint)
    loads, names = loads_of(footprint), [part.name for part in PARTS]
    rows = [loads.rows.get(name, np.zeros((0, ROW.size))) for name in names]
    nodes = [loads.nodes.get(name, np.zeros((0, NODE.size))) for name in names]
    record = np.zeros(1, PRESSURE.dtype)[0]
    record["load"] = [loads.shares.get(name, 0.0) for name in names]
    record["middle"], record["far"] = loads.middle, loads.far
    record["first_row"], record["first_node"] = (
        np.cumsum([0, *map(len, tables)]) for tables in (rows, nodes)
    )
    return PressureTables(record, np.concatenate(rows), np.concatenate(nodes))


def _foundation_tables(footprint: PressedFootprint) -> PressureTables:
    """The tables of a foundation that is pressed: its outline, and how it balances over half a
    turn.
    """
    size, outline = footprint.extent, footprint.outline
    middle = np.array(outline.centroid) / size
    record = np.zeros(1, PRESSURE.dtype)[0]
    record["middle"], record["far"] = middle, np.inf
    record["plate"], record["floor"] = footprint.plate_bend, footprint.floor_bend
    record["centre"] = np.array(footprint.centre) / size - middle
    record["table_count"] = BALANCE_ROWS
    if isinstance(outline, Polygon):
        boundary = np.ascontiguousarray(outline.array / size - middle)
        record["side_count"] = len(boundary)
    else:
        boundary = np.array([(outline.semi_x, outline.semi_y)]) / size
    record["reach"] = np.max(np.sum(boundary**2, axis=1))
    record["field"] = footprint.field_bend.ravel()
    record["field_reach"] = 0.0 if footprint.field is None else footprint.field.reach / size
    balance = np.zeros((BALANCE_ROWS, BALANCE.size))
    none = np.zeros((0, ROW.size)), np.zeros((0, NODE.size))
    tables = PressureTables(record, *none, boundary, balance)
    packed = np.array(_addressed(tables))
    if load().cm_balance(packed.ctypes.data, _address(balance)) < BALANCE_ROWS:
        raise InvalidInput(
            f"the load under {footprint.plate} on {footprint.floor} cannot be balanced: take "
            "smaller numbers for the shapes, or a simpler outline"
        )
    return tables


@dataclass(frozen=True, eq=False)
class Strokes:
    """What is done with an object: a push from a place of its contact curve, a drag through goals,
    or both.

    friction : numbers of LAW.
    pieces : of the contact curve, table as `piece_table` makes it, the ring last.
    direction : of the push, from the object's x axis if `with_object`, else from the world's.
    length : of the push, 0: none. Lengths in extents, friction in mean coefficients.
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
    """What came of tasks (n,): status (1: done, else why not), whether the rod left, whether
    another motion would have gone on, too, from a concave corner, and in extents and rad

    travel (n,) of the push, poses (n, 3) after it and at the end, the ring's way (n,); derivatives
    (n, 7, k) of both poses and the way by the k parameters. nan where not done.
    """

    status: NDArray[np.int64]
    left: NDArray[np.bool_]
    is_ambiguous: NDArray[np.bool_]
    travel: Array
    pushed: Array
    ended: Array
    way: Array
    derivatives: Array


def run(
    strokes: Sequence[Strokes], indices: NDArray[np.intp], poses: Array, varied: Array | None = None
) -> Ran:
    """Run tasks: strokes by their `indices` (n,) from poses (n, 3), in extents and rad; on all
    cores, interruptibly.

    varied : (n, 3, k), the poses' derivatives by the first k of PARAMETERS; None: none are wanted.
    """
    loops, held = _packed(strokes)
    tasks = np.column_stack([np.asarray(indices, float), poses])
    tasks = np.ascontiguousarray(tasks, dtype=float).reshape(-1, TASK.size)
    count = len(tasks)
    given = np.zeros((count, 3, 0)) if varied is None else np.ascontiguousarray(varied, dtype=float)
    derivatives = given.shape[2]
    results, by = np.empty((count, RESULT.size)), np.empty((count, OUTPUT.size, derivatives))
    queue, stop = ctypes.c_int64(0), ctypes.c_int64(0)
    library = load()

    def work() -> None:
        library.cm_run(
            *(loops.ctypes.data, _address(tasks), _address(given), count, derivatives),
            *(_address(results), _address(by), ctypes.byref(queue), ctypes.byref(stop)),
        )

    threads = min(thread_count(), -(-count // _LEAST_SHARE))
    # Ctrl-C raises in the main thread alone: a sweep's workers are spared handing their work to
    # another one.
    is_main = threading.current_thread() is threading.main_thread()
    hears_interrupts = is_main and signal.getsignal(signal.SIGINT) != signal.SIG_IGN
    if count <= _LEAST_SHARE or (threads == 1 and not hears_interrupts):
        work()
    else:
        _on_threads(threads, work, stop)
    del held
    columns = RESULT.columns_of(results)
    return Ran(
        status=columns.status.astype(np.int64),
        left=columns.has_left == 1.0,
        is_ambiguous=columns.is_ambiguous == 1.0,
        travel=columns.travel,
        pushed=columns.pushed,
        ended=columns.ended,
        way=columns.way,
        derivatives=by,
    )


def record(strokes: Strokes, pose: tuple[float, float, float], longest: float) -> Array:
    """Return the course of one task, rows (n, RECORD.size), from a pose in extents and rad.

    longest : bound on the spacing of rows, extents.

    Raises ConvergenceError where the motion cannot be followed in steps so short.
    """
    loops, held = _packed([strokes])
    task, room = np.array([0.0, *pose]), 512
    while True:
        rows = np.empty((room, RECORD.size))
        count = load().cm_record(loops.ctypes.data, _address(task), longest, _address(rows), room)
        if count != Status.RECORD_FULL:
            break
        room *= 4
    del held
    if count < 0:
        raise ConvergenceError("the motion's course cannot be followed: try another accuracy")
    return rows[:count]


def pressure_at(pressure: PressureTables, theta: float) -> Array:
    """Return the pressure of a foundation at an orientation, a row of QUADRATIC, in extents."""
    packed, quadratic = np.array(_addressed(pressure)), np.zeros(QUADRATIC.size)
    load().cm_press(packed.ctypes.data, theta, _address(quadratic))
    return quadratic


def friction_values(
    pressure: PressureTables, theta: float, matrix: tuple[float, ...], twists: Array
) -> Array:
    """Return D, then FRICTION, (n, 10), at twists (n, 3) of an object that has turned by theta;
    `matrix`: M by columns.
    """
    packed = np.array(_addressed(pressure))
    given = np.array(matrix)
    twists = np.ascontiguousarray(twists)
    values = np.empty((len(twists), 1 + FRICTION.size))
    load().cm_friction(
        packed.ctypes.data,
        theta,
        *(_address(given), _address(twists), len(twists), _address(values)),
    )
    return values


def piece_table(curve: ContactCurve, hitch: tuple[float, float]) -> Array:
    """Return a contact curve as rows of PIECE: its pieces come first, then its wedges, the ring
    last.
    """
    junctions = enumerate(curve.junctions)
    ends = [index for index, junction in junctions if junction == "wedge"]
    rows = np.zeros((len(curve.pieces) + len(ends) + 1, PIECE.size))
    columns = PIECE.columns_of(rows)
    columns.low[:], columns.high[:], columns.before[:], columns.after[:] = -np.inf, np.inf, -1, -1
    kinds = list(KINDS)

    def write(row: int, kind: str, *geometry: float) -> None:
        columns.kind[row] = kinds.index(kind)
        columns.geometry[row, : len(geometry)] = geometry

    for index, piece in enumerate(curve.pieces):
        if isinstance(piece, SidePiece):
            write(index, "side", *piece.start, *piece.direction)
        elif isinstance(piece, CornerPiece):
            write(index, "corner", *piece.corner)
        else:
            write(index, "ellipse", piece.semi_x, piece.semi_y)
        columns.low[index], columns.high[index] = piece.low, piece.high
        columns.before[index], columns.after[index] = curve.before[index], curve.after[index]
    for wedge, index in enumerate(ends, len(curve.pieces)):
        (first, second), following = curve.contacts_at_end(index), curve.after[index]
        # The friction of a point lies between the outer edges of both cones.
        sense = 1.0 if curve.radius > 0.0 else -1.0
        write(wedge, "wedge", *first.rod_centre(curve.radius), first.normal, second.normal, sense)
        columns.before[wedge], columns.after[wedge] = index, following
        columns.after[index] = columns.before[following] = wedge
    write(-1, "ring", *hitch)
    return rows


def _packed(strokes: Sequence[Strokes]) -> tuple[NDArray[np.void], list[Array]]:
    """Strokes as the engine reads them, and the tables that must live as long."""
    loops, held = np.zeros(max(len(strokes), 1), LOOP.dtype), []
    for index, each in enumerate(strokes):
        goals = np.array(each.goals, dtype=float).reshape(-1, 2)
        held += [each.pieces, goals]
        law = each.friction, each.radius, each.tolerance
        pieces = len(each.pieces) - 1, _address(each.pieces)
        start = each.start_coordinate, each.by_fraction, each.direction, each.length
        loops[index] = (
            (_addressed(each.pressure), *law, *pieces),
            *(*start, each.rod_friction, each.pin_friction),
            *(each.start_piece, each.with_object, len(goals), _address(goals)),
        )
    return loops, held


def _addressed(tables: PressureTables) -> np.void:
    """A copy of the record with the addresses of both tables."""
    record = tables.record.copy()
    record["rows"], record["nodes"] = _address(tables.rows), _address(tables.nodes)
    record["outline"], record["table"] = _address(tables.outline), _address(tables.balance)
    return record


def _address(table: Array) -> int:
    assert table.flags.c_contiguous and table.dtype == np.float64
    return table.ctypes.data


def thread_count() -> int:
    """Return how many threads the engine may use: CYCLEMAP_THREADS, else one a core that this
    process may use.

    Raises InvalidInput where the variable is not a whole number of at least 1.
    """
    named = os.environ.get(THREADS_VARIABLE)
    if not named:
        return (
            len(os.sched_getaffinity(0))
            if hasattr(os, "sched_getaffinity")
            else os.cpu_count() or 1
        )
    if not (named.isascii() and named.isdecimal() and 1 <= len(named) <= 4 and int(named) >= 1):
        raise InvalidInput(
            f"{THREADS_VARIABLE} must be a whole number from 1 to 9999, not {named!r}"
        )
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
