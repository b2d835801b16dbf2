"""Panels of the orientation before a push: turns and laws over it, measured and predicted, how
often each is recorded, and how it climbs over the cycles.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, ScalarFormatter

from cyclemap.arrays import TWO_PI, Array, Mask
from cyclemap.collection.portrait_curves import Cobweb, TurnCurve
from cyclemap.maps import Orbit, StepComparison, Steps
from cyclemap.views.panels.layout import legend_above
from cyclemap.views.panels.style import (
    BAND,
    BARS,
    DOTS,
    EVEN,
    INK,
    LINE,
    LINES,
    MARKS,
    MEASURED,
    MEASURED_EDGE,
    PATH,
    PREDICTED,
    QUIET,
    UNSTABLE,
    ZERO,
    Look,
    count_axis,
    degree_axis,
    name_beside,
    name_beside_path,
    orbit_marker,
    say,
    stability,
    unwrapped_axis,
)
from cyclemap.views.sentences import angle, number

if TYPE_CHECKING:
    from cyclemap.collection.uncertain_directions import DirectionInterval
    from cyclemap.evidence import AngleHistogram, PeriodicLaw, Theta0Pairs, TurnBins
    from cyclemap.evidence.laws.measured_cycle_map import TurnPace


PER_DEGREE = np.pi / 180
TURN = "turn of one cycle, f(θ0) - θ0 (°)"
CIRCLE = np.linspace(0.0, TWO_PI, 721)
SEEN: Look = {**DOTS, "label": "measured"}
SEEN_BARS: Look = {**BARS, "label": "measured"}
# An outcome of a push: its sign, its label, the factor from SI units, and the unit behind a number.
OUTCOMES = {
    "dtheta": ("Δθ", "turn of the push, Δθ (°)", 1.0 / PER_DEGREE, "°"),
    "dx": ("Δx", "displacement, Δx (mm)", 1e3, " mm"),
    "dy": ("Δy", "displacement, Δy (mm)", 1e3, " mm"),
}


def draw_turns(
    axes: Axes, theta: Array, turns: Mapping[str, Array], looks: Sequence[Look] = LINES
) -> None:
    """Turns (rad) of a cycle over orientations (rad), by name."""
    turn_axes(axes)
    draw_curves(axes, theta, turns, looks)


def draw_curves(
    axes: Axes, theta: Array, turns: Mapping[str, Array], looks: Sequence[Look] = LINES
) -> None:
    """Angles (rad) over orientations (rad), by name, each in a line of its own."""
    for (name, turn), look in zip(turns.items(), looks, strict=False):
        axes.plot(np.degrees(theta), np.degrees(turn), label=name, **look)


def turn_axes(axes: Axes) -> None:
    """Axes of a turn over the orientation, with the line of none."""
    axes.axhline(0.0, **ZERO)
    degree_axis(axes)
    axes.set_ylabel(TURN)


def draw_turn(axes: Axes, curve: TurnCurve, name: str = "predicted", **look: object) -> None:
    """The turn of one cycle by a map, in pieces between its jumps, which are dotted."""
    turn_axes(axes)
    for theta, turn in curve.pieces:
        axes.plot(np.degrees(theta), np.degrees(turn), **{**LINE, "label": name, **look})
    for jump in curve.jumps:
        place, ends = np.degrees(jump.theta), np.degrees([jump.before, jump.after])
        axes.plot([place, place], ends, color=PREDICTED, linewidth=1.0, linestyle=":", zorder=3)
    axes.yaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 3, 5, 6, 10]))
    axes.margins(y=0.12)


def mark_fixed_points(axes: Axes, orbits: Sequence[Orbit]) -> None:
    """Fixed points on the line of no turn, each with its name where the turn does not run."""
    for orbit in orbits:
        place, kind = float(np.degrees(orbit.points[0])), stability(orbit)
        axes.plot(place, 0.0, **orbit_marker(kind))
        # A turn falls through a stable direction and rises through an unstable one.
        left = place > 290.0
        offset = (-8 if left else 8, 9 if orbit.stable != left else -16)
        name_beside(axes, place, 0.0, f"{place:.1f}° {kind}", offset)


def draw_intervals(axes: Axes, known: Sequence[DirectionInterval]) -> None:
    """Bands of where the stable directions may lie."""
    for interval in known:
        for back in (0.0, 360.0):
            low, high = np.degrees([interval.lower, interval.upper]) - back
            if high > 0.0:
                band = max(low, 0.0), min(high, 360.0)
                axes.axvspan(*band, label="may lie here", **{**BAND, "zorder": 0})


def draw_measured(axes: Axes, theta: Array, value: Array, look: Look = SEEN) -> None:
    """Measured values over orientations (rad), a light dot each."""
    axes.plot(np.degrees(np.mod(theta, TWO_PI)), value, **look)


def draw_outcome(axes: Axes, theta: Array, values: Array, outcome: str, look: Look = SEEN) -> None:
    """Measured values (SI) of an outcome of pushes over orientations (rad)."""
    _, label, scale, _ = OUTCOMES[outcome]
    draw_measured(axes, theta, scale * values, look)
    degree_axis(axes)
    axes.set_ylabel(label)


def draw_measured_turns(axes: Axes, pairs: Theta0Pairs, bins: TurnBins) -> None:
    """Measured turns, a light dot each, and their medians in bins of the orientation."""
    draw_measured(axes, pairs.theta, np.degrees(pairs.turn))
    draw_medians(axes, bins, "5° medians")


def draw_medians(axes: Axes, bins: TurnBins, name: str) -> None:
    """Medians of measured turns in bins of the orientation."""
    axes.plot(*np.degrees([bins.centre, bins.median]), "s", label=name, **MARKS)


def draw_law(
    axes: Axes,
    law: PeriodicLaw,
    outcome: str,
    covered: Mask | None = None,
    name: str = "law, 95 % band",
    look: Look = LINE,
    fill: Look = BAND,
) -> tuple[float, float]:
    """A law over the orientation with its bands of pushes and of the mean, with gaps where it is
    not `covered`; returns the ends of the wider band.
    """
    around, scale = np.degrees(CIRCLE), OUTCOMES[outcome][2]
    centre = scale * law(CIRCLE)
    mean, single = (scale * half for half in law.half_bands(CIRCLE))
    axes.fill_between(around, centre - single, centre + single, label="95 % of pushes", **fill)
    axes.fill_between(
        around,
        centre - mean,
        centre + mean,
        color=look["color"],
        alpha=0.35,
        linewidth=0.0,
        zorder=3,
    )
    seen = centre if covered is None else np.where(covered, centre, np.nan)
    axes.plot(around, seen, label=name, **{**look, "linewidth": 1.4})
    return float(np.nanmin(centre - single)), float(np.nanmax(centre + single))


def keep_to(axes: Axes, values: Array, low: float, high: float) -> None:
    """Show all but one in 200 values, and what reaches from `low` to `high` as far as it leaves
    these no less than a third of the panel.
    """
    least, most = np.quantile(values, [0.005, 0.995]).tolist()
    reach = most - least or 1.0
    bottom, top = max(least - reach, min(least, low)), min(most + reach, max(most, high))
    axes.set_ylim(bottom - 0.06 * (top - bottom), top + 0.06 * (top - bottom))


def draw_agreement(axes: Axes, measured: Array, predicted: Array, what: str, name: str) -> None:
    """Predicted over measured values of the same, and the line where both are equal."""
    axes.axline((0.0, 0.0), slope=1.0, label="equal", **{**LINE, "zorder": 1})
    axes.plot(measured, predicted, label=name, **DOTS)
    axes.set(xlabel=f"measured {what}", ylabel=f"predicted {what}")


def draw_cobweb(axes: Axes, cobweb: Cobweb, fixed_points: Sequence[Orbit]) -> None:
    """The graph of the map about its most telling place, and paths walking up its stairs."""
    window = np.degrees([cobweb.low, cobweb.high])
    axes.plot(window, window, **ZERO)
    for theta, image in cobweb.pieces:
        axes.plot(np.degrees(theta), np.degrees(image), **LINE)
    for path in cobweb.paths:
        axes.plot(*np.degrees(path).T, color=INK, linewidth=0.7)
        axes.plot(*np.degrees(path[0]), marker="|", color=INK, markersize=7)
    for orbit in fixed_points:
        marker = {**orbit_marker(stability(orbit)), "clip_on": True}
        for lift in float(np.degrees(orbit.points[0])) + 360.0 * np.arange(-2, 3):
            axes.plot(lift, lift, **marker)
    axes.set(xlim=window, ylim=window, aspect="equal", anchor="W")
    axes.set(xlabel="θ0 (°)", ylabel="next θ0 (°)")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 3, 4.5, 6, 9, 10]))


def draw_recorded(
    axes: Axes, measured: AngleHistogram | None, predicted: AngleHistogram | None = None
) -> None:
    """How often each orientation was recorded, and is predicted to be, in bins."""
    density_axes(axes)
    if measured is not None:
        draw_histogram(axes, measured, {**SEEN_BARS, "fill": True})
    if predicted is not None:
        draw_histogram(axes, predicted, {**LINE, "label": "predicted"})


def draw_histogram(axes: Axes, histogram: AngleHistogram, look: Look) -> None:
    """The density of a histogram of orientations, per degree."""
    axes.stairs(PER_DEGREE * histogram.density, np.degrees(histogram.edges), **look)


def draw_density(axes: Axes, theta: Array, density: Array, name: str = "predicted") -> None:
    """A density (per rad) of the orientation."""
    density_axes(axes)
    axes.fill_between(np.degrees(theta), PER_DEGREE * density, **BAND)
    axes.plot(np.degrees(theta), PER_DEGREE * density, label=name, **LINE)


def density_axes(axes: Axes) -> None:
    """Axes of a density over the orientation, which begin at none, with the line of the uniform
    one.
    """
    axes.axhline(1.0 / 360.0, label="uniform", **EVEN).sticky_edges.y.append(0.0)
    degree_axis(axes)
    axes.set_ylabel("probability per degree")


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
            rim = withStroke(linewidth=5.0, foreground=INK)
            bar.set(color=UNSTABLE, linewidth=2.2, path_effects=[rim])
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
