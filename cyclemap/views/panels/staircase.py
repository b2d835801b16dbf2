"""Panels over the cycles: the orientation, unwrapped, its dwells, and how long each lasted."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import Normal, Stroke
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, ScalarFormatter

from cyclemap.arrays import TWO_PI, Array
from cyclemap.maps import StepComparison, Steps
from cyclemap.views.panels.layout import legend_above
from cyclemap.views.panels.style import (
    BAND,
    INK,
    LINE,
    MARKS,
    MEASURED,
    MEASURED_EDGE,
    PATH,
    PREDICTED,
    QUIET,
    UNSTABLE,
    Look,
    count_axis,
    name_beside_path,
    say,
    unwrapped_axis,
)
from cyclemap.views.sentences import angle, number

if TYPE_CHECKING:
    from cyclemap.evidence.laws.measured_cycle_map import TurnPace

LEAST_SPAN_DEG = 120.0
# With more dwells than this their levels are not written beside them.
MOST_NAMED = 12
# A predicted length so many times the panel's height is not drawn to scale.
FAR = 4.0


def draw_staircase(
    axes: Axes,
    predicted: Array,
    measured: Array | None = None,
    band: tuple[Array, Array] | None = None,
    count: str = "cycle",
) -> None:
    """θ0 over the cycles, unwrapped: one predicted noisy run, the measured one where there is one,
    and the `band` that holds 95 % of runs.
    """
    longest = len(predicted)
    if band is not None:
        lower, upper = np.degrees(band)
        axes.fill_between(np.arange(lower.size), lower, upper, label="95 % of runs", **BAND)
    if measured is not None:
        axes.plot(np.degrees(measured), label="measured", **PATH)
        longest = max(longest, len(measured))
    axes.plot(np.degrees(predicted), label="predicted", **{**LINE, "linewidth": 1.2})
    count_axis(axes, count, longest - 1)
    unwrapped_axis(axes, "θ0, unwrapped", LEAST_SPAN_DEG)


def draw_steps(axes: Axes, path: Array, steps: Steps) -> None:
    """`path` (rad, lifted) over the cycles, its dwells as thick bars at their levels, open where
    censored.

    Where the steps were found in zones that turn w times a cycle, the path is drawn less these
    turns.
    """
    winding = steps.zones[0].winding if steps.zones else 0
    straight = path - TWO_PI * winding * np.arange(path.size)
    axes.plot(np.degrees(straight), label="path", **{**PATH, "linewidth": 1.2})
    for start, end, level, censored in zip(
        steps.start, steps.end, steps.levels, steps.censored, strict=True
    ):
        height = float(np.degrees(level))
        label = "dwell not seen whole" if censored else "dwell"
        (bar,) = axes.plot(
            [start, end],
            [height, height],
            color=INK,
            linewidth=5.0,
            solid_capstyle="butt",
            zorder=4,
            label=label,
        )
        if censored:
            bar.set(color=UNSTABLE, linewidth=2.2)
            bar.set_path_effects([Stroke(linewidth=5.0, foreground=INK), Normal()])
        if steps.levels.size <= MOST_NAMED:
            name_beside_path(axes, start, end, height, angle(level), steps.climb >= 0.0)
    turning = f" less {360 * winding}° a cycle" if winding else ""
    count_axis(axes, "cycle", path.size - 1)
    axes.margins(y=0.08)
    unwrapped_axis(axes, f"θ, unwrapped{turning}")
    legend_above(axes)


def draw_step_lengths(axes: Axes, steps: Steps, comparison: StepComparison | None = None) -> None:
    """The dwells' lengths in order, arrows where they lasted longer than was seen; means beside the
    prediction.
    """
    places = np.arange(1, steps.lengths.size + 1)
    if not steps.lengths.size:
        say(axes, "no dwell")
    cut_marks = {**MARKS, "markerfacecolor": UNSTABLE}
    kinds = (("dwell", "o", ~steps.censored, MARKS), (_CUT, "^", steps.censored, cut_marks))
    for label, marker, chosen, look in kinds:
        if chosen.any():
            axes.plot(places[chosen], steps.lengths[chosen], marker, label=label, **look)
    if comparison is not None:
        _mark_means(axes, comparison)
    axes.set(xlabel="dwell", ylabel="length (cycles)", xlim=(0.5, max(steps.lengths.size, 1) + 0.5))
    axes.set_ylim(bottom=0.0)
    axes.xaxis.set_major_locator(MaxNLocator(8, integer=True, min_n_ticks=1))
    legend_above(axes)


_CUT = "lasted longer than seen"


def _mark_means(axes: Axes, comparison: StepComparison) -> None:
    """The measured mean length with its standard error; the predicted one as a line, or told alone
    where the line would dwarf what was measured.
    """
    mean, error, predicted = (
        comparison.mean_length,
        comparison.length_error,
        comparison.predicted_length,
    )
    if mean is not None:
        label = f"mean {mean:.1f}" if error is None else f"mean {mean:.1f} ± {error:.1f}"
        spread = error or 0.0
        look: Look = {"color": MEASURED, "alpha": 0.25, "linewidth": 0.0, "zorder": 1}
        axes.axhspan(mean - spread, mean + spread, **look)
        axes.axhline(mean, color=MEASURED_EDGE, linewidth=1.0, label=label, zorder=2)
    if predicted is not None:
        look = {"color": PREDICTED, "linewidth": 1.8, "linestyle": "--", "zorder": 3}
        if predicted > FAR * axes.get_ylim()[1]:
            axes.plot([], [], label=f"predicted {number(predicted)}, beyond the panel", **look)
            return
        written = f"{predicted:.1f}" if predicted < 1000 else number(predicted)
        axes.axhline(predicted, label=f"predicted {written}", **look)


def draw_pace(axes: Axes, pace: TurnPace) -> None:
    """Pushes that each full turn took, and the range that the fitted map gives it."""
    # A range without an end, or a turn that most paths never finish, runs out of the panel.
    pushes = np.array([pace.measured, pace.lower, pace.predicted, pace.upper])
    top = 1.4 * float(np.max(pushes[np.isfinite(pushes)]))
    low, middle, high = np.minimum(pushes[1:], 2.0 * top)
    ends = [middle - low, high - middle]
    axes.errorbar(
        pace.start,
        middle,
        yerr=ends,
        label="fitted map, 95 %",
        fmt="_",
        color=PREDICTED,
        ecolor=QUIET,
        zorder=3,
    )
    axes.plot(pace.start, pace.measured, "s", label="measured", **MARKS)
    axes.set(yscale="log", xlabel="cycle in which the turn began", ylabel="pushes a full turn")
    axes.set_ylim(top=top)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(ScalarFormatter())
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_locator(MaxNLocator(5, integer=True, min_n_ticks=1))
