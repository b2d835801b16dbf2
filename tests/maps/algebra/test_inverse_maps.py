"""The inverse of monotone maps, with jumps and plateaus: an inverse in every sense it can be one."""

import numpy as np
import pytest
from random_maps import GRID, away, check_same, rising_map, straight

from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, compose, inverse

TWO_PI = 2 * np.pi


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(25))
def test_the_inverse_undoes_and_is_undone_to_rounding(seed):
    f = rising_map(seed)
    back = inverse(f)
    x = away(f, 1e-12)
    np.testing.assert_allclose(back(f(x)), x, rtol=0, atol=1e-12)
    np.testing.assert_allclose(f(back(f(x))), f(x), rtol=0, atol=1e-12)
    slope = f.derivative(x)
    np.testing.assert_allclose(back.derivative(f(x)) * slope, 1.0, rtol=0, atol=1e-9 if f.samples else 1e-11)
    if f.jumps()[0].size == 0:
        np.testing.assert_allclose(f(back(GRID)), GRID, rtol=0, atol=1e-12)
    one = back.scalar()
    np.testing.assert_allclose([one(y) for y in GRID[::9]], back(GRID[::9]), rtol=0, atol=1e-13)
    check_same(compose(back, f), CircleMap(lambda t: t, np.ones_like, compose(back, f).breaks))
    check_same(inverse(back), f, atol=1e-11)


@pytest.mark.parametrize("seed", range(5))
def test_falling_maps_are_inverted_too(seed):
    f = straight(seed, degree=-1, gaps=seed % 2 == 0)
    if seed == 4:
        f = CircleMap(lambda x: 0.5 - x + 0.9 * np.sin(x), lambda x: 0.9 * np.cos(x) - 1, degree=-1)
    back = inverse(f)
    x = away(f, 1e-12)
    assert back.degree == -1
    np.testing.assert_allclose(back(f(x)), x, rtol=0, atol=1e-12)
    np.testing.assert_allclose(back.derivative(f(x)) * f.derivative(x), 1.0, rtol=0, atol=1e-11)
    np.testing.assert_allclose(back(GRID + TWO_PI) - back(GRID), -TWO_PI, rtol=0, atol=1e-13)
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
    np.testing.assert_allclose(back.right_derivative([0.25, 3.0, 5.0]), [2.0, 1.0, 2.0], rtol=1e-12)
    np.testing.assert_allclose(back.left_derivative([1.0, 3.0, 4.0]), [2.0, 0.0, 1.0], rtol=1e-12)
    check_same(inverse(back), f)


@pytest.mark.parametrize(
    ("circle_map", "message"),
    [
        (CircleMap.blaschke([0, 0]), "degree 2: only degree 1 or -1 .* preimages"),
        (CircleMap.arnold(0.2, 1.5), "turns back on .*branches inverts each monotone piece"),
        (
            CircleMap.from_branches([(0, 3, lambda x: 2 * x, None), (3, TWO_PI, lambda x: x, None)]),
            "jumps back by 3 at θ = 3",
        ),
    ],
)
def test_what_has_no_inverse_is_refused_and_the_way_out_named(circle_map, message):
    with pytest.raises(InvalidInput, match=message):
        inverse(circle_map)
