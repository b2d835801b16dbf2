"""A last leg in a random direction: unbiased on an even surface at any length, and not on plywood."""

import math

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.mechanics import EllipseFriction, Material
from cyclemap.resets.strategies.drag_strategies import TrailingLeg
from cyclemap.resets.strategies.shared_strokes import SharedStrokes
from cyclemap.resets.strategies.strategy_maps import strategy_maps

EVEN = CollectionLoop.mit(Material("even", EllipseFriction.isotropic(0.25)), accuracy=1e-7)
PLYWOOD = CollectionLoop.mit("plywood", accuracy=1e-6)
COUNT = 7


def ends(loop, length):
    """(directions, starts) orientations after one cycle of the full mechanics, from evenly spread starts."""
    strokes = SharedStrokes(loop)
    starts = 2.0 * math.pi * np.arange(COUNT) / COUNT
    actions = TrailingLeg(length).law(COUNT).actions
    return starts, np.array([[strokes.sample(action, start)[0] for start in starts.tolist()] for action in actions])


def test_on_an_even_surface_even_orientations_stay_even_at_any_length():
    """Every moment of the orientation after one cycle vanishes, and what a single start keeps does not know the start.

    The kernel is a convolution (docs/theory/random-leg.md), on the grid of directions and starts too.
    """
    for length in (0.05, 0.15):
        starts, after = ends(EVEN, length)
        for order in (1, 2, 3):
            assert abs(np.mean(np.exp(1j * order * after))) < 1e-6
            kept = np.mean(np.exp(1j * order * (after - starts)), axis=0)
            assert np.ptp(kept.real) < 1e-6 and np.ptp(kept.imag) < 1e-6
            assert 0.01 < abs(kept[0]) < 0.99


def test_on_plywood_they_do_not():
    starts, after = ends(PLYWOOD, 0.05)
    assert abs(np.mean(np.exp(1j * after))) > 0.02
    kept = np.mean(np.exp(1j * (after - starts)), axis=0)
    assert np.ptp(kept.real) > 0.02


@pytest.mark.parametrize("loop", [EVEN, PLYWOOD])
def test_the_law_of_the_leg_leaves_of_plywoods_bias_what_the_surface_makes_of_it(loop):
    """Stationary law without noise, 50 mm legs: uniform on the even surface, far from it on plywood.

    Found by following 4,000 even starts through the maps of the law, drawn anew in each of 60 cycles.
    """
    made = strategy_maps(loop, TrailingLeg(0.05), nodes=3, tolerance=1e-1)
    rng = np.random.default_rng(1)
    theta = 2.0 * math.pi * (np.arange(4000) + 0.5) / 4000
    for _ in range(60):
        chosen = rng.integers(3, size=theta.size)
        theta = np.choose(chosen, [one(theta) for one in made.maps]) % (2.0 * math.pi)
    resultant = abs(np.mean(np.exp(1j * theta)))
    assert resultant < 5.0 / math.sqrt(4000) if loop is EVEN else resultant > 0.8
