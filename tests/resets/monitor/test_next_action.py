"""The next action: the one that lands where least is recorded, and what a collection so steered comes to."""

import math

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.resets.monitor.coverage import CELLS, Coverage
from cyclemap.resets.monitor.next_action import next_action
from cyclemap.resets.scores.coverage_measures import coverage_measures
from cyclemap.resets.strategies.push_strategies import DrawnPushes, fraction_pushes, side_pushes
from cyclemap.resets.strategies.strategy_maps import StrategyMaps, strategy_maps
from cyclemap.resets.strategies.strategy_sampling import sample_strategy


@pytest.fixture(scope="module")
def maps() -> StrategyMaps:
    """Four pushes on plywood, coarse: what is tested here holds for any maps."""
    loop = CollectionLoop.mit()
    pushes = (*fraction_pushes(loop.push, (0.3, 0.7)), *side_pushes(loop.push, (1, 2)))
    return strategy_maps(loop, DrawnPushes(pushes), tolerance=1e-2)


def fed(theta) -> Coverage:
    covered = Coverage()
    for angle in theta:
        covered.add(float(angle))
    return covered


def test_crowding_is_the_density_of_the_recorded_directions_over_its_mean():
    """One direction: the wrapped Cauchy density of the reach, whose mean over the circle is one."""
    covered = fed([1.0])
    cells = (np.arange(CELLS) + 0.5) * 2.0 * math.pi / CELLS
    decay = math.exp(-covered.rule.reach)
    expected = (1.0 - decay**2) / (1.0 + decay**2 - 2.0 * decay * np.cos(cells - 1.0))
    np.testing.assert_allclose(covered.crowding(cells), expected / expected.mean(), rtol=1e-9)
    assert covered.crowding(cells).mean() == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_array_equal(covered.crowding(cells + 4.0 * math.pi), covered.crowding(cells))
    np.testing.assert_array_equal(Coverage().crowding(cells), 0.0)


def test_the_landing_is_that_of_the_map_and_no_alternative_is_emptier(maps):
    covered = fed(np.random.default_rng(3).uniform(0.0, 3.0, 40))
    chosen_numbers = set()
    for theta in np.linspace(0.0, 6.0, 13):
        chosen = next_action(maps, covered, theta)
        assert chosen.lands == pytest.approx(float(maps.maps[chosen.number](theta)) % (2.0 * math.pi), abs=1e-12)
        assert chosen.crowding == min(chosen.alternatives) and len(chosen.alternatives) == 4
        assert chosen.action is maps.law.actions[chosen.number]
        chosen_numbers.add(chosen.number)
    assert len(chosen_numbers) > 1


def test_a_steered_collection_is_more_even_than_one_that_draws(maps):
    """A hundred pushes with the same four: every drawn collection of twenty has the larger Kuiper discrepancy."""
    covered, theta = Coverage(), [0.0]
    for _ in range(100):
        covered.add(theta[-1])
        theta.append(next_action(maps, covered, theta[-1]).lands)
    steered = float(coverage_measures(np.array(theta[1:])).kuiper)
    drawn = [float(coverage_measures(sample_strategy(maps, 100, seed=k).theta[1:]).kuiper) for k in range(20)]
    assert steered < min(drawn)
    assert steered < 0.5 * float(np.mean(drawn))


def test_an_orientation_that_is_no_number_is_refused(maps):
    with pytest.raises(InvalidInput, match="theta"):
        next_action(maps, Coverage(), math.nan)
