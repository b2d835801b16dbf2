"""Tongue edges: closed forms, an extended system in extended precision, orders, bad input."""

from fractions import Fraction
from functools import partial
from itertools import pairwise, product

import numpy as np
import pytest
from refusals import refused

from cyclemap.errors import ConvergenceError
from cyclemap.maps import CircleMap, fixed_points, periodic_orbits, rotation_number, tongue, tongues
from cyclemap.maps.families.tongues import unseen_height
from tests.maps.known_maps import bumped, contraction, plateau, tent

TWO_PI = 2 * np.pi
WIDE = (-0.5, 1.5)


def arnold(K):
    return lambda omega: CircleMap.arnold(omega, K)


def exact_edge(K, ratio, omega, theta):
    """G = 0, G' = 0 of the sine family by Newton's method in extended precision: a route without
    this package.
    """
    two_pi = 2 * np.arccos(np.longdouble(-1))
    K, p, x = map(np.longdouble, (K, omega, theta))
    for _ in range(8):
        y, d, dd, dp, ddp = x, np.longdouble(1), 0, 0, 0
        for _ in range(ratio.denominator):
            slope, bend = 1 - K * np.cos(y), K * np.sin(y)
            dd, ddp = bend * d * d + slope * dd, bend * d * dp + slope * ddp
            d, dp = slope * d, two_pi + slope * dp
            y = y + two_pi * p - K * np.sin(y)
        g, h = y - x - two_pi * ratio.numerator, d - 1
        determinant = h * ddp - dp * dd
        x, p = x - (g * ddp - dp * h) / determinant, p - (h * h - dd * g) / determinant
    return p, max(abs(g), abs(h))


@pytest.mark.parametrize("K", [0.05, 1.0, 4.0])
def test_the_zero_tongue_of_the_sine_family_is_omega_at_most_K_over_two_pi_folded_or_not(K):
    found = tongue(arnold(K), 0, (-1.0, 1.0))
    assert found.right.holds(K / TWO_PI) and found.left.holds(-K / TWO_PI)
    assert found.width.error_bound < 1e-14 and found.folded == (K > 1)


@pytest.mark.slow
@pytest.mark.parametrize(("p", "q"), [(1, 2), (1, 3), (2, 5), (5, 13), (11, 40)])
def test_edges_agree_with_the_extended_system_in_extended_precision(p, q):
    for K in (0.9, 1.0):
        found = tongue(arnold(K), (p, q), WIDE)
        for edge, theta in ((found.left, found.left_orbit[0]), (found.right, found.right_orbit[0])):
            exact, residual = exact_edge(K, Fraction(p, q), edge, theta)
            assert residual < 1e-13
            assert abs(edge - exact) <= edge.error_bound < 1e-14


@pytest.mark.slow
@pytest.mark.parametrize("a", [0.3, 0.99])
def test_the_moebius_family_locks_at_zero_only(a):
    family = lambda omega: CircleMap.moebius(a, omega)  # noqa: E731
    zero = tongue(family, 0, (-0.5, 0.5))
    assert zero.right.holds(np.arcsin(a) / np.pi) and zero.left.holds(-np.arcsin(a) / np.pi)
    assert zero.width.error_bound < 1e-14
    for p, q in ((1, 2), (2, 7), (5, 11)):
        found = tongue(family, (p, q), (0.0, 1.0))
        assert found.width <= found.width.error_bound
        # cos πρ = cos πΩ/√(1 - a²) at ρ = p/q
        assert found.left.holds(np.arccos(np.sqrt(1 - a * a) * np.cos(np.pi * p / q)) / np.pi)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factor", "ratios"),
    [(0.3, [(0, 1), (2, 5)]), (0.9, [(1, 3), (7, 40)])],
)
def test_the_piecewise_contraction_has_its_closed_form_right_edges(factor, ratios):
    for p, q in ratios:
        found = tongue(partial(contraction, factor), (p, q), (-1.5, 2.5))
        assert found.right.holds(float(plateau(Fraction(factor), Fraction(p, q))[1]))
        assert found.right.error_bound < 1e-13
        inside = 0.5 * (found.left + found.right)
        assert rotation_number(contraction(factor, inside), iterates=4000).locked == Fraction(p, q)


def test_a_kinked_family_has_the_edges_its_lines_give():
    zero = tongue(tent, 0, (-1.0, 1.0))
    assert zero.right.holds(0.0) and zero.left.holds(-0.25)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("width", "height", "slopes"),
    [(1e-3, 8e-4, True), (1e-3, 0.1, True), (3e-4, 2e-4, False), (6e-5, 5e-5, True)],
)
def test_a_bump_is_found_wherever_it_lies(width, height, slopes):
    """6e-5 is the least width that is promised; higher than wide it folds the map.
    ``fixed_points`` is the other route.
    """
    for place in (0.1, 3.22):
        family = bumped(place, width, height, slopes=slopes)
        found = tongue(family, 0, (-0.5, 0.6))
        assert found.left.holds(-height / TWO_PI)
        assert abs(found.left_orbit[0] - place) < 1e-6 or height > 8e-4
        assert found.folded == (height > 8e-4)
        assert len(fixed_points(family(found.left + 1e-7))) == 2
        assert not fixed_points(family(found.left - 1e-7))


def test_a_bump_that_differences_step_over_is_refused_by_its_place():
    """Differences a milliradian wide do not see a bump of 6e-5; the cells do, and say so."""
    told = r"too rough to follow, most of all between θ = 0\.09.*none given"
    family = bumped(0.1, 6e-5, 5e-5, slopes=False)
    refused(tongue, family, 0, (-0.5, 0.6), told=told, kind=ConvergenceError)


def test_a_hump_that_the_scan_stepped_over_is_found_and_the_edge_sought_anew():
    """Beside the top of the wide one, 2e-6 wide: it moves the edge by 1.6e-7."""
    place = 1.5 * np.pi + 5e-4
    left = tongue(bumped(place, 2e-6, 1e-6, K=0.2), 0, (-0.5, 0.6)).left
    assert abs(left + (0.2 * np.cos(5e-4) + 1e-6) / TWO_PI) < 1e-14 > left.error_bound


@pytest.mark.parametrize("place", [0.1, 4.0])
def test_how_far_a_value_may_lie_above_nought_is_found_between_samples(place):
    """A bump of 2 mrad that stands 0.2 mrad above the diagonal, and one that stays below it."""

    def bump(theta):
        return 1.2e-3 * np.exp(-(((theta - place) / 2e-3) ** 2))

    for below, over in ((1e-3, 2e-4), (1.3e-3, 0.0)):
        circle = CircleMap(
            lambda theta, below=below: theta - below + bump(theta),
            lambda theta: 1.0 - (theta - place) / 2e-6 * bump(theta),
        )
        height, where = unseen_height(circle, Fraction(0), 1.0)
        assert over <= height + 1e-12 and height <= over + 1e-9
        assert not over or abs(where - place) < 2e-3


def test_what_is_not_seen_of_very_many_waves_is_in_the_edges_bound():
    """2,000 waves touch the diagonal at once: the edge may move by the room in the cells left."""
    family = lambda omega: CircleMap(  # noqa: E731
        lambda t: t + TWO_PI * omega + 2.5e-4 * np.cos(2000 * t),
        lambda t: 1.0 - 0.5 * np.sin(2000 * t),
    )
    found = tongue(family, 0, (-0.3, 0.3))
    left = found.left
    assert left.holds(-2.5e-4 / TWO_PI)
    # Edges anywhere within their bounds make no width that its own bound leaves out.
    assert found.width.upper >= (found.right.upper - left.lower) * (1.0 - 1e-12)
    unseen, _ = unseen_height(family(float(left)), Fraction(0), 1.0)
    assert left.error_bound >= 0.99 * unseen / TWO_PI > 1e-8


def test_a_folded_tongue_is_where_an_orbit_of_that_rotation_number_exists():
    found = tongue(arnold(2.0), (1, 3), WIDE)
    assert found.folded
    for edge, inward in ((found.left, 1e-6), (found.right, -1e-6)):
        assert periodic_orbits(CircleMap.arnold(edge + inward, 2.0), 3, 1)
        assert not periodic_orbits(CircleMap.arnold(edge - inward, 2.0), 3, 1)


@pytest.mark.slow
def test_boundaries_over_a_second_parameter_are_the_single_tongues():
    strengths = np.array([0.3, 0.9, 1.2])
    curves = tongues(CircleMap.arnold, [0, (1, 2)], strengths, WIDE)
    assert curves.left.shape == (2, 3)
    for (i, ratio), (j, strength) in product(enumerate(curves.ratios), enumerate(strengths)):
        single = tongue(arnold(strength), ratio, WIDE)
        assert (single.left, single.right) == (curves.left[i, j], curves.right[i, j])
        assert single.left.error_bound == curves.left_error[i, j]
        assert single.right.error_bound == curves.right_error[i, j]
    assert np.array_equal(np.any(curves.folded, axis=0), strengths > 1)
    assert np.all(np.diff(curves.right - curves.left, axis=1) > 0)


@pytest.mark.parametrize(("p", "q"), [(0, 1), (1, 2), (1, 3), (1, 4)])
def test_tongues_of_the_sine_family_open_like_the_qth_power(p, q):
    """Width = C K^q (1 + O(K²)): from K to 2K it grows 2^q times (Arnold 1965)."""
    strengths = (0.2, 0.4) if q < 3 else (0.3, 0.6)
    narrow, wide = (tongue(arnold(K), (p, q), WIDE).width for K in strengths)
    assert narrow > 100 * narrow.error_bound
    assert np.log2(wide / narrow) == pytest.approx(q, abs=0.15)


@pytest.mark.slow
def test_tongues_are_disjoint_and_in_the_order_of_their_ratios():
    ratios = sorted({Fraction(p, q) for q in range(1, 5) for p in range(q + 1)})
    edges = [tongue(arnold(1.0), ratio, WIDE) for ratio in ratios]
    for before, after in pairwise(edges):
        assert before.left <= before.right
        assert before.right.upper < after.left.lower


def dropping(omega):
    """A sampled map of slopes of 0.8 and more that jumps down at 2."""
    lifted = np.array([0.7, 2.3, 1.6, 3.8, 6.5]) + TWO_PI * omega
    return CircleMap.from_samples([0, 2, 2, 4, 6], lifted, [0.8] * 5)


@pytest.mark.parametrize(
    ("family", "ratio", "kinds"),
    [
        (arnold(0.9), (2, 5), "saddle-node"),
        (arnold(3.0), (1, 2), "saddle-node"),
        (tent, 0, "border-collision"),
        (partial(contraction, 0.5), (1, 2), "border-collision"),
        (dropping, 0, "saddle-node"),
        (dropping, (1, 2), "border-collision"),
    ],
)
def test_an_edge_says_what_meets_there_with_its_orbit(family, ratio, kinds):
    """A saddle-node's orbit closes, with multiplier 1; a border collision's visits a break."""
    found = tongue(family, ratio, (-1.0, 2.0))
    assert (found.left_kind, found.right_kind) == (kinds, kinds)
    for edge, orbit in ((found.left, found.left_orbit), (found.right, found.right_orbit)):
        member = family(float(edge))
        assert orbit.size == found.ratio.denominator
        if kinds == "saddle-node":
            assert abs(np.prod(member.derivative(orbit)) - 1) < 1e-5
            gap = member(orbit) - np.roll(orbit, -1)
            assert np.max(np.abs(gap - TWO_PI * np.round(gap / TWO_PI))) < 1e-6
        else:
            away = np.abs(orbit[:, None] - member.breaks)
            assert np.min(np.minimum(away, TWO_PI - away)) < 1e-6


def test_a_period_whose_iterate_is_too_bent_for_it_is_refused_at_the_first_parameter():
    """The critical sine family bends F^q most: fifty parameters would take minutes."""
    told = r"267/701 needs 4,[0-9]{3} cells of F\^701, above 4,279"
    near = (0.3925, 0.3926)
    refused(tongue, arnold(1.0), (267, 701), near, told=told, kind=ConvergenceError)


def test_what_is_no_ratio_in_lowest_terms_is_refused():
    for ratio in ((2, 4), (1, 0), (0, 2)):
        refused(tongue, arnold(0.9), ratio, WIDE, told="lowest terms")
    refused(tongue, arnold(0.9), "1/2", WIDE, told="ratio is '1/2'")
