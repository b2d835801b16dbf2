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
    gamma = sp.gamma(sp.Rational(1, 6))
    assert sp.simplify(substituted / euler * gamma - theory.passage_at_tangency()) == 0
    assert sp.simplify(sp.integrate(euler, (power, 0, sp.oo)) - gamma) == 0


def integral_of(gap, curvature, diffusion):
    """The passage's double integral, by its separations' roots."""
    value = sp.lambdify((U, EPS, A, D), theory.integrand())

    def by_root(root):
        return root * value(root * root, gap, curvature, diffusion)

    return 2.0 * quad(by_root, 0.0, 3.0, epsabs=0.0, limit=300)[0]


def test_the_well_takes_kramers_time():
    depth = sp.Symbol("e", positive=True)
    barrier = 4 * depth ** sp.Rational(3, 2) / (3 * D * sp.sqrt(A))
    wanted = sp.pi / sp.sqrt(A * depth) * sp.exp(barrier)
    assert sp.simplify(theory.kramers_time() / wanted - 1) == 0
    ratios = []
    for noise in (0.1, 0.05):
        kramers = float(theory.kramers_time().subs({depth: 1, A: 1, D: noise}))
        ratios.append(integral_of(-1.0, 1.0, noise) / kramers)
    # The next order is linear in D.
    assert 1.6 < (ratios[0] - 1.0) / (ratios[1] - 1.0) < 2.6


@pytest.mark.slow
def test_the_codes_mean_passage_times_exceed_the_integral_by_a_bounded_time_only():
    """The sine map's whole turn, gap in the noise's own unit (aD²)^(1/3): below, at and above
    tangency.
    """
    middle, strength = math.pi / 2, 0.4
    arc = (middle - math.pi, middle + math.pi)
    for unit in (-1.0, 0.0, 1.0):
        rest, integral = [], []
        for sigma in (0.08, 0.04):
            diffusion = sigma**2 / 2.0
            gap = unit * (strength / 2.0 * diffusion**2) ** (1.0 / 3.0)
            circle_map = CircleMap.arnold((strength + gap) / (2.0 * math.pi), strength)
            noise = WrappedNormal(sigma)
            found = mean_passage_time(circle_map, noise, arc[0] + 0.6, arc, lifted=True)
            integral.append(integral_of(gap, strength / 2.0, diffusion))
            rest.append(float(found) - integral[-1])
        assert integral[1] > 1.5 * integral[0] > 50.0
        assert max(np.abs(rest)) < 2.0
