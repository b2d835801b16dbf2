"""Rotation numbers: enclosures that hold the truth, proofs of locking, intervals of folded
lifts.
"""

from fractions import Fraction

import numpy as np
import pytest

from cyclemap.errors import ConvergenceError
from cyclemap.maps import (
    CircleMap,
    is_nondecreasing,
    lower_envelope,
    periodic_orbits,
    rotation_interval,
    rotation_number,
    upper_envelope,
)
from cyclemap.maps.orbits.rotation_number import largest_descent
from tests.maps.known_maps import KNOWN_TURNS, TWO_PI, agree
from tests.refusals import refused

GRID = np.linspace(-9.0, 9.0, 4001)


@pytest.mark.parametrize(("circle_map", "truth"), KNOWN_TURNS)
def test_known_rotation_numbers_to_fourteen_digits(circle_map, truth):
    found = rotation_number(circle_map)
    assert abs(found.value - truth) < 1e-14
    assert found.lower <= truth <= found.upper < found.lower + 1e-8
    assert (found.locked, found.proof) == (None, None)
    assert abs(found.estimate - truth) <= found.estimate.error_bound < 1e-14


@pytest.mark.slow
def test_the_proof_of_locking_holds_in_extended_precision_and_its_orbit_lies_between():
    """F^q - id - 2πp, evaluated anew, is negative at ``below`` and positive at ``above``."""
    rng = np.random.default_rng(8)
    two_pi, checked = 2 * np.arccos(np.longdouble(-1)), 0
    for _ in range(60):
        omega, strength = rng.uniform(-1, 2), rng.choice([1.0, rng.uniform(0.5, 1)])
        found = rotation_number(CircleMap.arnold(omega, strength), iterates=3000)
        if found.locked is None:
            continue
        p, q = found.locked.numerator, found.locked.denominator
        start = theta = np.array([found.proof.below, found.proof.above], dtype=np.longdouble)
        for _ in range(q):
            shift = two_pi * np.longdouble(omega)
            theta = theta + shift - np.longdouble(strength) * np.sin(theta)
        below, above = theta - start - two_pi * p
        assert below < 0 < above
        assert (found.proof.ratio, found.estimate) == (found.locked, None)
        orbits = periodic_orbits(CircleMap.arnold(omega, strength), q, p) if q < 6 else []
        stable = [orbit.points for orbit in orbits if orbit.stable]
        if stable:
            ahead = np.mod(np.append(stable, found.proof.below) - found.proof.above, TWO_PI)
            assert np.min(ahead[:-1]) < ahead[-1]
            checked += 1
    assert checked > 20


def test_a_locked_folded_map_has_a_proof_too():
    sine = CircleMap.arnold(0.0, 1.3)
    found = rotation_number(sine)
    assert found.locked == 0
    assert sine.turn(found.proof.below) < 0.0 < sine.turn(found.proof.above)


def test_a_tolerance_saves_iterates():
    """The lift is asked about once an iterate and orbit: far less often when two digits are
    enough.
    """
    asked = []

    def scalar(theta):
        asked.append(theta)
        return theta + 2.1 - 0.5 * np.sin(theta)

    sine = CircleMap.with_scalar(
        lambda x: x + 2.1 - 0.5 * np.sin(x), lambda x: 1 - 0.5 * np.cos(x), scalar
    )
    full = rotation_number(sine, iterates=4000)
    long, asked[:] = len(asked), []
    short = rotation_number(sine, iterates=4000, tolerance=0.01)
    assert len(asked) < long / 10
    assert short.upper - short.lower <= 0.02
    assert short.lower <= full.lower <= full.upper <= short.upper


def test_a_fold_too_narrow_to_be_seen_is_found_out_by_bounds_that_contradict_each_other():
    """One orbit falls into a slit 1e-5 wide right at its first image, the other passes beside
    it.
    """

    def slit(x):
        base = np.mod(x, TWO_PI)
        return x + 2.4 - 2.0 * ((base >= 2.4) & (base < 2.4 + 1e-5))

    ask = CircleMap(slit, np.ones_like)
    refused(rotation_number, ask, iterates=2000, kind=ConvergenceError, told="folds unseen")


@pytest.mark.parametrize(
    ("omega", "lower", "upper"),
    [(0.5, Fraction(1, 6), Fraction(5, 6)), (0.3, Fraction(0), Fraction(1, 2))],
)
def test_rotation_intervals_of_folded_sine_maps(omega, lower, upper):
    sine = CircleMap.arnold(omega, 3.0)
    found = rotation_interval(sine)
    assert (found.lower_number.locked, found.upper_number.locked) == (lower, upper)
    number = rotation_number(sine)
    assert number.lower <= float(lower) <= number.value <= float(upper) <= number.upper


def test_envelopes_are_the_nearest_monotone_maps():
    jumping = CircleMap.from_samples([0, 2, 2, 4, 6], [1, 2.5, 1.5, 4.2, 6.9], [1.0] * 5)
    for folded in (CircleMap.arnold(0.3, 3.0), CircleMap.arnold(0.1, 7.5), jumping):
        upper, lower = upper_envelope(folded), lower_envelope(folded)
        fine = np.linspace(-20, 9.0, 60001)
        running = np.maximum.accumulate(folded(fine))
        agree(upper(fine[20000:]), running[20000:], 4e-3)
        assert np.all(upper(GRID) >= folded(GRID) - 1e-12)
        assert np.all(lower(GRID) <= folded(GRID) + 1e-12)
        for envelope in (upper, lower):
            assert np.all(np.diff(envelope(GRID)) >= -1e-12)
            agree(envelope(GRID + TWO_PI), envelope(GRID) + TWO_PI, 1e-12)
            agree([envelope.scalar()(x) for x in GRID[::40]], envelope(GRID[::40]), 1e-12)
        assert not is_nondecreasing(folded) and is_nondecreasing(upper)


def test_the_largest_descent_is_that_of_theory():
    """Sine maps fall from -arccos(1/K) to arccos(1/K), by 2√(K² - 1) - 2 arccos(1/K); jumps by
    their height.
    """
    for strength in (1.0, 1.5, 9.0):
        theory = 2 * np.sqrt(strength**2 - 1) - 2 * np.arccos(1 / strength)
        assert abs(largest_descent(CircleMap.arnold(0.3, strength)) - theory) < 1e-12
    for height in (-0.3, 0.4):
        sawtooth = CircleMap.from_samples([0, 2, 2, 4], [0, 2, 2 + height, 4], [0.5] * 4)
        assert abs(largest_descent(sawtooth) - max(0.0, -height)) < 0.05 + 1e-12


def test_envelopes_claim_the_error_of_their_levels():
    """Fold levels against the closed form of the sine map's extrema, F(∓arccos(1/K))."""
    folded = CircleMap.arnold(0.3, 3.0)
    raised, lowered = upper_envelope(folded), lower_envelope(folded)
    top = TWO_PI * 0.3 + np.sqrt(8) - np.arccos(1 / 3)
    assert abs(raised(0.0) - top) <= raised.max_error + 4e-16
    assert abs(lowered(0.0) - (TWO_PI * 0.6 - top)) <= lowered.max_error + 4e-16
    assert 0.0 < raised.max_error < 1e-13
    sine = CircleMap.arnold(0.3, 0.9)  # which does not fold is its own envelope
    assert upper_envelope(sine) is sine and lower_envelope(sine) is sine
