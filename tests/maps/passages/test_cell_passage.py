"""Passages under uniform noise: closed forms, Monte Carlo, a coarser chain, infinities."""

import numpy as np
import pytest

from cyclemap.errors import ConvergenceError
from cyclemap.maps import CircleMap, UniformNoise, hitting_probability, mean_passage_time
from tests.maps.known_maps import DROPPING, simulated, within

STILL = CircleMap.rigid(0.0)
STICKY = CircleMap.arnold(0.1, 0.9)
FOLDED = CircleMap.arnold(0.3, 3.0)
BARRIER = (
    0.9 - 0.2 * np.pi
)  # the least halfwidth that carries the sticky map past its slowest point, θ = π/2


def walk_time(x, length, h):
    """Mean time of the driftless walk out of (0, L), h <= L <= 2h: u' = v/2h, v' = -u/2h for u(x),
    v(x) = u(x + h).
    """
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
        found = mean_passage_time(STILL, UniformNoise(h), start, (0.0, 0.45), lifted=True)
        assert found.holds(2 * h / (2 * h - 0.45)) and found.error_bound < 1e-10


@pytest.mark.parametrize("length", [0.55, 0.9, 0.99])
def test_a_walk_leaves_a_longer_arc_after_the_time_of_its_delay_equation(length):
    for start in (0.0, 0.02, 0.3, 0.5, length - 0.1):
        found = mean_passage_time(STILL, UniformNoise(0.5), start + 2.0, (2.0, 2.0 + length))
        exact = walk_time(start, length, 0.5)
        assert abs(found - exact) <= found.error_bound < 1e-2


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
    found = mean_passage_time(circle_map, UniformNoise(h), start, ends)
    assert abs(found - lives.mean()) < 4.5 * lives.std() / np.sqrt(lives.size)
    assert found.error_bound < 0.01 * found


def test_lifted_and_wrapped_passages_differ_only_by_steps_of_a_turn():
    ends = (-0.2, 1.6)
    wrapped, lifted = (
        mean_passage_time(STICKY, UniformNoise(0.8), 0.77, ends, lifted=way)
        for way in (False, True)
    )
    assert abs(wrapped - lifted) <= wrapped.error_bound + lifted.error_bound
    wrapped, lifted = (
        mean_passage_time(STICKY, UniformNoise(7.0), 0.77, ends, lifted=way)
        for way in (False, True)
    )
    assert wrapped > lifted + 0.1
    lives, _ = simulated(
        STICKY, UniformNoise(2.0), 0.77, lambda theta: (theta < -2.2) | (theta > 3.6)
    )
    found = mean_passage_time(STICKY, UniformNoise(2.0), 0.77, (-2.2, 3.6), lifted=True)
    assert abs(found - lives.mean()) < 4.5 * lives.std() / np.sqrt(lives.size)


def test_a_long_passage_agrees_with_a_chain_of_cells():
    """Cells of width δ, each with the law of its middle: an error of order δ², a third of it left
    by halving.
    """
    h, ends = 0.4, (0.0, 1.6)
    times = []
    for count in (500, 1000):
        edges = np.linspace(*ends, count + 1)
        middle = STICKY(0.5 * (edges[1:] + edges[:-1]))[:, None]
        overlap = np.minimum(edges[1:], middle + h) - np.maximum(edges[:-1], middle - h)
        chain = np.eye(count) - np.maximum(overlap, 0.0) / (2 * h)
        times.append(
            np.interp(0.77, 0.5 * (edges[1:] + edges[:-1]), np.linalg.solve(chain, np.ones(count)))
        )
    limit = times[1] + (times[1] - times[0]) / 3
    found = mean_passage_time(STICKY, UniformNoise(h), 0.77, ends)
    assert abs(found / limit - 1) < 2e-3
    assert found > 20_000 and found.error_bound < 0.01 * found


def test_the_time_is_infinite_where_the_noise_is_too_small():
    found = mean_passage_time(STICKY, UniformNoise(0.1), 0.77, (0.0, 1.6))
    assert found == np.inf and found.error_bound == 0.0
    assert mean_passage_time(STICKY, UniformNoise(BARRIER + 0.1), 0.77, (0.0, 1.6)) < 1e6
    # Where it cannot fall back it is finite, trap or no trap.
    beyond = mean_passage_time(STICKY, UniformNoise(0.12), 2.56, (0.0, 4.5))
    lives, _ = simulated(
        STICKY, UniformNoise(0.12), 2.56, lambda theta: ~within(theta, (0.0, 4.5)), 5_000
    )
    assert abs(beyond - lives.mean()) < 4.5 * lives.std() / np.sqrt(lives.size) + beyond.error_bound


@pytest.mark.parametrize("beyond", [-1e-4, 1e-4, 0.02])
def test_a_gap_as_narrow_as_a_cell_is_refused_or_infinite_but_never_guessed(beyond):
    try:
        found = mean_passage_time(STICKY, UniformNoise(BARRIER + beyond), 0.77, (0.0, 1.6))
    except ConvergenceError as refusal:
        assert "a gap as narrow as a cell" in str(refusal)
    else:
        assert found == np.inf and beyond < 0.0


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
    _, last = simulated(
        circle_map, UniformNoise(h), start, lambda theta: within(theta, a) | within(theta, b)
    )
    found = hitting_probability(circle_map, UniformNoise(h), start, a, b)
    share = np.mean(within(last, a))
    assert abs(found - share) < 4.5 * np.sqrt(max(found * (1 - found), 1e-6) / last.size)
    assert found.error_bound < 1e-3


def test_an_arc_that_cannot_be_reached_has_chance_zero_exactly():
    found = hitting_probability(STICKY, UniformNoise(0.1), 0.77, (1.6, 2.0), (-1.0, -0.5))
    assert found == 0.0 and found.error_bound < 1e-15


def test_bounds_hold_where_a_map_is_off_to_both_sides():
    """Moved up and down as a whole an odd map's passages stay: pulled apart or together they do
    not.
    """

    def pulled(by, claim=0.0):
        return CircleMap(lambda x: x - 0.3 * np.sin(x) + by * np.sin(x), max_error=claim)

    for off in (1e-4, 1e-3):
        claimed = mean_passage_time(pulled(0.0, off), UniformNoise(0.6), 0.0, (-1.0, 1.0))
        for by in (-off, off):
            other = mean_passage_time(pulled(by), UniformNoise(0.6), 0.0, (-1.0, 1.0))
            assert abs(claimed - other) <= claimed.error_bound
        assert claimed.error_bound < 1_000.0 * off
