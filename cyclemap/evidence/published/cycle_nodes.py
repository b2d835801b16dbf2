"""Cycles at a few orientations with their derivatives, and a Fourier series between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, read_only, whole_number
from cyclemap.collection import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.data_blocks.cycle_pair_block import cycles_by_unknowns
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters
from cyclemap.mechanics.cycle_batch import CYCLE_OUTPUTS

# What a node holds: the turn of the whole cycle (rad), then turn (rad) and displacement (m) of the push.
NODE_OUTPUTS = ("cycle_turn", "push_turn", "push_dx", "push_dy")
NODES = 47


@dataclass(frozen=True, eq=False)
class CycleNodes:
    """Cycles at orientations 2 pi k / m.

    values (m, 4) : NODE_OUTPUTS of each. jacobian (m, 4, k) : their derivatives by the k CYCLE_UNKNOWNS.
    """

    values: Array
    jacobian: Array

    def __post_init__(self) -> None:
        values = read_only(finite_array("values", self.values, last=len(NODE_OUTPUTS), ndim=2))
        if values.shape[0] % 2 == 0:
            raise InvalidInput(f"{values.shape[0]} nodes: their number must be odd, for a real Fourier series")
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "jacobian", read_only(self.jacobian))


def cycle_nodes(surface: SurfaceParameters, loop: CollectionLoop, count: int = NODES) -> CycleNodes:
    """Run `count` cycles (odd) of `loop` on an identified surface, with exact derivatives.

    Raises what the mechanics raise where they have no answer.
    """
    theta = 2.0 * np.pi * np.arange(whole_number("count", count, least=9)) / count
    runs, by_unknowns = cycles_by_unknowns(surface, loop, theta)
    values = np.column_stack([runs.theta_next[0] - theta, runs.push_turn[0], runs.push_displacement[0]])
    rows = [CYCLE_OUTPUTS.index(name) for name in ("theta_next", *NODE_OUTPUTS[1:])]
    return CycleNodes(values, by_unknowns[:, rows])


def node_values(loop: CollectionLoop, count: int = NODES) -> Array:
    """Run `count` cycles of a loop, evenly spread in orientation, and return their NODE_OUTPUTS (count, 4).

    >>> np.degrees(node_values(CollectionLoop.mit(), 9)[0, :2]).round(3)
    array([ 9.965, 73.653])
    """
    theta = 2.0 * np.pi * np.arange(whole_number("count", count, least=9)) / count
    runs = loop.cycles(theta)
    return np.column_stack([runs.theta_next - theta, runs.push_turn, runs.push_displacement])
