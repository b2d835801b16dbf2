"""A predicted staircase, and the measured one where there is one: in sentences, and on a landscape page."""

import math

import numpy as np
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from cyclemap.collection.staircase_forecast import StaircaseForecast
from cyclemap.evidence import MeasuredStaircase
from cyclemap.maps import Estimate, SlowZone, StaircaseSummary, Steps
from cyclemap.views.map_panels import draw_staircase
from cyclemap.views.sentences import LONGEST_STAY, angle, cycles, number, uncertainty_sentence, worn_rests
from cyclemap.views.step_panels import draw_step_lengths, draw_steps
from cyclemap.views.style import INK, new_figure, picture_style, write_page


def staircase_page(forecast: StaircaseForecast, measured: MeasuredStaircase | None = None) -> Figure:
    """Draw `forecast`, with `measured` beside it where given."""
    with picture_style():
        figure = new_figure()
        grid = GridSpec(
            2, 2, figure, width_ratios=(1.0, 1.0), left=0.06, right=0.985, bottom=0.115, top=0.755, wspace=0.17,
            hspace=0.5,
        )  # fmt: skip
        axes = figure.add_subplot(grid[:, 0])
        if measured is not None:
            fitted = np.degrees(measured.run.theta)
            label = "map fitted to all data alike, without wear"
            axes.plot(fitted, color=INK, linewidth=1.0, linestyle="--", label=label, zorder=4)
        draw_staircase(axes, forecast.run.theta, None if measured is None else measured.path)
        if measured is not None:
            axes.legend(loc="upper left")
        axes.set_title("One run" if measured is None else "One run each")
        steps, lengths = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
        if measured is None:
            draw_steps(steps, forecast.run.theta, forecast.steps)
            draw_step_lengths(lengths, forecast.steps, forecast.comparison)
        else:
            draw_steps(steps, measured.path, measured.steps)
            draw_step_lengths(lengths, measured.steps, measured.comparison)
        whose = "predicted" if measured is None else "measured"
        steps.set_title(f"Dwells, {whose}")
        # Above the legend, whose words may be long.
        lengths.set_title("Lengths", pad=22.0)
        name = forecast.loop.material.name
        told = [forecast_sentence(forecast), worn_sentence(forecast), run_sentence(forecast)]
        told += [uncertainty_sentence(name, forecast.uncertainty)]
        if measured is not None:
            told += [measured_sentence(measured), fitted_sentence(measured)]
        foot = f"cycle map from {forecast.map.samples} computed cycles; dwells found in the path alone, without a model"
        write_page(figure, f"Staircase of {name}", told, foot)
    return figure


def forecast_sentence(forecast: StaircaseForecast) -> str:
    """Where the predicted staircase rests, how long, and how high its steps are."""
    prediction = forecast.prediction
    noise = f"With {angle(forecast.noise.sigma)} of noise a cycle"
    if not prediction.zones or prediction.step is None:
        return f"{noise} θ0 rests nowhere: it moves {angle(prediction.mean_turn, 2)} a cycle on average."
    rests = [_zone_clause(*pair) for pair in zip(prediction.zones, forecast.log10_residences, strict=True)]
    climb = _pace_clause(prediction)
    fresh = "" if forecast.worn is None else " on the fresh surface"
    return f"{noise} θ0 rests{fresh} {' and '.join(rests)}; steps are {angle(prediction.step, 0)} high, {climb}."


def worn_sentence(forecast: StaircaseForecast) -> str:
    """What the wear of the surface does to the staircase by the end of the run; empty where it does not wear."""
    worn = forecast.worn
    if worn is None:
        return ""
    if not worn.zones or worn.step is None:
        return f"The surface wears: by the last cycle θ0 rests nowhere and moves {angle(worn.mean_turn, 2)} a cycle."
    return f"The surface wears: by the last cycle θ0 rests {worn_rests(worn)}, {_pace_clause(worn)}."


def run_sentence(forecast: StaircaseForecast) -> str:
    """What was found in the one run that is drawn."""
    return f"In one run of {forecast.run.cycles} cycles (seed {forecast.run.seed}) it {_found(forecast.steps)}."


def measured_sentence(measured: MeasuredStaircase) -> str:
    """What was found in the measured path."""
    pace = measured.cycles_a_turn
    turned = f"a full turn took {number(pace)} cycles" if math.isfinite(pace) else "it ended where it began"
    return f"In the {len(measured.path)} measured cycles it {_found(measured.steps)}; {turned}."


def fitted_sentence(measured: MeasuredStaircase) -> str:
    """What the map fitted to the data predicts, beside what was measured."""
    fitted, comparison = measured.prediction, measured.comparison
    law = f"{measured.fitted.law.harmonics} harmonics and {angle(measured.fitted.sigma)} of noise"
    if fitted.step is None or comparison.net_steps is None or comparison.expected_steps is None:
        return f"The map fitted to them ({law}) has no flat step."
    climbed = f"where {comparison.net_steps:.1f} were climbed"
    steps = f"{comparison.expected_steps:.1f} steps of {angle(fitted.step, 0)} {climbed}"
    visits = [
        f"{visit.predicted:.0f} cycles a visit to {angle(visit.zone.centre)} where {visit.mean:.0f} ± "
        f"{visit.standard_error or math.nan:.0f} were measured"
        for visit in comparison.visits
        if visit.predicted is not None and visit.mean is not None
    ]
    return f"The map fitted to them ({law}) predicts {', and '.join([steps, *visits])}."


def _zone_clause(zone: SlowZone, log10: Estimate | None) -> str:
    place = f"{'near' if zone.kind == 'ghost' else 'at'} {angle(zone.centre)}"
    if log10 is None:
        return f"{place} for longer than can be computed"
    if log10 > math.log10(LONGEST_STAY):
        return f"{place} for 10^{math.floor(log10)} cycles"
    return f"{place} for {cycles(zone.residence_cycles)}"


def _pace_clause(prediction: StaircaseSummary) -> str:
    pace = prediction.cycles_a_step
    return "none to be expected" if pace is None or pace > 1e9 else f"one in {cycles(pace)}"


def _found(steps: Steps) -> str:
    if not steps.levels.size:
        return "rests nowhere"
    if not steps.count:
        return f"stays at {angle(float(np.mod(steps.levels[0], 2 * np.pi)))}"
    length = f"{number(float(np.median(steps.lengths)))} cycles"
    return f"makes {steps.count} steps of {angle(float(np.median(steps.heights)), 0)} after rests of {length} (medians)"
