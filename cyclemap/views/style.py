"""One look for every picture: colours that also differ in lightness, legends that cover nothing,
markers, name tags.
"""

import math
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from io import BytesIO
from textwrap import fill
from typing import Any

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, MultipleLocator

from cyclemap.errors import InvalidInput
from cyclemap.maps import Orbit
from cyclemap.plain_text import printable, typeset

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
# How each format is saved. Level 3 packs a drawing's PNG about as small as the usual 6 does, in
# half the time.
_SAVED: dict[str, Look] = {
    "png": {"metadata": {}, "pil_kwargs": {"compress_level": 3}},
    "pdf": {"metadata": {"CreationDate": None}},
    "svg": {"metadata": {"Date": None}},
}
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
# Measured places, of which there may be many.
DOTS: Look = {"color": MEASURED, "markersize": 3.0, "alpha": 0.45, "linestyle": "none"}
DOTS |= {"markeredgecolor": MEASURED_EDGE, "markeredgewidth": 0.3}
# Points that a legend's key takes, and a letter of it, of a title, and a row of the legend.
_KEY, _LETTER, _TITLE_LETTER, _ROW = 31.0, 4.9, 6.8, 12.5
THETA, THETA0 = "θ (°)", "θ0, orientation before the push (°)"


@contextmanager
def picture_style() -> Iterator[None]:
    """The look of cyclemap's pictures, for as long as the block lasts."""
    with matplotlib.rc_context(_STYLE):
        yield


def new_figure(width: float = 13.333, height: float = 7.5) -> Figure:
    """An empty figure of `width` by `height` inches, a landscape page unless told."""
    figure = Figure(figsize=(width, height), facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def write_page(
    figure: Figure,
    title: str,
    words: Iterable[str],
    foot: str = "",
    top: float = 0.928,
    letters: int = 175,
    size: float = 18.0,
) -> None:
    """Write the title, the sentences below it (those that are empty left out), and what is small at
    the foot.
    """
    figure.text(0.015, 0.955, title, fontsize=size, fontweight="bold", va="center")
    told = fill(" ".join(filter(None, words)), letters)
    figure.text(0.015, top, told, fontsize=10, va="top", linespacing=1.35)
    if foot:
        figure.text(0.015, 0.02, foot, fontsize=8, color=QUIET)


def write_tall_page(
    figure: Figure, title: str, words: Iterable[str], foot: str, size: float = 18.0
) -> float:
    """The same on a page of 16 by 9.6 inches; returns where the sentences end, as a share of its
    height.
    """
    figure.text(0.012, 0.968, title, fontsize=size, fontweight="bold", va="center")
    told = fill(" ".join(words), 205)
    figure.text(0.012, 0.947, told, fontsize=9.5, va="top", linespacing=1.3)
    figure.text(0.012, 0.012, foot, fontsize=8, color=QUIET)
    return 0.947 - 0.0188 * (told.count("\n") + 1)


def render(figure: Figure, picture_format: str = "png", dpi: int = 144) -> bytes:
    """The bytes of `figure` as "png", "pdf" or "svg"; InvalidInput for any other format."""
    if picture_format not in _SAVED:
        raise InvalidInput(
            f"picture format {picture_format!r} is unknown; use one of {', '.join(_SAVED)}"
        )
    for text in _texts(figure):
        # A dollar sign in a name begins no formula; one that is escaped already stays so.
        text.set_text(re.sub(r"(?<!\\)\$", r"\$", typeset(printable(text.get_text()))))
    buffer = BytesIO()
    with picture_style():
        figure.savefig(buffer, format=picture_format, dpi=dpi, **_SAVED[picture_format])
    return buffer.getvalue()


def _texts(artist: Artist) -> Iterator[Text]:
    """The texts in `artist` but for labels of ticks: drawing makes those, of the ticks that are
    seen.
    """
    if isinstance(artist, Text):
        yield artist
    parts = [artist.label, artist.offsetText] if isinstance(artist, Axis) else artist.get_children()
    for part in parts:
        yield from _texts(part)


def degree_axis(axes: Axes, label: str = THETA0) -> None:
    """Make the x axis of `axes` one circle in degrees."""
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(range(0, 361, 45))
    axes.set_xlabel(label)


def legend_above(axes: Axes) -> int:
    """A legend above the panel, at its right end, where it covers no data: each label once, in as
    many columns as the panel has room for. Returns its rows.
    """
    named: Look = {}
    for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
        named.setdefault(label, handle)
    if not named:
        return 0
    columns = _columns(list(named), _width(axes))
    look: Look = {"borderaxespad": 0.2, "handlelength": 1.8, "columnspacing": 1.2}
    look |= {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0)}
    axes.legend(named.values(), named.keys(), ncols=columns, **look)
    return math.ceil(len(named) / columns)


def entitle(axes: Axes, title: str) -> None:
    """The legend of `legend_above`, and the title beside it, or above it where both are long."""
    rows = legend_above(axes)
    legend = axes.get_legend()
    labels = [text.get_text() for text in legend.get_texts()] if legend else []
    beside = rows == 1 and sum(map(_key_width, labels)) + _TITLE_LETTER * len(title) <= _width(axes)
    axes.set_title(title, pad=8.0 + _ROW * (0 if beside else rows))


def _columns(labels: list[str], width: float) -> int:
    """How many columns of a legend a width (points) has room for, where they are filled evenly."""
    widths = np.array([_key_width(label) for label in labels])
    for columns in range(len(labels), 1, -1):
        if sum(part.max() for part in np.array_split(widths, columns)) <= width:
            return columns
    return 1


def _key_width(label: str) -> float:
    return _KEY + _LETTER * len(label)


def _width(axes: Axes) -> float:
    """The width of a panel, points."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    return 72.0 * float(axes.get_position().width * figure.get_size_inches()[0])


def name_tag(axes: Axes, x: float, y: float, name: str, **options: Any) -> None:
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
    tail: Any,
    tip: Any,
    colour: str,
    width: float = 1.8,
    zorder: float = 5.0,
    **look: Any,
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


def say(axes: Axes, words: str) -> None:
    """Words in the middle of a panel that has nothing to draw."""
    axes.text(0.5, 0.5, words, transform=axes.transAxes, ha="center", va="center", color=QUIET)


def whole_turn_ticks(axes: Axes) -> None:
    """Make the y axis of `axes` one circle in degrees."""
    axes.set_ylim(0.0, 360.0)
    axes.yaxis.set_major_locator(MultipleLocator(45.0))


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
