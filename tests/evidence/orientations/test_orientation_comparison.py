"""Measured orientations against a predicted map: modes, effective size, and the plywood staircase."""

from pathlib import Path

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.evidence import harmonic_map, read_theta0_pairs
from cyclemap.evidence.orientations.orientation_comparison import (
    compare_orientations,
    effective_count,
    kernel_modes,
    nearest_modes,
)
from cyclemap.maps import (
    CircleMap,
    UniformNoise,
    VonMises,
    WrappedCauchy,
    WrappedNormal,
    sample_staircase,
    sample_staircases,
    transfer_operator,
)

TURN = 2 * np.pi


def test_modes_are_those_of_the_kernel_sum() -> None:
    """The Fourier series against the sum of wrapped normal kernels, maximised on a fine grid."""
    random = np.random.default_rng(1)
    sample = np.concatenate([random.normal(1.0, 0.2, 60), random.normal(3.5, 0.3, 40)])
    grid = np.linspace(0.0, TURN, 20_001)
    kernels = sum(np.exp(-0.5 * ((grid[:, None] - sample + turn) / 0.25) ** 2) for turn in (-TURN, 0.0, TURN))
    values = np.sum(kernels, axis=1)
    tops = grid[1:-1][(values[1:-1] > values[:-2]) & (values[1:-1] > values[2:])]
    assert kernel_modes(sample, 0.25) == pytest.approx(tops, abs=TURN / 20_000)
    assert tops.size == 2


def test_modes_turn_with_the_sample_and_a_uniform_one_has_none() -> None:
    sample = np.random.default_rng(2).normal(6.1, 0.3, 200)
    turned = kernel_modes(sample + 1.0)
    assert np.sort(np.mod(kernel_modes(sample) + 1.0, TURN)) == pytest.approx(turned, abs=1e-9)
    assert kernel_modes(TURN * np.arange(100) / 100).size == 0


def test_the_nearest_mode_is_found_round_the_circle() -> None:
    assert nearest_modes(np.array([0.1, 3.0]), np.array([2.0, 6.2])).tolist() == [6.2, 2.0]
    assert np.isnan(nearest_modes(np.array([0.1]), np.array([]))).all()


@pytest.mark.slow
@pytest.mark.parametrize("turns", [0.0, 0.02, 0.05])
def test_the_effective_count_is_what_the_mean_of_the_least_known_mode_scatters_by(turns) -> None:
    """A random walk on the circle that turns: its modes are e^(imθ), of mean square 1."""
    walk, noise, cycles = CircleMap.rigid(turns), WrappedNormal(0.6), 400
    starts = np.random.default_rng(3).uniform(0.0, TURN, 4000)
    paths = sample_staircases(walk, noise, cycles - 1, starts, seed=4)
    scatter = [np.mean(np.abs(np.exp(1j * m * paths).mean(axis=1)) ** 2) for m in (1, 2, 3, 4)]
    claimed = effective_count(cycles, transfer_operator(walk, noise))
    # The relative standard error of each is √(1/4000) = 1.6 %; the path's ends add 1/(400 gap) = 1.5 %.
    assert claimed == pytest.approx(1.0 / max(scatter), rel=0.08)
    assert claimed < 0.6 * cycles


def test_the_effective_count_is_never_above_the_count() -> None:
    assert effective_count(400, transfer_operator(CircleMap.rigid(0.45), WrappedNormal(0.3))) <= 400.0
    forgetful = transfer_operator(CircleMap.rigid(0.3), WrappedNormal(10.0))
    assert effective_count(400, forgetful) == pytest.approx(400.0, abs=1e-9)


def test_a_path_of_the_model_itself_agrees_in_everything() -> None:
    model = CircleMap.arnold(0.05, 0.5), WrappedNormal(0.2)
    found = compare_orientations(sample_staircase(*model, 3000, seed=5).theta, *model, runs=99)
    assert found.count == 3001
    assert min(p.value for p in (found.wasserstein, found.total_variation, found.kuiper, found.watson)) > 0.02
    assert found.predicted_peaks.size == found.nearest_modes.size == 1
    assert abs(found.peak_offsets[0]) < 0.12  # the scatter of a mode of about a thousand independent angles
    assert not found.refitted


@pytest.mark.slow
@pytest.mark.parametrize("noise", [UniformNoise(0.5), VonMises(20.0), WrappedCauchy(0.9)])
def test_every_noise_will_do(noise) -> None:
    model = CircleMap.arnold(0.05, 0.5), noise
    found = compare_orientations(sample_staircase(*model, 500, seed=6).theta, *model, runs=49)
    assert min(p.value for p in (found.wasserstein, found.total_variation, found.kuiper, found.watson)) > 0.02
    assert 50.0 < found.effective_count < 250.0  # the slope at the stable point, 0.61, alone would make it 121


def test_a_path_of_another_map_disagrees_by_its_rotation() -> None:
    truth, noise = CircleMap.arnold(0.05, 0.5), WrappedNormal(0.2)
    turned = CircleMap(lambda theta: truth(theta - 0.5) + 0.5)
    found = compare_orientations(sample_staircase(truth, noise, 3000, seed=5).theta, turned, noise, runs=99)
    assert {p.value for p in (found.wasserstein, found.total_variation, found.kuiper, found.watson)} == {0.01}
    assert found.wasserstein.statistic == pytest.approx(0.5, abs=0.06)
    assert found.peak_offsets[0] == pytest.approx(-0.5, abs=0.12)


def test_bad_input_is_refused() -> None:
    model = CircleMap.arnold(0.05, 0.5), WrappedNormal(0.2)
    with pytest.raises(InvalidInput, match=r"bandwidth is 0\.001"):
        compare_orientations([0.0, 1.0], *model, bandwidth=0.001)
    with pytest.raises(InvalidInput, match="bins must be at least 1"):
        compare_orientations([0.0, 1.0], *model, bins=0)
    with pytest.raises(InvalidInput, match="at least two"):
        compare_orientations([0.0], *model)


@pytest.mark.slow
def test_the_measured_plywood_is_not_one_stationary_chain(measured_data: Path) -> None:
    """The map fitted to all 2000 pushes as if nothing wore: its peak lies 4° below the measured one, and Kuiper's and
    Watson's statistics are far beyond the chain's; the predicted little peak at 21° was not measured."""
    pairs = read_theta0_pairs(measured_data / "plywood_rect1_theta0_2000.csv")
    fitted = harmonic_map(pairs)
    found = compare_orientations(pairs.path, fitted.map, WrappedNormal(fitted.sigma), runs=99)
    assert found.count == 2000
    assert found.effective_count == pytest.approx(300.5, abs=1.0)
    assert np.rad2deg(found.predicted_peaks) == pytest.approx([21.4, 93.3, 283.5], abs=0.2)
    assert np.rad2deg(found.measured_modes) == pytest.approx([97.5, 287.6], abs=0.2)
    assert np.rad2deg(found.wasserstein.statistic) == pytest.approx(3.96, abs=0.05)
    assert found.kuiper.value == found.watson.value == 0.01
    assert found.kuiper.statistic > 2.0 * found.kuiper.null_quantiles[-1]
