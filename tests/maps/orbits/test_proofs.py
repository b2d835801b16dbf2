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
from tests.maps.known_maps import KNOWN_TURNS
from tests.refusals import refused

pytest.importorskip(
    "flint", reason="proofs need the extra 'proofs'; install it, or nothing of them is tested"
)
TWO_PI = 2.0 * np.pi
EXACT = mpmath.MPContext()
EXACT.dps = 60


def within(truth, value, bound):
    return abs(truth - EXACT.mpf(float(value))) <= EXACT.mpf(float(bound))


def test_the_tongue_of_the_sine_map_holds_two_points_where_they_are_and_none_outside():
    """sin θ = s/K with s = 2πΩ as a float; multipliers 1 ∓ √(K² - s²), in 60 digits."""
    random, beside = np.random.default_rng(1), 0
    for _ in range(12):
        strength, share = random.uniform(0.2, 2.5), random.uniform(0.05, 0.999999)
        inside = CircleMap.arnold(share * strength / TWO_PI, strength)
        shift = EXACT.mpf(TWO_PI * (share * strength / TWO_PI))
        root = EXACT.asin(shift / EXACT.mpf(strength))
        steepness = EXACT.sqrt(EXACT.mpf(strength) ** 2 - shift**2)
        first, second = fixed_points(inside, proved=True)
        assert within(root, first.points[0], first.error_bound)
        assert within(EXACT.pi - root, second.points[0], second.error_bound)
        assert within(1 - steepness, first.multiplier, first.multiplier.error_bound)
        assert within(1 + steepness, second.multiplier, second.multiplier.error_bound)
        assert max(first.error_bound, second.error_bound) < 1e-14
        outside = strength * (1 + 1e-9) / TWO_PI
        if outside + strength / TWO_PI < 1.0:  # else the next tongue begins
            assert fixed_points(CircleMap.arnold(outside, strength), proved=True) == []
            beside += 1
    assert beside >= 6


def test_multipliers_of_a_moebius_map_follow_from_its_trace():
    """√λ + 1/√λ = 2 cos(s/2)/√(1 - a²): both multipliers, and their product one."""
    for a, omega in [(0.5, 0.1), (0.75, 0.2), (0.25, 0.05)]:
        trace = 2 * EXACT.cos(EXACT.mpf(TWO_PI * omega) / 2) / EXACT.sqrt(1 - EXACT.mpf(a) ** 2)
        root = (trace + EXACT.sqrt(trace**2 - 4)) / 2
        stable, unstable = sorted(
            fixed_points(CircleMap.moebius(a, omega), proved=True), key=lambda o: o.multiplier
        )
        assert within(root**-2, stable.multiplier, stable.multiplier.error_bound)
        assert within(root**2, unstable.multiplier, unstable.multiplier.error_bound)
        assert (stable.kind, unstable.kind) == ("stable", "unstable")
    assert fixed_points(CircleMap.moebius(0.5, 0.3), proved=True) == []


@pytest.mark.parametrize("zeros", [[0, 0.4], [0, -0.3j, 0.5], [0, 0.2 + 0.3j, -0.6, 0.1]])
def test_an_expanding_blaschke_product_has_as_many_points_as_its_degree_tells(zeros):
    """Degree k, all expanding: kⁿ - 1 points of Fⁿ, and of prime period n, a prime, k - 1 fewer."""
    expanding = CircleMap.blaschke(zeros, 0.1)
    degree = len(zeros)
    for period in (1, 2, 3):
        points = periodic_points(expanding, period, proved=True)
        assert points.count == degree**period - 1
        assert np.count_nonzero(points.prime_period == period) == degree**period - 1 - (
            period > 1
        ) * (degree - 1)
        assert np.all(points.multiplier - points.multiplier_error > 1.0)
        assert np.array_equal(np.sort(points.image), np.arange(points.count))


def test_a_hair_beside_a_tangency_is_decided_and_the_tangency_itself_refused():
    def gapped(gap):
        return CircleMap(lambda x: x + (0.5 + gap) - 0.5 * np.sin(x))

    assert fixed_points(gapped(2.0**-53), proved=True) == []
    first, second = fixed_points(gapped(-(2.0**-54)), proved=True)
    half = EXACT.acos(1 - EXACT.mpf(2) ** -53)
    assert within(EXACT.pi / 2 - half, first.points[0], first.error_bound)
    assert within(EXACT.pi / 2 + half, second.points[0], second.error_bound)
    refused(
        fixed_points,
        gapped(0.0),
        proved=True,
        kind=ConvergenceError,
        told=r"θ = 1\.5707963.*a tangency",
    )


def test_saddle_nodes_lie_within_bounds_between_whose_ends_orbits_are_born():
    """Where the shift is the parameter itself, two points meet at K exactly, and at K/2 twice over;
    the edges of the tongue 1/2 at K = 0.9 and of 1/3 at K = 1 are known to 25 digits.
    """
    random = np.random.default_rng(3)
    for strength in random.uniform(0.2, 2.5, 4):
        for waves in (1, 2):
            folds = saddle_nodes(
                lambda w, k=strength, m=waves: CircleMap(lambda x: x + w - k * np.sin(m * x)),
                (0.5 * strength, 1.2 * strength),
                resolution=2,
                proved=True,
            )
            assert len(folds) == waves
            for fold in folds:
                assert within(EXACT.mpf(strength), fold.parameter, fold.parameter.error_bound)
                assert fold.parameter.error_bound < 1e-13
    for strength, ratio, edge in (
        (0.9, (1, 2), "0.46966533712136485155447001"),
        (1.0, (1, 3), "0.336665006730793924968991870984"),
    ):
        left, _ = saddle_nodes(
            lambda omega, k=strength: CircleMap.arnold(omega, k),
            (float(edge) - 0.01, float(edge) + 0.1),
            ratio[1],
            ratio[0],
            resolution=4,
            proved=True,
        )
        assert within(EXACT.mpf(edge), left.parameter, left.parameter.error_bound)
        assert left.parameter.error_bound < 1e-13


def test_a_pair_born_where_another_vanishes_is_no_theorem():
    """sin θ + sin 3θ touches 0 from above at 90 degrees, and from below at 270."""

    def swapping(p):
        return CircleMap(lambda x: x + p + 0.1 * (np.sin(x) + np.sin(3 * x)))

    assert len(saddle_nodes(swapping, (-0.03, 0.04), resolution=2)) == 2
    refused(
        saddle_nodes,
        swapping,
        (-0.03, 0.04),
        resolution=2,
        proved=True,
        kind=ConvergenceError,
        told="as many orbits of period 1",
    )


def test_rotation_numbers_lie_within_bounds_that_are_theorems():
    """Möbius maps' in closed form, that of a lock exactly, of folded lifts the whole interval."""
    for circle_map, turns in KNOWN_TURNS:
        found = rotation_number(circle_map, iterates=1500, proved=True)
        assert found.lower <= turns <= found.upper and found.locked is None
        assert found.upper - found.lower < 4e-6
    for omega, strength, ratio in ((0.1, 0.9, (0, 1)), (0.5, 0.9, (1, 2)), (2.34, 0.9, (7, 3))):
        found = rotation_number(CircleMap.arnold(omega, strength), proved=True)
        assert found.locked == Fraction(*ratio)
        assert found.lower <= found.locked <= found.upper <= found.lower + 1e-15
    for omega, ends in ((0.3, (0, 1 / 2)), (0.5, (1 / 6, 5 / 6))):
        found = rotation_number(CircleMap.arnold(omega, 3.0), iterates=200, proved=True)
        assert found.lower <= ends[0] < ends[1] <= found.upper and found.locked is None
        assert found.upper - found.lower < ends[1] - ends[0] + 2 / 5
    # 1/4 of a turn is no float: a hair below it, and never a quarter.
    quarter = rotation_number(CircleMap.rigid(0.25), iterates=100, proved=True)
    assert (quarter.locked, quarter.upper) == (None, 0.25)
    refused(
        rotation_number,
        CircleMap(lambda x: x - 1.0 + np.sin(x)),
        proved=True,
        kind=ConvergenceError,
        told="as at a tangency",
    )
    angles = np.linspace(0.0, TWO_PI, 80, endpoint=False)
    refused(
        rotation_number,
        CircleMap.from_samples(angles, angles + 0.1),
        proved=True,
        told="a map that is not exact",
    )


def test_the_proof_finds_what_the_search_finds():
    """Two routes to 68 points of a folded map, to those of an expanding one, and of every function
    with intervals.
    """

    def written(x):
        wave = (
            np.tanh(np.sin(x))
            + np.log(2 + np.cos(x))
            - np.sqrt(1.5 + np.sin(2 * x))
            + 1 / (2 - np.cos(x))
        )
        bent = (
            np.arctan(np.cos(x)) ** 2
            + np.arctan2(np.sin(x), 2 + np.cos(x))
            - np.exp(np.cos(x)) ** 0.5
        )
        return x + 0.3 * (wave + bent - np.cosh(np.sin(x)) + np.sinh(np.cos(x)) + np.tan(np.sin(x)))

    expanding = CircleMap.blaschke([0, 0.4], 0.1)
    cases = [
        (CircleMap.arnold(0.3, 3.0), 6),
        (CircleMap(written), 1),
        (CircleMap(written), 2),
        (expanding, 4),
    ]
    for searched, period in cases:
        found, proved = (
            periodic_points(searched, period),
            periodic_points(searched, period, proved=True),
        )
        assert found.count == proved.count > 0
        for name in ("winding", "prime_period", "image", "kind"):
            assert np.array_equal(getattr(found, name), getattr(proved, name)), name
        assert np.all(np.abs(found.theta - proved.theta) <= found.error_bound + proved.error_bound)
        off = np.abs(found.multiplier - proved.multiplier)
        assert np.all(off <= found.multiplier_error + proved.multiplier_error)
    winding = periodic_points(CircleMap.arnold(0.3, 3.0), 6, 2, proved=True)
    assert winding.count == 36


def test_maps_of_maps_and_slopes_that_are_not_the_makers():
    """Points move along with a rotation; F² has the points of period 2; a wrong derivative does not
    matter.
    """
    sine = CircleMap.arnold(0.1, 0.9)
    turned = fixed_points(conjugate(sine, 1.0), proved=True)
    plain = fixed_points(sine, proved=True)
    assert np.allclose(
        [o.points[0] - 1.0 for o in turned], [o.points[0] for o in plain], rtol=0, atol=4e-15
    )
    assert np.allclose(
        [o.multiplier for o in turned], [o.multiplier for o in plain], rtol=0, atol=4e-15
    )
    half = CircleMap.arnold(0.5, 0.9)
    twice = fixed_points(nth_iterate(half, 2), proved=True)
    assert [len(orbit.points) for orbit in periodic_orbits(half, 2, proved=True)] == [2, 2]
    assert np.array_equal([o.points[0] for o in twice], periodic_points(half, 2, proved=True).theta)
    lying = CircleMap(lambda x: x + 0.2 - 0.5 * np.sin(x), lambda x: 1.05 - 0.5 * np.cos(x))
    slopes = [o.multiplier for o in fixed_points(lying, proved=True)]
    half_width = 0.5 * np.sqrt(1.0 - 0.4**2)
    assert np.allclose(slopes, [1.0 - half_width, 1.0 + half_width], rtol=0, atol=4e-15)
    refused(
        fixed_points, nth_iterate(half, 2), proved=True, slope_error=0.1, told="maps made of maps"
    )
    both = compose(CircleMap.blaschke([0, 0]), sine)
    assert periodic_points(both, 3, proved=True).count == 7


def test_samples_are_proved_of_every_map_within_their_errors():
    """The points of 20 smooth maps within both bounds lie within the bounds that were proved of the
    samples.
    """
    angles = np.linspace(0.0, TWO_PI, 80, endpoint=False)
    sine = CircleMap.arnold(0.1, 0.9)
    sampled = CircleMap.from_samples(angles, sine(angles), sine.derivative(angles), max_error=0.011)
    proved = fixed_points(sampled, proved=True, slope_error=0.055)
    assert len(proved) == 2
    steep = CircleMap.arnold(0.3, 3.0)
    folded = CircleMap.from_samples(angles, steep(angles), steep.derivative(angles), max_error=1e-3)
    assert (
        periodic_points(folded, 3, proved=True, slope_error=0.02).count
        == periodic_points(steep, 3).count
    )
    random = np.random.default_rng(2)
    for harmonic, phase in zip(
        random.integers(1, 6, 20), random.uniform(0.0, TWO_PI, 20), strict=True
    ):

        def truth(x, harmonic=float(harmonic), phase=phase):
            return x + TWO_PI * 0.1 - 0.9 * np.sin(x) + 0.01 * np.sin(harmonic * x + phase)

        for there, enclosure in zip(
            fixed_points(CircleMap(truth), proved=True), proved, strict=True
        ):
            assert (
                abs(there.points[0] - enclosure.points[0])
                <= enclosure.error_bound + there.error_bound
            )
            off = abs(there.multiplier - enclosure.multiplier)
            assert off <= enclosure.multiplier.error_bound + there.multiplier.error_bound
    wide = CircleMap.from_samples(angles, sine(angles), sine.derivative(angles), max_error=0.5)
    refused(
        fixed_points, wide, proved=True, slope_error=0.1, kind=ConvergenceError, told="no proof"
    )
    refused(fixed_points, sampled, proved=True, told=r"slope_error 0; .* needs bounds")
    refused(fixed_points, sampled, slope_error=0.1, told="give proved=True")


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
    refused(
        fixed_points,
        CircleMap.rigid(0.0),
        proved=True,
        kind=ConvergenceError,
        told="a whole arc may be fixed",
    )
    monkeypatch.setitem(sys.modules, "flint", None)
    refused(
        fixed_points, CircleMap.rigid(0.2), proved=True, told=r"needs python-flint: .*\[proofs\]"
    )
