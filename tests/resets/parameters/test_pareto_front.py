"""Fronts and volumes against their definitions, by brute force on small cases."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cyclemap.errors import InvalidInput
from cyclemap.resets.parameters.pareto_front import Candidate, hypervolume, non_dominated, pareto_front
from cyclemap.resets.strategies.drag_strategies import StraightReset

# Few whole values, so that ties and duplicates are common.
POINTS = st.tuples(st.integers(1, 14), st.integers(1, 4)).flatmap(
    lambda shape: arrays(np.float64, shape, elements=st.integers(0, 4).map(float))
)


def _dominates(p, q):
    return all(a <= b for a, b in zip(p, q, strict=True)) and any(a < b for a, b in zip(p, q, strict=True))


@settings(max_examples=120, deadline=None)
@given(POINTS)
def test_the_front_is_what_no_point_dominates(points):
    """Against the definition, pair by pair; and every point is dominated by one of the front, or is on it."""
    found = non_dominated(points)
    rows = points.tolist()
    assert found.tolist() == [not any(_dominates(p, q) for p in rows) for q in rows]
    assert found.any()
    front = [p for p, kept in zip(rows, found, strict=True) if kept]
    assert all(kept or any(_dominates(p, q) for p in front) for q, kept in zip(rows, found, strict=True))


@settings(max_examples=60, deadline=None)
@given(POINTS)
def test_the_volume_is_the_number_of_unit_cubes_that_are_dominated(points):
    """Points with whole coordinates below a whole reference: the cubes with a point at or below them are counted."""
    dims, top = points.shape[1], 4
    cubes = product(range(top), repeat=dims)
    count = sum(any(all(a <= b for a, b in zip(p, cube, strict=True)) for p in points.tolist()) for cube in cubes)
    assert hypervolume(points, np.full(dims, float(top))) == count


@settings(max_examples=40, deadline=None)
@given(POINTS, st.randoms())
def test_order_and_dominated_points_do_not_change_front_or_volume(points, random):
    order = list(range(len(points)))
    random.shuffle(order)
    reference = np.full(points.shape[1], 5.0)
    shuffled = points[order]
    assert non_dominated(shuffled).tolist() == non_dominated(points)[order].tolist()
    volumes = {hypervolume(part, reference) for part in (points, shuffled, points[non_dominated(points)])}
    assert len(volumes) == 1


def test_a_known_staircase_of_three():
    """(1, 3), (2, 2), (3, 1) below (4, 4): 1 + 2 + 3 unit squares; a point outside adds nothing."""
    points = [(1.0, 3.0), (2.0, 2.0), (3.0, 1.0), (0.0, 5.0)]
    assert hypervolume(points, (4.0, 4.0)) == 6.0
    assert hypervolume(points[:1], (1.0, 4.0)) == 0.0 and hypervolume(np.empty((0, 2)), (1.0, 1.0)) == 0.0


def _front():
    rows = [("a", (0.3, 1.0)), ("b", (0.1, 3.0)), ("c", (0.2, 2.0)), ("d", (0.2, 2.5)), ("e", (0.2, 2.0))]
    return pareto_front([Candidate(title, values, StraightReset()) for title, values in rows], ("bias", "cost"))


def test_a_front_is_sorted_and_keeps_the_dominated_apart():
    """Twins stay both; the front's rows rise in the first value and fall in the second."""
    front = _front()
    assert [one.title for one in front.candidates] == ["b", "c", "e", "a"]
    assert [one.title for one in front.dominated] == ["d"] and front.dominated_points.tolist() == [[0.2, 2.5]]
    assert np.all(np.diff(front.points[:, 0]) >= 0.0) and np.all(np.diff(front.points[:, 1]) <= 0.0)
    assert abs(front.hypervolume((0.4, 4.0)) - (0.1 * 3.0 + 0.1 * 2.0 + 0.1 * 1.0)) < 1e-12


def test_the_best_within_limits_is_on_the_front():
    front = _front()
    assert front.best("bias").title == "b" and front.best("cost").title == "a"
    assert front.best("bias", {"cost": 2.2}).title == "c" and front.best("cost", {"bias": 0.15}).title == "b"
    assert front.best("bias", {"cost": 0.5}) is None
    for one in front.candidates:
        limits = dict(zip(front.names, one.values.tolist(), strict=True))
        kept = front.best("bias", limits)
        assert kept is not None and np.array_equal(kept.values, one.values), "a limit that is just kept is kept"


def test_more_candidates_join_a_front_as_if_they_had_been_there():
    front = _front().with_candidates([Candidate("f", (0.1, 0.5)), Candidate("g", (0.05, 9.0))])
    assert [one.title for one in front.candidates] == ["g", "f"] and len(front.dominated) == 5


def test_bad_candidates_are_refused():
    with pytest.raises(InvalidInput, match="one candidate or more"):
        pareto_front([], ("bias",))
    with pytest.raises(InvalidInput, match="has 2 values for the 1 names"):
        pareto_front([Candidate("two", (1.0, 2.0))], ("bias",))
    with pytest.raises(InvalidInput, match="finite"):
        Candidate("nothing", (np.nan,))
    with pytest.raises(InvalidInput, match="the strategy of 'odd' is none"):
        Candidate("odd", (1.0,), strategy="straight")
    with pytest.raises(InvalidInput, match="'cots'"):
        _front().best("cots")
