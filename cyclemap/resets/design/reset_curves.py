"""What a picture of a designed reset shows, worked out: laws, paths, maps and cycles, before and after."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import whole_number
from cyclemap.collection.cycle_scene import placed
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait_curves import TurnCurve, turn_curve
from cyclemap.resets.design.action_cache import ActionCache, has_kernel
from cyclemap.resets.design.reset_design import ResetDesign
from cyclemap.resets.design.reset_ranking import ScoredReset
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.shared_strokes import run_action

Array = NDArray[np.float64]

CURVE_SAMPLES = 720
_SCENES = 4
_DRAWN = 60  # samples of a push, and as finely of a drag


@dataclass(frozen=True, eq=False)
class DragScene:
    """One cycle about the target, the world's origin; m. rod : (n, 2) path of the rod in the push; ring : (k, 2) path
    of the ring in the drag. pushed, back : (m, 2) closed outlines of the object after the push and after the drag."""

    rod: Array
    ring: Array
    pushed: Array
    back: Array


@dataclass(frozen=True, eq=False)
class ResetCurve:
    """One reset as it is drawn.

    density : (n,), per radian, over `ResetCurves.theta`. path : (pushes,), rad, not wrapped, of a run of its chain.
    turns : the turn of each of its maps, with its weight. scenes : some of its cycles. rod_radius, reach : m.
    """

    name: str
    density: Array
    path: Array
    turns: tuple[tuple[TurnCurve, float], ...]
    scenes: tuple[DragScene, ...]
    rod_radius: float
    reach: float


@dataclass(frozen=True, eq=False)
class ResetCurves:
    """The loop's own reset and the chosen one. theta : (n,), rad, of the densities."""

    theta: Array
    before: ResetCurve
    after: ResetCurve


def reset_curves(design: ResetDesign, pushes: int = 300, seed: int = 0) -> ResetCurves:
    """Return the curves of a design; the runs' paths are `pushes` long, both from orientation 0."""
    count, number = whole_number("pushes", pushes, least=2), whole_number("seed", seed, least=0)
    theta = np.linspace(0.0, 2.0 * math.pi, CURVE_SAMPLES + 1)
    before, after = (_curve(design.cache, one, theta, count, number) for one in (design.own, design.chosen))
    return ResetCurves(theta, before, after)


def _curve(cache: ActionCache, one: ScoredReset, theta: Array, pushes: int, seed: int) -> ResetCurve:
    strategy, nodes = one.candidate.strategy, one.candidate.nodes
    known = cache.kernel(strategy, nodes) if has_kernel(strategy) else cache.maps(strategy, nodes)
    turns = tuple((turn_curve(part), weight) for part, weight in zip(known.maps, known.weights.tolist(), strict=True))
    return ResetCurve(
        one.name,
        np.maximum(one.numbers.law.density(theta), 0.0),
        cache.sampler(strategy, nodes, 0.0)(1, pushes, seed)[0],
        turns,
        tuple(_scenes(cache, one)),
        cache.loop.pusher.radius,
        one.cost.reach,
    )


def _scenes(cache: ActionCache, one: ScoredReset) -> Iterable[DragScene]:
    """Cycles whose pushes go in as many even directions, of the actions that come most often."""
    law = one.candidate.strategy.law(one.candidate.nodes)
    prepared = one.candidate.strategy.prepared(cache.loop)
    often = np.argsort(-law.weights, kind="stable").tolist()
    picked = [law.actions[often[(k * max(1, len(often) // _SCENES)) % len(often)]] for k in range(_SCENES)]
    first = _push_direction(prepared, picked[0])
    for k, action in enumerate(picked):
        wished = first + 2.0 * math.pi * k / _SCENES
        yield _scene(prepared, action, wished - _push_direction(prepared, action))


def _push_direction(loop: CollectionLoop, action: CycleAction) -> float:
    """Direction (rad) in the world of the push from orientation 0."""
    course = run_action(loop, action, 0.0)[0].trajectory.pusher
    way = course[-1] - course[0]
    return math.atan2(way[1], way[0])


def _scene(loop: CollectionLoop, action: CycleAction, theta: float) -> DragScene:
    push, drag = run_action(loop, action, theta, (action.push or loop.push).distance / _DRAWN)
    outline = loop.slider.outline_points()
    ring = drag.trajectory.pusher if drag.legs else np.zeros((1, 2))
    pushed, back = (np.array([end.x, end.y, end.theta]) for end in (push.end, drag.end))
    return DragScene(push.trajectory.pusher, ring, placed(pushed, outline), placed(back, outline))
