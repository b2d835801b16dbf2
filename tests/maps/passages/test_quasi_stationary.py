"""Quasi-stationary laws, survival and slips: theorems, exact cases, Monte Carlo, plain linear algebra."""

from itertools import pairwise

import numpy as np
import pytest

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps import (
    CircleMap,
    UniformNoise,
    WrappedCauchy,
    WrappedNormal,
    fixed_points,
    mean_passage_time,
    quasi_stationary_distribution,
    slip_probabilities,
    survival_probabilities,
    transfer_operator,
)

TWO_PI = 2 * np.pi
STICKY = CircleMap.arnold(0.1, 0.9)
STABLE, UNSTABLE = (float(p.points[0]) for p in fixed_points(STICKY))
QUARTER, NOISE = (0.0, np.pi / 2), WrappedNormal(0.1 * np.pi)
WELL = (UNSTABLE - TWO_PI, UNSTABLE)


def rule(arc, count=400):
    x, w = np.polynomial.legendre.leggauss(count)
    half = 0.5 * (arc[1] - arc[0])
    return arc[0] + half * (1 + x), half * w


def test_the_law_is_carried_into_itself_by_the_killed_chain():
    """ν K = λ ν on the line and on the circle, checked with an independent rule of 400 nodes; ∫ ν = 1."""
    for noise, lifted in ((NOISE, False), (WrappedNormal(0.2), True), (WrappedCauchy(0.9), True)):
        law = quasi_stationary_distribution(STICKY, noise, QUARTER, lifted=lifted)
        theta, weight = rule(QUARTER)
        mass, at = law.density(theta) * weight, np.linspace(0.01, 1.5, 7)
        step = noise.line_density if lifted else noise.density
        carried = mass @ step(at - STICKY(theta)[:, None])
        np.testing.assert_allclose(carried, law.survival * law.density(at), rtol=1e-10)
        assert abs(mass.sum() - 1) < 1e-12
        assert law.density_error < 1e-11


def test_escape_is_one_over_the_mean_time_from_the_law():
    """∫ ν T = 1/(1 - λ): the residence is geometric from the quasi-stationary start."""
    law = quasi_stationary_distribution(STICKY, NOISE, QUARTER)
    theta, weight = rule(QUARTER, 24)
    times = np.array([mean_passage_time(STICKY, NOISE, x, QUARTER) for x in theta])
    assert law.residence_cycles.holds(float((law.density(theta) * weight) @ times))
    assert law.residence_cycles.error_bound < 1e-11
    np.testing.assert_allclose(law.residence_probability([0, 1, 50]), float(law.survival) ** np.array([0, 1, 50]))


def test_survival_is_the_largest_eigenvalue_of_the_killed_kernel():
    """Against LAPACK's eigenvalues of a plain Nyström matrix: for long, short and very short residences."""
    for noise, arc in ((NOISE, QUARTER), (WrappedNormal(0.8), QUARTER), (WrappedNormal(2.0), (0.0, 0.1))):
        theta, weight = rule(arc, 80)
        values = np.linalg.eigvals(noise.density(theta - STICKY(theta)[:, None]) * weight)
        law = quasi_stationary_distribution(STICKY, noise, arc)
        largest = np.max(np.abs(values))
        assert abs(law.survival - largest) < law.survival.error_bound + 1e-14
        assert abs(law.survival + law.escape_probability - 1) < 1e-15
        assert law.up is None and law.down is None


def test_tiny_escapes_keep_their_digits():
    """At 1e-98 a cycle: up + down is the whole, and the mean passage from the bottom is 1/(1 - λ) but for 1e-90."""
    law = quasi_stationary_distribution(STICKY, WrappedNormal(0.05), WELL, lifted=True)
    time = mean_passage_time(STICKY, WrappedNormal(0.05), STABLE, WELL, lifted=True)
    assert 1e-99 < law.escape_probability < 1e-97
    assert law.escape_probability.error_bound < 1e-10 * law.escape_probability
    assert law.up + law.down == pytest.approx(law.escape_probability, rel=1e-15)
    assert abs(time * law.escape_probability - 1) < 1e-11


def test_a_reset_leaves_with_its_exceedance_each_cycle():
    """A map that sends the arc to one point has that point's noise as its law: all chances in closed form."""
    x = np.array([-1.5, 1.5, 1.5, TWO_PI - 1.5])
    reset = CircleMap.from_samples(x, [0.1, 0.1, 0.1, TWO_PI], [0, 0, 0, 0.0])
    for sigma in (0.5, 0.1, 0.05):
        noise = WrappedNormal(sigma)
        law = quasi_stationary_distribution(reset, noise, (-1.0, 1.2), lifted=True)
        up, down = float(noise.exceedance(1.1)), float(noise.exceedance(1.1))
        assert abs(law.up - up) <= law.up.error_bound + 1e-14 * up < 1e-10 * up
        assert abs(law.down - down) <= law.down.error_bound + 1e-14 * down < 1e-10 * down
        at = np.array([-0.5, 0.3])
        np.testing.assert_allclose(law.density(at), noise.line_density(at - 0.1) / law.survival, rtol=1e-11)
        assert np.all(law.density([-1.01, 1.21]) == 0)


def test_a_symmetric_well_slips_both_ways_alike():
    law = quasi_stationary_distribution(CircleMap.arnold(0.0, 0.9), WrappedNormal(0.4), (-np.pi, np.pi), lifted=True)
    assert law.up == pytest.approx(law.down, rel=1e-12)
    assert law.density(0.7) == pytest.approx(law.density(-0.7), rel=1e-12)
    turned = quasi_stationary_distribution(CircleMap.arnold(0.0, 0.9), WrappedNormal(0.4), (-1.0, 1.0))
    assert turned.density(0.7 + TWO_PI) == pytest.approx(turned.density(0.7), rel=1e-12)


def test_survival_probabilities_sum_to_the_mean_passage_and_end_geometric():
    chances = survival_probabilities(STICKY, NOISE, STABLE, QUARTER, 2_500)
    assert chances.shape == (2_501,) and chances[0] == 1
    assert np.all(np.diff(chances) < 0)
    time = mean_passage_time(STICKY, NOISE, STABLE, QUARTER)
    assert abs(chances.sum() - time) < 1e-11
    law = quasi_stationary_distribution(STICKY, NOISE, QUARTER)
    assert abs(chances[201] / chances[200] - law.survival) < 1e-13


def test_survival_and_exits_agree_with_monte_carlo():
    noise, rng, paths = WrappedNormal(0.35), np.random.default_rng(3), 100_000
    arc = (STABLE - 0.8, STABLE + 0.8)
    theta, alive = np.full(paths, STABLE), [paths]
    for n in range(40):
        theta = STICKY(theta) + noise.sample(rng, theta.size)
        if n == 39:
            exits = np.array([np.sum(theta > arc[1]), np.sum(theta < arc[0])]) / alive[-1]
        theta = theta[(theta >= arc[0]) & (theta <= arc[1])]
        alive.append(theta.size)
    chances = survival_probabilities(STICKY, noise, STABLE, arc, 40, lifted=True)
    sigma = np.sqrt(chances * (1 - chances) / paths)
    assert np.all(np.abs(np.array(alive) / paths - chances) < 5 * sigma + 1e-12)
    law = quasi_stationary_distribution(STICKY, noise, arc, lifted=True)
    for seen, told in zip(exits, (law.up, law.down), strict=True):
        assert abs(seen - told) < 4 * np.sqrt(told / alive[-2])


def test_slips_make_the_rotation_number_of_deep_wells():
    """up - down tends to the exact mean winding in turns, faster and faster as the noise falls."""
    sigmas = (0.5, 0.4, 0.3, 0.22)
    errors = []
    for sigma in sigmas:
        slip = slip_probabilities(STICKY, WrappedNormal(sigma), STABLE)
        exact = transfer_operator(STICKY, WrappedNormal(sigma)).rotation_number
        errors.append(abs(slip.mean_turn / TWO_PI / exact - 1))
        assert slip.up.error_bound < 1e-10 * slip.up
    assert errors[0] < 0.1 and errors[-1] < 2e-5
    assert all(later < 0.5 * earlier for earlier, later in pairwise(errors))


def test_slips_between_equal_zones_half_a_turn_apart():
    """A centred ellipse's map, f(θ + π) = f(θ) + π: neighbours at ±π, and still the exact mean winding."""
    twice = CircleMap(lambda x: x + 0.15 - 0.4 * np.sin(2 * x), lambda x: 1 - 0.8 * np.cos(2 * x))
    centre = 0.5 * np.arcsin(0.15 / 0.4)
    slip = slip_probabilities(twice, WrappedNormal(0.25), centre, centre - np.pi, centre + np.pi)
    exact = transfer_operator(twice, WrappedNormal(0.25)).rotation_number
    assert abs(slip.mean_turn / TWO_PI / exact - 1) < 0.03
    assert slip.down < slip.up < 1
    assert slip.residence_cycles == pytest.approx(1 / (slip.up + slip.down), rel=1e-12)


def test_bad_requests_are_refused():
    with pytest.raises(InvalidInput, match="arc"):
        quasi_stationary_distribution(STICKY, NOISE, (0.0, 7.0))
    with pytest.raises(InvalidInput, match="jumps"):
        quasi_stationary_distribution(STICKY, UniformNoise(0.3), QUARTER)
    with pytest.raises(InvalidInput, match="outside the arc"):
        survival_probabilities(STICKY, NOISE, 3.0, QUARTER, 5)
    with pytest.raises(InvalidInput, match="cycles"):
        survival_probabilities(STICKY, NOISE, STABLE, QUARTER, -1)
    with pytest.raises(InvalidInput, match="degree 2"):
        slip_probabilities(CircleMap(lambda x: 2 * x, degree=2), NOISE, 0.0)
    with pytest.raises(InvalidInput, match="rise by at most a turn"):
        slip_probabilities(STICKY, NOISE, STABLE, STABLE + 1.0)
    with pytest.raises(ConvergenceError, match="1e300"):
        quasi_stationary_distribution(STICKY, WrappedNormal(0.025), WELL, lifted=True)


def test_two_wells_left_equally_slowly_have_no_single_law():
    twice = CircleMap(lambda x: x - 0.4 * np.sin(2 * x), lambda x: 1 - 0.8 * np.cos(2 * x))
    with pytest.raises(ConvergenceError, match="equally slowly"):
        quasi_stationary_distribution(twice, WrappedNormal(0.1), (-0.5, np.pi + 0.5001))
