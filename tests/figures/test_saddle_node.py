"""The saddle-node figure: what its caption claims, on a small version."""

import math

import numpy as np
import pytest
from figure_cases import exhibited

from cyclemap.collection import CollectionLoop
from cyclemap.figures.loop_family import with_ring_at

result = exhibited("saddle-node")


def test_the_pair_stands_where_an_independent_solver_found_it_and_meets_above_9_8_mm(
    result,
) -> None:
    for radius, stable, unstable in ((0.013, 99.9, 193.1), (0.010, 152.6, 171.4)):
        assert np.degrees(result.directions(radius)) == pytest.approx((stable, unstable), abs=0.6)
    assert 1000 * result.fold.radius == pytest.approx(9.7932, abs=1e-3)
    assert float(result.branch.special[0].parameter) == pytest.approx(result.fold.radius, abs=2e-5)
    assert [special.kind for special in result.branch.special] == ["saddle-node"]


def test_nothing_repeats_inside_the_fold_and_the_turn_touches_zero_on_it(result) -> None:
    before, at, beyond = (np.degrees(turn) for _, _, turn in result.graphs)
    assert np.sum(np.diff(np.sign(before)) != 0) == 2
    assert abs(at.min()) < 0.05
    assert beyond.min() > 1.0


def test_the_passage_lengthens_as_one_over_the_root_of_the_distance_and_cycles_that_are_run_agree(
    result,
) -> None:
    near, far = result.cycles_a_turn[0], result.cycles_a_turn[-1]
    assert near > 5 * far
    # A turn is the bottleneck's passage and a rest that hardly depends on the distance.
    rest = result.cycles_a_turn - result.passage
    assert np.ptp(rest) < 0.05 * near
    slope = np.polyfit(np.log(result.distances), np.log(result.passage), 1)[0]
    assert slope == pytest.approx(-0.5, abs=1e-9)
    distance, cycles = np.log(result.counted[0])
    curve = np.log([result.distances, result.cycles_a_turn])
    assert cycles == pytest.approx(np.interp(distance, *curve), abs=0.05)


def test_the_stated_error_holds_on_a_cycle_of_its_own(result) -> None:
    radius = 0.0125
    stable = result.directions(radius)[0]
    loop = with_ring_at(CollectionLoop.mit(material="plywood"), radius)
    assert abs(loop.cycle(stable).theta_next - stable) < max(3 * result.error, math.radians(0.05))
