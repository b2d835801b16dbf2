"""The paper's numerical experiment: batches of consecutive cycles from several orientations, and
where they end.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cyclemap.arrays import TWO_PI, Array, even_angles, placed
from cyclemap.checks import finite_array, require_room, whole_number
from cyclemap.collection.dynamic_loop import (
    DynamicLoop,
)
from cyclemap.collection.loop import CollectionLoop, require_loop
from cyclemap.collection.loop_surfaces import isotropic_twin
from cyclemap.collection.uncertain_directions import clusters
from cyclemap.errors import InvalidInput
from cyclemap.progress import Progress, unheard

# Ma & Rodriguez (2018): 600 cycles in 6 batches.
BATCHES = 6
CYCLES = 100
# A batch has settled once it stays this near its last orientation, rad.
WITHIN = math.radians(1.0)
# A batch that turns by less than this a cycle, rad, is at rest: the errors of a dynamic cycle are
# as large.
REST = 5e-5
# Places kept of the centre's path in each push, beside its start.
SAMPLES = 20
# Longest step of a quasi-static push, as a fraction of it: between steps its path is taken as
# straight.
_STEPS = 40


@dataclass(frozen=True, eq=False)
class BatchRun:
    """Batches of consecutive cycles on one surface.

    Attributes
    ----------
    theta : ndarray, shape (batches, cycles + 1)
        Orientations before every push and at last, rad, on the lift.
    path : ndarray, shape (batches, cycles, samples + 1, 2)
        The centre of mass during each push, m, evenly in rod travel (last: at rest), in the
        world, whose origin is the reset's target.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.collection import CollectionLoop, batch_experiment
    >>> run = batch_experiment(CollectionLoop.mit("plywood"), batches=3, cycles=10).anisotropic
    >>> run.theta.shape, np.degrees(run.theta[:, -1]).round(1).tolist()
    ((3, 11), [46.7, 80.4, 387.8])
    """

    theta: Array
    path: Array

    @property
    def last_step(self) -> Array:
        """How far the last cycle of each batch still turned it, rad."""
        return np.abs(self.theta[:, -1] - self.theta[:, -2])

    @property
    def left(self) -> Array:
        """How far each batch would still turn, (batches,) rad, if its steps went on shrinking as
        the last two do.

        |s2| r / (1 - r) with r = |s2 / s1|; zero at rest (last step at most `REST`), infinite where
        the steps do not shrink or only one was made.
        """
        steps = np.abs(np.diff(self.theta[:, -3:]))
        now = steps[:, -1]
        shrunk_by = steps[:, 0] - steps[:, -1]
        shrinking = shrunk_by > 0.0
        left = np.where(shrinking, now**2 / np.where(shrinking, shrunk_by, 1.0), np.inf)
        return np.where(now <= REST, 0.0, left)

    def directions(self) -> tuple[float, ...]:
        """Return where the batches end.

        Returns
        -------
        tuple of float
            Rad in [0, 2 pi), ascending; ends that gaps of a degree part are different. Empty where
            a batch still moves, by more than a tenth of a degree a cycle or with more than a
            quarter of one `left`: then it ends nowhere.

        Notes
        -----
        So the slow passage of a bottleneck, where no fixed point is, is no direction: at its
        narrowest its steps cease to shrink, and before, more is left unless its least step is near
        `REST`.
        """
        if self.last_step.max() > 0.1 * WITHIN or self.left.max() > 0.25 * WITHIN:
            return ()
        ends = np.mod(self.theta[:, -1], TWO_PI)
        return tuple(sorted(clusters(ends, WITHIN).tolist()))

    def settled_after(self) -> Array:
        """Return the number of cycles (batches,) after which each batch stays within WITHIN (rad)
        of where it ends.

        Where a batch still moves (`directions` is empty) that is no time of settling.
        """
        off = np.abs(self.theta - self.theta[:, -1:]) > WITHIN
        return np.array([int(np.flatnonzero(row)[-1]) + 1 if row.any() else 0 for row in off])

    @cached_property
    def object_path(self) -> Array:
        """`path` in the object's frame before each push, (batches, cycles, samples + 1, 2), m."""
        offset = self.path - self.path[:, :, :1]
        theta = self.theta[:, :-1, None]
        c = np.cos(theta)
        s = np.sin(theta)
        x = offset[..., 0]
        y = offset[..., 1]
        return np.stack([c * x + s * y, c * y - s * x], axis=-1)

    @property
    def spread(self) -> float:
        """Largest distance of a place of any path in the object's frame from the mean path, m."""
        away = self.object_path - self.object_path.mean(axis=(0, 1))
        return float(np.hypot(away[..., 0], away[..., 1]).max())


@dataclass(frozen=True, eq=False)
class BatchExperiment:
    """The numerical experiment on a surface and on its isotropic twin.

    Attributes
    ----------
    loop : CollectionLoop
        That of the surface.
    speed : float or None
        Speed of the rod, m/s; None for the quasi-static model.
    starts : ndarray, shape (batches,)
        Orientations that the batches start from, rad.
    anisotropic : BatchRun
        The batches on the surface.
    isotropic : BatchRun
        The batches on its isotropic twin.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.collection import CollectionLoop, batch_experiment
    >>> experiment = batch_experiment(CollectionLoop.mit("plywood"), batches=3, cycles=2)
    >>> experiment.cycles, np.degrees(experiment.starts).round().tolist()
    (2, [0.0, 120.0, 240.0])
    """

    loop: CollectionLoop
    speed: float | None
    starts: Array
    anisotropic: BatchRun
    isotropic: BatchRun

    @property
    def cycles(self) -> int:
        """Cycles a batch."""
        return int(self.anisotropic.theta.shape[1]) - 1


def batch_experiment(
    loop: DynamicLoop | CollectionLoop,
    batches: int = BATCHES,
    cycles: int = CYCLES,
    progress: Progress | None = None,
) -> BatchExperiment:
    """Run batches of cycles from evenly spaced orientations, on the loop's surface and on its
    isotropic twin.

    Parameters
    ----------
    loop : DynamicLoop or CollectionLoop
        The protocol. A `DynamicLoop` runs the paper's experiment; a `CollectionLoop` the same
        with quasi-static cycles on its own footprint.
    batches : int, optional
        How many batches, each from an orientation of its own.
    cycles : int, optional
        Cycles of a batch.
    progress : callable or None, optional
        Called with the fraction done.

    Returns
    -------
    BatchExperiment
        The batches on both surfaces.

    Raises
    ------
    InvalidInput
        For a loop that is none, less than one batch or cycle, and more than memory holds.

    References
    ----------
    Ma, D. & Rodriguez, A. (2018), Friction variability in planar pushing data, IEEE Robotics and
    Automation Letters 3(4), "Simulation".

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.collection import CollectionLoop, batch_experiment
    >>> experiment = batch_experiment(CollectionLoop.mit("plywood"), batches=3, cycles=2)
    >>> np.degrees(np.diff(experiment.isotropic.theta)).round(2).tolist()
    [[8.0, 8.0], [8.0, 8.0], [8.0, 8.0]]
    """
    count = whole_number("batches", batches, least=1)
    _require_room(count, whole_number("cycles", cycles, least=1))
    report = progress or unheard
    starts = even_angles(count)
    protocol, speed = (loop.loop, loop.speed) if isinstance(loop, DynamicLoop) else (loop, None)
    even = isotropic_twin(protocol)
    anisotropic = run_batches(loop, starts, cycles, lambda done: report(0.5 * done))
    twin = replace(loop, loop=even) if isinstance(loop, DynamicLoop) else even
    isotropic = run_batches(twin, starts, cycles, lambda done: report(0.5 + 0.5 * done))
    return BatchExperiment(protocol, speed, starts, anisotropic, isotropic)


def run_batches(
    loop: DynamicLoop | CollectionLoop,
    starts: Sequence[float] | Array,
    cycles: int = CYCLES,
    progress: Progress | None = None,
) -> BatchRun:
    """Run a batch of consecutive cycles from each of the orientations `starts` (rad)."""
    now = finite_array("starts", starts, ndim=1)
    length = whole_number("cycles", cycles, least=1)
    _require_room(now.size, length)
    if not isinstance(loop, DynamicLoop):
        require_loop(loop)
    if not now.size:
        raise InvalidInput("starts must hold at least one orientation")
    theta = np.empty((now.size, length + 1))
    paths = np.empty((now.size, length, SAMPLES + 1, 2))
    for batch, start in enumerate(now.tolist()):
        theta[batch, 0] = start
        for cycle in range(length):
            if isinstance(loop, DynamicLoop):
                ran = loop.cycle(theta[batch, cycle], SAMPLES)
                theta[batch, cycle + 1] = ran.theta_next
                slider = loop.loop.slider
                # The last sample, at rest, takes the place of that where the rod stops.
                pose = ran.push.trajectory.pose[np.r_[0:SAMPLES, SAMPLES + 1]]
                paths[batch, cycle] = placed(pose.T, np.array(slider.centre_of_mass))
            else:
                push, drag = loop.strokes(theta[batch, cycle], loop.push.distance / _STEPS)
                theta[batch, cycle + 1] = drag.end.theta
                course = push.trajectory
                centre = placed(course.pose.T, np.array(loop.slider.centre_of_mass))
                travel = np.linspace(0.0, loop.push.distance, SAMPLES + 1)
                paths[batch, cycle] = np.stack(
                    [np.interp(travel, course.path, values) for values in centre.T], axis=-1
                )
            if progress is not None:
                progress((batch * length + cycle + 1) / theta[:, 1:].size)
    return BatchRun(theta, paths)


def _require_room(batches: int, cycles: int) -> None:
    numbers = 2 * (SAMPLES + 1) * batches * cycles
    require_room(
        "numbers of the paths of a batch experiment", numbers, "run fewer batches or cycles"
    )
