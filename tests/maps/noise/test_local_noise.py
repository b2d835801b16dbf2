"""Kicks whose size depends on the angle and that resemble the last ones have the moments that were asked for."""

import math

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, DriftingMap, LocalNoise, WrappedNormal, sample_staircase, sample_staircases

STILL = CircleMap.rigid(0.0)


def test_kicks_have_the_size_of_the_place_they_start_from() -> None:
    """From many starts, the spread after one cycle is σ(θ) there: four standard errors."""
    noise = LocalNoise((math.log(0.01), 0.7, -0.4, 0.2, 0.1), 0.6)
    for theta in (0.3, 2.0, 4.5):
        paths = sample_staircases(STILL, noise, 1, np.full(20000, theta), seed=1)
        expected = 0.01 * math.exp(
            0.7 * math.cos(theta) - 0.4 * math.sin(theta) + 0.2 * math.cos(2 * theta) + 0.1 * math.sin(2 * theta)
        )
        assert paths[:, 1].std() == pytest.approx(expected, rel=4.0 / math.sqrt(2 * 20000))
        assert noise.sigma(theta) == pytest.approx(expected, rel=1e-12)


def test_successive_kicks_are_correlated_over_the_blocks_that_draws_come_in(monkeypatch) -> None:
    """corr(z_n, z_{n+k}) = ρ^k, also where one block of draws ends and the next begins."""
    monkeypatch.setattr("cyclemap.maps.staircases.staircase._DRAWS", 3 * 8000)
    paths = sample_staircases(STILL, LocalNoise((math.log(0.02),), 0.7), 6, np.zeros(8000), seed=2)
    kicks = np.diff(paths, axis=1)
    found = np.corrcoef(kicks.T)
    gap = np.abs(np.subtract.outer(np.arange(6), np.arange(6)))
    assert found == pytest.approx(0.7**gap, abs=0.04)


def test_the_white_noise_that_stands_for_it_carries_as_far_over_many_cycles() -> None:
    noise, count = LocalNoise((math.log(0.01),), 0.69), 400
    far = sample_staircases(STILL, noise, count, np.zeros(4000), seed=3)[:, -1]
    white = sample_staircases(STILL, WrappedNormal(noise.white(0.0)), count, np.zeros(4000), seed=4)[:, -1]
    # Less a constant of ρ/(1 - ρ)² cycles, here 1.8 % of the variance.
    assert far.std() == pytest.approx(white.std(), rel=0.06)


def test_one_path_is_that_of_many_and_follows_wear() -> None:
    drifting = DriftingMap.between([(0, CircleMap.rigid(0.0)), (50, CircleMap.rigid(0.2))])
    noise = LocalNoise((math.log(0.05), 0.3, 0.1), 0.5)
    one = sample_staircase(drifting, noise, 80, start=1.0, seed=5).theta
    assert one == pytest.approx(sample_staircases(drifting, noise, 80, [1.0], seed=5)[0], abs=1e-12)
    still = sample_staircase(drifting, LocalNoise((-40.0,), 0.5), 80, start=1.0, seed=5).theta
    assert still == pytest.approx(sample_staircase(drifting, None, 80, start=1.0).theta, abs=1e-12)


@pytest.mark.parametrize(
    ("given", "told"), [(((0.1, 0.2), 0.0), "pairs"), (((0.1,), 1.0), "in .0, 1"), (((0.1,), -0.1), "0, 1")]
)
def test_what_is_no_noise_is_refused(given, told) -> None:
    with pytest.raises(InvalidInput, match=told):
        LocalNoise(*given)
