"""The maps of a strategy's law: each is the mechanics' own, shared where symmetry allows it and nowhere else."""

import math

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction, Material, SidePush
from cyclemap.resets.strategies.combined import combine
from cyclemap.resets.strategies.drag_strategies import GripperTurn, RingPlace, StraightReset, TrailingLeg, WayPoints
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, side_pushes
from cyclemap.resets.strategies.strategy_maps import strategy_maps

TOLERANCE = 1e-3
SHORT = SidePush(distance=0.05)  # a short push is a quick one
EVEN = CollectionLoop.mit(Material("even", EllipseFriction.isotropic(0.25)), push=SHORT)
CENTRED = CollectionLoop.mit(Material("centred", EllipseFriction(0.3, 0.2, phi=0.4)), push=SHORT)
PLYWOOD = CollectionLoop.mit("plywood", push=SHORT)


@pytest.mark.parametrize(
    ("loop", "strategy", "computed"),
    [
        (EVEN, TrailingLeg(0.06), 1),
        (CENTRED, TrailingLeg(0.06), 1),
        (PLYWOOD, TrailingLeg(0.06), 2),
        (PLYWOOD, combine(RingPlace((0.0, 0.012)), WayPoints(((0.05, 0.02),)), GripperTurn()), 1),
        (PLYWOOD, AlternatingPushes(side_pushes(SHORT, (0, 2))), 2),
    ],
)
def test_every_map_is_that_of_the_mechanics(loop, strategy, computed):
    """At orientations off the samples, in value and in the drag's length; alike actions are computed once."""
    made = strategy_maps(loop, strategy, nodes=2, tolerance=TOLERANCE)
    assert made.computed == computed and len(made.maps) == len(made.law.actions) >= 2
    assert made.max_error <= TOLERANCE
    for one, action, lengths in zip(made.maps, made.law.actions, made.drag_lengths([1.0, 4.4]), strict=True):
        cycles = action.on(made.loop).cycles([1.0, 4.4])
        assert np.abs(one([1.0, 4.4]) - cycles.theta_next - action.turn).max() < TOLERANCE
        assert np.abs(lengths - cycles.drag_length).max() < 5e-4


def test_the_mean_drag_is_the_laws_and_progress_rises_to_one():
    seen = []
    made = strategy_maps(EVEN, TrailingLeg(0.05), nodes=16, tolerance=1e-2, progress=seen.append)
    assert seen == sorted(seen) and seen[-1] == 1.0 and len(seen) > 20
    theta = np.linspace(0.0, 6.0, 5)
    lengths = made.drag_lengths(theta)
    assert lengths.shape == (16, 5) and np.allclose(made.mean_drag_length(theta), lengths.mean(axis=0), atol=1e-15)
    # On an even surface the mean over even directions does not know the orientation.
    assert np.ptp(made.mean_drag_length(theta)) < 2e-4 < np.ptp(lengths)


def test_without_way_points_the_map_is_the_loops_own():
    made = strategy_maps(PLYWOOD, StraightReset(), tolerance=1e-2)
    own, theta = PLYWOOD.circle_map(1e-2), np.linspace(0.0, 6.0, 50)
    assert np.abs(made.maps[0](theta) - own(theta)).max() < 1e-9 and made.maps[0].samples == own.samples


def test_bad_input_is_refused():
    with pytest.raises(InvalidInput, match="no reset strategy"):
        strategy_maps(PLYWOOD, "trailing")
    with pytest.raises(InvalidInput, match="tolerance must be positive"):
        strategy_maps(PLYWOOD, StraightReset(), tolerance=-1.0)
    with pytest.raises(InvalidInput, match="nodes must be at least 1"):
        strategy_maps(PLYWOOD, TrailingLeg(0.05, math.pi), nodes=0)
