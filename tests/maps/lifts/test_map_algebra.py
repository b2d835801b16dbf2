"""Composition, iterates, inverses, conjugation and the Möbius group: the laws they must obey."""

from itertools import pairwise

import numpy as np
import pytest

from cyclemap.maps import (
    CircleMap,
    compose,
    conjugate,
    inverse,
    nth_iterate,
    shifted,
    upper_envelope,
)

TWO_PI = 2 * np.pi
GRID = np.linspace(-9.0, 9.0, 1801) + 0.00123


def straight(seed, degree=1, gaps=True, count=4):
    """Straight branches that all rise (or fall, for a negative degree), with jumps between them or
    none.
    """
    rng = np.random.default_rng(seed)
    ends = np.append(np.sort(rng.uniform(0, TWO_PI, count)), 0.0)
    ends[-1] = ends[0] + TWO_PI
    shares = rng.uniform(0.3, 1.0, 2 * count)
    shares[1::2] *= gaps
    heights = (
        rng.uniform(-3, 3) + TWO_PI * degree * np.append(0.0, np.cumsum(shares)) / shares.sum()
    )
    rows = []
    for i, (a, b) in enumerate(pairwise(ends)):
        slope = (heights[2 * i + 1] - heights[2 * i]) / (b - a)
        low = heights[2 * i]
        rows.append(
            (
                a,
                b,
                lambda x, a=a, y=low, s=slope: y + s * (x - a),
                lambda x, s=slope: np.full_like(x, s),
            )
        )
    return CircleMap.from_branches(rows, degree=degree)


def sampled(seed):
    rng = np.random.default_rng(seed)
    x = np.linspace(0, TWO_PI, 90, endpoint=False)
    c = rng.uniform(-0.3, 0.3, 2)
    return CircleMap.from_samples(x, x + 2 + c[0] * np.sin(x) + c[1] * np.cos(2 * x))


def any_map(seed):
    rng = np.random.default_rng(seed + 100)
    kinds = (
        lambda: CircleMap.arnold(rng.uniform(), rng.uniform(0, 3)),
        lambda: CircleMap.moebius(rng.uniform(0, 0.9), rng.uniform()),
        lambda: CircleMap.blaschke([0.4j, rng.uniform(0, 0.6)], rng.uniform()),
        lambda: sampled(seed),
        lambda: straight(seed),
        lambda: straight(seed, degree=-1),
        lambda: straight(seed, degree=2),
    )
    return kinds[seed % len(kinds)]()


def injective_map(seed):
    rng = np.random.default_rng(seed + 500)
    kinds = (
        lambda: CircleMap.arnold(rng.uniform(), rng.uniform(0, 0.97)),
        lambda: CircleMap.moebius(rng.uniform(0, 0.9), rng.uniform()),
        lambda: sampled(seed),
        lambda: straight(seed),
        lambda: straight(seed, gaps=False),
        lambda: straight(seed, degree=-1),
        lambda: CircleMap(
            lambda x: 0.5 - x + 0.9 * np.sin(x), lambda x: 0.9 * np.cos(x) - 1, degree=-1
        ),
    )
    return kinds[seed % len(kinds)]()


def away(circle_map, distance=1e-6):
    """Grid angles that are not near a break of the map."""
    if circle_map.breaks.size == 0:
        return GRID
    gap = np.abs(np.mod(GRID[:, None] - circle_map.breaks + np.pi, TWO_PI) - np.pi)
    return GRID[np.min(gap, axis=1) > distance]


def check_same(first, second, atol=1e-12):
    """Equal degree, breaks, values (both forms) and slopes."""
    assert first.degree == second.degree
    np.testing.assert_allclose(first.breaks, second.breaks, rtol=0, atol=1e-10)
    x = away(first)
    assert x.size > 1000
    scale = 1.0 + np.max(np.abs(first(x))) + np.max(np.abs(first.derivative(x)))
    np.testing.assert_allclose(first(x), second(x), rtol=0, atol=atol * scale)
    np.testing.assert_allclose(first.derivative(x), second.derivative(x), rtol=0, atol=1e-9 * scale)
    one = first.scalar()
    np.testing.assert_allclose(
        [one(t) for t in x[::40]], second(x[::40]), rtol=0, atol=atol * scale
    )


@pytest.mark.parametrize("seed", range(14))
def test_composition_is_associative_multiplies_degrees_and_is_one_map_after_the_other(seed):
    f, g, h = any_map(seed), any_map(3 * seed + 1), any_map(5 * seed + 2)
    left, right = compose(compose(f, g), h), compose(f, compose(g, h))
    check_same(left, right)
    assert left.degree == f.degree * g.degree * h.degree
    x = away(left)
    np.testing.assert_allclose(left(x), f(g(h(x))), rtol=1e-13, atol=3e-12)
    np.testing.assert_allclose(
        left(x + TWO_PI) - left(x), TWO_PI * left.degree, rtol=1e-11, atol=1e-11
    )


@pytest.mark.parametrize("seed", range(20))
def test_the_breaks_of_a_composite_are_complete_and_its_one_sided_values_those_beside_them(seed):
    rng = np.random.default_rng(seed)
    f = straight(seed, degree=int(rng.choice([-1, 1, 2])))
    g = [straight(seed + 50, degree=-1), CircleMap.arnold(0.3, 2.5), straight(seed + 60, degree=2)][
        seed % 3
    ]
    made = compose(f, g)
    x = np.linspace(0, TWO_PI, 100_001)
    y = f(g(x))
    steps = np.flatnonzero(np.abs(np.diff(y)) > 0.02)
    assert steps.size >= 4
    gap = np.abs(np.mod(x[steps, None] - made.breaks + np.pi, TWO_PI) - np.pi)
    assert np.max(np.min(gap, axis=1)) < 1.01 * x[1]
    b = made.breaks
    for side, limit in ((-1, made.left), (1, made.right)):
        near = b + side * 1e-8
        steep = made.derivative(near)
        expected, tolerance = (
            f(g(near)) - side * 1e-8 * steep,
            3e-14 * (1 + np.max(np.abs(f.derivative(GRID)))),
        )
        np.testing.assert_allclose(limit(b), expected, rtol=0, atol=tolerance)
        np.testing.assert_allclose(
            made.derivative(b, side), made.derivative(near), rtol=0, atol=1e-6
        )
    np.testing.assert_allclose(made(b), made.right(b), rtol=0, atol=1e-12)
    assert made.jumps()[0].size >= 4


def test_a_composite_keeps_to_its_side_of_a_break_however_flat_the_inner_map_is():
    """F'(θ) = 1e-6 moves the place where rounding crosses the outer break by 1e-10, far beyond
    one-sided steps.
    """
    flat = CircleMap.from_branches(
        [(0, 6, lambda x: 2 + 1e-6 * x, None), (6, TWO_PI, lambda x: x, None)]
    )
    jump = CircleMap.from_branches(
        [(0, 2.000003, lambda x: 0.5 * x, None), (2.000003, TWO_PI, lambda x: 1 + 0.8 * x, None)]
    )
    made = compose(jump, flat)
    at = made.breaks[np.argmin(np.abs(made.breaks - 3.0))]
    assert abs(at - 3.0) < 1e-8
    np.testing.assert_allclose(
        [made.left(at), made.right(at), made(at)], [1.0000015, 2.6000024, 2.6000024], atol=1e-11
    )
    np.testing.assert_allclose(made(np.nextafter(at, 0)), 1.0000015, atol=1e-11)


def test_an_inner_plateau_that_lies_on_an_outer_break_has_breaks_at_its_ends():
    inner = upper_envelope(CircleMap.arnold(0.1, 2.5))
    level = float(
        inner(inner.breaks[0] + 0.01 if inner.breaks.size == 1 else np.max(inner.breaks) + 0.01)
    )
    at = np.mod(level, TWO_PI)
    outer = CircleMap.from_branches(
        [(at, at + 3, lambda x: 0.5 * x, None), (at + 3, at + TWO_PI, lambda x: 0.5 * x + 1, None)]
    )
    made = compose(outer, inner)
    for b in inner.breaks:
        assert np.min(np.abs(made.breaks - b)) < 1e-10


def test_the_claimed_error_of_a_composite_and_of_an_inverse_holds():
    """Sampled maps with errors that are known, against the maps they were sampled from."""
    x = np.linspace(0, TWO_PI, 60, endpoint=False)
    ratios = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        truths = [CircleMap.moebius(rng.uniform(0.1, 0.5), rng.uniform()) for _ in range(2)]
        made = []
        for truth in truths:
            rough = CircleMap.from_samples(x, truth(x), truth.derivative(x))
            error = 1.01 * np.max(np.abs(rough(GRID) - truth(GRID))) + 1e-15
            made.append(CircleMap.from_samples(x, truth(x), truth.derivative(x), max_error=error))
        true_errors = [
            (compose(*made), np.max(np.abs(compose(*made)(GRID) - truths[0](truths[1](GRID))))),
            (
                nth_iterate(made[0], 3),
                np.max(np.abs(nth_iterate(made[0], 3)(GRID) - nth_iterate(truths[0], 3)(GRID))),
            ),
            (inverse(made[1]), np.max(np.abs(inverse(made[1])(GRID) - inverse(truths[1])(GRID)))),
        ]
        ratios += [circle_map.max_error / error for circle_map, error in true_errors]
    assert len(ratios) == 18 and min(ratios) >= 1.0 and max(ratios) < 60.0


@pytest.mark.parametrize("seed", range(14))
def test_an_iterate_of_n_plus_m_is_one_after_the_other(seed):
    f = any_map(seed)
    check_same(nth_iterate(f, 5), compose(nth_iterate(f, 2), nth_iterate(f, 3)), atol=1e-10)
    check_same(nth_iterate(f, 2), compose(f, f))
    assert nth_iterate(f, 1) is f
    np.testing.assert_array_equal(nth_iterate(f, 0)(GRID), GRID)
    assert nth_iterate(f, 3).degree == f.degree**3


@pytest.mark.parametrize("seed", range(14))
def test_conjugation_is_rotation_after_map_after_rotation_back(seed):
    f, angle = any_map(seed), [0.7, -2.5, 4.4, 9.0][seed % 4]
    made = conjugate(f, angle)
    there, back = CircleMap.rigid(angle / TWO_PI), CircleMap.rigid(-angle / TWO_PI)
    check_same(made, compose(there, compose(f, back)), atol=3e-13)
    np.testing.assert_allclose(
        made.breaks, np.sort(np.mod(f.breaks + angle, TWO_PI)), rtol=0, atol=1e-14
    )
    np.testing.assert_allclose(made.right(made.breaks), made(made.breaks), rtol=0, atol=1e-13)
    assert made.samples == f.samples and (made.pieces is None) == (f.pieces is None)
    check_same(conjugate(made, -angle), f)


def test_a_shifted_lift_is_whole_turns_higher_and_nothing_else():
    for f in (CircleMap.arnold(0.05, 0.9), sampled(1), straight(7)):
        up = shifted(f, 3)
        np.testing.assert_allclose(up(GRID), f(GRID) + 3 * TWO_PI, rtol=0, atol=2e-14)
        np.testing.assert_allclose(up.derivative(GRID), f.derivative(GRID), rtol=0, atol=2e-14)
        assert np.array_equal(up.breaks, f.breaks)
        assert up.samples == f.samples and up.scalar()(1.0) == pytest.approx(
            f.scalar()(1.0) + 3 * TWO_PI, abs=1e-13
        )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(28))
def test_the_inverse_undoes_and_is_undone_to_rounding(seed):
    f = injective_map(seed)
    back = inverse(f)
    assert back.degree == f.degree
    x = away(f, 1e-12)
    np.testing.assert_allclose(back(f(x)), x, rtol=0, atol=1e-12)
    np.testing.assert_allclose(f(back(f(x))), f(x), rtol=0, atol=1e-12)
    slope = f.derivative(x)
    np.testing.assert_allclose(
        back.derivative(f(x)) * slope, 1.0, rtol=0, atol=1e-9 if f.samples else 1e-11
    )
    if f.jumps()[0].size == 0:
        np.testing.assert_allclose(f(back(GRID)), GRID, rtol=0, atol=1e-12)
    one = back.scalar()
    np.testing.assert_allclose([one(y) for y in GRID[::9]], back(GRID[::9]), rtol=0, atol=1e-13)
    check_same(compose(back, f), CircleMap(lambda t: t, np.ones_like, compose(back, f).breaks))
    check_same(inverse(back), f, atol=1e-11)


def test_a_jump_becomes_a_plateau_and_a_plateau_a_jump_and_the_inverse_is_the_supremum():
    """The inverse that is continuous from the right is G(y) = sup {x : F(x) ≤ y}."""
    f = CircleMap.from_branches(
        [
            (0.5, 2, lambda x: 0.5 * x, lambda x: np.full_like(x, 0.5)),
            (2, 3, lambda x: 0 * x + 1.0, np.zeros_like),
            (3, 4, lambda x: x, np.ones_like),
            (4, 0.5 + TWO_PI, lambda x: 0.5 * x + 3, lambda x: np.full_like(x, 0.5)),
        ]
    )
    back = inverse(f)
    y = np.concatenate([np.linspace(0.2, 7.0, 500), [1.0, 3.0, 4.0, 5.0, 0.25]])
    x = np.linspace(-8, 16, 240_001)
    supremum = x[np.searchsorted(f(x), y, side="right") - 1]
    np.testing.assert_allclose(back(y), supremum, rtol=0, atol=2.1e-4)
    at, left, right = back.jumps()
    np.testing.assert_allclose([at, left, right], [[1.0], [2.0], [3.0]], rtol=0, atol=1e-12)
    assert np.all(back.derivative(np.array([1.5, 2.9, 4.5])) == 0.0)
    np.testing.assert_allclose(back.derivative([0.25, 3.0, 5.0], 1), [2.0, 1.0, 2.0], rtol=1e-12)
    np.testing.assert_allclose(back.derivative([1.0, 3.0, 4.0], -1), [2.0, 0.0, 1.0], rtol=1e-12)
    check_same(inverse(back), f)
