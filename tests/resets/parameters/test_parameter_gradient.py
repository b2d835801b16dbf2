"""Gradients of bias, mixing and cost: finite differences of recomputed maps, and cases with a closed form."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import WrappedNormal
from cyclemap.mechanics import EllipseFriction, Material, SidePush
from cyclemap.resets.parameters import parameter_gradient
from cyclemap.resets.parameters.parameter_families import (
    drawn_push_family,
    fixed_leg_family,
    gripper_family,
    random_leg_family,
    ring_family,
    way_point_family,
)
from cyclemap.resets.parameters.parameter_gradient import SCORES, Resolution, StrategyEvaluator, bias_gradient
from cyclemap.resets.parameters.parameter_space import StrategyFamily
from cyclemap.resets.strategies.drag_strategies import TrailingLeg
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes

SHORT = SidePush(distance=0.06)
PLYWOOD = CollectionLoop.mit("plywood", push=SHORT)
EVEN = CollectionLoop.mit(Material("even", EllipseFriction.isotropic(0.25)), push=SHORT)
NOISE = WrappedNormal(0.2)
COARSE = Resolution(samples=10, modes=16, nodes=3, pushes=5)


@pytest.mark.parametrize(
    ("family", "values"),
    [
        (
            drawn_push_family((SidePush(1), SidePush(2)), ("fraction", "angle", "distance"), weights=True),
            (0.7, 0.1, 0.07, 0.65, -0.1, 0.06, 1.3),
        ),
        (ring_family(), (-0.012, 0.011)),
        (way_point_family(), (0.03, 0.06)),
        (fixed_leg_family(), (0.05, 0.5, 0.03)),
        (random_leg_family(side_steps=(0.01, 0.1)), (0.05, 0.04)),
        (gripper_family(), (0.4,)),
    ],
    ids=lambda part: getattr(part, "title", ""),
)
def test_gradients_are_differences_of_scores_from_recomputed_maps(family, values):
    """Along a direction in which every parameter moves: to 1e-3 of each score's derivative, or to 1e-4."""
    steep = replace(COARSE, samples=20)  # the map of a leg is steep
    evaluator = StrategyEvaluator(PLYWOOD, family, NOISE, steep if family.title.startswith("random leg") else COARSE)
    found = evaluator.at(values)
    assert found.route == "grid" and set(found.by) == {"tangents"} and evaluator.evaluations == 1
    low, high = family.bounds
    toward = (high - low) * np.cos(1.0 + np.arange(low.size))
    step = 3e-4
    ends = [evaluator.value_at(np.array(values) + h * toward) for h in (-step, step)]
    slope, mine = (ends[1] - ends[0]) / (2.0 * step), found.gradient @ toward
    assert np.abs(mine - slope).max() <= 1e-3 * np.abs(slope).max()
    assert np.all(np.abs(mine - slope) <= 1e-3 * np.abs(slope) + 1e-4)


def test_on_an_even_surface_drawn_pushes_are_drawn_rotations():
    """Isotropic friction: each push turns by a_k from anywhere, so that the law is uniform, lambda_m = kappa_m sum of
    w_k exp(i m a_k), and all moves with a fraction as the loop's own sensitivity says."""
    family = drawn_push_family((SidePush(1, distance=0.06), SidePush(2, distance=0.06)), weights=True)
    found = bias_gradient(EVEN, family, (0.8, 0.4, 3.0), NOISE, Resolution(samples=8, modes=12))
    weights = np.array([0.25, 0.75])
    pushes = (SidePush(1, 0.8, distance=0.06), SidePush(2, 0.4, distance=0.06))
    known = [CollectionLoop.mit(EVEN.material, push=push).sensitivity(0.3, ("theta", "fraction")) for push in pushes]
    turns, rates = (np.array(row) for row in zip(*((k.theta_next - 0.3, k.by("fraction")) for k in known), strict=True))
    orders = np.arange(1, 13)
    waves = NOISE.coefficients(orders)[:, None] * np.exp(1j * np.outer(orders, turns))
    best = int(np.argmax(np.abs(waves @ weights)))
    mean = complex((waves @ weights)[best])
    assert found.score("total_variation") < 1e-7 and abs(found.score("second_eigenvalue") - abs(mean)) < 1e-6
    by_fraction = np.real(np.conj(mean) / abs(mean) * 1j * orders[best] * weights * rates * waves[best])
    by_weight = float(np.real(np.conj(mean) / abs(mean) * (waves[best] @ np.array([-1.0, 1.0]) / 16.0)))
    assert np.abs(found.slopes("second_eigenvalue") - (*by_fraction, by_weight)).max() < 1e-5
    drags = weights * [k.by("fraction", "drag_length") for k in known]
    assert np.abs(found.slopes("mean_drag_length")[:2] - drags).max() < 1e-7


def test_a_gripper_on_an_even_surface_mixes_by_its_own_spread():
    """lambda_1 = kappa_1 sin(h)/h, and its derivative; the drag does not know the gripper."""
    h = 1.1
    found = bias_gradient(EVEN, gripper_family(), (h,), NOISE, Resolution(samples=8, modes=12, nodes=64))
    kappa = float(NOISE.coefficients(1))
    assert abs(found.score("second_eigenvalue") - kappa * math.sin(h) / h) < 1e-7
    slope = kappa * (math.cos(h) / h - math.sin(h) / h**2)
    assert abs(found.slopes("second_eigenvalue")[0] - slope) < 1e-6 and found.slopes("mean_drag_length")[0] == 0.0


def test_where_the_strategy_has_a_kink_differences_are_taken_and_told():
    """At a side step of zero a way-point vanishes: its derivative is a difference, the length's is not."""
    family = StrategyFamily(
        "leg", ("length", "side"), (0.03, -0.05), (0.1, 0.05), lambda v: TrailingLeg(v[0], 0.4, side_step=v[1])
    )
    evaluator = StrategyEvaluator(PLYWOOD, family, NOISE, COARSE)
    found = evaluator.at((0.06, 0.0))
    assert found.by == ("tangents", "differences") and evaluator.evaluations == 3
    step = 1e-3 * 0.1
    ends = [evaluator.value_at((0.06, side)) for side in (-step, step)]
    assert np.abs(found.gradient[:, 1] - (ends[1] - ends[0]) / (2.0 * step)).max() < 1e-9


def test_where_even_samples_do_not_carry_a_map_adaptive_ones_do_and_the_result_says_so(monkeypatch):
    """Two routes to one gradient: tangents on even samples, differences of scores from adaptive maps."""
    family = StrategyFamily("push", ("f",), (0.2,), (0.8,), lambda v: DrawnPushes((SidePush(0, v[0], distance=0.06),)))
    loop, size = replace(PLYWOOD, accuracy=1e-6), Resolution(samples=16, modes=16, pushes=5)
    even = bias_gradient(loop, family, (0.7,), NOISE, size)
    monkeypatch.setattr(parameter_gradient, "_UNRESOLVED", 1e-9)
    adaptive = bias_gradient(loop, family, (0.7,), NOISE, size)
    assert (even.route, even.by) == ("grid", ("tangents",))
    assert (adaptive.route, adaptive.by) == ("adaptive", ("differences",))
    assert np.abs(even.value - adaptive.value).max() < 1e-3
    assert np.abs(even.gradient - adaptive.gradient).max() < 0.03 * np.abs(even.gradient).max()


def test_bad_demands_are_refused():
    family = StrategyFamily(
        "turns", ("f",), (0.6,), (0.8,), lambda v: AlternatingPushes((SidePush(0, v[0]), SidePush(2, v[0])))
    )
    with pytest.raises(InvalidInput, match=r"depend on each other \(periodic\)"):
        bias_gradient(PLYWOOD, family, (0.7,), NOISE)
    with pytest.raises(InvalidInput, match=r"the noise is 0\.1"):
        bias_gradient(PLYWOOD, ring_family(), (0.0, 0.0), 0.1)
    with pytest.raises(InvalidInput, match="pushes must be at least 1"):
        Resolution(pushes=0)
    found = bias_gradient(EVEN, gripper_family(), (1.0,), NOISE, Resolution(samples=8, modes=4))
    assert found.value.shape == (len(SCORES),)
    with pytest.raises(InvalidInput, match="'bias'"):
        found.score("bias")
