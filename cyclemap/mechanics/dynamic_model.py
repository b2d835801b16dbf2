"""The paper's dynamic simulation of one slider on one surface with one rod: pushes it, and drags it
by its ring.

Newton-Euler (Ma & Rodriguez 2018, Eq. 3): M q'' = F_pusher + F_friction, q = (x, y, theta) of the
centre of mass. The equations' lengths are in extents L of the footprint, speeds in rod speeds v,
forces in weights m g. Then M = Fr diag(1, 1, J) with the Froude number Fr = v^2 / (g L) and J = I /
(m L^2): the speed enters squared, and nowhere else. CasADi writes them, CVODES (Hindmarsh et al.
2005) integrates them along one leg of the rod after the other.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise

import casadi as ca
import numpy as np

from cyclemap.arrays import TWO_PI, Array, turned
from cyclemap.checks import (
    non_negative_number,
    point,
    positive_number,
    require_kind,
    require_room,
    whole_number,
)
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.mechanics.contact_curve import first_contact
from cyclemap.mechanics.engine.strokes import pressure_at, pressure_tables
from cyclemap.mechanics.footprint import Footprint, PatchFootprint, PointFootprint, grid_footprint
from cyclemap.mechanics.foundation import PressedFootprint, quadratic_at
from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.mechanics.outline import Ellipse, Outline
from cyclemap.mechanics.slider import GRAVITY, Pose, Pusher, SidePush, Slider
from cyclemap.mechanics.trajectory import DynamicDrag, DynamicPush, DynamicTrajectory

Places = tuple[tuple[float, float], ...]
GRID = 8
# Samples of each leg, beside its start.
SAMPLES = 30
# The contact may give way by this share of the rod's radius under the slider's whole weight.
_DEEPEST = 0.1
# How long the slider is waited for at a time, in the times that its own friction takes to stop it,
# and how often.
_WAIT, _MOST_WAITS = 4.0, 100
# The slider rests once no speed is above this share of the rod's, or above so many creep speeds.
_REST, _REST_CREEPS = 0.01, 10.0
# A leg shorter than this (extents) is none.
_SHORTEST = 1e-12
# No rod is faster, m/s.
_FASTEST = 1e3
# Numbers of each sample of a leg.
_SAMPLED = 13
# How a leg lies (rod's start and velocity, duration), then what it meets; creep: the speed below
# which friction fades.
LEG = ("rod_x", "rod_y", "rod_vx", "rod_vy", "duration")
PHYSICS = (
    *("froude", "inertia", "stiffness", "damping", "radius", "pusher_mu", "pin_radius", "creep"),
    *("mu_a", "mu_b", "m0", "n0", "phi"),
)
# The absolute tolerance as a share of the relative one: speeds and lengths are of order one.
_ABSOLUTE = 0.1
# Newton's error as a share of a step's: CVODES' own 0.1 lets the stiff contact turn it into failed
# error tests.
_NEWTON_SHARE = 1e-3
_MOST_STEPS = 200_000
# Units of the state. Velocities follow from positions through the stiff contact, where a step of
# length h gives them the error of positions over h: tested as strictly as these, they would have
# steps shortened without end.
_SCALES = np.array([1.0, 1.0, 1.0, 100.0, 100.0, 100.0])
# Newton's steps towards the nearest place of an ellipse; 5 reach rounding at an axis ratio of 1.5,
# 7 at 4.
_NEWTON_STEPS = 8
# Points a side on which a plate stands that has a shape, or whose floor has one; orientations over
# half a turn at which it is balanced, and harmonics of that.
_PRESSED_GRID, _BALANCES, _HARMONICS = 16, 256, 25


@dataclass(frozen=True)
class DynamicModel:
    """A slider with its inertia on a surface, and the rod that moves it through a stiff contact.

    The rod moves straight at a constant speed; the slider is at rest before each stroke, and after
    it the rod is held until no speed is above 1 % of it.

    Parameters
    ----------
    slider : Slider
        The object, of convex outline; of unknown inertia: a uniform plate's.
    friction : EllipseFriction
        That of the surface.
    pusher : Pusher, optional
        The rod.
    footprint : Footprint or None, optional
        Support points; None: the paper's grid of 8 x 8 with equal load. Of a PressedFootprint,
        points of a grid of 16 x 16 with loads that follow the orientation (on a trough strokes
        come within 0.4 degrees of the exact contact's).
    speed : float, default 0.02
        Speed of the rod, m/s.
    stiffness : float, default 1e6
        Of the contact and of the ring, N/m; errors of a cycle fall with its inverse (1e6 leaves
        under 0.001 degrees on the MIT square, 0.002 on the worst of the MIT shapes).
    damping : float, default 1.0
        Of the contact, in shares of the critical damping of the slider's mass on the contact's
        spring.
    regularisation : float, default 1e-4
        Speed below which friction fades, as a share of the rod's, at most 0.1: at slip u as u /
        sqrt(u^2 + regularisation^2). What should stick creeps at about this speed; errors fall
        in proportion (1e-4 leaves 0.002 degrees of a cycle on the MIT square, about 0.01 on the
        round plate `ellip1`, whose contact creeps as it rolls).
    tolerance : float, default 1e-7
        Relative error of a step, from 1e-10 to 1e-3; angles of a cycle come out within about
        fifty times that, in rad (1e-7: 0.0003 degrees).

    Attributes
    ----------
    points : PointFootprint
        The support points in use.
    inertia : float
        Moment of inertia about the centre of mass, kg m^2.

    Raises
    ------
    InvalidInput
        For parts that are none, speed, stiffness, damping, regularisation or tolerance that is
        not positive or out of reach, a footprint without support points, and a contact so soft
        that the rod would sink into it.

    Examples
    --------
    >>> import math
    >>> from cyclemap.mechanics import DynamicModel, EllipseFriction, Pose, SidePush, Slider
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
    points: PointFootprint = field(init=False, repr=False, compare=False)
    inertia: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_kind("slider", self.slider, Slider)
        require_kind("friction", self.friction, EllipseFriction)
        require_kind("pusher", self.pusher, Pusher)
        for name in ("speed", "stiffness", "damping", "regularisation", "tolerance"):
            vars(self)[name] = positive_number(name, getattr(self, name))
        if self.speed > _FASTEST:
            raise InvalidInput(
                f"speed {self.speed:g} m/s is that of no rod: choose at most {_FASTEST:g} m/s"
            )
        if not 1e-10 <= self.tolerance <= 1e-3:
            raise InvalidInput(
                f"tolerance {self.tolerance} is out of reach: choose one from 1e-10 to 1e-3"
            )
        if self.regularisation > 0.1:
            raise InvalidInput(
                f"regularisation {self.regularisation} leaves no friction: choose at most 0.1"
            )
        points, slider = self.footprint or grid_footprint(self.slider.outline, GRID), self.slider
        if isinstance(points, PressedFootprint):
            if points.field is not None:
                raise InvalidInput(
                    "the dynamic simulation knows no floor that varies from place to place: give "
                    "the footprint with field=None, to the model beside it too"
                )
            points = grid_footprint(points.outline, _PRESSED_GRID)
        if not isinstance(points, PointFootprint):
            raise InvalidInput(
                "the dynamic simulation stands on support points: choose a footprint such as "
                "grid:8, the pressure_points of a patch, or shapes of plate and floor"
            )
        if slider.weight / self.stiffness > _DEEPEST * self.pusher.radius:
            raise InvalidInput(
                f"the rod (radius {self.pusher.radius} m) would sink into a contact of "
                f"{self.stiffness:g} N/m: choose a stiffness above "
                f"{slider.weight / _DEEPEST / max(self.pusher.radius, 1e-6):.3g} N/m or a thicker "
                "rod"
            )
        inertia = slider.inertia
        if inertia is None:
            inertia = slider.mass * float(np.trace(PatchFootprint(slider.outline).second_moments))
        vars(self).update(points=points, inertia=inertia)

    def push(self, pose: Pose, push: SidePush, samples: int = SAMPLES) -> DynamicPush:
        """Push the slider from rest at a pose, the rod first just touching it.

        Parameters
        ----------
        pose : Pose
            Where the slider lies before.
        push : SidePush
            What the rod does.
        samples : int, optional
            How many samples of the course are kept.

        Returns
        -------
        DynamicPush
            The poses before and after, and the course.

        Raises
        ------
        InvalidInput
            For a push that is none, a contact that does not exist, a concave outline, and more
            samples than memory holds.
        ConvergenceError
            Where the integration fails.
        """
        require_kind("pose", pose, Pose)
        require_kind("push of the dynamic simulation", push, SidePush)
        touch, way = first_contact(self.slider, push, self.pusher.radius)
        places = (pose.to_world(*place) for place in (touch, touch + push.distance * way))
        equations = self._equations(self.slider.outline, samples)
        end, course = self._run(pose, equations, [np.array(place) for place in places])
        # The last sample is at rest, the one before it when the rod stops.
        ended = "distance" if np.any(course.contact_force[-2] != 0.0) else "left"
        return DynamicPush(pose, end, ended, course)

    def drag(
        self,
        pose: Pose,
        way_points: Places,
        samples: int = SAMPLES,
        pin_friction_radius: float = 0.0,
    ) -> DynamicDrag:
        """Drag the slider by its ring, straight through way-points, from rest at a pose.

        Parameters
        ----------
        pose : Pose
            Where the slider lies before.
        way_points : array_like, shape (k, 2)
            m, world frame, in order.
        samples : int, optional
            How many samples of the course of each leg are kept.
        pin_friction_radius : float, default 0.0
            Radius of the friction circle of the rod in the ring, m, as in
            `QuasiStaticModel.drag`.

        Returns
        -------
        DynamicDrag
            The poses before and after, and the course.

        Raises
        ------
        InvalidInput
            For values that are not numbers, a ring that is already there, and more samples than
            memory holds.
        ConvergenceError
            Where the integration fails.
        """
        require_kind("pose", pose, Pose)
        radius = non_negative_number("pin friction radius", pin_friction_radius)
        if not isinstance(way_points, (tuple, list, np.ndarray)) or len(way_points) == 0:
            raise InvalidInput(
                f"way-points must be one place (x, y), m, or several, not {way_points!r}"
            )
        goals = [point("way-point", goal) for goal in way_points]
        places = [np.array(place) for place in (pose.to_world(*self.slider.hitch), *goals)]
        length = math.fsum(float(np.hypot(*(b - a))) for a, b in pairwise(places))
        if length <= _SHORTEST * self.points.extent:
            raise InvalidInput(f"the ring is already at {goals[-1]} m: there is nothing to drag")
        end, course = self._run(pose, self._equations(self.slider.hitch, samples, radius), places)
        return DynamicDrag(pose, end, length, course)

    def _equations(
        self, touched: Outline | tuple[float, float], samples: int, pin_radius: float = 0.0
    ) -> LegEquations:
        """The equations of a leg of the rod on an outline, or in a ring at a place (m), with
        friction of a radius.
        """
        count = whole_number("samples", samples, least=1)
        require_room("numbers of the samples of a leg", _SAMPLED * count, "keep fewer samples")
        slider, law, length = self.slider, self.friction, self.points.extent
        unit = 1.0 / length
        froude = self.speed**2 / (GRAVITY * length)
        stiffness = self.stiffness * length / slider.weight
        physics = (
            froude,
            self.inertia / (slider.mass * length**2),
            stiffness,
            2.0 * self.damping * math.sqrt(stiffness * froude),
            self.pusher.radius / length,
            self.pusher.friction,
            pin_radius / length,
            self.regularisation,
            *(law.mu_a, law.mu_b, law.m0, law.n0, law.phi),
        )
        places = (unit * self.points.quadrature[0]).tolist()
        pressed = self.footprint if isinstance(self.footprint, PressedFootprint) else None
        return LegEquations(
            PointFootprint(tuple(map(tuple, places)), self.points.weights),
            (unit * slider.centre_of_mass[0], unit * slider.centre_of_mass[1]),
            (unit * touched[0], unit * touched[1])
            if isinstance(touched, tuple)
            else touched.scaled(unit),
            self.tolerance,
            count,
            physics,
            _resized(pressed, unit) if pressed else None,
        )

    def _run(
        self, pose: Pose, equations: LegEquations, places: list[Array]
    ) -> tuple[Pose, DynamicTrajectory]:
        """Move the rod through places (m) at its speed, then hold it until the slider rests."""
        length, law = self.points.extent, self.friction
        x, y = pose.to_world(*self.slider.centre_of_mass)
        now = np.array([x / length, y / length, pose.theta, 0.0, 0.0, 0.0])
        kept: list[Array] = []
        time = 0.0
        for place, goal in pairwise(place / length for place in places):
            way = float(np.hypot(*(goal - place)))
            if way > _SHORTEST:
                leg = equations.run(now, place, (goal - place) / way, way)
                leg[:, 0] += time
                kept.append(leg[1:] if kept else leg)
                now, time = leg[-1, 3:9], time + way
        # The rod moves at unit speed, so that its travel is the time.
        way, waits = time, 0
        grip = min(law.mu_a, law.mu_b) * (1.0 - math.hypot(law.m0 / law.mu_a, law.n0 / law.mu_b))
        wait = _WAIT * self.speed**2 / (GRAVITY * length) / grip
        while waits == 0 or np.abs(now[3:]).max() > max(_REST, _REST_CREEPS * self.regularisation):
            if waits == _MOST_WAITS:
                raise ConvergenceError(
                    f"the slider still moves at {np.abs(now[3:]).max():.3g} rod speeds long after "
                    "the rod has stopped: choose a smaller regularisation or a friction ellipse "
                    "whose centre is nearer to zero"
                )
            leg = equations.run(now, places[-1] / length, np.zeros(2), wait)
            leg[:, 0] += time
            now, time, waits = leg[-1, 3:9], time + wait, waits + 1
        # Of the coming to rest only its end is kept.
        rows = np.concatenate([*kept, leg[-1:]])
        lever = turned(np.array(self.slider.centre_of_mass), rows[:, 5])
        course = DynamicTrajectory(
            time=length / self.speed * rows[:, 0],
            path=length * np.minimum(rows[:, 0], way),
            pose=np.column_stack([length * rows[:, 3:5] - lever, rows[:, 5]]),
            velocity=self.speed * rows[:, 6:9] / (1.0, 1.0, length),
            pusher=length * rows[:, 1:3],
            contact_point=length * rows[:, 11:13],
            contact_force=self.slider.weight * rows[:, 9:11],
        )
        return Pose(*course.pose[-1].tolist()), course


@dataclass(frozen=True)
class LegEquations:
    """One leg of the rod, in the equations' units; touched: the outline that it pushes, or the
    ring's place.

    physics : as PHYSICS names them.
    pressed : what the points' loads follow; None: their weights.
    """

    footprint: PointFootprint
    centre: tuple[float, float]
    touched: Outline | tuple[float, float]
    tolerance: float
    samples: int
    physics: tuple[float, ...] = field(compare=False)
    pressed: PressedFootprint | None = None

    def run(self, start: Array, rod: Array, velocity: Array, time: float) -> Array:
        """Move the rod for a time from a place at a velocity, the slider being in the state `start`
        (6,).

        Rows (samples + 1, 13): time; the rod's place; x, y, theta of the centre of mass, their
        velocities; the rod's force on the slider, and where (world frame). Raises ConvergenceError
        where the integrator gives up.
        """
        integrator, observed = _functions(self)
        parameters = np.array([*rod, *velocity, time, *self.physics])
        # Whole turns stay out, since the integrator's error is relative to what it integrates.
        wound = TWO_PI * np.round(start[2] / TWO_PI) * (np.arange(6) == 2)
        try:
            solved = integrator(x0=(start - wound) / _SCALES, p=parameters)
        except RuntimeError as cause:
            raise ConvergenceError(
                "the integrator of the dynamic simulation gave up at tolerance "
                f"{self.tolerance:g}: choose a looser one, a larger regularisation or a smaller "
                "stiffness"
            ) from cause
        scaled = (
            np.column_stack([(start - wound) / _SCALES, np.array(solved["xf"])]) + wound[:, None]
        )
        share = np.linspace(0.0, 1.0, self.samples + 1)
        seen = np.array(observed(share[None], scaled, parameters))
        return np.column_stack(
            [time * share, rod + np.outer(time * share, velocity), scaled.T * _SCALES, seen.T]
        )


@lru_cache(maxsize=32)
def _functions(leg: LegEquations) -> tuple[ca.Function, ca.Function]:
    """The integrator over time 0 to 1, and (time, state, parameters) -> force (2), its place (2).

    Both know the state in units of _SCALES.
    """
    time, scaled = ca.SX.sym("time"), ca.SX.sym("scaled", 6)
    parameters = ca.SX.sym("parameters", len(LEG + PHYSICS))
    p = dict(zip(LEG + PHYSICS, ca.vertsplit(parameters), strict=True))
    state, centre = _SCALES * scaled, ca.DM(leg.centre)
    theta, omega = state[2], state[5]
    rod_velocity = ca.vertcat(p["rod_vx"], p["rod_vy"])
    # What the contact sees, in the slider's axes: the rod from the centre of mass and from the
    # place that it touches, and how fast it moves off that.
    rod = _turned(
        ca.vertcat(p["rod_x"], p["rod_y"]) + rod_velocity * (p["duration"] * time) - state[:2],
        -theta,
    )
    touched = leg.touched
    if isinstance(touched, tuple):
        place = ca.SX(ca.DM(touched)) - centre
    else:
        place = nearest_place(touched, rod + centre) - centre
    lever = rod - place
    slip = _turned(rod_velocity - state[3:5], -theta) + omega * ca.vertcat(place[1], -place[0])
    if isinstance(touched, tuple):
        # A spring and damper both ways; the root's small addend keeps its derivative finite where
        # there is no force.
        local = p["stiffness"] * lever + p["damping"] * slip
        size = ca.sqrt(ca.sumsqr(local) + 1e-16)
        pin = -p["pin_radius"] * size * omega / ca.sqrt(omega**2 + p["creep"] ** 2)
    else:
        local, pin = _on_outline(lever, slip, p), 0.0
    floor, floor_torque = _floor(leg, theta, state[3:5], omega, p)
    force = _turned(local, theta)
    torque = floor_torque + pin + _moment(place, local)
    rates = ca.vertcat(state[3:], ca.vertcat(floor + force, torque / p["inertia"]) / p["froude"])
    problem = {"t": time, "x": scaled, "p": parameters, "ode": p["duration"] * rates / _SCALES}
    options = {
        "reltol": leg.tolerance,
        "abstol": _ABSOLUTE * leg.tolerance,
        "nonlin_conv_coeff": _NEWTON_SHARE,
        "max_num_steps": _MOST_STEPS,
        "disable_internal_warnings": True,
        "linear_solver": "csparse",
    }
    grid = np.linspace(0.0, 1.0, leg.samples + 1)[1:].tolist()
    seen = ca.vertcat(force, state[:2] + _turned(place, theta))
    observed = ca.Function("observed", [time, scaled, parameters], [seen])
    return ca.integrator("leg", "cvodes", problem, 0.0, grid, options), observed


def _on_outline(lever: ca.SX, slip: ca.SX, p: Mapping[str, ca.SX]) -> ca.SX:
    """Force of the rod on the outline: spring and damper that never pull, Coulomb friction faded
    below the creep.
    """
    distance = ca.norm_2(lever)
    out = lever / distance
    depth, closing, sideways = p["radius"] - distance, -ca.dot(slip, out), _moment(out, slip)
    pressed = ca.fmax(p["stiffness"] * depth + p["damping"] * closing, 0.0)
    normal = ca.if_else(depth > 0.0, pressed, 0.0)
    tangential = p["pusher_mu"] * normal * sideways / ca.sqrt(sideways**2 + p["creep"] ** 2)
    return tangential * ca.vertcat(-out[1], out[0]) - normal * out


def _floor(
    leg: LegEquations, theta: ca.SX, velocity: ca.SX, omega: ca.SX, p: Mapping[str, ca.SX]
) -> tuple[ca.SX, ca.SX]:
    """Force (world) and torque of the floor on the slider.

    At every point the traction is the gradient of h(v) = s + m0 v_m + n0 v_n, the offset ellipse's
    (Ma & Rodriguez 2018, Eq. 2), with s = sqrt(mu_a^2 v_m^2 + mu_b^2 v_n^2 + mu_a mu_b creep^2):
    convex, smooth, exact far above creep.
    """
    moving = _turned(velocity, -p["phi"])
    axes, offset = ca.vertcat(p["mu_a"], p["mu_b"]), ca.vertcat(p["m0"], p["n0"])
    fading, force, torque = p["mu_a"] * p["mu_b"] * p["creep"] ** 2, ca.SX.zeros(2), 0.0
    loads = leg.footprint.weights if leg.pressed is None else _loads(leg, leg.pressed, theta)
    for place, weight in zip(leg.footprint.positions, loads, strict=True):
        lever = _turned(ca.DM(place) - ca.DM(leg.centre), theta - p["phi"])
        slides = moving + omega * ca.vertcat(-lever[1], lever[0])
        traction = offset + axes**2 * slides / ca.sqrt(ca.sumsqr(axes * slides) + fading)
        force -= weight * traction
        torque -= weight * _moment(lever, traction)
    return _turned(force, p["phi"]), torque


def _resized(footprint: PressedFootprint, factor: float) -> PressedFootprint:
    """The same with all lengths times a factor; shapes are told at a distance that stays."""
    x, y = footprint.centre
    plate, floor = (shape.scaled(factor**-2) for shape in (footprint.plate, footprint.floor))
    outline = footprint.outline.scaled(factor)
    return PressedFootprint(outline, plate, floor, (factor * x, factor * y))


def _loads(leg: LegEquations, pressed: PressedFootprint, theta: ca.SX) -> list[ca.SX]:
    """Loads of the points, which add to one, at an orientation: the pressure's quadratic by its
    harmonics.
    """
    tables, size = pressure_tables(pressed), pressed.extent
    turns = np.pi * np.arange(_BALANCES) / _BALANCES
    waves = np.fft.rfft([pressure_at(tables, turn) for turn in turns.tolist()], axis=0) / _BALANCES
    quadratic = ca.SX(ca.DM(waves[0].real))
    for order, wave in enumerate(waves[1:_HARMONICS], 1):
        angle = 2.0 * order * theta
        quadratic += 2.0 * (ca.cos(angle) * wave.real - ca.sin(angle) * wave.imag)
    places = (np.array(leg.footprint.positions) - pressed.outline.centroid) / size
    loads = []
    for (x, y), share in zip(places, leg.footprint.weights, strict=True):
        loads.append(share * ca.fmax(quadratic_at(ca.vertsplit(quadratic), x, y), 0.0))
    total = sum(loads)
    return [load / total for load in loads]


def nearest_place(outline: Outline, place: ca.SX) -> ca.SX:
    """Return where a convex outline is nearest to a place (2,) outside it; InvalidInput where it is
    concave.
    """
    if isinstance(outline, Ellipse):
        # Newton on the eccentric angle at which the lever to the place is normal to the outline.
        (x, y), a, b = ca.vertsplit(place), outline.semi_x, outline.semi_y
        angle = ca.atan2(a * y, b * x)
        for _ in range(_NEWTON_STEPS):
            c, s = ca.cos(angle), ca.sin(angle)
            slope = (a**2 - b**2) * s * c - a * x * s + b * y * c
            angle -= slope / ((a**2 - b**2) * (c**2 - s**2) - a * x * c - b * y * s)
        return ca.vertcat(a * ca.cos(angle), b * ca.sin(angle))
    if not outline.is_convex:
        raise InvalidInput(
            "the dynamic simulation needs a convex outline, since a rod touches a concave one in "
            "two places at once: use the quasi-static model"
        )
    nearest, least = ca.SX.zeros(2), ca.SX(np.inf)
    for a, b in zip(outline.array, np.roll(outline.array, -1, axis=0), strict=True):
        side, away = b - a, place - a
        share = ca.fmin(ca.fmax(ca.dot(away, side) / float(side @ side), 0.0), 1.0)
        foot = a + share * side
        square = ca.sumsqr(place - foot)
        nearest, least = ca.if_else(square < least, foot, nearest), ca.fmin(least, square)
    return nearest


def _moment(lever: ca.SX, force: ca.SX) -> ca.SX:
    return lever[0] * force[1] - lever[1] * force[0]


def _turned(vector: ca.SX, angle: ca.SX) -> ca.SX:
    """A vector turned counter-clockwise."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(c * vector[0] - s * vector[1], s * vector[0] + c * vector[1])
