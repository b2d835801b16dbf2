"""The data-collection loop run by the dynamic simulation, beside the quasi-static loop; and the
paper's numerical experiment: batches of consecutive cycles from several orientations, and where
they end.
"""

import math
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, along_way, even_angles, placed, turned
from cyclemap.checks import finite_array, finite_number, require_room, whole_number
from cyclemap.collection.cycles import Cycles, CycleTrajectory, StrokePair
from cyclemap.collection.loop import CollectionLoop, SentByFields, require_loop
from cyclemap.collection.loop_surfaces import isotropic_twin
from cyclemap.collection.uncertain_directions import clusters
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import PointFootprint, PressedFootprint
from cyclemap.mechanics.dynamic_model import GRID, SAMPLES, DynamicModel
from cyclemap.mechanics.footprint import pressure_points
from cyclemap.mechanics.trajectory import DynamicDrag, DynamicPush, DynamicTrajectory
from cyclemap.progress import Progress, unheard

# What a comparison tells of both models.
QUANTITIES = ("push_turn", "drag_turn", "theta_next", "push_displacement")
# Ma & Rodriguez (2018): 600 cycles in 6 batches.
BATCHES = 6
CYCLES = 100
# A batch has settled once it stays this near its last orientation, rad.
WITHIN = math.radians(1.0)
# A batch that turns by less than this a cycle, rad, is at rest: the errors of a dynamic cycle are
# as large.
REST = 5e-5
# Places kept of the centre's path in each push of a batch, beside its start.
PLACES = 20
# Longest step of a quasi-static push, as a fraction of it: between steps its path is taken as
# straight.
_STEPS = 40


@dataclass(frozen=True, eq=False)
class DynamicCycle(StrokePair[DynamicPush, DynamicDrag]):
    """One push and reset by the dynamic simulation, told as a `Cycle`'s.

    Attributes
    ----------
    theta : float
        Orientation before, rad.
    push : DynamicPush
        The push.
    drag : DynamicDrag
        The drag back.
    push_turn, drag_turn : float
        Turns of the object, rad.
    push_displacement : ndarray, shape (2,)
        Of the object's origin in its initial frame, m.
    drag_length : float
        Path of the rod in the drag, m.
    theta_next : float
        Orientation after, rad on the lift: theta + push_turn + drag_turn.
    ended : str
        Why the push ended, `distance`, or `left` where the rod lost the object.

    Examples
    --------
    >>> import math
    >>> from cyclemap.collection import CollectionLoop, DynamicLoop
    >>> cycle = DynamicLoop(CollectionLoop.mit()).cycle(1.0)
    >>> cycle.ended, round(math.degrees(cycle.theta_next), 1)
    ('distance', 57.6)
    """

    @property
    def trajectory(self) -> CycleTrajectory[DynamicTrajectory]:
        """The course of the cycle, as sampled."""
        return CycleTrajectory(self.push.trajectory, self.drag.trajectory)


@dataclass(frozen=True)
class DynamicLoop(SentByFields):
    """A collection loop whose strokes are run by `DynamicModel`, at rest in between.

    Parameters
    ----------
    loop : CollectionLoop
        The protocol; it stands on its own support points, or else on those that carry its
        patch's pressure (`on_points`).
    speed : float, default 0.02
        Speed of the rod, m/s, as `DynamicModel` takes and checks it.
    stiffness : float, default 1e6
        Of the contact and the ring, N/m, as `DynamicModel`'s.
    regularisation : float, default 1e-4
        Speed below which friction fades, as a share of the rod's, as `DynamicModel`'s.
    tolerance : float, default 1e-7
        Relative error of a step, as `DynamicModel`'s.

    Raises
    ------
    InvalidInput
        For a loop that is none, and where the parts do not fit each other.

    Examples
    --------
    >>> import math
    >>> from cyclemap.collection import CollectionLoop, DynamicLoop
    >>> cycle = DynamicLoop(CollectionLoop.mit()).cycle(0.0)
    >>> round(math.degrees(cycle.push_turn), 1), round(math.degrees(cycle.drag_turn), 1)
    (73.9, -64.2)
    """

    loop: CollectionLoop
    speed: float = 0.02
    stiffness: float = 1e6
    regularisation: float = 1e-4
    tolerance: float = 1e-7

    def __post_init__(self) -> None:
        require_loop(self.loop)
        # Made here, so that its checks refuse here what does not fit.
        self.model  # noqa: B018

    @cached_property
    def model(self) -> DynamicModel:
        """The mechanics. Raises InvalidInput where the parts do not fit each other."""
        return DynamicModel(
            self.loop.slider,
            self.loop.material.friction,
            self.loop.pusher,
            on_points(self.loop).footprint,
            self.speed,
            self.stiffness,
            regularisation=self.regularisation,
            tolerance=self.tolerance,
        )

    def cycle(self, theta: float, samples: int = SAMPLES) -> DynamicCycle:
        """Run one push and reset from orientation `theta` (rad); `samples` of the course of each
        leg are kept.
        """
        theta = finite_number("theta", theta)
        push = self.model.push(self.loop.start_pose(theta), self.loop.push, samples)
        way_points = (*self.loop.reset.way_points, (0.0, 0.0))
        drag = self.model.drag(push.end, way_points, samples, self.loop.reset.pin_friction_radius)
        return DynamicCycle(theta, push, drag)

    def cycles(self, theta: ArrayLike) -> Cycles:
        """Run one push and reset from each of many orientations (...), rad."""
        values = finite_array("theta", theta)
        runs = [self.cycle(each, samples=1) for each in values.ravel().tolist()]
        columns = {}
        for name in (field.name for field in fields(Cycles)[1:-1]):
            shape = (*values.shape, 2) if name == "push_displacement" else values.shape
            columns[name] = np.array([getattr(run, name) for run in runs], dtype=float).reshape(
                shape
            )
        left = np.array([run.ended == "left" for run in runs], dtype=bool).reshape(values.shape)
        return Cycles(values, left=left, **columns)


@dataclass(frozen=True, eq=False)
class DynamicsComparison:
    """Cycles from the same orientations by the dynamic simulation and by the quasi-static model, on
    the same points.

    Attributes
    ----------
    loop : DynamicLoop
        What was compared.
    dynamic : Cycles
        Cycles by the dynamic simulation.
    quasi_static : Cycles
        Cycles by the quasi-static model.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.collection import CollectionLoop, DynamicLoop, compare_dynamics
    >>> comparison = compare_dynamics(DynamicLoop(CollectionLoop.mit()), [0.0])
    >>> np.degrees(comparison.quasi_static.push_turn).round(1).tolist()
    [73.9]
    >>> bool(abs(np.degrees(comparison.difference("push_turn")[0])) < 0.05)
    True
    """

    loop: DynamicLoop
    dynamic: Cycles
    quasi_static: Cycles

    def difference(self, quantity: str) -> Array:
        """Return dynamic less quasi-static of push_turn, drag_turn, theta_next (rad) or
        push_displacement (m).
        """
        if quantity not in QUANTITIES:
            raise InvalidInput(
                f"a comparison has no difference {quantity!r}: choose one of "
                f"{', '.join(QUANTITIES)}"
            )
        return np.asarray(getattr(self.dynamic, quantity) - getattr(self.quasi_static, quantity))


def compare_dynamics(loop: DynamicLoop, theta: ArrayLike) -> DynamicsComparison:
    """Run cycles by the dynamic simulation and by the quasi-static model, on the same support
    points.

    Parameters
    ----------
    loop : DynamicLoop
        The loop; its support points are those of `on_points`.
    theta : array_like, shape (...)
        Orientations that the cycles start from, rad.

    Returns
    -------
    DynamicsComparison
        The cycles of both, in the shape of theta.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.collection import CollectionLoop, DynamicLoop, compare_dynamics
    >>> comparison = compare_dynamics(DynamicLoop(CollectionLoop.mit()), [0.0])
    >>> np.degrees(comparison.dynamic.push_turn).round(1).tolist()
    [73.9]
    """
    if not isinstance(loop, DynamicLoop):
        raise InvalidInput(
            "what is compared must be a DynamicLoop, such as DynamicLoop(loop), not a "
            f"{type(loop).__name__}"
        )
    return DynamicsComparison(loop, loop.cycles(theta), on_points(loop.loop).cycles(theta))


def on_points(loop: CollectionLoop) -> CollectionLoop:
    """Return the loop standing on points: its own, or those that carry its patch's pressure
    (`pressure_points`).

    Turns of a cycle on plywood from 12 orientations are within 0.44 degrees in the push, 0.63 in
    the drag and 0.25 in both of those on the patch, as the even grid's are. Shapes of plate and
    floor stay: the dynamic model's points follow them, the quasi-static one has the exact contact.
    Raises InvalidInput for a pressure that points cannot carry.
    """
    if isinstance(require_loop(loop).footprint, (PointFootprint, PressedFootprint)):
        return loop
    return replace(loop, footprint=pressure_points(loop.model.pressure, GRID))


# -- the paper's numerical experiment: batches of cycles


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
        return turned(self.path - self.path[:, :, :1], -self.theta[:, :-1, None])

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
    length = whole_number("cycles", cycles, least=1)
    numbers = 2 * (PLACES + 1) * count * length
    require_room(
        "numbers of the paths of a batch experiment", numbers, "run fewer batches or cycles"
    )
    report = progress or unheard
    starts = even_angles(count)
    protocol, speed = (loop.loop, loop.speed) if isinstance(loop, DynamicLoop) else (loop, None)
    even = isotropic_twin(protocol)
    anisotropic = run_batches(loop, starts, length, lambda done: report(0.5 * done))
    twin = replace(loop, loop=even) if isinstance(loop, DynamicLoop) else even
    isotropic = run_batches(twin, starts, length, lambda done: report(0.5 + 0.5 * done))
    return BatchExperiment(protocol, speed, starts, anisotropic, isotropic)


def run_batches(
    loop: DynamicLoop | CollectionLoop, starts: Array, cycles: int, progress: Progress
) -> BatchRun:
    """Run a batch of consecutive cycles from each of the orientations `starts` (rad)."""
    protocol = loop.loop if isinstance(loop, DynamicLoop) else loop
    middle = np.array(protocol.slider.centre_of_mass)
    travel = np.linspace(0.0, protocol.push.distance, PLACES + 1)
    theta = np.empty((len(starts), cycles + 1))
    theta[:, 0] = starts
    paths = np.empty((len(starts), cycles, PLACES + 1, 2))
    for batch in range(len(starts)):
        for cycle in range(cycles):
            if isinstance(loop, DynamicLoop):
                ran = loop.cycle(theta[batch, cycle], PLACES)
                theta[batch, cycle + 1] = ran.theta_next
                # The last sample, at rest, takes the place of that where the rod stops.
                pose = ran.push.trajectory.pose[np.r_[0:PLACES, PLACES + 1]]
                paths[batch, cycle] = placed(pose.T, middle)
            else:
                push, drag = loop.strokes(theta[batch, cycle], loop.push.distance / _STEPS)
                theta[batch, cycle + 1] = drag.end.theta
                course = push.trajectory
                paths[batch, cycle] = along_way(travel, course.path, placed(course.pose.T, middle))
            progress((batch * cycles + cycle + 1) / theta[:, 1:].size)
    return BatchRun(theta, paths)
