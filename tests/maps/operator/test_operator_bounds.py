"""Bounds of the transfer operator: they hold where truncation dominates, and are not much larger than the truth."""

import numpy as np
import pytest

from cyclemap.maps import CircleMap, VonMises, WrappedCauchy, WrappedNormal, transfer_operator

TWO_PI = 2 * np.pi
GRID = np.linspace(0, TWO_PI, 700, endpoint=False)


def kinked(x):
    t = np.mod(x, TWO_PI)
    return x - t + np.where(t < 2.0, 0.4 + 1.6 * t, 3.6 + (TWO_PI - 3.2) / (TWO_PI - 2) * (t - 2))


def kinked_slope(x):
    return np.where(np.mod(x, TWO_PI) < 2.0, 1.6, (TWO_PI - 3.2) / (TWO_PI - 2))


def jumping(x):
    t = np.mod(x, TWO_PI)
    return x + 0.5 + np.where((t >= 2) & (t < 5), 1.0 + 1.5 * np.sin(t), 0.1 * np.sin(t))


def sampled():
    x = np.linspace(0, TWO_PI, 90, endpoint=False)
    return CircleMap.from_samples(x, x + 0.6 - 0.9 * np.sin(x), 1 - 0.9 * np.cos(x))


MAPS = {
    "sine": CircleMap.arnold(0.1, 0.9),
    "folded": CircleMap.arnold(0.3, 3.0),
    "kinked": CircleMap(kinked, kinked_slope, [0.0, 2.0]),
    "jumping": CircleMap(jumping, breaks=[2.0, 5.0]),
    "sampled": sampled(),
}
NOISES = [WrappedNormal(0.3), WrappedNormal(0.12), VonMises(8.0), WrappedCauchy(0.7)]


def assert_tight(found, truth, bound):
    """The bound holds, and where the error is above rounding it is at most a hundred times the error."""
    error = float(np.max(np.abs(np.asarray(found) - truth)))
    assert error <= bound + 1e-14
    if error > 1e-10:
        assert bound <= 100 * error
    return error > 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("noise", NOISES, ids=repr)
@pytest.mark.parametrize("name", MAPS)
def test_bounds_of_truncated_operators_hold_and_are_tight(name, noise):
    """Density, moments, mean winding and gap with a third and with 60 % of the modes, against all of them."""
    full = transfer_operator(MAPS[name], noise)
    decided = 0
    for share in (0.35, 0.6):
        few = transfer_operator(MAPS[name], noise, modes=int(share * full.modes))
        decided += assert_tight(few.density(GRID), full.density(GRID), few.error_bound)
        assert_tight(few.moment(2), full.moment(2), few.moment_error(2))
        assert_tight(few.rotation_number, full.rotation_number, few.rotation_number.error_bound)
        assert abs(few.spectral_gap - full.spectral_gap) <= few.spectral_gap.error_bound + 1e-14
        assert few.tv_from_uniform.holds(full.tv_from_uniform)
        assert few.mixing_cycles.holds(full.mixing_cycles)
    assert decided >= 1


@pytest.mark.parametrize("name", MAPS)
def test_bounds_are_near_rounding_where_everything_is_resolved(name):
    for noise in (WrappedNormal(0.02 * TWO_PI), VonMises(10.0)):
        law = transfer_operator(MAPS[name], noise)
        assert law.error_bound < 1e-12
        assert max(law.moment_error(n) for n in (1, 2, 3)) < 1e-12
        assert law.rotation_number.error_bound < 1e-13
        assert law.is_certain


def test_truncation_error_falls_like_the_noises_coefficients():
    """With M modes the density is off by about κ_M, up to the law's own decay: faster than any power."""
    noise = WrappedNormal(0.3)
    full = transfer_operator(MAPS["folded"], noise)
    orders = np.array([8, 12, 16, 20])
    bounds = [transfer_operator(MAPS["folded"], noise, modes=int(m)).error_bound for m in orders]
    assert np.all(bounds < 3.0 * noise.coefficients(orders))
    assert full.error_bound < bounds[-1] < 1e-6 * bounds[0]


@pytest.mark.parametrize("name", ["sine", "folded"])
def test_the_maps_own_error_is_covered_to_first_order(name):
    """The worst F + δ, |δ| = ε, chosen by the sign of the response itself, moves E cos θ and ρ by just the bound."""
    exact, noise, epsilon = MAPS[name], WrappedNormal(0.25), 1e-6
    claimed = CircleMap(exact, exact.derivative, max_error=epsilon)
    law = transfer_operator(claimed, noise)
    plain = transfer_operator(exact, noise)
    moved = []
    for k in range(1, 5):
        for shape in (np.cos, np.sin):

            def lift(x, k=k, shape=shape):
                return exact(x) + epsilon * shape(k * x)

            moved.append(transfer_operator(CircleMap(lift, exact.derivative), noise))
    cosine = [abs(other.moment(1) - plain.moment(1)) for other in moved]
    winding = [abs(other.rotation_number - plain.rotation_number) for other in moved]
    density = [np.max(np.abs(other.density(GRID) - plain.density(GRID))) for other in moved]
    assert len(moved) == 8
    assert max(cosine) <= law.moment_error(1) <= 30 * max(cosine)
    assert max(winding) <= law.rotation_number.error_bound <= 30 * max(winding)
    assert max(density) <= law.error_bound <= 30 * max(density)
    assert plain.error_bound < 1e-12


def test_a_law_that_noise_cannot_decide_says_so():
    """Two wells that noise of 0.06 rad connects once in 1e30 cycles: any mixture is as stationary as any other."""
    twin = CircleMap(lambda x: x - 0.4 * np.sin(2 * x), lambda x: 1 - 0.8 * np.cos(2 * x))
    law = transfer_operator(twin, WrappedNormal(0.06))
    assert not law.is_certain
    assert law.error_bound > 0.1
    assert transfer_operator(twin, WrappedNormal(0.3)).is_certain
