"""Many loops at once come to what each comes to alone, in the order that they were given."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop, Cycles, run_cycles
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.mechanics import DragBack, Ellipse, Pusher, SidePush, Slider, grid_footprint

THETA = np.array([-4.0, 0.5, 2.0, 7.0])
MIT = CollectionLoop.mit(accuracy=1e-6)
SQUARE = MIT.slider.outline


def mixture() -> list[CollectionLoop]:
    """Loops that differ in everything."""
    return [
        MIT,
        CollectionLoop.mit("delrin", accuracy=1e-7),
        replace(MIT, footprint=grid_footprint(SQUARE, 3)),
        replace(MIT, slider=Slider(Ellipse(0.04, 0.03), hitch=(0.0, 0.01)), push=SidePush(0, 0.2, 0.1, 0.08)),
        replace(MIT, reset=DragBack(((0.1, 0.05), (-0.02, 0.1)), 0.001), pusher=Pusher(0.003, 0.4)),
        replace(MIT, pusher=Pusher(0.0)),
        replace(MIT, push=SidePush(2, 0.4, -0.3, 0.05), accuracy=1e-8),
    ]


def same(one: Cycles, other: Cycles) -> None:
    for field in fields(Cycles):
        np.testing.assert_allclose(getattr(one, field.name), getattr(other, field.name), rtol=0.0, atol=1e-11)


def taken(cycles: Cycles, *index) -> Cycles:
    return Cycles(*(getattr(cycles, field.name)[index] for field in fields(Cycles)))


def test_a_mixture_comes_to_what_its_loops_come_to_one_by_one():
    loops = mixture()
    cycles = run_cycles(loops, THETA)
    assert cycles.theta_next.shape == (7, 4) and cycles.push_displacement.shape == (7, 4, 2)
    assert cycles.left.dtype == bool and 0 < cycles.left.sum() < cycles.left.size
    for number, loop in enumerate(loops):
        same(taken(cycles, number), loop.cycles(THETA))
        one = loop.cycle(THETA[1])
        assert cycles.theta_next[number, 1] == pytest.approx(one.theta_next, abs=1e-11)
        assert cycles.left[number, 1] == (one.ended == "left")
    assert np.ptp(cycles.theta_next, axis=0).min() > 0.1


def test_orientations_are_each_loops_own_or_everyones():
    loops, order = mixture()[:2], [3, 0, 2, 1]
    common = run_cycles(loops, THETA)
    same(run_cycles(loops, np.stack([THETA, THETA])), common)
    crossed = run_cycles(loops, np.stack([THETA, THETA[order]]))
    same(taken(crossed, 0), taken(common, 0))
    same(taken(crossed, 1), taken(common, 1, order))


def test_loops_in_another_order_are_the_same_cycles_in_that_order():
    loops, order = mixture(), [4, 6, 0, 3, 2, 5, 1]
    same(run_cycles([loops[k] for k in order], THETA), taken(run_cycles(loops, THETA), order))


def test_nothing_to_run_is_no_cycles():
    assert run_cycles([], THETA).theta.shape == (0, 4)
    assert run_cycles([MIT], np.zeros(0)).push_displacement.shape == (1, 0, 2)


REFUSED = [
    (replace(MIT, push=SidePush(side=9)), InvalidInput, "side 9 does not exist"),
    (replace(MIT, accuracy=1.0), InvalidInput, "accuracy 1.0 is out of reach"),
]


@pytest.mark.parametrize(("loop", "kind", "told"), REFUSED, ids=["a side too many", "accuracy"])
def test_a_refusal_is_that_of_the_cycle_and_tells_which(loop, kind, told):
    with pytest.raises(kind, match=told) as alone:
        loop.cycle(2.0)
    with pytest.raises(kind, match=f"loop 1: .*{told}") as among:
        run_cycles([MIT, loop], [2.0, 3.0])
    assert type(among.value) is type(alone.value) and not isinstance(among.value, ConvergenceError)


@pytest.mark.parametrize(
    ("loops", "theta", "told"),
    [
        ([MIT, "plywood"], [0.0], "loop 1 must be a CollectionLoop, not 'plywood'"),
        ([MIT], 0.0, r"shape \(n,\) for all loops or \(1, n\), one row a loop, not \(\)"),
        ([MIT, MIT], np.zeros((3, 2)), r"or \(2, n\), one row a loop, not \(3, 2\)"),
        ([MIT], [math.nan], "theta must be finite"),
    ],
)
def test_what_is_no_batch_is_refused(loops, theta, told):
    with pytest.raises(InvalidInput, match=told):
        run_cycles(loops, theta)
