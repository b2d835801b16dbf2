"""Topological entropy by closed forms, counts of periodic points, invariances;
kneading sequences."""

from itertools import pairwise

import numpy as np
import pytest

from cyclemap.maps import (
    CircleMap,
    conjugate,
    kneading_sequences,
    nth_iterate,
    periodic_points,
    rotation_interval,
    topological_entropy,
)
from tests.maps.known_maps import DOUBLING, DROPPING, TWO_PI, lines, logistic
from tests.refusals import refused

FOLDED = CircleMap.arnold(0.5, 3.0)


def zigzag(slope, shift):
    """A lift of degree 1 with slopes ±s: its entropy is ln s (Misiurewicz & Szlenk 1980)."""
    top = np.pi * (1 / slope + 1)
    return lines((0, top, shift, slope), (top, TWO_PI, shift + 2 * slope * top, -slope))


@pytest.mark.parametrize(("slope", "shift"), [(1.3, 0.3), (2.0, 1.0), (3.0, 0.3), (4.4, 5.1)])
def test_a_lift_of_constant_slope_has_its_logarithm(slope, shift):
    found = topological_entropy(zigzag(slope, shift))
    assert found.holds(np.log(slope)) and found.error_bound < 1e-6


@pytest.mark.parametrize(
    ("r", "known"), [(3.5, 0.0), (3.83, np.log(0.5 + 0.5 * 5**0.5)), (4.0, np.log(2.0))]
)
def test_logistic_maps_have_the_known_values(r, known):
    """None below chaos, ln 2 at r = 4; in the window of period 3 the entropy of its graph, the
    golden mean's logarithm.
    """
    found = topological_entropy(logistic(r))
    assert found.holds(known) and found.error_bound < 1e-3
    assert r < 4.0 or abs(found - known) < 1e-11


def test_the_entropy_of_logistic_maps_rises():
    """Milnor & Thurston 1988."""
    values = [topological_entropy(logistic(r)) for r in (3.6, 3.7, 3.8, 3.9)]
    assert all(one.upper < other.lower for one, other in pairwise(values))


def test_periodic_points_grow_no_faster_than_the_entropy_of_an_expanding_lift_and_nearly_as_fast():
    slope = zigzag(2.7, 0.3)
    count = periodic_points(slope, 7).count
    assert np.log(count) / 7 == pytest.approx(topological_entropy(slope), abs=0.15)


def test_entropy_is_kept_by_turning_and_multiplied_by_iterating():
    entropy = topological_entropy(FOLDED)
    turned = topological_entropy(conjugate(FOLDED, 1.0))
    assert abs(turned - entropy) <= turned.error_bound + entropy.error_bound < 1e-7
    twice = topological_entropy(nth_iterate(FOLDED, 2))
    assert abs(twice - 2 * entropy) <= twice.error_bound + 2 * entropy.error_bound < 1e-4


def test_without_folds_it_is_the_logarithm_of_the_degree():
    assert topological_entropy(CircleMap.arnold(0.2, 0.9)) == 0.0
    assert topological_entropy(DOUBLING).holds(np.log(2.0))
    assert kneading_sequences(DOUBLING) == ()


def test_a_lift_whose_rotation_interval_is_one_fraction_may_have_none_and_wide_ones_have_much():
    """An interval of rotation numbers [0, 1/2] or wider means positive entropy (Misiurewicz
    1986)."""
    rng, wide = np.random.default_rng(2), 0
    for _ in range(5):
        circle_map = CircleMap.arnold(rng.uniform(0, 1), rng.uniform(1.2, 4.0))
        interval = rotation_interval(circle_map, iterates=2_000)
        entropy = topological_entropy(circle_map)
        if interval.lower_number.upper < interval.upper_number.lower:
            assert entropy.lower > 0.0
            wide += 1
        assert entropy.upper <= np.log(3 + 2 * np.ceil(1.0 + 4.0 / np.pi))
    assert 2 <= wide <= 4


def test_more_images_narrow_the_bounds_and_never_move_them_apart():
    estimates = [topological_entropy(FOLDED, iterates=count) for count in (2, 4, 8, 16)]
    widths = [one.error_bound for one in estimates]
    assert all(later < 0.5 * sooner for sooner, later in pairwise(widths))
    last = topological_entropy(FOLDED)
    assert all(one.lower <= last.upper and last.lower <= one.upper for one in estimates)


def test_bounds_hold_for_lifts_moved_by_what_they_may_be_off():
    rng, off = np.random.default_rng(8), 1e-4
    for _ in range(3):
        plain = CircleMap.arnold(rng.uniform(0, 1), rng.uniform(1.5, 4.0))
        claimed = CircleMap(plain, plain.derivative, max_error=off)
        wave = off * np.cos(rng.uniform(0, 6))
        moved = CircleMap(
            lambda x, m=plain, w=wave: m(x) + w * np.cos(x),
            lambda x, m=plain, w=wave: m.derivative(x) - w * np.sin(x),
        )
        one, other = topological_entropy(claimed), topological_entropy(moved)
        assert abs(one - other) <= one.error_bound + other.error_bound


@pytest.mark.parametrize("off", [5e-4, 0.5])
def test_bounds_hold_the_smooth_lift_from_which_every_fold_has_been_made_by_an_error(off):
    """Ripples as high as the error on a lift of slope 1/2, all of whose orbits come to rest."""

    def ripples(x):
        near = np.mod(x + np.pi, TWO_PI) - np.pi
        window = off * np.exp(-((near / off) ** 2))
        phase = 4.5 * near / off + 1.6
        steep = 4.5 / off * np.cos(phase) - 2.0 * near / off**2 * np.sin(phase)
        return window * np.sin(phase), window * steep

    def rippled(x):
        return 0.5 * np.sin(x) + ripples(x)[0]

    def slope(x):
        return 0.5 * np.cos(x) + ripples(x)[1]

    folded = topological_entropy(CircleMap(rippled, slope, degree=0))
    found = topological_entropy(CircleMap(rippled, slope, degree=0, max_error=1.001 * off))
    assert found.lower <= 0.0 and folded > 0.5 and found.upper >= folded.upper


def test_kneading_sequences_follow_the_orbits_of_the_folds():
    first, last = np.arccos(1 / 3), TWO_PI - np.arccos(1 / 3)
    for sequence, theta in zip(kneading_sequences(FOLDED, 12), (first, last), strict=True):
        letters = []
        for _ in range(12):
            theta = np.mod(float(FOLDED(theta)), TWO_PI)
            letters.append(0 if first <= theta < last else 1)
        assert list(sequence) == letters


def test_what_has_no_entropy_or_more_points_than_can_be_solved_for_is_refused():
    refused(topological_entropy, DROPPING, told="F jumps")
    refused(kneading_sequences, "map", told="give a CircleMap")
    inexact = CircleMap(FOLDED, FOLDED.derivative, max_error=3.2)
    refused(topological_entropy, inexact, told="tells nothing of its entropy")
    steep = CircleMap.arnold(0.0, 1.5)
    refused(topological_entropy, steep, iterates=1_000_000, told="iterates is 1000000")
