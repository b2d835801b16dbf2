"""Maximum dissipation on the limit ellipse gives the traction law, and the code's friction is that
law.
"""

import math

import numpy as np
import pytest
import sympy as sp

from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction
from theory import traction_law as theory

LAW = (theory.MU_A, theory.MU_B, theory.M0, theory.N0)
VELOCITY = (theory.V_M, theory.V_N)


def random_laws(count, seed=0):
    """Axis ratio in [1/3, 3], centre anywhere inside 95 % of the ellipse."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        mu_a = rng.uniform(0.1, 0.5)
        mu_b, off = mu_a * 3.0 ** rng.uniform(-1, 1), 0.95 * math.sqrt(rng.uniform())
        towards, phi = rng.uniform(0, 7, 2).tolist()
        centre = off * mu_a * math.cos(towards), off * mu_b * math.sin(towards)
        yield EllipseFriction(mu_a, mu_b, *centre, phi)


def numbers(law):
    return law.mu_a, law.mu_b, law.m0, law.n0


def test_the_codes_dissipation_and_traction_are_the_derived_ones_to_rounding():
    h = sp.lambdify((*LAW, *VELOCITY), theory.dissipation())
    force = sp.lambdify((*LAW, *VELOCITY), list(theory.most_dissipating_traction()))
    velocities = np.random.default_rng(1).normal(size=(50, 2))
    for law in random_laws(30):
        c, s = math.cos(law.phi), math.sin(law.phi)
        turn = np.array(((c, -s), (s, c)))
        along, across = (velocities @ turn).T
        power = h(*numbers(law), along, across)
        assert np.allclose(law.dissipation(velocities), power, rtol=1e-13, atol=1e-15)
        derived = np.stack(force(*numbers(law), along, across), axis=-1) @ turn.T
        assert np.allclose(law.traction(velocities), derived, rtol=0, atol=1e-14)


def test_the_code_refuses_a_law_exactly_where_the_worst_velocity_no_longer_dissipates():
    worst = sp.lambdify(LAW, theory.dissipation(*theory.worst_velocity()))
    mu_a, mu_b, refused = 0.3, 0.2, 0
    for angle in np.linspace(0.1, 6.2, 12):
        for size in (0.5, 0.999, 1.001, 1.5):
            values = (mu_a, mu_b, size * mu_a * math.cos(angle), size * mu_b * math.sin(angle))
            if worst(*values) > 0.0:
                assert EllipseFriction(*values).m0 == values[2]
                continue
            with pytest.raises(InvalidInput, match="does not contain zero"):
                EllipseFriction(*values)
            refused += 1
    assert refused == 24
