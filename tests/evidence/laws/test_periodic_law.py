"""Periodic laws fitted to made values whose law, order and scatter are known."""

import numpy as np
import pytest
from refusals import refused
from scipy.signal import lfilter
from scipy.special import i0

from cyclemap.errors import ConvergenceError
from cyclemap.evidence.laws.linear_fit import (
    cycle_folds,
    fit_linear,
    fourier_columns,
    nested_errors,
    simplest_good,
    student_quantile,
)
from cyclemap.evidence.laws.periodic_law import fit_log_variance, fit_periodic_law

TURN = 2 * np.pi
GRID = np.linspace(0.0, TURN, 72, endpoint=False)


def truth(theta: np.ndarray) -> np.ndarray:
    return 0.5 + 0.2 * np.cos(theta - 0.4) - 0.15 * np.sin(2 * theta) + 0.05 * np.cos(3 * theta)


def made(seed: int, count: int = 400, sigma: float = 0.05) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    theta = rng.uniform(-TURN, TURN, count)
    return theta, truth(theta) + sigma * rng.standard_normal(count)


def test_without_noise_the_law_its_order_and_its_slope_are_found_exactly() -> None:
    theta, value = made(0, sigma=0.0)
    for noise_harmonics in (0, None):
        law = fit_periodic_law(theta, value, noise_harmonics=noise_harmonics)
        assert (law.harmonics, law.lag_correlation) == (3, 0.0) and law.rmse < 1e-13
        assert np.allclose(law(GRID), truth(GRID), atol=1e-13)
    step = 1e-5
    slope = (truth(GRID + step) - truth(GRID - step)) / (2 * step)
    assert np.allclose(law.slope(GRID), slope, atol=1e-9)


@pytest.mark.slow
def test_the_chosen_order_is_the_true_one_in_nine_of_ten_runs() -> None:
    chosen = np.array([fit_periodic_law(*made(seed), seed=seed).harmonics for seed in range(20)])
    assert np.sum(chosen == 3) >= 18 and np.min(chosen) >= 3


def test_cross_validation_is_the_error_of_refitting_without_each_fold() -> None:
    """Two routes: one QR a fold for all orders, and a plain least-squares fit for each fold and
    order.
    """
    theta, value = made(1, count=90)
    design, fold = fourier_columns(theta, 4), cycle_folds(theta, seed=5)
    found = nested_errors(design, value, np.array([1, 5, 9]), fold)
    for j, size in enumerate((1, 5, 9)):
        for one in range(10):
            kept = np.linalg.lstsq(design[fold != one, :size], value[fold != one])[0]
            errors = (value - design[:, :size] @ kept)[fold == one] ** 2
            assert np.allclose(found[fold == one, j], errors, rtol=1e-9)


def test_folds_are_equal_shares_made_of_blocks_of_successive_values() -> None:
    theta = np.random.default_rng(0).uniform(0.0, 6.0, 2000)
    fold = cycle_folds(theta, seed=3)
    assert np.bincount(fold).tolist() == [200] * 10
    changes = np.flatnonzero(np.diff(fold)) + 1
    assert changes.size <= 49 and np.all(changes % 40 == 0)
    assert not np.array_equal(fold, cycle_folds(theta, seed=4))


def test_an_angle_that_one_harmonic_cannot_reach_from_the_rest_is_in_no_fold() -> None:
    """Twelve values come to rest from afar; the same values all around are all in folds."""
    rest = 0.05 * np.random.default_rng(1).standard_normal(108)
    fold = cycle_folds(np.append(np.geomspace(2.0, 0.4, 12), rest), seed=0)
    assert np.all(fold[:8] == -1) and np.all(fold[12:] >= 0)
    assert np.all(cycle_folds(40.0 * rest, seed=0) >= 0)


def test_scatter_waves_only_where_half_a_wave_of_it_was_measured_in_every_gap() -> None:
    """Scatter that triples from one end of the angles to the other."""
    rng = np.random.default_rng(4)
    orders = []
    for reach in (0.4, 2.0, np.pi):
        theta = rng.uniform(-reach, reach, 400)
        value = np.exp(0.5 * np.sin(theta * (np.pi / 2) / reach)) * rng.standard_normal(400)
        law = fit_periodic_law(theta, value, harmonics=1, noise_harmonics=None)
        orders.append(law.log_variance.size // 2)
    assert orders[0] == 0 and orders[1] == 1 and orders[2] >= 1


def test_the_one_standard_error_rule_takes_the_simplest_that_is_not_clearly_worse() -> None:
    rng = np.random.default_rng(0)
    common = rng.exponential(size=1000)
    sideways = 0.1 * np.repeat(rng.permutation(np.tile([1.0, -1.0], 50)), 10)
    errors = np.stack([common + 1.0, common + 0.001 + sideways - sideways.mean(), common], axis=1)
    fold = np.repeat(np.arange(10), 100)
    assert simplest_good(errors, np.array([1, 3, 5]), fold)[0] == 1
    errors[:, 1] = common + 0.001
    assert simplest_good(errors, np.array([1, 3, 5]), fold)[0] == 2


def test_bands_cover_the_truth_and_new_values_as_often_as_they_say() -> None:
    """Of 24 values and 7 coefficients: the 95 % band of the mean holds the truth, the prediction
    band a new value.
    """
    inside, ahead = [], []
    for seed in range(100):
        law = fit_periodic_law(*made(seed, count=24), harmonics=3)
        mean, one = law.half_bands(GRID)
        new = truth(GRID) + 0.05 * np.random.default_rng(10_000 + seed).standard_normal(GRID.size)
        inside.append(np.abs(law(GRID) - truth(GRID)) <= mean)
        ahead.append(np.abs(law(GRID) - new) <= one)
    assert np.mean(inside) == pytest.approx(0.95, abs=0.02)
    assert np.mean(ahead) == pytest.approx(0.95, abs=0.015)


@pytest.mark.slow
def test_the_covariance_of_correlated_residuals_is_the_double_sum_over_all_pairs() -> None:
    """X'X^-1 (sum over i, j of w(i - j) r_i r_j x_i x_j') X'X^-1 n/(n - p) with Bartlett's w (Newey
    & West 1987).
    """
    rng, count = np.random.default_rng(8), 70
    design = fourier_columns(rng.uniform(0.0, TURN, count), 2)
    value = np.convolve(rng.standard_normal(count + 4), np.ones(5), "valid")
    fit = fit_linear(design, value, correlated=True)
    lags = int(np.ceil(1.3 * np.sqrt(count)))
    apart = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    weight = np.maximum(1.0 - apart / (lags + 1.0), 0.0)
    moments = design * fit.residuals[:, None]
    inverse = np.linalg.inv(design.T @ design)
    expected = inverse @ moments.T @ weight @ moments @ inverse * (count / (count - 5))
    np.testing.assert_allclose(fit.covariance, expected, rtol=1e-9)


def test_scatter_is_that_of_the_values_not_of_what_many_coefficients_leave_of_it() -> None:
    """Nine coefficients take nine in forty of the variance with them: it is given back."""
    rng, levels = np.random.default_rng(9), []
    for _ in range(60):
        theta = rng.uniform(0.0, TURN, 40)
        law = fit_periodic_law(theta, 0.1 * rng.standard_normal(40), harmonics=4, noise_harmonics=1)
        levels.append(float(np.mean(law.noise(GRID) ** 2)))
    assert np.median(levels) == pytest.approx(0.01, rel=0.12)


def test_with_correlated_residuals_only_the_covariance_made_for_them_covers() -> None:
    """Autoregressive scatter (0.7) over angles that move slowly: plain bands are far too narrow."""
    held = {False: [], True: []}
    theta = 0.05 * np.arange(1000.0)
    design, at = fourier_columns(theta, 3), fourier_columns(1.0, 3)
    for seed in range(100):
        kick = np.random.default_rng(seed).standard_normal(1100)
        scatter = lfilter([1.0], [1.0, -0.7], kick)[100:]
        for correlated, hits in held.items():
            fit = fit_linear(design, truth(theta) + 0.05 * scatter, correlated=correlated)
            off = abs(float(at @ fit.coefficients - truth(np.array(1.0))))
            hits.append(off <= 1.96 * float(np.sqrt(at @ fit.covariance @ at)))
    assert np.mean(held[False]) < 0.75 and 0.88 <= np.mean(held[True]) <= 0.99
    told = fit_periodic_law(theta, truth(theta) + 0.05 * scatter, harmonics=3).lag_correlation
    assert told == pytest.approx(0.7, abs=0.1)


def test_scatter_that_depends_on_the_angle_is_recovered_with_its_order() -> None:
    rng = np.random.default_rng(4)
    theta = rng.uniform(0.0, TURN, 4000)
    sigma = lambda angle: 0.05 * np.exp(0.8 * np.cos(angle - 1.0))  # noqa: E731
    value = truth(theta) + sigma(theta) * rng.standard_normal(4000)
    law = fit_periodic_law(theta, value, noise_harmonics=None)
    assert law.harmonics == 3 and law.log_variance.size == 3
    # Standard errors of two log-standard-deviation coefficients of 1/√n each and one of half: four
    # of them.
    assert np.max(np.abs(np.log(law.noise(GRID) / sigma(GRID)))) < 4 * np.sqrt(1.5 / 4000)
    # The root mean square of it over the angles, in closed form.
    assert law.sigma == pytest.approx(0.05 * np.sqrt(i0(1.6)), rel=0.05)


def predicted_errors(theta: np.ndarray, variance: np.ndarray) -> list[float]:
    """Mean squared errors over the angles of weighted and of plain least squares, three harmonics
    (Aitken 1935).
    """
    design, grid = fourier_columns(theta, 3), fourier_columns(GRID, 3)
    weighted = np.linalg.inv(design.T @ (design / variance[:, np.newaxis]))
    inverse = np.linalg.inv(design.T @ design)
    plain = inverse @ (design.T @ (design * variance[:, np.newaxis])) @ inverse
    return [float(np.mean(np.sum(grid @ one * grid, axis=1))) for one in (weighted, plain)]


@pytest.mark.slow
def test_weighing_by_the_scatter_makes_the_law_as_sure_as_theory_says_and_its_bands_cover() -> None:
    covered, errors, theory = [], [], []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        theta = rng.uniform(0.0, TURN, 500)
        sigma = 0.05 * np.exp(np.cos(theta))
        value = truth(theta) + sigma * rng.standard_normal(500)
        theory.append(predicted_errors(theta, sigma**2))
        weighed = fit_periodic_law(theta, value, harmonics=3, noise_harmonics=1)
        covered.append(np.abs(weighed(GRID) - truth(GRID)) <= weighed.half_bands(GRID)[0])
        plain = fit_periodic_law(theta, value, harmonics=3)
        errors.append([np.mean((law(GRID) - truth(GRID)) ** 2) for law in (weighed, plain)])
    assert np.mean(covered) == pytest.approx(0.95, abs=0.025)
    (weighed_error, plain_error), expected = np.mean(errors, axis=0), np.mean(theory, axis=0)
    assert expected[0] < 0.85 * expected[1]
    # A mean of 60 squared errors of seven coefficients is good to about 7 %.
    assert [weighed_error, plain_error] == pytest.approx(expected, rel=0.2)


@pytest.mark.parametrize("tiny", [1e-12, 1e-40])
def test_scatter_that_all_but_vanishes_on_an_arc_is_fitted_where_newton_first_leaps_too_far(
    tiny,
) -> None:
    rng = np.random.default_rng(1)
    theta = rng.uniform(0.0, 2.0 * np.pi, 2000)
    columns = fourier_columns(theta, 6)
    squares = np.where(np.cos(theta) > 0.5, 1.0, tiny) * rng.chisquare(1, 2000)
    gamma = fit_log_variance(columns, squares)
    assert np.max(np.abs(columns.T @ (1.0 - squares * np.exp(-columns @ gamma)))) < 1e-2
    gone = np.where(np.cos(theta) > 0.5, 1.0, 0.0)
    refused(fit_log_variance, columns, gone, told="vanishes along a", kind=ConvergenceError)


@pytest.mark.parametrize("kind", [{}, {"noise_harmonics": 1}])
def test_turning_the_angles_and_scaling_the_values_turn_and_scale_the_law(kind) -> None:
    theta, value = made(6)
    by = 0.7 + TURN * np.random.default_rng(0).integers(-3, 4, theta.size)
    one = fit_periodic_law(theta, value, **kind)
    other = fit_periodic_law(theta + by, 1000.0 * value, **kind)
    assert other.harmonics == one.harmonics == 3 and one.count == 400
    assert (other.rmse, other.percent) == pytest.approx((1000.0 * one.rmse, one.percent), rel=1e-6)
    assert np.allclose(other(GRID + 0.7), 1000.0 * one(GRID), atol=1e-4)
    for turned, still in ((other.standard_error, one.standard_error), (other.noise, one.noise)):
        assert np.allclose(turned(GRID + 0.7), 1000.0 * still(GRID), rtol=1e-5)
    assert one.percent == pytest.approx(100 * 0.05 / np.mean(value), rel=0.1)


THETA, VALUE = made(10)
NOT_KNOWN = np.where(np.arange(400) == 2, np.nan, VALUE)


@pytest.mark.parametrize(
    ("theta", "value", "options", "match"),
    [
        (THETA, VALUE[:-1], {}, "400 and 399 entries"),
        ([], [], {}, "entries; give equally many"),
        (THETA, NOT_KNOWN, {}, "entry 2 is nan"),
        (THETA[:19], VALUE[:19], {}, "too few to choose"),
        (THETA[:7], VALUE[:7], {"harmonics": 3}, "7 pairs cannot fix 7 coefficients"),
        (np.ones(50), VALUE[:50], {"harmonics": 1}, "fix 1 of 3 coefficients"),
        (THETA, truth(THETA), {"harmonics": 3, "noise_harmonics": 1}, "on a smooth curve"),
        (THETA, VALUE, {"harmonics": -1}, "harmonics must be at least 0"),
        (THETA, VALUE, {"max_harmonics": -1}, "max_harmonics must be at least 0"),
        (THETA, VALUE, {"noise_harmonics": -1}, "noise_harmonics must be at least 0"),
        (THETA, VALUE, {"seed": -1}, "seed must be at least 0"),
    ],
)
def test_bad_input_is_refused_by_name(theta, value, options, match) -> None:
    refused(fit_periodic_law, theta, value, told=match, **options)
    refused(student_quantile, 95, 10.0, told="level is 95")
