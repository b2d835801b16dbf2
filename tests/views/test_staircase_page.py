"""The staircase page draws what was predicted and measured, and its sentences carry the numbers."""

import math
from functools import cache

import numpy as np
import pytest

from cyclemap.collection import StaircaseForecast, staircase_forecast
from cyclemap.evidence import MeasuredStaircase, Theta0Pairs, measured_staircase
from cyclemap.maps import CircleMap, WrappedNormal, sample_staircase
from cyclemap.views import staircase_page as sentences
from cyclemap.views.sentences import power_of_ten
from cyclemap.views.staircase_page import staircase_page
from cyclemap.views.style import render

GHOST, WELL, TURNING = (0.0955, 0.6), (0.1, 0.9), (0.3, 0.0)


@pytest.fixture(scope="module")
def forecast(loop_of):
    """The forecast of a sine map."""

    @cache
    def make(omega: float, strength: float) -> StaircaseForecast:
        return staircase_forecast(loop_of(CircleMap.arnold(omega, strength)), sigma=0.03, cycles=3_000)

    return make


@pytest.fixture(scope="module")
def measured() -> MeasuredStaircase:
    path = sample_staircase(CircleMap.arnold(0.11, 0.6), WrappedNormal(0.03), 2_000, seed=2).theta
    return measured_staircase(Theta0Pairs(path[:-1], path[1:], path))


@pytest.mark.slow
def test_a_page_shows_the_whole_run_and_every_dwell(forecast) -> None:
    found = forecast(*GHOST)
    paths, steps, lengths = staircase_page(found).axes
    assert np.allclose(paths.lines[0].get_ydata(), np.degrees(found.run.theta))
    bars = [line for line in steps.lines if line.get_linewidth() in (5.0, 2.2)]
    assert len(bars) == found.steps.levels.size > 10
    drawn = sum(len(line.get_xdata()) for line in lengths.lines if line.get_linestyle() == "None")
    assert drawn == found.steps.levels.size


def test_with_data_the_paths_are_the_measured_the_predicted_and_the_fitted(forecast, measured) -> None:
    paths = staircase_page(forecast(*GHOST), measured).axes[0]
    names = ["map fitted to all data alike, without wear", "measured", "predicted"]
    assert [line.get_label() for line in paths.lines] == names
    assert np.allclose(paths.lines[1].get_ydata(), np.degrees(measured.path))
    assert np.allclose(paths.lines[0].get_ydata(), np.degrees(measured.run.theta))
    low, high = paths.get_ylim()
    assert all(low < line.get_ydata().min() and line.get_ydata().max() < high for line in paths.lines)


def test_a_climb_of_turns_is_marked_in_whole_turns(forecast) -> None:
    """Ticks stand at whole turns of the drawn degrees and say the number of turns."""
    axes = staircase_page(forecast(*GHOST)).axes[0]
    axes.figure.canvas.draw()
    assert axes.get_ylabel() == "θ0, unwrapped (turns)"
    ticks = {label.get_text(): float(label.get_position()[1]) for label in axes.get_yticklabels()}
    assert len(ticks) > 2
    assert all(place == 360.0 * int(words.replace("−", "-")) for words, place in ticks.items())


def test_counts_have_whole_ticks_even_where_there_is_one(forecast) -> None:
    """A single dwell stands over the tick 1, not between fractions of dwells."""
    lengths = staircase_page(forecast(*WELL)).axes[2]
    assert all(float(tick).is_integer() for tick in lengths.get_xticks())


@pytest.mark.slow
@pytest.mark.parametrize("law", [GHOST, WELL, TURNING])
def test_every_kind_of_staircase_can_be_rendered(forecast, law) -> None:
    assert render(staircase_page(forecast(*law))).startswith(b"\x89PNG")


def test_a_ghost_is_told_with_its_rest_and_its_steps(forecast) -> None:
    found = forecast(*GHOST)
    zone = found.prediction.zones[0]
    said = sentences.forecast_sentence(found)
    place, rest = math.degrees(zone.centre), zone.residence_cycles
    assert said.startswith(
        f"With 1.7° of noise a cycle θ0 rests near {place:.1f}° for {rest:.0f} cycles; steps are 360°"
    )


def test_a_rest_beyond_every_float_is_told_by_its_power_of_ten(forecast) -> None:
    found = forecast(*WELL)
    power = math.floor(found.log10_residences[0])
    assert power > 200
    assert (
        f"for {power_of_ten(power)} cycles; steps are 360° high, none to be expected."
        in sentences.forecast_sentence(found)
    )
    assert "it stays at" in sentences.run_sentence(found)


def test_a_rotation_rests_nowhere(forecast) -> None:
    assert "rests nowhere: it moves 108.00° a cycle" in sentences.forecast_sentence(forecast(*TURNING))


def test_measured_and_fitted_sentences_carry_the_numbers(measured) -> None:
    said = sentences.measured_sentence(measured)
    assert said.startswith(f"In the 2001 measured cycles it makes {measured.steps.count} steps of ")
    assert said.endswith(f"a full turn took {measured.cycles_a_turn:.0f} cycles.")
    told = sentences.fitted_sentence(measured)
    assert f"predicts {measured.comparison.expected_steps:.1f} steps of 360°" in told
    assert f"where {measured.comparison.net_steps:.1f} were climbed" in told
