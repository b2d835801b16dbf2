"""One look for every picture: colours that also differ in lightness, lines, markers, axes, name
tags.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import (
    FixedLocator,
    FuncFormatter,
    MaxNLocator,
    MultipleLocator,
    NullFormatter,
)

from cyclemap.arrays import Array
from cyclemap.maps import Orbit

# Options of Matplotlib.
Look = dict[str, Any]
INK = "#222222"
QUIET = "#666666"
PREDICTED = "#0b3d6b"
PREDICTED_FILL = "#d5e3ef"
MEASURED = "#e69f00"
MEASURED_EDGE = "#8a5a00"
UNSTABLE = "#ffffff"
FORCE = "#c1440e"
_STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titlepad": 8.0,
    "axes.labelsize": 9.0,
    "axes.edgecolor": QUIET,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#ececec",
    "grid.linewidth": 0.7,
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.fontsize": 8.0,
    "legend.frameon": True,
    "legend.framealpha": 0.9,
    "legend.edgecolor": "none",
    "legend.borderpad": 0.2,
    "text.color": INK,
    "path.simplify": True,
    "pdf.fonttype": 42,
    # A fixed salt and no date: the same portrait gives the same file.
    "svg.hashsalt": "cyclemap",
}
# Curves in one panel, told apart in a grey print too; what is predicted is the first.
LINES: tuple[Look, ...] = (
    {"color": PREDICTED, "linestyle": "-", "linewidth": 2.0, "zorder": 4},
    {"color": INK, "linestyle": "--", "linewidth": 1.4, "zorder": 4},
    {"color": FORCE, "linestyle": "-.", "linewidth": 1.6, "zorder": 4},
    {"color": QUIET, "linestyle": ":", "linewidth": 1.6, "zorder": 4},
)
LINE, SECOND, THIRD, FOURTH = LINES
# What was measured: places of which there may be many, their means, a path, and columns.
DOTS: Look = {
    "marker": "o",
    "linestyle": "none",
    "color": MEASURED,
    "markersize": 3.4,
    "alpha": 0.5,
    "markeredgecolor": MEASURED_EDGE,
    "markeredgewidth": 0.3,
    "zorder": 2,
}
MARKS: Look = {
    "linestyle": "none",
    "color": MEASURED,
    "markersize": 4.5,
    "markeredgecolor": MEASURED_EDGE,
    "markeredgewidth": 0.7,
    "zorder": 3,
}
PATH: Look = {"color": MEASURED, "linewidth": 2.2, "zorder": 2}
BARS: Look = {
    "facecolor": MEASURED,
    "edgecolor": MEASURED_EDGE,
    "linewidth": 0.6,
    "alpha": 0.65,
    "zorder": 2,
}
# A marked place.
OPEN: Look = {"markerfacecolor": UNSTABLE, "markeredgecolor": INK, "linestyle": "none"}
# The range of what is predicted, the line of nothing, and of all alike.
BAND: Look = {"color": PREDICTED_FILL, "linewidth": 0.0, "zorder": 1}
ZERO: Look = {"color": QUIET, "linewidth": 0.9, "zorder": 1}
EVEN: Look = {"color": QUIET, "linewidth": 1.0, "linestyle": ":", "zorder": 2}
THETA, THETA0 = "θ (°)", "θ0, orientation before the push (°)"


@contextmanager
def picture_style() -> Iterator[None]:
    """The look of cyclemap's pictures, for as long as the block lasts."""
    with matplotlib.rc_context(_STYLE):
        yield


def degree_axis(axes: Axes, label: str = THETA0, every: int = 45) -> None:
    """Make the x axis of `axes` one circle in degrees."""
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(range(0, 361, every))
    axes.set_xlabel(label)


def whole_turn_ticks(axes: Axes) -> None:
    """Make the y axis of `axes` one circle in degrees."""
    axes.set_ylim(0.0, 360.0)
    axes.yaxis.set_major_locator(MultipleLocator(45.0))


def count_axis(axes: Axes, label: str, count: int) -> None:
    """Make the x axis of `axes` that of a count from 0, with whole numbers as ticks."""
    axes.set(xlabel=label, xlim=(0, max(count, 1)))
    axes.xaxis.set_major_locator(MaxNLocator(6, integer=True, min_n_ticks=1))


def plain_ticks(axis: Axis, places: Sequence[float]) -> None:
    """Plain numbers at these places of a logarithmic axis, and nothing else."""
    axis.set_major_locator(FixedLocator(places))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def square_window(axes: Axes, points: Array) -> None:
    """Show the least square about points (n, 2) and a margin on one scale."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = 0.5 * (low + high), 0.56 * float((high - low).max())
    show_window(axes, middle - half, middle + half)
    axes.set_aspect("equal", adjustable="box")


def show_window(axes: Axes, low: Array, high: Array) -> None:
    """Show what lies between two corners (2,) of the data."""
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))


def name_tag(axes: Axes, x: float, y: float, name: str, **options: object) -> None:
    """A short name at a place of the data, on a white ground that lets lines through a little."""
    ground = {"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}
    given: Look = {
        "fontsize": 7.5,
        "color": INK,
        "ha": "center",
        "va": "center",
        "zorder": 8,
        **options,
    }
    axes.annotate(name, (x, y), annotation_clip=True, bbox=ground, **given)


def name_beside(axes: Axes, x: float, y: float, name: str, offset: tuple[float, float]) -> None:
    """A name on a white ground, so many points to the right of a marked place (to the left:
    negative) and above it.
    """
    side = "left" if offset[0] > 0.0 else "right"
    name_tag(
        axes,
        x,
        y,
        name,
        fontsize=8,
        ha=side,
        va="baseline",
        xytext=offset,
        textcoords="offset points",
    )


def name_beside_path(
    axes: Axes, start: float, end: float, level: float, name: str, rises: bool
) -> None:
    """A name above a flat stretch, on the side where a rising (or a falling) curve leaves room for
    it.
    """
    place, side, offset = (end, "right", (-3, 4)) if rises else (start, "left", (3, 4))
    name_tag(
        axes, place, level, name, ha=side, va="bottom", xytext=offset, textcoords="offset points"
    )


def arrow(
    axes: Axes,
    tail: Array,
    tip: Array,
    colour: str,
    width: float = 1.8,
    zorder: float = 5.0,
    **look: object,
) -> None:
    """An arrow from one place of the data to another, (2,) each."""
    props = {
        "arrowstyle": "-|>",
        "color": colour,
        "linewidth": width,
        "shrinkA": 0,
        "shrinkB": 0,
        **look,
    }
    axes.annotate("", xy=tuple(tip), xytext=tuple(tail), arrowprops=props, zorder=zorder)


def cross(
    axes: Axes, place: Array | tuple[float, float] = (0.0, 0.0), colour: str = QUIET, **look: Any
) -> None:
    """A cross at a place of the data, (2,): a centre, or the origin."""
    axes.plot(*place, "+", **{"color": colour, "markersize": 8.0, "zorder": 5, **look})


def say(axes: Axes, words: str) -> None:
    """Words in the middle of a panel that has nothing to draw."""
    axes.text(0.5, 0.5, words, transform=axes.transAxes, ha="center", va="center", color=QUIET)


def unwrapped_axis(axes: Axes, name: str, least_span_deg: float = 0.0) -> None:
    """Name the y axis of an angle that is drawn unwrapped, in degrees; from two turns on its ticks
    are whole turns.

    To be called last: the window stays what it is then, or grows to `least_span_deg`, so that what
    is flat looks so.
    """
    low, high = axes.get_ylim()
    slack = max(0.0, least_span_deg - (high - low)) / 2
    axes.set_ylim(low - slack, high + slack)
    climbs = high - low >= 720.0
    if climbs:
        whole = MaxNLocator(7, integer=True, steps=[1, 2, 5, 10]).tick_values(
            low / 360.0, high / 360.0
        )
        axes.yaxis.set_major_locator(
            FixedLocator([360.0 * turn for turn in whole if low <= 360.0 * turn <= high])
        )
        axes.yaxis.set_major_formatter(
            FuncFormatter(lambda degrees, _: f"{degrees / 360.0:.0f}".replace("-", "−"))
        )
    axes.set_ylabel(f"{name} ({'turns' if climbs else '°'})")


def stability(orbit: Orbit) -> str:
    """How an orbit is drawn: as "stable", "unstable" or "half-stable" (a saddle-node)."""
    if orbit.kind == "saddle-node":
        return "half-stable"
    return "stable" if orbit.stable else "unstable"


def orbit_marker(kind: str) -> Look:
    """The marker of an orbit: filled where stable, open where unstable, half of each where
    half-stable.
    """
    return {
        "marker": "o",
        "markersize": 7.0,
        "fillstyle": "left" if kind == "half-stable" else "full",
        "markerfacecolor": UNSTABLE if kind == "unstable" else PREDICTED,
        "markerfacecoloralt": UNSTABLE,
        "markeredgecolor": PREDICTED,
        "markeredgewidth": 1.5,
        "linestyle": "none",
        "clip_on": False,
        "zorder": 5,
    }


def small(value: float) -> str:
    """A small number in one digit, for bounds on errors."""
    return f"{value:.1g}".replace("e-0", "e-").replace("-", "−")
