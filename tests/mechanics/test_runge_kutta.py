"""The Runge-Kutta method: orders of its solution and of both estimates, and an error that one of them overlooks."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.mechanics.runge_kutta import ERROR, LEAST_SHARE, ROUGH, STAGES, A, B, C, error_rate, step


def stages_of(h: float) -> np.ndarray:
    """Slopes (7, 2) of one step of y' = (cos(2 x + y_2), y_1 y_2) from (0.3, -0.4) at x = y_1 or so."""

    def row(state):
        slope = np.array([math.cos(2.0 * state[0] + state[1]), state[0] * state[1]])
        return np.concatenate([state, slope, np.ones(5), [0.0]])

    return step(row, np.array([0.3, -0.4]), h).stages[:, 2:4]


def test_the_rough_method_has_order_three_and_not_four():
    """Conditions of order on its weights (Hairer, Norsett & Wanner 1993, II.2)."""
    weights, full = B - ROUGH[:STAGES], np.zeros((STAGES, STAGES))
    full[:, : A.shape[1]] = A
    for value, wanted in (
        (weights.sum(), 1.0),
        (weights @ C, 1.0 / 2.0),
        (weights @ C**2, 1.0 / 3.0),
        (weights @ full @ C, 1.0 / 6.0),
    ):
        assert value == pytest.approx(wanted, abs=1e-14)
    assert abs(weights @ C**3 - 1.0 / 4.0) > 1e-3
    assert ROUGH[STAGES] == 0.0


@pytest.mark.parametrize(("weights", "order"), [(ERROR, 5), (ROUGH, 4)], ids=["estimate", "rough"])
def test_the_estimates_fall_with_their_powers_of_the_step(weights, order):
    sizes = [h * np.abs(weights @ stages_of(h)).max() for h in (0.02, 0.01)]
    assert math.log2(sizes[0] / sizes[1]) == pytest.approx(order, abs=0.25)


def test_the_rough_difference_counts_only_where_the_estimate_nearly_vanishes():
    slopes = stages_of(0.1)
    assert error_rate(slopes, 0.1) == np.abs(ERROR @ slopes).max()
    blind = slopes.copy()
    blind[STAGES] -= ERROR @ slopes / ERROR[STAGES]
    assert np.abs(ERROR @ blind).max() < 1e-15
    assert error_rate(blind, 0.1) == pytest.approx(LEAST_SHARE * 0.1 * np.abs(ROUGH @ slopes).max())


def test_a_drag_whose_estimate_vanishes_by_chance_keeps_its_accuracy():
    """The centre of rotation crosses the rim within a long step: by the estimate alone it was 48 accuracies off."""
    slider = replace(CollectionLoop.mit().slider, hitch=(-0.0270707, 0.0044444))
    loop = CollectionLoop.mit(slider=slider, accuracy=1e-6)
    exact = replace(loop, accuracy=1e-10)
    theta = 3.4033945 + np.linspace(-2e-5, 2e-5, 9)
    assert np.abs(loop.next_theta(theta) - exact.next_theta(theta)).max() < 2e-6
