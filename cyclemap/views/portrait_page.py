"""The portrait of a loop on one page, with turn, directions, cobweb, staircase, and a cycle to
scale; and its staircase alone, predicted and measured, in sentences and on a page.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from cyclemap.arrays import TWO_PI
from cyclemap.collection.portrait import Portrait, StaircaseForecast
from cyclemap.collection.portrait_curves import PortraitCurves
from cyclemap.maps import StaircaseSummary, StepComparison, Steps
from cyclemap.views import sentences
from cyclemap.views.panels import orientation
from cyclemap.views.panels.layout import entitle, page
from cyclemap.views.panels.orientation import draw_staircase, draw_step_lengths, draw_steps
from cyclemap.views.panels.scene import cycle_key, draw_cycle
from cyclemap.views.panels.style import SECOND, picture_style
from cyclemap.views.sentences import (
    LONGEST_STAY,
    ahead_sentence,
    angle,
    cycles,
    number,
    uncertainty_sentence,
    worn_rests,
)

if TYPE_CHECKING:
    from cyclemap.evidence import MeasuredOverlay, MeasuredStaircase


@picture_style()
def portrait_page(
    portrait: Portrait, curves: PortraitCurves, measured: MeasuredOverlay | None = None
) -> Figure:
    """Draw `portrait`, whose curves are `curves`, with `measured` over it where given."""
    words, foot = _words(portrait, measured)
    figure, panels = page(
        "abc;def",
        sentences.headline(portrait),
        words,
        foot,
        width_ratios=(5.2, 2.75, 3.2),
    )
    turn, cobweb, push, density, staircase, drag = panels
    orientation.draw_turn(turn, curves.turn)
    orientation.mark_fixed_points(turn, portrait.fixed_points)
    if portrait.uncertainty is not None:
        orientation.draw_intervals(turn, portrait.uncertainty.directions)
    orientation.draw_density(density, curves.density_theta, curves.density)
    orientation.draw_cobweb(cobweb, curves.cobweb, portrait.fixed_points)
    draw_staircase(
        staircase,
        portrait.staircase.theta,
        None if measured is None else measured.pairs.path,
    )
    if measured is not None:
        orientation.draw_measured_turns(turn, measured.pairs, measured.bins)
        orientation.draw_recorded(density, measured.histogram)
    cycle = portrait.cycle
    draw_cycle(push, drag, cycle)
    start, pushed, dragged = map(sentences.angle, (cycle.theta, cycle.push_turn, cycle.drag_turn))
    titles = (
        f"Turn of one cycle{', fresh' * (portrait.worn is not None)}",
        _cobweb_title(portrait, curves),
        f"Push from {start}: turns {pushed}",
        "Directions recorded",
        "Staircase",
        f"Drag by the ring: turns {dragged}",
    )
    for axes, title in zip(panels, titles, strict=True):
        entitle(axes, title)
    return figure


def _cobweb_title(portrait: Portrait, curves: PortraitCurves) -> str:
    """Of what place the cobweb is, where it does not show the whole circle."""
    if curves.cobweb.high - curves.cobweb.low > 6.2:
        return "Cobweb"
    if portrait.stable_points:
        return "Cobweb about the stable direction"
    return f"Cobweb about the {'jump' if portrait.gathering_jumps else 'slowest direction'}"


def _words(portrait: Portrait, measured: MeasuredOverlay | None) -> tuple[list[str], str]:
    """The sentences of the page, and its foot."""
    material = portrait.loop.material
    words = [
        sentences.lock_sentence(portrait),
        sentences.noise_sentence(portrait),
        sentences.staircase_sentence(portrait),
        sentences.uncertainty_sentence(material.name, portrait.uncertainty),
    ]
    inferred = f"{material.name} was inferred, not measured  ·  " if material.inferred else ""
    how = f"{sentences.push_line(portrait)}  ·  {sentences.accuracy_line(portrait)}"
    foot = [cycle_key(portrait.cycle), sentences.parameters_line(portrait), f"{inferred}{how}"]
    if measured is not None:
        foot.append(sentences.agreement_sentence(measured.agreement))
    return words, "\n".join(foot)


@picture_style()
def staircase_page(
    forecast: StaircaseForecast, measured: MeasuredStaircase | None = None
) -> Figure:
    """Draw `forecast`, with `measured` beside it where given."""
    name = forecast.loop.material.name
    words = [forecast_sentence(forecast), worn_sentence(forecast), run_sentence(forecast)]
    words += [uncertainty_sentence(name, forecast.uncertainty), ahead_sentence(forecast.forecast)]
    if measured is not None:
        words += [measured_sentence(measured), fitted_sentence(measured)]
    foot = (
        f"cycle map from {forecast.map.samples} computed cycles; dwells found in the path "
        "alone, without a model"
    )
    figure, (runs, dwells, lengths) = page("ab;ac", f"Staircase of {name}", words, foot)
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
            runs.plot(fitted, label="map fitted to all data alike, without wear", **SECOND)
    draw_steps(dwells, path, steps)
    draw_step_lengths(lengths, steps, comparison)
    entitle(runs, "One run" if measured is None else "One run each")
    entitle(dwells, f"Dwells, {'predicted' if measured is None else 'measured'}")
    entitle(lengths, "Lengths")
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
        f"{_course_words(forecast.steps)}."
    )


def measured_sentence(measured: MeasuredStaircase) -> str:
    """What was found in the measured path."""
    pace = measured.cycles_a_turn
    turned = (
        f"a full turn took {number(pace)} cycles"
        if math.isfinite(pace)
        else "it ended where it began"
    )
    return (
        f"In the {len(measured.path)} measured cycles it {_course_words(measured.steps)}; {turned}."
    )


def fitted_sentence(measured: MeasuredStaircase) -> str:
    """What the map fitted to the data predicts, beside what was measured."""
    if measured.foretold is None:
        return f"No map is fitted to them: {measured.problem}."
    foretold = measured.foretold
    fitted, comparison = foretold.prediction, foretold.comparison
    law = f"{foretold.fitted.law.harmonics} harmonics and {angle(foretold.fitted.sigma)} of noise"
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


def _course_words(steps: Steps) -> str:
    if not steps.levels.size:
        return "rests nowhere"
    if not steps.count:
        return f"stays at {angle(float(np.mod(steps.levels[0], TWO_PI)))}"
    length = f"{number(float(np.median(steps.lengths)))} cycles"
    return (
        f"makes {steps.count} steps of {angle(float(np.median(steps.heights)), 0)} after "
        f"rests of {length} (medians)"
    )
