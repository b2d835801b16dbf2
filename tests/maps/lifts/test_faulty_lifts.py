"""Lifts that are not what they should be somewhere: every answer names the place."""

import re

import numpy as np
import pytest

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps import (
    CircleMap,
    WrappedNormal,
    fixed_points,
    lyapunov_exponent,
    periodic_orbits,
    rotation_interval,
    rotation_number,
    transfer_operator,
)
from tests.maps.known_maps import TWO_PI, agree, apart
from tests.refusals import refused

ROUGH = r"too rough to follow.*θ = (\S+) and (\S+): a break may be missing"
HOLE = (2.06, 2.11)  # an arc that holds none of the angles at which a map is tried when it is made


def base(x):
    return np.mod(x, TWO_PI)


def tent(x):
    """A kink at 1 and at 1 + π."""
    return x + 0.4 + 0.3 / np.pi * np.abs(np.mod(x - 1 + np.pi, TWO_PI) - np.pi)


def raised(x):
    """Half a radian higher from 2 on, until 2π."""
    return x + 0.4 + 0.5 * (base(x) > 2.0)


def cliff(x):
    """Climbs by 0.8 within 1e-7 radians at 1, falls again at 1 + π."""
    return x + 0.4 + 0.4 * np.tanh(np.sin(x - 1) / 1e-7)


def everywhere_rough(x):
    return x + 0.4 + 0.1 * sum(2.0**-k * np.cos(3.0**k * x) for k in range(16))


@pytest.mark.parametrize(
    ("lift", "places"), [(tent, (1.0, 1 + np.pi)), (raised, (0.0, 2.0)), (cliff, (1.0, 1 + np.pi))]
)
def test_a_missing_break_is_named_where_there_are_only_differences(lift, places):
    with pytest.raises(ConvergenceError, match=ROUGH) as told:
        fixed_points(CircleMap(lift))
    words = re.search(ROUGH, str(told.value)).groups()
    ends = np.array([[float(word)] for word in words])
    assert np.min(np.max(apart(ends, places), axis=0)) < 1e-4


@pytest.mark.slow
def test_a_hidden_jump_is_named_where_the_derivative_is_given():
    for ask in (fixed_points, rotation_interval, lambda one: periodic_orbits(one, 2)):
        told = r"jumps by 0\.5\d* radians at θ = (1\.99999|2\.0000|6\.28318).*none of"
        refused(ask, CircleMap(raised, np.ones_like), kind=ConvergenceError, told=told)
    declared = CircleMap(raised, np.ones_like, [0.0, 2.0])
    assert rotation_interval(declared).lower > 0.0


def test_with_its_derivative_a_hidden_kink_or_cliff_costs_nothing():
    def slope(x):
        return 1 + 0.3 / np.pi * np.sign(np.mod(x - 1 + np.pi, TWO_PI) - np.pi)

    for period in (1, 2, 3):
        found, known = (
            periodic_orbits(CircleMap(tent, slope, breaks), period)
            for breaks in ([], [1.0, 1 + np.pi])
        )
        assert len(found) == len(known)
    steep = CircleMap(
        lambda x: cliff(x) - 0.4,
        lambda x: 1 + 4e6 * np.cos(x - 1) / np.cosh(np.clip(np.sin(x - 1) / 1e-7, -300, 300)) ** 2,
    )
    # F - id = 0.4 tanh(sin(x - 1)/1e-7) vanishes at 1 and 1 + π.
    agree([point.points[0] for point in fixed_points(steep)], [1.0, 1 + np.pi], 1e-12)


@pytest.mark.slow
def test_a_lift_rough_everywhere_is_refused_with_a_place():
    for ask in (fixed_points, rotation_number, lambda one: periodic_orbits(one, 3)):
        refused(ask, CircleMap(everywhere_rough), kind=ConvergenceError, told=ROUGH)


def in_hole(x):
    return (base(x) > HOLE[0]) & (base(x) < HOLE[1])


def holed(x):
    return np.where(in_hole(x), np.nan, x + 0.4 + 0.1 * np.sin(x))


def failing(x):
    if np.any(in_hole(x)):
        raise ZeroDivisionError("the table has a hole")
    return x + 0.4 + 0.1 * np.sin(x)


def has_hole(x):
    return np.where(in_hole(x), np.nan, 1.0)


NO_NUMBERS = ["0.3", np.datetime64("2020-01-01"), ["1.0", "x"], [[1.0], [2.0, 3.0]], 10**400]


@pytest.mark.parametrize("method", ["__call__", "turn", "derivative", "left", "right"])
def test_angles_that_are_no_numbers_are_refused(method):
    for theta in NO_NUMBERS:
        ask = getattr(CircleMap.arnold(0.1, 0.5), method)
        refused(ask, theta, told="theta must hold numbers only")


@pytest.mark.parametrize("degree", [10**400, -(10**16)])
def test_a_degree_beyond_all_floats_is_refused(degree):
    told = "degree must lie within"
    refused(CircleMap, np.sin, degree=degree, told=told)
    refused(CircleMap.from_samples, [0.0, 1.0, 2.0], [0.0, 1.0, 2.0], degree=degree, told=told)


SOUND, SLOPE = CircleMap.arnold(0.1, 0.5), lambda x: 1 + 0.1 * np.cos(x)
ASKED = [
    rotation_number,
    rotation_interval,
    fixed_points,
    lyapunov_exponent,
    lambda one: transfer_operator(one, WrappedNormal(0.3)).error_bound,
    lambda one: lyapunov_exponent(one, WrappedNormal(0.3)),
]


@pytest.mark.parametrize(
    ("lift", "slope", "words", "ask"),
    [
        *((holed, SLOPE, "gives nan", ask) for ask in ASKED),
        *((failing, SLOPE, "fails .*the table has a hole", ask) for ask in ASKED),
        (SOUND, has_hole, "the derivative gives nan", fixed_points),
    ],
)
def test_a_lift_or_derivative_with_a_hole_names_an_angle_in_it(lift, slope, words, ask):
    with pytest.raises(InvalidInput, match=words) as told:
        ask(CircleMap(lift, slope))
    assert in_hole(float(re.search(r"θ = ([\d.]+\d)", str(told.value))[1]))
