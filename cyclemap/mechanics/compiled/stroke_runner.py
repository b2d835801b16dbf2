"""Runs strokes in compiled code, and whole cycles on all cores."""

import ctypes
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.compiled.compiler import COMPILER_VARIABLE, NoCompiler
from cyclemap.mechanics.compiled.library_cache import CACHE_VARIABLE, cached_library
from cyclemap.mechanics.compiled.stroke_library import KINDS, StrokeKind, stroke_source
from cyclemap.mechanics.compiled.threads import on_threads, thread_count
from cyclemap.mechanics.contact_curve import Piece
from cyclemap.mechanics.runge_kutta import STAGES

Array = NDArray[np.float64]

# Columns of what goes to C and comes back, as contact_motions.c names them.
STROKE_COLUMNS, RESULT_COLUMNS, PHASE_COLUMNS, ROW = 18, 11, 7, 11
STEP_COLUMNS = 2 + (STAGES + 1) * ROW
# The same of whole cycles, as stroke_cycles.c names them.
LOOP_COLUMNS, CYCLE_COLUMNS, CYCLE_RESULTS = 22, 2, 9
# Room for the record of one stroke; longer ones are left to Python.
_STEPS, _PHASES = 8192, 256
# Strokes asked for one at a time before a library is compiled for them: compiling takes as long as running so many. For
# each library that this process has compiled it takes so many times more: where every loop has an object of its own, as
# in a sweep over the centre of mass, libraries would cost more than they save.
WORTHWHILE, _DEARER = 250, 4
# A thread that has fewer cycles than this to run takes longer to start than it saves.
_LEAST_SHARE = 2
# Cycles that a thread runs before it looks whether it is interrupted.
_AT_ONCE = 256


class _Record(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_long) for name in ("most_steps", "most_phases", "steps", "phases")),
        *((name, ctypes.c_void_p) for name in ("step", "phase")),
    ]


@dataclass(frozen=True, eq=False)
class StrokeRunner:
    """The compiled strokes of one kind; safe to call from several threads at once."""

    library: ctypes.CDLL

    def run(self, pieces: Array, strokes: Array, tolerance: float, longest: float, vary: bool) -> Array:
        """Return results (n, RESULT_COLUMNS) of strokes (n, STROKE_COLUMNS) on a contact curve, row by row as in C."""
        strokes = np.ascontiguousarray(strokes)
        results = np.empty((len(strokes), RESULT_COLUMNS))
        self._call(pieces, strokes, tolerance, longest, vary, results, None)
        return results

    def run_cycles(self, loops: Array, pieces: Array, goals: Array, cycles: Array, vary: bool) -> Array:
        """Return results (n, CYCLE_RESULTS) of cycles (n, CYCLE_COLUMNS) of loops (k, LOOP_COLUMNS), on all cores."""
        count, results = len(cycles), np.empty((len(cycles), CYCLE_RESULTS))
        queue = ctypes.c_long(0)
        given = [_pointer(table) for table in (loops, pieces, goals, cycles)]
        to = (ctypes.c_long(count), ctypes.c_int(vary), _pointer(results), ctypes.byref(queue))

        def work() -> None:
            while queue.value < count:
                self.library.run_cycles(*given, *to, ctypes.c_long(_AT_ONCE))

        def stop() -> None:
            queue.value = count

        on_threads(min(thread_count(), max(1, count // _LEAST_SHARE)), work, stop)
        return results

    def recorded(self, pieces: Array, stroke: Array, tolerance: float, longest: float) -> tuple[Array, Array, Array]:
        """Return one stroke's result, its phases (k, PHASE_COLUMNS) and all of their steps (n, STEP_COLUMNS)."""
        result = np.empty(RESULT_COLUMNS)
        steps, phases = np.empty((_STEPS, STEP_COLUMNS)), np.empty((_PHASES, PHASE_COLUMNS))
        record = _Record(_STEPS, _PHASES, 0, 0, steps.ctypes.data, phases.ctypes.data)
        self._call(pieces, stroke[None], tolerance, longest, False, result, record)
        return result, phases[: record.phases], steps[: record.steps]

    def _call(
        self,
        pieces: Array,
        strokes: Array,
        tolerance: float,
        longest: float,
        vary: bool,
        results: Array,
        record: _Record | None,
    ) -> None:
        self.library.run_strokes(
            _pointer(pieces),
            ctypes.c_long(len(pieces)),
            _pointer(strokes),
            ctypes.c_long(len(strokes)),
            ctypes.c_double(tolerance),
            ctypes.c_double(longest),
            ctypes.c_int(vary),
            _pointer(results),
            ctypes.byref(record) if record is not None else None,
        )


def _pointer(table: Array) -> ctypes.c_void_p:
    """The place of a table's numbers, row by row; it keeps the table alive as long as it is itself."""
    assert table.flags.c_contiguous and table.dtype == np.float64
    return table.ctypes.data_as(ctypes.c_void_p)


@dataclass
class _Place:
    """What is known of one kind of stroke: its runner, or why there is none; how many strokes were asked for."""

    runner: StrokeRunner | None = None
    refusal: str = ""
    sought: bool = False
    asked: int = 0
    lock: threading.Lock = field(default_factory=threading.Lock)


def stroke_runner(stroke: StrokeKind, strokes: int = 1) -> StrokeRunner | None:
    """Return the compiled strokes of a kind, or None where there are none yet: `strokes` more of them are asked for.

    A library that is kept is loaded at once; one is compiled when WORTHWHILE strokes have been asked for, or more where
    this process has compiled others.
    """
    if _INTERPRETING.get():
        return None
    place = _place(stroke, *(os.environ.get(name) for name in (COMPILER_VARIABLE, "CC", CACHE_VARIABLE)))
    if place.runner is not None or place.refusal:
        return place.runner
    with place.lock:
        place.asked += strokes
        worthwhile = place.asked >= WORTHWHILE * _DEARER ** len(_compiled_here)
        if place.runner is None and not place.refusal and (worthwhile or not place.sought):
            place.sought = True
            try:
                place.runner = _loaded(stroke, worthwhile)
            except NoCompiler as reason:
                place.refusal = str(reason)
    return place.runner


_INTERPRETING = ContextVar("interpreting", default=False)


@contextmanager
def interpreted() -> Iterator[None]:
    """Within this, strokes are run by Python and CasADi's interpreter, whatever is compiled."""
    before = _INTERPRETING.set(True)
    try:
        yield
    finally:
        _INTERPRETING.reset(before)


def prepare_kernels(stroke: StrokeKind) -> str:
    """Compile and keep the strokes of a kind, unless they are kept; return why that cannot be, empty where it can."""
    try:
        _loaded(stroke, compile_now=True)
    except NoCompiler as reason:
        return str(reason)
    return ""


def _loaded(stroke: StrokeKind, compile_now: bool) -> StrokeRunner | None:
    def source() -> str:
        _compiled_here.append(stroke)
        return stroke_source(stroke)

    library = cached_library(repr(stroke), source if compile_now else None)
    return None if library is None else StrokeRunner(library)


# What this process has compiled.
_compiled_here: list[StrokeKind] = []


@lru_cache(maxsize=256)
def _place(stroke: StrokeKind, *environment: str | None) -> _Place:
    return _Place()


def piece_table(pieces: tuple[Piece, ...]) -> Array:
    """Return pieces of a contact curve as the rows that C reads: kind, geometry 5, low, high."""
    rows = [
        (KINDS.index(piece.kind), *piece.geometry, *(0.0,) * (5 - len(piece.geometry)), piece.low, piece.high)
        for piece in pieces
    ]
    return np.array(rows)
