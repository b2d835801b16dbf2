from itertools import pairwise

import numpy as np
import pytest
from correction_cases import SINE, random_map

from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise_law import UniformNoise, WrappedNormal
from cyclemap.maps.operator.transfer_operator import transfer_operator
from cyclemap.resets.least_noise.fourier_left_over import FourierLeftOver
from cyclemap.resets.least_noise.lazy_turns import LazyTurns
from cyclemap.resets.least_noise.least_correction import least_correction
from cyclemap.resets.least_noise.least_noise import certified_crossing, least_noise
from cyclemap.resets.least_noise.noise_bound import independent_noise_bound, pushed_moments
from cyclemap.resets.least_noise.noise_families import FAMILIES, NoiseFamily, noise_family
from cyclemap.resets.least_noise.turn_costs import turn_cost
from cyclemap.resets.least_noise.turn_law_search import search_turn_law

ALLOWED = 0.05


@pytest.fixture(scope="module")
def plywood(real_loop):
    return real_loop.circle_map(1e-5)


@pytest.mark.parametrize("family", FAMILIES)
def test_a_dense_scan_finds_the_same_least_width(family):
    """Widths on both sides of the answer: TV is above the allowance at all below it and under at all above it."""
    found = least_noise(SINE, ALLOWED, family, scanned=8)
    assert found.is_met and found.is_monotone and not found.is_below_scan
    left_over = noise_family(family).left_over(SINE, None)
    widths = np.linspace(0.9, 1.1, 20) * float(found.width)
    above = [left_over(width) > ALLOWED for width in widths if width <= noise_family(family).most]
    assert len(above) >= 12 and True in above and False in above
    assert above == [bool(width < found.width) for width in widths[: len(above)]]
    assert found.tv == pytest.approx(ALLOWED, abs=1e-5)


def test_plywood_meets_the_allowance_and_a_long_simulation_agrees(plywood):
    """2·10⁵ orientations of 2,000 noisy paths, in 24 bins: TV as promised, within sampling error."""
    found = least_noise(plywood, ALLOWED, scanned=8)
    rng = np.random.default_rng(5)
    theta, seen = rng.uniform(0, 2 * np.pi, 2000), []
    for cycle in range(140):
        theta = np.mod(plywood(theta) + rng.normal(0.0, found.parameter_value, 2000), 2 * np.pi)
        if cycle >= 40:
            seen.append(theta)
    shares = np.histogram(np.concatenate(seen), 24, (0, 2 * np.pi))[0] / 200_000
    assert 0.5 * np.sum(np.abs(shares - 1 / 24)) == pytest.approx(ALLOWED, abs=0.006)


@pytest.mark.parametrize("a", [0.3, 0.6])
def test_lazy_turns_on_the_moebius_map_keep_their_bounds(a):
    """One cycle takes uniform to the Poisson law, (2/π) arcsin a away; (1 - q)/q of that bounds TV, met as q → 1."""
    angles = (np.arange(20_000) + 0.5) * (2 * np.pi / 20_000)
    poisson = (1 - a * a) / (1 + a * a - 2 * a * np.cos(angles))
    pushed = 2 / np.pi * np.arcsin(a)
    assert 0.5 * np.mean(np.abs(poisson - 1.0)) == pytest.approx(pushed, abs=1e-6)
    lazy = LazyTurns(CircleMap.moebius(a, 0.3), None)
    for q in (0.1, 0.3, 0.6, 0.9):
        assert lazy.total_variation(q).lower <= min(1.0, pushed / q) * (1 - q)
    assert float(lazy.total_variation(0.9999)) == pytest.approx(1e-4 * pushed, rel=2e-3)
    assert lazy.total_variation(1.0) == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_lazy_turns_fall_from_one_half_on_and_contract_on_random_maps(seed):
    """Folded maps too, with a little own noise."""
    lazy = LazyTurns(random_map(seed), WrappedNormal(0.15))
    left = [lazy.total_variation(q) for q in (0.5, 0.6, 0.7, 0.8, 0.9, 0.99)]
    assert all(after <= before for before, after in pairwise(left))
    assert all(tv.lower <= 1 - q for tv, q in zip(left, (0.5, 0.6, 0.7, 0.8, 0.9, 0.99), strict=True))
    assert left[0] > 0.0


def test_lazy_turns_without_noise_are_the_limit_of_little_noise():
    """Two routes: inverse images summed, and a linear system in Fourier modes."""
    exact = LazyTurns(SINE, None).total_variation(0.6)
    smooth = [LazyTurns(SINE, WrappedNormal(sigma)).total_variation(0.6) for sigma in (0.08, 0.04)]
    assert abs(smooth[1] - exact) < 0.35 * abs(smooth[0] - exact)
    assert smooth[1] == pytest.approx(float(exact), abs=2e-3)


def test_uniform_turns_in_fourier_modes_agree_with_the_panels_of_their_own_operator():
    modes = FourierLeftOver(SINE).total_variation(UniformNoise(2.7))
    assert modes.holds(transfer_operator(SINE, UniformNoise(2.7)).tv_from_uniform)
    assert modes.error_bound < 1e-6


@pytest.mark.parametrize("circle_map", [SINE, CircleMap.arnold(0.3, 2.5), random_map(1)])
def test_every_family_costs_more_than_both_lower_bounds(circle_map):
    """For independent turns the correction's bound holds too, since it may ignore what it knows."""
    correction = least_correction(circle_map, ALLOWED, cells=128)
    own = independent_noise_bound(circle_map, ALLOWED)
    for family in ("normal", "von-mises", "cauchy"):
        found = least_noise(circle_map, ALLOWED, family, correction=correction, scanned=4)
        assert found.is_met
        assert found.lower_bound == max(own.lower, correction.lower)
        assert found.mean_cost > found.lower_bound > 0.0 and found.factor > 1.0


def test_certificate_of_the_independent_bound_lies_below_the_cost_everywhere():
    bound = independent_noise_bound(SINE, ALLOWED)
    angles = np.random.default_rng(0).uniform(-np.pi, np.pi, 3000)
    waves = np.cos(np.multiply.outer(angles, np.arange(1, bound.limits.size + 1))) @ bound.certificate
    level = bound.by_limits + float(np.abs(bound.certificate) @ bound.limits)
    assert np.all(level + waves <= np.abs(angles))
    assert bound.lower >= bound.by_limits > 0.9


def test_stationary_laws_obey_the_limits_on_the_moments_of_the_noise():
    """Every noise that meets the allowance has |E e^{imξ}| within the limits; the least normal one comes near."""
    bound, found = independent_noise_bound(SINE, ALLOWED), least_noise(SINE, ALLOWED, scanned=6)
    moments = WrappedNormal(found.parameter_value).coefficients(np.arange(1, bound.limits.size + 1))
    assert np.all(moments <= bound.limits + 1e-12)
    assert moments[0] > 0.3 * bound.limits[0]


def test_every_noise_that_meets_the_allowance_departs_from_nothing_by_the_proven_bound(plywood):
    """E|1 - e^{iξ}| of laws found by three searches, one of them asymmetric, on the plywood map and a random one."""
    for circle_map, least in ((plywood, 0.5), (random_map(0), 0.05)):
        bound = independent_noise_bound(circle_map, ALLOWED)
        assert bound.departure > least
        free = search_turn_law(circle_map, ALLOWED, cells=24)
        chords = 2 * np.abs(np.sin(0.5 * np.add.outer(np.arange(24), np.linspace(-0.5, 0.5, 101)) * (2 * np.pi / 24)))
        assert free.is_met and free.masses @ chords.mean(axis=1) >= bound.departure
        assert free.mean_cost >= bound.lower >= bound.departure
        found = least_noise(circle_map, ALLOWED, "normal", scanned=4)
        assert 1 - WrappedNormal(found.width.upper).coefficients(1) >= 0.5 * bound.departure**2
        assert found.mean_cost >= bound.lower


def test_bounds_of_the_other_costs_follow_from_the_departure(plywood):
    one, two, three = (independent_noise_bound(plywood, ALLOWED, cost) for cost in ("absolute", "squared", "cosine"))
    assert one.departure == two.departure == three.departure
    assert two.lower >= one.departure**2 and three.lower >= 0.5 * one.departure**2
    for cost, bound in (("squared", two), ("cosine", three)):
        assert search_turn_law(plywood, ALLOWED, cost, cells=16).mean_cost >= bound.lower


def test_moments_of_the_pushed_uniform_law_are_bessel_functions_on_the_sine_map():
    from scipy.special import jv

    orders = np.arange(1, 97)
    assert np.allclose(pushed_moments(SINE), np.abs(jv(orders, 0.9 * orders)), atol=1e-13)


def test_an_allowance_of_zero_needs_a_turn_by_anything_and_that_is_optimal():
    """All moments of F#u differ from zero, so that g must be uniform: E|ξ| = π/2, which the bound nears."""
    for family in ("uniform", "lazy"):
        found = least_noise(SINE, 0.0, family)
        assert found.is_met and found.tv == 0.0
        assert found.mean_cost == pytest.approx(np.pi / 2, abs=1e-6)
        assert 1.0 <= found.factor < 1.001
    never = least_noise(SINE, 0.0, "normal")
    assert not never.is_met and np.isnan(never.width) and np.isnan(never.mean_cost)


def test_a_map_that_half_a_turn_leaves_alone_is_made_even_by_turns_over_half_the_circle():
    """F(θ + π) = F(θ) + π, as under a centred ellipse: F#u has even moments only."""
    twofold = CircleMap(lambda x: x + 1.0 + 0.3 * np.sin(2 * x), lambda x: 1.0 + 0.6 * np.cos(2 * x))
    found = least_noise(twofold, 0.0, "uniform")
    assert found.is_met and found.width == pytest.approx(np.pi / 2)
    assert found.lower_bound <= found.mean_cost == pytest.approx(np.pi / 4, abs=1e-6)
    assert transfer_operator(twofold, UniformNoise(np.pi / 2)).tv_from_uniform < 1e-9


def test_a_rigid_rotation_needs_no_noise():
    for family in FAMILIES:
        found = least_noise(CircleMap.rigid(0.1), 0.0, family)
        assert found.is_met and found.width == 0.0 and found.mean_cost == 0.0 and found.factor == 1.0


def test_an_allowance_out_of_reach_is_answered_by_the_least_there_is():
    found = least_noise(CircleMap.moebius(0.9, 0.0), 1e-6, "normal", scanned=4)
    assert not found.is_met and np.isnan(found.width)
    assert found.tv == np.min(found.tvs) > 1e-6


def test_a_wide_allowance_is_met_by_the_whole_scan():
    found = least_noise(CircleMap.arnold(0.1, 0.1), 0.5, "normal", scanned=5)
    assert found.is_below_scan and found.is_met and found.width == noise_family("normal").least


def test_the_last_crossing_is_taken_where_the_left_over_is_not_monotone(monkeypatch):
    """A left-over that crosses the allowance at 0.2π, 0.6π and last at π."""

    def waving(width):
        return Estimate(0.05 + 0.04 * np.cos(2.5 * width), 1e-12)

    monkeypatch.setattr(NoiseFamily, "left_over", lambda self, circle_map, own_noise: waving)
    found = least_noise(SINE, 0.05, "normal")
    assert found.width.holds(np.pi) and found.is_met and not found.is_monotone
    assert certified_crossing(waving, 0.05, 0.5, 0.7).holds(0.2 * np.pi)


def test_mean_costs_of_the_families_have_their_closed_forms():
    absolute, squared, cosine = (turn_cost(name) for name in ("absolute", "squared", "cosine"))
    assert noise_family("uniform").mean_cost(2.0, absolute) == pytest.approx(1.0, abs=1e-5)
    assert noise_family("normal").mean_cost(0.3, squared) == pytest.approx(0.09, abs=1e-6)
    assert noise_family("normal").mean_cost(1.5, cosine) == pytest.approx(1 - np.exp(-1.125), abs=1e-6)
    assert noise_family("cauchy").mean_cost(0.5, cosine) == pytest.approx(1 - np.exp(-0.5), abs=1e-6)
    assert noise_family("lazy").mean_cost(0.4, absolute) == pytest.approx(0.2 * np.pi, abs=1e-6)


def test_bad_values_are_named():
    correction = least_correction(SINE, 0.1, cells=32)
    for options, match in (
        ({"allowed_tv": 1.5}, "allowed_tv is 1.5"),
        ({"allowed_tv": 0.1, "family": "gauss"}, "unknown family 'gauss'"),
        ({"allowed_tv": 0.1, "own_noise": "some"}, "own_noise is 'some'"),
        ({"allowed_tv": 0.1, "scanned": 2}, "scanned must be at least 4"),
        ({"allowed_tv": 0.1, "correction": 3.0}, "correction is 3.0"),
        ({"allowed_tv": 0.05, "correction": correction}, "correction is of another"),
    ):
        with pytest.raises(InvalidInput, match=match):
            least_noise(SINE, **options)
    with pytest.raises(InvalidInput, match="the map is 3"):
        least_noise(3, 0.1)
    with pytest.raises(InvalidInput):
        least_noise(CircleMap.arnold(0.1, 2.0), 0.05, "lazy")
