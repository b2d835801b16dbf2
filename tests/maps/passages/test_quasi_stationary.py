"""Quasi-stationary distributions: rates and sides of escape."""

import numpy as np
import pytest
from refusals import refused

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps import (
    CircleMap,
    VonMises,
    WrappedCauchy,
    WrappedNormal,
    hitting_probability,
    mean_passage_time,
    quasi_stationary,
    survival_probabilities,
)
from tests.maps.known_maps import DROPPING

STICKY = CircleMap.arnold(0.05, 0.9)
ARC = (-1.0, 2.5)
TWO_WELLS = CircleMap(lambda x: x - 0.45 * np.sin(2 * x))
X, W = np.polynomial.legendre.leggauss(24)
PLACES, WEIGHTS = 0.75 + 1.75 * X, 1.75 * W  # of the arc


@pytest.mark.parametrize("noise", [WrappedNormal(0.5), WrappedCauchy(0.5)])
def test_passages_that_begin_with_it_last_as_long_as_its_rate_says(noise):
    found = quasi_stationary(STICKY, noise, ARC)
    mass = WEIGHTS * found.density(PLACES)
    assert mass.sum() == pytest.approx(1.0, abs=1e-9)
    times = [mean_passage_time(STICKY, noise, start, ARC, lifted=True) for start in PLACES]
    assert mass @ times == pytest.approx(1 / found.escape_rate, rel=1e-9)
    bound = found.below.error_bound + found.above.error_bound
    assert abs(found.below + found.above - 1.0) <= bound


@pytest.mark.parametrize("circle_map", [STICKY, CircleMap.arnold(0.3, 3.0), DROPPING])
def test_after_long_the_chance_of_staying_falls_by_its_rate(circle_map):
    noise = WrappedNormal(0.5)
    found = quasi_stationary(circle_map, noise, ARC)
    chances = survival_probabilities(circle_map, noise, 0.8, ARC, 60, lifted=True)
    rate = found.escape_rate
    assert abs(1 - chances[60] / chances[59] - rate) <= rate.error_bound + 1e-12
    assert found.density(np.array([-1.01, 2.51])).tolist() == [0.0, 0.0]


def test_sides_are_those_of_the_arc_that_is_reached_first():
    noise = WrappedNormal(0.4)
    found = quasi_stationary(STICKY, noise, ARC)
    sides = [
        hitting_probability(STICKY, noise, start, (2.5, 4.0), (-2.2, -1.0)) for start in PLACES
    ]
    above = (WEIGHTS * found.density(PLACES)) @ sides
    assert above == pytest.approx(found.above, abs=1e-6)
    assert 1e-4 < found.above < 0.2


def test_an_odd_map_slips_to_both_sides_alike_however_rarely():
    odd, noise, arc = CircleMap.arnold(0.0, 0.9), WrappedNormal(0.2), (-3.0, 3.0)
    found = quasi_stationary(odd, noise, arc)
    assert found.below.holds(0.5) and found.above.holds(0.5)
    assert found.escape_rate < 1e-25 and found.escape_rate.error_bound < 1e-12 * found.escape_rate
    time = mean_passage_time(odd, noise, 0.0, arc, lifted=True)
    assert abs(time * found.escape_rate - 1) < 1e-11


def test_of_two_wells_each_has_its_share_however_rarely_they_are_left():
    """Once in 1e145 cycles from the one, in 1e146 from the other."""
    noise, ends = WrappedNormal(0.05), (-1.5, 4.7)
    found = quasi_stationary(TWO_WELLS, noise, ends)
    x, w = np.polynomial.legendre.leggauss(300)
    mass = 3.1 * w * found.density(1.6 + 3.1 * x)
    times = [mean_passage_time(TWO_WELLS, noise, at, ends, lifted=True) for at in (0.0, np.pi)]
    mean = np.where(x < 0.0, *times) @ mass
    assert 1e145 < mean < 1e147
    assert mean == pytest.approx(1.0 / found.escape_rate, rel=1e-9)


def test_bounds_hold_for_maps_moved_by_what_they_may_be_off():
    rng, off = np.random.default_rng(3), 1e-5
    for _ in range(10):
        omega, K, sigma = rng.uniform([-0.1, 0.3, 0.2], [0.1, 1.6, 0.6])
        plain = CircleMap.arnold(omega, K)
        claimed = CircleMap(plain, plain.derivative, max_error=off)
        phase, waves = rng.uniform(0.0, 6.0), rng.integers(0, 5)
        moved = CircleMap(
            lambda x, m=plain, w=waves, p=phase: m(x) + off * np.cos(w * x + p), plain.derivative
        )
        ends = (rng.uniform(-2.5, -1.0), rng.uniform(1.0, 2.5))
        noise = WrappedNormal(sigma)
        one, other = (quasi_stationary(sine, noise, ends) for sine in (claimed, moved))
        for name in ("escape_rate", "below", "above"):
            value = getattr(one, name)
            assert abs(value - getattr(other, name)) <= value.error_bound


def test_bounds_hold_where_a_map_is_off_by_as_much_as_the_noise():
    """A small noise feels an error of its own size exponentially: far beyond first order."""
    plain, off = CircleMap.arnold(0.0, 0.9), 0.1
    noise, arc = WrappedNormal(0.3), (-3.0, 3.0)
    rate = quasi_stationary(CircleMap(plain, plain.derivative, max_error=off), noise, arc)
    for way in (lambda x: 1.0, np.sign, np.sin, lambda x: np.tanh(3.0 * x)):
        moved = CircleMap(
            lambda x, w=way: plain(x) + off * w(np.mod(x + np.pi, 2 * np.pi) - np.pi),
            breaks=(0.0, np.pi),
        )
        other = quasi_stationary(moved, noise, arc)
        assert abs(rate.escape_rate - other.escape_rate) <= rate.escape_rate.error_bound
        assert abs(rate.above - other.above) <= rate.above.error_bound


@pytest.mark.parametrize("off", [0.05, 0.1, 0.2])
def test_bounds_hold_where_the_map_turned_as_a_whole_is_the_worst(off):
    """Not the one off by the signs of what the first order tells."""
    plain = lambda x: x + 0.6 - 0.9 * np.sin(x)  # noqa: E731
    noise, ends = WrappedNormal(0.3), (-0.3, 1.8)
    claimed = quasi_stationary(CircleMap(plain, max_error=off), noise, ends).escape_rate
    turned = quasi_stationary(CircleMap(lambda x: plain(x) + off), noise, ends).escape_rate
    assert 0.9 * claimed.error_bound < abs(turned - claimed) <= claimed.error_bound * (1 + 1e-9)


def test_von_mises_noise_never_leaves_further_than_half_a_turn():
    found = quasi_stationary(STICKY, VonMises(10.0), (-0.8, 2.37))
    claimed = CircleMap(STICKY, STICKY.derivative, max_error=1e-6)
    off = quasi_stationary(claimed, VonMises(10.0), (-0.8, 2.37))
    assert found.escape_rate == pytest.approx(off.escape_rate, abs=off.escape_rate.error_bound)
    assert off.escape_rate.error_bound < 1e-3 * off.escape_rate


def test_bad_requests_are_refused():
    uneven = (0.3 - np.pi / 2, 1.5 * np.pi - 0.3)
    for circle_map, noise, arc, told, kind in (
        (STICKY, WrappedNormal(0.3), (1.0,), "arc", InvalidInput),
        (STICKY, None, ARC, "the noise is None", InvalidInput),
        (STICKY, WrappedNormal(0.02), (-3.0, 3.0), "longer than any number", ConvergenceError),
        (TWO_WELLS, WrappedNormal(0.05), uneven, "several parts", ConvergenceError),
    ):
        refused(quasi_stationary, circle_map, noise, arc, told=told, kind=kind)
