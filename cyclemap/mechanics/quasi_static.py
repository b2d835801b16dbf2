"""The quasi-static model of one slider on one surface with one rod: pushes it, and drags it back in its ring."""

import math
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache

import numpy as np
from scipy.constants import g as GRAVITY

from cyclemap.checks import finite_number, non_negative_number, positive_number
from cyclemap.errors import InvalidInput, RodInsideObject, RodMissesObject, UnsupportedContact
from cyclemap.mechanics.compiled.recorded_strokes import recorded_leg, recorded_push, stroke_kind
from cyclemap.mechanics.compiled.stroke_library import StrokeKind
from cyclemap.mechanics.contact_curve import OutlinePiece, RingPiece, contact_curve, side_coordinate
from cyclemap.mechanics.contact_solver import ContactSolver
from cyclemap.mechanics.event_integration import NO_LEG
from cyclemap.mechanics.first_touch import first_touch, overlaps
from cyclemap.mechanics.footprint import Footprint, PatchFootprint
from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.mechanics.handling import DragLeg, DragResult, PushResult
from cyclemap.mechanics.limit_surface import normalised
from cyclemap.mechanics.motion import Rod
from cyclemap.mechanics.outline import Ellipse, Outline
from cyclemap.mechanics.protocol import Pose, SidePush, WorldPush
from cyclemap.mechanics.push_run import PushRun, PushStart, run_push
from cyclemap.mechanics.pusher import Pusher
from cyclemap.mechanics.ring_leg import has_one_spin, run_leg
from cyclemap.mechanics.slider import Slider
from cyclemap.mechanics.trajectory import Frame

# What a step may be off by, as a share of the accuracy asked of the whole motion; measured in tests/mechanics.
_STEP_SHARE = 0.05


@dataclass(frozen=True)
class QuasiStaticModel:
    """A slider on a surface, and the rod that moves it.

    Parameters
    ----------
    slider, friction, pusher : the object, the surface under it, the rod.
    footprint : how the weight is spread; None: evenly over the outline, leaning where the centre of mass is not the
        centroid.
    accuracy : error (rad; extents of the footprint) aimed at for a whole push or drag, between 1e-11 and 1e-2. On
        MIT's loop 99 of 100 cycles came within 0.6 times of it and the worst within 1.2 (asked: 1e-5 to 1e-8, five
        materials); a motion that starts unstable magnifies its error as it does any difference.

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

    def __post_init__(self) -> None:
        accuracy = positive_number("accuracy", self.accuracy)
        if not 1e-11 <= accuracy <= 1e-2:
            raise InvalidInput(f"accuracy {accuracy} is out of reach: choose one from 1e-11 to 1e-2 rad")

    def __getstate__(self) -> dict[str, object]:
        # What was computed from the fields stays behind: CasADi's buffers cannot be copied to another process.
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def pressure(self) -> Footprint:
        """The footprint in use."""
        if self.footprint is not None:
            return self.footprint
        assert self.slider.centre_of_mass is not None
        return _under(self.slider.outline, self.slider.centre_of_mass)

    @cached_property
    def unit(self) -> float:
        """Unit of length of the normalised motion: the footprint's extent, m."""
        return self.pressure.extent

    @cached_property
    def solver(self) -> ContactSolver:
        """The contact equations, ready to be solved."""
        return ContactSolver(normalised(self.pressure), self.friction)

    @cached_property
    def pieces(self) -> tuple[OutlinePiece, ...]:
        """The contact curve, in units of `unit`."""
        return contact_curve(self._outline, self.radius)

    @property
    def radius(self) -> float:
        """The rod's radius in units of `unit`."""
        return self.pusher.radius / self.unit

    @cached_property
    def stroke_kind(self) -> StrokeKind | None:
        """What compiled strokes have to know of the model; None where only Python can run them."""
        return stroke_kind(normalised(self.pressure), self.pieces, self.radius)

    @cached_property
    def _outline(self) -> Outline:
        return _scaled(self.slider.outline, 1.0 / self.unit)

    @property
    def step_tolerance(self) -> float:
        """Error that one step may have, rad or extents."""
        return _STEP_SHARE * self.accuracy

    @property
    def weight(self) -> float:
        """The slider's weight, N."""
        return self.slider.mass * float(GRAVITY)

    def push(self, pose: Pose, push: SidePush | WorldPush, longest_step: float = math.inf) -> PushResult:
        """Push the slider from a pose.

        `longest_step` (m) bounds the spacing of the trajectory's samples. Raises InvalidInput for a contact that does
        not exist or a push that points away, UnsupportedContact and ConvergenceError as `run_push` tells.
        """
        start, direction, rod_start, length = self.start(pose, push)
        rod = Rod(self.radius, self.pusher.friction, direction)
        tolerance, longest = self.step_tolerance, longest_step / self.unit
        given = (self.solver, self.pieces, start, rod, length, tolerance, longest)
        run = recorded_push(self.stroke_kind, *given) or run_push(*given)
        self._refuse_overlap(run)
        frame = Frame(self.unit, rod_start, self.weight)
        return PushResult(pose, self._end_pose(run, frame), run.ended, run, frame)

    def drag(
        self,
        pose: Pose,
        way_points: tuple[tuple[float, float], ...],
        longest_step: float = math.inf,
        pin_friction_radius: float = 0.0,
    ) -> DragResult:
        """Drag the slider by its ring, straight through way-points (m, world frame), from a pose.

        `pin_friction_radius` (m): radius rho of the friction circle of the rod in the ring. With F = dD/dv the rod's
        force, the spin omega solves dD/domega = -sign(omega) rho |F| about the ring; where even omega = 0 asks for less
        torque, the object does not turn. The left side grows with omega, and so does the difference of both sides while
        rho is below half the ring's lever from the centre of pressure and the friction ellipse's centre within 60 % of
        its smaller axis (tests/mechanics/test_ring_friction.py): then there is one spin. From the whole lever on the
        ring always holds the object, since friction in translation acts at the centre of pressure. In between, and on
        laws more one-sided, there is a spin wherever the ring does not hold the object, but it may end on the way, at
        an orientation where the ring does: raises UnsupportedContact there.
        """
        radius = non_negative_number("pin friction radius", pin_friction_radius) / self.unit
        legs, now = [], pose
        for goal in way_points:
            leg = self._drag_leg(now, goal, radius, longest_step)
            if leg is None:
                continue
            legs.append(leg)
            now = _pose_from_ring(goal, float(leg.phase.phase.steps[-1].end[0]), self.slider.hitch)
        return DragResult(pose, now, tuple(legs))

    def ring_place(self, pose: Pose) -> tuple[float, float]:
        """Return where the ring is in the world at a pose, m."""
        return pose.to_world(*self.slider.hitch)

    def _drag_leg(
        self, pose: Pose, goal: tuple[float, float], friction_radius: float, longest_step: float
    ) -> DragLeg | None:
        ring = self.ring_place(pose)
        dx, dy = finite_number("way-point x", goal[0]) - ring[0], finite_number("way-point y", goal[1]) - ring[1]
        length = math.hypot(dx, dy) / self.unit
        if length <= NO_LEG:
            return None
        piece = RingPiece((self.slider.hitch[0] / self.unit, self.slider.hitch[1] / self.unit))
        rod = Rod(0.0, friction_radius, math.atan2(dy, dx))
        given = (self.solver, piece, pose.theta, rod, length, self.step_tolerance, longest_step / self.unit)
        leg = recorded_leg(self.stroke_kind, *given) if self.one_spin(friction_radius * self.unit) else None
        return DragLeg(leg or run_leg(*given), Frame(self.unit, ring, self.weight))

    def one_spin(self, pin_friction_radius: float) -> bool:
        """Whether a friction circle of the ring (m) leaves no choice of spins, as `has_one_spin` tells."""
        return has_one_spin(pin_friction_radius, self.ring_lever)

    @property
    def ring_lever(self) -> float:
        """Distance of the ring from the centre of pressure, m."""
        return math.dist(self.slider.hitch, self.pressure.centre)

    def start(self, pose: Pose, push: SidePush | WorldPush) -> tuple[PushStart, float, tuple[float, float], float]:
        """Return start state, direction (world), the rod's place at first touch (m) and the travel left (units)."""
        if isinstance(push, SidePush):
            index, coordinate = side_coordinate(self._outline, self.pieces, push.side, push.fraction)
            contact, _ = self.pieces[index].contact(coordinate, self.radius)
            direction = pose.theta + contact.normal + math.pi + push.angle
            length = push.distance / self.unit
        else:
            direction = push.direction
            travel, index, coordinate = self._touch(pose, push)
            length = push.distance / self.unit - travel
            if length <= 0.0:
                raise RodMissesObject(
                    f"the rod stops {-length * self.unit * 1e3:.3g} mm short of the object: lengthen the push"
                )
        place = self.rod_place(pose, index, coordinate)
        return PushStart(index, coordinate, pose.theta), direction, place, length

    def _touch(self, pose: Pose, push: WorldPush) -> tuple[float, int, float]:
        start = np.array(pose.to_object(*push.start)) / self.unit
        if overlaps(self._outline, self.radius, start):
            raise RodInsideObject(f"the rod starts inside the object, at {push.start} m: move its start outside")
        touch = first_touch(self.pieces, self.radius, start, push.direction - pose.theta)
        if touch is None:
            raise RodMissesObject(
                f"the rod never touches the object: from {push.start} m its path in direction {push.direction:.6g} rad "
                "passes it by or points away"
            )
        return touch

    def rod_place(self, pose: Pose, piece: int, coordinate: float) -> tuple[float, float]:
        """Return where the rod's centre is in the world (m) when it touches at a place of the contact curve."""
        contact, _ = self.pieces[piece].contact(coordinate, self.radius)
        x, y = contact.rod_centre(self.radius)
        return pose.to_world(self.unit * x, self.unit * y)

    def _end_pose(self, run: PushRun, frame: Frame) -> Pose:
        last = run.phases[-1].motion
        travel = frame.unit * run.length
        rod_x = frame.rod_start[0] + travel * math.cos(last.rod.direction)
        rod_y = frame.rod_start[1] + travel * math.sin(last.rod.direction)
        theta = float(run.end[0])
        x, y = self.rod_place(Pose(0.0, 0.0, theta), self.pieces.index(last.piece), float(run.end[1]))
        return Pose(rod_x - x, rod_y - y, theta)

    def _refuse_overlap(self, run: PushRun) -> None:
        """A rod that rolls along a concave outline may run into another side."""
        if isinstance(self._outline, Ellipse) or self._outline.is_convex:
            return
        for phase in run.phases:
            for taken in phase.phase.steps:
                contact, _ = phase.motion.piece.contact(float(taken.end[1]), self.radius)
                if self._outline.distance(contact.rod_centre(self.radius)) < self.radius - 1e-7:
                    raise UnsupportedContact(
                        "the rod runs into another side of this concave outline: use a thinner rod or push less far"
                    )


# Many models are of few objects.
_under = lru_cache(maxsize=256)(PatchFootprint.under)


@lru_cache(maxsize=256)
def _scaled(outline: Outline, factor: float) -> Outline:
    return outline.scaled(factor)


def _pose_from_ring(ring: tuple[float, float], theta: float, hitch: tuple[float, float]) -> Pose:
    """Return the pose at orientation theta whose ring is at a place."""
    x, y = Pose(0.0, 0.0, theta).to_world(*hitch)
    return Pose(ring[0] - x, ring[1] - y, theta)
