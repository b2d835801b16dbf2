"""Rotation numbers of many maps at once, and over planes of parameters: phase diagrams."""

import threading
from fractions import Fraction

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import (
    ARNOLD_FAMILY,
    MOEBIUS_FAMILY,
    CircleMap,
    ParametricLift,
    rotation_numbers,
    rotation_plane,
)
from tests.maps.known_maps import plateau

TWO_PI = 2 * np.pi


def moebius_truth(a, omega):
    """ρ of Möbius maps, 0 ≤ Ω < 1: cos πρ = cos πΩ/√(1 - a²) off the tongue; its sine has the root's sign."""
    beyond = np.maximum((np.sin(np.pi * omega) - a) * (np.sin(np.pi * omega) + a), 0.0)
    angles = np.arctan2(np.sqrt(beyond), np.cos(np.pi * omega)) / np.pi
    return np.where(beyond == 0.0, np.round(omega), angles)


def test_a_hundred_thousand_moebius_maps_hold_the_closed_form():
    rng = np.random.default_rng(0)
    a, omega = rng.uniform(0, 1, 100_000), rng.uniform(0, 1, 100_000)
    found, truth = rotation_numbers(MOEBIUS_FAMILY, a, omega, tolerance=3e-3), moebius_truth(a, omega)
    assert np.all((found.lower <= truth + 1e-7) & (truth - 1e-7 <= found.upper))
    sure = np.abs(np.sin(np.pi * omega) - a) > 1e-9
    assert np.all(((found.lower <= truth + 1e-13) & (truth - 1e-13 <= found.upper))[sure])
    assert np.all(np.abs(found.value - truth) <= 3e-3 + 1e-7)
    # The only tongue is 0/1, and nearly all of it is proved.
    locked, inside = found.period > 0, np.sin(np.pi * omega) < a
    assert np.all(inside[locked] & (found.period[locked] == 1))
    assert np.mean(locked[inside]) > 0.95


def contraction_family(slope):
    def lift(theta, shift):
        turns = np.floor(theta / TWO_PI)
        return slope * (theta - TWO_PI * turns) + TWO_PI * (shift + turns)

    return ParametricLift(lift, lambda theta, shift: slope + 0.0 * theta * shift, breaks=[0.0])


def test_contractions_with_a_jump_hold_their_staircase():
    ratios = [Fraction(p, q) for q in range(1, 9) for p in range(q) if np.gcd(p, q) == 1]
    left, right = np.array([plateau(0.7, ratio) for ratio in ratios]).T
    truth = np.array([float(ratio) for ratio in ratios])
    assert len(ratios) == 22
    assert np.all(right - left > 0.7**8 * 0.09)
    for share in (1e-3, 0.3, 0.7, 1 - 1e-3):
        found = rotation_numbers(contraction_family(0.7), left + share * (right - left), tolerance=5e-4)
        assert np.all((found.lower <= truth) & (truth <= found.upper))
        assert np.all(found.upper - found.lower <= 1e-3)
        proved = [Fraction(int(p), int(q)) if q else None for p, q in zip(found.winding, found.period, strict=True)]
        assert all(a in (None, b) for a, b in zip(proved, ratios, strict=True))
        assert sum(a == b for a, b in zip(proved, ratios, strict=True)) >= 8
    beyond = rotation_numbers(contraction_family(0.7), right + 1e-5)
    assert np.all(beyond.upper > truth)


def test_a_claimed_error_widens_the_enclosures_and_unmet_ones_say_so():
    loose = ParametricLift(ARNOLD_FAMILY.lift, nondecreasing=ARNOLD_FAMILY.nondecreasing, max_error=0.05)
    omega = np.linspace(0.2, 0.8, 200)
    wide, plain = rotation_numbers(loose, omega, 0.6), rotation_numbers(ARNOLD_FAMILY, omega, 0.6)
    for shift in (-0.05, 0.05):
        moved = rotation_numbers(ARNOLD_FAMILY, omega + shift / TWO_PI, 0.6)
        assert np.all((wide.lower <= moved.upper) & (moved.lower <= wide.upper))
    assert np.all(plain.upper - plain.lower <= 2e-3)
    assert np.min((wide.upper - wide.lower)[plain.period == 0]) > 2e-3
    assert np.median(wide.upper - wide.lower) < 0.025


def test_the_number_of_threads_and_the_batch_do_not_change_a_number():
    rng = np.random.default_rng(2)
    omega, strength = rng.uniform(0, 1, 9000), rng.uniform(0, 1, 9000)
    before = threading.active_count()
    many = rotation_numbers(ARNOLD_FAMILY, omega, strength, threads=3)
    single = rotation_numbers(ARNOLD_FAMILY, omega, strength, threads=1)
    part = rotation_numbers(ARNOLD_FAMILY, omega[5000:5100], strength[5000:5100])
    for name in ("value", "lower", "upper", "period", "winding"):
        np.testing.assert_array_equal(getattr(many, name), getattr(single, name))
        np.testing.assert_array_equal(getattr(many, name)[5000:5100], getattr(part, name))
    assert threading.active_count() == before


def test_shapes_broadcast_down_to_a_single_number():
    one = rotation_numbers(ARNOLD_FAMILY, 0.6, 0.5)
    assert one.value.shape == ()
    assert abs(one.value - 0.602894830374585) < 1e-3
    none = rotation_numbers(ARNOLD_FAMILY, np.zeros(0), 0.5)
    assert none.value.shape == (0,)
    grid = rotation_numbers(ARNOLD_FAMILY, np.zeros((3, 1)), np.full(4, 0.5))
    assert grid.period.tolist() == [[1] * 4] * 3


def test_a_parametric_lift_gives_circle_maps():
    waves = ParametricLift(
        lambda x, shift, size: x + shift + size * np.sin(2 * x),
        lambda x, shift, size: 1 + 2 * size * np.cos(2 * x),
        breaks=[1.0],
        max_error=1e-6,
    )
    member = waves(0.3, 0.2)
    assert isinstance(member, CircleMap)
    assert member.max_error == 1e-6
    assert member.breaks.tolist() == [1.0]
    np.testing.assert_allclose(member.derivative(np.array([0.1, 4.0])), 1 + 0.4 * np.cos([0.2, 8.0]))
    assert waves.rises(np.zeros(3), np.array([0.2, 0.49, 0.7])).tolist() == [True, True, False]
    rng = np.random.default_rng(3)
    theta = rng.uniform(-9, 9, 50)
    for family, pair in ((ARNOLD_FAMILY, (0.3, -1.7)), (MOEBIUS_FAMILY, (0.6, 0.2))):
        np.testing.assert_allclose(family.lift(theta, *pair), family(*pair)(theta), atol=1e-14)
        np.testing.assert_allclose(family.derivative(theta, *pair), family(*pair).derivative(theta), rtol=1e-13)


def one_by_one(omega, K):
    """The sine family as a callable whose formula is not known."""
    return CircleMap.arnold(omega, K)


def test_many_at_once_and_map_by_map_agree():
    omegas, strengths = np.linspace(0.05, 0.95, 13), np.linspace(0.1, 1.0, 5)
    together = rotation_plane(ARNOLD_FAMILY, omegas, strengths)
    singly = rotation_plane(one_by_one, omegas, strengths)
    assert together.value.shape == singly.value.shape == (13, 5)
    for plane in (together, singly):
        assert np.all(plane.upper - plane.lower <= 2e-3 * (1 + 1e-9))
        assert np.all((plane.lower <= plane.value) & (plane.value <= plane.upper))
        assert not np.any(plane.folded)
    assert np.all((together.lower <= singly.upper) & (singly.lower <= together.upper))
    both = (together.period > 0) & (singly.period > 0)
    assert np.sum(both) > 10
    assert np.all((together.winding == singly.winding)[both] & (together.period == singly.period)[both])


@pytest.mark.parametrize(("family", "known"), [(CircleMap.arnold, ARNOLD_FAMILY), (CircleMap.moebius, MOEBIUS_FAMILY)])
def test_the_textbook_maps_are_recognised_and_done_many_at_once(family, known):
    first, second = np.linspace(0.1, 0.9, 9), np.linspace(0.1, 0.6, 7)
    plane, other = rotation_plane(family, first, second), rotation_plane(known, first, second)
    for name in ("value", "lower", "upper", "period", "winding"):
        np.testing.assert_array_equal(getattr(plane, name), getattr(other, name))
    np.testing.assert_array_equal(rotation_numbers(family, first, 0.5).value, rotation_numbers(known, first, 0.5).value)


@pytest.mark.parametrize("family", [ARNOLD_FAMILY, one_by_one])
def test_folded_maps_show_their_rotation_interval(family):
    """(Ω .5, K 3) has [1/6, 5/6] and (.3, 3) has [0, 1/2]; K = .5 beside them does not fold."""
    plane = rotation_plane(family, [0.3, 0.5], [0.5, 3.0], tolerance=5e-3)
    assert plane.folded.tolist() == [[False, True], [False, True]]
    np.testing.assert_allclose(plane.lower[:, 1], [0, 1 / 6], atol=1e-15)
    np.testing.assert_allclose(plane.upper[:, 1], [1 / 2, 5 / 6], atol=1e-15)
    assert np.all((plane.lower <= plane.value) & (plane.value <= plane.upper))
    assert np.all(plane.period[:, 1] == 0)


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: rotation_numbers(ARNOLD_FAMILY, 0.5, [0.3, 1.2]), r"\(0.5, 1.2\).*nondecreasing.*rotation_interval"),
        (lambda: rotation_numbers(ParametricLift(lambda x, p: x + p * np.sin(x)), [0.2, 1.5]), "nondecreasing"),
        (lambda: rotation_numbers(ParametricLift(lambda x, p: 2 * x + p), [0.2]), "nondecreasing lift of degree 1"),
        (lambda: rotation_numbers(ParametricLift(lambda x, p: np.zeros(3)), [0.2]), "broadcast"),
        (lambda: rotation_numbers(ARNOLD_FAMILY, 0.1, [0.2, np.nan]), "parameter 1 must be finite"),
        (lambda: rotation_numbers(lambda x, p: x + p, 0.1, 0.2), "ParametricLift"),
        (lambda: rotation_numbers(ARNOLD_FAMILY), "parameters"),
        (lambda: rotation_numbers(ARNOLD_FAMILY, 0.1, 0.2, tolerance=0.0), "tolerance"),
        (lambda: rotation_numbers(ARNOLD_FAMILY, 0.1, 0.2, tolerance=0.2), "tolerance"),
        (lambda: rotation_numbers(ARNOLD_FAMILY, 0.1, 0.2, threads=0), "threads"),
        (lambda: ParametricLift(None), "lift"),
        (lambda: ParametricLift(np.add, 3.0), "derivative"),
        (lambda: ParametricLift(np.add, max_error=-1.0), "max_error"),
        (lambda: rotation_plane(ARNOLD_FAMILY, [0.1, np.nan], [0.1]), "first_values must be finite"),
        (lambda: rotation_plane(ARNOLD_FAMILY, [0.1], []), "second_values is empty"),
        (lambda: rotation_plane(ARNOLD_FAMILY, [0.1, 0.3, 0.2], [0.1]), "turns back"),
        (lambda: rotation_plane(ARNOLD_FAMILY, [0.1, 0.1], [0.1]), "turns back"),
        (lambda: rotation_plane(ARNOLD_FAMILY, [[0.1]], [0.1]), "axes"),
        (lambda: rotation_plane(ARNOLD_FAMILY, [0.1], [0.1], tolerance=0.2), "tolerance"),
        (lambda: rotation_plane(None, [0.1], [0.1]), "callable"),
        (lambda: rotation_plane(lambda p, q: CircleMap(lambda x: 2 * x, degree=2), [0.1], [0.1]), "degree 1"),
        (lambda: rotation_plane(lambda p, q: p + q, [0.1], [0.1]), "must be a CircleMap"),
    ],
)
def test_what_has_no_rotation_numbers_is_refused(ask, words):
    with pytest.raises(InvalidInput, match=words):
        ask()
