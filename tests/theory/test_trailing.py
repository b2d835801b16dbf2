"""A trailing lever: what a leg forgets, its bias and multiplier, and the fixed direction with its rate
for every pressure; in symbols, and in the code's drag.
"""

import math

import numpy as np
import pytest
import sympy as sp

from cyclemap.mechanics import (
    Ellipse,
    EllipseFriction,
    PatchFootprint,
    PointFootprint,
    Pose,
    QuasiStaticModel,
    Slider,
    grid_footprint,
    load_material,
)
from cyclemap.mechanics.footprint import INNER
from theory import trailing_leg as leg, trailing_rate as drag
from theory.moebius_drag import (
    HEADING,
    LENGTH,
    POINT,
    half_angle_tangent,
    heading_after,
    leg_of_the_lever,
    strength,
)

A = sp.Symbol("a", positive=True)


def test_the_multiplier_is_the_slope_at_the_trailing_heading():
    m = leg.multiplier()
    assert sp.simplify(leg.slope(m).subs(HEADING, 0) - m) == 0
    assert sp.simplify(leg.slope(m).subs(HEADING, sp.pi) - 1 / m) == 0
    assert sp.simplify((m - (1 - strength()) / (1 + strength())).rewrite(sp.exp)) == 0


@pytest.mark.slow
def test_the_slope_is_the_derivative_of_the_closed_form():
    assert sp.simplify(sp.diff(heading_after(), HEADING) - leg.slope(leg.multiplier())) == 0


def test_after_the_forgetting_length_the_last_allowed_heading_is_at_the_tolerance():
    start = sp.pi - leg.EXCLUDED
    reached = half_angle_tangent().subs(LENGTH, leg.forgetting_length()).subs(HEADING, start)
    residual = reached - sp.tan(leg.TOLERANCE / 2)
    assert sp.simplify(residual.rewrite(sp.tan)) == 0


def test_the_share_within_is_that_of_the_headings_which_end_on_the_tolerance():
    edge = sp.pi * leg.share_within()
    reached = half_angle_tangent().subs(HEADING, edge)
    assert sp.simplify(reached - sp.tan(leg.TOLERANCE / 2)) == 0


def test_a_uniform_heading_becomes_wrapped_cauchy():
    """The density is the slope of the inverse leg over 2π, and the mean of e^{iψ} is a, as a
    residue too.
    """
    backwards = leg.slope((1 + A) / (1 - A)) / (2 * sp.pi)
    cosine = sp.Symbol("C", real=True)
    whole = {sp.cos(HEADING / 2) ** 2: (1 + cosine) / 2, sp.sin(HEADING / 2) ** 2: (1 - cosine) / 2}
    density = leg.density_from_uniform(A).subs(sp.cos(HEADING), cosine)
    assert sp.simplify(backwards.subs(whole) - density) == 0
    assert leg.mean_from_uniform(A) == A
    assert sp.residue(leg_of_the_lever(A) / POINT, POINT, 0) == A


SQUARE = Slider.mit("rect1").outline
PLYWOOD = load_material("plywood").friction
STRONG = EllipseFriction(0.35, 0.18, 0.05, -0.03, 0.7)
FOOTPRINTS = {
    "square": PatchFootprint(SQUARE),
    "in parts": PatchFootprint(SQUARE, 0.2, 0.3, 0.1),
    "grid": grid_footprint(SQUARE, 8),
    "ellipse": PatchFootprint(Ellipse(0.05, 0.03)),
}
SYMBOLS = (drag.FIRST, drag.MIXED, drag.SECOND, drag.OFFSET_1, drag.OFFSET_2, drag.TOWARDS)


def law_numbers(law, towards):
    """Q and m in the world's axes, as the theory names them."""
    c, s = math.cos(law.phi), math.sin(law.phi)
    turn = np.array([[c, -s], [s, c]])
    q = turn @ np.diag([law.mu_a**2, law.mu_b**2]) @ turn.T
    m = turn @ [law.m0, law.n0]
    return q[0, 0], q[0, 1], q[1, 1], m[0], m[1], towards


def expression(value, *more):
    return sp.lambdify((*SYMBOLS, *more), value)


def second_moment(footprint, towards):
    """Mean of (u.x)^2 over the pressure; over a rim twice the even one: the slope of scale^4 over
    that of scale^2.
    """
    u = np.array((math.cos(towards), math.sin(towards)))
    if isinstance(footprint, PointFootprint):
        points, weights = footprint.quadrature
        return float(weights @ (points @ u) ** 2)
    evenly = footprint.even_share + INNER**2 * footprint.inner_share + 2.0 * footprint.rim_share
    corners = (
        np.mean((footprint.outline.points(4)[:-1] @ u) ** 2) if footprint.corner_share else 0.0
    )
    return float(evenly * (u @ footprint.second_moments @ u) + footprint.corner_share * corners)


def test_the_first_derivative_of_a_point_is_linear_in_its_place():
    """So that the mean over a pressure needs only its centre: dD/dω = f·(z × (x - ρ)) at ω = 0."""
    first = sp.diff(drag.dissipation_of_a_point(), drag.SPIN).subs(drag.SPIN, 0)
    point = {drag.POINT_1: 0, drag.POINT_2: 0}
    assert sp.simplify(first.subs(point) - drag.ring_torque()) == 0
    for coordinate in (drag.POINT_1, drag.POINT_2):
        assert sp.simplify(sp.diff(first, coordinate, 2)) == 0
        assert sp.simplify(sp.diff(first, coordinate).has(drag.RING_1)) == False  # noqa: E712


def test_the_torque_vanishes_where_the_lever_lies_along_the_force():
    size, force = sp.Symbol("k", real=True), drag.friction_force()
    along = {drag.TURN: 0, drag.RING_1: size * force[0], drag.RING_2: size * force[1]}
    assert sp.expand(drag.ring_torque().subs(along, simultaneous=True)) == 0


@pytest.mark.slow
def test_the_second_derivative_of_a_point_is_the_stated_quadratic():
    second = sp.diff(drag.dissipation_of_a_point(), drag.SPIN, 2).subs({drag.SPIN: 0, drag.TURN: 0})
    u = drag.direction()
    away = u[0] * (drag.POINT_1 - drag.RING_1) + u[1] * (drag.POINT_2 - drag.RING_2)
    wanted = drag.law_matrix().det() * away**2 / drag.sliding_speed() ** 3
    assert sp.simplify(second - wanted) == 0
    # The mean of (u·(x - ρ))² over a pressure centred at 0 is (u·ρ)² + ⟨(u·x)²⟩: the mixed term is
    # linear in x.
    along = drag.direction().dot(sp.Matrix([drag.RING_1, drag.RING_2]))
    mixed = sp.expand(away**2 - along**2 - (u[0] * drag.POINT_1 + u[1] * drag.POINT_2) ** 2)
    for place in (drag.POINT_1, drag.POINT_2):
        assert sp.expand(sp.diff(mixed, place, 2)) == 0


def test_the_rate_is_the_implicit_derivative():
    """G(ω, θ) = dD/dω = 0 gives dω/dθ = -G_θ/G_ω, with G_θ = f·ρ, which is |f| r where the ring
    leads.
    """
    lever, moment = sp.symbols("r X", positive=True)
    force = drag.friction_force()
    size = sp.sqrt(force.dot(force))
    turning = sp.diff(drag.ring_torque(), drag.TURN).subs(drag.TURN, 0)
    leading = {drag.RING_1: lever * force[0] / size, drag.RING_2: lever * force[1] / size}
    assert sp.simplify(turning - force.dot(sp.Matrix([drag.RING_1, drag.RING_2]))) == 0
    rate = -size * lever / drag.spin_stiffness(moment).subs(leading)
    assert rate - drag.trailing_rate(lever, moment) == 0
    square = turning.subs(leading) * size - lever * force.dot(force)
    assert sp.simplify(square) == 0


@pytest.mark.parametrize("name", FOOTPRINTS)
def test_the_codes_drag_keeps_the_fixed_direction_and_contracts_at_this_rate(name):
    footprint, lever, length = FOOTPRINTS[name], 0.02, 0.05
    force = expression(drag.friction_force())
    rate = expression(
        drag.trailing_rate(sp.Symbol("r"), sp.Symbol("X")), sp.Symbol("r"), sp.Symbol("X")
    )
    slider = Slider(SQUARE, hitch=(lever, 0.0))
    for law, towards in ((EllipseFriction.isotropic(0.3), 1.0), (PLYWOOD, -2.0), (STRONG, 0.4)):
        numbers = law_numbers(law, towards)
        fx, fy = force(*numbers).ravel()
        leading = math.atan2(fy, fx)

        # The second moment is that of the object as it lies at the fixed point.
        moment = second_moment(footprint, towards - leading)
        wanted = math.exp(rate(*numbers, lever, moment) * length)
        model = QuasiStaticModel(slider, law, footprint=footprint, accuracy=1e-11)
        goal = length * math.cos(towards), length * math.sin(towards)

        def end(theta, model=model, goal=goal):
            pose = Pose(0.0, 0.0, theta)
            x, y = pose.to_world(*model.slider.hitch)
            return model.drag(pose, ((x + goal[0], y + goal[1]),)).end.theta

        assert abs(end(leading) - leading) < 1e-11
        step = 2e-3
        coarse, fine = (
            (end(leading + h) - end(leading - h)) / (2.0 * h) for h in (step, step / 2.0)
        )
        assert abs((4.0 * fine - coarse) / 3.0 / wanted - 1.0) < 1e-6
