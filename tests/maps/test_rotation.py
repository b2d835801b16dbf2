"""Rotation numbers: enclosures that hold the truth, proofs of locking, intervals of folded lifts."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import (
    CircleMap,
    is_nondecreasing,
    lower_envelope,
    periodic_orbits,
    rotation_interval,
    rotation_number,
    upper_envelope,
)
from cyclemap.maps.rotation import simplest_between

TWO_PI = 2 * np.pi
GRID = np.linspace(-9.0, 9.0, 4001)


def moebius_rotation(a, omega):
    """ρ of the Möbius map in turns; its trace in PSU(1, 1) is 2 cos(πω)/√(1 - a²)."""
    half_trace = np.cos(np.pi * omega) / np.sqrt(1 - a * a)
    return 0.0 if abs(half_trace) >= 1 else float(np.arccos(half_trace) / np.pi)


def contraction(slope, shift):
    def lift(x):
        turns = np.floor(x / TWO_PI)
        return slope * (x - TWO_PI * turns) + TWO_PI * (shift + turns)

    return CircleMap(lift, lambda x: np.full_like(x, slope), [0.0])


KNOWN = [
    (CircleMap.moebius(0.5, 0.3), 0.262536755898823346733597549046),
    (CircleMap.moebius(0.9, 0.45), 0.383156928981311432564754399638),
    (CircleMap.arnold(0.6, 0.5), 0.602894830374585070928578946844),
]


@pytest.mark.parametrize(("circle_map", "truth"), KNOWN)
def test_known_rotation_numbers_to_fourteen_digits(circle_map, truth):
    found = rotation_number(circle_map)
    assert abs(found.value - truth) < 1e-14
    assert found.lower <= truth <= found.upper
    assert found.upper - found.lower < 1e-8
    assert found.locked is None


def test_the_enclosure_holds_for_four_hundred_random_moebius_maps():
    rng = np.random.default_rng(20)
    held = locked = 0
    for _ in range(400):
        a, omega = rng.uniform(0, 0.99), rng.uniform(0, 1)
        truth = moebius_rotation(a, omega) if omega <= 0.5 else 1 - moebius_rotation(a, 1 - omega)
        found = rotation_number(CircleMap.moebius(a, omega), iterates=1500)
        assert found.lower - 1e-15 <= truth <= found.upper + 1e-15
        assert found.lower <= found.value <= found.upper
        locked += found.locked is not None
        held += 1
    assert held == 400
    assert locked > 50


def test_moebius_locks_exactly_where_theory_says():
    rng = np.random.default_rng(21)
    checked = 0
    for _ in range(60):
        a, omega = rng.uniform(0.1, 0.9), rng.uniform(0, 0.5)
        if abs(np.sin(np.pi * omega) - a) < 1e-3:
            continue
        found = rotation_number(CircleMap.moebius(a, omega), iterates=2000)
        # A rational rotation number is no locking here: the only tongue is 0/1.
        assert (found.locked == 0) == (np.sin(np.pi * omega) < a)
        checked += 1
    assert checked >= 55


@pytest.mark.parametrize(
    ("left", "right", "strength", "ratio"),
    [
        (-0.9 / TWO_PI, 0.9 / TWO_PI, 0.9, Fraction(0)),
        (0.46301722338218515819, 1 - 0.46301722338218515819, 1.0, Fraction(1, 2)),
        (0.46966533712136485155, 1 - 0.46966533712136485155, 0.9, Fraction(1, 2)),
        (0.33666500673073392497, 0.36722449875089161199, 1.0, Fraction(1, 3)),
    ],
)
def test_tongues_of_the_sine_map(left, right, strength, ratio):
    for omega in (left + 1e-7, 0.5 * (left + right), right - 1e-7):
        found = rotation_number(CircleMap.arnold(omega, strength))
        assert found.locked == ratio
        assert found.lower <= float(ratio) <= found.upper
        assert periodic_orbits(CircleMap.arnold(omega, strength), ratio.denominator, ratio.numerator)
    for omega, side in ((left - 1e-4, -1), (right + 1e-4, 1)):
        found = rotation_number(CircleMap.arnold(omega, strength))
        assert found.locked != ratio
        assert (found.value - float(ratio)) * side > 0


def test_at_a_tongue_edge_the_bounds_still_hold():
    found = rotation_number(CircleMap.arnold(0.9 / TWO_PI, 0.9))
    assert found.lower <= 0.0 <= found.upper
    assert found.upper < 1e-4


def test_piecewise_contractions_have_the_rotation_number_of_their_devils_staircase():
    """Right edge of the plateau ρ: (1 - λ)(1 + Σ_k (⌊(k+1)ρ⌋ - ⌊kρ⌋) λ^k)."""
    slope, checked = 0.6, 0
    for ratio in (Fraction(1, 2), Fraction(1, 3), Fraction(2, 5), Fraction(3, 7), Fraction(5, 8)):
        k = np.arange(200)
        whole = np.array([int((i + 1) * ratio) - int(i * ratio) for i in range(200)])
        right = (1 - slope) * (1 + np.sum(whole * slope**k))
        inside = rotation_number(contraction(slope, right - 1e-6))
        beyond = rotation_number(contraction(slope, right + 1e-6))
        assert inside.locked == ratio
        assert beyond.lower > float(ratio)
        checked += 1
    assert checked == 5


def test_rigid_rotations():
    for turns in (np.sqrt(2) - 1, 0.25, -1.75, 1 / 3, 12.1):
        found = rotation_number(CircleMap.rigid(turns))
        assert found.lower <= turns <= found.upper
        assert abs(found.value - turns) < 1e-13


def test_conjugation_and_whole_turns_leave_it_unchanged():
    sine = CircleMap.arnold(0.37, 0.8)
    plain = rotation_number(sine)
    moved = rotation_number(CircleMap(lambda x: sine(x - 1.1) + 1.1, lambda x: sine.derivative(x - 1.1)))
    lifted = rotation_number(CircleMap.arnold(2.37, 0.8))
    assert abs(plain.value - moved.value) < 1e-12
    assert abs(plain.value + 2 - lifted.value) < 1e-12


def test_the_rotation_number_grows_with_the_map():
    omegas = np.linspace(0, 1, 60)
    found = [rotation_number(CircleMap.arnold(omega, 0.95), iterates=2000) for omega in omegas]
    for one, other in pairwise(found):
        assert one.lower <= other.upper
    assert found[0].locked == 0
    assert found[-1].locked == 1


@pytest.mark.parametrize(
    ("omega", "strength", "lower", "upper"),
    [(0.5, 3.0, Fraction(1, 6), Fraction(5, 6)), (0.3, 3.0, Fraction(0), Fraction(1, 2))],
)
def test_rotation_intervals_of_folded_sine_maps(omega, strength, lower, upper):
    sine = CircleMap.arnold(omega, strength)
    found = rotation_interval(sine)
    assert (found.lower_number.locked, found.upper_number.locked) == (lower, upper)
    number = rotation_number(sine)
    assert number.lower <= float(lower) <= number.value <= float(upper) <= number.upper


def test_every_periodic_orbit_lies_in_the_rotation_interval():
    checked = 0
    for omega in (0.1, 0.3, 0.62):
        sine = CircleMap.arnold(omega, 3.0)
        interval = rotation_interval(sine)
        for period in range(1, 6):
            for orbit in periodic_orbits(sine, period):
                assert interval.lower_number.lower <= orbit.winding / period <= interval.upper_number.upper
                checked += 1
    assert checked > 30


def test_envelopes_are_the_nearest_monotone_maps():
    jumping = CircleMap.from_samples([0, 2, 2, 4, 6], [1, 2.5, 1.5, 4.2, 6.9], [1.0] * 5)
    for folded in (CircleMap.arnold(0.3, 3.0), CircleMap.arnold(0.1, 7.5), jumping):
        values = folded(GRID)
        upper, lower = upper_envelope(folded), lower_envelope(folded)
        running = np.maximum.accumulate(folded(np.linspace(-20, 9.0, 60001)))
        np.testing.assert_allclose(upper(np.linspace(-20, 9.0, 60001))[20000:], running[20000:], atol=4e-3)
        assert np.all(upper(GRID) >= values - 1e-12)
        assert np.all(lower(GRID) <= values + 1e-12)
        for envelope in (upper, lower):
            assert np.all(np.diff(envelope(GRID)) >= -1e-12)
            np.testing.assert_allclose(envelope(GRID + TWO_PI), envelope(GRID) + TWO_PI, atol=1e-12)
            one = envelope.scalar()
            np.testing.assert_allclose([one(x) for x in GRID[::40]], envelope(GRID[::40]), atol=1e-12)
        assert not is_nondecreasing(folded)
        assert is_nondecreasing(upper)


def test_a_monotone_map_is_its_own_envelope():
    sine = CircleMap.arnold(0.3, 0.9)
    assert upper_envelope(sine) is sine
    assert lower_envelope(sine) is sine


def test_simplest_fraction_has_the_smallest_denominator():
    rng = np.random.default_rng(3)
    checked = 0
    for _ in range(200):
        low = Fraction(int(rng.integers(-300, 300)), int(rng.integers(1, 60)))
        high = low + Fraction(1, int(rng.integers(1, 400)))
        found = simplest_between(low, high)
        assert low <= found <= high
        for q in range(1, found.denominator):
            assert -(-low * q // 1) > high * q
        checked += 1
    assert checked == 200


def test_other_degrees_and_bad_counts_are_refused():
    doubling = CircleMap(lambda x: 2 * x, degree=2)
    for ask in (rotation_number, rotation_interval, upper_envelope, lower_envelope):
        with pytest.raises(InvalidInput, match="degree"):
            ask(doubling)
    with pytest.raises(InvalidInput):
        rotation_number(CircleMap.rigid(0.1), iterates=0)
