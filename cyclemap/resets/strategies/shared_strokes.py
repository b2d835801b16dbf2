"""Pushes of one loop, each run once for all actions that share it, and the cycles that go on from them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cyclemap.collection.loop import CollectionLoop
from cyclemap.mechanics import DragResult, PushResult, SidePush
from cyclemap.mechanics.stroke_variation import turned, unit_rows, vary_drag, vary_push
from cyclemap.resets.strategies.cycle_action import CycleAction

Array = NDArray[np.float64]

_NAMES = ("theta",)


def run_action(
    loop: CollectionLoop, action: CycleAction, theta: float, longest_step: float = math.inf
) -> tuple[PushResult, DragResult]:
    """Run the push and the drag of one cycle as `action` wants it, from orientation `theta` (rad), on the loop's model.

    The gripper's turn is not in it. `longest_step` (m) bounds the spacing of the trajectories' samples.

    >>> loop = CollectionLoop.mit()
    >>> push, drag = run_action(loop, CycleAction(((0.05, 0.0),)), 0.0)
    >>> drag.end.theta == CycleAction(((0.05, 0.0),)).on(loop).cycle(0.0).theta_next
    True
    """
    whole = action.filled(loop)
    assert whole.push is not None
    push = loop.model.push(loop.start_pose(theta), whole.push, longest_step)
    return push, run_drag(loop, whole, push, longest_step)


def run_drag(loop: CollectionLoop, action: CycleAction, push: PushResult, longest_step: float = math.inf) -> DragResult:
    """Run the drag of a filled action after its push."""
    assert action.way_points is not None
    way = (*action.way_points, (0.0, 0.0))
    return loop.model.drag(push.end, way, longest_step, loop.reset.pin_friction_radius)


@dataclass(frozen=True)
class _Pushed:
    """A push, and the derivatives by theta of the orientation (1,) and of the ring's place (2, 1) at its end."""

    push: PushResult
    by_theta: Array
    ring: Array


@dataclass
class SharedStrokes:
    """Cycles of one loop (prepared, and as accurate as its maps are to be): pushes are kept by push and orientation.

    A push depends on the orientation alone, so that actions which differ in their drags share it.
    """

    loop: CollectionLoop
    pushed: dict[tuple[SidePush, float], _Pushed] = field(default_factory=dict)

    def sample(self, action: CycleAction, theta: float) -> tuple[float, float, float]:
        """Return theta_next (rad, without the gripper's turn), its derivative by theta, and the drag's length (m).

        As `CollectionLoop.sensitivity` does, by the chain rule through the CasADi tangents of push and drag.
        """
        whole = action.filled(self.loop)
        assert whole.push is not None
        before = self._pushed(whole.push, theta)
        drag = run_drag(self.loop, whole, before.push)
        rows = unit_rows(self.loop.model, _NAMES)
        by_theta, _ = vary_drag(self.loop.model, drag, before.by_theta, before.ring, rows)
        return drag.end.theta, float(by_theta[0]), drag.length

    def _pushed(self, push: SidePush, theta: float) -> _Pushed:
        if (push, theta) not in self.pushed:
            self.pushed[push, theta] = self._new_push(push, theta)
        return self.pushed[push, theta]

    def _new_push(self, push: SidePush, theta: float) -> _Pushed:
        model = self.loop.model
        made = model.push(self.loop.start_pose(theta), push)
        rows = unit_rows(model, _NAMES)
        varied = vary_push(model, made, rows)
        hitch, fixed = np.array(model.slider.hitch), np.zeros((2, 1))
        # Before the push the ring is at the target: the object's origin moves as -R(theta) hitch.
        start = turned(made.start.theta, hitch, rows["theta"], fixed)
        ring = model.unit * varied[1:3] - start + turned(made.end.theta, hitch, varied[0], fixed)
        return _Pushed(made, varied[0], ring)
