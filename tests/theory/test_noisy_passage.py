"""The bottleneck under noise: the double integral in symbols, its limits, and the code's mean
passage times.
"""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad

from cyclemap.maps import CircleMap, WrappedNormal, mean_passage_time
from theory import noisy_passage as theory

A, D, EPS, U = theory.CURVATURE, theory.DIFFUSION, theory.GAP, theory.SEPARATION


def test_the_integral_over_the_middle_is_the_gaussian_that_the_integrand_holds():
    middle = sp.integrate(sp.exp(-A * theory.MIDDLE**2 * U / D), (theory.MIDDLE, -sp.oo, sp.oo))
    rest = theory.exponent().subs(theory.MIDDLE, 0)
    assert sp.simplify(theory.exponent() - rest + A * theory.MIDDLE**2 * U / D) == 0
    assert sp.simplify(middle * sp.exp(rest) / D - theory.integrand()) == 0


def test_the_integral_at_tangency_is_the_gamma_function():
    power = sp.Symbol("t", positive=True)
    # With t = a u³/(12 D) the integral becomes Euler's.
    place = sp.cbrt(12 * D * power / A)
    substituted = theory.integrand().subs(EPS, 0).subs(U, place) * sp.diff(place, power)
    euler = power ** sp.Rational(-5, 6) * sp.exp(-power)
    assert (
        sp.simplify(
            substituted / euler * sp.gamma(sp.Rational(1, 6)) - theory.passage_at_tangency()
        )
        == 0
    )
    assert sp.simplify(sp.integrate(euler, (power, 0, sp.oo)) - sp.gamma(sp.Rational(1, 6))) == 0


def test_the_well_takes_kramers_time():
    depth = sp.Symbol("e", positive=True)
    barrier = 4 * depth ** sp.Rational(3, 2) / (3 * D * sp.sqrt(A))
    wanted = sp.pi / sp.sqrt(A * depth) * sp.exp(barrier)
    assert sp.simplify(theory.kramers_time() / wanted - 1) == 0
    value = sp.lambdify((U, EPS, A, D), theory.integrand())
    ratios = []
    for noise in (0.1, 0.05):
        total = (
            2.0
            * quad(
                lambda w, d=noise: w * value(w * w, -1.0, 1.0, d), 0.0, 3.0, epsabs=0.0, limit=200
            )[0]
        )
        ratios.append(total / float(theory.kramers_time().subs({depth: 1, A: 1, D: noise})))
    # The next order is linear in D.
    assert 1.6 < (ratios[0] - 1.0) / (ratios[1] - 1.0) < 2.6


@pytest.mark.slow
def test_the_codes_mean_passage_times_exceed_the_integral_by_a_bounded_time_only():
    """The sine map's whole turn, gap in the noise's own unit (aD²)^(1/3): below, at and above
    tangency.
    """
    value = sp.lambdify((U, EPS, A, D), theory.integrand())
    middle, strength = math.pi / 2, 0.4
    for unit in (-1.0, 0.0, 1.0):
        rest, integral = [], []
        for sigma in (0.08, 0.04):
            numbers = (
                unit * (strength / 2.0 * (sigma**2 / 2.0) ** 2) ** (1.0 / 3.0),
                strength / 2.0,
                sigma**2 / 2.0,
            )
            circle_map = CircleMap.arnold((strength + numbers[0]) / (2.0 * math.pi), strength)
            arc = (middle - math.pi, middle + math.pi)
            found = mean_passage_time(
                circle_map, WrappedNormal(sigma), arc[0] + 0.6, arc, lifted=True
            )
            integral.append(
                2.0 * quad(lambda w, n=numbers: w * value(w * w, *n), 0.0, 3.0, limit=300)[0]
            )
            rest.append(float(found) - integral[-1])
        assert integral[1] > 1.5 * integral[0] > 50.0
        assert max(np.abs(rest)) < 2.0
