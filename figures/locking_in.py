"""Animation: the loop of push and drag locks in: seen from above, as a cobweb, and as θ0 over the cycles."""

import math
from dataclasses import dataclass, replace

import numpy as np

from cyclemap.arrays import Array
from cyclemap.collection.cycle_scene import placed
from cyclemap.collection.loop import CollectionLoop, Cycle
from cyclemap.errors import ConvergenceError
from cyclemap.maps import fixed_points
from cyclemap.mechanics import Polygon, Trajectory

from .exhibit import BEYOND, PaperAnimation
from .locking_in_frames import frames
from .measured_folder import MeasuredFolder

START = math.radians(215.0)
# Radians from the stable direction at which the robot counts as locked in.
LOCKED = math.radians(0.5)
MOST_CYCLES = 120
# Pictures of the push and of the drag of a cycle: slow at first, then faster, until one shows a whole cycle.
PACE = ((2, 13, 9), (5, 6, 4), (9, 3, 2))
SLOW, FAST = (13, 9), (1, 0)
SECONDS, LAST_SECONDS = 0.07, 2.0


@dataclass(frozen=True, eq=False)
class Moment:
    """One picture's worth of motion.

    cycle : number of the cycle, from 0. outline : (k, 2) m, the object. side : (2, 2) m, ends of the side pushed.
    ring, rod : (2,) m. pushing : else dragged. rod_path : (n, 2) m, of the rod since this stroke began. seconds : how
    long it is shown.
    """

    cycle: int
    outline: Array
    side: Array
    ring: Array
    rod: Array
    pushing: bool
    rod_path: Array
    seconds: float


@dataclass(frozen=True, eq=False)
class LockingIn:
    """A run of the loop until it locks in.

    theta : (n + 1,) rad, unwrapped: θ0 of every cycle. stable : rad, the stable direction on the turn where the run
    ends. multiplier : of the stable direction. curve : (m, 2) rad, θ0 and next θ0 over the run's range. moments : what
    the pictures show. rod_radius : m. unstable : rad, the unstable direction nearest below the start.
    """

    theta: Array
    stable: float
    unstable: float
    multiplier: float
    curve: Array
    moments: tuple[Moment, ...]
    rod_radius: float

    @property
    def cycles(self) -> int:
        """How many cycles were run."""
        return int(self.theta.size - 1)


def compute(
    measured: MeasuredFolder,
    start: float = START,
    locked: float = LOCKED,
    pace: tuple[tuple[int, int, int], ...] = PACE,
    slow: tuple[int, int] = SLOW,
) -> LockingIn:
    """Run the MIT loop on plywood from `start` (rad) until it is within `locked` (rad) of its stable direction.

    pace : (up to this cycle, pictures of its push, of its drag), in order; slow : those of the last cycle.
    Raises ConvergenceError where MOST_CYCLES cycles do not lock in.
    """
    del measured
    loop = CollectionLoop.mit(material="plywood")
    circle_map = loop.circle_map(tolerance=1e-4)
    rest, edge = (next(orbit for orbit in fixed_points(circle_map) if orbit.stable == kind) for kind in (True, False))
    stable = float(rest.points[0])
    run = _run(loop, start, stable, locked)
    theta = np.array([run[0].theta, *(cycle.theta_next for cycle in run)])
    stable = stable + 2 * np.pi * round((theta[-1] - stable) / (2 * np.pi))
    unstable = float(edge.points[0]) + 2 * np.pi * math.floor((theta[0] - float(edge.points[0])) / (2 * np.pi))
    reach = np.linspace(min(theta.min(), unstable) - 0.1, theta.max() + 0.25, 241)
    moments = [moment for number, cycle in enumerate(run) for moment in _moments(cycle, number, len(run), pace, slow)]
    return LockingIn(
        theta, stable, unstable, rest.multiplier, np.stack([reach, circle_map(reach)], axis=1), tuple(moments),
        loop.pusher.radius,
    )  # fmt: skip


def _run(loop: CollectionLoop, start: float, stable: float, locked: float) -> list[Cycle]:
    """The cycles until one ends locked in, and one more."""
    run = [loop.cycle(start)]
    while abs(math.remainder(run[-1].theta - stable, 2 * math.pi)) > locked:
        if len(run) > MOST_CYCLES:
            raise ConvergenceError(f"{MOST_CYCLES} cycles from {math.degrees(start):.4g} deg do not lock in")
        run.append(loop.cycle(run[-1].theta_next))
    return run


def _moments(
    cycle: Cycle, number: int, count: int, pace: tuple[tuple[int, int, int], ...], slow: tuple[int, int]
) -> list[Moment]:
    """The pictures of one cycle."""
    push, drag = next(((p, d) for until, p, d in pace if number < until), FAST)
    if number == count - 1:
        push, drag = slow
    made = _stroke(cycle, number, cycle.trajectory.push, push, True)
    if drag:
        made += _stroke(cycle, number, cycle.trajectory.drag, drag, False)
    if number == count - 1:
        made[-1] = replace(made[-1], seconds=LAST_SECONDS)
    return made


def _stroke(cycle: Cycle, number: int, motion: Trajectory, count: int, pushing: bool) -> list[Moment]:
    """`count` pictures at equal distances along a stroke, the last at its end."""
    way = motion.path / motion.path[-1]
    shares = np.linspace(0.0, 1.0, count + 1)[1:]
    slider = cycle.loop.slider
    assert isinstance(slider.outline, Polygon)
    outline, hitch = np.asarray(slider.outline.vertices), np.asarray(slider.hitch, dtype=float)
    side = outline[[cycle.loop.push.side, (cycle.loop.push.side + 1) % len(outline)]]
    made = []
    for share in shares.tolist():
        pose = np.array([np.interp(share, way, column) for column in motion.pose.T])
        rod = np.array([np.interp(share, way, column) for column in motion.pusher.T])
        path = np.concatenate([motion.pusher[way < share], [rod]])
        body, pushed, ring = (placed(pose, points) for points in (outline, side, hitch))
        made.append(Moment(number, body, pushed, ring, rod, pushing, path, SECONDS))
    return made


def caption(result: LockingIn) -> str:
    """What is seen, with its numbers."""
    near = math.degrees(result.theta[-1] - result.stable)
    return (
        f"The loop of push and drag on plywood (Table I), to scale: the rod pushes the object, then drags it back by "
        f"its ring to the same spot (first cycles slowly, later ones at a glance). Started at "
        f"{math.degrees(result.theta[0]):.0f}°, each cycle begins where the last one left θ0: on the cycle map it "
        f"climbs the stairs of a cobweb, until after {result.cycles} cycles it repeats the same push at "
        f"{math.degrees(result.stable) % 360:.0f}°, {abs(near):.1f}° from the stable direction. There every cycle "
        f"leaves {100 * result.multiplier:.0f} % of the distance."
    )


ANIMATION = PaperAnimation("locking-in", BEYOND, "The loop of push and drag locks in", compute, frames, caption)
