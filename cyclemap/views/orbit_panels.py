"""A map's graph with its orbits, their basins, slow passages, and orbits over a parameter with their bifurcations."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from cyclemap.arrays import TWO_PI, Array
from cyclemap.collection.portrait_curves import turn_curve
from cyclemap.maps import (
    Basin,
    Bifurcation,
    CircleMap,
    LyapunovExponents,
    Orbit,
    OrbitBranch,
    OrbitDiagram,
    SlowPassage,
    nth_iterate,
)
from cyclemap.views.sentences import angle, number
from cyclemap.views.style import (
    INK,
    MEASURED,
    PREDICTED,
    PREDICTED_FILL,
    QUIET,
    THETA,
    UNSTABLE,
    degree_axis,
    legend_above,
    name_tag,
    orbit_keys,
    orbit_marker,
    say,
    stability,
    whole_turn_ticks,
)

HALF_ROW = 0.28
# A smaller share of the circle is what rounding leaves between neighbouring arcs.
TOLD_SHARE = 1e-6
Curve = tuple[Array, Array]
WINDOW_SAMPLES = 400
# Widths of a slow passage that are shown on each side of its slowest point.
WIDTHS_SHOWN = 4.0
STABLE: dict[str, Any] = {"color": PREDICTED, "linewidth": 2.0, "linestyle": "-", "zorder": 3}
LOST: dict[str, Any] = {"color": QUIET, "linewidth": 1.3, "linestyle": "--", "zorder": 2}
# Shapes differ, so that the colours need not be told apart.
MARKERS: dict[str, dict[str, Any]] = {
    "saddle-node": {"marker": "o", "markerfacecolor": UNSTABLE},
    "period-doubling": {"marker": "D", "markerfacecolor": MEASURED},
    "border-collision": {"marker": "^", "markerfacecolor": INK},
    "branch point": {"marker": "X", "markerfacecolor": UNSTABLE},
}


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
    orbit = basin.orbit
    name = f"period {orbit.period}, winding {orbit.winding}: {100 * basin.measure:.3g} % of the circle"
    axes.annotate(name, (0.0, row - HALF_ROW), (0, 4), textcoords="offset points", fontsize=8)
    points_deg = np.degrees(basin.orbit.points)
    axes.plot(points_deg, np.full(points_deg.size, row), label=labels[2], **orbit_marker("stable"))


def _bars(arcs: Array) -> list[tuple[float, float]]:
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
    error = f", off by {100 * passage.relative_error:.1g} %" if np.isfinite(passage.relative_error) else ""
    name = f"parabola: {number(passage.passage_cycles)} cycles to pass{error}"
    axes.plot(theta_deg, parabola_deg, color=INK, linewidth=1.2, linestyle="--", label=name)
    _mark_gap_and_width(axes, passage)
    counted = "one cycle" if passage.period == 1 else f"{passage.period} cycles"
    turns = "" if passage.winding == 0 else f" less {360 * passage.winding}°"
    axes.set(xlabel=THETA, ylabel=f"move of {counted}{turns} (°)", xlim=(theta_deg[0], theta_deg[-1]))
    largest = 1.1 * float(np.nanmax(np.abs(np.append(move_deg, parabola_deg))))
    axes.set_ylim(*((-0.1 * largest, largest) if passage.direction > 0 else (-largest, 0.1 * largest)))
    legend_above(axes)


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


def map_graph(circle_map: CircleMap) -> list[Curve]:
    """The graph of `circle_map` over one circle, (θ, θ' mod 360) in degrees, cut at jumps and where θ' runs round."""
    graph: list[Curve] = []
    for theta, turn in turn_curve(circle_map).pieces:
        graph += cut_at_turns(np.degrees(theta), theta + turn)
    return graph


def cut_at_turns(x: Array, angle: Array) -> list[Curve]:
    """Pieces (x, angle mod 360 in degrees) of the polyline through (`x`, `angle` in rad), cut at whole turns."""
    position = np.arange(angle.size, dtype=float)
    levels = np.arange(np.floor(angle.min() / TWO_PI) + 1, np.ceil(angle.max() / TWO_PI)) * TWO_PI
    crossings = [_crossings(angle, level) for level in levels]
    places = np.unique(np.concatenate([position, *crossings]))
    x, angle = np.interp(places, position, x), np.interp(places, position, angle)
    turn = np.floor(0.5 * (angle[:-1] + angle[1:]) / TWO_PI)
    edges = [0, *(np.flatnonzero(np.diff(turn)) + 1).tolist(), angle.size - 1]
    return [
        (x[first : last + 1], np.degrees(angle[first : last + 1] - TWO_PI * turn[first]))
        for first, last in pairwise(edges)
    ]


def _crossings(angle: Array, level: float) -> Array:
    """Where along the polyline `angle` crosses `level`, in numbers of its points."""
    before = np.flatnonzero(np.diff(angle > level))
    return np.asarray(before + (level - angle[before]) / (angle[before + 1] - angle[before]))


def passage_curve(circle_map: CircleMap, passage: SlowPassage) -> tuple[Array, Array, Array]:
    """(θ, move of the n-fold cycle less its whole turns, parabola ε + a x²) about a slow passage, in degrees.

    The move is nan where it jumps.
    """
    reach = min(WIDTHS_SHOWN * passage.width, np.pi)
    iterate = nth_iterate(circle_map, passage.period)
    x = np.linspace(-reach, reach, WINDOW_SAMPLES + 1)
    move = iterate.turn(passage.theta + x) - TWO_PI * passage.winding
    jumps = np.mod(iterate.jumps()[0] - passage.theta + reach, TWO_PI) - reach
    jumps = jumps[jumps < reach]
    places = np.searchsorted(x, jumps)
    x, move = np.insert(x, places, jumps), np.insert(move, places, np.nan)
    parabola = passage.gap + passage.curvature * x**2
    return np.degrees(passage.theta + x), np.degrees(move), np.degrees(parabola)


def branch_curves(branch: OrbitBranch) -> list[tuple[bool, Curve]]:
    """(stable, (parameter, angle mod 360 in degrees)) for every run of one stability of every point of the orbits."""
    stable, angles = _stable_segments(branch), branch.points
    edges = [0, *(np.flatnonzero(np.diff(stable)) + 1).tolist(), stable.size]
    return [
        (bool(stable[first]), curve)
        for first, last in pairwise(edges)
        for points in angles[first : last + 1].T
        for curve in cut_at_turns(branch.parameter[first : last + 1], points)
    ]


def _stable_segments(branch: OrbitBranch) -> NDArray[np.bool_]:
    """Whether the orbits between neighbouring ones are stable: as the end is that is no bifurcation."""
    special = np.array([float(found.parameter) for found in branch.special])
    distance = np.abs(branch.parameter[:, None] - special).min(axis=1, initial=np.inf)
    bifurcates = distance <= 1e-9 * max(float(np.ptp(branch.parameter)), 1e-300)
    return np.where(bifurcates[:-1], branch.stable[1:], branch.stable[:-1])


def draw_orbit_branches(
    axes: Axes,
    branches: Sequence[OrbitBranch],
    bifurcations: Sequence[Bifurcation] = (),
    parameter_label: str = "parameter",
) -> None:
    """Angles of the orbits over the parameter: solid where stable, dashed where not; bifurcations by their shapes."""
    axes.set(xlabel=parameter_label, ylabel="θ of the orbit (°)")
    whole_turn_ticks(axes)
    if not branches:
        say(axes, "no periodic orbit")
    seen: set[str] = set()
    for branch in branches:
        for stable, (parameter, theta_deg) in branch_curves(branch):
            label = _once("stable" if stable else "unstable", seen)
            axes.plot(parameter, theta_deg, label=label, **(STABLE if stable else LOST))
    for found in bifurcations:
        _mark(axes, found, _once(found.kind, seen))
    axes.margins(x=0.02)
    named = dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
    legend_above(axes, columns=6, handles=[named[name] for name in ("stable", "unstable", *MARKERS) if name in named])


def _once(name: str, seen: set[str]) -> str | None:
    """`name` the first time, then None."""
    label = None if name in seen else name
    seen.add(name)
    return label


def _mark(axes: Axes, found: Bifurcation, label: str | None) -> None:
    points_deg = np.degrees(found.points)
    look: dict[str, Any] = {"linestyle": "none", "markersize": 7, "markeredgecolor": INK, "markeredgewidth": 1.2}
    parameter = np.full(points_deg.size, float(found.parameter))
    axes.plot(parameter, points_deg, label=label, zorder=5, **look, **MARKERS[found.kind])


def draw_orbit_diagram(axes: Axes, diagram: OrbitDiagram, parameter_label: str = "parameter") -> None:
    """Every angle that the orbits visit, a dot each, over the parameter."""
    parameter = np.repeat(diagram.parameter, diagram.theta.shape[1])
    axes.plot(parameter, np.degrees(diagram.theta).ravel(), ",", color=INK, alpha=0.5, rasterized=True)
    axes.set(xlabel=parameter_label, ylabel="θ of the orbit (°)")
    whole_turn_ticks(axes)
    axes.margins(x=0.0)


def draw_lyapunov_exponents(
    axes: Axes, exponents: LyapunovExponents, first_label: str = "parameter", second_label: str = "second parameter"
) -> None:
    """A curve over the one parameter that varies, or colour over two: red where orbits diverge, blue where not."""
    varying = [values for values in exponents.parameters if values.size > 1]
    label = "Lyapunov exponent (1/cycle)"
    if exponents.value.ndim == 1:
        axes.plot(varying[0].ravel(), exponents.value, color=PREDICTED, linewidth=1.2)
        axes.axhline(0.0, color=QUIET, linewidth=0.8, linestyle="--")
        axes.set(xlabel=first_label, ylabel=label)
        axes.margins(x=0.0)
        return
    finite = exponents.value[np.isfinite(exponents.value)]
    # The few deep minima, at superstable orbits, would leave no colour to the rest.
    reach = max(float(np.max(finite, initial=0.0)), float(np.quantile(np.append(np.abs(finite), 1e-3), 0.9)))
    mesh = axes.pcolormesh(
        *(values.ravel() for values in varying),
        exponents.value.T,
        cmap="RdBu_r",
        vmin=-reach,
        vmax=reach,
        rasterized=True,
    )
    axes.set(xlabel=first_label, ylabel=second_label)
    axes.grid(visible=False)
    axes.get_figure(root=True).colorbar(mesh, ax=axes, label=label, extend="min")  # type: ignore[union-attr]
