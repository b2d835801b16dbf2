"""Distributions of orientations against closed forms, operators made otherwise, brute force and
simulation.
"""

import math

import numpy as np
import pytest
from refusals import refused

import cyclemap as cm
from cyclemap.resets import CycleAction, ResetStrategy, orientation_law, sampled_orientations
from cyclemap.resets.orientation_law import slowest_factor

N = 720
THETA = 2.0 * math.pi * np.arange(N) / N
ONE = ResetStrategy((CycleAction(),))
PAIR = ResetStrategy((CycleAction(), CycleAction(turn=1.0)))
TURNS = np.array(
    [0.5 + 0.3 * np.sin(THETA), 2.0 - 0.25 * np.cos(2.0 * THETA) + 0.1 * np.sin(THETA)]
)


def in_bins(theta) -> np.ndarray:
    """Shares of the orientations of each row in 24 bins."""
    counts = [np.histogram(row % (2 * math.pi), 24, (0.0, 2 * math.pi))[0] for row in theta]
    return np.array(counts) / theta.shape[1]


def test_one_map_has_the_stationary_distribution_of_the_transfer_operator() -> None:
    """The sine map, locked and not, against the certified operator of the maps."""
    for omega, K, sigma in ((0.1, 0.9, 0.3), (0.3, 0.5, 0.1), (0.02, 0.25, 0.05)):
        sine = cm.CircleMap.arnold(omega, K)
        turn = (np.asarray(sine(THETA)) - THETA)[None]
        law = orientation_law(turn, ONE, sigma)
        operator = cm.transfer_operator(sine, cm.WrappedNormal(sigma))
        whole = np.radians(np.arange(360.0))
        assert law.density == pytest.approx(operator.density(whole), abs=2e-4)
        expected = 0.5 * float(np.mean(np.abs(2.0 * math.pi * operator.density(THETA) - 1.0)))
        assert law.total_variation == pytest.approx(expected, abs=max(law.error, 5e-4))
        factor = slowest_factor(turn, ONE, sigma)
        assert 1.0 - factor == pytest.approx(float(operator.spectral_gap), abs=1e-4)


def test_a_rotation_keeps_the_uniform_distribution_and_forgets_by_its_noise_alone() -> None:
    sigma = 0.4
    law = orientation_law(np.full((1, N), 2.0), ONE, sigma, pushes=20)
    assert law.total_variation == pytest.approx(0.0, abs=1e-12)
    assert slowest_factor(np.full((1, N), 2.0), ONE, sigma) == pytest.approx(
        math.exp(-0.5 * sigma**2)
    )
    orders = np.arange(1, 30)
    left = np.exp(-0.5 * 20 * (orders * sigma) ** 2)
    density = 2.0 * np.cos(np.outer(THETA, orders)) @ left
    assert law.after == pytest.approx(0.5 * np.abs(density).mean(), abs=1e-3)


ORDERS = pytest.mark.parametrize("order", ["random", "in turn", "shuffled"])


@ORDERS
def test_turning_the_surface_changes_no_total_variation(order) -> None:
    """f -> alpha + f(theta - alpha) for every action conjugates the chain."""
    strategy = ResetStrategy(PAIR.actions, order=order)
    plain, turned = (
        orientation_law(np.roll(TURNS, shift, axis=1), strategy, 0.05) for shift in (0, 250)
    )
    assert turned.total_variation == pytest.approx(plain.total_variation, abs=2e-4)
    assert turned.after == pytest.approx(plain.after, abs=2e-3) and plain.total_variation > 0.01


@ORDERS
def test_simulated_orientations_follow_the_law(order) -> None:
    """Each of 24 bins within four standard errors over 200 runs of 200 orientations."""
    strategy = ResetStrategy(PAIR.actions, order=order)
    law = orientation_law(TURNS, strategy, 0.3)
    theta = sampled_orientations(TURNS, strategy, 300, 200, 0.3, seed=1)[:, 100:]
    shares = in_bins(theta)
    middles = 0.5 * (law.density + np.roll(law.density, -1)) * math.radians(1.0)
    error = shares.std(axis=0, ddof=1) / math.sqrt(len(shares))
    exact = middles.reshape(24, 15).sum(axis=1)
    assert np.all(np.abs(shares.mean(axis=0) - exact) < 4.5 * error + 2e-4)


@pytest.mark.parametrize("pushes", [4, 6])
def test_blocks_of_unequal_shares_are_averaged_over_all_their_orders_alike(pushes) -> None:
    """Three of one action and one of another, the orders made one by one on a grid."""
    strategy = ResetStrategy(PAIR.actions, (3.0, 1.0), order="shuffled")
    law = orientation_law(TURNS, strategy, 0.2, pushes)
    step = THETA[:, None] - THETA[None]
    chains = []
    for turn in TURNS:
        off = (step - turn[None] + math.pi) % (2.0 * math.pi) - math.pi
        density = np.exp(-0.5 * (off / 0.2) ** 2)
        chains.append(density / density.sum(axis=0))
    orders = ([0, 0, 0, 1], [0, 0, 1, 0], [0, 1, 0, 0], [1, 0, 0, 0])
    ends = np.mean([np.linalg.multi_dot([chains[k] for k in order]) for order in orders], axis=0)
    if pushes == 6:
        # Two more: the second action first, second, or not among them.
        pairs = [chains[1] @ chains[0], chains[0] @ chains[1], chains[0] @ chains[0]]
        ends = (pairs[0] / 4.0 + pairs[1] / 4.0 + pairs[2] / 2.0) @ ends
    left = 0.5 * np.abs(ends - 1.0 / N).sum(axis=0)
    assert law.after == pytest.approx(left.max(), abs=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("order", "pushes"), [("random", 6), ("shuffled", 5)])
def test_after_n_pushes_is_what_simulated_collections_from_the_worst_start_show(
    order, pushes
) -> None:
    """In the middle of a block, too: 8,000 from each of twelve starts, with the same draws."""
    strategy = ResetStrategy(PAIR.actions, order=order)
    law = orientation_law(TURNS, strategy, 0.2, pushes)
    theta = np.repeat(np.arange(0.0, 2 * math.pi, math.pi / 6.0)[:, None], 8_000, axis=1)
    random = np.random.default_rng(2)
    for chosen in strategy.drawn(6 * 8_000, 2).reshape(-1, 6).T[:pushes]:
        turned = [np.interp(theta, THETA, turn, period=2 * math.pi) for turn in TURNS]
        theta = theta + np.where(chosen == 0, *turned) + 0.2 * random.standard_normal(8_000)
    found = 0.5 * np.abs(in_bins(theta) - 1.0 / 24.0).sum(axis=1)
    assert max(found) == pytest.approx(law.after, abs=0.03)


def test_blocks_too_long_to_average_over_are_refused() -> None:
    many = ResetStrategy(tuple(CycleAction(turn=float(k)) for k in range(12)), order="shuffled")
    told = "passes through 4096 sets of actions"
    refused(orientation_law, np.zeros((12, 96)), many, 0.1, told=told)


@pytest.mark.parametrize("sigma", [0.3, 0.03, 0.01])
def test_the_error_holds_the_operators_distance_down_to_noise_not_resolved(sigma: float) -> None:
    """Two sums of too few waves both exceed 1, and are not the same for that."""
    theta = 2.0 * math.pi * np.arange(1024) / 1024
    for shift, bend in ((0.6, 0.9), (0.9, 1.2)):
        law = orientation_law((shift - bend * np.sin(theta))[None], ONE, sigma, pushes=10)
        sine = cm.CircleMap(lambda x, a=shift, b=bend: x + a - b * np.sin(x))
        exact = cm.transfer_operator(sine, cm.WrappedNormal(sigma)).tv_from_uniform
        assert abs(law.total_variation - exact) <= law.error
        assert law.error < 5e-4 or law.modes == 192
