"""Long runs sampled from the maps: the very path of the full mechanics, and the law that the maps have."""

import math

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import WrappedNormal
from cyclemap.mechanics import EllipseFriction, Material, SidePush
from cyclemap.resets.strategies.combined import combine
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.drag_strategies import GripperTurn, StraightReset, TrailingLeg
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes, VariedPush, side_pushes
from cyclemap.resets.strategies.schedules import GoldenAngle, LatinBlocks
from cyclemap.resets.strategies.spread import Spread
from cyclemap.resets.strategies.strategy import ActionLaw
from cyclemap.resets.strategies.strategy_maps import strategy_maps
from cyclemap.resets.strategies.strategy_run import run_strategy
from cyclemap.resets.strategies.strategy_sampling import interpolation_error, sample_strategy

SHORT = SidePush(distance=0.05)  # a short push is a quick one
LOOP = CollectionLoop.mit("plywood", push=SHORT, accuracy=1e-6)
EVEN = CollectionLoop.mit(Material("even", EllipseFriction.isotropic(0.25)), push=SHORT, accuracy=1e-6)
NOISE = WrappedNormal(0.03)
SIDES = side_pushes(SHORT, (0, 2))


@pytest.mark.parametrize(
    ("loop", "strategy", "nodes"),
    [
        (EVEN, combine(TrailingLeg(0.05, schedule=GoldenAngle()), GripperTurn(schedule=GoldenAngle())), 40),
        (LOOP, combine(DrawnPushes(SIDES, LatinBlocks(4)), GripperTurn(Spread(-0.5, 0.7))), 4),
        (LOOP, AlternatingPushes(SIDES), 1),
        (LOOP, VariedPush(SHORT, fraction=Spread(0.65, 0.75)), 12),
    ],
)
def test_a_sampled_path_is_that_of_the_full_mechanics(loop, strategy, nodes):
    """Same schedule, same noise: ten cycles apart by no more than the errors of maps and interpolation add up to."""
    maps = strategy_maps(loop, strategy, nodes=nodes, tolerance=1e-3)
    error = interpolation_error(maps, 12, seed=1)
    assert error < 3e-3
    run = run_strategy(loop, strategy, 10, start=0.4, noise=NOISE, seed=3)
    path = sample_strategy(maps, 10, start=0.4, noise=NOISE, seed=3)
    assert path.cycles == 10 and path.theta.shape == (11,) and np.ptp(path.theta) > 0.2
    assert np.abs(path.theta - run.theta).max() < 20 * max(error, 1e-3)
    # The paths are not those of another seed.
    assert np.abs(sample_strategy(maps, 10, start=0.4, noise=NOISE, seed=4).theta - run.theta).max() > 0.01


def test_more_directions_interpolate_better():
    """On the even surface's smooth maps the error falls faster than any power: by 3 or more each time they double."""
    made = [strategy_maps(EVEN, TrailingLeg(0.05), nodes=n, tolerance=3e-4) for n in (4, 8, 16)]
    errors = [interpolation_error(one, 15) for one in made]
    assert errors[0] > 3.0 * errors[1] > 9.0 * errors[2] > 0.0


@pytest.fixture(scope="module")
def even_maps():
    return strategy_maps(EVEN, TrailingLeg(0.08), nodes=12, tolerance=1e-3)


def test_a_long_sample_on_an_even_surface_is_uniform(even_maps):
    """30,000 cycles of legs in random directions: the first moments vanish within five standard errors.

    Of a chain whose moment n shrinks by k_n a cycle, n cycles are worth (1 - k)/(1 + k) of as many independent ones.
    """
    maps = even_maps
    path = sample_strategy(maps, 30_000, seed=2)
    grid = np.linspace(0.0, 2.0 * math.pi, 256, endpoint=False)
    for order in (1, 2):
        kept = abs(np.mean(np.exp(1j * order * maps.maps[0].turn(grid))))
        worth = 30_000 * (1.0 - kept) / (1.0 + kept)
        assert abs(np.mean(np.exp(1j * order * path.theta))) < 5.0 / math.sqrt(worth)
        assert 0.05 < kept < 0.99


def test_what_cannot_be_interpolated_is_refused(even_maps):
    class Own:
        name, needs = "own", ()

        def prepared(self, loop):
            return loop

        def actions(self, cycles, seed=0):
            return (CycleAction(),) * cycles

        def law(self, nodes=1):
            return ActionLaw((CycleAction(),), [1.0])

    maps = strategy_maps(LOOP, Own(), tolerance=1e-1)
    for call in (lambda: sample_strategy(maps, 3), lambda: interpolation_error(maps)):
        with pytest.raises(InvalidInput, match="own does not say what it draws"):
            call()
    with pytest.raises(InvalidInput, match="own does not say what it draws"):
        combine(Own(), StraightReset()).draws(3)
    assert run_strategy(LOOP, combine(Own(), StraightReset()), 1).cycles == 1
    with pytest.raises(InvalidInput, match="cycles must be at least 1"):
        sample_strategy(even_maps, 0)
