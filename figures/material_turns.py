"""Figs. 5 and 7: the turn Δθ of the push on four materials, over the orientation that it starts
from, and its histogram, as a fitted law predicts it and as it was.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import TWO_PI, Array
from cyclemap.evidence import PushSet, TurnHistogram, turn_histogram
from cyclemap.evidence.laws.set_fit import MotionLaw, motion_law
from cyclemap.views.fit_page import draw_motion_law, draw_turn_histogram
from cyclemap.views.panels.layout import Panel
from cyclemap.views.panels.orientation import (
    CIRCLE,
    OUTCOMES,
    SEEN_BARS,
    draw_curves,
    draw_measured,
)
from cyclemap.views.panels.style import FOURTH, SECOND, say
from cyclemap.views.sentences import angle, listed

from . import Exhibit, MeasuredFolder
from .repeated_pushes import (
    PAPER,
    SIMULATED_BARS,
    SIMULATED_DOTS,
    STANDS_FOR,
    SampledRun,
    Sampling,
    draw_each,
    draw_materials,
    fitted_laws,
    measured_theta0,
    not_found,
    recorded_set,
    sampled_run,
)

# Share of the pushes whose arc is told.
MOST = 0.95


@dataclass(frozen=True, eq=False)
class MaterialTurns:
    """One panel.

    run : simulated pushes.
    measured : the recorded set, None where none was found.
    law : of the recorded Δθ where there are any, else of the simulated.
    simulated_law : of these.
    curves : (states, 721) rad, the mechanics' Δθ at ``CIRCLE``, fresh and worn; one where the
        surface does not wear.
    arc : rad, the shortest in which 95 % of the simulated pushes start.
    worst_miss : rad, how far their law lies from the mechanics of the fresh surface, at worst.
    """

    run: SampledRun
    measured: PushSet | None
    law: MotionLaw
    simulated_law: MotionLaw
    curves: Array
    arc: float
    worst_miss: float


def shortest_arc(theta: Array, share: float) -> float:
    """Length (rad) of the shortest arc of the circle that holds a share, in (0, 1], of the angles
    (n,), any turn.

    >>> round(shortest_arc(np.array([0.1, 6.2, 0.3, 3.0]), 0.75), 6)
    0.383185
    """
    angles = np.sort(np.mod(theta, TWO_PI))
    held = max(int(np.ceil(share * angles.size)), 1)
    ends = np.concatenate([angles, angles + TWO_PI])[held - 1 : held - 1 + angles.size]
    return float(np.min(ends - angles))


def turns_over_theta0(
    measured: MeasuredFolder, sampling: Sampling = PAPER
) -> tuple[MaterialTurns, ...]:
    """Simulate pushes on each material, look for recorded ones, and fit the law of Δθ to both."""
    panels = []
    for surface, material in STANDS_FOR.items():
        recorded = recorded_set(measured, surface)
        run = sampled_run(material, sampling)
        simulated = fitted_laws(run.pushes)[0]
        law = simulated if recorded is None else fitted_laws(recorded)[0]
        shown = run.states[:: max(len(run.states) - 1, 1)]
        curves = np.array([state.motion(CIRCLE)[:, 0] for state in shown])
        arc = shortest_arc(run.pushes.theta, MOST)
        miss = (
            math.nan
            if simulated.law is None
            else float(np.max(np.abs(simulated.law(CIRCLE) - curves[0])))
        )
        panels.append(MaterialTurns(run, recorded, law, simulated, curves, arc, miss))
    return tuple(panels)


def _draw_turns(axes: Axes, panel: MaterialTurns) -> None:
    if panel.measured is None:
        draw_motion_law(axes, panel.law, SIMULATED_DOTS)
    else:
        draw_motion_law(axes, panel.law)
        pushes, look = panel.run.pushes, {**SIMULATED_DOTS, "zorder": 1}
        draw_measured(axes, pushes.theta, np.degrees(pushes.dtheta), look)
    names = ("mechanics",) if len(panel.curves) == 1 else ("mechanics, fresh", "mechanics, worn")
    curves = dict(zip(names, panel.curves, strict=True))
    draw_curves(axes, CIRCLE, curves, (SECOND, FOURTH))
    shown = np.degrees(np.concatenate([panel.curves.ravel(), panel.law.value]))
    margin = 0.08 * float(np.ptp(shown)) + 0.5
    low, high = axes.get_ylim()
    axes.set_ylim(min(shown.min() - margin, low), max(shown.max() + margin, high))


def turn_caption(result: tuple[MaterialTurns, ...]) -> str:
    """What is drawn, and how far each law and each range of directions goes."""
    count = result[0].run.pushes.count
    recorded = [
        f"{panel.run.surface} ({panel.measured.count} pushes, law within "
        f"{angle(panel.law.law.rmse, 2)} RMS)"
        for panel in result
        if panel.measured is not None and panel.law.law is not None
    ]
    sentences = [
        f"Turn of the push over θ0: predicted by the mechanics, and {count} simulated pushes a "
        "material with the law fitted to them. In each push friction is off by a random offset, as "
        "much as makes the next θ0 scatter by 1.1°, as measured cycles on plywood do. Plywood is "
        "the one inferred from the measured staircase (plywood-measured), which wears; the curve "
        "of its last cycle is drawn too.",
        *[_turn_sentence(panel) for panel in result],
        "Where no push starts, a law only guesses: around the circle it misses the mechanics by up "
        "to "
        f"{listed(f'{angle(panel.worst_miss)} on {panel.run.surface}' for panel in result)}.",
        f"Recorded pushes are drawn, and their law, on {listed(recorded)}." if recorded else "",
        not_found("pushes", [panel.run.surface for panel in result if panel.measured is None]),
    ]
    return " ".join(filter(None, sentences))


def _turn_sentence(panel: MaterialTurns) -> str:
    low, high = np.degrees([panel.curves[0].min(), panel.curves[0].max()])
    rmse = panel.simulated_law.law
    fitted = (
        "no law could be fitted" if rmse is None else f"the law is {angle(rmse.rmse, 2)} RMS off"
    )
    return (
        f"On {panel.run.surface} the mechanics turns by {low:.1f}° to {high:.1f}°, {fitted} in the "
        f"simulated pushes (paper, recorded: {angle(panel.run.published.rmse[0], 2)}), and 95 "
        f"% of these start on an arc of {angle(panel.arc, 0)}."
    )


DEFAULT_RUNS = 200
# Bins of the turn of a push, and of a cycle, which spreads far wider than where most of them lie.
PUSH_BINS, CYCLE_BINS = 40, 120


@dataclass(frozen=True, eq=False)
class TurnPanel:
    """One panel.

    surface : the material.
    recorded : whether its turns were measured on a robot, else they are simulated.
    whole_cycle : whether a turn is that of push and drag together, since only θ0 was recorded; else
        of the push alone.
    law : fitted to the turns over θ0.
    histogram : of the turns and of what the law makes of the same θ0; None where no law could be
        fitted.
    """

    surface: str
    recorded: bool
    whole_cycle: bool
    law: MotionLaw
    histogram: TurnHistogram | None


def turn_histograms(
    measured: MeasuredFolder, sampling: Sampling = PAPER, runs: int = DEFAULT_RUNS
) -> tuple[TurnPanel, ...]:
    """Fit the law of Δθ to recorded pushes, else to simulated ones, and let it predict their
    histogram: a panel a material, and those of whole cycles where only θ0 was recorded.

    runs : simulated sets that tell how far apart the two histograms may be by chance.
    """
    laws = []
    cycle_laws = []
    for surface, material in STANDS_FOR.items():
        recorded = recorded_set(measured, surface)
        shown = sampled_run(material, sampling).pushes if recorded is None else recorded
        laws.append((surface, recorded is not None, False, fitted_laws(shown)[0]))
        pairs = measured_theta0(measured, surface)
        if recorded is None and pairs is not None:
            # θ0 was recorded without its pushes: whole cycles are at hand.
            law = motion_law("dtheta", pairs.theta, pairs.turn)
            cycle_laws.append((surface, True, True, law))
    panels = []
    for surface, is_recorded, whole, law in laws + cycle_laws:
        bins = CYCLE_BINS if whole else PUSH_BINS
        known = None
        if law.law is not None:
            known = turn_histogram(law.theta, law.value, law.law, bins=bins, runs=runs)
        panels.append(TurnPanel(surface, is_recorded, whole, law, known))
    return tuple(panels)


def draw_turn_histograms(result: tuple[TurnPanel, ...]) -> Figure:
    """Draw the panels."""
    panels: list[Panel] = []
    for panel in result:
        title = f"{panel.surface}{', cycle' * panel.whole_cycle}"
        panels.append((title, partial(_draw_histogram, panel=panel)))
    return draw_materials(panels)


def _draw_histogram(axes: Axes, panel: TurnPanel) -> None:
    if panel.histogram is None:
        say(axes, "no law")
        axes.set_ylabel("pushes")
    else:
        look = SEEN_BARS if panel.recorded else SIMULATED_BARS
        draw_turn_histogram(axes, panel.histogram, look)
        low, high = np.degrees(np.quantile(panel.law.value, [0.002, 0.998]))
        axes.set_xlim(low - 0.1 * (high - low), high + 0.1 * (high - low))
    whole = "turn of the whole cycle, push and drag (°)"
    axes.set_xlabel(whole if panel.whole_cycle else OUTCOMES["dtheta"][1])


def histogram_caption(result: tuple[TurnPanel, ...]) -> str:
    """What is drawn, and how far the law's histogram is from what was recorded or simulated."""
    sentences = [
        "Histogram of the turn of each push, and the one that the fitted law predicts from the "
        "same θ0, with its scatter and, as the paper drew it, alone. Simulated plywood is "
        "plywood-measured, which wears.",
        *[_histogram_sentence(panel) for panel in result],
        not_found("pushes", [panel.surface for panel in result if not panel.recorded]),
    ]
    return " ".join(filter(None, sentences))


def _histogram_sentence(panel: TurnPanel) -> str:
    source = "recorded" if panel.recorded else "simulated"
    what = f"whole cycles {source}" if panel.whole_cycle else f"pushes {source}"
    if panel.whole_cycle:
        what += " (push and drag together, since only θ0 is at hand, not Δθ)"
    histogram, law = panel.histogram, panel.law.law
    if histogram is None or law is None:
        return f"No law could be fitted to the {what} on {panel.surface}: {panel.law.problem}."
    low, high = np.degrees(np.quantile(panel.law.value, [0.025, 0.975]))
    chance = "within" if histogram.total_variation <= histogram.chance_total_variation else "beyond"
    return (
        f"Of {histogram.count} {what} on {panel.surface}, 95 % turn by {low:.1f}° to {high:.1f}°; "
        "the "
        f"law's histogram is {histogram.total_variation:.2f} off in total variation, {chance} the "
        f"{histogram.chance_total_variation:.2f} that chance makes in 19 of 20 sets, and without "
        f"its scatter {histogram.law_alone_total_variation:.2f}."
    )


EXHIBITS = {
    "turn-over-theta0": Exhibit(turns_over_theta0, turn_caption, partial(draw_each, _draw_turns)),
    "turn-histograms": Exhibit(turn_histograms, histogram_caption, draw_turn_histograms),
}
