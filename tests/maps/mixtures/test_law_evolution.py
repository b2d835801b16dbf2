"""Laws after n cycles, the worst start, and schedules: closed forms, symmetries, sampling."""

import numpy as np
import pytest

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps import (
    CircleMap,
    UniformNoise,
    WrappedCauchy,
    WrappedNormal,
    sample_staircases,
    transfer_operator,
)
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.law_evolution import law_after, stationary_fourier_law
from cyclemap.maps.mixtures.mixture_operator import mixture_operator
from cyclemap.maps.mixtures.periodic_schedule import PeriodicSchedule
from cyclemap.maps.mixtures.start_ensemble import StartEnsemble
from cyclemap.maps.mixtures.start_grid import start_grid

TWO_PI = 2 * np.pi
GRID = np.linspace(0, TWO_PI, 400, endpoint=False)
STICKY = transfer_operator(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.2))
FOLDED = transfer_operator(CircleMap.arnold(0.3, 3.0), WrappedNormal(0.3))


def cauchy(z, modes=400):
    return FourierLaw(z ** np.arange(modes + 1))


def cosine(size, frequency=1):
    """Density (1 + 2·size cos kθ)/2π."""
    moments = np.zeros(frequency + 1)
    moments[0], moments[-1] = 1.0, size
    return FourierLaw(moments)


# -- laws and their distances ----------------------------------------------------------------------------------


@pytest.mark.parametrize("frequency", [1, 2, 7])
def test_distances_of_a_cosine_law_from_uniform_are_known(frequency):
    """½∫|2a cos kθ|/2π = 2a/π; W1 = ∫|2a sin kθ/(2πk)| = 4a/(πk)... for k = 1: 4a/π; each inside its bound."""
    law = cosine(0.3, frequency)
    variation, distance, peak = law.total_variation(), law.wasserstein(), law.peak_to_mean()
    assert abs(variation - 0.6 / np.pi) <= variation.error_bound < 2e-4
    assert abs(distance - 1.2 / (np.pi * frequency)) <= distance.error_bound < 2e-4
    assert abs(peak - 1.6) <= peak.error_bound + 1e-14 < 1e-5


def test_distance_of_cauchy_laws_is_that_of_their_arcs():
    """Total variation of a wrapped Cauchy law (mean r) from uniform: the densities cross where cos θ = r."""
    r = 0.8
    law, noise = cauchy(r), WrappedCauchy(r)
    edge = np.arccos(r)
    exact = float(noise.arc_probability(-edge, edge)) - edge / np.pi
    found = law.total_variation()
    assert abs(found - exact) <= found.error_bound < 1e-4
    assert abs(law.peak_to_mean() - (1 + r) / (1 - r)) <= law.peak_to_mean().error_bound + 1e-12
    np.testing.assert_allclose(law.density(GRID), noise.density(GRID), atol=1e-13)


def test_a_turned_law_is_as_far_as_it_was_turned_and_a_random_turn_brings_laws_together():
    """W1 between a narrow law and itself turned by α is α; an independent random turn contracts both distances."""
    narrow = FourierLaw(WrappedNormal(0.05).coefficients(np.arange(200)))
    turned = FourierLaw(narrow.moments * np.exp(0.7j * np.arange(200)))
    found = narrow.wasserstein(turned)
    assert abs(found - 0.7) <= found.error_bound + 1e-12 < 1e-2
    other = cauchy(0.5j)
    for noise in (UniformNoise(1.0), WrappedNormal(0.5)):
        assert narrow.turned_by(noise).total_variation(other.turned_by(noise)) < narrow.total_variation(other)
        assert narrow.turned_by(noise).wasserstein(other.turned_by(noise)) < narrow.wasserstein(other)
    np.testing.assert_allclose(cauchy(0.5).turned_by(WrappedCauchy(0.6)).density(GRID), cauchy(0.3).density(GRID))


def test_a_density_becomes_the_law_it_is_and_bounds_what_its_modes_miss():
    noise = WrappedCauchy(0.7)
    for modes, most in ((20, 1e-2), (200, 1e-13)):
        law = FourierLaw.from_density(noise.density, modes)
        error = np.max(np.abs(law.density(GRID) - noise.density(GRID)))
        assert error <= 1.05 * law.error_bound + 1e-14 < most + 1e-14
    with pytest.raises(InvalidInput, match="integrates to"):
        FourierLaw.from_density(np.ones_like)


# -- after n cycles --------------------------------------------------------------------------------------------


def test_a_moebius_map_with_cauchy_noise_carries_cauchy_laws_exactly():
    a, omega, r = 0.5, 0.3, 0.6
    operator = transfer_operator(CircleMap.moebius(a, omega), WrappedCauchy(r))
    z = np.exp(1j * 0.4)
    for n in range(1, 8):
        z = r * np.exp(2j * np.pi * omega) * (z - a) / (1 - a * z)
        found = law_after(operator, 0.4, n)
        error = np.max(np.abs(found.density(GRID) - cauchy(z).density(GRID)))
        assert error <= found.error_bound < 1e-10
    settled = stationary_fourier_law(operator)
    assert abs(law_after(operator, 0.4, 60).total_variation(settled)) < 1e-12
    again = law_after(operator, cauchy(0.3j), 1)
    image = r * np.exp(2j * np.pi * omega) * (0.3j - a) / (1 - a * 0.3j)
    np.testing.assert_allclose(again.density(GRID), cauchy(image).density(GRID), atol=1e-12)


@pytest.mark.parametrize("share", [0.4, 0.6])
def test_bounds_of_truncated_laws_hold(share):
    full = mixture_operator([CircleMap.arnold(0.1, 0.9), CircleMap.arnold(0.3, 3.0)], None, WrappedNormal(0.2))
    few = mixture_operator(full.random_map.maps, None, WrappedNormal(0.2), modes=int(share * full.modes))
    for n in (1, 2, 5, 20):
        truth, found = law_after(full, 1.0, n), law_after(few, 1.0, n)
        error = np.max(np.abs(truth.density(GRID) - found.density(GRID)))
        assert error <= found.error_bound
        assert error > 1e-9


def test_sampled_paths_follow_the_law_cycle_by_cycle():
    paths = sample_staircases(STICKY.map, STICKY.noise, 6, np.full(20_000, 2.0), 5)
    for n in (1, 3, 6):
        law = law_after(STICKY, 2.0, n)
        for order in (1, 2, 4):
            values = np.exp(1j * order * paths[:, n])
            assert abs(np.mean(values) - law.moments[order]) < 4 * np.std(values) / np.sqrt(20_000)


# -- the worst start -------------------------------------------------------------------------------------------


def test_every_start_of_a_rotation_is_equally_bad_and_as_bad_as_its_noise():
    """After n cycles the law is the noise's n-fold sum, turned: its distances from uniform are the worst ones."""
    sigma = 0.5
    worst = StartEnsemble(transfer_operator(CircleMap.rigid(0.2), WrappedNormal(sigma)), 64).worst(12)
    for n in range(1, 13):
        law = FourierLaw(WrappedNormal(sigma * np.sqrt(n)).coefficients(np.arange(100)))
        assert abs(worst.total_variation[n - 1] - law.total_variation()) <= worst.total_variation_error[n - 1]
        assert abs(worst.wasserstein[n - 1] - law.wasserstein()) <= worst.wasserstein_error[n - 1]
    assert worst.total_variation_error[3] < 0.01


def test_the_worst_start_is_worse_than_any_other_and_within_its_bounds():
    worst = StartEnsemble(STICKY, 48).worst(30)
    finer = StartEnsemble(STICKY, 480).worst(30)
    law = stationary_fourier_law(STICKY)
    assert np.all(np.abs(finer.total_variation - worst.total_variation) <= worst.total_variation_error)
    assert np.all(np.abs(finer.wasserstein - worst.wasserstein) <= worst.wasserstein_error)
    assert np.all(np.diff(worst.total_variation) < 1e-4), "it never grows with the cycles"
    for start in (0.3, 2.0, 4.0):
        for n in (1, 4, 9):
            apart = law_after(STICKY, start, n).total_variation(law)
            assert apart <= worst.total_variation[n - 1] + worst.total_variation_error[n - 1]
    there = law_after(STICKY, float(worst.start[8]), 9).total_variation(law)
    assert abs(there - worst.total_variation[8]) < 1e-3


def test_bounds_between_starts_hold_where_maps_jump():
    """Enough starts against 1500, for maps that jump and are steep: each break counts as two starts."""

    def lift(x):
        t = np.mod(x, TWO_PI)
        return x + 0.5 + np.where((t >= 2) & (t < 5), 1.0 + 1.5 * np.sin(t), 0.1 * np.sin(t))

    jumping, steep = CircleMap(lift, breaks=[2.0, 5.0]), CircleMap.arnold(0.3, 3.0)
    for maps in ([jumping], [jumping, CircleMap.arnold(0.1, 0.9), steep]):
        operator = mixture_operator(maps, None, WrappedNormal(0.15))
        few, many = (StartEnsemble(operator, starts).worst(8) for starts in (None, 1500))
        assert np.all(np.abs(many.total_variation - few.total_variation) <= few.total_variation_error)
        assert np.all(np.abs(many.wasserstein - few.wasserstein) <= few.wasserstein_error)
        assert few.total_variation_error[-1] < 0.02


def test_starts_stand_for_a_function_that_jumps_to_second_order():
    """sin on one piece and cos on the other: the bends bound what linear interpolation misses, and fall like h²."""
    breaks, worst = np.array([0.7, 3.9]), []
    for count in (32, 64, 128):
        grid = start_grid(count, breaks)
        second = (grid.angles > 0.7) & (grid.angles < 3.9)
        second |= (grid.angles == 0.7) & ~grid.from_left | (grid.angles == 3.9) & grid.from_left
        worst.append(np.max(np.abs(grid.bends(np.where(second, np.sin(grid.angles), np.cos(grid.angles))))))
        assert abs(worst[-1] - (TWO_PI / count) ** 2 / 8) < 0.1 * worst[-1]
    assert grid.angles.size == 128 + 4 and np.sum(grid.from_left) == 2


def test_mixing_cycles_are_those_of_the_curve():
    ensemble = StartEnsemble(STICKY, 256)
    curve = ensemble.worst(70).total_variation
    for tv in (0.5, 0.1):
        found = ensemble.mixing_cycles(tv)
        assert curve[-1] <= tv
        assert found.cycles == 1 + np.argmax(curve <= tv)
        assert found.earliest <= found.cycles <= found.latest < found.earliest + 3
    assert StartEnsemble(transfer_operator(CircleMap.rigid(0.1), WrappedNormal(3.0))).mixing_cycles(0.3).cycles == 1


def test_the_time_to_near_uniform_is_that_of_the_curve_and_infinite_where_the_law_is_further():
    ensemble = StartEnsemble(FOLDED, 256)
    apart = float(FOLDED.tv_from_uniform)
    curve = ensemble.worst(60, FourierLaw.uniform()).total_variation
    reached = ensemble.reach_cycles(apart + 0.05)
    after = int(reached.cycles)
    assert np.all(curve[after - 1 :] <= apart + 0.05) and curve[after - 2] > apart + 0.05
    assert reached.earliest <= after <= reached.latest < reached.earliest + 3
    never = ensemble.reach_cycles(0.5 * apart)
    assert never.cycles == never.earliest == np.inf


def test_truncated_operators_certify_no_worst_start():
    few = transfer_operator(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.2), modes=15)
    assert np.all(StartEnsemble(few, 64).worst(3).total_variation_error == 1.0)
    found = StartEnsemble(few, 64).mixing_cycles(0.05)
    assert (found.earliest, found.latest) == (1, np.inf) and not found.certified


# -- schedules -------------------------------------------------------------------------------------------------


def test_a_schedule_of_one_operator_twice_is_that_operator():
    for shuffled in (False, True):
        schedule = PeriodicSchedule([STICKY, STICKY], shuffled)
        law = schedule.recorded_law()
        assert np.max(np.abs(law.density(GRID) - STICKY.density(GRID))) < 1e-11
        assert abs(schedule.spectral_gap - STICKY.spectral_gap) < 1e-11
        assert law.error_bound < 1e-8


def test_alternating_maps_have_the_law_of_sampled_alternation():
    """Operators of unlike noise, so of unlike numbers of modes; laws before either cycle, and after an odd number."""
    schedule = PeriodicSchedule([STICKY, FOLDED])
    theta = np.linspace(0, TWO_PI, 20_000, endpoint=False)
    rng = np.random.default_rng(2)
    for n in range(40):
        if n in (38, 39):
            for order in (1, 2, 3):
                values = np.exp(1j * order * theta)
                found = schedule.laws()[n - 38].moments[order]
                assert abs(np.mean(values) - found) < 4 * np.std(values) / np.sqrt(theta.size)
        operator = (STICKY, FOLDED)[n % 2]
        theta = operator.map(theta) + operator.noise.sample(rng, theta.size)
    start = cosine(0.4)
    by_hand = law_after(STICKY, law_after(FOLDED, law_after(STICKY, start, 1), 1), 1)
    np.testing.assert_allclose(schedule.law_after(start, 3).density(GRID), by_hand.density(GRID), atol=1e-11)


def test_shuffled_blocks_average_over_all_orders():
    third = transfer_operator(CircleMap.moebius(0.3, 0.2), WrappedNormal(0.3))
    shuffled = PeriodicSchedule([STICKY, FOLDED, third], shuffled=True)
    orders = [(0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)]
    operators = (STICKY, FOLDED, third)
    products = [PeriodicSchedule([operators[i] for i in order]).matrix for order in orders]
    np.testing.assert_allclose(shuffled.matrix, np.mean(products, axis=0), atol=1e-13)
    assert shuffled.recorded_law().error_bound < 1e-8
    law = shuffled.laws()[0]
    np.testing.assert_allclose(shuffled.law_after(law, 3).density(GRID), law.density(GRID), atol=1e-11)


def test_the_worst_start_of_a_schedule_is_that_of_its_paths():
    """One operator twice: the ensemble's curve. Two: the law from the worst start by hand. Shuffled: both orders."""
    uniform = FourierLaw.uniform()
    alone = StartEnsemble(STICKY, 64).worst(7, uniform)
    for shuffled in (False, True):
        twice = PeriodicSchedule([STICKY, STICKY], shuffled).worst(7, starts=64)
        np.testing.assert_allclose(twice.total_variation, alone.total_variation, atol=1e-11)
        np.testing.assert_allclose(twice.wasserstein, alone.wasserstein, atol=1e-11)
        assert np.all(twice.total_variation_error < 2 * alone.total_variation_error + 1e-9)
    for shuffled in (False, True):
        found = PeriodicSchedule([STICKY, FOLDED], shuffled).worst(4, starts=64)
        start, laws = float(found.start[2]), []
        for order in ((STICKY, FOLDED), (FOLDED, STICKY)) if shuffled else ((STICKY, FOLDED),):
            second = law_after(order[1], law_after(order[0], start, 1), 1)
            laws += [law_after(last, second, 1) for last in ((STICKY, FOLDED) if shuffled else (STICKY,))]
        size = max(law.modes for law in laws) + 1
        mean = FourierLaw(np.mean([np.pad(law.moments, (0, size - 1 - law.modes)) for law in laws], axis=0))
        assert abs(mean.total_variation() - found.total_variation[2]) < 1e-4


def test_bad_input_is_refused():
    uniform = transfer_operator(CircleMap.rigid(0.1), UniformNoise(0.5))
    with pytest.raises(InvalidInput, match="narrow smooth noise"):
        law_after(uniform, 0.0, 2)
    with pytest.raises(ConvergenceError, match="keep more modes"):
        stationary_fourier_law(transfer_operator(STICKY.map, STICKY.noise, modes=3))
    with pytest.raises(InvalidInput, match="make it with transfer_operator"):
        StartEnsemble("operator")
    with pytest.raises(InvalidInput, match="two or more"):
        PeriodicSchedule([STICKY])
    with pytest.raises(InvalidInput, match="at most 8"):
        PeriodicSchedule([STICKY] * 9, shuffled=True)
    with pytest.raises(InvalidInput, match="between 0 and 1"):
        StartEnsemble(STICKY).mixing_cycles(0.0)
    with pytest.raises(InvalidInput, match="the first is 1"):
        FourierLaw(np.array([0.5, 0.1]))
    with pytest.raises(InvalidInput, match="give the law of the turn"):
        cosine(0.1).turned_by(0.5)
