"""The trailing direction's fixed point and rate: exact in symbols for every pressure, and so in the
code's drag.
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
from theory import trailing_rate as theory

SQUARE = Slider.mit("rect1").outline
PLYWOOD = load_material("plywood").friction
STRONG = EllipseFriction(0.35, 0.18, 0.05, -0.03, 0.7)
FOOTPRINTS = {
    "square": PatchFootprint(SQUARE),
    "in parts": PatchFootprint(SQUARE, 0.2, 0.3, 0.1),
    "grid": grid_footprint(SQUARE, 8),
    "ellipse": PatchFootprint(Ellipse(0.05, 0.03)),
}
SYMBOLS = (
    theory.FIRST,
    theory.MIXED,
    theory.SECOND,
    theory.OFFSET_1,
    theory.OFFSET_2,
    theory.TOWARDS,
)


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
    first = sp.diff(theory.dissipation_of_a_point(), theory.SPIN).subs(theory.SPIN, 0)
    point = {theory.POINT_1: 0, theory.POINT_2: 0}
    assert sp.simplify(first.subs(point) - theory.ring_torque()) == 0
    for coordinate in (theory.POINT_1, theory.POINT_2):
        assert sp.simplify(sp.diff(first, coordinate, 2)) == 0
        assert sp.simplify(sp.diff(first, coordinate).has(theory.RING_1)) == False  # noqa: E712


def test_the_torque_vanishes_where_the_lever_lies_along_the_force():
    size, force = sp.Symbol("k", real=True), theory.friction_force()
    along = {theory.TURN: 0, theory.RING_1: size * force[0], theory.RING_2: size * force[1]}
    assert sp.expand(theory.ring_torque().subs(along, simultaneous=True)) == 0


@pytest.mark.slow
def test_the_second_derivative_of_a_point_is_the_stated_quadratic():
    second = sp.diff(theory.dissipation_of_a_point(), theory.SPIN, 2).subs(
        {theory.SPIN: 0, theory.TURN: 0}
    )
    u = theory.direction()
    away = u[0] * (theory.POINT_1 - theory.RING_1) + u[1] * (theory.POINT_2 - theory.RING_2)
    wanted = theory.law_matrix().det() * away**2 / theory.sliding_speed() ** 3
    assert sp.simplify(second - wanted) == 0
    # The mean of (u·(x - ρ))² over a pressure centred at 0 is (u·ρ)² + ⟨(u·x)²⟩: the mixed term is
    # linear in x.
    along = theory.direction().dot(sp.Matrix([theory.RING_1, theory.RING_2]))
    mixed = sp.expand(away**2 - along**2 - (u[0] * theory.POINT_1 + u[1] * theory.POINT_2) ** 2)
    assert (
        sp.expand(sp.diff(mixed, theory.POINT_1, 2))
        == sp.expand(sp.diff(mixed, theory.POINT_2, 2))
        == 0
    )


def test_the_rate_is_the_implicit_derivative():
    """G(ω, θ) = dD/dω = 0 gives dω/dθ = -G_θ/G_ω, with G_θ = f·ρ, which is |f| r where the ring
    leads.
    """
    lever, moment = sp.symbols("r X", positive=True)
    force = theory.friction_force()
    size = sp.sqrt(force.dot(force))
    turning = sp.diff(theory.ring_torque(), theory.TURN).subs(theory.TURN, 0)
    leading = {theory.RING_1: lever * force[0] / size, theory.RING_2: lever * force[1] / size}
    assert sp.simplify(turning - force.dot(sp.Matrix([theory.RING_1, theory.RING_2]))) == 0
    rate = -size * lever / theory.spin_stiffness(moment).subs(leading)
    assert rate - theory.trailing_rate(lever, moment) == 0
    square = turning.subs(leading) * size - lever * force.dot(force)
    assert sp.simplify(square) == 0


@pytest.mark.parametrize("name", FOOTPRINTS)
def test_the_codes_drag_keeps_the_fixed_direction_and_contracts_at_this_rate(name):
    footprint, lever, length = FOOTPRINTS[name], 0.02, 0.05
    force = expression(theory.friction_force())
    rate = expression(
        theory.trailing_rate(sp.Symbol("r"), sp.Symbol("X")), sp.Symbol("r"), sp.Symbol("X")
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
