"""Enclosures of rotation numbers against 2,500 random maps whose rotation number is known some
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
from tests.maps.known_maps import TWO_PI, contraction, lines, plateau

ITERATES = 200
MOEBIUS, SINE, CONTRACTIONS, FOLDED, AT_ONCE = 250, 345, 200, 25, 560  # 2,500 together


def judged(maps, truths):
    """Every map's lock and the width of its enclosure, after the check that each holds its truth (a
    pair of bounds on it, as floats).
    """
    found = [rotation_number(circle_map, iterates=ITERATES, max_period=100) for circle_map in maps]
    for one, (low, high) in zip(found, truths, strict=True):
        slack = 1e-15 * abs(low)
        assert one.lower - slack <= high and low <= one.upper + slack
        assert one.lower <= one.value <= one.upper
    return [one.locked for one in found], np.array([one.upper - one.lower for one in found])


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


def near_fraction(rng):
    """A fraction of small denominator, and one a little beside it."""
    ratio = float(Fraction(int(rng.integers(-9, 9)), int(rng.integers(1, 9))))
    return ratio, ratio + rng.choice([-1, 1]) * 10 ** rng.uniform(-14, -2)


def random_moebius(rng):
    a = rng.choice([rng.uniform(0, 1), 1 - 10 ** rng.uniform(-4, -1), 10 ** rng.uniform(-12, -1)])
    edge = rng.choice([-1, 1]) * np.arcsin(a) / np.pi
    return a, rng.choice([rng.uniform(-3, 3), edge, rng.uniform(-900, 900), near_fraction(rng)[1]])


@pytest.mark.slow
def test_moebius_maps_hold_the_closed_form():
    rng = np.random.default_rng(1)
    drawn = [random_moebius(rng) for _ in range(MOEBIUS)]
    maps = [CircleMap.moebius(*pair) for pair in drawn]
    locks, widths = judged(maps, [moebius_truth(*pair) for pair in drawn])
    assert widths.max() < 2.01 / ITERATES and np.quantile(widths, 0.9) < 1.01 / ITERATES
    assert np.median(widths) < 5e-4
    known = [lock for lock in locks if lock is not None]
    assert len(known) > 50 and all(lock.denominator == 1 for lock in known)


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
    known = np.round(omega)
    inside = np.abs(omega - known) < strength / TWO_PI - 1e-12 * (1 + np.abs(omega))
    return np.where(inside, known, whole + low), np.where(inside, known, whole + high)


def random_sine(rng):
    strength = rng.choice(
        [rng.uniform(0, 1), 10 ** rng.uniform(-14, -2), 1 - 10 ** rng.uniform(-9, -1), 1.0]
    )
    edge = rng.choice([-1, 1]) * strength / TWO_PI
    far, near = rng.uniform(-1000, 1000), rng.uniform(-2, 2, 2)
    return rng.choice([far, edge, *near, *near_fraction(rng)]), strength


@pytest.mark.slow
def test_sine_maps_agree_with_a_longer_independent_enclosure():
    rng = np.random.default_rng(2)
    drawn = np.array([random_sine(rng) for _ in range(SINE)])
    low, high = sine_enclosures(*drawn.T)
    maps = [CircleMap.arnold(*pair) for pair in drawn.tolist()]
    locks, widths = judged(maps, list(zip(low, high, strict=True)))
    assert np.median(high - low) < 0.3 * np.median(widths)
    assert widths.max() < 2.01 / ITERATES and np.quantile(widths, 0.9) < 1.01 / ITERATES
    assert sum(lock is not None for lock in locks) > 60


def random_contraction(rng):
    """(λ, δ, bounds on ρ): inside a plateau, on its edges to the last bit, or a rounding unit
    beyond.
    """
    slope = rng.uniform(0.05, 0.95)
    ratio = Fraction(int(rng.integers(-15, 30)), int(rng.integers(1, 14)))
    left, right = plateau(Fraction(slope), ratio)
    inside = float(left + (right - left) * Fraction(rng.uniform()))
    shift = rng.choice([inside, float(left), float(right)])
    shift = float(rng.choice([shift, np.nextafter(shift, np.inf), np.nextafter(shift, -np.inf)]))
    low = float(ratio) if Fraction(shift) >= left else -np.inf
    high = float(ratio) if Fraction(shift) < right else np.inf
    return slope, shift, (low, high)


@pytest.mark.slow
def test_contractions_hold_their_plateau_of_the_devils_staircase():
    rng = np.random.default_rng(4)
    slopes, shifts, truths = zip(
        *(random_contraction(rng) for _ in range(CONTRACTIONS)), strict=True
    )
    locks, widths = judged(map(contraction, slopes, shifts), truths)
    sure = [lock for lock, (low, high) in zip(locks, truths, strict=True) if low == high]
    assert len(sure) > 100 and sum(lock is not None for lock in sure) > 50
    assert np.quantile(widths, 0.9) < 0.04 and np.median(widths) < 0.005


def contraction_lift(theta, slope, shift):
    turns = np.floor(theta / TWO_PI)
    return slope * (theta - TWO_PI * turns) + TWO_PI * (shift + turns)


@pytest.mark.slow
def test_many_at_once_hold_the_same_truths():
    rng = np.random.default_rng(9)
    moebius = [random_moebius(rng) for _ in range(AT_ONCE)]
    moebius_truths = np.transpose([moebius_truth(*pair) for pair in moebius])
    sine = np.array([random_sine(rng) for _ in range(AT_ONCE)])
    slopes, shifts, truths = zip(*(random_contraction(rng) for _ in range(AT_ONCE)), strict=True)
    contractions = ParametricLift(contraction_lift, lambda x, slope, _: slope + 0 * x, breaks=[0.0])
    for family, drawn, (low, high), met in (
        (MOEBIUS_FAMILY, np.transpose(moebius), moebius_truths, 1.0),
        (ARNOLD_FAMILY, sine.T, sine_enclosures(*sine.T), 1.0),
        # edges of plateaus are hard to tell
        (contractions, (slopes, shifts), np.transpose(truths), 0.45),
    ):
        found = rotation_numbers(family, *drawn)
        slack = 1e-15 * np.abs(found.value)
        assert np.all((found.lower - slack <= high) & (low <= found.upper + slack))
        assert np.mean(found.upper - found.lower <= 2e-3) >= met
        assert np.sum(found.period > 0) > 90


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
    tent = lines((0.0, bend, up, slope), (bend, TWO_PI, up + TWO_PI * (1 + slope), -slope))
    return tent, tent_interval(slope, shift, period)


@pytest.mark.slow
def test_folded_tents_hold_their_exact_rotation_interval():
    rng = np.random.default_rng(6)
    locked = 0
    for _ in range(FOLDED):
        tent, (low, high) = random_tent(rng)
        found = rotation_interval(tent, iterates=ITERATES, max_period=100)
        for end, truth in ((found.lower_number, low), (found.upper_number, high)):
            assert end.lower <= truth <= end.upper
            locked += end.locked == truth
        number = rotation_number(tent, iterates=ITERATES)
        assert number.lower <= low <= high <= number.upper
    assert locked > FOLDED


def claimed(omega, strength, error):
    plain = CircleMap.arnold(omega, strength)
    return CircleMap(plain, plain.derivative, max_error=error)


@pytest.mark.slow
def test_max_error_covers_every_map_that_near():
    """[lower, upper] of F with max_error e holds ρ(F + c) for all |c| ≤ e, and is hardly wider than
    they spread.
    """
    rng = np.random.default_rng(7)
    for _ in range(25):
        omega, strength, error = rng.uniform(0, 1), rng.uniform(0, 1), 10 ** rng.uniform(-6, -2)
        found = rotation_number(claimed(omega, strength, error), iterates=600)
        shifts = omega + np.array([-1, 0.2, 1]) * error / TWO_PI
        spread = [rotation_number(CircleMap.arnold(at, strength), iterates=600) for at in shifts]
        for one in spread:
            assert found.lower <= one.upper and one.lower <= found.upper
            assert found.locked is None or found.locked == one.locked
        assert found.lower <= spread[0].lower and spread[-1].upper <= found.upper
        assert found.upper - found.lower <= spread[-1].upper - spread[0].lower + 1e-9


@pytest.mark.parametrize("error", [1e-9, 1e-3])
def test_a_lock_with_max_error_needs_the_whole_band_inside_the_tongue(error):
    edge = 0.9 / TWO_PI
    for omega, inside in ((edge - 2 * error / TWO_PI, True), (edge - 0.5 * error / TWO_PI, False)):
        assert rotation_number(CircleMap.arnold(omega, 0.9), iterates=4000).locked == 0
        found = rotation_number(claimed(omega, 0.9, error), iterates=4000)
        assert (found.locked == 0) == inside
