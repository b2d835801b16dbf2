"""What an action costs: length of the drag, time, and the room that rod and object need about the target."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_number, non_negative_number, positive_number, whole_number
from cyclemap.collection.cycle_scene import placed
from cyclemap.collection.loop import CollectionLoop
from cyclemap.mechanics import Trajectory
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.shared_strokes import run_action
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.resets.strategies.strategy_maps import checked_strategy

Array = NDArray[np.float64]

# Samples of a push, and of as long a part of a drag, over which the reach of the object is taken.
_SAMPLES = 40
_COST_ACCURACY = 1e-6


@dataclass(frozen=True)
class Pace:
    """How fast the robot works.

    speed : of the rod in contact, m/s. handling : s a cycle for all else: into the ring, out of it, to the next push.
    gripper : s more in a cycle in which a gripper turns the object.
    """

    speed: float = 0.020
    handling: float = 10.0
    gripper: float = 10.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "speed", positive_number("speed", self.speed))
        for name in ("handling", "gripper"):
            object.__setattr__(self, name, non_negative_number(f"{name} time", getattr(self, name)))

    def seconds(self, travel: float, action: CycleAction) -> float:
        """Return the time (s) of a cycle whose push and drag together are `travel` (m) long.

        >>> Pace().seconds(0.25, CycleAction())
        22.5
        """
        return travel / self.speed + self.handling + (self.gripper if action.turn else 0.0)


@dataclass(frozen=True)
class CycleCost:
    """The cost of one cycle.

    drag_length : path of the ring, m. seconds : of push, drag and handling. rod_reach, object_reach : the
    largest distance from the target, m, of any point of the rod and of the object's outline, over push and drag. The
    rod goes to the end of its push, whether or not it has lost the object by then.
    """

    drag_length: float
    seconds: float
    rod_reach: float
    object_reach: float

    @property
    def reach(self) -> float:
        """The radius (m) about the target that the cycle needs."""
        return max(self.rod_reach, self.object_reach)


@dataclass(frozen=True)
class StrategyCost:
    """The cost of a strategy, over its law and over orientations that are evenly spread, as without bias.

    mean_drag_length, longest_drag : m. mean_seconds : s a cycle. rod_reach, object_reach : m, the largest found.
    """

    mean_drag_length: float
    longest_drag: float
    mean_seconds: float
    rod_reach: float
    object_reach: float

    @property
    def reach(self) -> float:
        """The radius (m) about the target that the collection needs."""
        return max(self.rod_reach, self.object_reach)


def action_cost(loop: CollectionLoop, action: CycleAction, theta: float, pace: Pace | None = None) -> CycleCost:
    """Return the cost of one cycle of a prepared loop from orientation `theta` (rad).

    The rod's reach is exact; the object's is the largest at samples some 4 mm of rod travel apart, and short of the
    true one by less than 0.2 mm for the MIT shapes.

    >>> cost = action_cost(CollectionLoop.mit(), CycleAction(), 0.0)
    >>> round(cost.drag_length, 5), round(cost.seconds, 2)
    (0.09349, 22.17)
    """
    start, distance = finite_number("theta", theta), (action.push or loop.push).distance
    push, drag = run_action(loop, action, start, distance / _SAMPLES)
    courses = [push.trajectory, drag.trajectory] if drag.legs else [push.trajectory]
    seconds = (pace or Pace()).seconds(distance + drag.length, action)
    rod = np.concatenate([_pushed_to(push.trajectory, distance), *(course.pusher for course in courses)])
    reach = float(np.hypot(*rod.T).max()) + loop.pusher.radius
    return CycleCost(drag.length, seconds, reach, max(_outline_reach(loop, course) for course in courses))


def _pushed_to(course: Trajectory, distance: float) -> Array:
    """Where the rod (1, 2) ends its push (m), also where it has lost the object by then."""
    way = course.pusher[-1] - course.pusher[0]
    return np.atleast_2d(course.pusher[0] + distance * way / math.hypot(*way))


def _outline_reach(loop: CollectionLoop, course: Trajectory) -> float:
    places = placed(course.pose.T[:, :, None], loop.slider.outline_points())
    return float(np.hypot(places[..., 0], places[..., 1]).max())


def strategy_cost(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    *,
    pace: Pace | None = None,
    orientations: int = 12,
    nodes: int = 12,
) -> StrategyCost:
    """Return the cost of the strategy on the loop: means and largest values over its law and even orientations.

    orientations : how many start orientations; nodes : of the law, for a full turn. Twelve of each give MIT's mean
    drag on plywood to 0.1 %. Runs as many cycles as their product, about 15 ms each.

    >>> from cyclemap.resets.strategies.drag_strategies import TrailingLeg
    >>> cost = strategy_cost(CollectionLoop.mit(), TrailingLeg(0.05, 0.0), orientations=2)
    >>> 0.05 < cost.mean_drag_length < cost.longest_drag < 0.3
    True
    """
    law, prepared = checked_strategy(strategy).law(nodes), strategy.prepared(loop)
    rough = replace(prepared, accuracy=max(prepared.accuracy, _COST_ACCURACY))
    count = whole_number("orientations", orientations, least=1)
    starts = 2.0 * math.pi * np.arange(count) / count
    costs = [[action_cost(rough, action, start, pace) for start in starts.tolist()] for action in law.actions]
    table = np.array([[(c.drag_length, c.seconds, c.rod_reach, c.object_reach) for c in row] for row in costs])
    mean, largest = law.weights @ table.mean(axis=1), table.max(axis=(0, 1))
    return StrategyCost(float(mean[0]), float(largest[0]), float(mean[1]), float(largest[2]), float(largest[3]))
