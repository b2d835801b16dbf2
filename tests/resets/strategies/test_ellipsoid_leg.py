"""The leg in closed form: against its differential equation, the theory's symbols and the code's Möbius maps."""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap
from cyclemap.mechanics import MIT_SHAPE_NAMES, DragBack, EllipseFriction, Material, Slider, load_material
from cyclemap.resets.strategies.ellipsoid_leg import EllipsoidLeg, trailing_point
from theory import trailing_leg, trailing_rate
from theory.moebius_drag import LENGTH, LEVER, SPIN_RADIUS

LEG = EllipsoidLeg.of_lever(0.015, 0.026)
SYMBOLS = {LEVER: 0.015, SPIN_RADIUS: 0.026}
STRONG = EllipseFriction(0.35, 0.18, 0.05, -0.03, 0.7)
LAWS = (EllipseFriction.isotropic(0.25), load_material("plywood").friction, STRONG)


def test_a_numerical_leg_ends_where_the_closed_form_says():
    """d psi/ds = -r sin(psi)/(r^2 + c^2), integrated; headings straight ahead stay there."""
    starts = np.linspace(-3.1, 3.1, 9)
    for length in (0.02, 0.1, 0.4):
        run = solve_ivp(
            lambda s, psi: -0.015 * np.sin(psi) / (0.015**2 + 0.026**2), (0, length), starts, rtol=1e-11, atol=1e-12
        )
        assert np.abs(LEG.heading_after(starts, length) - run.y[:, -1]).max() < 1e-9
    assert abs(LEG.heading_after(math.pi, 0.4) - math.pi) < 1e-12
    assert np.array_equal(LEG.heading_after(starts, 0.0), starts)


def test_a_leg_is_the_moebius_map_of_its_strength():
    starts = np.linspace(-3.0, 3.0, 7)
    ends = CircleMap.moebius(LEG.strength(0.1), 0.0)(starts + math.pi) - math.pi
    assert np.abs(np.exp(1j * ends) - np.exp(1j * LEG.heading_after(starts, 0.1))).max() < 1e-12
    both = (LEG.strength(0.1) + LEG.strength(0.2)) / (1.0 + LEG.strength(0.1) * LEG.strength(0.2))
    assert abs(both - LEG.strength(0.3)) < 1e-15


def test_forgetting_length_and_share_are_the_theorys():
    for tolerance, share in ((0.1, 0.02), (0.5, 0.3), (1.0, 0.01)):
        numbers = SYMBOLS | {trailing_leg.TOLERANCE: tolerance, trailing_leg.EXCLUDED: math.pi * share}
        length = LEG.forgetting_length(tolerance, share)
        assert abs(length - float(trailing_leg.forgetting_length().subs(numbers))) < 1e-14
        within = trailing_leg.share_within().subs(numbers | {LENGTH: 0.1})
        assert abs(LEG.share_within(tolerance, 0.1) - float(within)) < 1e-14
        assert abs(LEG.share_within(tolerance, length) - (1.0 - share)) < 1e-14
    assert LEG.forgetting_length(3.0, 0.5) == 0.0


@pytest.mark.parametrize("shape", MIT_SHAPE_NAMES)
def test_the_trailing_point_is_the_theorys(shape):
    """The lever along the friction force, and the rate of `theory.trailing_rate`, for every law and direction."""
    lever, moment = sp.Symbol("r"), sp.Symbol("X")
    symbols = (trailing_rate.FIRST, trailing_rate.MIXED, trailing_rate.SECOND)
    symbols += (trailing_rate.OFFSET_1, trailing_rate.OFFSET_2, trailing_rate.TOWARDS, lever, moment)
    rate = sp.lambdify(symbols, trailing_rate.trailing_rate(lever, moment))
    force = sp.lambdify(symbols, trailing_rate.friction_force())
    for law in LAWS:
        loop = CollectionLoop.mit(Material("some", law), slider=Slider.mit(shape))
        c, s = math.cos(law.phi), math.sin(law.phi)
        turn = np.array([[c, -s], [s, c]])
        q, m = turn @ np.diag([law.mu_a**2, law.mu_b**2]) @ turn.T, turn @ [law.m0, law.n0]
        for direction in (0.4, -2.0):
            point = trailing_point(loop, direction)
            arm = np.subtract(loop.slider.hitch, loop.model.pressure.centre)
            points, weights = loop.model.pressure.quadrature
            seen = direction - point.theta
            second = weights @ ((points - loop.model.pressure.centre) @ [math.cos(seen), math.sin(seen)]) ** 2
            numbers = (q[0, 0], q[0, 1], q[1, 1], *m, direction, float(np.hypot(*arm)), second)
            assert abs(point.rate + rate(*numbers)) < 1e-9 * point.rate
            fx, fy = force(*numbers).ravel()
            assert abs(math.remainder(math.atan2(fy, fx) - point.force_direction, 2 * math.pi)) < 1e-12
            turned = point.theta + math.atan2(arm[1], arm[0])
            assert abs(math.remainder(turned - point.force_direction, 2 * math.pi)) < 1e-12


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: EllipsoidLeg(0.0), "rate must be positive"),
        (lambda: EllipsoidLeg.of_lever(0.0, 0.02), "lever must be positive"),
        (lambda: LEG.strength(-0.1), "length must not be negative"),
        (lambda: LEG.forgetting_length(0.1, 0.0), "share left out must be positive"),
        (lambda: LEG.forgetting_length(0.1, 1.0), "none at all is out of reach"),
        (lambda: LEG.share_within(3.2, 0.1), "choose one below pi"),
        (lambda: trailing_point(CollectionLoop.mit(slider=Slider.mit("rect1", (0.0, 0.0)))), "never comes to trail"),
        (lambda: trailing_point(CollectionLoop.mit(reset=DragBack((), 1e-3))), "set it to zero"),
    ],
)
def test_bad_values_are_refused(call, match):
    with pytest.raises(InvalidInput, match=match):
        call()
