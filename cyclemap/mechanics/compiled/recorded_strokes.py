"""One compiled stroke with its phases, as push_run.py and event_integration.py tell them."""

import math
from collections.abc import Iterator, Sequence
from typing import overload

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.compiled.stroke_library import StrokeKind
from cyclemap.mechanics.compiled.stroke_runner import STROKE_COLUMNS, StrokeRunner, piece_table, stroke_runner
from cyclemap.mechanics.contact_curve import OutlinePiece, Piece, RingPiece
from cyclemap.mechanics.contact_solver import ContactSolver
from cyclemap.mechanics.event_integration import Phase
from cyclemap.mechanics.footprint import Footprint, PointFootprint
from cyclemap.mechanics.motion import (
    RING,
    RING_LEFT,
    RING_RIGHT,
    RING_STUCK,
    SLIDE_FREE,
    SLIDE_LEFT,
    SLIDE_RIGHT,
    STICK,
    Motion,
    Rod,
    motion_parameters,
)
from cyclemap.mechanics.pressure_family import PressureFamily
from cyclemap.mechanics.push_run import PushRun, PushStart, RunPhase
from cyclemap.mechanics.runge_kutta import STAGES, UNKNOWN, Step

Array = NDArray[np.float64]

# Modes by their numbers in C.
MODES = (STICK, SLIDE_LEFT, SLIDE_RIGHT, SLIDE_FREE, RING, RING_LEFT, RING_RIGHT, RING_STUCK)


# Every call works on some 200 bytes a point of the thread's stack.
_MOST_POINTS = 1000


def stroke_kind(footprint: Footprint, pieces: tuple[OutlinePiece, ...], radius: float) -> StrokeKind | None:
    """Return the kind of strokes of a normalised footprint on a contact curve, None where only Python can run them.

    Those are of point rods, concave outlines, and more support points than compiled code has room for.
    """
    if radius == 0.0 or (isinstance(footprint, PointFootprint) and len(footprint.positions) > _MOST_POINTS):
        return None
    kinds = [piece.kind for piece in pieces]
    neighbours = zip(kinds, kinds[1:] + kinds[:1], strict=True)
    if kinds != ["ellipse"] and any(one == other == "side" for one, other in neighbours):
        return None
    return StrokeKind(PressureFamily.of(footprint), tuple(sorted(set(kinds))))


def stroke_row(solver: ContactSolver, rod: Rod, start: PushStart, length: float) -> Array:
    """Return a stroke as the row that C reads, without a variation."""
    parameters = motion_parameters(solver, RingPiece((0.0, 0.0)), SLIDE_LEFT, rod)[:11]
    parameters[1] = rod.radius
    row = np.zeros(STROKE_COLUMNS)
    row[:4], row[7:] = (start.piece, start.coordinate, start.theta, length), parameters
    return row


def recorded_push(
    kind: StrokeKind | None,
    solver: ContactSolver,
    pieces: tuple[OutlinePiece, ...],
    start: PushStart,
    rod: Rod,
    length: float,
    tolerance: float,
    longest: float = math.inf,
) -> PushRun | None:
    """Return what `run_push` returns for a model whose strokes are of a `kind`, or None where that is left to it."""
    runner = None if kind is None else stroke_runner(kind)
    if runner is None:
        return None
    result, phases = _recorded(runner, solver, pieces, start, rod, length, tolerance, longest)
    if not result[0]:
        return None
    return PushRun(phases, result[1:3].copy(), "left" if result[5] else "distance")


def recorded_leg(
    kind: StrokeKind | None,
    solver: ContactSolver,
    piece: RingPiece,
    theta: float,
    rod: Rod,
    length: float,
    tolerance: float,
    longest: float,
) -> RunPhase | None:
    """Return one leg of a drag of a model whose strokes are of a `kind`, or None where Python has to run it."""
    runner = None if kind is None else stroke_runner(kind)
    if runner is None:
        return None
    start = PushStart(0, 0.0, theta)
    result, phases = _recorded(runner, solver, (piece,), start, rod, length, tolerance, longest)
    return phases[0] if result[0] else None


def _recorded(
    runner: StrokeRunner,
    solver: ContactSolver,
    pieces: tuple[Piece, ...],
    start: PushStart,
    rod: Rod,
    length: float,
    tolerance: float,
    longest: float,
) -> tuple[Array, tuple[RunPhase, ...]]:
    row = stroke_row(solver, rod, start, length)
    result, phases, steps = runner.recorded(piece_table(pieces), row, tolerance, longest)
    return result, tuple(_phases(solver, pieces, rod, phases, steps)) if result[0] else ()


class _RecordedSteps(Sequence[Step]):
    """The steps of a phase as C wrote them, made when they are asked for."""

    def __init__(self, rows: Array, columns: int) -> None:
        self.lengths: list[float] = rows[:, 0].tolist()
        self._rows, self._columns = rows, columns

    def __len__(self) -> int:
        return len(self.lengths)

    @overload
    def __getitem__(self, index: int) -> Step: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[Step]: ...

    def __getitem__(self, index: int | slice) -> Step | Sequence[Step]:
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(len(self)))]
        row = self._rows[index]
        return Step(self.lengths[index], row[2:].reshape(STAGES + 1, -1)[:, : self._columns].copy(), float(row[1]))


class _RecordedPhase(Phase):
    """A phase whose length needs none of its steps."""

    @property
    def length(self) -> float:
        """Rod travel over the stretch."""
        assert isinstance(self.steps, _RecordedSteps)
        return math.fsum(self.steps.lengths)


def _phases(
    solver: ContactSolver, pieces: tuple[Piece, ...], rod: Rod, phases: Array, steps: Array
) -> Iterator[RunPhase]:
    steps, first = steps.copy(), 0
    for mode, piece, broken, next_h, count, theta, coordinate in phases.tolist():
        motion = Motion(solver, pieces[int(piece)], MODES[int(mode)], rod)
        last, columns = first + int(count), UNKNOWN.start + len(motion.unknowns)
        taken = _RecordedSteps(steps[first:last], columns)
        motion.unknowns = taken[-1].stages[-1, UNKNOWN].tolist()
        phase = _RecordedPhase(taken, None if broken < 0 else int(broken), next_h)
        yield RunPhase(motion, np.array((theta, coordinate)), phase)
        first = last
