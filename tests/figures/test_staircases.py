"""Staircases: steps of a whole turn on plywood, a climb without rest on pu, one direction for good elsewhere."""

import numpy as np
import pytest
from drawn_words import assert_words_apart
from figure_cases import NOWHERE, RECORDED_ABS, SMALL, labels, recorded_folder

from cyclemap.figures.measured_folder import NO_DATA, MeasuredFolder
from cyclemap.figures.simulated_collections import Sampling
from cyclemap.figures.staircases import caption, climb_of, compute, draw

RUNS = 20
# Long enough for plywood to climb; the maps are coarse.
LONG = Sampling(pushes=2000, states=SMALL.states, tolerance=SMALL.tolerance)


@pytest.fixture(scope="module")
def result():
    return compute(NOWHERE, LONG, RUNS)


@pytest.fixture(scope="module")
def measured(measured_data):
    return compute(MeasuredFolder(measured_data), LONG, RUNS)


def test_plywood_climbs_in_steps_of_a_whole_turn_and_faster_as_it_wears(result) -> None:
    plywood = result[0].climb
    assert plywood.steps.count > 5
    assert np.degrees(np.median(plywood.steps.heights)) == pytest.approx(360.0, abs=5.0)
    assert plywood.turn_pushes[:3].mean() > plywood.turn_pushes[-3:].mean()


def test_pu_never_rests_and_the_others_keep_a_direction(result) -> None:
    _, one_abs, delrin, pu = result
    assert pu.climb.steps.levels.size == 0 and pu.climb.turns > 20
    assert delrin.climb.steps.count == 0 and abs(delrin.climb.turns) < 0.1
    assert 0 < one_abs.climb.first_stay < 600
    assert np.cos(np.mean(one_abs.climb.path[1000:]) - np.deg2rad(150.0)) > np.cos(np.deg2rad(15.0))


def test_the_range_of_runs_holds_most_of_each_drawn_run(result) -> None:
    for one in result:
        inside = (one.lower - 1e-9 <= one.climb.path) & (one.climb.path <= one.upper + 1e-9)
        assert np.mean(inside) > 0.5, one.run.surface
        assert one.turns.size == RUNS and one.lower.size == LONG.pushes


def test_measured_plywood_climbs_18_turns_in_steps_of_360_as_the_caption_says(measured) -> None:
    recorded = measured[0].recorded
    assert recorded.turns == pytest.approx(18.0, abs=0.1)
    assert np.degrees(np.median(recorded.steps.heights)) == pytest.approx(360.0, abs=1.0)
    told = caption(measured)
    assert f"The recorded path of 2000 pushes makes {recorded.steps.count} steps of 360°" in told
    assert "ends +18.0 turns from its start" in told
    assert f"first whole one in {recorded.turn_pushes[0]} pushes and the last in {recorded.turn_pushes[-1]}" in told
    assert recorded.turn_pushes[0] > 4 * recorded.turn_pushes[-1]
    assert "that agreement is a fit, not a test" in told
    assert told.endswith(f"Recorded θ0 on abs, delrin and pu: {NO_DATA}.")


def test_axes_have_labels_with_units_and_a_recorded_set_is_drawn(tmp_path_factory) -> None:
    found = compute(recorded_folder(tmp_path_factory), SMALL, RUNS)
    figure = draw(found)
    units = [label.removeprefix("θ0, unwrapped ") for _, label in labels(figure)]
    climbs = [np.ptp(one.climb.path) > 1.1 * 4 * np.pi for one in found]
    assert any(climbs) and all(unit == "(turns)" for unit, climbing in zip(units, climbs, strict=True) if climbing)
    assert set(units) <= {"(turns)", "(°)"}
    assert_words_apart(figure)
    assert found[1].recorded.path.size == RECORDED_ABS and found[3].recorded is None
    assert f"The recorded path of {RECORDED_ABS} pushes" in caption(found)


def test_a_climb_counts_its_turns_and_its_first_stay() -> None:
    path = np.repeat(2 * np.pi * np.arange(5.0), 30)
    climb = climb_of(path, np.pi)
    assert climb.steps.count == 4 and climb.turns == 4.0 and climb.first_stay == 30
    assert climb.turn_pushes.tolist() == [30, 30, 30]
