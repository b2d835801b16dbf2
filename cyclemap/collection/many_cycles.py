"""Cycles of many loops at once: any mixture of materials, protocols, objects and accuracies, in one call."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.checks import finite_array
from cyclemap.collection.cycle import Cycles, StrokePair
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.mechanics.compiled.cycle_batch import cycle_batch


def run_cycles(loops: Sequence[CollectionLoop], theta: ArrayLike) -> Cycles:
    """Run one push and reset of each of k loops from each of n orientations: `Cycles` with the axes (k, n).

    Parameters
    ----------
    loops : any mixture of materials, protocols, objects and accuracies.
    theta : (n,), rad, orientations that all loops start from, or (k, n), those of each.

    Where a C compiler is at hand all of it is one call of compiled code for every outline with its kind of footprint,
    on as many threads as CYCLEMAP_THREADS tells, else one a core; the results do not depend on how many, nor on what
    else is in the call. What compiled code cannot run (point rods, concave outlines) is run by Python.
    The numbers are those of `CollectionLoop.cycle`: to 1e-12 rad times the map's slope, on support points mostly.

    Raises what `CollectionLoop.cycle` raises where a cycle is refused, telling which loop and orientation; InvalidInput
    for loops that are none, or thetas in another shape.

    >>> loops = [CollectionLoop.mit(material) for material in ("plywood", "delrin")]
    >>> np.degrees(run_cycles(loops, [0.0, 1.0, 2.0]).push_turn).round(2)
    array([[73.65, 73.93, 70.46],
           [69.79, 72.71, 70.94]])
    """
    for number, loop in enumerate(loops):
        if not isinstance(loop, CollectionLoop):
            raise InvalidInput(f"loop {number} must be a CollectionLoop, not {loop!r}")
    values = finite_array("theta", theta)
    if values.ndim not in (1, 2) or (values.ndim == 2 and len(values) != len(loops)):
        raise InvalidInput(
            f"theta must have shape (n,) for all loops or ({len(loops)}, n), one row a loop, not {values.shape}"
        )
    values = np.broadcast_to(values, (len(loops), values.shape[-1])).copy()
    batch = cycle_batch(loops, values, slopes=False)

    def run(index: int) -> StrokePair[Any, Any]:
        number = index // values.shape[1]
        return _run_one(number, loops[number], float(values.flat[index]))

    return Cycles.of_batch(values, batch, run)


def _run_one(number: int, loop: CollectionLoop, theta: float) -> StrokePair[Any, Any]:
    try:
        return loop.cycle(theta)
    except CycleMapError as error:
        raise type(error)(f"loop {number} from theta = {theta!r} rad: {error}") from error
