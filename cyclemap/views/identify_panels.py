"""Panels of an identification: the friction ellipse, data beside predictions, intervals of parameters."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.ticker import MaxNLocator

from cyclemap.evidence.identification.identify import Estimate
from cyclemap.evidence.identified_curves import CycleFit, IdentifiedCurves, PlaceFit, TurnFit
from cyclemap.evidence.identified_material import readable_unit
from cyclemap.views.panel_parts import legend_above
from cyclemap.views.style import INK, MEASURED, MEASURED_EDGE, PREDICTED, PREDICTED_FILL, QUIET, degree_axis

_DOTS: dict[str, Any] = {
    "color": MEASURED,
    "markersize": 3.5,
    "alpha": 0.55,
    "markeredgecolor": MEASURED_EDGE,
    "markeredgewidth": 0.3,
    "linestyle": "none",
}


def draw_ellipse(axes: Axes, curves: IdentifiedCurves) -> None:
    """The friction ellipse over directions of sliding, what it may be, and the forces that scans measured."""
    axes.add_collection(
        LineCollection(list(curves.samples), colors=PREDICTED_FILL, linewidths=1.2, alpha=0.5, zorder=1)
    )
    axes.plot([], [], color=PREDICTED_FILL, linewidth=6, label="what it may be")
    if curves.forces is not None:
        axes.plot(*curves.forces.T, marker="o", label="measured", zorder=2, **_DOTS)
    axes.plot(*curves.ellipse.T, color=PREDICTED, linewidth=1.8, label="identified", zorder=4)
    if curves.worn is not None:
        axes.plot(*curves.worn.T, color=INK, linewidth=1.4, linestyle="--", label="at the end", zorder=4)
    axes.plot(0.0, 0.0, "+", color=QUIET, markersize=9, zorder=3)
    axes.set_aspect("equal", adjustable="datalim")
    unit = "" if curves.sized else ", size not told by motions"
    axes.set(xlabel=f"friction coefficient along x{unit}", ylabel="along y")
    legend_above(axes, columns=4)


def draw_shares(axes: Axes, plates: Mapping[str, Mapping[str, float]]) -> None:
    """Where the weight of each plate rests: a bar a plate, its shares from left to right."""
    names = list(plates)[::-1]
    left = np.zeros(len(names))
    looks = {"inner_share": (QUIET, "inside"), "rim_share": (PREDICTED, "rim"), "corner_share": (MEASURED, "corners")}
    for key, (colour, label) in looks.items():
        size = 100.0 * np.array([plates[name][key] for name in names])
        axes.barh(names, size, left=left, height=0.62, color=colour, label=label)
        left += size
    axes.barh(names, 100.0 - left, left=left, height=0.62, color=PREDICTED_FILL, label="even")
    axes.set(xlim=(0.0, 100.0), xlabel="share of the weight (%)")
    legend_above(axes, columns=4)


def draw_turns(axes: Axes, fit: TurnFit) -> None:
    """Predicted over measured turns of strokes."""
    measured, predicted = np.degrees(fit.measured), np.degrees(fit.predicted)
    axes.axline((0.0, 0.0), slope=1.0, color=PREDICTED, linewidth=1.4, label="equal", zorder=3)
    axes.plot(measured, predicted, marker="o", label="strokes", zorder=2, **_DOTS)
    axes.set(xlabel="measured turn (°)", ylabel="predicted turn (°)")
    legend_above(axes)


def draw_places(axes: Axes, fit: PlaceFit) -> None:
    """Where pushes ended, predicted less measured, with the circle that half of them keep within."""
    x, y = 1000.0 * fit.errors.T
    half = float(np.median(np.hypot(x, y)))
    around = np.linspace(0.0, 2 * np.pi, 121)
    axes.plot(x, y, marker="o", label="pushes", zorder=2, **_DOTS)
    axes.plot(
        half * np.cos(around), half * np.sin(around), color=PREDICTED, label=f"half within {half:.2g} mm", zorder=3
    )
    axes.plot(0.0, 0.0, "+", color=QUIET, markersize=9, zorder=3)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="error of the place, x (mm)", ylabel="y (mm)")
    legend_above(axes)


def draw_cycles(axes: Axes, fit: CycleFit) -> None:
    """Measured turns of cycles over θ0, and the fitted map's."""
    axes.axhline(0.0, color=QUIET, linewidth=0.9)
    theta = np.degrees(np.mod(fit.theta, 2 * np.pi))
    axes.plot(theta, np.degrees(fit.turn), marker="o", label="measured", zorder=2, **_DOTS)
    name = "identified" if fit.late is None else "at the start"
    axes.plot(np.degrees(fit.grid), np.degrees(fit.fitted), color=PREDICTED, linewidth=1.8, label=name, zorder=4)
    if fit.late is not None:
        late = np.degrees(fit.late)
        axes.plot(np.degrees(fit.grid), late, color=INK, linestyle="--", linewidth=1.4, label="at the end", zorder=4)
    degree_axis(axes, "θ0, orientation before the push (°)")
    axes.set_ylabel("turn of one cycle (°)")
    legend_above(axes)


def draw_interval(axes: Axes, one: Estimate) -> None:
    """The interval of one parameter on an axis of its own, its name at the left."""
    unit, factor = readable_unit(one.unit)
    value, lower, upper = factor * one.value, factor * one.lower, factor * one.upper
    look: dict[str, Any] = {
        "color": PREDICTED if one.identifiable else QUIET,
        "linewidth": 2.2,
        "solid_capstyle": "butt",
    }
    axes.plot([lower, upper], [0.0, 0.0], **look)
    axes.plot(value, 0.0, "o", color=look["color"], markersize=5)
    for end, opened in ((lower, one.lower_open), (upper, one.upper_open)):
        axes.plot(end, 0.0, "|" if not opened else "x", color=look["color"], markersize=8)
    room = 0.35 * max(upper - lower, 1e-9)
    # An interval narrower than the digits of its ticks would be labelled with an offset that nobody can read.
    room = max(room, 1e-3 * max(abs(lower), abs(upper), 1e-3))
    axes.set_xlim(lower - room, upper + room)
    axes.ticklabel_format(axis="x", useOffset=False)
    axes.set(yticks=[], ylim=(-1.0, 1.0))
    axes.xaxis.set_major_locator(MaxNLocator(4))
    axes.grid(visible=False)
    for side in ("left", "top", "right"):
        axes.spines[side].set_visible(False)
    axes.tick_params(axis="x", labelsize=7, length=2, pad=1)
    words = f"{one.name.replace('_', ' ')}{f' ({unit.strip()})' if unit else ''}"
    axes.text(-0.03, 0.5, words, transform=axes.transAxes, ha="right", va="center", fontsize=8)
