"""What the panels of a map share: legends that cover nothing, orbit markers, name tags, probability per degree."""

from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, MultipleLocator

from cyclemap.maps import Orbit
from cyclemap.views.style import INK, PREDICTED, QUIET, UNSTABLE

THETA = "θ (°)"


def legend_above(axes: Axes, columns: int = 3, handles: list[Any] | None = None) -> None:
    """A legend above the panel, at its right end, where it covers no data; none where nothing has a label."""
    shown = axes.get_legend_handles_labels()[0] if handles is None else handles
    if shown:
        axes.legend(
            handles=shown,
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            ncols=min(columns, len(shown)),
            borderaxespad=0.2,
            handlelength=1.8,
            columnspacing=1.2,
        )


def name_tag(axes: Axes, x: float, y: float, name: str, **options: Any) -> None:
    """A short name at a place of the data, on a white ground that lets lines through a little."""
    ground = {"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}
    given: dict[str, Any] = {"fontsize": 7.5, "color": INK, "ha": "center", "va": "center", "zorder": 8, **options}
    axes.annotate(name, (x, y), annotation_clip=True, bbox=ground, **given)


def name_beside_path(axes: Axes, start: float, end: float, level: float, name: str, rises: bool) -> None:
    """A name above a flat stretch, on the side where a rising (or a falling) curve leaves room for it."""
    place, side, offset = (end, "right", (-3, 4)) if rises else (start, "left", (3, 4))
    name_tag(axes, place, level, name, ha=side, va="bottom", xytext=offset, textcoords="offset points")


def say(axes: Axes, words: str) -> None:
    """Words in the middle of a panel that has nothing to draw."""
    axes.text(0.5, 0.5, words, transform=axes.transAxes, ha="center", va="center", color=QUIET)


def whole_turn_ticks(axes: Axes) -> None:
    """Make the y axis of `axes` one circle in degrees."""
    axes.set_ylim(0.0, 360.0)
    axes.yaxis.set_major_locator(MultipleLocator(45.0))


def unwrapped_axis(axes: Axes, name: str, least_span_deg: float = 0.0) -> None:
    """Name the y axis of an angle that is drawn unwrapped, in degrees; from two turns on its ticks are whole turns.

    To be called last: the window stays what it is then, or grows to `least_span_deg`, so that what is flat looks so.
    """
    low, high = axes.get_ylim()
    slack = max(0.0, least_span_deg - (high - low)) / 2
    axes.set_ylim(low - slack, high + slack)
    climbs = high - low >= 720.0
    if climbs:
        whole = MaxNLocator(7, integer=True, steps=[1, 2, 5, 10]).tick_values(low / 360.0, high / 360.0)
        axes.yaxis.set_major_locator(FixedLocator([360.0 * turn for turn in whole if low <= 360.0 * turn <= high]))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda degrees, _: f"{degrees / 360.0:.0f}".replace("-", "−")))
    axes.set_ylabel(f"{name} ({'turns' if climbs else '°'})")


def stability(orbit: Orbit) -> str:
    """How an orbit is drawn: as "stable", "unstable" or "half-stable" (a saddle-node)."""
    if orbit.kind == "saddle-node":
        return "half-stable"
    return "stable" if orbit.stable else "unstable"


def orbit_marker(kind: str) -> dict[str, Any]:
    """The marker of an orbit: filled where stable, open where unstable, half of each where half-stable."""
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


def orbit_keys(kinds: set[str]) -> list[Line2D]:
    """Legend entries for the kinds of orbit that are drawn."""
    order = ("stable", "half-stable", "unstable")
    return [Line2D([], [], label=kind, **orbit_marker(kind)) for kind in order if kind in kinds]


def small(value: float) -> str:
    """A small number in one digit, for bounds on errors."""
    return f"{value:.1g}".replace("e-0", "e-").replace("-", "−")
