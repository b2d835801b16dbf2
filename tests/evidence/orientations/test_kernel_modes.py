"""Modes of a kernel estimate of the density of orientations."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.evidence import kernel_modes

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
    assert np.sort(np.mod(kernel_modes(sample) + 1.0, TURN)) == pytest.approx(kernel_modes(sample + 1.0), abs=1e-9)
    assert kernel_modes(TURN * np.arange(100) / 100).size == 0


def test_a_bandwidth_too_narrow_is_refused() -> None:
    with pytest.raises(InvalidInput, match=r"bandwidth is 0\.001"):
        kernel_modes([0.0, 1.0], 0.001)
