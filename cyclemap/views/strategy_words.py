"""What a robot does in a cycle of a strategy, in a few words."""

import math

from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.views.sentences import angle

# More way-points than this are counted, not told one by one.
_MOST_TOLD = 3


def action_words(action: CycleAction) -> str:
    """The push, the drag and the gripper's turn of a cycle; what the loop does of itself is left out.

    >>> from cyclemap.mechanics import SidePush
    >>> action_words(CycleAction(((0.05, 0.0),), SidePush(side=1, distance=0.08), math.pi / 6))
    'push 80 mm on side 1 at 0.7, drag by 50 mm at 0.0°, gripper 30.0°'
    >>> action_words(CycleAction()), action_words(CycleAction(()))
    ('as the loop does', 'straight drag')
    """
    told = []
    if action.push is not None:
        slant = f", {angle(action.push.angle)} off its normal" if action.push.angle else ""
        told.append(
            f"push {1e3 * action.push.distance:.4g} mm on side {action.push.side} at {action.push.fraction:.4g}{slant}"
        )
    if action.way_points is not None:
        told.append(_drag_words(action.way_points))
    if action.turn:
        told.append(f"gripper {angle(action.turn)}")
    return ", ".join(told) or "as the loop does"


def _drag_words(way_points: tuple[tuple[float, float], ...]) -> str:
    told = way_points[:_MOST_TOLD]
    places = [f"{1e3 * math.hypot(x, y):.4g} mm at {angle(math.atan2(y, x))}" for x, y in told]
    if not places:
        return "straight drag"
    more = len(way_points) - len(places)
    return f"drag by {', then '.join(places)}{f', and {more} places more' if more > 0 else ''}"


def strategy_words(strategy: ResetStrategy, actions: int, kind: str) -> str:
    """The strategy, how many actions its law has, how they follow each other, and what they need."""
    how = {
        "independent": "drawn anew in every cycle",
        "periodic": "in turn",
        "blocks": "in shuffled blocks",
        "sequence": "by a fixed sequence",
    }
    law = f"{actions} actions {how[kind]}" if actions > 1 else "the same action in every cycle"
    needs = f"; needs a {' and a '.join(strategy.needs)}" if strategy.needs else ""
    return f"{strategy.name}, {law}{needs}"
