"""A predicted staircase, and the measured one where there is one: in sentences, and on a landscape
page.
"""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.patheffects import Normal, Stroke
from matplotlib.ticker import MaxNLocator

from cyclemap.arrays import Array
from cyclemap.collection.portrait import StaircaseForecast
from cyclemap.evidence import MeasuredStaircase
from cyclemap.maps import StaircaseSummary, StepComparison, Steps
from cyclemap.views import style
from cyclemap.views.portrait_page import draw_staircase
from cyclemap.views.sentences import (
    LONGEST_STAY,
    ahead_sentence,
    angle,
    cycles,
    number,
    uncertainty_sentence,
    worn_rests,
)
from cyclemap.views.style import INK, MEASURED, MEASURED_EDGE, PREDICTED, UNSTABLE, Look


@style.picture_style()
def staircase_page(
    forecast: StaircaseForecast, measured: MeasuredStaircase | None = None
) -> Figure:
    """Draw `forecast`, with `measured` beside it where given."""
    figure = style.new_figure()
    edges = {"left": 0.06, "right": 0.985, "bottom": 0.115, "top": 0.755}
    grid = GridSpec(2, 2, figure, width_ratios=(1.0, 1.0), wspace=0.17, hspace=0.5, **edges)
    axes = figure.add_subplot(grid[:, 0])
    if measured is not None and measured.foretold is not None:
        fitted = np.degrees(measured.foretold.run.theta)
        label = "map fitted to all data alike, without wear"
        axes.plot(fitted, color=INK, linewidth=1.0, linestyle="--", label=label, zorder=4)
    draw_staircase(axes, forecast.run.theta, None if measured is None else measured.path)
    if measured is not None:
        axes.legend(loc="upper left")
    axes.set_title("One run" if measured is None else "One run each")
    steps, lengths = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    shown = forecast if measured is None else measured
    draw_steps(steps, forecast.run.theta if measured is None else measured.path, shown.steps)
    comparison: StepComparison | None = forecast.comparison
    if measured is not None:
        comparison = None if measured.foretold is None else measured.foretold.comparison
    draw_step_lengths(lengths, shown.steps, comparison)
    steps.set_title(f"Dwells, {'predicted' if measured is None else 'measured'}")
    # Above the legend, whose words may be long.
    lengths.set_title("Lengths", pad=22.0)
    name = forecast.loop.material.name
    told = [forecast_sentence(forecast), worn_sentence(forecast), run_sentence(forecast)]
    told += [uncertainty_sentence(name, forecast.uncertainty), ahead_sentence(forecast.forecast)]
    if measured is not None:
        told += [measured_sentence(measured), fitted_sentence(measured)]
    foot = (
        f"cycle map from {forecast.map.samples} computed cycles; dwells found in the path "
        "alone, without a model"
    )
    style.write_page(figure, f"Staircase of {name}", told, foot)
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
        f"In one run of {forecast.run.cycles} cycles (seed {forecast.run.seed}) it "
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


# With more dwells than this their levels are not written beside them.
MOST_NAMED = 12
# A predicted length so many times the panel's height is not drawn to scale.
FAR = 4.0


def draw_steps(axes: Axes, path: Array, steps: Steps) -> None:
    """`path` (rad, lifted) over the cycles, its dwells as thick bars at their levels, open where
    censored.

    Where the steps were found in zones that turn w times a cycle, the path is drawn less these
    turns.
    """
    winding = steps.zones[0].winding if steps.zones else 0
    cycles = np.arange(path.size)
    axes.plot(
        cycles,
        np.degrees(path - 2 * np.pi * winding * cycles),
        color=MEASURED,
        linewidth=1.2,
        label="path",
    )
    # Every dwell as a bar, filled, or open where the path begins or ends in it.
    labels = {False: "dwell", True: "dwell not seen whole"}
    for start, end, level, censored in zip(
        steps.start, steps.end, steps.levels, steps.censored, strict=True
    ):
        level_deg, open_ended = float(np.degrees(level)), bool(censored)
        look: Look = {"solid_capstyle": "butt", "zorder": 4}
        label = labels.pop(open_ended, None)
        (bar,) = axes.plot(
            [start, end], [level_deg] * 2, color=INK, linewidth=5.0, label=label, **look
        )
        if open_ended:
            bar.set(
                color=UNSTABLE,
                linewidth=2.2,
                path_effects=[Stroke(linewidth=5.0, foreground=INK), Normal()],
            )
        if steps.levels.size <= MOST_NAMED:
            style.name_beside_path(axes, start, end, level_deg, angle(level), steps.climb >= 0.0)
    turning = f" less {360 * winding}° a cycle" if winding else ""
    axes.set(xlabel="cycle", xlim=(0, max(path.size - 1, 1)))
    axes.xaxis.set_major_locator(MaxNLocator(6, integer=True, min_n_ticks=1))
    axes.margins(y=0.08)
    style.unwrapped_axis(axes, f"θ, unwrapped{turning}")
    style.legend_above(axes)


def draw_step_lengths(axes: Axes, steps: Steps, comparison: StepComparison | None = None) -> None:
    """The dwells' lengths in order, arrows where they lasted longer than was seen; means beside the
    prediction.
    """
    number_of, whole, cut = np.arange(1, steps.lengths.size + 1), ~steps.censored, steps.censored
    look: Look = {"linestyle": "none", "markeredgecolor": MEASURED_EDGE, "zorder": 4}
    if not steps.lengths.size:
        style.say(axes, "no dwell")
    if whole.any():
        axes.plot(
            number_of[whole], steps.lengths[whole], "o", color=MEASURED, label="dwell", **look
        )
    if cut.any():
        open_look = {**look, "markerfacecolor": UNSTABLE}
        axes.plot(
            number_of[cut], steps.lengths[cut], "^", label="lasted longer than seen", **open_look
        )
    if comparison is not None:
        # The measured mean with its standard error, and the predicted one.
        mean, error, predicted = (
            comparison.mean_length,
            comparison.length_error,
            comparison.predicted_length,
        )
        if mean is not None:
            spread = 0.0 if error is None else error
            label = f"mean {mean:.1f}" if error is None else f"mean {mean:.1f} ± {error:.1f}"
            axes.axhspan(
                mean - spread, mean + spread, color=MEASURED, alpha=0.25, linewidth=0, zorder=1
            )
            axes.axhline(mean, color=MEASURED_EDGE, linewidth=1.0, label=label, zorder=2)
        if predicted is not None:
            # The predicted mean as a line, or told alone where the line would dwarf what was
            # measured.
            line: Look = {
                "color": PREDICTED,
                "linewidth": 1.8,
                "linestyle": "--",
                "zorder": 3,
            }
            if predicted > FAR * axes.get_ylim()[1]:
                axes.plot([], [], label=f"predicted {number(predicted)}, beyond the panel", **line)
            else:
                written = f"{predicted:.1f}" if predicted < 1000 else number(predicted)
                axes.axhline(predicted, label=f"predicted {written}", **line)
    axes.set(xlabel="dwell", ylabel="length (cycles)", xlim=(0.5, max(steps.lengths.size, 1) + 0.5))
    axes.set_ylim(bottom=0.0)
    axes.xaxis.set_major_locator(MaxNLocator(8, integer=True, min_n_ticks=1))
    style.legend_above(axes)
