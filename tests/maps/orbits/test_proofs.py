"""Points, saddle-nodes and rotation numbers by interval arithmetic: theorems checked against closed
forms, counting theorems and the search.
"""

import sys
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from cyclemap.errors import ConvergenceError
from cyclemap.maps import (
    CircleMap,
    compose,
    conjugate,
    fixed_points,
    nth_iterate,
    periodic_orbits,
    periodic_points,
    rotation_number,
    saddle_nodes,
)
from tests.maps.known_maps import KNOWN_TURNS, TWO_PI, agree
from tests.refusals import refused

pytest.importorskip(
    "flint", reason="proofs need the extra 'proofs'; install it, or nothing of them is tested"
)
EXACT = mpmath.MPContext()
EXACT.dps = 60
SINE, HALF, STEEP = (CircleMap.arnold(*pair) for pair in ((0.1, 0.9), (0.5, 0.9), (0.3, 3.0)))
ANGLES = np.linspace(0.0, TWO_PI, 80, endpoint=False)


def within(truth, value, bound):
    return abs(truth - EXACT.mpf(float(value))) <= EXACT.mpf(float(bound))


def holds(orbit, theta, multiplier):
    """Whether a fixed point is where it is proved to be, and so is its multiplier."""
    slope = orbit.multiplier
    return within(theta, orbit.points[0], orbit.error_bound) and within(
        multiplier, slope, slope.error_bound
    )


def undecided(ask, *values, told, **named):
    refused(ask, *values, proved=True, kind=ConvergenceError, told=told, **named)


def sampled(circle_map, max_error):
    values = circle_map(ANGLES), circle_map.derivative(ANGLES)
    return CircleMap.from_samples(ANGLES, *values, max_error=max_error)


def test_the_tongue_of_the_sine_map_holds_two_points_where_they_are_and_none_outside():
    """sin θ = s/K with s = 2πΩ as a float; multipliers 1 ∓ √(K² - s²), in 60 digits."""
    random, beside = np.random.default_rng(1), 0
    for _ in range(8):
        strength, share = random.uniform(0.2, 2.5), random.uniform(0.05, 0.999999)
        inside = CircleMap.arnold(share * strength / TWO_PI, strength)
        shift = EXACT.mpf(TWO_PI * (share * strength / TWO_PI))
        root = EXACT.asin(shift / EXACT.mpf(strength))
        steepness = EXACT.sqrt(EXACT.mpf(strength) ** 2 - shift**2)
        first, second = fixed_points(inside, proved=True)
        assert holds(first, root, 1 - steepness) and holds(second, EXACT.pi - root, 1 + steepness)
        assert max(first.error_bound, second.error_bound) < 1e-14
        outside = strength * (1 + 1e-9) / TWO_PI
        if outside + strength / TWO_PI < 1.0:  # else the next tongue begins
            assert fixed_points(CircleMap.arnold(outside, strength), proved=True) == []
            beside += 1
    assert beside >= 4


@pytest.mark.parametrize(("a", "omega"), [(0.5, 0.1), (0.75, 0.2), (0.25, 0.05)])
def test_multipliers_of_a_moebius_map_follow_from_its_trace(a, omega):
    """√λ + 1/√λ = 2 cos(s/2)/√(1 - a²): both multipliers, and their product one."""
    trace = 2 * EXACT.cos(EXACT.mpf(TWO_PI * omega) / 2) / EXACT.sqrt(1 - EXACT.mpf(a) ** 2)
    root = (trace + EXACT.sqrt(trace**2 - 4)) / 2
    orbits = fixed_points(CircleMap.moebius(a, omega), proved=True)
    assert sorted(orbit.kind for orbit in orbits) == ["stable", "unstable"]
    for orbit in orbits:
        truth = root**-2 if orbit.stable else root**2
        assert within(truth, orbit.multiplier, orbit.multiplier.error_bound)


@pytest.mark.parametrize("zeros", [[0, -0.3j, 0.5], [0, 0.2 + 0.3j, -0.6, 0.1]])
def test_an_expanding_blaschke_product_has_as_many_points_as_its_degree_tells(zeros):
    """Degree k, all expanding: kⁿ - 1 points of Fⁿ, and of prime period n, a prime, k - 1 fewer."""
    expanding = CircleMap.blaschke(zeros, 0.1)
    degree = len(zeros)
    for period in (1, 2):
        points = periodic_points(expanding, period, proved=True)
        assert points.count == degree**period - 1
        lower = (degree - 1) * (period > 1)
        assert np.count_nonzero(points.prime_period == period) == points.count - lower
        assert np.all(points.multiplier - points.multiplier_error > 1.0)
        assert np.array_equal(np.sort(points.image), np.arange(points.count))


def test_a_hair_beside_a_tangency_is_decided_and_the_tangency_itself_refused():
    def gapped(gap):
        return CircleMap(lambda x: x + (0.5 + gap) - 0.5 * np.sin(x))

    assert fixed_points(gapped(2.0**-53), proved=True) == []
    half = EXACT.acos(1 - EXACT.mpf(2) ** -53)
    orbits = fixed_points(gapped(-(2.0**-54)), proved=True)
    for orbit, side in zip(orbits, (-1, 1), strict=True):
        assert within(EXACT.pi / 2 + side * half, orbit.points[0], orbit.error_bound)
    undecided(fixed_points, gapped(0.0), told=r"θ = 1\.5707963.*a tangency")


def test_saddle_nodes_lie_within_bounds_between_whose_ends_orbits_are_born():
    """Where the shift is the parameter itself, two points meet at K exactly, and at K/2 twice over;
    the edges of the tongue 1/2 at K = 0.9 and of 1/3 at K = 1 are known to 25 digits.
    """

    def waving(strength, waves):
        return lambda w: CircleMap(lambda x: x + w - strength * np.sin(waves * x))

    def sine(strength):
        return lambda omega: CircleMap.arnold(omega, strength)

    folds = []
    for strength in np.random.default_rng(3).uniform(0.2, 2.5, 2):
        for waves in (1, 2):
            reach = 0.5 * strength, 1.2 * strength
            found = saddle_nodes(waving(strength, waves), reach, resolution=2, proved=True)
            assert len(found) == waves
            folds += [(fold, EXACT.mpf(strength)) for fold in found]
    for strength, p, q, edge in (
        (0.9, 1, 2, "0.46966533712136485155447001"),
        (1.0, 1, 3, "0.336665006730793924968991870984"),
    ):
        reach = float(edge) - 0.01, float(edge) + 0.1
        left, _ = saddle_nodes(sine(strength), reach, q, p, resolution=4, proved=True)
        folds.append((left, EXACT.mpf(edge)))
    for fold, truth in folds:
        assert within(truth, fold.parameter, fold.parameter.error_bound)
        assert fold.parameter.error_bound < 1e-13


def test_a_pair_born_where_another_vanishes_is_no_theorem():
    """sin θ + sin 3θ touches 0 from above at 90 degrees, and from below at 270."""

    def swapping(p):
        return CircleMap(lambda x: x + p + 0.1 * (np.sin(x) + np.sin(3 * x)))

    within_reach = (-0.03, 0.04)
    assert len(saddle_nodes(swapping, within_reach, resolution=2)) == 2
    told = "as many orbits of period 1"
    undecided(saddle_nodes, swapping, within_reach, resolution=2, told=told)


def test_rotation_numbers_lie_within_bounds_that_are_theorems():
    """Möbius maps' in closed form, that of a lock exactly, of folded lifts the whole interval."""
    for circle_map, turns in KNOWN_TURNS:
        found = rotation_number(circle_map, iterates=800, proved=True)
        assert found.lower <= turns <= found.upper < found.lower + 1e-5
        assert found.locked is None
    for circle_map, ratio in (
        (SINE, (0, 1)),
        (HALF, (1, 2)),
        (CircleMap.arnold(2.34, 0.9), (7, 3)),
    ):
        found = rotation_number(circle_map, proved=True)
        assert found.locked == Fraction(*ratio)
        assert found.lower <= found.locked <= found.upper <= found.lower + 1e-15
    for circle_map, low, high in ((STEEP, 0, 1 / 2), (CircleMap.arnold(0.5, 3.0), 1 / 6, 5 / 6)):
        found = rotation_number(circle_map, iterates=200, proved=True)
        assert found.lower <= low < high <= found.upper and found.locked is None
        assert found.upper - found.lower < high - low + 2 / 5
    # 1/4 of a turn is no float: a hair below it, and never a quarter.
    quarter = rotation_number(CircleMap.rigid(0.25), iterates=100, proved=True)
    assert (quarter.locked, quarter.upper) == (None, 0.25)
    undecided(rotation_number, CircleMap(lambda x: x - 1.0 + np.sin(x)), told="as at a tangency")
    told = "a map that is not exact"
    refused(rotation_number, sampled(SINE, 0.0), proved=True, told=told)


def written(x):
    """A lift made of every function that takes intervals."""
    wave = np.tanh(np.sin(x)) + np.log(2 + np.cos(x)) - np.sqrt(1.5 + np.sin(2 * x))
    bent = np.arctan(np.cos(x)) ** 2 + np.arctan2(np.sin(x), 2 + np.cos(x))
    steep = 1 / (2 - np.cos(x)) - np.exp(np.cos(x)) ** 0.5 + np.tan(np.sin(x))
    return x + 0.3 * (wave + bent + steep - np.cosh(np.sin(x)) + np.sinh(np.cos(x)))


@pytest.mark.parametrize(
    ("searched", "period"),
    [
        (STEEP, 4),
        (CircleMap.arnold(0.48, 0.9), 40),
        (CircleMap(written), 2),
        (CircleMap.blaschke([0, 0.4], 0.1), 4),
    ],
)
def test_the_proof_finds_what_the_search_finds(searched, period):
    found = periodic_points(searched, period)
    proved = periodic_points(searched, period, proved=True)
    assert found.count == proved.count > 0
    for name in ("winding", "prime_period", "image", "kind"):
        assert np.array_equal(getattr(found, name), getattr(proved, name)), name
    assert np.all(np.abs(found.theta - proved.theta) <= found.error_bound + proved.error_bound)
    off = np.abs(found.multiplier - proved.multiplier)
    assert np.all(off <= found.multiplier_error + proved.multiplier_error)
    alone = periodic_points(searched, period, 1, proved=True)
    assert alone.count == np.count_nonzero(found.winding == 1)


def test_maps_of_maps_and_slopes_that_are_not_the_makers():
    """Points move along with a rotation; F² has the points of period 2; a wrong derivative does not
    matter.
    """
    turned, plain = (fixed_points(f, proved=True) for f in (conjugate(SINE, 1.0), SINE))
    agree([o.points[0] - 1.0 for o in turned], [o.points[0] for o in plain], 4e-15)
    agree([o.multiplier for o in turned], [o.multiplier for o in plain], 4e-15)
    squared = nth_iterate(HALF, 2)
    twice = fixed_points(squared, proved=True)
    assert [len(orbit.points) for orbit in periodic_orbits(HALF, 2, proved=True)] == [2, 2]
    assert np.array_equal([o.points[0] for o in twice], periodic_points(HALF, 2, proved=True).theta)
    lying = CircleMap(lambda x: x + 0.2 - 0.5 * np.sin(x), lambda x: 1.05 - 0.5 * np.cos(x))
    half_width = 0.5 * np.sqrt(1.0 - 0.4**2)
    slopes = [o.multiplier for o in fixed_points(lying, proved=True)]
    agree(slopes, [1.0 - half_width, 1.0 + half_width], 4e-15)
    refused(fixed_points, squared, proved=True, slope_error=0.1, told="maps made of maps")
    both = compose(CircleMap.blaschke([0, 0]), SINE)
    assert periodic_points(both, 3, proved=True).count == 7


def test_samples_are_proved_of_every_map_within_their_errors():
    """The points of smooth maps within both bounds lie within the bounds that were proved of the
    samples.
    """
    near = sampled(SINE, 0.011)
    proved = fixed_points(near, proved=True, slope_error=0.055)
    assert len(proved) == 2
    folded = periodic_points(sampled(STEEP, 1e-3), 3, proved=True, slope_error=0.02)
    assert folded.count == periodic_points(STEEP, 3).count
    random = np.random.default_rng(2)
    for harmonic in (1.0, 2.0, 3.0, 4.0, 5.0, 5.0):
        phase = random.uniform(0.0, TWO_PI)
        truth = CircleMap(
            lambda x, k=harmonic, p=phase: (
                x + TWO_PI * 0.1 - 0.9 * np.sin(x) + 0.01 * np.sin(k * x + p)
            )
        )
        for there, enclosure in zip(fixed_points(truth, proved=True), proved, strict=True):
            reach = enclosure.error_bound + there.error_bound
            assert abs(there.points[0] - enclosure.points[0]) <= reach
            slope, known = there.multiplier, enclosure.multiplier
            assert abs(slope - known) <= known.error_bound + slope.error_bound
    undecided(fixed_points, sampled(SINE, 0.5), slope_error=0.1, told="no proof")
    refused(fixed_points, near, proved=True, told=r"slope_error 0; .* needs bounds")
    refused(fixed_points, near, slope_error=0.1, told="give proved=True")


def test_work_without_an_end_in_sight_is_refused_before_it_begins():
    """2ⁿ - 1 points of the doubling map, and periods of which no cell is cheap."""
    doubling = CircleMap(lambda x: 2 * x, degree=2)
    undecided(periodic_points, doubling, 16, told=r"F\^16 has 65,535 points, above 9,375")
    undecided(periodic_points, SINE, 90_000, told=r"F\^90000 takes 32 cells at least")


@pytest.mark.parametrize(
    ("lift", "told"),
    [
        (lambda x: x + 0.1 * np.abs(np.sin(x)), r"does not take intervals .*numpy's sin"),
        (lambda x: x + np.where(np.sin(x) == 2.0, 1.0, 0.2), "cannot be compared"),
        (lambda x: x + 0.1 * np.sin(x.astype(float)), "does not take intervals"),
        (
            lambda x: x + 0.3 * np.sin(6.2831853 * x / TWO_PI),
            r"0\.99999999965.* turns at θ = 0\.0131, not 1",
        ),
    ],
)
def test_what_takes_no_intervals_is_refused(lift, told):
    refused(fixed_points, CircleMap(lift), proved=True, told=told)


def test_breaks_and_whole_arcs_are_refused_and_a_missing_library_is_named(monkeypatch):
    kinked = CircleMap(lambda x: x + 0.1, breaks=[1.0])
    refused(fixed_points, kinked, proved=True, told="1 breaks")
    undecided(fixed_points, CircleMap.rigid(0.0), told="a whole arc may be fixed")
    monkeypatch.setitem(sys.modules, "flint", None)
    told = r"needs python-flint: .*\[proofs\]"
    refused(fixed_points, CircleMap.rigid(0.2), proved=True, told=told)
