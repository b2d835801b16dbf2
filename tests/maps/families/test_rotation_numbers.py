"""Rotation numbers of many maps at once, and over planes of parameters: phase diagrams."""

import threading

import numpy as np
import pytest

from cyclemap.maps import (
    ARNOLD_FAMILY,
    MOEBIUS_FAMILY,
    CircleMap,
    ParametricLift,
    rotation_interval,
    rotation_numbers,
    rotation_plane,
)

TWO_PI = 2 * np.pi


def test_a_claimed_error_widens_the_enclosures_and_unmet_ones_say_so():
    loose = ParametricLift(
        ARNOLD_FAMILY.lift, nondecreasing=ARNOLD_FAMILY.nondecreasing, max_error=0.05
    )
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
    assert rotation_numbers(ARNOLD_FAMILY, np.zeros(0), 0.5).value.shape == (0,)
    many = rotation_numbers(ARNOLD_FAMILY, omega, strength, threads=3)
    single = rotation_numbers(ARNOLD_FAMILY, omega, strength, threads=1)
    part = rotation_numbers(ARNOLD_FAMILY, omega[5000:5100], strength[5000:5100])
    for name in ("value", "lower", "upper", "period", "winding"):
        np.testing.assert_array_equal(getattr(many, name), getattr(single, name))
        np.testing.assert_array_equal(getattr(many, name)[5000:5100], getattr(part, name))
    assert threading.active_count() == before


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
    np.testing.assert_allclose(
        member.derivative(np.array([0.1, 4.0])), 1 + 0.4 * np.cos([0.2, 8.0])
    )
    assert waves.rises(np.zeros(3), np.array([0.2, 0.49, 0.7])).tolist() == [True, True, False]
    rng = np.random.default_rng(3)
    theta = rng.uniform(-9, 9, 50)
    for family, pair in ((ARNOLD_FAMILY, (0.3, -1.7)), (MOEBIUS_FAMILY, (0.6, 0.2))):
        np.testing.assert_allclose(family.lift(theta, *pair), family(*pair)(theta), atol=1e-14)
        np.testing.assert_allclose(
            family.derivative(theta, *pair), family(*pair).derivative(theta), rtol=1e-13
        )


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
    assert np.all(
        (together.winding == singly.winding)[both] & (together.period == singly.period)[both]
    )


@pytest.mark.parametrize(
    ("family", "known"), [(CircleMap.arnold, ARNOLD_FAMILY), (CircleMap.moebius, MOEBIUS_FAMILY)]
)
def test_the_textbook_maps_are_recognised_and_done_many_at_once(family, known):
    first, second = np.linspace(0.1, 0.9, 9), np.linspace(0.1, 0.6, 7)
    plane, other = rotation_plane(family, first, second), rotation_plane(known, first, second)
    for name in ("value", "lower", "upper", "period", "winding"):
        np.testing.assert_array_equal(getattr(plane, name), getattr(other, name))
    np.testing.assert_array_equal(
        rotation_numbers(family, first, 0.5).value, rotation_numbers(known, first, 0.5).value
    )


@pytest.mark.parametrize("family", [ARNOLD_FAMILY, one_by_one])
def test_folded_maps_show_their_rotation_interval(family):
    """(Ω .5, K 3) has [1/6, 5/6] and (.3, 3) has [0, 1/2]; K = .5 beside them does not fold."""
    plane = rotation_plane(family, [0.3, 0.5], [0.5, 3.0], tolerance=5e-3)
    assert plane.folded.tolist() == [[False, True], [False, True]]
    np.testing.assert_allclose(plane.lower[:, 1], [0, 1 / 6], atol=1e-15)
    np.testing.assert_allclose(plane.upper[:, 1], [1 / 2, 5 / 6], atol=1e-15)
    assert np.all((plane.lower <= plane.value) & (plane.value <= plane.upper))
    assert np.all(plane.period[:, 1] == 0)


def test_a_plane_of_folded_maps_encloses_what_each_map_gives_by_itself():
    """Both bounds hold the whole rotation interval, which the maps one by one know far better;
    progress reaches 1.
    """
    told = []
    first, second = np.linspace(0.05, 0.95, 4), np.array([0.8, 1.3, 2.0, 3.0])
    plane = rotation_plane(CircleMap.arnold, first, second, progress=told.append)
    assert np.array_equal(plane.folded, np.broadcast_to(second > 1.0, (4, 4)))
    assert told == sorted(told) and told[-1] == 1.0
    for i, omega in enumerate(first):
        for j in range(1, 4):
            interval = rotation_interval(CircleMap.arnold(omega, second[j]), iterates=4_000)
            assert plane.lower[i, j] <= interval.lower_number.upper
            assert plane.upper[i, j] >= interval.upper_number.lower
            assert plane.lower[i, j] >= interval.lower - 2.1e-3
            assert plane.upper[i, j] <= interval.upper + 2.1e-3
            assert plane.lower[i, j] <= plane.value[i, j] <= plane.upper[i, j]
