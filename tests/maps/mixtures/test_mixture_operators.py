"""Transfer operators of random maps: exact cases, one map as a special case, bounds that hold, Monte Carlo."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import (
    CircleMap,
    UniformNoise,
    VonMises,
    WrappedCauchy,
    WrappedNormal,
    conjugate,
    transfer_operator,
)
from cyclemap.maps.mixtures.independent_sum import IndependentSum
from cyclemap.maps.mixtures.mixture_operator import mixture_operator
from cyclemap.maps.mixtures.random_map import RandomMap, sample_random_paths

TWO_PI = 2 * np.pi
GRID = np.linspace(0, TWO_PI, 500, endpoint=False)


def jumping():
    def lift(x):
        t = np.mod(x, TWO_PI)
        return x + 0.5 + np.where((t >= 2) & (t < 5), 1.0 + 1.5 * np.sin(t), 0.1 * np.sin(t))

    return CircleMap(lift, breaks=[2.0, 5.0])


THREE = [CircleMap.arnold(0.1, 0.9), jumping(), CircleMap.arnold(0.3, 3.0)]
SHARES = [0.5, 0.2, 0.3]


def test_drawn_rotations_have_the_mean_phase_times_the_noise_as_spectrum():
    """λ_k = κ_k Σ w e^{ikα}, each with its conjugate; uniform law; mean winding Σ wα/2π."""
    turns, weights, noise = np.array([0.05, 0.21, 0.4]), np.array([0.5, 0.2, 0.3]), WrappedNormal(0.4)
    law = mixture_operator([CircleMap.rigid(t) for t in turns], weights, noise)
    orders = np.arange(1, 30)
    exact = noise.coefficients(orders) * (np.exp(1j * TWO_PI * np.multiply.outer(orders, turns)) @ weights)
    moduli = np.sort(np.repeat(np.abs(exact), 2))[::-1][:10]
    np.testing.assert_allclose(np.abs(law.eigenvalues(11))[1:], moduli, atol=1e-13)
    assert abs(law.spectral_gap - (1 - moduli[0])) < 1e-13
    np.testing.assert_allclose(law.density(GRID), 0.5 / np.pi, rtol=1e-13)
    assert law.tv_from_uniform == 0.0
    assert abs(law.rotation_number - turns @ weights) < 1e-14


def test_a_moebius_map_mixed_with_a_uniform_turn_is_exactly_solvable():
    """Cauchy noise, a Möbius map M, and M with half a turn more, drawn by a coin.

    A wrapped Cauchy law of mean z becomes one of mean ±r·M(z): the law is the mean of those over all sequences of
    coins, and 16 coins tell it to a few 1e-9. Its odd moments vanish.
    """
    a, omega, r = 0.5, 0.3, 0.6
    plain = CircleMap.moebius(a, omega)
    law = mixture_operator([plain, plain], [0.3, 0.7], WrappedCauchy(r))
    alone = transfer_operator(plain, WrappedCauchy(r))
    np.testing.assert_allclose(law.density(GRID), alone.density(GRID), atol=1e-14)
    turned = CircleMap.moebius(a, omega + 0.5)
    law = mixture_operator([plain, turned], [0.5, 0.5], WrappedCauchy(r))
    points, weights = np.array([0.0 + 0.0j]), np.array([1.0])
    for _ in range(16):
        image = r * np.exp(2j * np.pi * omega) * (points - a) / (1 - a * points)
        points, weights = np.concatenate([image, -image]), np.concatenate([weights, weights]) / 2
    assert points.size == 2**16
    for n in range(1, 6):
        assert abs(law.moment(n) - np.sum(weights * points**n)) < 3e-9
    assert abs(law.moment(1)) < 1e-14


def test_one_map_in_several_disguises_is_that_map():
    """Equal maps drawn with any weights, and maps of weight 0 besides, leave nothing but rounding."""
    noise = WrappedNormal(0.12)
    one = transfer_operator(THREE[1], noise)
    for maps, weights in (([THREE[1]], None), ([THREE[1]] * 3, [0.2, 0.5, 0.3]), (THREE, [0.0, 1.0, 0.0])):
        mixed = mixture_operator(maps, weights, noise)
        np.testing.assert_allclose(mixed.density(GRID), one.density(GRID), atol=1e-12)
        np.testing.assert_allclose(np.abs(mixed.eigenvalues(6)), np.abs(one.eigenvalues(6)), atol=1e-12)
        assert abs(mixed.rotation_number - one.rotation_number) < 1e-13
        assert abs(mixed.tv_from_uniform - one.tv_from_uniform) < 1e-12
        assert abs(mixed.moment(3) - one.moment(3)) < 1e-13
        np.testing.assert_allclose(mixed.peaks(), one.peaks(), atol=1e-9)


def test_the_matrix_is_the_weighted_mean_of_the_maps_matrices():
    noise = VonMises(6.0)
    mixed = mixture_operator(THREE, SHARES, noise)
    apart = [transfer_operator(part, noise).discretisation.matrix for part in THREE]
    mean = sum(w * matrix for w, matrix in zip(SHARES, apart, strict=True))
    np.testing.assert_allclose(mixed.discretisation.matrix, mean, atol=1e-14)
    column = np.random.default_rng(1).standard_normal(mixed.discretisation.size)
    np.testing.assert_allclose(mixed.discretisation.cycle(column), mean @ column, atol=1e-12)
    np.testing.assert_allclose(mixed.discretisation.backward(column), mean.T @ column, atol=1e-12)


@pytest.mark.parametrize("noise", [WrappedNormal(0.15), VonMises(8.0), WrappedCauchy(0.7)], ids=repr)
def test_bounds_of_truncated_mixtures_hold_and_are_tight(noise):
    full = mixture_operator(THREE, SHARES, noise)
    decided = 0
    for share in (0.35, 0.6):
        few = mixture_operator(THREE, SHARES, noise, modes=int(share * full.modes))
        error = np.max(np.abs(few.density(GRID) - full.density(GRID)))
        assert error <= few.error_bound + 1e-14
        assert abs(few.moment(2) - full.moment(2)) <= few.moment_error(2) + 1e-14
        winding = few.rotation_number
        assert abs(winding - full.rotation_number) <= winding.error_bound + 1e-14
        gap = few.spectral_gap
        assert abs(gap - full.spectral_gap) <= gap.error_bound + 1e-13
        if error > 1e-10:
            assert few.error_bound <= 100 * error
            decided += 1
    assert decided >= 1


def test_the_stated_error_of_the_maps_covers_what_moving_them_does():
    """Each map off by at most ε, in its own way: the law moves by less than the bound, which is not idle."""
    epsilon, noise = 1e-4, WrappedNormal(0.2)
    claimed = [CircleMap(part, part.derivative, part.breaks, max_error=epsilon) for part in THREE[::2]]
    law = mixture_operator(claimed, None, noise)
    moved = [
        CircleMap(lambda x, part=part, k=k: part(x) + epsilon * np.sin(k * x)) for k, part in enumerate(THREE[::2], 2)
    ]
    other = mixture_operator(moved, None, noise)
    change = np.max(np.abs(law.density(GRID) - other.density(GRID)))
    assert 1e-6 < change < law.error_bound
    assert abs(law.rotation_number - other.rotation_number) < law.rotation_number.error_bound


def test_a_rotated_mixture_has_the_rotated_law():
    noise, angle = WrappedNormal(0.2), 1.1
    law = mixture_operator(THREE, SHARES, noise)
    turned = mixture_operator([conjugate(part, angle) for part in THREE], SHARES, noise)
    np.testing.assert_allclose(turned.density(GRID + angle), law.density(GRID), atol=1e-11)


def test_an_extra_uniform_turn_multiplies_the_moments_and_can_make_the_law_uniform():
    base, extra = WrappedNormal(0.1), UniformNoise(0.8)
    both = IndependentSum((base, extra))
    orders = np.arange(-3, 40)
    np.testing.assert_allclose(both.coefficients(orders), base.coefficients(orders) * extra.coefficients(orders))
    assert both.variance == base.variance + extra.variance
    np.testing.assert_allclose(np.sum(both.density(GRID)) * GRID[1], 1.0, rtol=1e-13)
    step = 1e-4
    slope = (both.density(GRID + step) - both.density(GRID - step)) / (2 * step)
    np.testing.assert_allclose(both.slope(GRID), slope, atol=1e-5)
    shares = both.arc_probability(GRID[:-1], GRID[1:])
    ends, middle = both.density(GRID), both.density(0.5 * (GRID[1:] + GRID[:-1]))
    np.testing.assert_allclose(shares, (ends[:-1] + 4 * middle + ends[1:]) * GRID[1] / 6, atol=1e-9)
    law = mixture_operator(THREE, SHARES, IndependentSum((base, UniformNoise(np.pi))))
    assert law.tv_from_uniform < 1e-13
    assert both.tail(20) >= np.sum(np.abs(both.coefficients(np.arange(21, 300))))


def test_sampled_paths_of_a_random_map_have_its_law_and_winding():
    drawn = RandomMap(tuple(THREE), SHARES, WrappedNormal(0.3))
    law = mixture_operator(THREE, SHARES, WrappedNormal(0.3))
    paths = sample_random_paths(drawn, 60, np.linspace(0, TWO_PI, 4000, endpoint=False), seed=3)
    assert paths.shape == (4000, 61)
    for n in (1, 2, 3):
        last = np.exp(1j * n * paths[:, -1])
        assert abs(np.mean(last) - law.moment(n)) < 4 * np.std(last) / np.sqrt(4000)
    turns = (paths[:, -1] - paths[:, 30]) / (30 * TWO_PI)
    assert abs(np.mean(turns) - law.rotation_number) < 4 * np.std(turns) / np.sqrt(4000)
    again = sample_random_paths(drawn, 60, paths[:, 0], seed=3)
    np.testing.assert_array_equal(paths, again)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([], None, WrappedNormal(0.1)), "one CircleMap or more"),
        (([THREE[0], "map"], None, WrappedNormal(0.1)), "one CircleMap or more"),
        ((THREE, [0.5, 0.5], WrappedNormal(0.1)), "2 entries for 3 maps"),
        ((THREE, [0.5, 0.7, -0.2], WrappedNormal(0.1)), "none below 0"),
        ((THREE, None, 0.1), "a random map needs some"),
        ((THREE, None, UniformNoise(0.1)), "IndependentSum"),
        (([CircleMap.rigid(0.1), CircleMap.blaschke([0, 0])], None, WrappedNormal(0.1)), "one degree"),
    ],
)
def test_bad_mixtures_are_refused_by_name(arguments, message):
    with pytest.raises(InvalidInput, match=message):
        mixture_operator(*arguments)


def test_what_belongs_to_one_map_or_one_noise_is_refused():
    law = mixture_operator([CircleMap.blaschke([0, 0])], None, WrappedNormal(0.3))
    with pytest.raises(InvalidInput, match="mean winding is not defined"):
        _ = law.rotation_number
    with pytest.raises(InvalidInput, match="give each map's"):
        law.discretisation.map_response(np.zeros(3), np.ones_like, np.zeros(0))
    with pytest.raises(InvalidInput, match="2000 Fourier modes"):
        IndependentSum((UniformNoise(1.0), WrappedNormal(1e-4)))
    with pytest.raises(InvalidInput, match="one noise or more"):
        IndependentSum(())
    with pytest.raises(InvalidInput, match="real line"):
        IndependentSum((WrappedNormal(0.1),)).exceedance(0.2)
    with pytest.raises(InvalidInput, match="starts is empty"):
        sample_random_paths(law.random_map, 3, [])
