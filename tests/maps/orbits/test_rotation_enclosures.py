"""Enclosures of rotation numbers against 10,000 random maps whose rotation number is known some
other way.
"""

from fractions import Fraction
from math import floor

import numpy as np
import pytest

from cyclemap.maps import (
    ARNOLD_FAMILY,
    MOEBIUS_FAMILY,
    CircleMap,
    ParametricLift,
    rotation_interval,
    rotation_number,
    rotation_numbers,
)
from tests.maps.known_maps import contraction, plateau

TWO_PI = 2 * np.pi
ITERATES = 200
MOEBIUS, SINE, CONTRACTIONS, FOLDED, AT_ONCE = 500, 900, 400, 50, 1050  # 5,000 together


def judged(maps, truths):
    """Every map's enclosure, after the check that each holds its truth (a pair of bounds on it, as
    floats).
    """
    found = [rotation_number(circle_map, iterates=ITERATES, max_period=100) for circle_map in maps]
    missed = [
        (i, one.lower, one.upper, low, high)
        for i, (one, (low, high)) in enumerate(zip(found, truths, strict=True))
        if not (one.lower - 1e-15 * abs(low) <= high and low <= one.upper + 1e-15 * abs(low))
        or not one.lower <= one.value <= one.upper
    ]
    assert missed == []
    return found


def widths(found):
    return np.array([one.upper - one.lower for one in found])


def moebius_truth(a, omega):
    """Bounds on ρ that allow for rounding of sin πΩ - a: exact up to 1e-14 away from the tongue's
    edge.
    """
    base = floor(omega)
    part = omega - base
    beyond = np.sin(np.pi * part) - a + np.array([-1e-15, 1e-15]) * (1 + abs(omega))
    sine = np.sqrt(np.maximum(beyond, 0.0) * (beyond + 2 * a)) / np.sqrt(1 - a * a)
    cosine = np.cos(np.pi * part) / np.sqrt(1 - a * a)
    angles = np.arctan2(sine, cosine) / np.pi
    angles = np.where(beyond <= 0.0, 0.0 if part < 0.5 else 1.0, angles)
    slack = 1e-14 * (1 + abs(omega))
    return base + angles.min() - slack, base + angles.max() + slack


def random_moebius(rng):
    a = rng.choice([rng.uniform(0, 1), 1 - 10 ** rng.uniform(-4, -1), 10 ** rng.uniform(-12, -1)])
    omega = rng.choice(
        [rng.uniform(-3, 3), np.arcsin(a) / np.pi, -np.arcsin(a) / np.pi, rng.uniform(-900, 900)]
    )
    near = Fraction(int(rng.integers(-9, 9)), int(rng.integers(1, 9)))
    return a, rng.choice(
        [omega, omega, omega, float(near) + rng.choice([-1, 1]) * 10 ** rng.uniform(-14, -2)]
    )


@pytest.mark.slow
def test_moebius_maps_hold_the_closed_form():
    rng = np.random.default_rng(1)
    drawn = [random_moebius(rng) for _ in range(MOEBIUS)]
    found = judged(
        [CircleMap.moebius(*pair) for pair in drawn], [moebius_truth(*pair) for pair in drawn]
    )
    assert widths(found).max() < 2.01 / ITERATES
    assert np.quantile(widths(found), 0.9) < 1.01 / ITERATES
    assert np.median(widths(found)) < 5e-4
    assert sum(one.locked is not None for one in found) > 100
    assert all(one.locked is None or one.locked.denominator == 1 for one in found)


def sine_enclosures(omega, strength, cycles=3000, start=2.0):
    """[lower, upper] of many sine maps, |K| ≤ 1: orbits of F - 1e-12 and F + 1e-12 bound ρ by
    (whole turns)/n.
    """
    whole = np.floor(omega)
    shift = TWO_PI * (omega - whole)
    low, high = np.full(omega.size, -np.inf), np.full(omega.size, np.inf)
    under, over = np.full(omega.size, start), np.full(omega.size, start)
    for n in range(1, cycles + 1):
        under = under + (shift - 1e-12 - strength * np.sin(under))
        over = over + (shift + 1e-12 - strength * np.sin(over))
        low = np.maximum(low, np.floor((under - start) / TWO_PI) / n)
        high = np.minimum(high, np.ceil((over - start) / TWO_PI) / n)
    inside = np.abs(omega - np.round(omega)) < strength / TWO_PI - 1e-12 * (1 + np.abs(omega))
    known = np.round(omega)
    return np.where(inside, known, whole + low), np.where(inside, known, whole + high)


def random_sine(rng):
    strength = rng.choice(
        [rng.uniform(0, 1), 10 ** rng.uniform(-14, -2), 1 - 10 ** rng.uniform(-9, -1), 1.0]
    )
    near = Fraction(int(rng.integers(-9, 9)), int(rng.integers(1, 9)))
    edge = rng.choice([-1, 1]) * strength / TWO_PI
    omegas = [
        rng.uniform(-2, 2),
        rng.uniform(0, 1),
        edge,
        float(near) + 10 ** rng.uniform(-14, -2),
        float(near),
    ]
    return rng.choice([*omegas, rng.uniform(-1000, 1000)]), strength


@pytest.mark.slow
def test_sine_maps_agree_with_a_longer_independent_enclosure():
    rng = np.random.default_rng(2)
    drawn = np.array([random_sine(rng) for _ in range(SINE)])
    low, high = sine_enclosures(*drawn.T)
    found = judged(
        [CircleMap.arnold(*pair) for pair in drawn.tolist()], list(zip(low, high, strict=True))
    )
    assert np.median(high - low) < 0.3 * np.median(widths(found))
    assert widths(found).max() < 2.01 / ITERATES
    assert np.quantile(widths(found), 0.9) < 1.01 / ITERATES
    assert sum(one.locked is not None for one in found) > 150


def random_contraction(rng):
    """(λ, δ, bounds on ρ): inside a plateau, on its edges to the last bit, or a rounding unit
    beyond.
    """
    slope, ratio = (
        rng.uniform(0.05, 0.95),
        Fraction(int(rng.integers(-15, 30)), int(rng.integers(1, 14))),
    )
    left, right = plateau(Fraction(slope), ratio)
    shift = rng.choice(
        [float(left + (right - left) * Fraction(rng.uniform())), float(left), float(right)]
    )
    shift = float(rng.choice([shift, np.nextafter(shift, np.inf), np.nextafter(shift, -np.inf)]))
    if left <= Fraction(shift) < right:
        return slope, shift, (float(ratio), float(ratio))
    past = Fraction(shift) >= right
    return slope, shift, ((float(ratio), np.inf) if past else (-np.inf, float(ratio)))


@pytest.mark.slow
def test_contractions_hold_their_plateau_of_the_devils_staircase():
    rng = np.random.default_rng(4)
    drawn = [random_contraction(rng) for _ in range(CONTRACTIONS)]
    found = judged(
        [contraction(slope, shift) for slope, shift, _ in drawn], [truth for *_, truth in drawn]
    )
    sure = [one for one, (*_, truth) in zip(found, drawn, strict=True) if truth[0] == truth[1]]
    assert len(sure) > 200
    assert sum(one.locked is not None for one in sure) > 100
    assert np.quantile(widths(found), 0.9) < 0.04
    assert np.median(widths(found)) < 0.005


def contraction_lift(theta, slope, shift):
    turns = np.floor(theta / TWO_PI)
    return slope * (theta - TWO_PI * turns) + TWO_PI * (shift + turns)


@pytest.mark.slow
def test_many_at_once_hold_the_same_truths():
    rng = np.random.default_rng(9)
    moebius = [random_moebius(rng) for _ in range(AT_ONCE)]
    sine = np.array([random_sine(rng) for _ in range(AT_ONCE)])
    jumping = [random_contraction(rng) for _ in range(AT_ONCE)]
    contractions = ParametricLift(contraction_lift, lambda x, slope, _: slope + 0 * x, breaks=[0.0])
    for family, drawn, truth, met in (
        (MOEBIUS_FAMILY, moebius, np.array([moebius_truth(*pair) for pair in moebius]).T, 1.0),
        (ARNOLD_FAMILY, sine, sine_enclosures(*sine.T), 1.0),
        (
            contractions,
            [one[:2] for one in jumping],
            np.array([truth for *_, truth in jumping]).T,
            0.45,
        ),
    ):
        found = rotation_numbers(family, *np.transpose(drawn))
        slack = 1e-15 * np.abs(found.value)
        assert np.all((found.lower - slack <= truth[1]) & (truth[0] <= found.upper + slack))
        assert (
            np.mean(found.upper - found.lower <= 2e-3) >= met
        )  # edges of plateaus are hard to tell
        assert np.sum(found.period > 0) > 180


def tent_interval(slope, shift, period):
    """The rotation interval of ω + tent of slopes ±s, ω = shift/period, by its exact monotone
    envelopes.
    """
    grid = 2 * period

    def rotation(level, begin):
        # On [begin, begin + 1) the envelope is min(s·x, level) + ω; all in multiples of 1/grid.
        x, seen = level, {}
        for n in range(10 * grid):
            turns = (x - begin) // grid
            base = x - turns * grid
            if base in seen:
                start, lap = seen[base]
                return Fraction(turns - lap, n - start)
            seen[base] = (n, turns)
            x = min(slope * base, level) + 2 * shift + turns * grid
        raise AssertionError("no cycle on a finite grid")

    top = period * (slope + 1)
    return rotation(grid, 0), rotation(top, Fraction(top - grid, slope))


def random_tent(rng):
    slope, period = int(rng.integers(2, 6)), int(rng.integers(2, 40))
    shift = int(rng.integers(-2 * period, 3 * period))
    bend, up = TWO_PI * (1 + slope) / (2 * slope), TWO_PI * shift / period
    rising = (0.0, bend, lambda x: slope * x + up, lambda x: np.full_like(x, slope))
    falling = (
        bend,
        TWO_PI,
        lambda x: TWO_PI - slope * (x - TWO_PI) + up,
        lambda x: np.full_like(x, -slope),
    )
    return CircleMap.from_branches([rising, falling]), tent_interval(slope, shift, period)


@pytest.mark.slow
def test_folded_tents_hold_their_exact_rotation_interval():
    rng = np.random.default_rng(6)
    drawn = [random_tent(rng) for _ in range(FOLDED)]
    locked = 0
    for tent, (low, high) in drawn:
        found = rotation_interval(tent, iterates=ITERATES, max_period=100)
        assert found.lower_number.lower <= low <= found.lower_number.upper
        assert found.upper_number.lower <= high <= found.upper_number.upper
        locked += (found.lower_number.locked == low) + (found.upper_number.locked == high)
    assert locked > FOLDED
    for tent, (low, high) in drawn[:20]:
        number = rotation_number(tent, iterates=ITERATES)
        assert number.lower <= low <= high <= number.upper


@pytest.mark.slow
def test_max_error_covers_every_map_that_near():
    """[lower, upper] of F with max_error e holds ρ(F + c) for all |c| ≤ e, and is hardly wider than
    they spread.
    """
    rng = np.random.default_rng(7)
    for _ in range(60):
        omega, strength, error = rng.uniform(0, 1), rng.uniform(0, 1), 10 ** rng.uniform(-6, -2)
        claimed = CircleMap(
            lambda x, o=omega, k=strength: x + TWO_PI * o - k * np.sin(x),
            lambda x, k=strength: 1 - k * np.cos(x),
            max_error=error,
        )
        found = rotation_number(claimed, iterates=600)
        shifts = omega + np.array([-1, -0.7, 0.2, 1]) * error / TWO_PI
        spread = [
            rotation_number(CircleMap.arnold(shift, strength), iterates=600) for shift in shifts
        ]
        for one in spread:
            assert found.lower <= one.upper and one.lower <= found.upper
            assert found.locked is None or found.locked == one.locked
        assert found.lower <= spread[0].lower and spread[-1].upper <= found.upper
        assert found.upper - found.lower <= spread[-1].upper - spread[0].lower + 1e-9


@pytest.mark.parametrize("error", [1e-9, 1e-3])
def test_a_lock_with_max_error_needs_the_whole_band_inside_the_tongue(error):
    edge = 0.9 / TWO_PI
    for omega, inside in ((edge - 2 * error / TWO_PI, True), (edge - 0.5 * error / TWO_PI, False)):
        plain = CircleMap.arnold(omega, 0.9)
        claimed = CircleMap(plain, plain.derivative, max_error=error)
        assert rotation_number(plain, iterates=4000).locked == 0
        assert (rotation_number(claimed, iterates=4000).locked == 0) == inside
