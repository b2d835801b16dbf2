"""The paper's dynamic simulation of one slider on one surface with one rod: pushes it, and drags it by its ring."""

import math
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import pairwise

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import non_negative_number, point, positive_number, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.mechanics.contact_curve import contact_curve, side_coordinate
from cyclemap.mechanics.dynamic_equations import PHYSICS, Leg, LegEquations
from cyclemap.mechanics.footprint import Footprint, PatchFootprint, PointFootprint, grid_footprint
from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.mechanics.outline import Outline
from cyclemap.mechanics.protocol import Pose, Pusher, SidePush
from cyclemap.mechanics.slider import GRAVITY, Slider
from cyclemap.mechanics.trajectory import Stroke

GRID = 8
# Samples of each leg, beside its start.
SAMPLES = 30
# The contact may give way by this share of the rod's radius under the slider's whole weight.
_DEEPEST = 0.1
# How long the slider is waited for at a time, in the times that its own friction takes to stop it, and how often.
_WAIT, _MOST_WAITS = 4.0, 100
# The slider rests once no speed is above this share of the rod's, or above so many creep speeds.
_REST, _REST_CREEPS = 0.01, 10.0
# A leg shorter than this (extents) is none.
_SHORTEST = 1e-12


@dataclass(frozen=True, eq=False)
class DynamicTrajectory:
    """A motion sampled evenly in time while the rod moves, and once more when the object rests, in the world frame.

    time : (n,) s. path : (n,) rod travel, m. pose : (n, 3) object's x, y (m) and theta (rad).
    velocity : (n, 3) of the centre of mass, m/s, and spin, rad/s. pusher : (n, 2) rod's centre, m.
    contact_point : (n, 2) m. contact_force : (n, 2) force of the rod on the object, N; zero where they do not touch.
    """

    time: Array
    path: Array
    pose: Array
    velocity: Array
    pusher: Array
    contact_point: Array
    contact_force: Array


@dataclass(frozen=True)
class EnergyBalance:
    """Where the rod's work went, J.

    work : done by the rod. floor : dissipated under the object. contact : dissipated by sliding and damping between
    rod and object. stored : left in the contact's spring and in motion at the end.
    """

    work: float
    floor: float
    contact: float
    stored: float

    @property
    def residual(self) -> float:
        """Work that is not accounted for, as a share of the work: the error of the integration."""
        return (self.work - self.floor - self.contact - self.stored) / self.work


@dataclass(frozen=True, eq=False)
class DynamicPush(Stroke):
    """A push: poses before and after, and why it ended: `distance`, or `left` where the rod has lost the object."""

    ended: str
    trajectory: DynamicTrajectory
    energy: EnergyBalance


@dataclass(frozen=True, eq=False)
class DynamicDrag(Stroke):
    """A drag: poses before and after, the path of the rod (m), its course and energies."""

    length: float
    trajectory: DynamicTrajectory
    energy: EnergyBalance


@dataclass(frozen=True)
class DynamicModel:
    """A slider with its inertia on a surface, and the rod that moves it through a stiff contact.

    Newton-Euler with the mass matrix diag(m, m, I) (Ma & Rodriguez 2018, Eq. 3); I = m L^2/6 for a square. The rod
    moves straight at a constant speed; the slider is at rest before each stroke, and after it the rod is held until no
    speed is above 1 % of the rod's. See `dynamic_equations` for the laws of floor and contact.

    Parameters
    ----------
    slider, friction, pusher : the object, the surface under it, the rod. The slider's inertia is a uniform plate's
        where it is not known. Its outline must be convex.
    footprint : support points; None: the paper's grid of 8 x 8 with equal load.
    speed : of the rod, m/s.
    stiffness : of the contact and of the ring, N/m; errors of a cycle fall with its inverse (1e6 leaves under 0.001
        degrees on the MIT square, 0.002 on the worst of the MIT shapes).
    damping : of the contact, in shares of the critical damping of the slider's mass on the contact's spring.
    regularisation : speed below which friction fades, as a share of the rod's: friction at slip u is that of
        u / sqrt(u^2 + regularisation^2). What should stick creeps at about this speed; errors fall in proportion (1e-4
        leaves 0.002 degrees of a cycle on the MIT square, about 0.01 on the worst of the MIT shapes: the round plate
        `ellip1`, whose contact with the rod creeps while it rolls).
    tolerance : relative error of a step, from 1e-10 to 1e-3; angles of a cycle come out within about fifty times
        that, in rad (1e-7: 0.0003 degrees).

    >>> model = DynamicModel(Slider.mit("rect1"), EllipseFriction.isotropic(0.25))
    >>> push = model.push(Pose(), SidePush(side=0, fraction=0.7))
    >>> round(math.degrees(push.turn), 1), push.ended
    (74.7, 'distance')
    """

    slider: Slider
    friction: EllipseFriction
    pusher: Pusher = Pusher()
    footprint: Footprint | None = None
    speed: float = 0.02
    stiffness: float = 1e6
    damping: float = 1.0
    regularisation: float = 1e-4
    tolerance: float = 1e-7

    def __post_init__(self) -> None:
        for name in ("speed", "stiffness", "damping", "regularisation", "tolerance"):
            object.__setattr__(self, name, positive_number(name, getattr(self, name)))
        if not 1e-10 <= self.tolerance <= 1e-3:
            raise InvalidInput(f"tolerance {self.tolerance} is out of reach: choose one from 1e-10 to 1e-3")
        if self.regularisation > 0.1:
            raise InvalidInput(f"regularisation {self.regularisation} leaves no friction: choose at most 0.1")
        if not isinstance(self.points, PointFootprint):
            raise InvalidInput(
                "the dynamic simulation stands on support points: choose a footprint such as grid:8, "
                "or the pressure_points of a patch"
            )
        if self.slider.weight / self.stiffness > _DEEPEST * self.pusher.radius:
            raise InvalidInput(
                f"the rod (radius {self.pusher.radius} m) would sink into a contact of {self.stiffness:g} N/m: choose "
                f"a stiffness above {self.slider.weight / _DEEPEST / max(self.pusher.radius, 1e-6):.3g} N/m or a "
                "thicker rod"
            )

    def __getstate__(self) -> dict[str, object]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def points(self) -> Footprint:
        """The support points in use."""
        return self.footprint or grid_footprint(self.slider.outline, GRID)

    @cached_property
    def mass_matrix(self) -> Array:
        """diag(m, m, I) about the centre of mass, (3, 3), kg and kg m^2."""
        inertia = self.slider.inertia
        if inertia is None:
            inertia = self.slider.mass * float(np.trace(PatchFootprint(self.slider.outline).second_moments))
        return np.diag([self.slider.mass, self.slider.mass, inertia])

    @property
    def froude(self) -> float:
        """Inertia against friction: v^2 / (g L), L the footprint's extent."""
        return self.speed**2 / (GRAVITY * self.points.extent)

    def push(self, pose: Pose, push: SidePush, samples: int = SAMPLES) -> DynamicPush:
        """Push the slider from rest at a pose, the rod first just touching it.

        `samples` : of the course while the rod moves. Raises InvalidInput for a contact that does not exist or a
        concave outline, ConvergenceError where the integration fails.
        """
        radius, outline = self.pusher.radius, self.slider.outline
        pieces = contact_curve(outline, radius).pieces
        index, coordinate = side_coordinate(outline, pieces, push.side, push.fraction)
        contact, _ = pieces[index].contact(coordinate, radius)
        direction = pose.theta + contact.normal + math.pi + push.angle
        touch = np.array(pose.to_world(*contact.rod_centre(radius)))
        places = [touch, touch + push.distance * np.array((math.cos(direction), math.sin(direction)))]
        end, course, energy = self._run(pose, self.equations(outline, samples), places)
        # The last sample is at rest, the one before it when the rod stops.
        ended = "distance" if np.any(course.contact_force[-2] != 0.0) else "left"
        return DynamicPush(pose, end, ended, course, energy)

    def drag(
        self,
        pose: Pose,
        way_points: tuple[tuple[float, float], ...],
        samples: int = SAMPLES,
        pin_friction_radius: float = 0.0,
    ) -> DynamicDrag:
        """Drag the slider by its ring, straight through way-points (m, world frame), from rest at a pose.

        `samples` : of the course of each leg. `pin_friction_radius` (m): of the friction circle of the rod in the ring,
        as in `QuasiStaticModel.drag`. Raises InvalidInput for values that are not numbers or a ring that is already
        there, ConvergenceError where the integration fails.
        """
        radius = non_negative_number("pin friction radius", pin_friction_radius)
        if not isinstance(way_points, (tuple, list, np.ndarray)) or len(way_points) == 0:
            raise InvalidInput(f"way-points must be one place (x, y), m, or several, not {way_points!r}")
        goals = [point("way-point", goal) for goal in way_points]
        places = [np.array(place) for place in (pose.to_world(*self.slider.hitch), *goals)]
        length = math.fsum(float(np.hypot(*(b - a))) for a, b in pairwise(places))
        if length <= _SHORTEST * self.points.extent:
            raise InvalidInput(f"the ring is already at {goals[-1]} m: there is nothing to drag")
        end, course, energy = self._run(pose, self.equations(self.slider.hitch, samples), places, radius)
        return DynamicDrag(pose, end, length, course, energy)

    def equations(self, touched: Outline | tuple[float, float], samples: int = 1) -> LegEquations:
        """Return the equations of a leg of the rod on an outline, or in a ring at a place (m)."""
        count = whole_number("samples", samples, least=1)
        assert isinstance(self.points, PointFootprint)
        unit = 1.0 / self.points.extent
        x, y = self.slider.centre_of_mass
        scaled = (unit * touched[0], unit * touched[1]) if isinstance(touched, tuple) else touched.scaled(unit)
        return LegEquations(self.points.scaled(unit), (unit * x, unit * y), scaled, self.tolerance, count)

    def physics(self, pin_friction_radius: float = 0.0) -> Array:
        """Return the numbers `dynamic_equations.PHYSICS`."""
        length, law = self.points.extent, self.friction
        stiffness = self.stiffness * length / self.slider.weight
        values = {
            "froude": self.froude,
            "inertia": self.mass_matrix[2, 2] / (self.slider.mass * length**2),
            "stiffness": stiffness,
            "damping": 2.0 * self.damping * math.sqrt(stiffness * self.froude),
            "radius": self.pusher.radius / length,
            "pusher_mu": self.pusher.friction,
            "pin_radius": pin_friction_radius / length,
            "creep": self.regularisation,
            **{name: getattr(law, name) for name in ("mu_a", "mu_b", "m0", "n0", "phi")},
        }
        return np.array([values[name] for name in PHYSICS])

    def _run(
        self, pose: Pose, equations: LegEquations, places: list[Array], pin_radius: float = 0.0
    ) -> tuple[Pose, DynamicTrajectory, EnergyBalance]:
        """Move the rod through places (m) at its speed, then hold it until the slider rests."""
        length, law, physics = self.points.extent, self.friction, self.physics(pin_radius)
        centre = pose.to_world(*self.slider.centre_of_mass)
        now = np.array([centre[0] / length, centre[1] / length, pose.theta, 0.0, 0.0, 0.0])
        moving: list[Leg] = []
        for place, goal in pairwise(place / length for place in places):
            way = float(np.hypot(*(goal - place)))
            if way > _SHORTEST:
                moving.append(equations.run(now, place, (goal - place) / way, way, physics))
                now = moving[-1].state[-1]
        grip = min(law.mu_a, law.mu_b) * (1.0 - math.hypot(law.m0 / law.mu_a, law.n0 / law.mu_b))
        resting: list[Leg] = []
        while not resting or np.abs(now[3:]).max() > max(_REST, _REST_CREEPS * self.regularisation):
            if len(resting) == _MOST_WAITS:
                raise ConvergenceError(
                    f"the slider still moves at {np.abs(now[3:]).max():.3g} rod speeds long after the rod has stopped: "
                    "choose a smaller regularisation or a friction ellipse whose centre is nearer to zero"
                )
            wait = _WAIT * self.froude / grip
            resting.append(equations.run(now, places[-1] / length, np.zeros(2), wait, physics))
            now = resting[-1].state[-1]
        course = self._course(moving, resting)
        work, floor, contact = self.slider.weight * length * np.sum([leg.works for leg in (*moving, *resting)], axis=0)
        vx, vy, omega = course.velocity[-1]
        motion = (self.mass_matrix.diagonal() @ (vx**2, vy**2, omega**2)) / 2.0
        stored = self.slider.weight * length * resting[-1].stored[-1] + motion
        return (
            Pose(*course.pose[-1].tolist()),
            course,
            EnergyBalance(float(work), float(floor), float(contact), float(stored)),
        )

    def _course(self, moving: list[Leg], resting: list[Leg]) -> DynamicTrajectory:
        """Legs that follow each other, in SI units; of the coming to rest only its end is kept."""
        kept = [slice(0 if k == 0 else 1, None) for k in range(len(moving))] + [slice(-1, None)]
        legs = [*moving, resting[-1]]
        state, rod, force, place = (
            np.concatenate([getattr(leg, name)[part] for leg, part in zip(legs, kept, strict=True)])
            for name in ("state", "rod", "force", "place")
        )
        starts = np.cumsum([0.0, *(leg.time[-1] for leg in (*moving, *resting))])
        moved = [start + leg.time[part] for start, leg, part in zip(starts, moving, kept, strict=False)]
        # The rod moves at unit speed, so that its travel is the time.
        time, path = np.append(np.concatenate(moved), starts[-1]), np.append(np.concatenate(moved), starts[len(moving)])
        length, (x, y), theta = self.points.extent, self.slider.centre_of_mass, state[:, 2]
        c, s = np.cos(theta), np.sin(theta)
        lever = np.column_stack([c * x - s * y, s * x + c * y])
        return DynamicTrajectory(
            time=length / self.speed * time,
            path=length * path,
            pose=np.column_stack([length * state[:, :2] - lever, theta]),
            velocity=self.speed * state[:, 3:] / (1.0, 1.0, length),
            pusher=length * rod,
            contact_point=length * place,
            contact_force=self.slider.weight * force,
        )
