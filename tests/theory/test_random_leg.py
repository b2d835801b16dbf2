"""A leg in a random direction leaves no bias: in symbols, in the code's drag, and for the
ellipsoid's memory.
"""

import numpy as np
import pytest
import sympy as sp

from cyclemap.maps import CircleMap
from theory import random_leg as theory
from theory.moebius_drag import strength


def test_the_turn_does_not_know_the_orientation():
    turn = theory.turn_by_heading(sp.Function("g"))
    assert not turn.has(theory.START, theory.DIRECTION)


@pytest.mark.slow
def test_the_memory_is_the_stated_residue():
    a, z = theory.STRENGTH, theory.POINT
    for order in range(1, 5):
        ratio = ((z + a) / (z * (1 + a * z))) ** order / z
        assert sp.simplify(sp.residue(ratio, z, 0) - theory.memory(order)) == 0
        assert sp.simplify(theory.memory(order).subs(a, 0) - 1) == 0
        assert theory.memory(order).subs(a, 1) == 0


def test_the_first_memory_is_the_stated_function_of_the_length():
    residual = theory.memory(1).subs(theory.STRENGTH, strength()) - theory.correlation()
    assert sp.simplify(residual.rewrite(sp.exp)) == 0


def test_one_leg_gives_even_headings_the_powers_of_its_strength_as_moments():
    x = np.linspace(0.0, 2.0 * np.pi, 4096, endpoint=False)
    for a in (0.1, 0.5, 0.9):
        heading = CircleMap.moebius(a, 0.0)(x) - np.pi
        for order in range(1, 6):
            wanted = float(theory.moment_from_uniform(order).subs(theory.STRENGTH, a))
            assert abs(np.mean(np.exp(1j * order * heading)) - wanted) < 1e-13


def moments_left(strength, rotation, directions, order=64):
    """Stationary moments E e^{inθ}, n = -order..order, of a Möbius leg in one of K directions at
    random.
    """
    grid = np.arange(8 * order) * 2.0 * np.pi / (8 * order)
    numbers = np.arange(-order, order + 1)
    matrix = np.zeros((numbers.size, numbers.size), dtype=complex)
    for angle in np.arange(directions) * 2.0 * np.pi / directions:
        image = CircleMap.moebius(strength, 0.0)(grid - angle) + angle + rotation
        waves = np.fft.fft(np.exp(1j * numbers[:, None] * image), axis=1) / grid.size
        matrix += waves[:, numbers] / directions
    centre = order
    rest = numbers != 0
    moments = np.ones(numbers.size, dtype=complex)
    system = np.eye(2 * order) - matrix[np.ix_(rest, rest)]
    moments[rest] = np.linalg.solve(system, matrix[rest, centre])
    return dict(zip(numbers.tolist(), moments, strict=True))


def test_k_directions_leave_only_every_kth_harmonic_of_the_bias():
    """One fixed direction leaves a bias a; two leave no first harmonic; three no first and no
    second.
    """
    for directions in (1, 2, 3, 4):
        moments = moments_left(0.3, 1.0, directions)
        for n in range(1, 7):
            share = theory.surviving_share(n, directions)
            assert share == (1 if n % directions == 0 else 0)
            if share == 0:
                assert abs(moments[n]) < 1e-12
        assert abs(moments[directions]) > 1e-5
    assert abs(moments_left(0.3, 1.0, 1)[1]) > 0.1
