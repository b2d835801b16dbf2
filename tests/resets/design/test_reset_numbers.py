"""The numbers a reset is ranked by, against closed forms, against all scores, and quick against bounded."""

import numpy as np
import pytest
from scipy.linalg import eigh

from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, WrappedNormal
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.resets.design.reset_numbers import ResetKernel
from cyclemap.resets.scores.reset_scores import reset_scores
from cyclemap.resets.scores.simulated_coverage import schedule_sampler

NOISE = WrappedNormal(0.3)
UNEVEN = (CircleMap.arnold(0.1, 0.7), CircleMap.arnold(0.4, 0.3))


def test_a_rotation_leaves_the_even_law_and_forgets_its_start_as_its_noise_alone_does() -> None:
    """After n cycles the law is a normal of variance nσ²: its total variation from uniform, by its own moments."""
    found = ResetKernel([CircleMap.rigid(0.3)], np.ones(1), "independent", NOISE).numbers(within=20, near=0.1)
    left = [
        float(FourierLaw(np.exp(-0.5 * n * NOISE.sigma**2 * np.arange(40) ** 2)).total_variation())
        for n in range(1, 61)
    ]
    assert found.tv == pytest.approx(0.0, abs=1e-12)
    assert found.tv_after == pytest.approx(left[19], abs=2e-4)
    assert found.reach == np.inf and left[19] > 0.1
    long = ResetKernel([CircleMap.rigid(0.3)], np.ones(1), "independent", NOISE).numbers(within=60, near=0.1)
    assert long.reach == 1 + sum(one > 0.1 for one in left)


def test_quick_numbers_are_those_of_the_scores_and_lie_within_the_bounds_of_the_certified_ones() -> None:
    kernel = ResetKernel(UNEVEN, np.array([0.6, 0.4]), "independent", NOISE)
    quick, sure = (kernel.numbers(10, 0.3, bounded) for bounded in (False, True))
    whole = reset_scores(UNEVEN, NOISE, [0.6, 0.4])
    assert quick.tv == pytest.approx(whole.evenness.total_variation, abs=1e-9)
    assert sure.tv.error_bound < 1e-3 and sure.tv_after.error_bound < 0.02
    assert sure.tv.holds(quick.tv) or abs(sure.tv - quick.tv) < 1e-9
    assert abs(sure.tv_after - quick.tv_after) <= sure.tv_after.error_bound
    assert quick.effective_per_100 == pytest.approx(whole.effective_size_per_100, rel=1e-6)
    assert quick.reach == sure.reach == whole.within(0.3).cycles
    assert not quick.bounded and np.isinf(quick.tv_after.error_bound)
    assert kernel.quick_tv() == pytest.approx(quick.tv, abs=1e-9)


def test_maps_in_turn_have_the_law_of_their_schedule_which_is_not_that_of_drawn_ones() -> None:
    turns = ResetKernel(UNEVEN, np.full(2, 0.5), "periodic", NOISE)
    found = turns.numbers(10, 0.3)
    law = turns.schedule().recorded_law()
    assert found.tv == pytest.approx(float(law.total_variation()), abs=1e-12)
    paths = schedule_sampler(turns.schedule(), "uniform")(4000, 140, 1)[:, 40:]
    waves = np.stack([wave(k * paths) for k in (1, 2) for wave in (np.cos, np.sin)], axis=-1)
    once, means = np.cov(waves.reshape(-1, 4).T), np.cov(waves.mean(axis=1).T)
    worth = 1.0 / float(eigh(means, once, eigvals_only=True)[-1])
    assert found.effective_per_100 == pytest.approx(worth, rel=0.1) and worth < 60.0
    drawn = ResetKernel(UNEVEN, np.full(2, 0.5), "independent", NOISE).numbers(10, 0.3)
    assert abs(found.tv - drawn.tv) > 1e-3


def test_one_map_in_turn_with_itself_is_that_map() -> None:
    alone = ResetKernel(UNEVEN[:1], np.ones(1), "periodic", NOISE).numbers(10, 0.3)
    twice = ResetKernel((UNEVEN[0], UNEVEN[0]), np.full(2, 0.5), "periodic", NOISE).numbers(10, 0.3)
    assert twice.tv == pytest.approx(alone.tv, abs=1e-9)
    assert twice.tv_after == pytest.approx(alone.tv_after, abs=1e-9)


def test_a_law_too_sharp_for_few_modes_is_looked_at_with_all() -> None:
    still = ResetKernel([CircleMap.arnold(0.0, 0.95)], np.ones(1), "independent", WrappedNormal(0.03))
    assert still.numbers(3, 0.1).tv == pytest.approx(still.numbers(3, 0.1, bounded=True).tv, abs=2e-3)
    assert still.quick_tv() > 0.9


def test_what_has_no_kernel_is_refused() -> None:
    with pytest.raises(InvalidInput, match="'sequence' have no kernel"):
        ResetKernel(UNEVEN, np.full(2, 0.5), "sequence", NOISE)
