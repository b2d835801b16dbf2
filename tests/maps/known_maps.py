"""Maps whose orbits, rotation and passages are known, and how numbers are compared, for all tests
of the room.
"""

from math import ceil, floor

import numpy as np

from cyclemap.arrays import shorter_way
from cyclemap.maps import CircleMap

TWO_PI = 2 * np.pi
TWIN_WELLS = CircleMap(lambda x: x - 0.4 * np.sin(2 * x), lambda x: 1 - 0.8 * np.cos(2 * x))
DROPPING = CircleMap.from_samples([0, 2, 2, 4, 6], [0.7, 2.3, 1.6, 3.8, 6.5], [0.8] * 5)
DOUBLING = CircleMap(lambda x: 2 * x, lambda x: np.full_like(x, 2.0), degree=2)
KNOWN_TURNS = [
    (CircleMap.moebius(0.5, 0.3), 0.262536755898823346733597549046),
    (CircleMap.moebius(0.9, 0.45), 0.383156928981311432564754399638),
    (CircleMap.arnold(0.6, 0.5), 0.602894830374585070928578946844),
]


def agree(found, truth, to):
    """Assert that numbers differ by no more than ``to``."""
    np.testing.assert_allclose(found, truth, rtol=0, atol=to)


def apart(first, second):
    """How far angles lie from each other round the circle, radians."""
    return np.abs(shorter_way(np.subtract(first, second)))


def lines(*rows, degree=1, slopes=True):
    """The lift of straight branches, each (start, end, value at θ = 0, slope)."""
    branches = [
        (a, b, lambda x, y=y, s=s: y + s * x, (lambda x, s=s: s + 0 * x) if slopes else None)
        for a, b, y, s in rows
    ]
    return CircleMap.from_branches(branches, degree=degree)


def logistic(r):
    """x → r x(1 - x) with x in [0, 1) in turns: a lift of degree 0 with a kink at 0."""

    def turns(theta):
        return np.mod(theta, TWO_PI) / TWO_PI

    return CircleMap(
        lambda x: TWO_PI * r * turns(x) * (1 - turns(x)), lambda x: r * (1 - 2 * turns(x)), [0.0], 0
    )


def contraction(slope, shift):
    """x → λx + δ mod 1 as a lift with an upward jump at the integers."""
    return lines((0.0, TWO_PI, TWO_PI * shift, slope))


def plateau(slope, ratio):
    """The δ, in exact fractions for one of λ, where x → λx + δ (mod 1) has ρ = p/q: (left edge,
    right edge).
    """
    q = ratio.denominator
    below = sum((floor((k + 1) * ratio) - floor(k * ratio)) * slope**k for k in range(q))
    above = sum((ceil((k + 1) * ratio) - ceil(k * ratio)) * slope**k for k in range(q))
    rest = 1 - slope**q
    return (1 - slope) * above / rest, (1 - slope) * (1 + below / rest)


def bumped(place, width, height, K=0.0, slopes=True):
    """The family of sine maps with one bump, 5/3 of ``width`` wide at half its height."""

    def bump(x):
        return height * np.exp(-((2 * np.sin(0.5 * (x - place)) / width) ** 2))

    def slope(x):
        return 1 - K * np.cos(x) - 2 * np.sin(x - place) / width**2 * bump(x)

    return lambda omega: CircleMap(
        lambda x: x + TWO_PI * omega - K * np.sin(x) + bump(x), slope if slopes else None
    )


def tent(omega):
    """A kinked map whose fixed points meet its kinks at Ω = -1/4 and 0."""

    def lift(x):
        return x + TWO_PI * omega + 0.5 * np.abs(np.mod(x + np.pi, TWO_PI) - np.pi)

    return CircleMap(
        lift, lambda x: np.where(np.mod(x, TWO_PI) < np.pi, 1.5, 0.5), breaks=[0.0, np.pi]
    )


def reset(to):
    """A map that sends the arc from -1.5 to 1.5 to one place."""
    x = np.array([-1.5, 1.5, 1.5, TWO_PI - 1.5])
    return CircleMap.from_samples(x, [to, to, to, TWO_PI], [0, 0, 0, 0.0])


def wavy(x):
    return x + 0.4 + 0.3 * np.sin(x) - 0.1 * np.cos(2 * x)


def wavy_slope(x):
    return 1 + 0.3 * np.cos(x) + 0.2 * np.sin(2 * x)


def within(theta, ends):
    """Whether the angles lie in the arc, both ends included."""
    return np.mod(theta - ends[0], TWO_PI) <= ends[1] - ends[0]


def simulated(circle_map, noise, start, stop, walkers=20_000, seed=8):
    """Cycles and last positions of paths from ``start`` until ``stop`` says so."""
    rng, theta, lives = np.random.default_rng(seed), np.full(walkers, start), np.zeros(walkers)
    alive = np.arange(walkers)
    while alive.size:
        theta[alive] = circle_map(theta[alive]) + noise.sample(rng, alive.size)
        lives[alive] += 1
        alive = alive[~stop(theta[alive])]
    return lives, theta
