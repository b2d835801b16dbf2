"""Families of strategies that a robot with the same rod and ring can do, ready to be searched."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_array, positive_number
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import SidePush
from cyclemap.resets.parameters.parameter_space import StrategyFamily
from cyclemap.resets.strategies.drag_strategies import GripperTurn, RingPlace, TrailingLeg, WayPoints
from cyclemap.resets.strategies.push_strategies import DrawnPushes
from cyclemap.resets.strategies.spread import Spread
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.suggestions import unknown_name

Array = NDArray[np.float64]
Range = tuple[float, float]

_HALF_TURN = math.pi
# What of a drawn push can be free, and within which bounds.
_PUSH_RANGES: dict[str, Range] = {"fraction": (0.05, 0.95), "angle": (-0.6, 0.6), "distance": (0.05, 0.2)}
_WEIGHT_RANGE = (0.02, 10.0)


def ring_family(reach: float = 0.03) -> StrategyFamily:
    """Return the rings at any place `hitch_x`, `hitch_y` (m) of the object's frame, each within `reach` (m) of 0.

    >>> ring_family().strategy((0.0, 0.02)).hitch
    (0.0, 0.02)
    """
    far = positive_number("reach", reach)
    names = ("hitch_x", "hitch_y")
    return StrategyFamily(
        "ring place", names, (-far, -far), (far, far), lambda v: RingPlace((float(v[0]), float(v[1])))
    )


def way_point_family(reach: float = 0.15) -> StrategyFamily:
    """Return the drags by one way-point `way_x`, `way_y` (m from the target), each within `reach` (m) of 0."""
    far = positive_number("reach", reach)
    names = ("way_x", "way_y")
    return StrategyFamily(
        "fixed way-point", names, (-far, -far), (far, far), lambda v: WayPoints(((float(v[0]), float(v[1])),))
    )


def fixed_leg_family(lengths: Range = (0.03, 0.2), side_steps: Range = (0.01, 0.15)) -> StrategyFamily:
    """Return the trailing legs of a fixed `length` (m), `direction` (rad) and `side_step` (m).

    Side steps of both signs are left out: at zero a way-point vanishes, and the orientation has a kink there.
    """
    lower, upper = (lengths[0], -_HALF_TURN, side_steps[0]), (lengths[1], _HALF_TURN, side_steps[1])

    def build(v: Array) -> ResetStrategy:
        return TrailingLeg(float(v[0]), float(v[1]), side_step=float(v[2]))

    return StrategyFamily("fixed leg", ("length", "direction", "side_step"), lower, upper, build)


def random_leg_family(lengths: Range = (0.03, 0.2), side_steps: Range | None = None) -> StrategyFamily:
    """Return the trailing legs in a uniformly random direction: `length` (m), and with a range also `side_step` (m).

    >>> random_leg_family(side_steps=(0.01, 0.1)).names
    ('length', 'side_step')
    """
    if side_steps is None:
        return StrategyFamily("random leg", ("length",), lengths[:1], lengths[1:], lambda v: TrailingLeg(float(v[0])))
    lower, upper = (lengths[0], side_steps[0]), (lengths[1], side_steps[1])

    def build(v: Array) -> ResetStrategy:
        return TrailingLeg(float(v[0]), side_step=float(v[1]))

    return StrategyFamily("random leg with side step", ("length", "side_step"), lower, upper, build)


def gripper_family(halfwidths: Range = (0.01, _HALF_TURN)) -> StrategyFamily:
    """Return the turns by a gripper drawn evenly from -`halfwidth` to `halfwidth` (rad): noise that is injected."""
    return StrategyFamily(
        "gripper's spread",
        ("halfwidth",),
        halfwidths[:1],
        halfwidths[1:],
        lambda v: GripperTurn(Spread.within(0.0, float(v[0]))),
    )


def drawn_push_family(
    pushes: Sequence[SidePush],
    vary: Sequence[str] = ("fraction",),
    weights: bool = False,
    ranges: Mapping[str, Range] | None = None,
) -> StrategyFamily:
    """Return the independent draws among these pushes, with what is named in `vary` of each free.

    vary : of `fraction` (.05 to .95), `angle` (rad, within .6) and `distance` (m, .05 to .2); names end in _1, _2, ...
    weights : whether the weights are free too: `weight_2`, ..., of the second push on, the first's being 1.
    ranges : other bounds, by the same names. A rod near a corner soon loses the object: its pushes are short ones.

    >>> family = drawn_push_family((SidePush(1), SidePush(2)), weights=True)
    >>> family.names, family.strategy((0.7, 0.7, 1.0)).weights
    (('fraction_1', 'fraction_2', 'weight_2'), (1.0, 1.0))
    """
    given, free, bounds = tuple(pushes), tuple(vary), _PUSH_RANGES | dict(ranges or {})
    for name in (*free, *bounds):
        if name not in _PUSH_RANGES:
            raise unknown_name("part of a push", name, tuple(_PUSH_RANGES))
    for name, ends in bounds.items():
        if finite_array(f"range of {name}", ends, ndim=1).size != 2:
            raise InvalidInput(f"range of {name} is {ends}: give its lower and its upper end")
    if not all(isinstance(push, SidePush) for push in given):
        raise InvalidInput(f"pushes must be SidePush, not {pushes!r}")
    if not given or not (free or weights):
        raise InvalidInput("a family of drawn pushes needs a push or more, and something that is free")
    pairs = [(f"{name}_{k + 1}", bounds[name]) for k in range(len(given)) for name in free]
    pairs += [(f"weight_{k + 1}", _WEIGHT_RANGE) for k in range(1, len(given)) if weights]

    def build(v: Array) -> ResetStrategy:
        rows = v[: len(given) * len(free)].reshape(len(given), len(free)).tolist()
        made = tuple(_changed(push, free, row) for push, row in zip(given, rows, strict=True))
        chances = (1.0, *v[len(given) * len(free) :].tolist()) if weights else None
        return DrawnPushes(made, weights=chances)

    names, limits = tuple(name for name, _ in pairs), [found for _, found in pairs]
    return StrategyFamily("drawn pushes", names, [low for low, _ in limits], [high for _, high in limits], build)


def _changed(push: SidePush, names: tuple[str, ...], values: list[float]) -> SidePush:
    changes: dict[str, Any] = dict(zip(names, values, strict=True))
    return replace(push, **changes)
