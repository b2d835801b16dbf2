"""Staircases: bars over the dwells, lengths with censoring, and the drift of what is predicted."""

import numpy as np
import pytest
from drawn_panels import faces, labelled, legend_words, panel, png, written

from cyclemap.maps import (
    CircleMap,
    DriftingMap,
    WrappedNormal,
    compare_steps,
    find_steps,
    predict_drift,
    predict_staircase,
    sample_staircase,
)
from cyclemap.views.step_panels import draw_drift, draw_step_lengths, draw_steps
from cyclemap.views.style import MEASURED, UNSTABLE

STAIRS = np.repeat([0.0, 1.0, 2.0], [20, 30, 40])
GHOST, NOISE = CircleMap.arnold(0.15, 0.9), WrappedNormal(0.05)


def bars(axes):
    return [line for line in axes.lines if len(line.get_xdata()) == 2 and line.get_zorder() == 4]


def test_bars_lie_on_the_dwells_and_are_open_where_censored() -> None:
    steps = find_steps(STAIRS)
    axes = panel()
    draw_steps(axes, STAIRS, steps)
    assert labelled(axes, "path").get_ydata() == pytest.approx(np.degrees(STAIRS))
    places = [(*bar.get_xdata(), bar.get_ydata()[0]) for bar in bars(axes)]
    expected = zip(steps.start, steps.end, np.degrees(steps.levels), strict=True)
    assert np.array(places) == pytest.approx(np.array(list(expected)))
    assert [bar.get_color() == UNSTABLE for bar in bars(axes)] == steps.censored.tolist() == [True, False, True]
    assert written(axes) == ["0.0°", "57.3°", "114.6°"]
    assert legend_words(axes) == ["path", "dwell not seen whole", "dwell"]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("cycle", "θ, unwrapped (°)")
    png(axes)


def test_many_dwells_are_not_named() -> None:
    path = sample_staircase(GHOST, NOISE, 400).theta
    steps = find_steps(path)
    axes = panel()
    draw_steps(axes, path, steps)
    assert len(bars(axes)) == steps.levels.size > 12 and written(axes) == []
    png(axes)


def test_path_without_dwells_is_drawn_alone() -> None:
    path = np.linspace(0.0, 60.0, 300)
    steps = find_steps(path)
    assert steps.levels.size == 0
    axes = panel()
    draw_steps(axes, path, steps)
    assert len(axes.lines) == 1
    png(axes)
    axes = panel()
    draw_step_lengths(axes, steps)
    assert written(axes) == ["no dwell"]
    png(axes)


def test_turns_of_the_zones_are_taken_off_the_path_as_off_the_levels() -> None:
    turning = CircleMap.arnold(1.15, 0.9)
    zones = predict_staircase(turning, NOISE).zones
    assert [zone.winding for zone in zones] == [1]
    path = sample_staircase(turning, NOISE, 150).theta
    steps = find_steps(path, zones=zones)
    axes = panel()
    draw_steps(axes, path, steps)
    drawn = np.radians(labelled(axes, "path").get_ydata())
    assert steps.levels.size > 3
    for start, end, level in zip(steps.start, steps.end, steps.levels, strict=True):
        assert drawn[start : end + 1].min() < level < drawn[start : end + 1].max()
    assert axes.get_ylabel().startswith("θ, unwrapped less 360° a cycle (")


# -- lengths -----------------------------------------------------------------------------------------------


def test_lengths_stand_in_order_beside_their_mean_and_the_prediction() -> None:
    prediction = predict_staircase(GHOST, NOISE)
    path = sample_staircase(GHOST, NOISE, 240).theta
    steps = find_steps(path, zones=prediction.zones)
    comparison = compare_steps(steps, prediction)
    axes = panel()
    draw_step_lengths(axes, steps, comparison)
    whole = labelled(axes, "dwell")
    assert whole.get_ydata().tolist() == steps.lengths[~steps.censored].tolist()
    assert faces(axes) == [(MEASURED, "full", int((~steps.censored).sum()))]
    assert faces(axes, "^") == [(UNSTABLE, "full", int(steps.censored.sum()))]
    assert labelled(axes, "mean").get_ydata()[0] == comparison.mean_length
    assert labelled(axes, "predicted").get_ydata()[0] == comparison.predicted_length
    assert axes.get_ylabel() == "length (cycles)" and axes.get_ylim()[0] == 0.0
    png(axes)


def test_one_censored_dwell_has_no_mean_but_the_prediction_stays() -> None:
    locked = CircleMap.arnold(0.0, 0.9)
    path = sample_staircase(locked, NOISE, 60).theta
    prediction = predict_staircase(locked, NOISE)
    steps = find_steps(path, zones=prediction.zones)
    assert steps.censored.tolist() == [True]
    axes = panel()
    draw_step_lengths(axes, steps, compare_steps(steps, prediction))
    assert legend_words(axes)[0] == "lasted longer than seen"
    assert not any(words.startswith("mean") for words in legend_words(axes))
    assert legend_words(axes)[-1] == "predicted more than 10¹², beyond the panel"
    assert axes.get_ylim()[1] < 100.0
    png(axes)


# -- drift -------------------------------------------------------------------------------------------------


def test_drift_shows_turn_and_residence_on_their_own_axes() -> None:
    noise = WrappedNormal(0.3)
    worn = DriftingMap.between([(0, CircleMap.arnold(0.16, 0.9)), (999, CircleMap.arnold(0.12, 0.9))])
    drift = predict_drift(worn, noise, 1000, 3)
    axes = panel()
    draw_drift(axes, drift)
    (other,) = [twin for twin in axes.get_figure().axes if twin is not axes]
    assert labelled(axes, "mean turn").get_ydata() == pytest.approx(np.degrees(drift.mean_turn))
    assert labelled(other, "mean residence").get_ydata() == pytest.approx(drift.mean_residence_cycles)
    assert (axes.get_ylabel(), other.get_ylabel()) == ("mean turn (° a cycle)", "mean residence (cycles)")
    assert legend_words(axes)[:2] == ["mean turn", "mean residence"]
    assert legend_words(axes)[2].startswith(f"in all {drift.turns:.3g} turns, give or take ")
    png(axes)


def test_drift_without_slow_zones_has_no_residence() -> None:
    worn = DriftingMap.between([(0, CircleMap.rigid(0.1)), (99, CircleMap.rigid(0.3))])
    axes = panel()
    draw_drift(axes, predict_drift(worn, WrappedNormal(0.3), 100, 2))
    assert axes.get_figure().axes == [axes]
    assert legend_words(axes)[1].startswith("in all 20 turns")
    png(axes)
