"""A staircase and its bottleneck, and the map as plywood wears: what both captions claim, on small
versions and on measured data.
"""

import math

import numpy as np
import pytest
from figure_cases import assert_drawn, exhibited
from refusals import refused

from cyclemap.collection import CollectionLoop, worn_loop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import ConvergenceError
from cyclemap.figures import THETA0_FILE, bottleneck as figure
from cyclemap.figures.bottleneck import (
    AGES,
    MATERIAL,
    beside_measured,
    bottleneck,
    measured_bottleneck,
)
from cyclemap.maps import (
    CircleMap,
    WrappedNormal,
    fixed_points,
    sample_staircase,
    transfer_operator,
)

stairs = exhibited("staircase-bottleneck")
drift = exhibited("wear-drift")
WEARING = CollectionLoop.mit(material=MATERIAL)


def test_no_direction_repeats_and_the_slowest_is_where_the_saddle_node_was(stairs) -> None:
    computed = stairs.computed
    turn = np.degrees(computed.map.turn(np.linspace(0.0, 2 * np.pi, 2_000)))
    assert 0.0 < turn.min() < 0.5
    assert math.degrees(computed.passage.theta) == pytest.approx(162.7, abs=1.0)
    assert math.degrees(computed.passage.gap) == pytest.approx(turn.min(), abs=0.01)


def test_steps_sampled_last_as_long_as_predicted_and_about_as_passage_theory_says(stairs) -> None:
    computed = stairs.computed
    mean, spread = computed.visit
    count = computed.lengths.size
    assert count > 80
    assert computed.lengths.mean() == pytest.approx(mean, abs=4 * spread / math.sqrt(count))
    assert computed.lengths.std() == pytest.approx(spread, rel=0.35)
    assert computed.passage.passage_cycles == pytest.approx(mean, rel=0.15)


def test_the_passage_law_fits_the_predicted_directions_at_the_bottleneck(stairs) -> None:
    """Where a cycle moves by v, a path is 1/v as often: the density's peak is that of the passage
    law.
    """
    computed = stairs.computed
    law = float(computed.prediction.mean_turn) / (2 * np.pi) / computed.passage.gap
    assert computed.density.max() == pytest.approx(law, rel=0.15)
    circle = np.linspace(0.0, 2 * np.pi, 721)
    assert np.trapezoid(computed.density, circle) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.slow
def test_the_measured_staircase_has_a_bottleneck_near_95_degrees_and_its_steps_shorten(
    stairs, measured_data
) -> None:
    found = measured_bottleneck(measured_data / THETA0_FILE)
    assert math.degrees(found.passage.theta) == pytest.approx(95.0, abs=5.0)
    first, second = np.array_split(found.lengths, 2)
    assert found.lengths.size >= 10
    assert first.mean() > 1.5 * second.mean()
    mean, spread = found.visit
    error = found.lengths.std() / math.sqrt(found.lengths.size)
    assert abs(found.lengths.mean() - mean) < 2 * error
    assert found.lengths.std() > 1.3 * spread
    assert found.run.shape == found.path.shape and found.run[0] == found.path[0]
    both = type(stairs)(stairs.computed, found)
    assert_drawn(figure.draw_bottleneck(both), 8)
    assert "95°" in figure.bottleneck_caption(both)


def test_measured_pairs_without_an_order_and_a_map_without_bottleneck_are_refused(tmp_path) -> None:
    rows = "".join(f"{k},{k + 2}\n" for k in range(50))
    (tmp_path / "pairs.csv").write_text(f"theta0_deg,theta_next_deg\n{rows}")
    refused(measured_bottleneck, tmp_path / "pairs.csv", told="no known order")
    turn = CircleMap.rigid(0.1)
    path = sample_staircase(turn, WrappedNormal(0.1), 100).theta
    refused(bottleneck, "a rotation", turn, 0.1, path, told="no bottleneck", kind=ConvergenceError)


@pytest.mark.slow
def test_up_to_the_cycle_told_a_direction_holds_the_robot_and_after_it_none_does(drift) -> None:
    assert np.all(np.diff(drift.least) > 0.0)
    assert np.degrees(drift.least[[0, -1]]) == pytest.approx((-1.22, 0.31), abs=0.1)
    assert drift.opened == pytest.approx(1059, abs=60)
    assert f"cycle {drift.opened:.0f}" in figure.wear_caption(drift)
    ages = (drift.opened - 200, drift.opened + 200)
    worn = [worn_loop(WEARING, age).circle_map(tolerance=1e-4) for age in ages]
    assert [len(fixed_points(circle_map)) for circle_map in worn] == [2, 0]


@pytest.mark.slow
def test_the_interpolated_turns_are_those_of_the_worn_loops(drift) -> None:
    start = math.radians(100.0)
    turn = worn_loop(WEARING, AGES[1]).cycle(start).theta_next - start
    assert drift.turns[1][200] == pytest.approx(turn, abs=max(2 * drift.error, 1e-3))
    assert drift.error < math.radians(0.3)


@pytest.mark.slow
def test_a_turn_takes_fewer_and_fewer_cycles_about_as_many_as_the_robot_took_late(drift) -> None:
    assert np.isnan(drift.cycles_a_turn[0]) and np.all(np.diff(drift.cycles_a_turn)[1:] < 0.0)
    assert drift.cycles_a_turn[-1] == pytest.approx(60, abs=15)
    worn = worn_loop(WEARING, 2000.0).circle_map(tolerance=1e-4)
    theta = 2 * np.pi * np.arange(4096) / 4096
    density = transfer_operator(worn, WrappedNormal(DEFAULT_SIGMA)).density(theta)
    assert drift.rotation[-1] == pytest.approx(np.mean(density * worn.turn(theta)), rel=0.05)
    assert 15 < drift.expected_turns < 22


@pytest.mark.slow
def test_the_robot_took_257_cycles_a_turn_early_on_and_45_late(measured_data, drift) -> None:
    found = beside_measured(drift, measured_data / THETA0_FILE, runs=8, harmonics=10)
    first, last = found.pace.measured[[0, -1]]
    assert (first, last) == pytest.approx((257, 45), abs=2)
    assert found.pace.inside > 0.6
    assert found.measured_least[-1] > found.measured_least[0]
    unseen = [np.isnan(turn).mean() for turn in found.measured_turns]
    assert unseen[0] > 0.5 and unseen[2] < 0.1
    assert_drawn(figure.draw_wear(found), 4)
    told = f"took {first:.0f} cycles early on and {last:.0f} late"
    assert told in figure.wear_caption(found)
