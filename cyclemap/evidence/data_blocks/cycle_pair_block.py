"""The block of measured cycles: next orientation over orientation, predicted by push and drag together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, whole_number
from cyclemap.collection import CollectionLoop
from cyclemap.collection.settings import with_material
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import Kinds, Labels, Values, checked_labels, set_fields
from cyclemap.evidence.identification.surface_parameters import (
    FRICTION_NAMES,
    SHARE_NAMES,
    SURFACE,
    Parameter,
    SurfaceParameters,
    possible_names,
    share_names,
)
from cyclemap.mechanics import FoundWith, Material, PlatePressure
from cyclemap.mechanics.cycle_batch import CYCLE_OUTPUTS, CycleBatch, run_batch
from cyclemap.mechanics.engine.strokes import PARAMETERS

Rows = tuple[Array, Array]
SHAPE = SURFACE.names[1:5]
CYCLE_UNKNOWNS = (*SHAPE, "pusher_friction", *SHARE_NAMES, "pin_friction_radius")
# Cycles are computed at this many angles and interpolated between by a Fourier series.
NODES = 48
ACCURACY = 1e-6


def interpolation(theta: ArrayLike, count: int) -> Array:
    """Return the matrix (n, count) from values at 2 pi k / count to the Fourier series through them at theta (n,), rad.

    >>> nodes = 2 * np.pi * np.arange(5) / 5
    >>> bool(np.allclose(interpolation([0.3], 5) @ np.cos(2 * nodes), np.cos(0.6)))
    True
    """
    off = finite_array("theta", theta, ndim=1)[:, np.newaxis] - 2.0 * np.pi * np.arange(count) / count
    orders = np.arange(1, (count - 1) // 2 + 1, dtype=float)
    return np.asarray((1.0 + 2.0 * np.cos(off[..., np.newaxis] * orders).sum(axis=-1)) / count)


@dataclass(frozen=True, eq=False)
class CyclePairBlock:
    """Measured turns of whole cycles, rad, set against the cycle map of a loop.

    loop : who is pushed where, and how it is brought back; surface, pusher friction, rim share and ring are the
        unknowns'. theta, turn (n,) : rad, orientation before a push and how far the cycle turned the object.
    groups (n,) : labels of rows. share (n,) or None : how worn the surface was, 0 fresh to 1 at the end of the data;
        the turn is then blended linearly between the two, its ends having an ellipse each, the worn one's `worn_...`.
    nodes : angles at which cycles are computed; between them a trigonometric polynomial, so the map must be smooth.

    Raises InvalidInput where shapes differ or nothing is given.
    """

    name: str
    loop: CollectionLoop
    theta: Array
    turn: Array
    groups: Labels
    share: Array | None = None
    nodes: int = NODES
    parameters: tuple[str, ...] = field(init=False)
    own_parameters: tuple[Parameter, ...] = field(init=False)
    kinds: Kinds = field(init=False)

    def __post_init__(self) -> None:
        theta, turn = finite_array("theta", self.theta, ndim=1), finite_array("turn", self.turn, ndim=1)
        if theta.size == 0 or turn.shape != theta.shape:
            raise InvalidInput(f"{theta.size} orientations and {turn.size} turns: give one turn for each, one at least")
        whole_number("nodes", self.nodes, least=9)
        worn: list[Parameter] = []
        if self.share is not None:
            share = finite_array("share of wear", self.share, ndim=1)
            if share.shape != theta.shape or share.min() < 0.0 or share.max() > 1.0:
                raise InvalidInput("the share of wear must be a number from 0 to 1 for each cycle")
            set_fields(self, share=share)
            late = "at the end of the data"
            fresh = (SURFACE[name] for name in SHAPE)
            worn = [replace(x, name=f"worn_{x.name}", description=f"{x.description}, {late}") for x in fresh]
        asked = possible_names((*CYCLE_UNKNOWNS, *(one.name for one in worn)), self.loop.slider.outline)
        groups = checked_labels(self.name, self.groups, theta.size)
        set_fields(self, theta=theta, turn=turn, groups=groups, parameters=asked, own_parameters=tuple(worn))
        set_fields(self, kinds=np.repeat(np.array(["cycle turn (rad)"]), theta.size))

    def residuals(self, values: Values) -> Rows:
        """Return predicted minus measured turns, and their derivatives."""
        (turn, jacobian), names = self._predicted(values), (*CYCLE_UNKNOWNS, *(x.name for x in self.own_parameters))
        jacobian = np.hstack([jacobian, np.zeros((turn.size, len(self.own_parameters)))])
        if self.share is not None:
            turn_worn, by_worn = self._predicted({**values, **{name: values[f"worn_{name}"] for name in SHAPE}})
            share = self.share[:, np.newaxis]
            turn = turn + self.share * (turn_worn - turn)
            kept, shape = len(CYCLE_UNKNOWNS), len(SHAPE)
            jacobian *= 1.0 - share
            jacobian[:, shape:kept] += share * by_worn[:, shape:]
            jacobian[:, kept:] = share * by_worn[:, :shape]
        return turn - self.turn, jacobian[:, [names.index(name) for name in self.parameters]]

    def subset(self, keep_groups: ArrayLike) -> CyclePairBlock:
        """Return the block with the rows of some groups only."""
        keep = np.isin(self.groups, keep_groups)
        share = None if self.share is None else self.share[keep]
        return replace(self, theta=self.theta[keep], turn=self.turn[keep], groups=self.groups[keep], share=share)

    def _predicted(self, values: Mapping[str, float]) -> Rows:
        """Turns (n,) on one surface and their derivatives by CYCLE_UNKNOWNS, between an odd number of nodes."""
        theta = 2.0 * np.pi * np.arange(self._between.shape[1]) / self._between.shape[1]
        runs, by_unknowns = cycles_by_unknowns(SurfaceParameters.from_values(values), self.loop, theta)
        by_next = by_unknowns[:, CYCLE_OUTPUTS.index("theta_next")]
        return self._between @ (runs.theta_next[0] - theta), self._between @ by_next

    @cached_property
    def _between(self) -> Array:
        return interpolation(self.theta, self.nodes - 1 + self.nodes % 2)


def cycles_by_unknowns(surface: SurfaceParameters, loop: CollectionLoop, theta: Array) -> tuple[CycleBatch, Array]:
    """Run cycles of the loop on an identified surface from theta (n,), rad; with d CYCLE_OUTPUTS / d CYCLE_UNKNOWNS.

    The batch has the shape (1, n), the derivatives (n, 6, k).
    """
    names = (*FRICTION_NAMES, "pusher_friction", *share_names(loop.slider.outline), "pin_friction_radius")
    runs = run_batch((loop_on(surface, loop),), theta[None], len(PARAMETERS))
    by_mechanics = runs.jacobian[0][:, :, [PARAMETERS.index(name) for name in names]]
    return runs, surface.chain(by_mechanics, names, CYCLE_UNKNOWNS)


def loop_on(surface: SurfaceParameters, loop: CollectionLoop) -> CollectionLoop:
    """Return the loop on an identified surface, with the rod, rim and ring that were identified along with it."""
    shares = {name: share for name, share in surface.shares.items() if name in share_names(loop.slider.outline)}
    plate = PlatePressure(loop.slider.name, **shares)
    found = FoundWith(surface.pusher_friction, surface.pin_friction_radius)
    material = Material("identified", surface.to_friction(), found_with=found, plates=(plate,))
    return with_material(replace(loop, accuracy=ACCURACY), material)
