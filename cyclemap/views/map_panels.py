"""The map and what the robot will record of it: turn, cobweb, histogram of directions, staircase."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from cyclemap.arrays import Array
from cyclemap.collection.portrait_curves import Cobweb, PortraitCurves, TurnCurve
from cyclemap.collection.uncertain_directions import DirectionInterval
from cyclemap.maps import Orbit
from cyclemap.views import style
from cyclemap.views.style import INK, MEASURED, MEASURED_EDGE, PREDICTED, PREDICTED_FILL, QUIET

if TYPE_CHECKING:
    from cyclemap.evidence import AngleHistogram, Theta0Pairs, TurnBins

PER_DEGREE = np.pi / 180
LEAST_SPAN_DEG = 120.0


def draw_turn(
    axes: Axes, curve: TurnCurve, fixed_points: tuple[Orbit, ...], known: tuple[DirectionInterval, ...] = ()
) -> None:
    """The turn of one cycle over θ0, with the fixed points on its zero line and bands of where they may lie."""
    axes.axhline(0.0, color=QUIET, linewidth=0.9)
    for number, one in enumerate(known):
        label = "may lie here" if number == 0 else None
        for back in (0.0, 360.0) if one.upper > 2 * np.pi else (0.0,):
            ends = np.clip(np.degrees([one.lower, one.upper]) - back, 0.0, 360.0)
            axes.axvspan(
                *ends.tolist(), color=PREDICTED_FILL, linewidth=0.0, label=label if back == 0.0 else None, zorder=0
            )
    for index, (theta, turn) in enumerate(curve.pieces):
        label = "predicted" if index == 0 else None
        axes.plot(np.degrees(theta), np.degrees(turn), color=PREDICTED, linewidth=2.0, label=label, zorder=3)
    for jump in curve.jumps:
        place, ends = np.degrees(jump.theta), np.degrees([jump.before, jump.after])
        axes.plot([place, place], ends, color=PREDICTED, linewidth=1.0, linestyle=":", zorder=3)
    for orbit in fixed_points:
        at = float(np.degrees(orbit.points[0]))
        axes.plot(at, 0.0, **_marker(orbit))
        name = f"{at:.1f}° {'stable' if orbit.stable else 'unstable'}"
        style.name_beside(axes, at, 0.0, name, (7 if at < 290 else -7, 9 if orbit.stable else -16))
    style.degree_axis(axes, "θ0, orientation before the push (°)")
    axes.set_ylabel("turn of one cycle, f(θ0) - θ0 (°)")
    axes.yaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 3, 5, 6, 10]))
    axes.margins(y=0.12)


def draw_measured_turns(axes: Axes, pairs: Theta0Pairs, bins: TurnBins) -> None:
    """Measured pairs as light dots, and their medians by bin; the scale keeps to the medians."""
    theta = np.degrees(np.mod(pairs.theta, 2 * np.pi))
    axes.plot(theta, np.degrees(pairs.turn), ".", color=MEASURED, markersize=3, alpha=0.35, label="measured", zorder=1)
    look: dict[str, Any] = {"markeredgecolor": MEASURED_EDGE, "markeredgewidth": 0.7, "markersize": 4.0, "zorder": 2}
    axes.plot(np.degrees(bins.centre), np.degrees(bins.median), "s", color=MEASURED, label="5° medians", **look)


def draw_cobweb(axes: Axes, cobweb: Cobweb, fixed_points: tuple[Orbit, ...]) -> None:
    """The graph of the map about its most telling place, and paths walking up its stairs."""
    window = np.degrees([cobweb.low, cobweb.high])
    axes.plot(window, window, color=QUIET, linewidth=0.9)
    for theta, image in cobweb.pieces:
        axes.plot(np.degrees(theta), np.degrees(image), color=PREDICTED, linewidth=2.0)
    for path in cobweb.paths:
        axes.plot(*np.degrees(path).T, color=INK, linewidth=0.7)
        axes.plot(*np.degrees(path[0]), marker="|", color=INK, markersize=7)
    for orbit in fixed_points:
        for lift in float(np.degrees(orbit.points[0])) + 360.0 * np.arange(-2, 3):
            if window[0] <= lift <= window[1]:
                axes.plot(lift, lift, **_marker(orbit))
    axes.set(xlim=window, ylim=window, aspect="equal", anchor="W", xlabel="θ0 (°)", ylabel="next θ0 (°)")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 3, 4.5, 6, 9, 10]))


def _marker(orbit: Orbit) -> dict[str, Any]:
    kind = "stable" if orbit.stable else "unstable"
    return {**style.orbit_marker(kind), "markersize": 7.5, "markeredgewidth": 1.6, "clip_on": True}


def draw_density(axes: Axes, curves: PortraitCurves) -> None:
    """The predicted stationary density of θ0."""
    theta, density = np.degrees(curves.density_theta), PER_DEGREE * curves.density
    axes.fill_between(theta, density, color=PREDICTED_FILL, linewidth=0, zorder=1)
    axes.plot(theta, density, color=PREDICTED, linewidth=1.8, label="predicted", zorder=3)
    style.degree_axis(axes, "θ0, orientation before the push (°)")
    axes.set_ylabel("probability per degree")


def draw_measured_histogram(axes: Axes, histogram: AngleHistogram) -> None:
    """How often each direction was recorded."""
    look: dict[str, Any] = {"facecolor": MEASURED, "edgecolor": MEASURED_EDGE, "linewidth": 0.6, "alpha": 0.65}
    heights, edges = PER_DEGREE * histogram.density, np.degrees(histogram.edges)
    axes.stairs(heights, edges, fill=True, label="measured", zorder=2, **look)


def draw_staircase(axes: Axes, predicted: Array, measured: Array | None) -> None:
    """θ0 over the cycles, unwrapped: one predicted noisy run, and the measured one where there is one."""
    if measured is not None:
        axes.plot(np.degrees(measured), color=MEASURED, linewidth=2.2, label="measured", zorder=2)
    axes.plot(np.degrees(predicted), color=PREDICTED, linewidth=1.2, label="predicted", zorder=3)
    axes.set_xlabel("cycle")
    axes.set_xlim(0, max(len(predicted), 0 if measured is None else len(measured)) - 1)
    axes.xaxis.set_major_locator(MaxNLocator(5, integer=True, min_n_ticks=1))
    style.unwrapped_axis(axes, "θ0, unwrapped", LEAST_SPAN_DEG)
