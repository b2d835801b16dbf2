"""The wearing map: what the caption claims, on a small version and on measured data."""

import math

import numpy as np
import pytest
from figure_cases import assert_drawn

from cyclemap.collection import CollectionLoop, worn_loop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.figures import bottleneck as figure
from cyclemap.figures.bottleneck import AGES, MATERIAL, wear_drift
from cyclemap.figures.catalogue import MeasuredFolder
from cyclemap.maps import WrappedNormal, fixed_points, transfer_operator

pytestmark = pytest.mark.slow


NAME = "wear-drift"


def test_the_least_turn_grows_and_passes_zero_at_the_cycle_told(result) -> None:
    assert np.all(np.diff(result.least) > 0.0)
    assert np.degrees(result.least[[0, -1]]) == pytest.approx((-1.22, 0.31), abs=0.1)
    assert result.opened == pytest.approx(1059, abs=60)
    assert f"cycle {result.opened:.0f}" in figure.wear_caption(result)


def test_before_that_cycle_a_direction_holds_the_robot_and_after_it_none_does(result) -> None:
    loop = CollectionLoop.mit(material=MATERIAL)
    counts = [
        len(fixed_points(worn_loop(loop, result.opened + off).circle_map(tolerance=1e-4)))
        for off in (-200, 200)
    ]
    assert counts == [2, 0]


def test_the_interpolated_turns_are_those_of_the_worn_loops(result) -> None:
    loop = worn_loop(CollectionLoop.mit(material=MATERIAL), AGES[1])
    turn = loop.cycle(math.radians(100.0)).theta_next - math.radians(100.0)
    assert result.turns[1][200] == pytest.approx(turn, abs=max(2 * result.error, 1e-3))
    assert result.error < math.radians(0.3)


def test_a_turn_takes_fewer_and_fewer_cycles_about_as_many_as_the_robot_took_late(result) -> None:
    assert np.isnan(result.cycles_a_turn[0]) and np.all(np.diff(result.cycles_a_turn)[1:] < 0.0)
    assert result.cycles_a_turn[-1] == pytest.approx(60, abs=15)
    noise = WrappedNormal(DEFAULT_SIGMA)
    worn = worn_loop(CollectionLoop.mit(material=MATERIAL), 2000.0).circle_map(tolerance=1e-4)
    theta = 2 * np.pi * np.arange(4096) / 4096
    turns = transfer_operator(worn, noise).density(theta) * worn.turn(theta)
    assert result.rotation[-1] == pytest.approx(np.mean(turns), rel=0.05)
    assert 15 < result.expected_turns < 22


def test_the_robot_took_257_cycles_a_turn_early_on_and_45_late(measured_data, result) -> None:
    found = wear_drift(MeasuredFolder(measured_data), points=3, runs=8, harmonics=10)
    pace = found.pace
    assert pace.measured[[0, -1]] == pytest.approx((257, 45), abs=2)
    assert pace.inside > 0.6
    assert found.measured_least is not None and found.least == pytest.approx(result.least)
    assert found.measured_least[-1] > found.measured_least[0]
    assert found.measured_turns is not None
    assert np.isnan(found.measured_turns[0]).mean() > 0.5
    assert np.isnan(found.measured_turns[2]).mean() < 0.1
    assert_drawn(figure.draw_wear(found), 4)
    assert (
        f"took {pace.measured[0]:.0f} cycles early on and {pace.measured[-1]:.0f} late"
        in figure.wear_caption(found)
    )
