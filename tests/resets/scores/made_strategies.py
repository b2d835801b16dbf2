"""Strategies with cycle maps made up by formula, in no time: one for every kind of action and schedule."""

import math
from functools import lru_cache

import numpy as np

from cyclemap.collection.loop import CollectionLoop
from cyclemap.maps import CircleMap
from cyclemap.mechanics import SidePush
from cyclemap.resets.strategies.combined import combine
from cyclemap.resets.strategies.drag_strategies import (
    GripperTurn,
    RingPlace,
    ScatteredAim,
    StraightReset,
    TrailingLeg,
    WayPoints,
)
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes, VariedPush, side_pushes
from cyclemap.resets.strategies.schedules import GoldenAngle, LatinBlocks, Sobol, VanDerCorput
from cyclemap.resets.strategies.spread import Spread
from cyclemap.resets.strategies.strategy_maps import StrategyMaps

PUSH = SidePush()
SIDES = side_pushes(PUSH, (0, 2))
THREE = (PUSH, SidePush(side=1, fraction=0.6), SidePush(side=3, fraction=0.4))

STRATEGIES = {
    "straight": StraightReset(),
    "way-points": WayPoints(((0.06, 0.03), (0.05, -0.02))),
    "ring at another place": RingPlace((0.0, 0.02)),
    "fixed leg": TrailingLeg(0.1, 1.0),
    "random leg": TrailingLeg(0.1),
    "golden leg": TrailingLeg(0.1, schedule=GoldenAngle()),
    "leg in blocks": TrailingLeg(0.1, schedule=LatinBlocks(5)),
    "leg in blocks of middles": TrailingLeg(0.1, schedule=LatinBlocks(4, jitter=False)),
    "leg in blocks too many to follow": TrailingLeg(0.1, schedule=LatinBlocks(16)),
    "Sobol leg": TrailingLeg(0.1, schedule=Sobol()),
    "van der Corput leg": TrailingLeg(0.1, schedule=VanDerCorput()),
    "scattered aim": ScatteredAim(0.05),
    "gripper turn": GripperTurn(),
    "small gripper turn": GripperTurn(Spread.within(0.3, 0.4)),
    "golden gripper turn": GripperTurn(schedule=GoldenAngle()),
    "alternating pushes": AlternatingPushes(THREE),
    "drawn pushes": DrawnPushes(THREE, weights=(0.5, 0.2, 0.3)),
    "golden pushes": DrawnPushes(SIDES, GoldenAngle()),
    "pushes in blocks": DrawnPushes(SIDES, LatinBlocks(4, jitter=False)),
    "varied push": VariedPush(PUSH, fraction=Spread(0.6, 0.8)),
    "pushes and legs": combine(DrawnPushes(SIDES), TrailingLeg(0.1)),
    "pushes in turn and a golden gripper": combine(AlternatingPushes(SIDES), GripperTurn(schedule=GoldenAngle())),
    "pushes in turn and a leg": combine(AlternatingPushes(SIDES), TrailingLeg(0.1, Spread.within(1.0, 0.5))),
}


@lru_cache(maxsize=1)
def loop():
    return CollectionLoop.mit()


def drift(action, prepared, theta):
    """θ' - θ and its slope of a made-up cycle: drawn to the legs, turned by the push, slowed down twice a turn."""
    push = action.push or prepared.push
    turn = 0.5 - 0.25 * np.cos(2 * theta - 1.0) - 6.0 * prepared.slider.hitch[0]
    turn = turn + 0.4 * push.side + 2.0 * (push.fraction - 0.7) * np.cos(theta)
    slope = 0.5 * np.sin(2 * theta - 1.0) - 2.0 * (push.fraction - 0.7) * np.sin(theta)
    for x, y in action.way_points or ():
        pull, towards = 6.0 * math.hypot(x, y), math.atan2(y, x)
        turn, slope = turn + pull * np.sin(towards - theta), slope - pull * np.cos(towards - theta)
    return turn, slope


def made_maps(strategy, nodes=12, drift=drift):
    """What ``strategy_maps`` would give, with maps of a formula instead of the mechanics."""
    law, prepared = strategy.law(nodes), strategy.prepared(loop())
    theta = np.linspace(0.0, 2 * np.pi, 90, endpoint=False)
    known, still, whole = {}, [], []
    for action in law.actions:
        key = action.way_points, action.push
        if key not in known:
            turn, slope = drift(action, prepared, theta)
            known[key] = CircleMap.from_samples(theta, theta + turn, 1.0 + slope)
        still.append(known[key])
        up = known[key].pieces.shifted(0.0, action.turn)
        whole.append(known[key] if not action.turn else CircleMap.from_pieces(up, known[key].breaks, 90))
    return StrategyMaps(strategy, nodes, prepared, law, tuple(whole), tuple(still), len(known), ())


def rigid_drift(action, prepared, theta):
    """Rotations alone, as on an isotropic surface: a push's side says by how much."""
    return np.full(theta.size, 0.3 + 0.5 * (action.push or prepared.push).side), np.zeros(theta.size)
