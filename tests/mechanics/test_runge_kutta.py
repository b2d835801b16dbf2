"""The Runge-Kutta method: orders of its solution and of both estimates, and an error that one of them overlooks."""

import math
from dataclasses import replace
from functools import lru_cache
from itertools import product

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.mechanics.runge_kutta import (
    ERROR,
    LEAST_SHARE,
    MIDDLE_STATE,
    MIDDLE_VALUE,
    ROUGH,
    STAGES,
    A,
    B,
    C,
    error_rate,
    next_length,
    step,
)


def stages_of(h: float) -> np.ndarray:
    """Slopes (11, 2) of one step of y' = (cos(2 x + y_2), y_1 y_2) from (0.3, -0.4) at x = y_1 or so."""

    def row(state):
        slope = np.array([math.cos(2.0 * state[0] + state[1]), state[0] * state[1]])
        return np.concatenate([state, slope, np.ones(5), [0.0]])

    return step(row, np.array([0.3, -0.4]), h).stages[:, 2:4]


@lru_cache
def trees(order):
    """Rooted trees of so many nodes, each as its branches, sorted (Hairer, Norsett & Wanner 1993, II.2)."""
    if order == 1:
        return [()]
    found = set()
    for sizes in partitions(order - 1):
        for branches in product(*(trees(size) for size in sizes)):
            found.add(tuple(sorted(branches)))
    return sorted(found)


def partitions(whole, largest=None):
    if whole == 0:
        yield ()
    for part in range(min(whole, largest or whole), 0, -1):
        for rest in partitions(whole - part, part):
            yield (part, *rest)


def stage_weights(tree, full):
    """The tree's elementary weights (11,) at the stages and the end."""
    weights = np.ones(STAGES + 1)
    for branch in tree:
        weights = weights * (full @ stage_weights(branch, full))
    return weights


def density(tree):
    """One over what the exact solution has in place of the elementary weight: the product of all subtrees' sizes."""
    return size(tree) * math.prod(density(branch) for branch in tree)


def size(tree):
    return 1 + sum(size(branch) for branch in tree)


FULL = np.zeros((STAGES + 1, STAGES + 1))
FULL[:STAGES, : STAGES - 1], FULL[STAGES, :STAGES] = A, B
LOWER = np.append(B, 0.0) - ERROR
# Weights of the slopes, and the order up to which they are those of a method, or of a difference of two.
ORDERS = {"method": (np.append(B, 0.0), 7, 1.0), "lower": (LOWER, 6, 1.0), "rough": (ROUGH, 5, 0.0)}


@pytest.mark.parametrize("name", ORDERS)
def test_the_weights_meet_all_conditions_of_their_order_and_not_all_of_the_next(name):
    """A condition a rooted tree: 1, 1, 2, 4, 9, 20, 48, 115 of them with one to eight nodes."""
    weights, order, exact = ORDERS[name]
    assert [len(trees(k)) for k in range(1, 9)] == [1, 1, 2, 4, 9, 20, 48, 115]
    for nodes in range(1, order + 2):
        missed = [abs(weights @ stage_weights(tree, FULL) - exact / density(tree)) for tree in trees(nodes)]
        assert max(missed) < 1e-14 if nodes <= order else max(missed) > 1e-6


def test_the_middle_of_a_step_is_known_to_order_five():
    """Conditions on trees for the state halfway, and for a value that depends on it: a power of a half less."""
    for nodes in range(1, 6):
        for tree in trees(nodes):
            weights, exact = stage_weights(tree, FULL), 0.5**nodes / density(tree)
            assert MIDDLE_STATE @ weights == pytest.approx(exact, abs=1e-14)
            assert MIDDLE_VALUE @ weights == pytest.approx(2.0 * nodes * exact, abs=1e-14)


def test_places_are_sums_of_rows():
    np.testing.assert_allclose(FULL.sum(axis=1), [*C, 1.0], rtol=0.0, atol=5e-14)


@pytest.mark.parametrize(("weights", "order"), [(ERROR, 7), (ROUGH, 6)], ids=["estimate", "rough"])
def test_the_estimates_fall_with_their_powers_of_the_step(weights, order):
    sizes = [h * np.abs(weights @ stages_of(h)).max() for h in (0.1, 0.05)]
    assert math.log2(sizes[0] / sizes[1]) == pytest.approx(order, abs=0.25)


def test_the_error_is_the_larger_of_two_estimates_so_that_one_may_vanish():
    slopes = stages_of(0.3)
    rough = LEAST_SHARE * 0.3 * np.abs(ROUGH @ slopes).max()
    assert error_rate(slopes, 0.3) == max(np.abs(ERROR @ slopes).max(), rough)
    blind = slopes.copy()
    blind[9] -= ERROR @ slopes / ERROR[9]
    assert np.abs(ERROR @ blind).max() < 1e-15
    assert error_rate(blind, 0.3) == pytest.approx(rough)


def test_lengths_of_steps_do_not_follow_the_rounding_of_their_errors():
    """Errors that differ by a millionth give the same length, but where two lengths meet: one of 256 in an octave."""
    errors = 10.0 ** np.random.default_rng(2).uniform(-13.0, -6.0, 2000)
    pairs = [[next_length(0.05, error * (1.0 + shift), 1e-9) for shift in (0.0, 1e-6)] for error in errors.tolist()]
    assert np.mean([one != other for one, other in pairs]) < 1e-3
    exact = np.clip(0.8 * (1e-9 / errors) ** (1.0 / 7.0), 0.2, 4.0) * 0.05
    ratio = np.array(pairs)[:, 0] / exact
    assert ((ratio > 1.0 - 1.0 / 128.0) & (ratio <= 1.0 + 1e-12)).all()


def test_a_drag_whose_estimate_vanishes_by_chance_keeps_its_accuracy():
    """The centre of rotation crosses the rim within a long step: by the estimate alone it was 48 accuracies off."""
    slider = replace(CollectionLoop.mit().slider, hitch=(-0.0270707, 0.0044444))
    loop = CollectionLoop.mit(slider=slider, accuracy=1e-6)
    exact = replace(loop, accuracy=1e-10)
    theta = 3.4033945 + np.linspace(-2e-5, 2e-5, 9)
    assert np.abs(loop.next_theta(theta) - exact.next_theta(theta)).max() < 2e-6
