"""Random circle maps of every kind, and what makes two maps the same."""

from itertools import pairwise

import numpy as np

from cyclemap.maps import CircleMap

TWO_PI = 2 * np.pi
GRID = np.linspace(-9.0, 9.0, 1801) + 0.00123


def straight(seed, degree=1, gaps=True, count=4):
    """Straight branches that all rise (or fall, for a negative degree), with jumps between them or none."""
    rng = np.random.default_rng(seed)
    ends = np.append(np.sort(rng.uniform(0, TWO_PI, count)), 0.0)
    ends[-1] = ends[0] + TWO_PI
    shares = rng.uniform(0.3, 1.0, 2 * count)
    shares[1::2] *= gaps
    heights = rng.uniform(-3, 3) + TWO_PI * degree * np.append(0.0, np.cumsum(shares)) / shares.sum()
    rows = []
    for i, (a, b) in enumerate(pairwise(ends)):
        slope = (heights[2 * i + 1] - heights[2 * i]) / (b - a)
        low = heights[2 * i]
        rows.append((a, b, lambda x, a=a, y=low, s=slope: y + s * (x - a), lambda x, s=slope: np.full_like(x, s)))
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


def rising_map(seed):
    rng = np.random.default_rng(seed + 500)
    kinds = (
        lambda: CircleMap.arnold(rng.uniform(), rng.uniform(0, 0.97)),
        lambda: CircleMap.moebius(rng.uniform(0, 0.9), rng.uniform()),
        lambda: sampled(seed),
        lambda: straight(seed),
        lambda: straight(seed, gaps=False),
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
    np.testing.assert_allclose([one(t) for t in x[::40]], second(x[::40]), rtol=0, atol=atol * scale)
