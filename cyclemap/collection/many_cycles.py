"""Cycles of many loops at once: any mixture of materials, protocols, objects and accuracies, in one call."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.checks import finite_array
from cyclemap.collection.cycle import Cycles
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics.cycle_batch import run_batch


def run_cycles(loops: Sequence[CollectionLoop], theta: ArrayLike) -> Cycles:
    """Run one push and reset of each of k loops from each of n orientations: `Cycles` with the axes (k, n).

    Parameters
    ----------
    loops : any mixture of materials, protocols, objects and accuracies.
    theta : (n,), rad, orientations that all loops start from, or (k, n), those of each.

    All of it is one call of the engine, on as many threads as CYCLEMAP_THREADS tells, else one a core; the results do
    not depend on how many, nor on what else is in the call: they are the numbers of `CollectionLoop.cycle` to the bit.

    Raises what `CollectionLoop.cycle` raises where a cycle is refused, telling which loop and orientation; InvalidInput
    for loops that are none, or thetas in another shape.

    >>> loops = [CollectionLoop.mit(material) for material in ("plywood", "delrin")]
    >>> np.degrees(run_cycles(loops, [0.0, 1.0, 2.0]).push_turn).round(2)
    array([[73.65, 73.93, 70.46],
           [71.82, 74.22, 71.53]])
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
    return Cycles.of_batch(values, run_batch(loops, values))
