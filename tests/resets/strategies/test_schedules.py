"""Schedules: each spreads evenly, alone and jointly, and keeps its own promise of evenness."""

import math

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.resets.strategies.schedules import (
    GoldenAngle,
    Independent,
    LatinBlocks,
    Schedule,
    Sobol,
    VanDerCorput,
)
from cyclemap.resets.strategies.spread import Spread

ALL = (Independent(), GoldenAngle(), VanDerCorput(), Sobol(), LatinBlocks(12), LatinBlocks(5, jitter=False))
SEQUENCES = (GoldenAngle(), VanDerCorput(), Sobol())


def gaps(points):
    ordered = np.sort(points)
    return np.diff(ordered, append=ordered[0] + 1.0)


@pytest.mark.parametrize("schedule", ALL, ids=repr)
def test_draws_lie_in_the_unit_cube_and_depend_on_the_seed_alone(schedule):
    assert isinstance(schedule, Schedule)
    for dimensions in (1, 3):
        points = schedule.draws(37, dimensions, 5)
        assert points.shape == (37, dimensions) and points.min() >= 0.0 and points.max() < 1.0
        np.testing.assert_array_equal(points, schedule.draws(37, dimensions, np.random.SeedSequence(5)))
        assert np.any(points != schedule.draws(37, dimensions, 6))
    assert schedule.draws(0, 2, 1).shape == (0, 2)


@pytest.mark.parametrize("schedule", ALL, ids=repr)
def test_coordinates_spread_evenly_alone_and_jointly(schedule):
    """The means of e^{2 pi i (k.u)} vanish: within 5/sqrt(n) for random draws, and much nearer for sequences."""
    count = 2400
    points = schedule.draws(count, 2, 1)
    orders = [(k, m) for k in range(-2, 3) for m in range(-2, 3) if (k, m) != (0, 0)]
    means = [abs(np.mean(np.exp(2j * math.pi * (points @ order)))) for order in orders]
    assert len(means) == 24
    assert max(means) < (0.02 if schedule.kind == "sequence" else 5.0 / math.sqrt(count))


@pytest.mark.parametrize("schedule", ALL, ids=repr)
def test_the_first_draw_is_even_over_the_seeds(schedule):
    """So that the law of every single cycle is the uniform one."""
    first = np.array([schedule.draws(2, 1, seed)[1, 0] for seed in range(400)])
    assert abs(np.mean(np.exp(2j * math.pi * first))) < 3.5 / math.sqrt(400)


def test_the_golden_angle_leaves_gaps_of_three_lengths_at_most():
    """The three-gap theorem (Sos 1957), and the largest is at most the golden ratio squared over n + 1."""
    for count in (2, 5, 8, 13, 30, 100):
        lengths = gaps(GoldenAngle().draws(count, 1, 3)[:, 0])
        assert len(np.unique(lengths.round(9))) <= 3
        assert lengths.max() < 2.6181 / (count + 1) + 1e-9


def test_base_two_sequences_visit_every_dyadic_sector_alike():
    for schedule in (VanDerCorput(), Sobol()):
        for bits in (3, 5):
            sectors = np.floor(2**bits * schedule.draws(2 ** (bits + 1), 1, 4)[:, 0]).astype(int)
            assert np.bincount(sectors[: 2**bits]).tolist() == [1] * 2**bits
            assert np.bincount(sectors[2**bits :]).tolist() == [1] * 2**bits


def test_latin_blocks_visit_every_sector_once_in_changing_order():
    for schedule in (LatinBlocks(7), LatinBlocks(7, jitter=False)):
        sectors = np.floor(7 * schedule.draws(30, 2, 2)).astype(int)
        for block in range(4):
            assert np.array_equal(np.sort(sectors[7 * block : 7 * block + 7], axis=0)[:, 1], np.arange(7))
        assert np.any(sectors[:7] != sectors[7:14]) and np.any(sectors[:7, 0] != sectors[:7, 1])
    middles = LatinBlocks(4, jitter=False).draws(8, 1, 0)
    assert set(middles.ravel().tolist()) == {0.125, 0.375, 0.625, 0.875}


def test_every_sequence_covers_better_than_independent_draws():
    """The largest gap among 128 directions, the median over 20 seeds."""
    found = {
        type(schedule).__name__: np.median([gaps(schedule.draws(128, 1, seed)[:, 0]).max() for seed in range(20)])
        for schedule in (*SEQUENCES, LatinBlocks(128), Independent())
    }
    assert len(found) == 5 and all(found[name] < 0.6 * found["Independent"] for name in found if name != "Independent")


def test_a_spreads_nodes_integrate_what_they_promise():
    """A full turn: harmonics below the count. An interval: polynomials up to degree 2k - 1."""
    values, weights = Spread.full_turn().nodes(10)
    for order in range(1, 10):
        assert abs(weights @ np.exp(1j * order * values)) < 1e-14
    assert abs(weights @ np.exp(10j * values)) > 0.99
    values, weights = Spread(0.2, 0.5).nodes(16)
    for degree in range(8):
        exact = (0.5 ** (degree + 1) - 0.2 ** (degree + 1)) / (degree + 1) / 0.3
        assert len(values) == 4 and abs(weights @ values**degree - exact) < 1e-15
    assert Spread.full_turn().closed and not Spread.within(1.0, 0.5).closed
    assert not Spread(0.0, 2.0 * math.pi).closed
    values, weights = Spread(1.0, 3.0).nodes(99, sectors=2)
    assert values.tolist() == [1.5, 2.5] and weights.tolist() == [0.5, 0.5]


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: LatinBlocks(0), "block size must be at least 1"),
        (lambda: LatinBlocks(3, jitter=1), "jitter must be True or False"),
        (lambda: GoldenAngle().draws(-1, 1, 0), "cycles must be at least 0"),
        (lambda: Sobol().draws(4, 0, 0), "dimensions must be at least 1"),
        (lambda: Spread(1.0, 1.0), "from a lower to a higher number"),
        (lambda: Spread(0.0, 7.0, around=True), "wider than a full turn"),
        (lambda: Spread(math.nan, 1.0), "low end must be a finite number"),
        (lambda: Spread(0.0, 1.0).nodes(0), "nodes must be at least 1"),
    ],
)
def test_bad_values_are_refused(call, match):
    with pytest.raises(InvalidInput, match=match):
        call()
