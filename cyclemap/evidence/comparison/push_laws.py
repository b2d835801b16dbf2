"""What a loop's push does to the object at any orientation: turn and displacement as periodic functions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from cyclemap.checks import positive_number
from cyclemap.collection import CollectionLoop
from cyclemap.collection.adaptive_map import sample_circle_map
from cyclemap.evidence.orientations.circular_law import Array
from cyclemap.maps import CircleMap

PUSH_OUTPUTS = ("push_turn", "push_dx", "push_dy")
# More pushes than this are looked up in the sampled laws; fewer are run one by one.
MOST_RUN = 250
# A metre is sampled as so many radians: at 1e-5 rad a length is then good to a micrometre.
RADIANS_A_METRE = 10.0


@dataclass(frozen=True, eq=False)
class PushLaws:
    """Turn (rad) and displacement (m) of one push over θ, kinks and jumps kept.

    turn, dx, dy : lifts θ → θ + value, the displacements times ``RADIANS_A_METRE``.
    Their ``max_error`` is checked as that of a cycle map is.
    """

    turn: CircleMap
    dx: CircleMap
    dy: CircleMap

    def __call__(self, theta: Array) -> Array:
        """Turn (rad), dx and dy (m, initial object frame) of pushes from ``theta`` (n,): shape (n, 3)."""
        columns = [self.turn.turn(theta), *(one.turn(theta) / RADIANS_A_METRE for one in (self.dx, self.dy))]
        return np.stack(columns, axis=-1)

    @property
    def max_error(self) -> tuple[float, float]:
        """Bounds as far as checked: of the turn (rad), of a displacement (m)."""
        return self.turn.max_error, max(self.dx.max_error, self.dy.max_error) / RADIANS_A_METRE


def push_laws(
    loop: CollectionLoop, tolerance: float = 1e-5, progress: Callable[[float], None] | None = None
) -> PushLaws:
    """Sample the push of ``loop`` over all orientations until cubics reproduce it to ``tolerance``.

    tolerance : radians of turn, and of ``RADIANS_A_METRE`` times the displacement. See ``sample_circle_map`` for how
    samples are placed, and kinks and jumps found. progress : called with the fraction done, in [0, 1].
    """
    error = max(0.1 * positive_number("tolerance", tolerance), 1e-9)
    fine, report = replace(loop, accuracy=min(error, 1e-6)), progress or (lambda fraction: None)

    @cache
    def values(theta: float) -> Array:
        cycle = fine.cycle(theta)
        return np.array([cycle.push_turn, *(RADIANS_A_METRE * cycle.push_displacement)])

    @cache
    def slopes(theta: float) -> Array:
        found = fine.sensitivity(theta, ("theta",))
        scale = np.array([1.0, RADIANS_A_METRE, RADIANS_A_METRE])
        return scale * [found.by("theta", output) for output in PUSH_OUTPUTS]

    def sampled(k: int) -> CircleMap:
        def value(theta: float) -> float:
            return theta + float(values(theta)[k])

        def sample(theta: float) -> tuple[float, float]:
            return value(theta), 1.0 + float(slopes(theta)[k])

        return sample_circle_map(sample, value, tolerance, lambda done: report((k + done) / 3.0), error)

    return PushLaws(*(sampled(k) for k in range(len(PUSH_OUTPUTS))))


def predicted_pushes(
    loop: CollectionLoop,
    theta: Array,
    *,
    tolerance: float = 1e-5,
    most_run: int = MOST_RUN,
    progress: Callable[[float], None] | None = None,
) -> tuple[Array, tuple[float, float]]:
    """Turn (rad), dx and dy (m) of the loop's push from each of ``theta`` (n,): (n, 3), and bounds on their errors.

    Up to ``most_run`` pushes are run one by one, exact to the loop's accuracy (bounds 0); more are looked up in
    ``push_laws`` of ``tolerance``.
    Raises UnsupportedContact where the mechanics cannot follow a push.
    """
    if theta.size > most_run:
        laws = push_laws(loop, tolerance, progress)
        return laws(theta), laws.max_error
    runs = [loop.model.push(loop.start_pose(angle), loop.push) for angle in theta.tolist()]
    return np.array([[run.turn, *run.displacement] for run in runs]).reshape(-1, 3), (0.0, 0.0)
