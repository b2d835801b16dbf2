"""Slopes by differences carry their errors into maps made of maps, multipliers and exponents."""

from fractions import Fraction

import numpy as np
import pytest

from cyclemap.maps import (
    CircleMap,
    WrappedNormal,
    compose,
    conjugate,
    inverse,
    lyapunov_exponent,
    nth_iterate,
    periodic_orbits,
    shifted,
)
from tests.maps.known_maps import TWO_PI, lines


def waved(waves, derivative):
    """A homeomorphism with so many waves, with its derivative, without, or as branches without."""

    def lift(x):
        return x + 0.3 + 0.5 / waves * np.sin(waves * x) + 0.2 * np.sin(x)

    def slope(x):
        return 1 + 0.5 * np.cos(waves * x) + 0.2 * np.cos(x)

    if derivative == "branches":
        return CircleMap.from_branches([(0.0, 3.0, lift, None), (3.0, TWO_PI, lift, None)])
    return CircleMap(lift, slope if derivative == "given" else None)


MADE = [
    lambda f: f,
    lambda f: nth_iterate(f, 3),
    lambda f: compose(f, f),
    inverse,
    lambda f: conjugate(f, 1.0),
    lambda f: shifted(f, 1),
    lambda f: nth_iterate(inverse(f), 2),
]


@pytest.mark.parametrize("waves", [1, 200])
@pytest.mark.parametrize("derivative", ["branches", "none"])
def test_slopes_of_maps_made_of_maps_are_within_their_errors(waves, derivative):
    theta = np.random.default_rng(4).uniform(0.0, TWO_PI, 200)
    for make in MADE:
        exact = make(waved(waves, "given")).derivative_and_error(theta)
        found = make(waved(waves, derivative)).derivative_and_error(theta)
        assert np.all(np.abs(found[0] - exact[0]) <= found[1] + exact[1])
        assert np.median(found[1]) < 1e-6


def test_a_slope_read_where_rounding_has_put_the_image_is_within_its_error():
    """F' climbs by 2e4 a radian on a milliradian of the second map; the truth is in fractions."""
    bend, start, end = 1e4, 2.0, 2.001
    pieces = [
        (0.0, start, lambda x: x, np.ones_like),
        (start, end, lambda x: x + bend * (x - start) ** 2, lambda x: 1 + 2 * bend * (x - start)),
        (end, TWO_PI, lambda x: x + 0.01, np.ones_like),
    ]
    made = compose(CircleMap.from_branches(pieces), CircleMap.rigid(0.1))
    theta = np.random.default_rng(2).uniform(1.37169, 1.37267, 500)  # which lead to the bend
    slopes, errors = made.derivative_and_error(theta)
    past = [Fraction(angle) + Fraction(TWO_PI * 0.1) - 2 for angle in theta.tolist()]
    truth = [1 + 2 * Fraction(bend) * distance for distance in past]
    off = [abs(float(Fraction(s) - t)) for s, t in zip(slopes.tolist(), truth, strict=True)]
    assert np.all(off <= errors) and np.max(errors) < 1e-9
    # Far above what F' itself is good to.
    assert np.max(off) > 1e-12


TENT = lines((0, np.pi, 0, 1.7), (np.pi, TWO_PI, 1.7 * TWO_PI, -1.7), degree=0, slopes=False)


@pytest.mark.slow
@pytest.mark.parametrize(("steps", "noise"), [(2, None), (1, WrappedNormal(0.1))])
def test_a_tent_without_a_derivative_knows_how_well_its_exponent_is_known(steps, noise):
    found = lyapunov_exponent(nth_iterate(TENT, steps), noise)
    assert abs(found - steps * np.log(1.7)) <= found.error_bound < 1e-9


def test_multipliers_carry_the_error_of_the_slope():
    orbits = periodic_orbits(TENT, 3)
    assert len(orbits) == 2
    for orbit in orbits:
        assert abs(abs(orbit.multiplier) - 1.7**3) <= orbit.multiplier.error_bound < 1e-8
    given = CircleMap.arnold(0.1, 0.9)
    bare = CircleMap(lambda x: x + 0.1 * TWO_PI - 0.9 * np.sin(x))
    for exact, found in zip(periodic_orbits(given, 1), periodic_orbits(bare, 1), strict=True):
        assert found.multiplier.holds(exact.multiplier) and exact.multiplier.error_bound < 1e-12
