"""The paper's dynamic simulation of one slider on one surface with one rod: pushes it, and drags it by its ring."""

import math
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.constants import g as GRAVITY

from cyclemap.checks import non_negative_number, point, positive_number, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.mechanics.contact_curve import contact_curve, side_coordinate
from cyclemap.mechanics.dynamics.dynamic_equations import PHYSICS
from cyclemap.mechanics.dynamics.dynamic_results import DynamicDrag, DynamicPush, DynamicTrajectory, EnergyBalance
from cyclemap.mechanics.dynamics.stroke_integrator import LegRun, StrokeIntegrator
from cyclemap.mechanics.dynamics.stroke_record import Units, energy_of, trajectory_of
from cyclemap.mechanics.footprint import Footprint, PatchFootprint, PointFootprint, grid_footprint
from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.mechanics.outline import Outline
from cyclemap.mechanics.protocol import Pose, SidePush
from cyclemap.mechanics.pusher import Pusher
from cyclemap.mechanics.slider import Slider

Array = NDArray[np.float64]

GRID = 8
# Samples of each leg, beside its start.
SAMPLES = 30
# The contact may give way by this share of the rod's radius under the slider's whole weight.
_DEEPEST = 0.1
# How long the slider is waited for at a time, in the times that its own friction takes to stop it.
_WAIT = 4.0


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
        if self.weight / self.stiffness > _DEEPEST * self.pusher.radius:
            raise InvalidInput(
                f"the rod (radius {self.pusher.radius} m) would sink into a contact of {self.stiffness:g} N/m: choose "
                f"a stiffness above {self.weight / _DEEPEST / max(self.pusher.radius, 1e-6):.3g} N/m or a thicker rod"
            )

    def __getstate__(self) -> dict[str, object]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def points(self) -> Footprint:
        """The support points in use."""
        return self.footprint or grid_footprint(self.slider.outline, GRID)

    @property
    def weight(self) -> float:
        """The slider's weight, N."""
        return self.slider.mass * float(GRAVITY)

    @cached_property
    def mass_matrix(self) -> Array:
        """diag(m, m, I) about the centre of mass, (3, 3), kg and kg m^2."""
        inertia = self.slider.inertia
        if inertia is None:
            inertia = self.slider.mass * float(np.trace(PatchFootprint(self.slider.outline).second_moments))
        return np.diag([self.slider.mass, self.slider.mass, inertia])

    @cached_property
    def units(self) -> Units:
        """Units of the equations."""
        return Units(self.points.extent, self.speed, self.weight)

    @property
    def froude(self) -> float:
        """Inertia against friction: v^2 / (g L), L the footprint's extent."""
        return self.speed**2 / (float(GRAVITY) * self.units.length)

    def push(self, pose: Pose, push: SidePush, samples: int = SAMPLES) -> DynamicPush:
        """Push the slider from rest at a pose, the rod first just touching it.

        `samples` : of the course while the rod moves. Raises InvalidInput for a contact that does not exist or a
        concave outline, ConvergenceError where the integration fails.
        """
        touch, direction = self._touch(pose, push)
        stroke = self._integrator(self.slider.outline.scaled(1.0 / self.units.length), samples)
        moving, resting = self._run(stroke, pose, [touch, touch + push.distance * direction])
        ended = "distance" if np.any(moving[-1].observed[-1, :2] != 0.0) else "left"
        return DynamicPush(pose, self._end(pose, [*moving, *resting]), ended, *self._told(moving, resting))

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
        stroke = self._integrator(self._scaled(self.slider.hitch), samples)
        moving, resting = self._run(stroke, pose, places, radius)
        length = math.fsum(float(np.hypot(*(b - a))) for a, b in pairwise(places))
        if not moving:
            raise InvalidInput(f"the ring is already at {goals[-1]} m: there is nothing to drag")
        return DynamicDrag(pose, self._end(pose, [*moving, *resting]), length, *self._told(moving, resting))

    def _touch(self, pose: Pose, push: SidePush) -> tuple[Array, Array]:
        """Where the rod's centre first touches (world, m), and the direction in which it goes on."""
        radius, outline = self.pusher.radius, self.slider.outline
        pieces = contact_curve(outline, radius).pieces
        index, coordinate = side_coordinate(outline, pieces, push.side, push.fraction)
        contact, _ = pieces[index].contact(coordinate, radius)
        direction = pose.theta + contact.normal + math.pi + push.angle
        return np.array(pose.to_world(*contact.rod_centre(radius))), np.array(
            (math.cos(direction), math.sin(direction))
        )

    def _integrator(self, touched: Outline | tuple[float, float], samples: int) -> StrokeIntegrator:
        count = whole_number("samples", samples, least=1)
        assert isinstance(self.points, PointFootprint)
        points = self.points.scaled(1.0 / self.points.extent)
        return StrokeIntegrator(points, self._scaled(self._centre), touched, self.tolerance, count)

    def _run(
        self, stroke: StrokeIntegrator, pose: Pose, places: list[Array], pin_radius: float = 0.0
    ) -> tuple[list[LegRun], ...]:
        """Legs while the rod moves through places (m), and while the slider comes to rest."""
        centre = self._scaled(pose.to_world(*self._centre))
        start = np.array([*centre, pose.theta, 0.0, 0.0, 0.0])
        law = self.friction
        grip = min(law.mu_a, law.mu_b) * (1.0 - math.hypot(law.m0 / law.mu_a, law.n0 / law.mu_b))
        return stroke.stroke(
            start,
            [place / self.units.length for place in places],
            _WAIT * self.froude / grip,
            self._physics(pin_radius),
        )

    def _physics(self, pin_radius: float) -> Array:
        """The numbers `dynamic_equations.PHYSICS`."""
        length, law = self.units.length, self.friction
        stiffness = self.stiffness * length / self.weight
        values = {
            "froude": self.froude,
            "inertia": self.mass_matrix[2, 2] / (self.slider.mass * length**2),
            "stiffness": stiffness,
            "damping": 2.0 * self.damping * math.sqrt(stiffness * self.froude),
            "radius": self.pusher.radius / length,
            "pusher_mu": self.pusher.friction,
            "pin_radius": pin_radius / length,
            "creep": self.regularisation,
            **{name: getattr(law, name) for name in ("mu_a", "mu_b", "m0", "n0", "phi")},
        }
        return np.array([values[name] for name in PHYSICS])

    def _end(self, pose: Pose, runs: list[LegRun]) -> Pose:
        x, y, theta = runs[-1].state[-1, :3]
        lever = Pose(0.0, 0.0, float(theta)).to_world(*self._centre)
        return Pose(self.units.length * x - lever[0], self.units.length * y - lever[1], float(theta))

    def _told(self, moving: list[LegRun], resting: list[LegRun]) -> tuple[DynamicTrajectory, EnergyBalance]:
        inertia = float(self._physics(0.0)[PHYSICS.index("inertia")])
        energy = energy_of([*moving, *resting], self.froude, inertia, self.units)
        return trajectory_of(moving, resting, self.units, self._centre), energy

    @property
    def _centre(self) -> tuple[float, float]:
        return self.slider.centre_of_mass

    def _scaled(self, place: tuple[float, float]) -> tuple[float, float]:
        return place[0] / self.units.length, place[1] / self.units.length
