"""The staircase's page and its words."""

import math
from functools import cache

import pytest

from cyclemap.collection import StaircaseForecast, staircase_forecast
from cyclemap.evidence import MeasuredStaircase, Theta0Pairs, measured_staircase
from cyclemap.maps import CircleMap, WrappedNormal, sample_staircase
from cyclemap.views import portrait_page as sentences
from cyclemap.views.panels.layout import render
from cyclemap.views.portrait_page import staircase_page

GHOST, WELL, TURNING = (0.0955, 0.6), (0.1, 0.9), (0.3, 0.0)


@pytest.fixture(scope="module")
def forecast(loop_of):
    """The forecast of a sine map."""

    @cache
    def make(omega: float, strength: float) -> StaircaseForecast:
        loop = loop_of(CircleMap.arnold(omega, strength))
        return staircase_forecast(loop, sigma=0.03, cycles=3_000)

    return make


@pytest.fixture(scope="module")
def measured() -> MeasuredStaircase:
    path = sample_staircase(CircleMap.arnold(0.11, 0.6), WrappedNormal(0.03), 2_000, seed=2).theta
    return measured_staircase(Theta0Pairs(path[:-1], path[1:], path))


def test_a_climb_of_turns_is_marked_in_whole_turns(forecast) -> None:
    axes = staircase_page(forecast(*GHOST)).axes[0]
    axes.figure.canvas.draw()
    assert axes.get_ylabel() == "θ0, unwrapped (turns)"
    ticks = {label.get_text(): float(label.get_position()[1]) for label in axes.get_yticklabels()}
    assert len(ticks) > 2
    assert all(place == 360.0 * int(words.replace("−", "-")) for words, place in ticks.items())


@pytest.mark.slow
@pytest.mark.parametrize("law", [GHOST, WELL, TURNING])
def test_every_kind_of_staircase_can_be_rendered_with_whole_counts(forecast, law) -> None:
    page = staircase_page(forecast(*law))
    assert render(page).startswith(b"\x89PNG")
    assert all(float(tick).is_integer() for tick in page.axes[2].get_xticks())
    rests = law != TURNING
    assert (len(page.axes[2].texts) == 0) is rests
    nowhere = "rests nowhere: it moves 108.00° a cycle"
    assert (nowhere in sentences.forecast_sentence(forecast(*law))) is not rests


def test_rests_are_told_by_their_length_or_by_its_power_of_ten(forecast) -> None:
    ghost, well = forecast(*GHOST), forecast(*WELL)
    (zone, *_), power = ghost.prediction.zones, math.floor(well.log10_residences[0])
    place = f"{math.degrees(zone.centre):.1f}° for {zone.residence_cycles:.0f} cycles"
    told = f"With 1.7° of noise a cycle θ0 rests near {place}; steps are 360°"
    assert sentences.forecast_sentence(ghost).startswith(told)
    assert power > 200
    told = f"for 10^{power} cycles; steps are 360° high, none to be expected."
    assert told in sentences.forecast_sentence(well)
    assert "it stays at" in sentences.run_sentence(well)
    lengths = staircase_page(well).axes[2]
    told = [text.get_text() for text in lengths.get_legend().get_texts()]
    assert told[-1] == "predicted more than 10^12, beyond the panel"
    assert lengths.get_ylim()[1] < 10_000.0


def test_measured_and_fitted_sentences_carry_the_numbers(measured) -> None:
    said = sentences.measured_sentence(measured)
    assert said.startswith(f"In the 2001 measured cycles it makes {measured.steps.count} steps of ")
    assert said.endswith(f"a full turn took {measured.cycles_a_turn:.0f} cycles.")
    told = sentences.fitted_sentence(measured)
    assert f"predicts {measured.foretold.comparison.expected_steps:.1f} steps of 360°" in told
    assert f"where {measured.foretold.comparison.net_steps:.1f} were climbed" in told
