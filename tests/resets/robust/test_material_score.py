"""The quick score of a strategy on a material: symmetric where the mechanics are, and that of adaptive maps."""

import math
from dataclasses import replace

import numpy as np
import pytest
from robust_cases import EVEN, GRID, LAW, NOISE, ROUGH, SHORT, short_loop

from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, WrappedNormal
from cyclemap.mechanics import Material
from cyclemap.resets.robust.material_score import (
    DEFAULT_NOISE,
    QuickGrid,
    material_score,
    resolved_operator,
    sample_cycles,
    variation_after,
)
from cyclemap.resets.scores.reset_scores import reset_scores
from cyclemap.resets.strategies.combined import combine
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.drag_strategies import GripperTurn, StraightReset, TrailingLeg
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes, side_pushes
from cyclemap.resets.strategies.strategy_maps import strategy_maps

SIDES = DrawnPushes(side_pushes(SHORT, (0, 2)), weights=(1.0, 2.0))


def turned(angle: float) -> Material:
    return Material("turned", LAW.turned(angle))


def test_turning_the_surface_leaves_the_bias_of_drawn_pushes_as_it_is():
    """To 1e-6 in both distances and in the drag: by a grid step, so that both look at the same cycles, turned."""
    step = 2.0 * math.pi * 3 / GRID.samples
    grid = replace(GRID, accuracy=1e-7)
    one, other = (material_score(short_loop(made), SIDES, 10, grid=grid) for made in (ROUGH, turned(step)))
    assert one.total_variation > 0.01
    for name in ("total_variation", "variation_after", "drag_length", "own_drag"):
        rounded = 1e-3 if name == "variation_after" else 1e-6  # the grid of 96 starts is not turned along by all angles
        assert getattr(one, name) == pytest.approx(getattr(other, name), abs=rounded)


def test_the_turned_surfaces_map_is_the_map_turned():
    """f on the surface turned by a is a + f(theta - a), at every sample, to the cycle's accuracy."""
    grid, shift = replace(GRID, accuracy=1e-8), 5
    angle = 2.0 * math.pi * shift / GRID.samples
    plain, other = (sample_cycles(short_loop(made), [CycleAction()], grid) for made in (ROUGH, turned(angle)))
    turn, other_turn = plain.lifted[0] - plain.theta, other.lifted[0] - other.theta
    assert np.abs(np.roll(turn, shift) - other_turn).max() < 1e-6 < np.ptp(turn)
    assert np.abs(np.roll(plain.drag_length, shift, axis=1) - other.drag_length).max() < 1e-7


def test_on_isotropic_friction_drawn_pushes_are_rotations_and_exactly_even():
    score = material_score(short_loop(EVEN), SIDES, grid=GRID)
    assert score.total_variation < 1e-6 and score.error < 1e-6 and not score.adaptive


def test_the_quick_score_is_that_of_adaptive_maps():
    """Within the error that halving the grid shows, in the long run and ten pushes from the worst start."""
    loop = short_loop(ROUGH)
    grid = QuickGrid(samples=48, modes=32, nodes=4)
    score = material_score(loop, SIDES, 10, grid=grid)
    made = strategy_maps(loop, SIDES, tolerance=1e-4)
    truth = reset_scores(made.maps, DEFAULT_NOISE, made.weights, modes=32, bounded=False, starts=96, pushes=10)
    exact = float(truth.evenness.total_variation)
    assert abs(score.total_variation - exact) < min(5e-4, score.error + 1e-4)
    assert score.variation_after == pytest.approx(truth.curve.total_variation[-1], abs=2e-3)
    theta = 2.0 * np.pi * np.arange(72) / 72
    assert score.drag_length == pytest.approx(made.mean_drag_length(theta).mean(), rel=1e-3)


def test_too_coarse_a_grid_is_noticed_and_mended_by_adaptive_maps():
    loop = short_loop(ROUGH)
    rough = QuickGrid(samples=8, modes=16, allowed=1e-5, tolerance=1e-3)
    mended, fine = (material_score(loop, SIDES, 5, grid=grid) for grid in (rough, QuickGrid(samples=48, modes=16)))
    assert mended.adaptive and mended.error > 1e-5
    assert mended.total_variation == pytest.approx(fine.total_variation, abs=5e-4)


def test_the_ratio_of_drags_is_one_for_the_loops_own_reset():
    score = material_score(short_loop(ROUGH), StraightReset(), noise=NOISE, grid=replace(GRID, samples=12))
    assert score.drag_ratio == pytest.approx(1.0, abs=1e-9)


def test_a_gripper_and_legs_are_in_the_score():
    """A gripper's even turn makes any law even; a drawn leg lengthens the drag by more than the leg."""
    loop = short_loop(ROUGH)
    even = material_score(loop, GripperTurn(), grid=replace(GRID, nodes=8))
    legged = material_score(loop, combine(SIDES, TrailingLeg(0.05)), grid=GRID)
    assert even.total_variation < 0.02 and even.drag_ratio == pytest.approx(1.0, abs=1e-2)
    assert legged.drag_length > 0.05


def test_a_peaked_law_takes_the_modes_that_it_needs():
    """Möbius: the law of a locked map has moments near one, which 8 modes cannot hold."""
    locked, noise = CircleMap.moebius(0.8, 0.0), WrappedNormal(0.05)
    operator, found = resolved_operator([locked], np.ones(1), noise, 8)
    assert operator.modes > 100 and found == pytest.approx(float(operator.tv_from_uniform), abs=1e-6)
    assert resolved_operator([CircleMap.rigid(0.3)], np.ones(1), noise, 8)[0].modes == 8


def test_after_n_pushes_a_rotation_has_its_noise_alone():
    """From a point, n rotations with wrapped normal noise: a wrapped normal of n times the variance."""
    operator, _ = resolved_operator([CircleMap.rigid(0.2)], np.ones(1), WrappedNormal(0.5), 40)
    grid, order = np.linspace(0.0, 2.0 * np.pi, 4097)[:-1], np.arange(1, 41)
    for pushes in (1, 5):
        decay = np.exp(-0.5 * pushes * (0.5 * order) ** 2)
        truth = 0.5 * np.abs(2.0 * np.cos(np.outer(grid, order)) @ decay).mean()
        assert variation_after(operator, pushes) == pytest.approx(truth, abs=1e-4)


def test_cycles_that_know_of_each_other_are_refused():
    with pytest.raises(InvalidInput, match="know of each other \\(periodic\\)"):
        material_score(short_loop(ROUGH), AlternatingPushes(side_pushes(SHORT, (0, 2))))
    with pytest.raises(InvalidInput, match="even number"):
        QuickGrid(samples=9)
