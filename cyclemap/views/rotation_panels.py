"""Rotation numbers over one parameter and over two: the devil's staircase, the plane, its tongues
and bifurcations.
"""

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patheffects import Normal, Stroke
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.maps import BifurcationCurve, RotationNumbers, RotationPlane, TongueBoundaries
from cyclemap.views.style import (
    INK,
    MEASURED,
    PREDICTED,
    PREDICTED_FILL,
    UNSTABLE,
    legend_above,
    name_beside_path,
    name_tag,
    small,
)

ROTATION = "rotation number (turns a cycle)"
# Tongues of longer periods are too many and too narrow to outline in a plane.
LONGEST_PERIOD = 6
# Share of the panel's width from which a tongue or a plateau has room for its name.
NAMED_WIDTH = 0.012
# Names nearer than this share of the panel's width stand one above the other.
CLOSE_NAMES = 0.045
# Curves and points of bifurcations.
CURVES: dict[str, dict[str, Any]] = {
    "saddle-node": {"color": PREDICTED, "linestyle": "-", "linewidth": 2.0},
    "period-doubling": {"color": MEASURED, "linestyle": "-", "linewidth": 2.0},
    "border-collision": {"color": INK, "linestyle": ":", "linewidth": 2.0},
}
POINTS: dict[str, dict[str, Any]] = {
    "cusp": {"marker": "v", "markerfacecolor": UNSTABLE},
    "generalised flip": {"marker": "D", "markerfacecolor": MEASURED},
    "tip": {"marker": "o", "markerfacecolor": UNSTABLE},
    "border saddle-node": {"marker": "^", "markerfacecolor": INK},
    "border flip": {"marker": "s", "markerfacecolor": INK},
}


def draw_rotation_plane(
    axes: Axes,
    plane: RotationPlane,
    first_label: str = "first parameter",
    second_label: str = "second parameter",
) -> None:
    """Turns a cycle as colour, a colour bar; locked tongues outlined and named, cells of folded
    maps hatched.
    """
    first, second = cell_edges(plane.first_values), cell_edges(plane.second_values)
    mesh = axes.pcolormesh(first, second, plane.value.T, cmap="cividis", rasterized=True)
    label = "folded: an interval of rotation numbers, one orbit's shown"
    for column in np.flatnonzero(plane.folded.any(axis=0)).tolist():
        runs = [
            (first[start], first[end] - first[start])
            for start, end in _runs(plane.folded[:, column])
        ]
        height = (second[column], second[column + 1] - second[column])
        # White dots show on dark colours, dark lines on light ones.
        for color, hatch in ((INK, "//"), ("white", "..")):
            look: dict[str, Any] = {
                "facecolor": "none",
                "edgecolor": color,
                "hatch": hatch,
                "linewidth": 0.0,
            }
            axes.broken_barh(runs, height, label=label, zorder=3, **look)
            label = ""
    _mark_tongues(axes, plane, first, second)
    axes.set(xlabel=first_label, ylabel=second_label)
    axes.set_xlim(float(first.min()), float(first.max()))
    axes.set_ylim(float(second.min()), float(second.max()))
    axes.grid(visible=False)
    legend_above(axes)
    axes.get_figure(root=True).colorbar(mesh, ax=axes, label=ROTATION)  # type: ignore[union-attr]


def cell_edges(values: Array) -> Array:
    """The edges (m + 1,) of cells round `values` (m,), half way between neighbours."""
    if values.size == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middle = 0.5 * (values[:-1] + values[1:])
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def _mark_tongues(axes: Axes, plane: RotationPlane, first: Array, second: Array) -> None:
    """Edges of cells locked at p/q of a short period, beside others; p/q in the widest row that has
    room for it.
    """
    shown = (plane.period > 0) & (plane.period <= LONGEST_PERIOD)
    ratio = np.where(shown, plane.winding / np.maximum(plane.period, 1), np.inf)
    across, upward = ratio[:-1] != ratio[1:], ratio[:, :-1] != ratio[:, 1:]
    lines = [
        [(first[i + 1], second[j]), (first[i + 1], second[j + 1])] for i, j in np.argwhere(across)
    ]
    lines += [
        [(first[i], second[j + 1]), (first[i + 1], second[j + 1])] for i, j in np.argwhere(upward)
    ]
    edges = LineCollection(lines, colors=INK, linewidths=0.8, capstyle="projecting", zorder=4)
    edges.set_path_effects([Stroke(linewidth=2.0, foreground="white"), Normal()])
    axes.add_collection(edges, autolim=False)
    for winding, period in sorted(
        set(zip(plane.winding[shown].tolist(), plane.period[shown].tolist(), strict=True))
    ):
        inside = (plane.winding == winding) & (plane.period == period)
        wide = np.flatnonzero(inside.sum(axis=0) > 0.8 * inside.sum(axis=0).max())
        row = int(wide[wide.size // 2])
        cells = np.flatnonzero(inside[:, row])
        if cells.size > NAMED_WIDTH * plane.first_values.size:
            x, y = plane.first_values[cells[cells.size // 2]], plane.second_values[row]
            name_tag(axes, float(x), float(y), ratio_name(Fraction(winding, period)))


def ratio_name(ratio: Fraction) -> str:
    """p/q, also where it is whole."""
    return f"{ratio.numerator}/{ratio.denominator}".replace("-", "−")


def _runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """(first, last + 1) of every run of true entries."""
    changes = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]])))
    return list(zip(changes[::2].tolist(), changes[1::2].tolist(), strict=True))


def draw_rotation_numbers(
    axes: Axes, parameter: Array, numbers: RotationNumbers, label: str = "parameter"
) -> None:
    """Rotation numbers (m,) over `parameter` (m,), the band that encloses them, and the plateaus by
    name.
    """
    widest = float(np.max(numbers.upper - numbers.lower))
    band = f"enclosure, at most {small(widest)} wide"
    axes.fill_between(
        parameter, numbers.lower, numbers.upper, color=PREDICTED_FILL, label=band, zorder=2
    )
    axes.plot(
        parameter,
        numbers.value,
        color=PREDICTED,
        linewidth=1.0,
        label="middle of the enclosure",
        zorder=3,
    )
    axes.set(xlabel=label, ylabel=ROTATION)
    axes.margins(x=0.0, y=0.08)
    span, told = float(np.ptp(parameter)), "locked at p/q"
    rises = numbers.value[-1] >= numbers.value[0]
    same = (numbers.period[1:] == numbers.period[:-1]) & (
        numbers.winding[1:] == numbers.winding[:-1]
    )
    for first, last in _runs(same & (numbers.period[1:] > 0)):
        low, high = float(parameter[first]), float(parameter[last])
        value = float(numbers.value[first])
        axes.plot([low, high], [value, value], color=INK, linewidth=3.0, label=told, zorder=4)
        told = ""
        if abs(high - low) >= NAMED_WIDTH * span:
            ratio = Fraction(int(numbers.winding[first]), int(numbers.period[first]))
            name_beside_path(axes, low, high, value, ratio_name(ratio), bool(rises))
    legend_above(axes)


def draw_tongues(
    axes: Axes,
    boundaries: TongueBoundaries,
    first_label: str = "first parameter",
    second_label: str = "second parameter",
) -> None:
    """The tongues, filled between their edges, named above; edges dashed where maps fold and
    tongues overlap.
    """
    second = boundaries.second
    labels = {False: "edge of a tongue", True: "edge where the map folds"}
    for left, right, folded in zip(
        boundaries.left, boundaries.right, boundaries.folded, strict=True
    ):
        axes.fill_betweenx(second, left, right, color=PREDICTED, alpha=0.22, linewidth=0, zorder=2)
        changes = (np.flatnonzero(np.diff(folded)) + 1).tolist()
        for edge in (left, right):
            for first, last in pairwise([0, *changes, edge.size]):
                bent, part = bool(folded[first]), slice(max(first - 1, 0), last)
                look: dict[str, Any] = {
                    "linewidth": 1.3,
                    "linestyle": "--" if bent else "-",
                    "zorder": 3,
                }
                axes.plot(
                    edge[part], second[part], color=PREDICTED, label=labels.pop(bent, None), **look
                )
    axes.set(xlabel=first_label, ylabel=second_label)
    axes.margins(x=0.02, y=0.0)
    # p/q above the upper end of every tongue, in two rows where they stand close.
    top = int(np.argmax(boundaries.second))
    middle = 0.5 * (boundaries.left + boundaries.right)[:, top]
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.11 * (high - low))
    before, raised = -np.inf, False
    for index in np.argsort(middle).tolist():
        raised = not raised and bool(middle[index] - before < CLOSE_NAMES * np.ptp(axes.get_xlim()))
        before = float(middle[index])
        name, offset = ratio_name(boundaries.ratios[index]), (0, 15 if raised else 3)
        name_tag(axes, before, high, name, va="bottom", xytext=offset, textcoords="offset points")
    legend_above(axes)


def draw_bifurcation_curves(
    axes: Axes,
    curves: Sequence[BifurcationCurve],
    boundaries: TongueBoundaries | None = None,
    first_label: str = "first parameter",
    second_label: str = "second parameter",
) -> None:
    """A plane of two parameters: curves by their kind, points of codimension two by their shapes,
    tongues filled.

    Period doublings are dashed where they are subcritical: the orbit that they bear is unstable.
    """
    if boundaries is not None:
        draw_tongues(axes, boundaries, first_label, second_label)
    for curve in curves:
        look, born = CURVES[curve.kind], np.nan_to_num(curve.coefficient[1:])
        bad = (born < 0.0) & (curve.kind == "period-doubling")
        changes = (np.flatnonzero(np.diff(bad)) + 1).tolist()
        for start, end in pairwise([0, *changes, bad.size]):
            shown = {**look, "linestyle": "--"} if bad[start] else look
            part, label = (
                slice(start, end + 1),
                f"subcritical {curve.kind}" if bad[start] else curve.kind,
            )
            axes.plot(curve.first[part], curve.second[part], label=label, zorder=4, **shown)
        for point in curve.special:
            mark = {
                "linestyle": "none",
                "markersize": 8,
                "markeredgecolor": INK,
                **POINTS[point.kind],
            }
            axes.plot(
                [float(point.first)], [float(point.second)], label=point.kind, zorder=5, **mark
            )
    shown_to = np.array([axes.get_xlim(), axes.get_ylim()])
    for index, values in enumerate(
        zip(*((curve.first, curve.second) for curve in curves), strict=True)
    ):
        every = (
            np.concatenate([shown_to[index], *values])
            if boundaries is not None
            else np.concatenate(values)
        )
        shown_to[index] = every.min(), every.max()
    shown_to += 0.02 * np.ptp(shown_to, axis=1, keepdims=True) * np.array([-1.0, 1.0])
    axes.set(xlabel=first_label, ylabel=second_label, xlim=shown_to[0], ylim=shown_to[1])
    named = dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
    legend_above(axes, columns=4, handles=list(named.values()))
