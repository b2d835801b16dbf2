"""All solutions of Fⁿ(θ) = θ + 2πw: counts by two routes, tangencies never lost or doubled, bounds
that hold; the orbits that they make, and jumps across the diagonal.
"""

from collections import Counter
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from cyclemap.errors import ConvergenceError
from cyclemap.maps import (
    CircleMap,
    conjugate,
    crossings_by_jump,
    fixed_points,
    periodic_orbits,
    periodic_points,
    shifted,
)
from tests.maps.known_maps import (
    DOUBLING,
    TWO_PI,
    agree,
    apart,
    contraction,
    lines,
    logistic,
    plateau,
)
from tests.refusals import refused


def counts(found):
    return Counter(found.winding.tolist())


def sign_changes(circle_map, n, size=100_003):
    """Crossings of Fⁿ - id with whole turns seen on a huge grid: each sign change is one."""
    theta = TWO_PI * np.arange(size + 1) / size - 1e-7
    image = theta
    for _ in range(n):
        image = circle_map(image)
    turns = np.floor((image - theta) / TWO_PI).astype(int)
    found = Counter()
    for a, b in pairwise(turns.tolist()):
        found.update(range(min(a, b) + 1, max(a, b) + 1))
    return found


def test_the_doubling_map_has_the_exact_4095_points():
    found = periodic_points(DOUBLING, 12)
    off = np.abs(found.theta - TWO_PI * np.arange(4095) / 4095)
    assert np.all(off <= found.error_bound) and np.max(off) < 4e-15
    np.testing.assert_array_equal(found.winding, np.arange(4095))
    np.testing.assert_array_equal(found.image, 2 * np.arange(4095) % 4095)
    np.testing.assert_array_equal(found.multiplier, 4096)
    # Möbius inversion: Σ over d | n of (points of prime period d) = 2ⁿ - 1.
    by_period = Counter(found.prime_period.tolist())
    assert by_period == {1: 1, 2: 2, 3: 6, 4: 12, 6: 54, 12: 4020}


@pytest.mark.parametrize(
    ("omega", "strength", "n", "known"),
    [(0.5, 2.0, 8, {4: 64}), (0.3, 3.0, 6, {0: 4, 1: 12, 2: 36, 3: 16})],
)
def test_sine_map_counts_are_the_known_ones_and_those_of_a_huge_grid(omega, strength, n, known):
    sine = CircleMap.arnold(omega, strength)
    found = periodic_points(sine, n)
    assert counts(found) == known == sign_changes(sine, n)
    assert np.all(found.image >= 0)
    for w, count in known.items():
        alone = periodic_points(sine, n, w)
        assert alone.count == count
        np.testing.assert_array_equal(alone.theta, found.theta[found.winding == w])
        np.testing.assert_array_equal(np.sort(alone.image), np.arange(count))


@pytest.mark.parametrize("n", [1, 3, 12])
def test_logistic_map_at_four_has_the_exact_2_to_the_n_points(n):
    found = periodic_points(logistic(4.0), n)
    k = np.arange(2 ** (n - 1))
    roots = [np.sin(np.pi * k / (2**n - 1)) ** 2, np.sin(np.pi * (k + 1) / (2**n + 1)) ** 2]
    off = np.abs(found.theta - TWO_PI * np.sort(np.concatenate(roots)))
    assert np.all(off <= found.error_bound) and np.max(off) < 1e-12
    # |multiplier| is 2ⁿ at every point but 0, where it is 4ⁿ (conjugacy with the tent map).
    np.testing.assert_allclose(np.abs(found.multiplier[1:]), 2.0**n, rtol=1e-8)
    assert abs(found.multiplier[0] / 4.0**n - 1.0) < 1e-12


@pytest.mark.parametrize(("slope", "n"), [(3, 5), (-3, 4), (-2, 7), (5, 4)])
def test_counts_of_full_branches_follow_from_the_transition_matrix(slope, n):
    """A full m-branch map has trace(Aⁿ) = mⁿ closed walks; on the circle the end points of the
    branches coincide.
    """
    straight = CircleMap(lambda x: slope * x, lambda x: slope + 0 * x, degree=slope)
    assert periodic_points(straight, n).count == abs(slope**n - 1)


@pytest.mark.parametrize("n", [1, 2, 3, 8])
def test_markov_map_with_jumps_has_the_trace_of_its_transition_matrix(n):
    """Golden-mean (beta) map x → βx mod 1, branches [0, 1/β), [1/β, 1): the second covers only the
    first.
    """
    beta = (1 + 5**0.5) / 2
    seam = TWO_PI / beta
    found = periodic_points(lines((0, seam, 0, beta), (seam, TWO_PI, -TWO_PI, beta)), n)
    # 0 and 1 are one point, so of the itineraries 0^∞, (01)^∞ → 1/β and (10)^∞ → 1 one is lost
    # for even n.
    trace = np.trace(np.linalg.matrix_power(np.array([[1, 1], [1, 0]]), n))
    assert found.count == trace - (n % 2 == 0)
    # A jump of Fⁿ ends on the diagonal at 0 for odd n, at 1/β (from the left) for even n.
    agree(found.theta[found.kind == "border-collision"], [0.0 if n % 2 else seam], 1e-13)


def with_double_roots(rng):
    """θ + g(θ): g a trigonometric polynomial with one or two double roots and up to four simple
    ones, well apart.
    """
    doubles, pairs = rng.uniform(0, TWO_PI, rng.integers(1, 3)), rng.integers(0, 3)
    singles = rng.uniform(0, TWO_PI, 2 * pairs)
    roots = np.concatenate([doubles, singles])
    if np.min(apart(roots[:, None], roots) + 9 * np.eye(roots.size)) < 0.3:
        return with_double_roots(rng)

    def factors(x):
        values = [1 - np.cos(x - d) for d in doubles]
        values += [np.sin((x - a) / 2) * np.sin((x - b) / 2) for a, b in singles.reshape(-1, 2)]
        slopes = [np.sin(x - d) for d in doubles] + [
            np.sin(x - (a + b) / 2) / 2 for a, b in singles.reshape(-1, 2)
        ]
        return values, slopes

    def g(x):
        return np.prod(factors(x)[0], axis=0)

    def slope(x):
        values, slopes = factors(x)
        terms = [np.prod([*values[:i], s, *values[i + 1 :]], axis=0) for i, s in enumerate(slopes)]
        return np.sum(terms, axis=0)

    scale = 1.5 / np.max(np.abs(g(np.linspace(0, TWO_PI, 2001))))
    curvature = scale * (slope(doubles + 1e-4) - slope(doubles - 1e-4)) / 2e-4
    return doubles, curvature, singles.size, lambda x: scale * g(x), lambda x: scale * slope(x)


@pytest.mark.slow
def test_double_roots_of_random_maps_are_one_none_or_two_as_they_must_be():
    rng, checked = np.random.default_rng(7), 0
    shifts = [s * e for e in (1e-14, 1e-13, 4e-12, 1e-9, 1e-6) for s in (1, -1)]
    for number in range(60):
        doubles, curvature, simple, g, slope = with_double_roots(rng)
        if np.min(np.abs(curvature)) < 1e-2:
            continue
        for shift in (0.0, shifts[number % 10], shifts[(number + 5) % 10])[: 1 + number % 3]:
            shifted = CircleMap(lambda x, g=g, e=shift: x + g(x) + e, lambda x, s=slope: 1 + s(x))
            found = periodic_points(shifted, 1)
            merged = abs(shift) < 1e-12
            each = 1 if merged else 2 * (curvature * shift < 0)
            assert found.count == simple + np.sum(each * np.ones_like(curvature))
            touching = found.kind == "saddle-node"
            assert np.sum(touching) == (doubles.size if merged else 0)
            assert np.all(np.isfinite(found.error_bound))
            if merged:
                agree(found.theta[touching], np.sort(doubles), 1e-10)
            checked += 1
    assert checked > 90


EDGES = [(2, 0.46966533712136485155447001, 0.9, 2), (2, 0.46301722338218515819112389, 1.0, 2)]
EDGES += [(3, 0.33666500673073392496899187, 1.0, 3), (3, 0.3672244987508916119875371, 1.0, 3)]


@pytest.mark.slow
@pytest.mark.parametrize(("n", "edge", "strength", "points"), EDGES)
def test_all_points_of_an_orbit_are_judged_alike_at_every_distance_from_a_tongue_edge(
    n, edge, strength, points
):
    seen = []
    for distance in np.concatenate([[0.0], np.geomspace(1e-15, 1e-6, 10)]):
        for side in (-1, 1):
            sine = CircleMap.arnold(edge + side * distance, strength)
            found, orbits = periodic_points(sine, n), periodic_orbits(sine, n)
            judged = found.count, int(np.sum(found.kind == "saddle-node")), len(orbits)
            assert judged in ((0, 0, 0), (points, points, 1), (2 * points, 0, 2))
            seen.append(len(orbits))
    assert seen[:2] == [1, 1]
    assert sorted(seen[-2:]) == [0, 2]
    assert set(seen) == {0, 1, 2}


DEGENERATE = {
    "cubic": (lambda x: 0.1 * np.sin(x) ** 3, lambda x: 0.3 * np.sin(x) ** 2 * np.cos(x)),
    "quartic": (lambda x: 0.2 * (1 - np.cos(x)) ** 2, lambda x: 0.4 * (1 - np.cos(x)) * np.sin(x)),
    "quintic": (lambda x: 0.1 * np.sin(x) ** 5, lambda x: 0.5 * np.sin(x) ** 4 * np.cos(x)),
}


@pytest.mark.parametrize("centre", [0.0, 0.7, np.pi])
@pytest.mark.parametrize("name", DEGENERATE)
def test_degenerate_tangencies_are_one_point_of_the_documented_kind(name, centre):
    g, slope = DEGENERATE[name]
    for sign in (1, -1):
        touch = CircleMap(
            lambda x, s=sign: x + s * g(x - centre), lambda x, s=sign: 1 + s * slope(x - centre)
        )
        found = periodic_points(touch, 1)
        kinds = ["saddle-node"] if name == "quartic" else ["neutral", "neutral"]
        assert found.kind.tolist() == kinds
        off = np.abs(np.mod(found.theta - centre + 0.5, np.pi) - 0.5)
        assert np.all(off <= found.error_bound) and np.max(found.error_bound) < 0.03
        assert np.all(np.abs(found.multiplier - 1.0) <= found.multiplier_error)


@pytest.mark.parametrize(
    ("left", "right", "kind"),
    [
        (-49.0, -1 / 49.0, "neutral"),
        (-2.0, -0.5, "neutral"),
        (-1.0, -0.5, "stable"),
        (-1.0, -1.5, "unstable"),
        (-1.0, 0.5, "stable"),
        (-3.0, 0.5, "stable"),
    ],
)
def test_on_a_kink_the_side_decides_on_which_orbits_are_or_both_where_they_change_it(
    left, right, kind
):
    """Two lines meet at θ = 1, and a third one closes the turn."""
    low, high = 1.0 - 0.3 * left, 1.0 + 0.3 * right
    rest = (low + TWO_PI - high) / (TWO_PI - 0.6)
    kinked = lines(
        (0.7, 1.0, 1.0 - left, left),
        (1.0, 1.3, 1.0 - right, right),
        (1.3, 0.7 + TWO_PI, high - 1.3 * rest, rest),
    )
    [point] = [orbit for orbit in fixed_points(kinked) if abs(orbit.points[0] - 1.0) < 1e-9]
    assert point.kind == kind and point.stable == (kind == "stable")
    agree([point.left_multiplier, point.multiplier], [left, right], 1e-12)
    assert crossings_by_jump(kinked) == []


def test_period_doubling_merges_its_orbits_only_within_the_tangency():
    # θ - K sin θ doubles at K = 2: 0 has multiplier 1 - K, the orbit of period two lies at ±√(6(K -
    # 2)) or so.
    assert [p.kind for p in fixed_points(CircleMap.arnold(0.0, 2.0))] == ["neutral", "unstable"]
    expected = {-1e-3: 2, -1e-9: 2, 0.0: 2, 1e-12: 2, 1e-7: 4, 1e-3: 4}
    for past, count in expected.items():
        found = periodic_points(CircleMap.arnold(0.0, 2.0 + past), 2, 0)
        assert found.count == count
        assert found.theta[0] < 1e-9
        np.testing.assert_array_equal(
            np.sort(found.prime_period), [1, 1] if count == 2 else [1, 1, 2, 2]
        )


def test_error_bounds_hold_and_are_not_far_above_the_truth():
    # Möbius maps: e^{iθ} solves a quadratic, known in closed form.
    rng = np.random.default_rng(3)
    for _ in range(20):
        a, omega = rng.uniform(0.2, 0.95), rng.uniform(-0.05, 0.05)
        found = periodic_points(CircleMap.moebius(a, omega), 1)
        half = np.arcsin(np.sin(np.pi * omega) / a)
        # F(θ) = θ where a sin(θ - πΩ) = - sin πΩ, that is θ = πΩ - half and θ = πΩ + π + half.
        truth = np.sort(np.mod([np.pi * omega - half, np.pi * omega + np.pi + half], TWO_PI))
        assert found.count == 2
        assert np.all(apart(found.theta, truth) <= found.error_bound + 1e-15)
        assert np.all(found.error_bound < 1e-13 / np.abs(found.multiplier - 1) + 1e-13)


def test_a_collision_with_a_jump_is_one_border_point():
    # The fixed point shift/(1 - 0.6) turns leaves through the jump at shift = 0 and at shift = 0.4.
    for edge, inward in ((0.0, 1e-9), (0.4, -1e-9)):
        for off, kinds in ((-inward, []), (0.0, ["border-collision"]), (inward, ["stable"])):
            found = periodic_points(contraction(0.6, edge + off), 1)
            assert found.kind.tolist() == kinds


def test_plateaus_folds_and_kinks_in_one_map_give_superstable_orbits():
    flat = lines((0, 4 / 3, 0, 3), (4 / 3, TWO_PI, 4, 0))
    found = periodic_points(flat, 1)
    stable = found.kind == "stable"
    agree(found.theta[stable], [4.0], 1e-14)
    assert found.multiplier[stable].tolist() == [0.0]
    for n in (2, 3):
        again = periodic_points(flat, n)
        assert np.all(again.prime_period == 1) and again.count == found.count


@pytest.mark.parametrize(("degree", "height"), [(9, 0.02), (3, 0.2)])
def test_fine_features_met_by_a_steep_second_iterate_are_not_missed(degree, height):
    """A ripple of wavelength 0.16 behind a slope of 9, and one that folds: each of the two routes
    sees it in its own way.
    """
    rippled = CircleMap(
        lambda x: degree * x + height * np.sin(40 * x),
        lambda x: degree + 40 * height * np.cos(40 * x),
        degree=degree,
    )
    assert counts(periodic_points(rippled, 2)) == sign_changes(rippled, 2)


def test_too_many_points_are_refused_and_none_are_an_answer_that_never_changes():
    steep = CircleMap(lambda x: 9 * x, lambda x: 9 + 0 * x, degree=9)
    refused(periodic_points, steep, 9, kind=ConvergenceError, told=r"too steep.* shorter period")
    assert periodic_points(CircleMap.rigid(0.2), 3).count == 0
    with pytest.raises(ValueError, match="read-only"):
        periodic_points(DOUBLING, 2).theta[0] = 1.0


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


def test_a_multiplier_beyond_all_floats_is_infinite_with_no_bound():
    """(1/λ)ⁿ of the repelling point of a Möbius map, λ = 6e-4 and n = 120; λⁿ is 0 as a float."""
    found = periodic_points(CircleMap.moebius(0.999, 0.1), 120)
    assert sorted(found.kind) == ["stable", "unstable"]
    repels = found.kind == "unstable"
    assert np.array_equal(found.multiplier, np.where(repels, np.inf, 0.0))
    assert np.array_equal(found.multiplier_error, np.where(repels, np.inf, 0.0))
    # On the repelling point itself, 0 to the last digit, no iterate leaves it.
    told = r"the slope of F\^[0-9]+ is beyond all floats at θ = 0: ask for a shorter period"
    still = CircleMap.moebius(0.999, 0.0)
    refused(periodic_points, still, 120, told=told, kind=ConvergenceError)
