"""The cycle map fitted to measured pairs, against maps that are known."""

from pathlib import Path

import numpy as np
import pytest

from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import InvalidInput
from cyclemap.evidence import HarmonicMap, Theta0Pairs, harmonic_map, read_theta0_pairs

TURN = 2 * np.pi


def turn(theta: np.ndarray) -> np.ndarray:
    return 0.1 + 0.2 * np.cos(theta - 0.4) - 0.15 * np.sin(2 * theta) + 0.05 * np.cos(6 * theta)


def noisy(sigma: float, count: int = 20_000, seed: int = 7) -> Theta0Pairs:
    random = np.random.default_rng(seed)
    theta = random.uniform(-TURN, 3 * TURN, count)
    return Theta0Pairs(theta, theta + turn(theta) + sigma * random.standard_normal(count))


def worst(fitted: HarmonicMap) -> float:
    theta = np.linspace(0, TURN, 500)
    return float(np.max(np.abs(fitted.map.turn(theta) - turn(theta))))


def test_without_noise_the_map_is_found_exactly_and_the_scatter_is_nothing() -> None:
    fitted = harmonic_map(noisy(0.0, 500))
    assert worst(fitted) < 1e-13
    assert fitted.sigma < 1e-14


def test_the_scatter_is_the_noise() -> None:
    # The relative standard error of a standard deviation is 1/sqrt(2n) = 0.5 %; four of them are allowed.
    assert harmonic_map(noisy(0.02)).sigma == pytest.approx(0.02, rel=0.02)


@pytest.mark.slow
def test_the_error_falls_with_the_root_of_the_number_of_pairs() -> None:
    counts = np.array([500, 2_000, 8_000, 32_000])
    errors = [np.mean([worst(harmonic_map(noisy(0.05, n, seed))) for seed in range(8)]) for n in counts]
    order = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert order == pytest.approx(-0.5, abs=0.12)


def test_its_derivative_is_its_own_slope() -> None:
    fitted = harmonic_map(noisy(0.02, 500)).map
    theta, step = np.linspace(0, TURN, 50), 1e-5
    slope = (fitted(theta + step) - fitted(theta - step)) / (2 * step)
    assert np.allclose(fitted.derivative(theta), slope, atol=1e-9)


def test_pairs_that_do_not_fix_the_coefficients_are_refused() -> None:
    with pytest.raises(InvalidInput, match="13 coefficients"):
        harmonic_map(noisy(0.1, 13))
    crowded = Theta0Pairs(np.full(50, 1.0), np.full(50, 1.1))
    with pytest.raises(InvalidInput, match="fix 1 of 13"):
        harmonic_map(crowded)


def test_default_noise_is_the_scatter_of_measured_plywood(measured_data: Path) -> None:
    pairs = read_theta0_pairs(measured_data / "plywood_rect1_theta0_2000.csv")
    assert harmonic_map(pairs).sigma == pytest.approx(DEFAULT_SIGMA, rel=0.02)
