"""Composition, iterates, inverses, conjugation and the Möbius group: the laws they must obey."""

import numpy as np
import pytest

from cyclemap.maps import (
    CircleMap,
    compose,
    conjugate,
    inverse,
    nth_iterate,
    upper_envelope,
)
from tests.maps.known_maps import TWO_PI, agree, apart, lines

GRID = np.linspace(-9.0, 9.0, 1801) + 0.00123


def straight(seed, degree=1, gaps=True, count=4):
    """Straight branches that all rise (or fall, for a negative degree), with jumps between them or
    none.
    """
    rng = np.random.default_rng(seed)
    starts = np.sort(rng.uniform(0, TWO_PI, count))
    ends = np.append(starts[1:], starts[0] + TWO_PI)
    shares = rng.uniform(0.3, 1.0, 2 * count)
    shares[1::2] *= gaps
    climbed = np.append(0.0, np.cumsum(shares)) / shares.sum()
    heights = rng.uniform(-3, 3) + TWO_PI * degree * climbed
    slopes = np.diff(heights)[::2] / (ends - starts)
    at_zero = heights[:-1:2] - slopes * starts
    return lines(*zip(starts, ends, at_zero, slopes, strict=True), degree=degree)


def sampled(seed):
    rng = np.random.default_rng(seed)
    x = np.linspace(0, TWO_PI, 90, endpoint=False)
    c = rng.uniform(-0.3, 0.3, 2)
    return CircleMap.from_samples(x, x + 2 + c[0] * np.sin(x) + c[1] * np.cos(2 * x))


INJECTIVE = [
    CircleMap.arnold(0.37, 0.9),
    CircleMap.moebius(0.7, 0.2),
    sampled(3),
    straight(4),
    straight(5, gaps=False),
    straight(6, degree=-1),
    CircleMap(lambda x: 0.5 - x + 0.9 * np.sin(x), lambda x: 0.9 * np.cos(x) - 1, degree=-1),
]
FOLDED = CircleMap.arnold(0.3, 2.5)
MAPS = [*INJECTIVE[:6], FOLDED, CircleMap.blaschke([0.4j, 0.5], 0.3), straight(7, degree=2)]


def away(circle_map, distance=1e-6):
    """Grid angles that are not near a break of the map."""
    gaps = apart(GRID[:, None], circle_map.breaks)
    return GRID[np.min(gaps, axis=1, initial=np.pi) > distance]


def check_same(first, second, atol=1e-12):
    """Equal degree, breaks, values (both forms) and slopes."""
    assert first.degree == second.degree
    agree(first.breaks, second.breaks, 1e-10)
    x = away(first)
    assert x.size > 1000
    scale = 1.0 + np.max(np.abs(first(x))) + np.max(np.abs(first.derivative(x)))
    agree(first(x), second(x), atol * scale)
    agree(first.derivative(x), second.derivative(x), 1e-9 * scale)
    agree([first.scalar()(t) for t in x[::40]], second(x[::40]), atol * scale)


@pytest.mark.parametrize("index", range(9))
def test_composition_is_associative_multiplies_degrees_and_is_one_map_after_the_other(index):
    f, g, h = MAPS[index], MAPS[(4 * index + 1) % 9], MAPS[(7 * index + 2) % 9]
    left = compose(compose(f, g), h)
    check_same(left, compose(f, compose(g, h)))
    assert left.degree == f.degree * g.degree * h.degree
    x = away(left)
    np.testing.assert_allclose(left(x), f(g(h(x))), rtol=1e-13, atol=3e-12)


@pytest.mark.parametrize("seed", range(9))
def test_the_breaks_of_a_composite_are_complete_and_its_one_sided_values_those_beside_them(seed):
    f = straight(seed, degree=[-1, 1, 2][seed // 3])
    g = [straight(seed + 50, degree=-1), FOLDED, straight(seed + 60, degree=2)][seed % 3]
    made = compose(f, g)
    x = np.linspace(0, TWO_PI, 100_001)
    steps = np.flatnonzero(np.abs(np.diff(f(g(x)))) > 0.02)
    assert steps.size >= 4
    assert np.max(np.min(apart(x[steps, None], made.breaks), axis=1)) < 1.01 * x[1]
    b = made.breaks
    rounding = 3e-14 * (1 + np.max(np.abs(f.derivative(GRID))))
    for side, limit in ((-1, made.left), (1, made.right)):
        beside = b + side * 1e-8
        steep = made.derivative(beside)
        agree(limit(b), f(g(beside)) - side * 1e-8 * steep, rounding)
        agree(made.derivative(b, side), steep, 1e-6)
    agree(made(b), made.right(b), 3e-12)
    assert made.jumps()[0].size >= 4


def test_a_composite_keeps_to_its_side_of_a_break_however_flat_the_inner_map_is():
    """F'(θ) = 1e-6 moves the place where rounding crosses the outer break by 1e-10, far beyond
    one-sided steps.
    """
    flat = lines((0, 6, 2, 1e-6), (6, TWO_PI, 0, 1), slopes=False)
    made = compose(lines((0, 2.000003, 0, 0.5), (2.000003, TWO_PI, 1, 0.8), slopes=False), flat)
    at = made.breaks[np.argmin(np.abs(made.breaks - 3.0))]
    assert abs(at - 3.0) < 1e-8
    agree([made.left(at), made.right(at), made(at)], [1.0000015, 2.6000024, 2.6000024], 1e-11)
    agree(made(np.nextafter(at, 0)), 1.0000015, 1e-11)


def test_an_inner_plateau_that_lies_on_an_outer_break_has_breaks_at_its_ends():
    inner = upper_envelope(CircleMap.arnold(0.1, 2.5))
    at = np.mod(float(inner(np.max(inner.breaks) + 0.01)), TWO_PI)
    made = compose(lines((at, at + 3, 0, 0.5), (at + 3, at + TWO_PI, 1, 0.5)), inner)
    assert np.max(np.min(apart(inner.breaks[:, None], made.breaks), axis=1)) < 1e-10


def test_the_claimed_error_of_a_composite_and_of_an_inverse_holds():
    """Sampled maps with errors that are known, against the maps they were sampled from."""
    x = np.linspace(0, TWO_PI, 60, endpoint=False)
    ratios = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        truths = [CircleMap.moebius(rng.uniform(0.1, 0.5), rng.uniform()) for _ in range(2)]
        made = []
        for truth in truths:
            samples = x, truth(x), truth.derivative(x)
            rough = CircleMap.from_samples(*samples)
            error = 1.01 * np.max(np.abs(rough(GRID) - truth(GRID))) + 1e-15
            made.append(CircleMap.from_samples(*samples, max_error=error))
        for make in (
            lambda pair: compose(*pair),
            lambda pair: nth_iterate(pair[0], 3),
            lambda pair: inverse(pair[1]),
        ):
            claimed = make(made)
            off = np.abs(claimed(GRID) - make(truths)(GRID))
            ratios.append(claimed.max_error / np.max(off))
    assert min(ratios) >= 1.0 and max(ratios) < 60.0


@pytest.mark.parametrize("f", MAPS)
def test_an_iterate_of_n_plus_m_is_one_after_the_other(f):
    check_same(nth_iterate(f, 5), compose(nth_iterate(f, 2), nth_iterate(f, 3)), atol=1e-10)
    check_same(nth_iterate(f, 2), compose(f, f))
    assert nth_iterate(f, 1) is f
    np.testing.assert_array_equal(nth_iterate(f, 0)(GRID), GRID)


@pytest.mark.parametrize("f", MAPS)
@pytest.mark.parametrize("angle", [0.7, -9.0])
def test_conjugation_is_rotation_after_map_after_rotation_back(f, angle):
    made = conjugate(f, angle)
    there, back = CircleMap.rigid(angle / TWO_PI), CircleMap.rigid(-angle / TWO_PI)
    check_same(made, compose(there, compose(f, back)), atol=3e-13)
    agree(made.breaks, np.sort(np.mod(f.breaks + angle, TWO_PI)), 1e-14)
    agree(made.right(made.breaks), made(made.breaks), 1e-13)
    assert made.samples == f.samples and (made.pieces is None) == (f.pieces is None)


@pytest.mark.parametrize("f", INJECTIVE)
def test_the_inverse_undoes_and_is_undone_to_rounding(f):
    back = inverse(f)
    assert back.degree == f.degree
    x = away(f, 1e-12)
    agree(back(f(x)), x, 1e-12)
    agree(f(back(f(x))), f(x), 1e-12)
    agree(back.derivative(f(x)) * f.derivative(x), 1.0, 1e-9 if f.samples else 1e-11)
    if f.jumps()[0].size == 0:
        agree(f(back(GRID)), GRID, 1e-12)
    agree([back.scalar()(y) for y in GRID[::9]], back(GRID[::9]), 1e-13)
    check_same(inverse(back), f, atol=1e-11)


def test_a_jump_becomes_a_plateau_and_a_plateau_a_jump_and_the_inverse_is_the_supremum():
    """The inverse that is continuous from the right is G(y) = sup {x : F(x) ≤ y}."""
    f = lines((0.5, 2, 0, 0.5), (2, 3, 1, 0), (3, 4, 0, 1), (4, 0.5 + TWO_PI, 3, 0.5))
    back = inverse(f)
    y = np.concatenate([np.linspace(0.2, 7.0, 500), [1.0, 3.0, 4.0, 5.0, 0.25]])
    x = np.linspace(-8, 16, 240_001)
    agree(back(y), x[np.searchsorted(f(x), y, side="right") - 1], 2.1e-4)
    agree(back.jumps(), [[1.0], [2.0], [3.0]], 1e-12)
    assert np.all(back.derivative(np.array([1.5, 2.9, 4.5])) == 0.0)
    agree(back.derivative([0.25, 3.0, 5.0], 1), [2.0, 1.0, 2.0], 2e-12)
    agree(back.derivative([1.0, 3.0, 4.0], -1), [2.0, 0.0, 1.0], 2e-12)
    check_same(inverse(back), f)
