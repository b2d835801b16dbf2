"""A loop on another material, and whether the surface's direction matters to a strategy."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cyclemap.collection.found_with import with_found
from cyclemap.collection.loop import CollectionLoop
from cyclemap.mechanics import FoundWith, Material, Pusher
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.strategy import ActionLaw, ResetStrategy
from cyclemap.resets.strategies.strategy_maps import checked_strategy

# A law that is the same after a turn by a tenth and by a twelfth of a circle is so after any sixtieth.
_TURNS = (10, 12)
_PLACES = 9  # decimals (m, weights) to which turned actions must agree

_Key = tuple[object, ...]


def loop_on(loop: CollectionLoop, material: Material) -> CollectionLoop:
    """Return the loop on another material, with what was found with that one in place of what came with its own.

    What both materials say alike stays as it is in the loop, where it may have been replaced on purpose; the ring's
    lever changes by the ratio of the scales and the difference of the turns.

    >>> from cyclemap.mechanics import load_material
    >>> moved = loop_on(CollectionLoop.mit("plywood"), load_material("abs"))
    >>> moved == CollectionLoop.mit("abs") and loop_on(moved, load_material("plywood")).reset.pin_friction_radius == 0.0
    True
    """
    before, after = loop.material.found_with, material.found_with
    bare = replace(loop, material=material)
    if before == after:
        return bare
    rod = _changed(before.pusher_friction, after.pusher_friction, Pusher().friction)
    pin = _changed(before.pin_friction_radius, after.pin_friction_radius, 0.0)
    pressure = _pressure(before), _pressure(after)
    if pressure[0] != pressure[1] and pressure[1] == (None, None, None):
        bare, pressure = replace(bare, footprint=None), (pressure[1], pressure[1])
    rim, warp_a, warp_b = pressure[1] if pressure[0] != pressure[1] else (None, None, None)
    scale = _or(after.hitch_scale, 1.0) / _or(before.hitch_scale, 1.0)
    turn = _or(after.hitch_turn, 0.0) - _or(before.hitch_turn, 0.0)
    lever = {} if scale == 1.0 and turn == 0.0 else {"hitch_scale": scale, "hitch_turn": turn}
    return with_found(bare, FoundWith(rod, rim, pin_friction_radius=pin, warp_a=warp_a, warp_b=warp_b, **lever))


def direction_matters(loop: CollectionLoop, strategy: ResetStrategy) -> bool:
    """Tell whether the bias of a strategy on the loop can depend on the direction phi of the surface.

    Turning surface and object by alpha turns the whole cycle: the map of an action on the turned surface is
    f -> alpha + f(theta - alpha), f the map of the action turned back. A law of actions that turning leaves as it is
    (one of the push alone, legs in directions drawn evenly) thus has its stationary law turned, and the distance of
    that from uniform, from the worst start too, and the mean drag over even orientations stay the same.

    Tested on the law's quadratures with 10 and 12 nodes: a law that stays the same under a tenth and a twelfth of a
    turn has no preferred direction but for what 60 equal ones resolve.

    >>> from cyclemap.resets.strategies.drag_strategies import TrailingLeg, WayPoints
    >>> loop = CollectionLoop.mit()
    >>> [direction_matters(loop, one) for one in (TrailingLeg(0.05), WayPoints(((0.05, 0.0),)))]
    [False, True]
    """
    prepared = checked_strategy(strategy).prepared(loop)
    return any(not _turns_into_itself(strategy.law(nodes), prepared, 2.0 * math.pi / nodes) for nodes in _TURNS)


def _turns_into_itself(law: ActionLaw, loop: CollectionLoop, angle: float) -> bool:
    actions = [action.filled(loop) for action in law.actions]
    before, after = (_weights(kind, law) for kind in (actions, [action.turned(angle) for action in actions]))
    return before.keys() == after.keys() and all(abs(before[key] - after[key]) < 10.0**-_PLACES for key in before)


def _weights(actions: list[CycleAction], law: ActionLaw) -> dict[_Key, float]:
    found: dict[_Key, float] = {}
    for action, weight in zip(actions, law.weights.tolist(), strict=True):
        places = np.round(np.array(action.way_points or ()), _PLACES) + 0.0
        key = (tuple(places.ravel().tolist()), action.push, action.turn)
        found[key] = found.get(key, 0.0) + weight
    return found


def _changed(before: float | None, after: float | None, otherwise: float) -> float | None:
    """What is to be set: None where both say the same."""
    return None if before == after else _or(after, otherwise)


def _or(value: float | None, otherwise: float) -> float:
    return otherwise if value is None else value


def _pressure(found: FoundWith) -> tuple[float | None, float | None, float | None]:
    return found.rim_share, found.warp_a, found.warp_b
