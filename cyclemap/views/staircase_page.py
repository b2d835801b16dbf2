"""A predicted staircase, and the measured one where there is one: in sentences, and on a landscape
page.
"""

import math

import numpy as np
from matplotlib.figure import Figure

from cyclemap.collection.portrait import StaircaseForecast
from cyclemap.evidence import MeasuredStaircase
from cyclemap.maps import StaircaseSummary, StepComparison, Steps
from cyclemap.views import style
from cyclemap.views.sentences import (
    LONGEST_STAY,
    ahead_sentence,
    angle,
    cycles,
    number,
    uncertainty_sentence,
    worn_rests,
)
from cyclemap.views.staircase_panels import draw_staircase, draw_step_lengths, draw_steps


@style.picture_style()
def staircase_page(
    forecast: StaircaseForecast, measured: MeasuredStaircase | None = None
) -> Figure:
    """Draw `forecast`, with `measured` beside it where given."""
    name = forecast.loop.material.name
    told = [forecast_sentence(forecast), worn_sentence(forecast), run_sentence(forecast)]
    told += [uncertainty_sentence(name, forecast.uncertainty), ahead_sentence(forecast.forecast)]
    if measured is not None:
        told += [measured_sentence(measured), fitted_sentence(measured)]
    foot = (
        f"cycle map from {forecast.map.samples} computed cycles; dwells found in the path "
        "alone, without a model"
    )
    figure, (runs, dwells, lengths) = style.page("ab;ac", f"Staircase of {name}", told, foot)
    path, steps = forecast.staircase.theta, forecast.steps
    comparison: StepComparison | None = forecast.comparison
    if measured is None:
        draw_staircase(runs, path)
    else:
        draw_staircase(runs, path, measured.path)
        path, steps, comparison = measured.path, measured.steps, None
        if measured.foretold is not None:
            comparison = measured.foretold.comparison
            fitted = np.degrees(measured.foretold.run.theta)
            runs.plot(fitted, label="map fitted to all data alike, without wear", **style.SECOND)
    draw_steps(dwells, path, steps)
    draw_step_lengths(lengths, steps, comparison)
    style.entitle(runs, "One run" if measured is None else "One run each")
    style.entitle(dwells, f"Dwells, {'predicted' if measured is None else 'measured'}")
    style.entitle(lengths, "Lengths")
    return figure


def forecast_sentence(forecast: StaircaseForecast) -> str:
    """Where the predicted staircase rests, how long, and how high its steps are."""
    prediction = forecast.prediction
    noise = f"With {angle(forecast.noise.sigma)} of noise a cycle"
    if not prediction.zones or prediction.step is None:
        return (
            f"{noise} θ0 rests nowhere: it moves {angle(prediction.mean_turn, 2)} a cycle on "
            "average."
        )
    rests = []
    for zone, log10 in zip(prediction.zones, forecast.log10_residences, strict=True):
        stay = cycles(zone.residence_cycles)
        if log10 is None:
            stay = "longer than can be computed"
        elif log10 > math.log10(LONGEST_STAY):
            stay = f"10^{math.floor(log10)} cycles"
        rests.append(f"{'near' if zone.kind == 'ghost' else 'at'} {angle(zone.centre)} for {stay}")
    climb = _pace_clause(prediction)
    fresh = "" if forecast.worn is None else " on the fresh surface"
    return (
        f"{noise} θ0 rests{fresh} {' and '.join(rests)}; steps are {angle(prediction.step, 0)} "
        f"high, {climb}."
    )


def worn_sentence(forecast: StaircaseForecast) -> str:
    """What the wear of the surface does to the staircase by the end of the run; empty where it does
    not wear.
    """
    worn = forecast.worn
    if worn is None:
        return ""
    if not worn.zones or worn.step is None:
        return (
            "The surface wears: by the last cycle θ0 rests nowhere and moves "
            f"{angle(worn.mean_turn, 2)} a cycle."
        )
    return (
        f"The surface wears: by the last cycle θ0 rests {worn_rests(worn)}, {_pace_clause(worn)}."
    )


def run_sentence(forecast: StaircaseForecast) -> str:
    """What was found in the one run that is drawn."""
    return (
        f"In one run of {forecast.staircase.cycles} cycles (seed {forecast.staircase.seed}) it "
        f"{_found(forecast.steps)}."
    )


def measured_sentence(measured: MeasuredStaircase) -> str:
    """What was found in the measured path."""
    pace = measured.cycles_a_turn
    turned = (
        f"a full turn took {number(pace)} cycles"
        if math.isfinite(pace)
        else "it ended where it began"
    )
    return f"In the {len(measured.path)} measured cycles it {_found(measured.steps)}; {turned}."


def fitted_sentence(measured: MeasuredStaircase) -> str:
    """What the map fitted to the data predicts, beside what was measured."""
    if measured.foretold is None:
        return f"No map is fitted to them: {measured.problem}."
    found = measured.foretold
    fitted, comparison = found.prediction, found.comparison
    law = f"{found.fitted.law.harmonics} harmonics and {angle(found.fitted.sigma)} of noise"
    if fitted.step is None or comparison.net_steps is None or comparison.expected_steps is None:
        return f"The map fitted to them ({law}) has no flat step."
    climbed = f"where {comparison.net_steps:.1f} were climbed"
    steps = f"{comparison.expected_steps:.1f} steps of {angle(fitted.step, 0)} {climbed}"
    visits = [
        f"{visit.predicted:.0f} cycles a visit to {angle(visit.zone.centre)} where "
        f"{visit.mean:.0f} ± {visit.standard_error or math.nan:.0f} were measured"
        for visit in comparison.visits
        if visit.predicted is not None and visit.mean is not None
    ]
    return f"The map fitted to them ({law}) predicts {', and '.join([steps, *visits])}."


def _pace_clause(prediction: StaircaseSummary) -> str:
    pace = prediction.cycles_a_step
    return "none to be expected" if pace is None or pace > 1e9 else f"one in {cycles(pace)}"


def _found(steps: Steps) -> str:
    if not steps.levels.size:
        return "rests nowhere"
    if not steps.count:
        return f"stays at {angle(float(np.mod(steps.levels[0], 2 * np.pi)))}"
    length = f"{number(float(np.median(steps.lengths)))} cycles"
    return (
        f"makes {steps.count} steps of {angle(float(np.median(steps.heights)), 0)} after "
        f"rests of {length} (medians)"
    )
