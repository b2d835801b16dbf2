"""What a push or a drag comes to, and its whole course in the world, SI units."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.mechanics.engine.schema import MODES, RECORD
from cyclemap.mechanics.engine.strokes import Strokes, record
from cyclemap.mechanics.slider import Pose

# Of each mode: its name, the sign of its friction, whether it is on the outline and sticks.
_NAMES, _SIGNS = np.array([mode.name for mode in MODES]), np.array([mode.sign for mode in MODES])
_ON_OUTLINE = np.array([mode.place == "outline" for mode in MODES])
_STICKS = np.array([mode.law == "stick" for mode in MODES])


@dataclass(frozen=True)
class Trajectory:
    """A motion sampled at the ends of its steps.

    Attributes
    ----------
    path : ndarray, shape (n,)
        Rod travel, m.
    pose : ndarray, shape (n, 3)
        The object's x, y (m) and theta (rad).
    pusher : ndarray, shape (n, 2)
        The rod's centre, m.
    contact_point : ndarray, shape (n, 2)
        The place of contact, m; of two contacts at once, the first.
    contact_force : ndarray, shape (n, 2)
        Force of the rod on the object, N; of two contacts, their sum.
    mode : ndarray of str, shape (n,)
        Stick, slide_left, slide_right, slide_free; in a concave corner wedge_left, wedge_right,
        wedge_stuck; in the ring: ring, with friction ring_left, ring_right, ring_stuck.
    phase : ndarray of int, shape (n,)
        Number of the stretch under one law to which the sample belongs.
    residual : float
        How far forces are from what the laws ask for, at worst over the samples, relative to
        the friction coefficients: of the balance, and of the friction cone of the contact.

    Examples
    --------
    >>> import cyclemap as cm
    >>> course = cm.CollectionLoop.mit().cycle(0.0).push.trajectory
    >>> str(course.mode[0]), round(float(course.path[-1]), 3), course.residual < 1e-6
    ('slide_right', 0.147, True)
    """

    path: Array
    pose: Array
    pusher: Array
    contact_point: Array
    contact_force: Array
    mode: NDArray[np.str_]
    phase: NDArray[np.intp]
    residual: float


@dataclass(frozen=True, eq=False)
class Course:
    """What the engine was asked for, so that it can be written down.

    Attributes
    ----------
    strokes : Strokes
        What was asked.
    pose : tuple[float, float, float]
        Where the object was before (extents, rad).
    unit : float
        Of length, m.
    weight : float
        Of the object, N.
    scale : float
        The mean friction coefficient.
    longest : float
        Bound on the spacing of samples, extents.
    """

    strokes: Strokes
    pose: tuple[float, float, float]
    unit: float
    weight: float
    scale: float
    longest: float

    @cached_property
    def rows(self) -> Array:
        """What the engine wrote down (n, 16), columns of RECORD.

        Raises ConvergenceError where it cannot follow the motion in steps so short.
        """
        try:
            return record(self.strokes, self.pose, self.longest)
        except ConvergenceError as cause:
            if math.isinf(self.longest):
                raise
            raise ConvergenceError(
                f"{cause}, or a longest_step above {self.unit * self.longest:.3g} m"
            ) from cause

    def trajectory(self, of_push: bool) -> Trajectory:
        """Return the course of the push, or of all legs of the drag."""
        of_first = RECORD.columns_of(self.rows).stroke == 0.0
        recorded = RECORD.columns_of(self.rows[of_first & (self.strokes.length > 0.0) == of_push])
        modes = recorded.mode.astype(int)
        # How far a contact's force lies outside the friction cone, or off its edge where the rod
        # slides.
        limit = self.strokes.rod_friction * recorded.compression
        inside = np.abs(recorded.tangential) - limit
        off_edge = np.abs(recorded.tangential - _SIGNS[modes] * limit)
        off = np.maximum(np.where(_STICKS[modes], inside, off_edge), -recorded.compression)
        outside = off[_ON_OUTLINE[modes]].max(initial=0.0)
        return Trajectory(
            path=self.unit * recorded.way,
            pose=np.column_stack([self.unit * recorded.place, recorded.theta]),
            pusher=self.unit * recorded.rod,
            contact_point=self.unit * recorded.touch,
            contact_force=self.scale * self.weight * recorded.force,
            mode=_NAMES[modes],
            phase=np.cumsum(np.diff(recorded.way, prepend=-1.0) <= 0.0),
            residual=float(max(recorded.residual.max(), outside)),
        )


@dataclass(frozen=True)
class Stroke:
    """What the rod does in one go: the object's poses before and after."""

    start: Pose
    end: Pose

    @property
    def turn(self) -> float:
        """Turn of the object, rad."""
        return self.end.theta - self.start.theta

    @property
    def displacement(self) -> Array:
        """Displacement of the object's origin in its initial frame, (2,), m."""
        return np.array(self.start.to_object(self.end.x, self.end.y))


@dataclass(frozen=True)
class PushResult(Stroke):
    """A push of the quasi-static model.

    Attributes
    ----------
    ended : str
        Why the push ended: `distance`, or `left` where the rod no longer approaches.
    travel : float
        Rod travel in contact, m.
    is_ambiguous : bool
        Whether it came into a concave corner from which more than one motion balances all
        forces, mostly being wedged beside another one; that without squeezing was taken.
    course : Course
        What was run.
    start : Pose
        The object before.
    end : Pose
        The object after.

    Notes
    -----
    A rod leaves where it no longer approaches; one that still sticks then could pull the object
    along by friction for a while: here it leaves.

    Examples
    --------
    >>> import cyclemap as cm
    >>> push = cm.CollectionLoop.mit().cycle(0.0).push
    >>> push.ended, round(push.travel, 3), round(push.turn, 4)
    ('left', 0.147, 1.2855)
    """

    ended: str
    travel: float
    is_ambiguous: bool
    course: Course

    @cached_property
    def trajectory(self) -> Trajectory:
        """The course of the push in the world."""
        return self.course.trajectory(of_push=True)


@dataclass(frozen=True)
class DragResult(Stroke):
    """A drag of the quasi-static model.

    Attributes
    ----------
    length : float
        Path of the ring, m (0 where the ring was already there).
    course : Course
        What was run.
    start : Pose
        The object before.
    end : Pose
        The object after.

    Examples
    --------
    >>> import cyclemap as cm
    >>> drag = cm.CollectionLoop.mit().cycle(0.0).drag
    >>> round(drag.length, 5), round(drag.turn, 4)
    (0.09349, -1.1116)
    """

    length: float
    course: Course

    @cached_property
    def trajectory(self) -> Trajectory:
        """The course of the drag in the world."""
        if self.length == 0.0:
            raise InvalidInput("this drag has no length, so that it has no trajectory")
        return self.course.trajectory(of_push=False)


@dataclass(frozen=True, eq=False)
class DynamicTrajectory:
    """A motion sampled evenly in time while the rod moves, and once more when the object rests, in
    the world frame.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Since the stroke began, s.
    path : ndarray, shape (n,)
        Rod travel, m.
    pose : ndarray, shape (n, 3)
        The object's x, y (m) and theta (rad).
    velocity : ndarray, shape (n, 3)
        Of the centre of mass, m/s, and spin, rad/s.
    pusher : ndarray, shape (n, 2)
        The rod's centre, m.
    contact_point : ndarray, shape (n, 2)
        The place of contact, m.
    contact_force : ndarray, shape (n, 2)
        Force of the rod on the object, N; zero where they do not touch.

    Examples
    --------
    >>> import cyclemap as cm
    >>> friction = cm.EllipseFriction.isotropic(0.25)
    >>> model = cm.mechanics.DynamicModel(cm.Slider.mit("rect1"), friction)
    >>> course = model.push(cm.Pose(), cm.SidePush(), samples=5).trajectory
    >>> course.time.round(2).tolist()
    [0.0, 1.5, 3.0, 4.5, 6.0, 7.5, 7.53]
    """

    time: Array
    path: Array
    pose: Array
    velocity: Array
    pusher: Array
    contact_point: Array
    contact_force: Array


@dataclass(frozen=True, eq=False)
class DynamicPush(Stroke):
    """A push of the dynamic model.

    Attributes
    ----------
    ended : str
        Why the push ended: `distance`, or `left` where the rod has lost the object.
    trajectory : DynamicTrajectory
        Its course.
    start : Pose
        The object before.
    end : Pose
        The object after.

    Examples
    --------
    >>> import cyclemap as cm
    >>> friction = cm.EllipseFriction.isotropic(0.25)
    >>> model = cm.mechanics.DynamicModel(cm.Slider.mit("rect1"), friction)
    >>> push = model.push(cm.Pose(), cm.SidePush())
    >>> push.ended, round(push.turn, 3)
    ('distance', 1.305)
    """

    ended: str
    trajectory: DynamicTrajectory


@dataclass(frozen=True, eq=False)
class DynamicDrag(Stroke):
    """A drag of the dynamic model.

    Attributes
    ----------
    length : float
        Path of the rod, m.
    trajectory : DynamicTrajectory
        Its course.
    start : Pose
        The object before.
    end : Pose
        The object after.

    Examples
    --------
    >>> import cyclemap as cm
    >>> friction = cm.EllipseFriction.isotropic(0.25)
    >>> model = cm.mechanics.DynamicModel(cm.Slider.mit("rect1"), friction)
    >>> drag = model.drag(cm.Pose(), ((0.05, 0.0),))
    >>> round(drag.length, 4), round(drag.turn, 3)
    (0.0615, -0.72)
    """

    length: float
    trajectory: DynamicTrajectory
