"""Diffusion of the lifted path: closed forms, Monte Carlo, hopping between wells."""

import numpy as np
import pytest

from cyclemap.maps import (
    CircleMap,
    WrappedCauchy,
    WrappedNormal,
    sample_staircases,
    transfer_operator,
)
from tests.maps.known_maps import TWIN_WELLS

TWO_PI = 2 * np.pi
JUMPING = CircleMap(
    lambda x: x + np.where(np.mod(x, TWO_PI) < 3.0, 1.0, -0.8), np.ones_like, [0.0, 3.0]
)


def sampled_diffusion(circle_map, noise):
    """D and its standard error: half the growth of the variance over the second half
    of many paths."""
    paths = sample_staircases(circle_map, noise, 280, np.linspace(0, TWO_PI, 20_000), seed=7)
    middle, end = (
        (climb - climb.mean()) ** 2
        for climb in (paths[:, cycle] - paths[:, 40] for cycle in (160, 280))
    )
    growth = (end - middle) / 240
    return growth.mean(), growth.std() / np.sqrt(growth.size)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [WrappedNormal(0.4), WrappedNormal(2.0)], ids=repr)
@pytest.mark.parametrize("turns", [0.0, 0.3])
def test_a_rotation_diffuses_by_its_noise_alone(noise, turns):
    found = transfer_operator(CircleMap.rigid(turns), noise).diffusion
    assert abs(found - 0.5 * noise.variance) <= found.error_bound < 1e-11


@pytest.mark.slow
@pytest.mark.parametrize("noise", [WrappedNormal(0.4), WrappedNormal(0.8)], ids=repr)
@pytest.mark.parametrize(
    "circle_map", [CircleMap.arnold(0.3, 0.9), CircleMap.arnold(0.3, 3.0), JUMPING], ids=repr
)
def test_monte_carlo_spreads_as_fast(noise, circle_map):
    found = transfer_operator(circle_map, noise).diffusion
    mean, error = sampled_diffusion(circle_map, noise)
    assert error < 0.05 * max(mean, 2e-3)  # beside the jumping map a path hardly spreads
    assert abs(mean - found) < 5 * error
    assert found.error_bound < 1e-10


def test_two_equal_wells_make_a_walk_of_half_turns():
    """Hops of ±π at rate Γ give D = π²Γ/2 and an eigenvalue 1 - 2Γ, so D = (π²/4)·gap where hops
    are rare.
    """
    law = transfer_operator(TWIN_WELLS, WrappedNormal(0.3))
    assert law.spectral_gap < 1e-3
    assert law.diffusion == pytest.approx(0.25 * np.pi**2 * law.spectral_gap, rel=1e-2)


def test_bounds_hold_with_few_modes():
    circle_map, noise = CircleMap.arnold(0.3, 3.0), WrappedNormal(0.3)
    truth = transfer_operator(circle_map, noise).diffusion
    for modes in (8, 11, 14):
        few = transfer_operator(circle_map, noise, modes=modes).diffusion
        assert abs(few - truth) <= few.error_bound + truth.error_bound
        assert few.error_bound <= 100 * abs(few - truth)


def test_cauchy_kicks_have_no_variance():
    assert transfer_operator(CircleMap.rigid(0.1), WrappedCauchy(0.5)).diffusion == np.inf
