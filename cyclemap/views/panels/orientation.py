"""Panels over the orientation before the push: turns and laws, measured and predicted, and how
often each orientation is recorded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from cyclemap.arrays import TWO_PI, Array, Mask
from cyclemap.collection.portrait_curves import Cobweb, TurnCurve
from cyclemap.maps import Orbit
from cyclemap.views.panels.style import (
    BAND,
    BARS,
    DOTS,
    EVEN,
    INK,
    LINE,
    LINES,
    MARKS,
    PREDICTED,
    ZERO,
    Look,
    degree_axis,
    name_beside,
    orbit_marker,
    stability,
)

if TYPE_CHECKING:
    from cyclemap.collection.uncertain_directions import DirectionInterval
    from cyclemap.evidence import AngleHistogram, PeriodicLaw, Theta0Pairs, TurnBins

PER_DEGREE = np.pi / 180
TURN = "turn of one cycle, f(θ0) - θ0 (°)"
CIRCLE = np.linspace(0.0, TWO_PI, 721)
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


def draw_measured(axes: Axes, theta: Array, value: Array, name: str = "measured") -> None:
    """Measured values over orientations (rad), a light dot each."""
    axes.plot(np.degrees(np.mod(theta, TWO_PI)), value, label=name, **DOTS)


def draw_outcome(
    axes: Axes, theta: Array, values: Array, outcome: str, name: str = "measured"
) -> None:
    """Measured values (SI) of an outcome of pushes over orientations (rad)."""
    _, label, scale, _ = OUTCOMES[outcome]
    draw_measured(axes, theta, scale * values, name)
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
        draw_histogram(axes, measured, "measured", fill=True, **BARS)
    if predicted is not None:
        draw_histogram(axes, predicted, "predicted", **LINE)


def draw_histogram(axes: Axes, histogram: AngleHistogram, name: str, **look: Any) -> None:
    """The density of a histogram of orientations, per degree."""
    axes.stairs(PER_DEGREE * histogram.density, np.degrees(histogram.edges), label=name, **look)


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
