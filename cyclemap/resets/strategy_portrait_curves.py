"""The curves of a strategy's portrait, ready to draw: every number that a picture of it shows is worked out here."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait_curves import CURVE_SAMPLES, TurnCurve, turn_curve
from cyclemap.maps.arcs import TWO_PI
from cyclemap.mechanics import SidePush
from cyclemap.resets.protocol.schedule_file import rod_start
from cyclemap.resets.strategies.cycle_action import CycleAction, Points
from cyclemap.resets.strategy_portrait import StrategyPortrait

Array = NDArray[np.float64]


@dataclass(frozen=True)
class DrawnPush:
    """A push in the object's frame: the start of the rod's centre (m), the unit vector of its way, its share."""

    start: tuple[float, float]
    direction: tuple[float, float]
    weight: float


@dataclass(frozen=True, eq=False)
class StrategyCurves:
    """All that is drawn of a strategy's portrait.

    turns : the turn of each action's map, the gripper's included. weights : of the actions. mean : theta and the mean
    turn over the law, each (n,), rad. density_theta, density : (n,) rad and (n,) per rad. pushed, farthest : numbers of
    pushes, and the largest total variation from uniform that any start leaves after them. outline : (m, 2), m, and
    hitch : of the object. pushes : distinct ones. drags : distinct way-points with their share. gripper : (k,), rad.
    """

    turns: tuple[TurnCurve, ...]
    weights: Array
    mean: tuple[Array, Array]
    density_theta: Array
    density: Array
    pushed: Array
    farthest: Array
    outline: Array
    hitch: tuple[float, float]
    pushes: tuple[DrawnPush, ...]
    drags: tuple[tuple[Points, float], ...]
    gripper: Array


def strategy_curves(portrait: StrategyPortrait) -> StrategyCurves:
    """Return the curves of `portrait`."""
    maps, theta = portrait.maps, np.linspace(0.0, TWO_PI, CURVE_SAMPLES + 1)
    actions = [action.filled(maps.loop) for action in maps.law.actions]
    farthest = portrait.scores.curve.total_variation
    slider = maps.loop.slider
    return StrategyCurves(
        turns=tuple(turn_curve(one) for one in maps.maps),
        weights=maps.weights,
        mean=(theta, mean_turns(portrait, theta)),
        density_theta=theta,
        density=portrait.scores.law.density(theta),
        pushed=np.arange(1.0, farthest.size + 1.0),
        farthest=farthest,
        outline=slider.outline_points(),
        hitch=slider.hitch,
        pushes=_pushes(maps.loop, actions, maps.weights.tolist()),
        drags=_drags(actions, maps.weights.tolist()),
        gripper=np.unique([action.turn for action in actions]),
    )


def mean_turns(portrait: StrategyPortrait, theta: Array) -> Array:
    """Return the mean over the law of the turn (rad) at orientations (n,)."""
    turns = [weight * one.turn(theta) for one, weight in zip(portrait.maps.maps, portrait.maps.weights, strict=True)]
    return np.asarray(np.sum(turns, axis=0))


def _pushes(loop: CollectionLoop, actions: list[CycleAction], weights: list[float]) -> tuple[DrawnPush, ...]:
    shares: dict[SidePush, float] = {}
    for action, weight in zip(actions, weights, strict=True):
        assert action.push is not None
        shares[action.push] = shares.get(action.push, 0.0) + weight
    return tuple(DrawnPush(*rod_start(loop, push), weight) for push, weight in shares.items())


def _drags(actions: Iterable[CycleAction], weights: list[float]) -> tuple[tuple[Points, float], ...]:
    shares: dict[Points, float] = {}
    for action, weight in zip(actions, weights, strict=True):
        assert action.way_points is not None
        shares[action.way_points] = shares.get(action.way_points, 0.0) + weight
    return tuple(shares.items())
