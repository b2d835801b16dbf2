from itertools import combinations

import numpy as np
import pytest
from correction_cases import SINE, random_map

from cyclemap.errors import InvalidInput
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.resets.least_noise.cycle_cells import CycleCells, circulant
from cyclemap.resets.least_noise.least_noise import least_noise
from cyclemap.resets.least_noise.noise_bound import independent_noise_bound
from cyclemap.resets.least_noise.turn_law_search import left_over_masses, local_optimum, search_turn_law


def laws_in_twentieths(count):
    """Every probability vector of `count` entries that are multiples of 1/20."""
    bars = np.array(list(combinations(range(20 + count - 1), count - 1)))
    ends = np.hstack([np.full((len(bars), 1), -1), bars, np.full((len(bars), 1), 20 + count - 1)])
    return (np.diff(ends, axis=1) - 1) / 20


@pytest.mark.parametrize("circle_map", [SINE, random_map(2), random_map(7)])
def test_no_law_of_a_fine_grid_beats_the_search_on_six_cells(circle_map):
    """Brute force over 53,130 laws of the turn: none that meets the allowance costs less than what the search finds."""
    cycle, count, allowed = CycleCells(circle_map, 6).after.toarray(), 6, 0.1
    prices = np.array([0.0, 1.0, 2.0, 3.0, 2.0, 1.0]) * np.pi / 3
    laws = laws_in_twentieths(count)
    assert len(laws) == 53_130
    rows = (np.arange(count)[:, None] - np.arange(count)) % count
    systems = np.eye(count) - laws[:, rows] @ cycle + 1.0 / count
    stationary = np.linalg.solve(systems, np.full((len(laws), count, 1), 1.0 / count))[..., 0]
    meets = 0.5 * np.sum(np.abs(stationary - 1 / count), axis=1) <= allowed
    assert np.any(meets) and not np.all(meets)
    starts = [np.full(count, 1 / count), *np.random.default_rng(0).dirichlet(np.ones(count), 6)]
    masses, merit = min((local_optimum(cycle, prices, allowed, start) for start in starts), key=lambda pair: pair[1])
    assert merit <= np.min((laws @ prices)[meets]) + 1e-9
    law = left_over_masses(cycle, masses)
    assert 0.5 * np.sum(np.abs(law - 1 / count)) <= allowed + 1e-9
    assert np.allclose(circulant(masses) @ cycle @ law, law, atol=1e-12)


def test_the_law_found_beats_every_family_and_obeys_the_proven_bound():
    found, bound = search_turn_law(SINE, 0.05, cells=32), independent_noise_bound(SINE, 0.05)
    assert found.is_met and found.tv.upper <= 0.05
    best_of_families = min(least_noise(SINE, 0.05, family, scanned=4).mean_cost for family in ("normal", "lazy"))
    assert bound.lower < found.mean_cost < best_of_families


def test_a_simulation_with_the_law_found_is_as_even_as_promised():
    """10⁶ orientations in 24 bins."""
    found, rng = search_turn_law(SINE, 0.05, cells=16), np.random.default_rng(3)
    theta, counts = rng.uniform(0, 2 * np.pi, 10_000), np.zeros(24)
    for cycle in range(120):
        turns = rng.choice(16, 10_000, p=found.masses) + rng.uniform(-0.5, 0.5, 10_000)
        theta = np.mod(SINE(theta) + turns * (2 * np.pi / 16), 2 * np.pi)
        if cycle >= 20:
            counts += np.histogram(theta, 24, (0, 2 * np.pi))[0]
    assert 0.5 * np.sum(np.abs(counts / counts.sum() - 1 / 24)) == pytest.approx(found.tv, abs=0.004)


def test_extremes_of_the_allowance():
    """None at all asks for the uniform turn; a map that keeps the uniform law asks for no more than its arc's width."""
    nothing = search_turn_law(SINE, 0.0, cells=8)
    assert nothing.is_met and nothing.mean_cost == pytest.approx(np.pi / 2)
    free = search_turn_law(CircleMap.rigid(0.25), 0.05, cells=16)
    assert free.is_met and free.mean_cost == pytest.approx(2 * np.pi / 16 / 4, abs=1e-6)


def test_bad_cells_are_named():
    with pytest.raises(InvalidInput, match="cells is 200"):
        search_turn_law(SINE, 0.1, cells=200)
    with pytest.raises(InvalidInput, match="cells must be at least 8"):
        search_turn_law(SINE, 0.1, cells=2)
