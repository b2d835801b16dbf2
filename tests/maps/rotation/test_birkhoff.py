"""Weighted Birkhoff averages against closed forms, and what their error bound is worth."""

from itertools import pairwise

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, birkhoff_average
from cyclemap.maps.orbits.rotation_number import orbit_angles, weighted_mean

TWO_PI = 2 * np.pi
KNOWN = [
    (CircleMap.moebius(0.5, 0.3), 0.262536755898823346733597549046),
    (CircleMap.moebius(0.9, 0.45), 0.383156928981311432564754399638),
    (CircleMap.arnold(0.6, 0.5), 0.602894830374585070928578946844),
]


@pytest.mark.parametrize(("circle_map", "turns"), KNOWN)
def test_fourteen_digits_of_diophantine_rotation_numbers(circle_map, turns):
    mean = birkhoff_average(circle_map)
    assert abs(mean / TWO_PI - turns) < 1e-15
    assert abs(mean - TWO_PI * turns) <= mean.error_bound < 1e-14


@pytest.mark.parametrize(("circle_map", "turns"), KNOWN)
def test_the_error_bound_holds_at_every_length_and_falls_faster_than_any_power(circle_map, turns):
    means = [birkhoff_average(circle_map, iterates=n, start=1.0) for n in (100, 300, 1000, 3000, 10000)]
    errors = [abs(mean - TWO_PI * turns) for mean in means]
    bounds = [mean.error_bound for mean in means]
    assert all(error <= bound for error, bound in zip(errors, bounds, strict=True))
    assert errors[0] > 1e-9
    assert bounds[-1] < 1e-14
    # A hundred times better for three times the length, at least twice: faster than the fourth power.
    steps = [a / max(b, 1e-16) for a, b in pairwise(bounds)]
    assert sum(step > 100 for step in steps) >= 2


def test_a_mean_over_the_invariant_law_of_a_moebius_map():
    """E e^{iθ} under the invariant law is the fixed point z* of z → e^{iω}(z - a)/(1 - a z) inside the disc."""
    a, omega = 0.5, 0.3
    w = np.exp(2j * np.pi * omega)
    roots = np.roots([a, -(1 - w), -w * a])
    inside = roots[np.abs(roots) < 1][0]
    moebius = CircleMap.moebius(a, omega)
    cosine, sine = birkhoff_average(moebius, np.cos), birkhoff_average(moebius, np.sin)
    assert abs(complex(cosine, sine) - inside) < 1e-14
    assert cosine.error_bound < 1e-14


def test_a_plain_mean_is_far_worse():
    circle_map, turns = KNOWN[0]
    visited = orbit_angles(circle_map, 0.0, 40_000)
    plain = np.mean(circle_map.turn(visited))
    assert abs(plain - TWO_PI * turns) > 1e6 * abs(birkhoff_average(circle_map) - TWO_PI * turns)


@pytest.mark.slow
def test_chaotic_orbits_have_a_bound_of_a_plain_means_size():
    """x → 3x (mod 2π): cos has mean 0 and variance 1/2; the bound is of the order of the sampling error."""
    tripling = CircleMap(lambda x: 3 * x, degree=3)
    held = 0
    for start in np.linspace(0.1, 6.0, 40):
        mean = birkhoff_average(tripling, np.cos, start=start, iterates=4000)
        held += abs(mean) <= 2 * mean.error_bound
        assert mean.error_bound < 0.2
    assert held >= 32


def test_transients_and_minus_infinity():
    locked = CircleMap.arnold(0.1, 0.9)
    stable = np.arcsin(0.2 * np.pi / 0.9)
    mean = birkhoff_average(locked, np.sin, start=3.0, iterates=16, transient=2000)
    assert abs(mean - np.sin(stable)) < 1e-14
    assert mean.error_bound < 1e-14
    nothing = birkhoff_average(locked, lambda x: np.full_like(x, -np.inf), iterates=16)
    assert nothing == -np.inf
    assert nothing.error_bound == 0.0


def test_orbit_angles_stay_in_one_turn_and_follow_the_map():
    sine = CircleMap.arnold(-0.37, 0.8)
    visited = orbit_angles(sine, -9.0, 500)
    assert np.all((visited >= 0.0) & (visited <= TWO_PI))
    ahead = np.mod(sine(visited[:-1]) - visited[1:] + np.pi, TWO_PI) - np.pi
    assert np.max(np.abs(ahead)) < 1e-14
    assert visited.size == 500


def test_weights_sum_to_one_and_are_symmetric():
    values = np.random.default_rng(0).normal(size=101)
    assert abs(weighted_mean(values) - weighted_mean(values[::-1])) < 1e-15
    assert abs(weighted_mean(np.ones(101)) - 1.0) < 1e-15


def test_bad_input_is_refused():
    sine = CircleMap.arnold(0.1, 0.5)
    with pytest.raises(InvalidInput, match="degree 2"):
        birkhoff_average(CircleMap(lambda x: 2 * x, degree=2))
    with pytest.raises(InvalidInput, match="CircleMap"):
        birkhoff_average(np.sin)
    with pytest.raises(InvalidInput, match="iterates"):
        birkhoff_average(sine, iterates=15)
    with pytest.raises(InvalidInput, match="transient"):
        birkhoff_average(sine, transient=-1)
    with pytest.raises(InvalidInput, match="start"):
        birkhoff_average(sine, start=np.nan)
    with pytest.raises(InvalidInput, match="entry by entry"):
        birkhoff_average(sine, lambda x: 1.0)
    with pytest.raises(InvalidInput, match="finite"):
        birkhoff_average(sine, lambda x: x * np.nan)
    with pytest.raises(InvalidInput, match="at least 16"):
        weighted_mean(np.ones(15))
