"""Lyapunov exponents: exact cases and known numbers."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import (
    CircleMap,
    WrappedCauchy,
    WrappedNormal,
    fixed_points,
    lyapunov_exponent,
    sample_staircase,
)

TWO_PI = 2 * np.pi


def test_known_exponents_under_noise():
    sticky = lyapunov_exponent(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.05 * TWO_PI))
    assert abs(sticky + 0.97812914157904) < 1e-13
    solvable = lyapunov_exponent(CircleMap.moebius(0.5, 0.3), WrappedCauchy(0.9))
    assert abs(solvable + 0.0285247244779752248) < 1e-14


def test_without_noise_a_stable_point_gives_its_multiplier_and_a_rotation_zero():
    sine = CircleMap.arnold(0.1, 0.9)
    assert abs(lyapunov_exponent(sine) - np.log(fixed_points(sine)[0].multiplier)) < 1e-13
    assert lyapunov_exponent(CircleMap.rigid(0.1)) == 0.0
    assert abs(lyapunov_exponent(CircleMap.arnold(0.6, 0.5))) < 1e-12
    doubling = CircleMap(lambda x: 2 * x, lambda x: np.full_like(x, 2.0), degree=2)
    assert abs(lyapunov_exponent(doubling) - np.log(2)) < 1e-14


def test_a_folded_map_agrees_with_monte_carlo_despite_the_singular_logarithm():
    folded, noise = CircleMap.arnold(0.3, 3.0), WrappedNormal(0.1 * TWO_PI)
    path = sample_staircase(folded, noise, 400_000, seed=1)
    blocks = np.log(np.abs(folded.derivative(path.theta[:-1]))).reshape(100, -1).mean(axis=1)
    assert abs(lyapunov_exponent(folded, noise) - blocks.mean()) < 5 * blocks.std() / 10


def test_a_folded_map_under_wide_noise_has_the_uniform_average():
    """With nearly uniform noise E ln|1 - K cos θ| = ln(K/2) for K > 1 (Jensen's formula)."""
    found = lyapunov_exponent(CircleMap.arnold(0.3, 3.0), WrappedNormal(8.0))
    assert abs(found - np.log(1.5)) < 1e-12


def test_a_flat_piece_gives_minus_infinity():
    flat = CircleMap.from_samples([0, 1, 2, 6], [1, 1, 1, 7.2], [0, 0, 0, 0.3])
    assert lyapunov_exponent(flat, WrappedNormal(0.3)) == float("-inf")


def test_what_is_no_map_is_refused():
    with pytest.raises(InvalidInput):
        lyapunov_exponent(np.sin)
