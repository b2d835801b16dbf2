"""Rotation numbers over one parameter and over two: the devil's staircase, the plane, its tongues
and bifurcations.
"""

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from cyclemap.arrays import Array, Mask, stretches
from cyclemap.maps import BifurcationCurve, RotationNumbers, RotationPlane, TongueBoundaries
from cyclemap.views.panels.layout import legend_above
from cyclemap.views.panels.style import (
    INK,
    MEASURED,
    PREDICTED,
    PREDICTED_FILL,
    UNSTABLE,
    Look,
    name_beside_path,
    name_tag,
    show_window,
    small,
)

ROTATION = "rotation number (turns a cycle)"
# Tongues of longer periods are too many and too narrow to outline in a plane.
LONGEST_PERIOD = 6
# Share of the panel's width from which a tongue or a plateau has room for its name.
NAMED_WIDTH = 0.012
# Names nearer than this share of the panel's width stand one above the other.
CLOSE_NAMES = 0.045
# Edges of tongues, by whether the map folds there.
TONGUE_EDGES: dict[bool, Look] = {
    False: {"linestyle": "-", "linewidth": 1.3, "label": "edge of a tongue"},
    True: {"linestyle": "--", "linewidth": 1.3, "label": "edge where the map folds"},
}
# Curves and points of bifurcations.
CURVES: dict[str, Look] = {
    "saddle-node": {"color": PREDICTED, "linestyle": "-", "linewidth": 2.0},
    "period-doubling": {"color": MEASURED, "linestyle": "-", "linewidth": 2.0},
    "border-collision": {"color": INK, "linestyle": ":", "linewidth": 2.0},
}
POINT: Look = {
    "linestyle": "none",
    "markersize": 8,
    "markeredgecolor": INK,
    "zorder": 5,
}
POINTS: dict[str, Look] = {
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
    """Draw rotation numbers over two parameters as colour; locked tongues outlined and named, cells
    of folded maps hatched.

    Parameters
    ----------
    axes : Axes
        Where they are drawn, with a colour bar beside.
    plane : RotationPlane
        As ``rotation_plane`` finds them.
    first_label : str, default 'first parameter'
        Of the horizontal axis, the first parameter.
    second_label : str, default 'second parameter'
        Of the vertical axis, the second parameter.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from cyclemap.maps import CircleMap, rotation_plane
    >>> from cyclemap.views.panels.rotation import draw_rotation_plane
    >>> axes = Figure().subplots()
    >>> draw_rotation_plane(axes, rotation_plane(CircleMap.arnold, [0.0, 0.5], [0.3, 0.9]))
    >>> axes.has_data()
    True
    """
    first, second = cell_edges(plane.first_values), cell_edges(plane.second_values)
    draw_shades(axes, first, second, plane.value, ROTATION, cmap="cividis")
    folded = "folded: an interval of rotation numbers, one orbit's shown"
    # White dots show on dark colours, dark lines on light ones.
    for color, hatch in ((INK, "//"), ("white", "..")):
        mark_cells(
            axes,
            first,
            second,
            plane.folded,
            label=folded,
            zorder=3,
            facecolor="none",
            edgecolor=color,
            hatch=hatch,
            linewidth=0.0,
        )
    _mark_tongues(axes, plane, first, second)
    axes.set(xlabel=first_label, ylabel=second_label)
    legend_above(axes)


def draw_shades(
    axes: Axes,
    first: Array,
    second: Array,
    values: Array,
    label: str,
    ticks: Array | None = None,
    **look: Any,
) -> Colorbar:
    """Values (n, m) as colour over two axes, by the edges (n + 1,) and (m + 1,) of their cells, and
    the scale beside them with these ticks, which is returned.
    """
    mesh = axes.pcolormesh(first, second, values.T, rasterized=True, **look)
    axes.set_xlim(float(first.min()), float(first.max()))
    axes.set_ylim(float(second.min()), float(second.max()))
    axes.grid(visible=False)
    return scale_beside(axes, mesh, label, ticks)


def scale_beside(
    axes: Axes, drawn: ScalarMappable, label: str, ticks: Array | None = None
) -> Colorbar:
    """The scale of the shades of what is drawn, at the right of the axes."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    return figure.colorbar(drawn, ax=axes, label=label, ticks=ticks)


def mark_cells(axes: Axes, first: Array, second: Array, marked: Mask, **look: Any) -> None:
    """A look laid over the cells (n, m) of a plane that are marked."""
    for column in np.flatnonzero(marked.any(axis=0)).tolist():
        bars = [
            (first[start], first[end] - first[start]) for start, end in stretches(marked[:, column])
        ]
        axes.broken_barh(bars, (second[column], second[column + 1] - second[column]), **look)


def runs(values: NDArray[Any]) -> list[tuple[int, int]]:
    """(first, last + 1) of every run of equal values (n,)."""
    changes = np.flatnonzero(values[1:] != values[:-1]) + 1
    return list(pairwise([0, *changes.tolist(), values.size]))


def cell_edges(values: Array) -> Array:
    """The edges (m + 1,) of cells round `values` (m,), half way between neighbours."""
    if values.size == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middle = 0.5 * (values[:-1] + values[1:])
    return np.array([2 * values[0] - middle[0], *middle, 2 * values[-1] - middle[-1]])


def _mark_tongues(axes: Axes, plane: RotationPlane, first: Array, second: Array) -> None:
    """Edges of cells locked at p/q of a short period, beside others; p/q in the widest row that has
    room for it.
    """
    shown = (plane.period > 0) & (plane.period <= LONGEST_PERIOD)
    ratio = np.where(shown, plane.winding / np.maximum(plane.period, 1), np.inf)
    white = withStroke(linewidth=2.0, foreground="white")
    look: Look = {"colors": INK, "linewidths": 0.8, "zorder": 4, "path_effects": [white]}
    i, j = np.nonzero(ratio[:-1] != ratio[1:])
    axes.vlines(first[i + 1], second[j], second[j + 1], capstyle="projecting", **look)
    i, j = np.nonzero(ratio[:, :-1] != ratio[:, 1:])
    axes.hlines(second[j + 1], first[i], first[i + 1], capstyle="projecting", **look)
    for winding, period in np.unique([plane.winding[shown], plane.period[shown]], axis=1).T:
        inside = (plane.winding == winding) & (plane.period == period)
        wide = np.flatnonzero(inside.sum(axis=0) > 0.8 * inside.sum(axis=0).max())
        row = int(wide[wide.size // 2])
        cells = np.flatnonzero(inside[:, row])
        if cells.size > NAMED_WIDTH * plane.first_values.size:
            x, y = plane.first_values[cells[cells.size // 2]], plane.second_values[row]
            name_tag(axes, float(x), float(y), ratio_name(Fraction(int(winding), int(period))))


def ratio_name(ratio: Fraction) -> str:
    """p/q, also where it is whole."""
    return f"{ratio.numerator}/{ratio.denominator}".replace("-", "−")


def draw_rotation_numbers(
    axes: Axes, parameter: Array, numbers: RotationNumbers, label: str = "parameter"
) -> None:
    """Draw rotation numbers over a parameter, the band that encloses them, and the plateaus by
    name.

    Parameters
    ----------
    axes : Axes
        Where they are drawn.
    parameter : ndarray, shape (m,)
        Values of the parameter.
    numbers : RotationNumbers
        As ``rotation_numbers`` finds them, one a value.
    label : str, default 'parameter'
        Of the horizontal axis.

    Examples
    --------
    >>> import numpy as np
    >>> from matplotlib.figure import Figure
    >>> from cyclemap.maps import ARNOLD_FAMILY, rotation_numbers
    >>> from cyclemap.views.panels.rotation import draw_rotation_numbers
    >>> axes, omega = Figure().subplots(), np.linspace(0.0, 1.0, 9)
    >>> draw_rotation_numbers(axes, omega, rotation_numbers(ARNOLD_FAMILY, omega, 0.5), "omega")
    >>> axes.get_xlabel()
    'omega'
    """
    widest = float(np.max(numbers.upper - numbers.lower))
    band = f"enclosure, at most {small(widest)} wide"
    axes.fill_between(
        parameter, numbers.lower, numbers.upper, color=PREDICTED_FILL, label=band, zorder=2
    )
    axes.plot(
        parameter,
        numbers.value,
        linewidth=1.0,
        color=PREDICTED,
        label="middle of the enclosure",
        zorder=3,
    )
    axes.set(xlabel=label, ylabel=ROTATION)
    axes.margins(x=0.0, y=0.08)
    rises = bool(numbers.value[-1] >= numbers.value[0])
    for start, end in runs(numbers.winding + 1j * numbers.period):
        if not numbers.period[start] or end - start < 2:
            continue
        low, high = float(parameter[start]), float(parameter[end - 1])
        value = float(numbers.value[start])
        axes.plot(
            [low, high], [value, value], color=INK, linewidth=3.0, label="locked at p/q", zorder=4
        )
        if abs(high - low) >= NAMED_WIDTH * float(np.ptp(parameter)):
            ratio = Fraction(int(numbers.winding[start]), int(numbers.period[start]))
            name_beside_path(axes, low, high, value, ratio_name(ratio), rises)
    legend_above(axes)


def draw_tongues(
    axes: Axes,
    boundaries: TongueBoundaries,
    first_label: str = "first parameter",
    second_label: str = "second parameter",
) -> None:
    """Draw tongues, filled between their edges, named above; edges dashed where maps fold and
    tongues overlap.

    Parameters
    ----------
    axes : Axes
        Where they are drawn.
    boundaries : TongueBoundaries
        As ``tongues`` finds them.
    first_label : str, default 'first parameter'
        Of the horizontal axis.
    second_label : str, default 'second parameter'
        Of the vertical axis.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from cyclemap.maps import CircleMap, tongues
    >>> from cyclemap.views.panels.rotation import draw_tongues
    >>> axes = Figure().subplots()
    >>> draw_tongues(axes, tongues(CircleMap.arnold, [0], [0.4, 0.8], (-0.5, 0.5)))
    >>> axes.has_data()
    True
    """
    second = boundaries.second
    for left, right, folded in zip(
        boundaries.left, boundaries.right, boundaries.folded, strict=True
    ):
        axes.fill_betweenx(second, left, right, color=PREDICTED, alpha=0.22, linewidth=0, zorder=2)
        for start, end in runs(folded):
            look = TONGUE_EDGES[bool(folded[start])]
            shown = slice(max(start - 1, 0), end)
            for edge in (left, right):
                axes.plot(edge[shown], second[shown], color=PREDICTED, zorder=3, **look)
    axes.set(xlabel=first_label, ylabel=second_label)
    axes.margins(x=0.02, y=0.0)
    # p/q above the upper end of every tongue, in two rows where they stand close.
    top = int(np.argmax(second))
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
    """Draw a plane of two parameters: curves by their kind, points of codimension two by their
    shapes, tongues filled.

    Parameters
    ----------
    axes : Axes
        Where they are drawn.
    curves : sequence of BifurcationCurve
        As ``bifurcation_curves`` finds them. Period doublings are dashed where they are
        subcritical: the orbit that they bear is unstable.
    boundaries : TongueBoundaries or None, optional
        Tongues that are filled; None: none.
    first_label : str, default 'first parameter'
        Of the horizontal axis.
    second_label : str, default 'second parameter'
        Of the vertical axis.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from cyclemap.maps import CircleMap, follow_bifurcation, saddle_nodes
    >>> from cyclemap.views.panels.rotation import draw_bifurcation_curves
    >>> (born,) = saddle_nodes(lambda p: CircleMap.arnold(p, 0.9), (0.0, 0.5))
    >>> edge = follow_bifurcation(CircleMap.arnold, born, 0.9, (0.0, 0.5), (0.5, 1.0))
    >>> axes = Figure().subplots()
    >>> draw_bifurcation_curves(axes, [edge], first_label="omega", second_label="K")
    >>> axes.get_xlabel(), axes.get_ylabel()
    ('omega', 'K')
    """
    if boundaries is not None:
        draw_tongues(axes, boundaries, first_label, second_label)
    for curve in curves:
        bad = (np.nan_to_num(curve.coefficient[1:]) < 0.0) & (curve.kind == "period-doubling")
        for start, end in runs(bad):
            look, label, shown = CURVES[curve.kind], curve.kind, slice(start, end + 1)
            if bad[start]:
                look, label = {**look, "linestyle": "--"}, f"subcritical {curve.kind}"
            axes.plot(curve.first[shown], curve.second[shown], label=label, zorder=4, **look)
        for point in curve.special:
            place = [float(point.first)], [float(point.second)]
            axes.plot(*place, label=point.kind, **POINT, **POINTS[point.kind])
    ends = [np.array([curve.first, curve.second]) for curve in curves]
    if boundaries is not None:
        ends.append(np.array([axes.get_xlim(), axes.get_ylim()]))
    low, high = np.min(np.hstack(ends), axis=1), np.max(np.hstack(ends), axis=1)
    low, high = low - 0.02 * (high - low), high + 0.02 * (high - low)
    show_window(axes, low, high)
    axes.set(xlabel=first_label, ylabel=second_label)
    legend_above(axes)
