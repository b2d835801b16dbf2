"""A strategy that does the same in every cycle as the loop it amounts to; which settings a strategy takes over."""

from __future__ import annotations

from cyclemap.collection.loop import CollectionLoop
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.strategy import ResetStrategy

# Enough to tell a drawn number from a fixed one.
_NODES = 2
_PUSH_KEYS = ("side", "fraction", "angle_deg", "push_mm")


def fixed_action(strategy: ResetStrategy) -> CycleAction | None:
    """Return what the strategy does in every cycle; None where cycles differ.

    >>> from cyclemap.resets.strategies.drag_strategies import GripperTurn, TrailingLeg
    >>> fixed_action(GripperTurn(0.5)), fixed_action(TrailingLeg(0.05))
    (CycleAction(way_points=None, push=None, turn=0.5), None)
    """
    actions = set(strategy.law(_NODES).actions)
    return actions.pop() if len(actions) == 1 else None


def fixed_loop(loop: CollectionLoop, strategy: ResetStrategy) -> CollectionLoop | None:
    """Return the loop with the strategy in it; None where cycles differ, or a gripper turns the object.

    >>> from cyclemap.resets.strategies.drag_strategies import TrailingLeg
    >>> fixed_loop(CollectionLoop.mit(), TrailingLeg(0.05, 0.0)).reset.way_points
    ((0.05, 0.0),)
    """
    action = fixed_action(strategy)
    if action is None or action.turn:
        return None
    return action.on(strategy.prepared(loop))


def why_not_fixed(strategy: ResetStrategy) -> str:
    """Return in words why a strategy has no `fixed_loop`."""
    if fixed_action(strategy) is None:
        return f"its strategy ({strategy.name}) does not do the same in every cycle"
    return f"its strategy ({strategy.name}) turns the object by a gripper, which is no part of a loop"


def overruled_settings(loop: CollectionLoop, strategy: ResetStrategy) -> tuple[str, ...]:
    """Return the settings of `loop` that the strategy replaces in every cycle.

    >>> from cyclemap.resets.strategies.drag_strategies import StraightReset
    >>> overruled_settings(CollectionLoop.mit(), StraightReset())
    ('way_points_mm',)
    """
    actions = strategy.law(_NODES).actions
    keys: tuple[str, ...] = _PUSH_KEYS if all(action.push is not None for action in actions) else ()
    keys += ("way_points_mm",) if all(action.way_points is not None for action in actions) else ()
    moved = strategy.prepared(loop).slider.hitch != loop.slider.hitch
    return (*keys, "hitch_x_mm", "hitch_y_mm") if moved else keys
