"""The pair of directions that meets as the ring moves in, and where the robot locks in: what both
captions claim, on small versions.
"""

import math
from functools import partial

import numpy as np
import pytest
from figure_cases import exhibited

from cyclemap.collection import CollectionLoop
from cyclemap.figures.loop_family import ring_fold, with_anisotropy_times, with_ring_at
from cyclemap.figures.ring_distance import RADII, phase_caption
from cyclemap.maps import fixed_points

PLYWOOD = CollectionLoop.mit(material="plywood")
pair = exhibited("saddle-node")
phases = exhibited("phase-diagram")


def test_the_pair_stands_where_an_independent_solver_found_it_and_meets_above_9_8_mm(
    pair,
) -> None:
    for radius, stable, unstable in ((0.013, 99.9, 193.1), (0.010, 152.6, 171.4)):
        assert np.degrees(pair.directions(radius)) == pytest.approx((stable, unstable), abs=0.6)
    assert 1000 * pair.fold.radius == pytest.approx(9.7932, abs=1e-3)
    assert float(pair.branch.special[0].parameter) == pytest.approx(pair.fold.radius, abs=2e-5)
    assert [special.kind for special in pair.branch.special] == ["saddle-node"]


def test_nothing_repeats_inside_the_fold_and_the_turn_touches_zero_on_it(pair) -> None:
    before, at, beyond = (np.degrees(turn) for _, turn in pair.graphs)
    assert np.sum(np.diff(np.sign(before)) != 0) == 2
    assert abs(at.min()) < 0.05
    assert beyond.min() > 1.0


def test_the_passage_lengthens_as_one_over_the_root_of_the_distance_and_cycles_that_are_run_agree(
    pair,
) -> None:
    near, far = pair.cycles_a_turn[0], pair.cycles_a_turn[-1]
    assert near > 5 * far
    # A turn is the bottleneck's passage and a rest that hardly depends on the distance.
    rest = pair.cycles_a_turn - pair.passage
    assert np.ptp(rest) < 0.05 * near
    slope = np.polyfit(np.log(pair.distances), np.log(pair.passage), 1)[0]
    assert slope == pytest.approx(-0.5, abs=1e-9)
    distance, cycles = np.log(pair.counted[0])
    curve = np.log([pair.distances, pair.cycles_a_turn])
    assert cycles == pytest.approx(np.interp(distance, *curve), abs=0.05)


def test_the_stated_error_holds_on_a_cycle_of_its_own(pair) -> None:
    radius = 0.0125
    stable = pair.directions(radius)[0]
    loop = with_ring_at(PLYWOOD, radius)
    assert abs(loop.cycle(stable).theta_next - stable) < max(3 * pair.error, math.radians(0.05))


def fixed_directions(loop):
    return len(fixed_points(loop.circle_map(tolerance=1e-4)))


def test_at_the_tip_of_the_tongue_isotropic_friction_turns_the_object_by_nothing(phases) -> None:
    tip = with_ring_at(with_anisotropy_times(PLYWOOD, 0.0), phases.first.neutral)
    assert abs(tip.cycle(1.0).theta_next - 1.0) < math.radians(0.05)
    assert 1000 * phases.first.neutral == pytest.approx(21.3, abs=0.1)
    assert np.nanmin(phases.first.scale) < 0.02


def test_the_grid_is_locked_between_the_edges_and_winds_outside(phases) -> None:
    locked = phases.plane.period == 1
    assert 20 < locked.sum() < locked.size - 20
    assert np.all(phases.stable[locked] == 1)
    compared = 0
    for edge, outside in ((phases.inner, -1), (phases.outer, 1)):
        for scale, fold in edge:
            column = int(np.argmin(np.abs(phases.plane.second_values - scale)))
            if abs(phases.plane.second_values[column] - scale) > 0.03:
                continue
            away = outside * (phases.plane.first_values - fold.radius)
            assert not locked[away > 0.001, column].any()
            compared += 1
    assert compared >= 1


def test_edges_are_folds_of_the_mechanics_with_fixed_points_on_one_side_only(phases) -> None:
    assert len(phases.inner) == len(phases.outer) == 2
    scale, fold = phases.inner[0]
    surface = with_anisotropy_times(PLYWOOD, scale)
    for radius, count in ((fold.radius - 2e-4, 0), (fold.radius + 2e-4, 2)):
        assert fixed_directions(with_ring_at(surface, radius)) == count
    for radius, edge in zip(RADII, (phases.inner, phases.outer), strict=True):
        assert edge[-1][1].radius == pytest.approx(radius, abs=5e-4)


def test_the_first_order_edge_is_missed_by_the_square_of_the_anisotropy(phases) -> None:
    """First order gives ε to O(ε²): halving ε quarters what it misses on the exact edge."""
    first, misses = phases.first, []
    ahead = first.radius < first.neutral
    grid = 2 * np.pi * np.arange(24) / 24
    for scale in (0.3, 0.15):
        surface = with_anisotropy_times(PLYWOOD, scale)
        start = float(np.interp(-scale, -first.scale[ahead], first.radius[ahead]))
        theta = float(grid[np.argmin(with_ring_at(surface, start).next_theta(grid) - grid)])
        fold = ring_fold(partial(with_ring_at, surface), theta, start)
        misses.append(
            float(np.interp(fold.radius, first.radius[ahead], first.scale[ahead])) - scale
        )
    assert misses[0] / misses[1] == pytest.approx(4.0, rel=0.35)


def test_the_mit_ring_locks_on_plywood_and_from_the_scale_that_the_caption_tells(phases) -> None:
    assert phases.mit == pytest.approx(0.015)
    for scale, count in ((phases.mit_scale - 0.03, 0), (phases.mit_scale + 0.03, 2)):
        assert fixed_directions(with_anisotropy_times(PLYWOOD, scale)) == count
    assert f"{phases.mit_scale:.2f} times Table I" in phase_caption(phases)
    assert "one stable direction" in phase_caption(phases)
