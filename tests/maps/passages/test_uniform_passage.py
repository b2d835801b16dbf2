"""Passages under uniform noise: closed forms, Monte Carlo, a chain of cells, exact infinities."""

import numpy as np
import pytest

from cyclemap.errors import ConvergenceError
from cyclemap.maps import CircleMap, UniformNoise, hitting_probability
from cyclemap.maps.passages.uniform_passage import uniform_hitting_probability, uniform_passage_time
from tests.maps.known_maps import DROPPING, simulated, within

STILL = CircleMap.rigid(0.0)
STICKY = CircleMap.arnold(0.1, 0.9)
FOLDED = CircleMap.arnold(0.3, 3.0)
BARRIER = 0.9 - 0.2 * np.pi  # the least halfwidth that carries the sticky map past its slowest point, θ = π/2


def walk_time(x, length, h):
    """Mean time of the driftless walk out of (0, L), h <= L <= 2h: u' = v/2h, v' = -u/2h for u(x), v(x) = u(x + h)."""
    d = (length - h) / (2 * h)
    share = (1 - np.sin(d)) / np.cos(d)
    middle = 1 / (1 - 2 * share * np.sin(d) - 2 * (1 - np.cos(d)) - (2 * h - length) / (2 * h))
    near = min(x, length - x)
    if near >= length - h:
        return middle
    return middle * (share * np.cos(near / (2 * h)) + np.sin(near / (2 * h)))


@pytest.mark.parametrize("h", [0.5, 0.47, 3.0])
def test_a_walk_leaves_a_short_arc_with_the_same_chance_every_cycle(h):
    for start in (0.0, 0.13, 0.45):
        found = uniform_passage_time(STILL, UniformNoise(h), start, (0.0, 0.45), True)
        assert found.holds(2 * h / (2 * h - 0.45)) and found.error_bound < 1e-11


@pytest.mark.parametrize("length", [0.55, 0.9, 0.99])
def test_a_walk_leaves_a_longer_arc_after_the_time_of_its_delay_equation(length):
    for start in (0.0, 0.02, 0.3, 0.5, length - 0.1):
        found = uniform_passage_time(STILL, UniformNoise(0.5), start + 2.0, (2.0, 2.0 + length))
        exact = walk_time(start, length, 0.5)
        assert abs(found - exact) <= found.error_bound < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize(
    ("circle_map", "h", "start", "ends"),
    [
        (STILL, 0.2, 0.3, (0.0, 1.0)),
        (STICKY, 0.7, 0.77, (-0.2, 1.6)),
        (STICKY, 4.0, 0.77, (-0.2, 1.6)),
        (DROPPING, 1.0, 1.0, (0.5, 3.0)),
        (FOLDED, 0.3, 1.0, (0.5, 3.0)),
    ],
)
def test_monte_carlo_agrees(circle_map, h, start, ends):
    lives, _ = simulated(circle_map, UniformNoise(h), start, lambda theta: ~within(theta, ends))
    found = uniform_passage_time(circle_map, UniformNoise(h), start, ends)
    assert abs(found - lives.mean()) < 4.5 * lives.std() / np.sqrt(lives.size)
    assert found.error_bound < 1e-7


def test_lifted_and_wrapped_passages_differ_only_by_steps_of_a_turn():
    ends = (-0.2, 1.6)
    wrapped, lifted = (uniform_passage_time(STICKY, UniformNoise(0.8), 0.77, ends, way) for way in (False, True))
    assert abs(wrapped - lifted) <= wrapped.error_bound + lifted.error_bound
    wrapped, lifted = (uniform_passage_time(STICKY, UniformNoise(7.0), 0.77, ends, way) for way in (False, True))
    assert wrapped > lifted + 0.1
    lives, _ = simulated(STICKY, UniformNoise(2.0), 0.77, lambda theta: (theta < -2.2) | (theta > 3.6))
    found = uniform_passage_time(STICKY, UniformNoise(2.0), 0.77, (-2.2, 3.6), True)
    assert abs(found - lives.mean()) < 4.5 * lives.std() / np.sqrt(lives.size)


def test_a_long_passage_agrees_with_a_chain_of_cells():
    """Cells of width δ, each with the law of its middle: an error of order δ², a third of it left by halving."""
    h, ends = 0.4, (0.0, 1.6)
    times = []
    for count in (500, 1000):
        edges = np.linspace(*ends, count + 1)
        middle = STICKY(0.5 * (edges[1:] + edges[:-1]))[:, None]
        overlap = np.minimum(edges[1:], middle + h) - np.maximum(edges[:-1], middle - h)
        chain = np.eye(count) - np.maximum(overlap, 0.0) / (2 * h)
        times.append(np.interp(0.77, 0.5 * (edges[1:] + edges[:-1]), np.linalg.solve(chain, np.ones(count))))
    limit = times[1] + (times[1] - times[0]) / 3
    found = uniform_passage_time(STICKY, UniformNoise(h), 0.77, ends)
    assert abs(found / limit - 1) < 1e-4
    assert found > 20_000 and found.error_bound < 1e-7 * found


@pytest.mark.slow
def test_the_time_is_infinite_exactly_where_the_noise_is_too_small():
    for h in (0.1, BARRIER - 1e-4):
        found = uniform_passage_time(STICKY, UniformNoise(h), 0.77, (0.0, 1.6))
        assert found == np.inf and found.error_bound == 0.0
    assert uniform_passage_time(STICKY, UniformNoise(BARRIER + 0.1), 0.77, (0.0, 1.6)) < 1e6
    # From beyond the slowest point the path may fall back for good: the mean is infinite there too.
    assert uniform_passage_time(STICKY, UniformNoise(0.25), 1.55, (0.0, 1.6)) == np.inf
    # Where it cannot fall back it is finite, trap or no trap.
    beyond = uniform_passage_time(STICKY, UniformNoise(0.12), 2.56, (0.0, 4.5))
    lives, _ = simulated(STICKY, UniformNoise(0.12), 2.56, lambda theta: ~within(theta, (0.0, 4.5)), 5_000)
    assert abs(beyond - lives.mean()) < 4.5 * lives.std() / np.sqrt(lives.size) + beyond.error_bound


def test_a_passage_beyond_double_precision_is_refused():
    with pytest.raises(ConvergenceError, match="too long"):
        uniform_passage_time(STICKY, UniformNoise(BARRIER + 0.02), 0.77, (0.0, 1.6))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("circle_map", "h", "start", "a", "b"),
    [
        (STICKY, 0.7, 0.77, (1.5, 2.0), (-0.2, 0.1)),
        (DROPPING, 0.9, 2.0, (3.0, 3.5), (0.0, 0.5)),
        (FOLDED, 0.3, 2.0, (3.0, 3.5), (0.0, 0.5)),
        (STILL, 0.4, 2.0, (3.0, 4.0), (0.0, 1.5)),
    ],
)
def test_monte_carlo_hits_agree(circle_map, h, start, a, b):
    _, last = simulated(circle_map, UniformNoise(h), start, lambda theta: within(theta, a) | within(theta, b))
    found = uniform_hitting_probability(circle_map, UniformNoise(h), start, a, b)
    share = np.mean(within(last, a))
    assert abs(found - share) < 4.5 * np.sqrt(max(found * (1 - found), 1e-6) / last.size)
    assert found.error_bound < 1e-4


def test_an_arc_that_cannot_be_reached_has_chance_zero_exactly():
    found = uniform_hitting_probability(STICKY, UniformNoise(0.1), 0.77, (1.6, 2.0), (-1.0, -0.5))
    assert found == 0.0 and found.error_bound == 0.0


def test_narrow_noise_asks_only_for_where_the_path_may_come_to():
    """A path 1e-4 wide goes one way only: few evaluations decide, where the whole circle would take thousands."""
    asked = []

    def sine(theta):
        asked.append(np.size(theta))
        return theta + 0.2 * np.pi - 0.9 * np.sin(theta)

    counted = CircleMap(sine, lambda theta: 1.0 - 0.9 * np.cos(theta))
    found = hitting_probability(counted, UniformNoise(1e-4), 0.5, (0.77, 0.78), (-0.002, -0.001))
    assert found.holds(1.0) and found.error_bound < 1e-8
    assert sum(asked) < 1_000_000


def test_narrow_walks_are_wide_walks_seen_from_afar():
    """Chances and times depend on lengths over the noise's width alone; half-way between two ends it is a half."""
    narrow = hitting_probability(STILL, UniformNoise(1e-4), 0.0, (5e-4, 1e-3), (-1e-3, -5e-4))
    wide = hitting_probability(STILL, UniformNoise(0.1), 0.1, (0.5, 1.0), (-1.0, -0.5))
    near = hitting_probability(STILL, UniformNoise(1e-4), 1e-4, (5e-4, 1e-3), (-1e-3, -5e-4))
    assert narrow.holds(0.5) and abs(near - wide) <= near.error_bound + wide.error_bound < 1e-7


@pytest.mark.slow
def test_paths_that_a_trap_swallows_count_for_neither_arc():
    arcs, noise = ((3.4, 3.6), (-0.5, 0.0)), UniformNoise(0.15)
    chances = [uniform_hitting_probability(STICKY, noise, 2.4, *pair) for pair in (arcs, arcs[::-1])]
    _, last = simulated(
        STICKY, UniformNoise(0.15), 2.4, lambda x: within(x, arcs[0]) | within(x, arcs[1]) | within(x, (0.5, 1.0))
    )
    for found, arc in zip(chances, arcs, strict=True):
        assert abs(found - np.mean(within(last, arc))) < 4.5 * np.sqrt(found * (1 - found) / last.size)
    assert 0.2 < sum(chances) < 0.35
