"""Branches and preimages: closed forms, polynomial roots, brute-force counts."""

import numpy as np
import pytest

from cyclemap.maps import CircleMap, branches, preimages
from tests.maps.known_maps import TWO_PI, agree, apart, lines
from tests.refusals import refused


def folded(seed, degree=1):
    """A random trigonometric lift that folds."""
    rng = np.random.default_rng(seed)
    k = np.arange(1, 5)
    c, s = rng.normal(0, 1.5, (2, 4)) / k
    return CircleMap(
        lambda x: degree * x + np.cos(x[..., None] * k) @ c + np.sin(x[..., None] * k) @ s,
        lambda x: degree - np.sin(x[..., None] * k) @ (k * c) + np.cos(x[..., None] * k) @ (k * s),
        degree=degree,
    )


# Straight branches with a fold at a kink, a kink that is none, a plateau, jumps up and down.
ZIGZAG = lines(
    *[(0.4, 1.0, 0.0, 0.5), (1.0, 1.8, 0.3, 2.0), (1.8, 2.5, 3.9, -1.0), (2.5, 3.5, 2.0, 0.0)],
    *[(3.5, 5.0, 0.25, 0.5), (5.0, 0.4 + TWO_PI, 1.0, 0.1)],
)


def check_tiling(circle_map, parts):
    starts, ends = np.array([p.start for p in parts]), np.array([p.end for p in parts])
    assert np.array_equal(ends[:-1], starts[1:]) and 0 <= starts[0] < TWO_PI
    agree(ends[-1], starts[0] + TWO_PI, 1e-14)
    for part in parts:
        agree(part.start_value, circle_map.right(part.start), 2e-13)
        agree(part.end_value, circle_map.left(part.end), 2e-13)
        x = np.linspace(part.start, part.end, 203)[1:-1]
        assert np.all(np.diff(circle_map(x)) * part.direction > 0) or part.direction == 0


@pytest.mark.parametrize("K", [1.001, 3.0, 20.0])
def test_the_sine_map_has_two_branches_cut_where_the_cosine_is_one_over_K(K):
    made = CircleMap.arnold(0.2, K)
    rising, falling = branches(made)
    fold = np.arccos(1 / K)
    agree([rising.start, rising.end], [fold, TWO_PI - fold], 1e-12)
    assert (rising.direction, falling.direction) == (1, -1)
    check_tiling(made, (rising, falling))


@pytest.mark.parametrize("seed", range(6))
def test_branches_tile_one_turn_and_each_inverse_undoes_the_map_to_rounding(seed):
    made = folded(seed, degree=seed % 4 - 1)
    parts = branches(made)
    check_tiling(made, parts)
    turns = np.diff(made(np.linspace(0, TWO_PI, 20001))) > 0
    assert len(parts) == np.count_nonzero(turns != np.roll(turns, 1)) >= 2
    for part in parts:
        low, high = sorted((part.start_value, part.end_value))
        values = np.linspace(low, high, 60).reshape(3, 20)
        theta = part.inverse(values)
        assert theta.shape == (3, 20) and np.all((theta >= part.start) & (theta <= part.end))
        agree(made(theta), values, 5e-14)
        x = np.linspace(part.start, part.end, 40)[1:-1]
        error = np.abs(part.inverse(made(x)) - x)
        assert np.all(error <= 3e-14 / np.abs(made.derivative(x)) + 2e-15)


def test_kinks_cut_only_where_the_direction_changes_and_plateaus_and_jumps_always_do():
    parts = branches(ZIGZAG)
    check_tiling(ZIGZAG, parts)
    agree([p.start for p in parts], [0.4, 1.0, 1.8, 2.5, 3.5, 5.0], 1e-12)
    assert [p.direction for p in parts] == [1, 1, -1, 0, 1, 1]
    steep = (TWO_PI - 1) / (TWO_PI - 2)
    bent = lines((0, 2, 0, 0.5), (2, TWO_PI, TWO_PI * (1 - steep), steep))
    assert bent.breaks.size == 2 and len(branches(bent)) == 1


def test_values_outside_a_branch_and_levels_of_plateaus_are_refused():
    rising = branches(CircleMap.arnold(0.2, 2.0))[0]
    outside = r"value 9 is outside the branch: F runs from 0\.57"
    refused(rising.inverse, [2.0, 9.0], told=outside)
    refused(rising.inverse, np.nan, told="finite")
    refused(branches(ZIGZAG)[3].inverse, 2.0, told="a plateau has no inverse")
    refused(preimages, ZIGZAG, 2.0, told=r"along \[2.5, 3.5\]: the preimages cannot be listed")
    assert preimages(ZIGZAG, 2.0 + 1e-9).size >= 1
    refused(preimages, ZIGZAG, np.inf, told="angle")


@pytest.mark.parametrize("seed", range(5))
def test_preimages_under_a_blaschke_product_are_the_roots_of_its_polynomial(seed):
    """B(z) = w is Π(z - a) = w e^{-2πiΩ} Π(1 - conj(a) z): exactly k roots, all on the circle."""
    rng = np.random.default_rng(seed)
    zeros = rng.uniform(0, 0.8, 4) * np.exp(1j * rng.uniform(0, TWO_PI, 4))
    made = CircleMap.blaschke(zeros, 0.17)
    bottom = np.array([1.0 + 0j])
    for a in zeros:
        bottom = np.convolve(bottom, [-np.conj(a), 1.0])
    for angle in rng.uniform(0, TWO_PI, 5):
        roots = np.roots(np.poly(zeros) - np.exp(1j * (angle - TWO_PI * 0.17)) * bottom)
        found = preimages(made, angle)
        assert found.size == 4
        agree(found, np.sort(np.mod(np.angle(roots), TWO_PI)), 1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("made", [*(folded(seed, seed - 1) for seed in range(4)), ZIGZAG])
def test_preimages_of_folded_maps_are_as_many_as_the_crossings_on_a_fine_grid(made):
    x = np.linspace(0, TWO_PI, 200_001)
    y = made(x)
    jump = np.abs(np.diff(y)) > 0.05
    counts = set()
    for angle in np.random.default_rng(1).uniform(0, TWO_PI, 20):
        found = preimages(made, angle)
        laps = np.floor((y - angle) / TWO_PI)
        assert found.size == np.sum(np.abs(np.diff(laps))[~jump])
        agree(apart(made(found), angle), 0.0, 5e-14)
        assert np.all(np.diff(found) > 1e-9) and np.all((found >= 0) & (found < TWO_PI))
        counts.add(found.size)
    assert len(counts) > 1


def test_a_fold_is_one_preimage_and_beside_its_level_there_are_two_or_none_more():
    made = CircleMap.arnold(0.2, 2.0)
    rising, _ = branches(made)
    level = rising.start_value
    assert preimages(made, level).size == 2
    assert np.min(np.abs(preimages(made, level) - rising.start)) == 0.0
    assert (preimages(made, level + 1e-9).size, preimages(made, level - 1e-9).size) == (3, 1)
    sine = CircleMap(np.sin, np.cos, degree=0)
    agree(preimages(sine, 1.0), [np.pi / 2], 2e-8)
    agree(preimages(sine, 0.0), [0.0, np.pi], 1e-15)
    assert preimages(sine, 1.5).size == 0


def test_at_a_jump_the_value_from_the_right_is_taken_and_the_one_from_the_left_is_not():
    made = lines((1, 4, 0, 0.5), (4, 1 + TWO_PI, 1, 0.5), slopes=False)
    assert preimages(made, 3.0).tolist() == [4.0]
    assert preimages(made, 2.0).size == 0 and preimages(made, 2.5).size == 0
    agree(preimages(made, 2.0 - 1e-9), [4 - 2e-9], 1e-14)
    assert preimages(made, 0.5).tolist() == [1.0]


def test_each_preimage_counts_once_where_a_kink_or_the_end_of_the_turn_lies_on_the_level():
    bent = CircleMap.from_branches(
        [(0, 2, lambda x: x, None), (2, TWO_PI, lambda x: x + 0.2 * (x - 2) * (TWO_PI - x), None)]
    )
    assert bent.breaks.size == 2
    for angle, theta in [(2.0, 2.0), (0.0, 0.0), (TWO_PI, 0.0)]:
        agree(preimages(bent, angle), [theta], 1e-14)
    turned = CircleMap.rigid(0.3)
    for angle in float(turned(0.0)) + np.arange(-9, 9) * 4e-16:
        assert preimages(turned, angle).size == 1


def test_the_inverse_holds_up_to_a_jump_whichever_way_it_goes():
    stepped = CircleMap(
        lambda x: x + 0.1 * np.sin(x) + 0.4 * (np.mod(x - 1.0, TWO_PI) >= 3.0), None, [1.0, 4.0]
    )
    up, down = branches(stepped)
    for branch in (up, down):
        values = branch.end_value - np.geomspace(1e-9, 0.1, 30)
        agree(stepped(branch.inverse(values)), values, 4e-15)
    assert up.end_value < down.start_value and stepped(down.end) < down.end_value
