"""The quasi-static model of one slider on one surface with one rod: pushes it, and drags it back in
its ring.
"""

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from types import NoneType

import numpy as np

from cyclemap.checks import non_negative_number, positive_number, require_kind
from cyclemap.errors import (
    ConvergenceError,
    DoubtfulInput,
    InvalidInput,
    RodInsideObject,
    RodMissesObject,
    TooManySteps,
    UnsupportedContact,
)
from cyclemap.mechanics.contact_curve import (
    OVERLAP,
    ContactCurve,
    contact_curve,
    first_touches,
    side_coordinate,
)
from cyclemap.mechanics.engine import strokes as engine
from cyclemap.mechanics.engine.schema import KINDS, LAW, PARAMETERS, PIECE, Status
from cyclemap.mechanics.engine.strokes import Ran, Strokes, piece_table, pressure_tables
from cyclemap.mechanics.footprint import FOOTPRINTS, Footprint, PatchFootprint, PointFootprint
from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.mechanics.outline import Outline
from cyclemap.mechanics.slider import (
    DragBack,
    Pose,
    Pusher,
    SidePush,
    Slider,
    WorldPush,
    places_of,
)
from cyclemap.mechanics.trajectory import Course, DragResult, PushResult

# What a step may be off by, as a share of the accuracy asked of the whole motion; measured in
# tests/mechanics.
STEP_SHARE = 0.05
# Footprints smaller than this share of the outline's extent carry no object.
_LEAST_FOOTPRINT = 1e-3
# A footprint that reaches beyond this many extents of the outline is doubtful.
_FARTHEST = 1.02
# Places on a footprint's outline at which that is asked.
_PLACES = 90
# The reset's target, in every loop's frame.
_TARGET = (0.0, 0.0)


@dataclass(frozen=True)
class QuasiStaticModel:
    """A slider on a surface, and the rod that moves it, so slowly that friction balances the rod at
    every instant.

    Parameters
    ----------
    slider : Slider
        The object.
    friction : EllipseFriction
        That of the surface under it.
    pusher : Pusher, optional
        The rod.
    footprint : Footprint or None, optional
        How the weight is spread, its centre of pressure included, whatever the object's centre
        of mass; None: evenly over the outline, leaning where the centre of mass is not the
        centroid.
    accuracy : float, default 1e-8
        Error (rad; extents of the footprint) aimed at for a whole push or drag, between 1e-11
        and 1e-2. It is aimed at, not proven: of 30,000 cycles of MIT's loop (five materials,
        three places and slants of the push) at each of 1e-5 to 1e-9, 99 of 100 came within
        twice of it and the worst within 22 times, the travel of a push that the rod leaves
        included; a motion that starts unstable magnifies its error as it does any difference.

    Attributes
    ----------
    pressure : Footprint
        The footprint in use.
    weight : float
        Weight of the slider, N.
    unit : float
        Unit of length of the normalised motion, the footprint's extent, m.
    scale : float
        Unit of friction of the normalised motion, the geometric mean of the coefficients mu_a
        and mu_b.
    radius : float
        The rod's, in units of length.

    Raises
    ------
    InvalidInput
        For parts that are none, an accuracy out of reach, and support points that the object
        would tip from.

    Warns
    -----
    DoubtfulInput
        Where the footprint reaches out of the object.

    Examples
    --------
    >>> import math
    >>> from cyclemap import EllipseFriction, Pose, QuasiStaticModel, SidePush, Slider
    >>> model = QuasiStaticModel(Slider.mit("rect1"), EllipseFriction.isotropic(0.25))
    >>> push = model.push(Pose(), SidePush(side=0, fraction=0.7))
    >>> round(math.degrees(push.turn), 4), push.ended
    (74.5204, 'distance')
    """

    slider: Slider
    friction: EllipseFriction
    pusher: Pusher = Pusher()
    footprint: Footprint | None = None
    accuracy: float = 1e-8
    pressure: Footprint = field(init=False, repr=False, compare=False)
    weight: float = field(init=False, repr=False, compare=False)
    unit: float = field(init=False, repr=False, compare=False)
    scale: float = field(init=False, repr=False, compare=False)
    radius: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_kind("slider", self.slider, Slider)
        require_kind("friction", self.friction, EllipseFriction)
        require_kind("pusher", self.pusher, Pusher)
        require_kind("footprint", self.footprint, *FOOTPRINTS, NoneType)
        accuracy = positive_number("accuracy", self.accuracy)
        if not 1e-11 <= accuracy <= 1e-2:
            raise InvalidInput(
                f"accuracy {accuracy} is out of reach: choose one from 1e-11 to 1e-2 rad"
            )
        outline, centre, law = self.slider.outline, self.slider.centre_of_mass, self.friction
        pressure = _patch(outline, centre=centre) if self.footprint is None else self.footprint
        size, whole = pressure.extent, outline.extent
        if size < _LEAST_FOOTPRINT * whole:
            raise InvalidInput(
                f"the support points lie within {size * 1e3:.3g} mm of their centre, under an "
                f"object of {whole * 1e3:.3g} mm: it would tip rather than slide; give points that "
                "span it"
            )
        reach = _reach(pressure, self.slider)
        if reach > _FARTHEST * whole:
            doubt = (
                f"the footprint reaches {1e3 * reach:.4g} mm from the object's centroid, the "
                f"object {1e3 * whole:.4g} mm: is it in metres, and of this object?"
            )
            warnings.warn(doubt, DoubtfulInput, stacklevel=4)
        vars(self).update(
            pressure=pressure,
            weight=self.slider.weight,
            unit=size,
            radius=self.pusher.radius / size,
            scale=math.sqrt(law.mu_a) * math.sqrt(law.mu_b),
        )

    @property
    def isotropic(self) -> "QuasiStaticModel":
        """The same slider and rod where nothing is known of the surface: one friction all around,
        even pressure.
        """
        return replace(self, friction=EllipseFriction.isotropic(self.scale), footprint=None)

    @cached_property
    def curve(self) -> ContactCurve:
        """The contact curve, in units of `unit`."""
        return contact_curve(_scaled(self.slider.outline, 1.0 / self.unit), self.radius)

    @cached_property
    def _still(self) -> Strokes:
        """What all strokes of the model share."""
        law, unit, scale = self.friction, self.unit, self.scale
        x, y = self.pressure.centre
        hitch_x, hitch_y = self.slider.hitch
        return Strokes(
            pressure_tables(self.pressure),
            (
                law.mu_a / scale,
                law.mu_b / scale,
                law.m0 / scale,
                law.n0 / scale,
                law.phi,
                x / unit,
                y / unit,
            ),
            self.radius,
            STEP_SHARE * self.accuracy,
            piece_table(self.curve, (hitch_x / unit, hitch_y / unit)),
            rod_friction=self.pusher.friction,
        )

    def push(
        self, pose: Pose, push: SidePush | WorldPush, longest_step: float = math.inf
    ) -> PushResult:
        """Push the slider from a pose.

        Parameters
        ----------
        pose : Pose
            Where the slider lies before.
        push : SidePush or WorldPush
            What the rod does.
        longest_step : float, optional
            Bound on the spacing of the trajectory's samples, m.

        Returns
        -------
        PushResult
            The poses before and after, and why the push ended.

        Raises
        ------
        InvalidInput
            For a contact that does not exist, a push that points away, and a bound that is not
            positive.
        UnsupportedContact
            Where the rod would slide without bound or nothing goes on.
        ConvergenceError
            Where the contact cannot be solved.
        """
        return self._moved(self.push_strokes(pose, push), pose, longest_step)[0]

    def drag(
        self,
        pose: Pose,
        way_points: tuple[tuple[float, float], ...],
        longest_step: float = math.inf,
        pin_friction_radius: float = 0.0,
    ) -> DragResult:
        """Drag the slider by its ring, straight through way-points, from a pose.

        Parameters
        ----------
        pose : Pose
            Where the slider lies before.
        way_points : tuple of tuple[float, float]
            (x, y), m, world frame, in order.
        longest_step : float, optional
            Bound on the spacing of the trajectory's samples, m.
        pin_friction_radius : float, default 0.0
            Radius rho of the friction circle of the rod in the ring, m.

        Returns
        -------
        DragResult
            The poses before and after, and the ring's path.

        Raises
        ------
        InvalidInput
            For way-points that are no places, and a bound that is not positive.
        UnsupportedContact
            Where no spin balances the torque of the ring.

        Notes
        -----
        With F = dD/dv the rod's force, the spin omega solves dD/domega = -sign(omega) rho |F| about
        the ring; where even omega = 0 asks for less torque, the object does not turn. There is one
        spin while rho is below half the ring's lever from the centre of pressure and the friction
        ellipse's centre within 60 % of its smaller axis (tests/mechanics/test_drag.py). From the
        whole lever on the ring always holds the object. In between, and on laws more one-sided,
        there is a spin wherever the ring does not hold the object, but it may end on the way, at an
        orientation where the ring does: that is refused.
        """
        return self._moved(self.drag_strokes(way_points, pin_friction_radius), pose, longest_step)[
            1
        ]

    def cycle(
        self, theta: float, push: SidePush, reset: DragBack, longest_step: float = math.inf
    ) -> tuple[PushResult, DragResult]:
        """Push the slider, its ring at the world's origin, and drag it back there.

        Parameters
        ----------
        theta : float
            Orientation before the push, rad.
        push : SidePush
            What the rod does.
        reset : DragBack
            How the object is brought back.
        longest_step : float, optional
            Bound on the spacing of the trajectory's samples, m.

        Returns
        -------
        push : PushResult
            The push.
        drag : DragResult
            The drag back.
        """
        return self._moved(self.cycle_strokes(push, reset), self.start_pose(theta), longest_step)

    def cycle_strokes(self, push: SidePush, reset: DragBack) -> Strokes:
        """Return what the engine is asked for in a cycle. Raises InvalidInput where push and object
        do not fit.
        """
        require_kind("reset", reset, DragBack)
        pushed = self.push_strokes(Pose(), push)
        dragged = self.drag_strokes((*reset.way_points, _TARGET), reset.pin_friction_radius)
        return replace(
            pushed, goals=dragged.goals, pin_friction=dragged.pin_friction, with_object=True
        )

    def start_pose(self, theta: float) -> Pose:
        """Return the pose with the ring at the world's origin, where every cycle starts."""
        x, y = Pose(0.0, 0.0, theta).to_world(*self.slider.hitch)
        return Pose(-x, -y, theta)

    def push_strokes(self, pose: Pose, push: SidePush | WorldPush) -> Strokes:
        """Return what the engine is asked for in a push from a pose; raises as `push` where they do
        not fit.
        """
        require_kind("pose", pose, Pose)
        require_kind("push", push, SidePush, WorldPush)
        if isinstance(push, WorldPush):
            return self._from_afar(pose, push)
        outline = _scaled(self.slider.outline, 1.0 / self.unit)
        index, coordinate, by_fraction = side_coordinate(
            outline, self.curve.pieces, push.side, push.fraction
        )
        contact = self.curve.pieces[index].contact(coordinate, self.radius)
        return replace(
            self._still,
            start_piece=index,
            start_coordinate=coordinate,
            by_fraction=by_fraction,
            direction=pose.theta + contact.normal + math.pi + push.angle,
            length=push.distance / self.unit,
        )

    def _from_afar(self, pose: Pose, push: WorldPush) -> Strokes:
        start = np.array([pose.to_object(*push.start)]) / self.unit
        touches = first_touches(
            self.curve.pieces, self.radius, start, np.array([push.direction - pose.theta])
        )
        travel, index, coordinate = float(touches[0][0]), int(touches[1][0]), float(touches[2][0])
        if math.isnan(travel):
            raise RodMissesObject(
                f"the rod never touches the object: from {push.start} m its path in direction "
                f"{push.direction:.6g} rad passes it by or points away"
            )
        contact = self.curve.pieces[index].contact(coordinate, self.radius)
        if travel * math.cos(push.direction - pose.theta - contact.normal) > OVERLAP:
            raise RodInsideObject(
                f"the rod starts inside the object, at {push.start} m: move its start outside"
            )
        length = push.distance / self.unit - max(travel, 0.0)
        if length <= 0.0:
            raise RodMissesObject(
                f"the rod stops {-length * self.unit * 1e3:.3g} mm short of the object: lengthen "
                "the push"
            )
        return replace(
            self._still,
            start_piece=index,
            start_coordinate=coordinate,
            direction=push.direction,
            length=length,
        )

    def drag_strokes(
        self, way_points: tuple[tuple[float, float], ...], pin_friction_radius: float
    ) -> Strokes:
        """Return what the engine is asked for in a drag through way-points (m, world frame)."""
        radius = non_negative_number("pin friction radius", pin_friction_radius) / self.unit
        goals = tuple((x / self.unit, y / self.unit) for x, y in places_of(way_points))
        return replace(self._still, goals=goals, pin_friction=radius)

    def course(self, strokes: Strokes, pose: Pose, longest_step: float = math.inf) -> Course:
        """Return strokes of this model from a pose, as `run_strokes` takes them; `longest_step` in
        m. Raises InvalidInput where that is not positive.
        """
        require_kind("pose", pose, Pose)
        if longest_step != math.inf:
            positive_number("longest_step", longest_step)
        place = (pose.x / self.unit, pose.y / self.unit, pose.theta)
        return Course(strokes, place, self.unit, self.weight, self.scale, longest_step / self.unit)

    def _moved(
        self, strokes: Strokes, pose: Pose, longest_step: float
    ) -> tuple[PushResult, DragResult]:
        """What a push, or nothing, and then a drag, or nothing, come to from a pose."""
        course, unit = self.course(strokes, pose, longest_step), self.unit
        ran = run_strokes([course])
        pushed, end = (
            Pose(unit * x, unit * y, theta)
            for x, y, theta in (ran.pushed[0].tolist(), ran.ended[0].tolist())
        )
        push = PushResult(
            start=pose,
            end=pushed,
            ended="left" if ran.left[0] else "distance",
            travel=unit * float(ran.travel[0]),
            is_ambiguous=bool(ran.is_ambiguous[0]),
            course=course,
        )
        return push, DragResult(
            pushed if strokes.length else pose, end, unit * float(ran.way[0]), course
        )


def run_strokes(courses: Sequence[Course], derivatives: int = 0, most_failing: float = 0.0) -> Ran:
    """Run what n courses tell of from where they start, which no parameter moves but `theta`, their
    turn there.

    derivatives : how many of PARAMETERS to differentiate by.
    most_failing : share of the courses that may fail, whose results are nan. Raises as the first
        that fails where more do.
    """
    poses = np.array([course.pose for course in courses])
    varied = np.zeros((len(courses), 3, derivatives))
    varied[:, 2, : PARAMETERS.index("theta") + 1] = 1.0
    ran = engine.run([course.strokes for course in courses], np.arange(len(courses)), poses, varied)
    failed = np.flatnonzero(ran.status <= 0)
    if failed.size > most_failing * len(courses):
        first = int(failed[0])
        raise refusal(int(ran.status[first]), courses[first].strokes)
    return ran


def refusal(status: int, strokes: Strokes) -> BaseException:
    """Return the error that tells why the engine stopped."""
    friction, law = strokes.rod_friction, LAW.of(strokes.friction)
    ring = KINDS["ring"].of(PIECE.of(strokes.pieces[-1]).geometry)
    lever = math.hypot(ring.x - law.centre_x, ring.y - law.centre_y)
    errors: dict[int, BaseException] = {
        Status.MANY_STEPS: TooManySteps(
            "the motion turns so abruptly towards its steady course that it needs more than 20000 "
            "steps: ask for a shorter way or less accuracy, or take a friction law nearer to "
            "isotropic, a footprint that leans less, or a thicker outline"
        ),
        Status.NO_SLIP: UnsupportedContact(
            "no slip of the rod, however fast, balances the surface's friction at pusher friction "
            f"{friction:.3g}: the friction is too one-sided for this push; choose a lower pusher "
            "friction or a smaller offset m0, n0"
        ),
        Status.POINTS_AWAY: InvalidInput(
            "the push points away from the object: its direction must have a component into the "
            "side that it touches"
        ),
        Status.NOT_ALONE: UnsupportedContact(
            "the rod is in a concave corner, and no motion with forces inside both friction cones "
            "goes on from there: push less far, or elsewhere"
        ),
        Status.RING_STOPS: UnsupportedContact(
            "the ring's friction stops the object on its way while it turns: its radius is "
            f"{strokes.pin_friction / max(lever, 1e-12):.3g} times the ring's distance from the "
            "centre of pressure; choose a smaller pin friction radius or a ring farther away"
        ),
        Status.CHATTERS: ConvergenceError(
            "the contact changes its mode more than 10000 times: it chatters"
        ),
        Status.STOPPED: KeyboardInterrupt(),
    }
    unsolved = (
        "the contact's balance of forces cannot be solved: try another accuracy, or a friction "
        "nearer to isotropic"
    )
    return errors.get(status, ConvergenceError(unsolved))


# Many models are of few objects.
_patch = lru_cache(maxsize=256)(PatchFootprint)


def _reach(pressure: Footprint, slider: Slider) -> float:
    """How far a footprint reaches from the object's centroid, m."""
    if isinstance(pressure, PointFootprint):
        return float(np.hypot(*(pressure.positions - np.array(slider.outline.centroid)).T).max())
    if pressure.outline is slider.outline:
        return slider.outline.extent
    places = pressure.outline.points(_PLACES) - np.array(slider.outline.centroid)
    return float(np.hypot(*places.T).max())


@lru_cache(maxsize=256)
def _scaled(outline: Outline, factor: float) -> Outline:
    return outline.scaled(factor)
