"""Cycles at a few orientations with their derivatives, and a Fourier series between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_array, read_only, whole_number
from cyclemap.collection import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.data_blocks.cycle_pair_block import CYCLE_UNKNOWNS, loop_on
from cyclemap.evidence.identification.surface_parameters import FRICTION_NAMES, HITCH_NAMES, SurfaceParameters

Array = NDArray[np.float64]

# What a node holds: the turn of the whole cycle (rad), then turn (rad) and displacement (m) of the push.
NODE_OUTPUTS = ("cycle_turn", "push_turn", "push_dx", "push_dy")
NODES = 47
_MECHANICS = (*FRICTION_NAMES, "pusher_friction", "rim_share", *HITCH_NAMES, "pin_friction_radius")


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
    """Run `count` cycles (odd) of `loop` on an identified surface, with exact derivatives (`loop.sensitivity`).

    Raises what the mechanics raise where they have no answer.
    """
    real = loop_on(surface, loop)
    theta = 2.0 * np.pi * np.arange(whole_number("count", count, least=9)) / count
    found = [real.sensitivity(angle, _MECHANICS) for angle in theta.tolist()]
    values = node_values(real, count)
    names = ("theta_next", *NODE_OUTPUTS[1:])
    rows = [[one.jacobian[one.outputs.index(name)] for name in names] for one in found]
    return CycleNodes(values, surface.chain(np.array(rows), _MECHANICS, CYCLE_UNKNOWNS, hitch=loop.slider.hitch))


def node_values(loop: CollectionLoop, count: int = NODES) -> Array:
    """Run `count` cycles of a loop, evenly spread in orientation, and return their NODE_OUTPUTS (count, 4).

    >>> np.degrees(node_values(CollectionLoop.mit(), 9)[0, :2]).round(3)
    array([ 9.965, 73.653])
    """
    theta = 2.0 * np.pi * np.arange(whole_number("count", count, least=9)) / count
    runs = loop.cycles(theta)
    return np.column_stack([runs.theta_next - theta, runs.push_turn, runs.push_displacement])
