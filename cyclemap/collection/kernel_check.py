"""Whether cycles run in compiled code here, how fast, and whether they come to the numbers they should."""

import math
import statistics
import time
from dataclasses import dataclass

import numpy as np

from cyclemap.collection.loop import CollectionLoop
from cyclemap.mechanics.compiled.compiler import NoCompiler, find_compiler
from cyclemap.mechanics.compiled.cycle_batch import cycle_batch
from cyclemap.mechanics.compiled.stroke_runner import interpreted, prepare_kernels

# Turns (rad) of MIT's push on plywood and of the drag that follows, from theta = 0, by an independent solver.
REFERENCE = (math.radians(73.65314), math.radians(-63.68794))
# What the turns may be off that solver's, and compiled and interpreted cycles off each other, rad.
REFERENCE_ERROR, AGREEMENT = math.radians(1e-4), 1e-12

_TIMED = [0.3 * k for k in range(20)]


@dataclass(frozen=True)
class KernelCheck:
    """What was found.

    compiler : its command, None where there is none. refusal : why cycles are interpreted; empty where they are not.
    error : largest difference of the self-check's turns from their reference, rad. interpreted_seconds,
    compiled_seconds : median time of one cycle at an accuracy of 1e-8 rad; difference : of the two in theta_next at
    those orientations, rad. The latter two are None where cycles are interpreted.
    """

    compiler: str | None
    refusal: str
    error: float
    interpreted_seconds: float
    compiled_seconds: float | None
    difference: float | None

    @property
    def problems(self) -> tuple[str, ...]:
        """What should work and does not; a machine without a compiler is sound."""
        found = []
        if self.compiler is not None and self.refusal:
            found.append(f"a compiler is at hand, but: {self.refusal}")
        if not self.error <= REFERENCE_ERROR:
            found.append(f"the self-check's turns are {self.error:.2e} rad off their reference")
        if self.difference is not None and not self.difference <= AGREEMENT:
            found.append(f"compiled and interpreted cycles differ by {self.difference:.2e} rad")
        return tuple(found)


def check_kernels() -> KernelCheck:
    """Run MIT's loop on plywood in both ways; compiles the kernels where they are not kept yet.

    >>> check_kernels().problems
    ()
    """
    loop = CollectionLoop.mit()
    compiler, refusal = None, ""
    try:
        compiler = " ".join(find_compiler().command)
    except NoCompiler as reason:
        refusal = str(reason)
    assert loop.model.stroke_kind is not None
    refusal = refusal or prepare_kernels(loop.model.stroke_kind)
    with interpreted():
        slow, seen = _timed(loop)
    fast, told = None, seen
    if not refusal:
        batch = cycle_batch((loop,), np.array([_TIMED]), slopes=False)
        refusal = "" if batch.done.all() else "compiled code leaves cycles of MIT's loop to Python"
        fast, told = _timed(loop)[0], batch.theta_next[0].tolist()
    cycle = loop.cycle(0.0)
    error = max(abs(cycle.push_turn - REFERENCE[0]), abs(cycle.drag_turn - REFERENCE[1]))
    difference = None if refusal else max(abs(a - b) for a, b in zip(seen, told, strict=True))
    return KernelCheck(compiler, refusal, error, slow, None if refusal else fast, difference)


def _timed(loop: CollectionLoop) -> tuple[float, list[float]]:
    """Median time of a cycle, after one that is not counted, and theta_next."""
    loop.cycle(0.0)
    times, found = [], []
    for theta in _TIMED:
        start = time.perf_counter()
        found.append(loop.cycle(theta).theta_next)
        times.append(time.perf_counter() - start)
    return statistics.median(times), found
