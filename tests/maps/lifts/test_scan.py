"""Cells, preimages and bracketed roots: monotone pieces, closed forms, breaks of iterates."""

import numpy as np
import pytest

from cyclemap.maps import CircleMap, fixed_points, is_nondecreasing
from cyclemap.maps.lifts.scan import bracketed_root, iterate, monotone_cells, preimages
from tests.maps.known_maps import TWO_PI, agree, bumped


def test_roots_in_many_brackets_are_found_to_rounding_and_few_evaluations():
    calls = []
    shift = np.linspace(0.1, 50.0, 1000)

    def residual(x, index):
        calls.append(x.size)
        return x**3 - shift[index]

    found = bracketed_root(residual, np.zeros(1000), np.full(1000, 4.0))
    np.testing.assert_allclose(found, np.cbrt(shift), rtol=1e-15)
    assert sum(calls) < 14 * 1000


def test_a_bracket_without_a_sign_change_gives_its_end_nearer_to_zero():
    found = bracketed_root(lambda x, _: x * x + 1.0, np.array([1.0, -3.0]), np.array([2.0, -1.0]))
    assert found.tolist() == [1.0, -1.0]


@pytest.mark.parametrize("shift", [0.0, 1.0])
def test_the_iterate_is_monotone_in_every_cell_and_the_cells_tile_the_turn(shift):
    folded = CircleMap.arnold(0.3, 3.0)
    cells = monotone_cells(folded, 4, shift)
    assert (cells.start[0], cells.end[-1]) == (0.0, TWO_PI)
    np.testing.assert_array_equal(cells.start[1:], cells.end[:-1])
    np.testing.assert_array_equal(cells.g_start[1:], cells.g_end[:-1])
    inside = cells.start + np.linspace(0, 1, 9)[:, None] * (cells.end - cells.start)
    steps = np.diff(iterate(folded, inside, 4) - shift * inside, axis=0)
    trend = np.sign(cells.g_end - cells.g_start)
    assert np.all(steps * trend > -1e-11)


def test_turning_points_of_the_iterate_are_counted_by_the_chain_rule():
    # (Fⁿ)' = 0 where some image up to the n-th is a fold: count the preimages of the folds one by
    # one.
    folded = CircleMap.arnold(0.3, 3.0)
    folds = np.array([1.0, -1.0]) * np.arccos(1 / 3)
    once = monotone_cells(folded, 1, 0.0)
    generation, total = np.mod(folds, TWO_PI), 0
    for n in (1, 2, 3, 4):
        total += generation.size
        cells = monotone_cells(folded, n, 0.0)
        rising = cells.g_end > cells.g_start
        assert np.count_nonzero(rising != np.roll(rising, 1)) == total
        generation = preimages(folded, once, generation)
    assert total > 30


def test_breaks_of_an_iterate_are_the_preimages_of_the_breaks():
    # The tripling map with a mark at 0: marks of the n-th iterate at k/3ⁿ⁻¹ turns, each once.
    tripling = CircleMap(lambda x: 3 * x, lambda x: 3 + 0 * x, [0.0], degree=3)
    for n in (1, 2, 4, 7):
        cells, count = monotone_cells(tripling, n, 0.0), 3 ** (n - 1)
        agree(cells.start[cells.cut], TWO_PI * np.arange(count) / count, 3e-12)


@pytest.mark.parametrize("width", [6e-4, 6e-5])
@pytest.mark.parametrize("K", [0.0, 0.9])
def test_bumps_a_tenth_of_a_milliradian_wide_are_seen_wherever_they_lie(width, K):
    """One that just folds the map makes it fall; one that bends it back over the diagonal adds two
    fixed points.
    """
    for place in 0.1 + 0.39 * np.arange(16):
        around = place + width * np.linspace(-5.0, 5.0, 2001)
        folding = bumped(place, width, 1.75 * width * (1.0 - K * np.cos(place)), K)(0.13)
        assert np.any(np.diff(folding(around)) < 0.0) and not is_nondecreasing(folding)
        height = 5.0 * width * (K * abs(np.cos(place)) + 0.05)
        crossing = bumped(place, width, height, K)((K * np.sin(place) - 0.5 * height) / TWO_PI)
        above = crossing.turn(np.union1d(np.linspace(0.0, TWO_PI, 2001), around)) > 0.0
        assert len(fixed_points(crossing)) == np.count_nonzero(np.diff(above)) == (4 if K else 2)
