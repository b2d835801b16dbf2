"""Curves of bifurcations in a plane of two parameters, and their points of codimension two."""

import numpy as np
import pytest
from refusals import refused

from cyclemap.maps import (
    CircleMap,
    bifurcation_curves,
    bifurcations,
    follow_bifurcation,
    period_doublings,
    saddle_nodes,
    tongue,
)

TWO_PI = 2 * np.pi
PLANE = (0.0, 0.6), (-1.0, 2.0)


def born(period, winding, ends):
    """A saddle-node of the sine family at K = 0.9."""
    return saddle_nodes(
        lambda omega: CircleMap.arnold(omega, 0.9), ends, period, winding, resolution=2
    )[0]


def two_waves(shift, first, second):
    return CircleMap(
        lambda x: x + shift - first * np.sin(x) - second * np.sin(2 * x),
        lambda x: 1 - first * np.cos(x) - 2 * second * np.cos(2 * x),
    )


@pytest.mark.parametrize(
    ("ratio", "ends"),
    [((0, 1), (0.1, 0.2)), ((1, 2), (0.45, 0.5)), ((1, 3), (0.33, 0.345))],
)
def test_edges_of_sine_tongues_end_in_their_tips_at_no_kick_and_agree_with_the_tongues(ratio, ends):
    edge = follow_bifurcation(CircleMap.arnold, born(ratio[1], ratio[0], ends), 0.9, *PLANE)
    assert sorted(edge.ends) == ["end of the plane", "tip"] and edge.residual < 1e-12
    (tip,) = edge.special
    assert tip.kind == "tip" and tip.first.holds(ratio[0] / ratio[1]) and tip.second.holds(0.0)
    assert max(tip.first.error_bound, tip.second.error_bound) < 1e-3
    index = int(np.argmin(np.abs(edge.second - 0.6)))
    family = lambda omega: CircleMap.arnold(omega, edge.second[index])  # noqa: E731
    known = tongue(family, ratio, (-0.5, 1.0))
    assert min(abs(edge.first[index] - side) for side in (known.left, known.right)) < 1e-10


def test_fixed_points_of_the_sine_family_double_on_a_hyperbola_with_a_known_coefficient():
    family = lambda omega: CircleMap.arnold(omega, 2.5)  # noqa: E731
    (start,) = period_doublings(family, (0.1, 0.5), resolution=4)
    curve = follow_bifurcation(CircleMap.arnold, start, 2.5, (-1.0, 1.0), (-1.0, 5.0))
    assert curve.first.min() < -0.5 and curve.first.max() > 0.5  # round the fold in K at K = 2
    assert np.max(np.abs((TWO_PI * curve.first) ** 2 - curve.second**2 + 4)) < 1e-12
    # With F'' = K sin θ, F''' = K cos θ = 2.
    assert np.max(np.abs(curve.coefficient - ((curve.second**2 - 4) / 4 + 1 / 3))) < 1e-8
    assert curve.special == ()


def test_a_loop_of_period_doublings_closes():
    def family(p, q):
        return CircleMap.arnold(0.0, 2.5 - p**2 - 4 * q**2)

    (start,) = period_doublings(lambda p: family(p, 0.1), (0.1, 1.0), resolution=4)
    curve = follow_bifurcation(family, start, 0.1, (-1.0, 1.0), (-1.0, 1.0))
    assert curve.ends == ("closed", "closed")
    assert np.max(np.abs(curve.first**2 + 4 * curve.second**2 - 0.5)) < 1e-13
    angle = np.unwrap(np.arctan2(2 * curve.second, curve.first))
    assert abs(abs(angle[-1] - angle[0]) - TWO_PI) < 1e-12


def test_saddle_nodes_of_twice_the_period_end_in_the_generalised_flip_that_the_doubling_tells():
    def family(K, b):
        return two_waves(0.1, K, b)

    ends = (1.5, 3.5), (-0.6, 0.2)
    (flip,) = period_doublings(lambda K: family(K, -0.4), ends[0], resolution=3)
    (fold,) = saddle_nodes(lambda K: family(K, -0.4), (2.6, 2.9), 2, resolution=3)
    (at_doubling,) = follow_bifurcation(family, flip, -0.4, *ends).special
    curve = follow_bifurcation(family, fold, -0.4, *ends)
    assert "half the period" in curve.ends
    (at_end,) = curve.special
    assert at_doubling.kind == at_end.kind == "generalised flip"
    for here, there in ((at_doubling.first, at_end.first), (at_doubling.second, at_end.second)):
        assert abs(here - there) <= here.error_bound + there.error_bound < 1e-8


def test_curves_at_a_kink_meet_where_a_slope_beside_it_is_one():
    """Slopes ±q - 0.2 cos θ on the halves, turned with p: at q = ±0.2 a fold runs into the kink."""

    def family(p, q):
        turn = 0.5 * p

        def lift(x):
            away = np.abs(np.mod(x - turn + np.pi, TWO_PI) - np.pi)
            return x + p + q * (away - np.pi / 2) - 0.2 * np.sin(x - turn)

        def slope(x):
            half = np.where(np.mod(x - turn, TWO_PI) < np.pi, 1.0, -1.0)
            return 1 + q * half - 0.2 * np.cos(x - turn)

        return CircleMap(lift, slope, [turn, turn + np.pi])

    found = bifurcations(lambda p: family(p, 0.1), (0.05, 0.8), resolution=4)
    kinds = {}
    for start in found:
        curve = follow_bifurcation(family, start, 0.1, (-1.0, 1.0), (-0.5, 0.5))
        kinds.setdefault(curve.kind, []).append(curve)
        assert curve.residual < 1e-12
        if curve.kind == "border-collision":
            assert np.max(np.abs(np.abs(curve.first) - np.abs(curve.second) * np.pi / 2)) < 1e-12
        assert [point.kind for point in curve.special] == ["border saddle-node"] * 2
        for point in curve.special:
            assert abs(abs(point.first) - 0.1 * np.pi) <= point.first.error_bound < 1e-5
            assert abs(abs(point.second) - 0.2) <= point.second.error_bound < 1e-5
    assert set(kinds) == {"border-collision", "saddle-node"}
    assert kinds["saddle-node"][0].ends == ("border collision", "border collision")


def test_at_a_jump_the_far_side_has_no_orbit_whose_multiplier_could_pass_one():
    """Slope 1.5 + q below a jump, 0.5 above it: the orbit that comes from above stays stable."""

    def family(p, q):
        def lift(theta):
            turns = np.floor(theta / TWO_PI)
            away = theta - TWO_PI * turns
            low, high = 0.5 * away, (1.5 + q) * (away - TWO_PI) + 0.7 * TWO_PI
            return p + TWO_PI * turns + np.where(away < np.pi, low, high)

        return CircleMap(lift, None, [0.0, np.pi])

    found = bifurcations(lambda p: family(p, 0.0), (-0.5, 0.5), resolution=4)
    start = next(one for one in found if one.jump and one.theta < 1.0)
    curve = follow_bifurcation(family, start, 0.0, (-1.0, 1.0), (-0.9, 0.9))
    assert np.max(np.abs(curve.first)) < 1e-12 and curve.special == ()


@pytest.mark.slow
def test_all_curves_of_a_plane_are_met_once():
    curves = bifurcation_curves(CircleMap.arnold, (-0.6, 0.6), (0.0, 4.0), lines=2)
    kinds = sorted(curve.kind for curve in curves)
    assert kinds == ["period-doubling", "saddle-node", "saddle-node"]


def test_what_is_no_start_is_refused():
    start = born(1, 0, (0.1, 0.2))
    for wrong, at, plane, told in (
        (0.3, 0.9, PLANE, "start is 0.3"),
        (start, 0.5, PLANE, "there is no saddle-node"),
        (start, 0.9, ((0.5, 0.1), (0, 1)), "first"),
    ):
        refused(follow_bifurcation, CircleMap.arnold, wrong, at, *plane, told=told)
    refused(bifurcation_curves, CircleMap.arnold, (0.0, 1.0), (0.0, 1.0), lines=0, told="lines")
