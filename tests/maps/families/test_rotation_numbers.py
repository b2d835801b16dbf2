"""Families: many maps at once, planes of parameters, executors, and how lifts move."""

import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

from cyclemap.maps import (
    ARNOLD_FAMILY,
    MOEBIUS_FAMILY,
    CircleMap,
    ParametricLift,
    bifurcation_curves,
    lyapunov_exponents,
    rotation_interval,
    rotation_numbers,
    rotation_plane,
    tongues,
)
from cyclemap.maps.families.family import parameter_tangent

TWO_PI = 2 * np.pi
ROTATION = ("value", "lower", "upper", "period", "winding")


def one_by_one(omega, K):
    """The sine family as a callable whose formula is not known."""
    return CircleMap.arnold(omega, K)


def enclosed(plane):
    return np.all((plane.lower <= plane.value) & (plane.value <= plane.upper))


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
    omega, strength = np.random.default_rng(2).uniform(0, 1, (2, 9000))
    before = threading.active_count()
    assert rotation_numbers(ARNOLD_FAMILY, np.zeros(0), 0.5).value.shape == (0,)
    many = rotation_numbers(ARNOLD_FAMILY, omega, strength, threads=3)
    single = rotation_numbers(ARNOLD_FAMILY, omega, strength, threads=1)
    part = rotation_numbers(ARNOLD_FAMILY, omega[5000:5100], strength[5000:5100])
    for name in ROTATION:
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
    assert (member.max_error, member.breaks.tolist()) == (1e-6, [1.0])
    assert member.derivative(4.0) == pytest.approx(1 + 0.4 * np.cos(8.0))
    assert waves.rises(np.zeros(3), np.array([0.2, 0.49, 0.7])).tolist() == [True, True, False]
    theta = np.random.default_rng(3).uniform(-9, 9, 50)
    for family, pair in ((ARNOLD_FAMILY, (0.3, -1.7)), (MOEBIUS_FAMILY, (0.6, 0.2))):
        member, slopes = family(*pair), family.derivative(theta, *pair)
        np.testing.assert_allclose(family.lift(theta, *pair), member(theta), atol=1e-14)
        np.testing.assert_allclose(slopes, member.derivative(theta), rtol=1e-13)


def test_many_at_once_and_map_by_map_agree():
    omegas, strengths = np.linspace(0.05, 0.95, 13), np.linspace(0.1, 1.0, 5)
    together = rotation_plane(ARNOLD_FAMILY, omegas, strengths)
    singly = rotation_plane(one_by_one, omegas, strengths)
    assert together.value.shape == singly.value.shape == (13, 5)
    for plane in (together, singly):
        assert np.all(plane.upper - plane.lower <= 2e-3 * (1 + 1e-9))
        assert enclosed(plane)
        assert not np.any(plane.folded)
    assert np.all((together.lower <= singly.upper) & (singly.lower <= together.upper))
    both = (together.period > 0) & (singly.period > 0)
    assert np.sum(both) > 10
    assert np.array_equal(together.winding[both], singly.winding[both])
    assert np.array_equal(together.period[both], singly.period[both])


@pytest.mark.parametrize(
    ("family", "known"), [(CircleMap.arnold, ARNOLD_FAMILY), (CircleMap.moebius, MOEBIUS_FAMILY)]
)
def test_the_textbook_maps_are_recognised_and_done_many_at_once(family, known):
    first, second = np.linspace(0.1, 0.9, 5), np.linspace(0.1, 0.6, 3)
    assert same(rotation_plane(family, first, second), rotation_plane(known, first, second))
    assert same(rotation_numbers(family, first, 0.5), rotation_numbers(known, first, 0.5))


@pytest.mark.parametrize("family", [ARNOLD_FAMILY, one_by_one])
def test_folded_maps_show_their_rotation_interval(family):
    """(Ω .5, K 3) has [1/6, 5/6] and (.3, 3) has [0, 1/2]; K = .5 beside them does not fold."""
    plane = rotation_plane(family, [0.3, 0.5], [0.5, 3.0], tolerance=5e-3)
    assert plane.folded.tolist() == [[False, True], [False, True]]
    np.testing.assert_allclose(plane.lower[:, 1], [0, 1 / 6], atol=1e-15)
    np.testing.assert_allclose(plane.upper[:, 1], [1 / 2, 5 / 6], atol=1e-15)
    assert enclosed(plane)
    assert np.all(plane.period[:, 1] == 0)


def test_a_plane_of_folded_maps_encloses_what_each_map_gives_by_itself():
    """Both bounds hold the whole rotation interval, which the maps one by one know far better."""
    first, second = np.linspace(0.05, 0.95, 4), np.array([0.8, 1.3, 2.0, 3.0])
    plane = rotation_plane(CircleMap.arnold, first, second)
    assert np.array_equal(plane.folded, np.broadcast_to(second > 1.0, (4, 4)))
    assert enclosed(plane)
    for i, omega in enumerate(first):
        for j in range(1, 4):
            interval = rotation_interval(CircleMap.arnold(omega, second[j]), iterates=4_000)
            assert plane.lower[i, j] <= interval.lower_number.upper
            assert plane.upper[i, j] >= interval.upper_number.lower
            assert plane.lower[i, j] >= interval.lower - 2.1e-3
            assert plane.upper[i, j] <= interval.upper + 2.1e-3


def planes_rotation(**options):
    return rotation_plane(one_by_one, [0.1, 0.5, 0.9], [0.5, 1.5], 1e-2, **options)


def planes_exponents(**options):
    omega, strength = np.linspace(0.1, 0.9, 9)[:, None], [0.5, 2.5]
    return lyapunov_exponents(one_by_one, omega, strength, cycles=200, **options)


def edges_of_tongues(**options):
    return tongues(one_by_one, [0, (1, 2)], [0.6, 1.2], (-0.5, 1.0), **options)


def curves_in_the_plane(**options):
    return bifurcation_curves(one_by_one, (0.02, 0.4), (0.5, 2.3), lines=1, **options)


def same(one, other):
    """Whether all numbers of two results are the same, to the last digit."""
    if is_dataclass(one):
        return all(same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return np.array_equal(one, other, equal_nan=np.asarray(one).dtype.kind == "f")


@pytest.mark.parametrize(
    "found", [planes_rotation, planes_exponents, edges_of_tongues, curves_in_the_plane]
)
def test_the_numbers_do_not_depend_on_the_executor(found):
    plain = found()
    for kind in (ThreadPoolExecutor, ProcessPoolExecutor):
        told = []
        with kind(2) as executor:
            assert same(found(progress=told.append, executor=executor), plain)
        assert told == sorted(told) and told[-1] == 1.0 and len(told) > 1


def test_same_sees_a_changed_digit():
    plane = planes_rotation()
    assert not same(plane, replace(plane, value=np.nextafter(plane.value, 2.0)))


def moving_jump(p):
    """x + 0.3 sin(x - p) + 1 with a jump of 0.4 at p and a kink at p + 2."""

    def lift(x):
        y = np.mod(x - p, TWO_PI)
        waves = x + 1.0 + 0.3 * np.sin(y) + 0.4 * np.cos(p) * (y / TWO_PI) ** 2
        return waves + 0.1 * np.maximum(y - 2.0, 0.0) * (TWO_PI - y)

    return CircleMap(lift, None, breaks=[p, p + 2.0])


def test_the_error_of_a_tangent_falls_with_the_square_of_the_step():
    """In the middle, and at an end of what is allowed."""
    truth = 2.0 * np.sin(1.0) / (1.0 - 1.2 * np.cos(1.0) + 0.36)
    steps = np.array([0.08, 0.04, 0.02])
    family = lambda r: CircleMap.moebius(r, 0.2)  # noqa: E731
    for within in ((0.0, 0.999), (0.0, 0.6)):
        errors = [abs(float(parameter_tangent(family, 0.6, h, within)(1.0)) - truth) for h in steps]
        orders = np.diff(np.log(errors)) / np.diff(np.log(steps))
        assert np.all(np.abs(orders - 2.0) < 0.35)


def test_a_tangent_at_the_end_of_the_allowed_range_never_leaves_it():
    asked, theta = [], np.linspace(-7.0, 9.0, 101)

    def family(K):
        asked.append(K)
        return CircleMap.arnold(0.1, K)

    for parameter in (0.0, 0.0005, 0.999, 1.0):
        tangent = parameter_tangent(family, parameter, 1e-3, (0.0, 1.0))
        assert np.max(np.abs(tangent(theta) + np.sin(theta))) < 1e-10
    assert len(asked) > 10 and min(asked) >= 0.0 and max(asked) <= 1.0


def test_breaks_that_move_are_followed_and_never_differenced_across():
    """One is close to 2π, round which a large step takes it."""
    p, theta = 6.1, np.linspace(-7.0, 9.0, 101)
    for step, good in ((1e-5, 1e-8), (1e-3, 1e-4)):
        tangent = parameter_tangent(moving_jump, p, step, (0.0, 10.0))
        assert np.allclose(tangent.break_rates, 1.0, atol=1e-10)
        y = np.mod(np.append(theta, [p, p + 2.0, p - 1e-6, p + 1e-6]) - p, TWO_PI)
        truth = (
            -0.3 * np.cos(y)
            - 0.4 * np.cos(p) * 2.0 * y / TWO_PI**2
            - 0.4 * np.sin(p) * (y / TWO_PI) ** 2
            - 0.1 * np.where(y >= 2.0 - 1e-12, TWO_PI - 2.0 * y + 2.0, 0.0)
        )
        assert np.max(np.abs(tangent(p + y) - truth)) < good
