"""A map's graph with its orbits, the basins of the stable ones, and the slow passage that a lost one leaves behind."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from cyclemap.maps import Basin, CircleMap, Orbit, SlowPassage
from cyclemap.views.panel_curves import map_graph, passage_curve
from cyclemap.views.panel_parts import (
    THETA,
    legend_above,
    name_tag,
    orbit_keys,
    orbit_marker,
    say,
    stability,
    whole_turn_ticks,
)
from cyclemap.views.sentences import angle, number
from cyclemap.views.style import INK, PREDICTED, PREDICTED_FILL, QUIET, degree_axis

HALF_ROW = 0.28
# A smaller share of the circle is what rounding leaves between neighbouring arcs.
TOLD_SHARE = 1e-6


def draw_map(axes: Axes, circle_map: CircleMap, orbits: Sequence[Orbit] = ()) -> None:
    """The graph of the map on one circle, cut at its jumps, the diagonal, and `orbits` on the graph."""
    axes.plot([0.0, 360.0], [0.0, 360.0], color=QUIET, linewidth=0.9, linestyle="--", zorder=2)
    for theta_deg, image_deg in map_graph(circle_map):
        axes.plot(theta_deg, image_deg, color=PREDICTED, linewidth=1.8, zorder=3)
    for orbit in orbits:
        points_deg = np.degrees(orbit.points)
        axes.plot(points_deg, np.roll(points_deg, -1), **orbit_marker(stability(orbit)))
    degree_axis(axes, THETA)
    whole_turn_ticks(axes)
    axes.set(ylabel="next θ (°)", aspect="equal")
    legend_above(axes, handles=orbit_keys({stability(orbit) for orbit in orbits}))


# -- basins ------------------------------------------------------------------------------------------------


def draw_basins(axes: Axes, basins: Sequence[Basin]) -> None:
    """A band for every basin, its immediate part hatched, its stable points as dots; the share of none is told."""
    degree_axis(axes, THETA)
    axes.set_yticks([])
    axes.set_ylim(max(len(basins), 1) - 0.6, -0.5)
    if not basins:
        say(axes, "no stable orbit")
        return
    for row, basin in enumerate(basins):
        _draw_basin(axes, row, basin)
    undecided = basins[0].undecided
    share = f"{100 * undecided:.2g} %" if undecided > TOLD_SHARE else "nothing"
    axes.plot([], [], label=f"undecided: {share}", linestyle="none")
    legend_above(axes, columns=4)


def _basin_name(basin: Basin) -> str:
    return f"period {basin.orbit.period}, winding {basin.orbit.winding}: {100 * basin.measure:.3g} % of the circle"


def _draw_basin(axes: Axes, row: int, basin: Basin) -> None:
    height = (row - HALF_ROW, 2 * HALF_ROW)
    labels = ("basin", "immediate basin", "stable orbit") if row == 0 else (None, None, None)
    axes.broken_barh(_bars(basin.arcs), height, facecolor=PREDICTED_FILL, linewidth=0, label=labels[0], zorder=2)
    axes.broken_barh(
        _bars(basin.immediate),
        height,
        facecolor="none",
        edgecolor=PREDICTED,
        hatch="////",
        linewidth=0,
        label=labels[1],
        zorder=3,
    )
    axes.annotate(_basin_name(basin), (0.0, row - HALF_ROW), (0, 4), textcoords="offset points", fontsize=8)
    points_deg = np.degrees(basin.orbit.points)
    axes.plot(points_deg, np.full(points_deg.size, row), label=labels[2], **orbit_marker("stable"))


def _bars(arcs: np.typing.NDArray[np.float64]) -> list[tuple[float, float]]:
    """(start, length) in degrees of arcs (m, 2) rad, those across 360° in two parts."""
    bars = []
    for start, end in np.degrees(arcs).tolist():
        first = start % 360.0
        last = first + end - start
        bars.append((first, min(last, 360.0) - first))
        if last > 360.0:
            bars.append((0.0, last - 360.0))
    return bars


# -- slow passages -----------------------------------------------------------------------------------------


def draw_slow_passage(axes: Axes, circle_map: CircleMap, passage: SlowPassage) -> None:
    """The move of one cycle (of n, for period n) about its least, the parabola there, and what follows from it."""
    theta_deg, move_deg, parabola_deg = passage_curve(circle_map, passage)
    axes.axhline(0.0, color=QUIET, linewidth=0.9)
    axes.plot(theta_deg, move_deg, color=PREDICTED, linewidth=2.0, label="map", zorder=3)
    axes.plot(theta_deg, parabola_deg, color=INK, linewidth=1.2, linestyle="--", label=_parabola_name(passage))
    _mark_gap_and_width(axes, passage)
    axes.set(xlabel=THETA, ylabel=_move_name(passage), xlim=(theta_deg[0], theta_deg[-1]))
    largest = 1.1 * float(np.nanmax(np.abs(np.append(move_deg, parabola_deg))))
    axes.set_ylim(*((-0.1 * largest, largest) if passage.direction > 0 else (-largest, 0.1 * largest)))
    legend_above(axes)


def _parabola_name(passage: SlowPassage) -> str:
    error = f", off by {100 * passage.relative_error:.1g} %" if np.isfinite(passage.relative_error) else ""
    return f"parabola: {number(passage.passage_cycles)} cycles to pass{error}"


def _move_name(passage: SlowPassage) -> str:
    counted = "one cycle" if passage.period == 1 else f"{passage.period} cycles"
    turns = "" if passage.winding == 0 else f" less {360 * passage.winding}°"
    return f"move of {counted}{turns} (°)"


def _mark_gap_and_width(axes: Axes, passage: SlowPassage) -> None:
    """ε as a double arrow at the slowest point, and the stretch on which the move is less than doubled."""
    centre_deg, width_deg, gap_deg = (float(np.degrees(v)) for v in (passage.theta, passage.width, passage.gap))
    arrow = {"arrowstyle": "<->", "color": INK, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (centre_deg, gap_deg), (centre_deg, 0.0), arrowprops=arrow, zorder=4)
    across = [centre_deg - width_deg, centre_deg + width_deg]
    axes.plot(across, [2.0 * gap_deg] * 2, color=INK, linewidth=1.0, marker="|", markersize=8, zorder=4)
    name_tag(axes, centre_deg + 0.15 * width_deg, 0.5 * gap_deg, f"ε = {angle(passage.gap, 2)}", ha="left")
    side = "bottom" if passage.direction > 0 else "top"
    offset = (0.0, 4.0 * passage.direction)
    name = f"2·width = {angle(2 * passage.width)}"
    name_tag(axes, centre_deg, 2.0 * gap_deg, name, va=side, xytext=offset, textcoords="offset points")
