"""Near-tangencies: gap, curvature and passage time against closed forms and counted iterates."""

from math import atan, pi, sqrt

import mpmath
import numpy as np
import pytest

from cyclemap.maps import CircleMap, nth_iterate, periodic_points, slow_passages
from cyclemap.maps.orbits.diagonal import REACH
from tests.maps.known_maps import TWO_PI, agree

EDGE_HALF = 0.46301722338218515819112389  # left edge of the sine map's tongue 1/2 at K = 1, turns


def outside(gap, strength=0.9):
    """The sine map that clears its tongue 0/1 by ``gap`` radians."""
    return CircleMap.arnold((strength + gap) / TWO_PI, strength)


def lopsided(gap):
    """A bottleneck at 0 with curvature 0.2 and a cubic term 0.05."""
    return CircleMap(
        lambda x: x + gap + (1 - np.cos(x)) * (0.4 + 0.1 * np.sin(x)),
        lambda x: 1 + np.sin(x) * (0.4 + 0.1 * np.sin(x)) + 0.1 * (1 - np.cos(x)) * np.cos(x),
    )


def cycles_across(circle_map, low, high):
    """Iterates from ``low`` to ``high`` > low, the last one counted by its share."""
    lift, x, count = circle_map.scalar(), low, 0.0
    while True:
        y = lift(x)
        if y >= high:
            return count + (high - x) / (y - x)
        x, count = y, count + 1.0


@pytest.mark.parametrize("gap", [1e-1, 1e-4, 1e-8])
def test_the_sine_maps_bottleneck_has_the_closed_form(gap):
    (found,) = slow_passages(outside(gap))
    assert abs(found.theta - pi / 2) < 1e-12
    assert abs(found.gap - gap) < 1e-15
    assert abs(found.curvature / 0.45 - 1) < 1e-8
    assert abs(found.width / sqrt(gap / 0.45) - 1) < 1e-6
    assert abs(found.passage_cycles / (pi / sqrt(0.45 * gap)) - 1) < 1e-6
    assert (found.winding, found.period, found.direction) == (0, 1, 1)


@pytest.mark.parametrize("make", [outside, lopsided])
@pytest.mark.parametrize("gap", [1e-2, 1e-5, 1e-6])
def test_counted_iterates_across_the_bottleneck_confirm_the_relative_error(make, gap):
    (found,) = slow_passages(make(gap))
    reach = REACH * found.width
    counted = cycles_across(make(gap), found.theta - reach, found.theta + reach)
    parabola = 2 * atan(REACH) / sqrt(found.curvature * found.gap)
    # The share of the last step is itself good to (slope of the move)/8 of a cycle.
    slack = found.curvature * reach / parabola
    assert abs(abs(counted / parabola - 1) - found.relative_error) <= 1.01 * slack


def exact_cycles(a, omega, low, high):
    """Cycles of a Möbius map from angle to angle: about its fixed point within the disc it turns
    evenly.
    """
    exact = mpmath.MPContext()
    exact.dps = 60
    a, turn = exact.mpf(a), exact.expj(2 * exact.pi * exact.mpf(omega))
    rho = exact.acos(exact.cos(exact.pi * exact.mpf(omega)) / exact.sqrt(1 - a * a)) / exact.pi
    root = exact.sqrt((turn - 1) ** 2 + 4 * a * a * turn)
    centre = min(((1 - turn + side * root) / (2 * a) for side in (1, -1)), key=abs)
    ends = (exact.expj(exact.mpf(angle)) for angle in (low, high))
    start, end = ((z - centre) / (1 - exact.conj(centre) * z) for z in ends)
    return exact.arg(end / start) / (2 * exact.pi) % 1 / rho


def test_what_the_parabola_misses_and_what_rounding_hides_is_in_the_relative_error():
    """Against the exact number of cycles, from gaps of 0.02 to 2e-11 radians."""
    for past in 10.0 ** -np.arange(2.0, 12.0):
        omega = (np.arcsin(0.5) + past) / pi
        (found,) = slow_passages(CircleMap.moebius(0.5, omega))
        reach = REACH * found.width
        exact = exact_cycles(0.5, omega, found.theta - reach, found.theta + reach)
        parabola = 2 * atan(REACH) / sqrt(found.curvature * found.gap)
        off = abs(float(exact / parabola - 1))
        # Of a path that is followed the share of the last cycle is unknown.
        unknown = 2 * found.curvature * reach / parabola if parabola < 1000 else 0.0
        most = 1.01 * off + unknown + 1e-14 / found.gap
        assert off <= found.relative_error * (1 + 1e-5) <= most


@pytest.mark.parametrize("distance", [1e-4, 1e-8])
def test_a_tongue_of_period_two_leaves_one_passage_at_each_point(distance):
    before = CircleMap.arnold(EDGE_HALF - distance, 1.0)
    found = slow_passages(before, 2)
    assert [(p.period, p.winding, p.direction) for p in found] == [(2, 1, -1), (2, 1, -1)]
    times = [p.passage_cycles for p in found]
    twice = slow_passages(nth_iterate(before, 2))
    assert [2 * p.passage_cycles for p in twice] == pytest.approx(times, rel=1e-6)
    assert abs(times[0] / times[1] - 1) < 10 * distance + 1e-3 * sqrt(distance)
    edge = periodic_points(CircleMap.arnold(EDGE_HALF, 1.0), 2).theta
    agree([p.theta for p in found], edge, 10 * distance)
    assert slow_passages(CircleMap.arnold(EDGE_HALF + 1e-6, 1.0), 2) == []


def test_downward_passages_and_other_windings():
    (down,) = slow_passages(CircleMap.arnold(-(0.9 + 1e-4) / TWO_PI, 0.9))
    assert (down.direction, down.winding) == (-1, 0)
    assert down.gap < 0 > down.curvature
    (next_turn,) = slow_passages(CircleMap.arnold(1 + (0.9 + 1e-4) / TWO_PI, 0.9))
    assert next_turn.winding == 1
    assert slow_passages(CircleMap.arnold(1 + (0.9 + 1e-4) / TWO_PI, 0.9), winding=0) == []


ROOF_AT = np.insert(np.linspace(0, TWO_PI, 9), 4, pi)
ROOF = ROOF_AT + 0.01 + 0.3 * np.abs(ROOF_AT - pi)
NO_BOTTLENECKS = {
    "locked: the curve crosses the line": CircleMap.arnold(0.1, 0.9),
    "even": CircleMap.rigid(0.001),
    "passed in five cycles": CircleMap.arnold(0.3, 1.0),
    "a ripple": CircleMap(lambda x: x + 0.05 + 1e-6 * np.cos(x), lambda x: 1 - 1e-6 * np.sin(x)),
    "within the tangency: a saddle-node": outside(1e-14),
    "an extremum on a kink": CircleMap.from_samples(ROOF_AT, ROOF, [0.7] * 5 + [1.3] * 5),
}


@pytest.mark.parametrize("name", NO_BOTTLENECKS)
def test_what_is_no_bottleneck_is_left_out(name):
    assert slow_passages(NO_BOTTLENECKS[name]) == []


def test_a_passage_of_a_divisor_of_the_period_is_left_out():
    assert slow_passages(outside(1e-3), 2) == []


def test_a_break_inside_the_stretch_leaves_the_error_open():
    def broken(x):
        return x + 1e-3 + 0.45 * (1 - np.sin(x)) + 0.01 * (np.mod(x, TWO_PI) > 1.6)

    (found,) = slow_passages(CircleMap(broken, lambda x: 1 - 0.45 * np.cos(x), [0.0, 1.6]))
    assert found.relative_error == np.inf
    assert abs(found.passage_cycles - pi / sqrt(0.225e-3)) < 1e-4
