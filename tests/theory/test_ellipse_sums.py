"""The sums under ellipses: proved where they are identities, and their rules' errors as far as they
say.
"""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.special import ellipj, ellipk

from cyclemap.mechanics import Ellipse, EllipseFriction, LimitSurface, PatchFootprint
from theory import ellipse_sums as theory

LAW = EllipseFriction(0.31, 0.17, phi=0.8)
OVAL = Ellipse(0.05, 0.03)


# These take SymPy more than half a second.
LONG = ("outer_area_residual", "depth_residual")
NAMES = [name for name in vars(theory) if name.endswith("_residual")]
CASES = [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in NAMES]


@pytest.mark.parametrize("name", CASES)
def test_every_identity_holds(name):
    assert sp.simplify(getattr(theory, name)()) == 0


def test_moments_of_a_chord_are_those_that_are_summed():
    a, b, f, g, q = *sp.symbols("a b f g"), theory.HALF
    even, odd = theory.chord_moments()
    cube = sp.Rational(2, 3) * q**3
    assert sp.expand(even - (2 * q * a * f + cube * b * g)) == 0
    assert sp.expand(odd - cube * (a * g + b * f)) == 0


@pytest.mark.slow
def test_the_best_bend_is_the_root_of_what_it_mends():
    """Both distances become atanh of the root of tanh eta."""
    assert sp.simplify(theory.best_bend() - 1 / sp.sqrt(sp.tanh(theory.ETA))) == 0


def image(law, outline):
    """The matrix from the unit disc's coordinates to the velocity plane for a unit spin."""
    c, s = math.cos(law.phi), math.sin(law.phi)
    matrix = np.array([[law.mu_a * c, law.mu_a * s], [-law.mu_b * s, law.mu_b * c]])
    return matrix @ np.array([[0.0, -1.0], [1.0, 0.0]]) @ np.diag([outline.semi_x, outline.semi_y])


@pytest.mark.parametrize("away", [0.3, 0.8, 1.5])
def test_chords_add_up_to_the_codes_dissipation_as_exponentially_as_the_singularities_are_far(away):
    """Of a spin about a place inside or outside: even steps in t, each chord summed as its
    direction times |w|.
    """
    linear, centre = image(LAW, OVAL), away * np.array([0.6, 0.8])
    place = centre * (OVAL.semi_x, OVAL.semi_y)
    wanted = float(LimitSurface(PatchFootprint(OVAL), LAW).dissipation([place[1], -place[0], 1.0]))
    errors = []
    for count in (8, 16, 32):
        t = (np.arange(count) + 0.5) * math.pi / count
        if away < 1.0:
            middle, half = away * np.cos(t), np.sqrt(1.0 - (away * np.sin(t)) ** 2)
            angle = t
            moment = (np.abs(half + middle) ** 3 + np.abs(half - middle) ** 3) / 3.0
        else:
            t = t - math.pi / 2.0
            root, half = np.sqrt(1.0 - (np.sin(t) / away) ** 2), np.cos(t)
            angle, middle = np.arcsin(np.sin(t) / away), away * root
            moment = ((middle + half) ** 3 - (middle - half) ** 3) / 3.0 * np.cos(t) / middle
        unit = -centre / away
        across = np.array([-unit[1], unit[0]])
        along = np.cos(angle)[:, None] * unit + np.sin(angle)[:, None] * across
        speed = np.hypot(*(linear @ along.T))
        errors.append(abs(float(np.mean(speed * moment)) - wanted) / wanted)
    assert errors[2] < 1e-7 and errors[2] < 0.1 * errors[0]


@pytest.mark.parametrize("modulus", [0.3, 0.9, 0.999])
def test_elliptic_steps_around_the_circle_integrate_legendres_root_to_rounding(modulus):
    """The length of |Z^2 - s^2| around the circle, by even steps of v and by many even steps of the
    angle.
    """
    s = (1.0 - math.sqrt(1.0 - modulus**2)) / modulus
    whole, count = 4.0 * ellipk(modulus**2), 160
    _, cosine, dense, _ = ellipj((np.arange(count) + 0.5) * whole / count, modulus**2)
    density = math.sqrt(1.0 - modulus**2) / dense
    found = float(
        np.mean(whole * density * (1.0 + s**2) * np.sqrt(1.0 - (modulus * cosine / dense) ** 2))
    )
    phi = (np.arange(200_000) + 0.5) * 2.0 * math.pi / 200_000
    plain = float(np.mean(2.0 * math.pi * np.abs(np.exp(2j * phi) - s**2)))
    assert found == pytest.approx(plain, rel=1e-12)


@pytest.mark.parametrize("modulus", [0.2, 0.7, 0.99])
def test_landens_step_leads_to_jacobis_function(modulus):
    rest = math.sqrt(1.0 - modulus**2)
    small, u = (1.0 - rest) / (1.0 + rest), np.linspace(0.1, 2.0, 7)
    inner = ellipj(u / (1.0 + small), small**2)[0]
    assert np.allclose(theory.landen(inner, small), ellipj(u, modulus**2)[0], rtol=1e-13)
