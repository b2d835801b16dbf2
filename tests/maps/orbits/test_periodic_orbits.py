"""Fixed points and periodic orbits: counts, multipliers, tangencies, kinks and jumps."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from cyclemap.maps import (
    CircleMap,
    conjugate,
    crossings_by_jump,
    fixed_points,
    periodic_orbits,
    shifted,
)
from tests.maps.known_maps import TWO_PI, agree, apart, contraction, plateau


def test_points_lie_on_their_orbit_in_order_of_visit():
    folded = CircleMap.arnold(0.3, 3.0)
    orbits = periodic_orbits(folded, 6)
    lower = sum(d * len(periodic_orbits(folded, d)) for d in (1, 2, 3))
    assert len(orbits) == (4 + 12 + 36 + 16 - lower) // 6
    for orbit in orbits:
        gap = apart(folded(orbit.points), np.roll(orbit.points, -1))
        steepest = np.max(np.abs(folded.derivative(orbit.points)))
        assert np.max(gap) <= orbit.error_bound * steepest + 1e-13
        assert orbit.points[0] == np.min(orbit.points)
        assert len(np.unique(np.round(orbit.points, 9))) == 6


@pytest.mark.slow
@settings(max_examples=12, deadline=None, derandomize=True)
@given(st.floats(0.0, 6.28), st.floats(0.05, 0.95), st.floats(0.3, 2.9))
def test_conjugation_by_a_rotation_moves_the_orbits_and_nothing_else(angle, omega, strength):
    sine = CircleMap.arnold(omega, strength)
    for period in (1, 2):
        plain, moved = (
            sorted(orbit.multiplier for orbit in periodic_orbits(made, period))
            for made in (sine, conjugate(sine, angle))
        )
        np.testing.assert_allclose(moved, plain, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("ratio", [Fraction(1, 2), Fraction(1, 3), Fraction(2, 5)])
def test_at_either_edge_of_a_plateau_one_orbit_runs_into_the_jump(ratio):
    """At the right edge its point at the jump is reached from below alone, so that no link leads
    there.
    """
    for edge in plateau(Fraction(3, 5), ratio):
        (orbit,) = periodic_orbits(contraction(0.6, float(edge)), ratio.denominator)
        assert (orbit.kind, orbit.winding) == ("border-collision", ratio.numerator)
        assert orbit.points.size == ratio.denominator
        assert np.min(apart(orbit.points, 0.0)) < 1e-12


@pytest.mark.slow
def test_a_multiplier_that_is_not_known_to_differ_from_one_is_neutral():
    """Twenty-four slopes of 1 ± 7e-9 multiply to 1 ± 1.7e-7, which is told; of 1 ± 4.4e-9 not, since
    the points are hardly known there, and less by differences.
    """
    count = 24
    errors = []
    for steep, is_given, kinds in (
        (7e-9, True, ["stable", "unstable"]),
        (4.4e-9, True, ["neutral", "neutral"]),
        (4.4e-9, False, ["neutral", "neutral"]),
    ):

        def lift(x, steep=steep):
            wave = np.sin(count * (x - 1.0))
            return x + TWO_PI / count + (wave**3 + steep * wave) / count

        def slope(x, steep=steep):
            wave, by = np.sin(count * (x - 1.0)), np.cos(count * (x - 1.0))
            return 1.0 + (3.0 * wave**2 + steep) * by

        orbits = periodic_orbits(CircleMap(lift, slope if is_given else None), count, 1)
        assert sorted(orbit.kind for orbit in orbits) == kinds
        for orbit in orbits:
            off = abs(abs(orbit.multiplier) - 1.0)
            assert abs(off - count * steep) <= orbit.multiplier.error_bound
            sure = off > max(1e-7, orbit.multiplier.error_bound)
            assert sure == (orbit.kind != "neutral")
        errors.append(orbits[0].multiplier.error_bound)
    assert errors[0] < errors[1] < errors[2]


def test_windings_shift_with_the_lift():
    for turns in (-2, 0, 3):
        raised = shifted(CircleMap.arnold(0.1, 0.9), turns)
        for made in (CircleMap.arnold(0.1 + turns, 0.9), raised):
            assert [orbit.winding for orbit in fixed_points(made)] == [turns, turns]
    many = CircleMap.arnold(0.0, 7.0)
    assert sorted(orbit.winding for orbit in fixed_points(many)) == [-1, -1, 0, 0, 1, 1]
    assert [orbit.winding for orbit in periodic_orbits(many, 1, winding=1)] == [1, 1]


def test_a_touch_at_a_kink_is_one_saddle_node():
    x = np.linspace(0, TWO_PI, 21)
    turn = 0.3 * np.abs(np.mod(x - np.pi + np.pi, TWO_PI) - np.pi)
    at = np.insert(x, 10, x[10])
    lifted, slopes = at + np.insert(turn, 10, turn[10]), np.where(np.arange(22) <= 10, 0.7, 1.3)
    roof = CircleMap.from_samples(at, lifted, slopes)
    assert [p.kind for p in fixed_points(roof)] == ["saddle-node"]


def test_a_jump_across_the_diagonal_is_a_crossing_and_no_fixed_point():
    gap = contraction(0.6, 1.1)
    (stable,) = fixed_points(gap)
    agree(stable.points, [0.25 * TWO_PI], 1e-12)
    assert (stable.winding, stable.kind) == (1, "stable")
    (crossing,) = crossings_by_jump(gap)
    assert (crossing.theta, crossing.winding, crossing.attracting) == (0.0, 1, False)
    down = CircleMap.from_samples([0, 2, 2, 4, 6], [1, 2.5, 1.5, 4.2, 6.9], [1.0] * 5)
    assert [jump.theta for jump in crossings_by_jump(down) if jump.attracting] == [2.0]


def test_a_touch_may_be_as_far_off_as_the_tangency_lets_it():
    (touch,) = fixed_points(CircleMap.arnold(0.9 / TWO_PI, 0.9))
    # |g| ≤ tangency lets the roots be anywhere within √(2e-12/0.9).
    assert 1e-6 < touch.error_bound < 4e-6
    assert abs(touch.points[0] - np.pi / 2) < 1e-9
