"""One look for every picture: colours that also differ in lightness, legends that cover nothing,
markers, name tags.
"""

import math
import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from string import ascii_letters
from textwrap import wrap
from typing import Any

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.text import Text
from matplotlib.textpath import text_to_path
from matplotlib.ticker import (
    FixedLocator,
    FuncFormatter,
    MaxNLocator,
    MultipleLocator,
    NullFormatter,
)

from cyclemap.arrays import Array
from cyclemap.errors import InvalidInput
from cyclemap.maps import Orbit
from cyclemap.plain_text import printable, typeset

# Options of Matplotlib.
Look = dict[str, Any]
# A panel's title, and what draws it.
Panel = tuple[str, Callable[[Axes], None]]
# Where on a page there is room: from here up to there, as shares of its height.
Room = tuple[float, float]
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
# Inches at the left of a panel, at its right, below it for labels, above it for the title, and for
# each row of a legend.
_LEFT, _RIGHT, _BELOW, _ABOVE, _KEYS = 0.8, 0.2, 0.5, 0.33, 0.18
# Sizes of titles of pages, points.
_TITLE, _SMALL_TITLE = 18.0, 13.0
# Fonts of sentences, of legends and of titles; inches that a legend's key takes, and points that
# a row of it does.
_SAID = FontProperties(family="DejaVu Sans", size=10.0)
_KEYED = FontProperties(family="DejaVu Sans", size=8.0)
_TITLED = FontProperties(family="DejaVu Sans", size=10.0, weight="bold")
_KEY, _ROW = 0.4, 12.5
# Letters are drawn in whole pixels, wider than measured: so much of a width is filled.
_SAFE = 0.92
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
    figure: Figure, title: str, words: Iterable[str] = (), foot: str = "", key: str = ""
) -> Room:
    """Write the title, the sentences below it (those that are empty left out), and what is small at
    the foot, and at its right the key of a drawing; return what is left between them.
    """
    width, height = figure.get_size_inches().tolist()
    wide, y = width - 0.4, 0.1
    if title:
        size = 10.0 * _SAFE * wide / _text_width(title, _TITLED)
        size = min(max(size, _SMALL_TITLE), _TITLE)
        # A hair wider, so that a title that just fits is not wrapped by rounding.
        lines = _wrapped(title, _TITLED, 10.0 * wide / size + 0.05)
        _write(figure, y + 0.115, lines, fontsize=size, fontweight="bold", linespacing=1.2)
        y += 0.115 + len(lines) * size / _TITLE * 0.325
    lines = _wrapped(" ".join(filter(None, words)), _SAID, wide)
    _write(figure, y, lines, fontsize=10, linespacing=1.35)
    y += len(lines) * 0.197
    beside = max(_text_width(line, _KEYED) for line in key.split("\n"))
    at_foot: Look = {"va": "bottom", "fontsize": 8, "color": QUIET, "linespacing": 1.35}
    _write(figure, height - 0.1, [key] if key else [], x=width - 0.2, ha="right", **at_foot)
    paragraphs = [_wrapped(part, _KEYED, wide - beside - 0.2) for part in foot.split("\n")]
    lines = [line for paragraph in paragraphs for line in paragraph]
    _write(figure, height - 0.1, lines, **at_foot)
    return (0.16 * len(lines) + 0.12 * bool(lines)) / height, 1.0 - y / height


def _write(figure: Figure, y: float, lines: list[str], x: float = 0.2, **look: Any) -> None:
    """Write lines, if any, from a place in inches from the left and from the top."""
    width, height = figure.get_size_inches().tolist()
    if lines:
        figure.text(x / width, 1.0 - y / height, "\n".join(lines), **{"va": "top", **look})


def _wrapped(text: str, font: FontProperties, width: float) -> list[str]:
    """The lines of a text that fit a width in inches, by how wide its letters are on average."""
    lines = _text_width(text, font) / width
    return wrap(text, int(_SAFE * len(text) / lines)) if lines > 0.0 else []


def page(
    layout: str,
    title: str = "",
    words: Iterable[str] = (),
    foot: str = "",
    key: str = "",
    size: tuple[float, float] = (13.333, 7.5),
    **options: Any,
) -> tuple[Figure, list[Axes]]:
    """A figure of a size in inches with its words, and its panels in what these leave.

    title, words, foot, key : of `write_page`.
    layout, options : of `panels`.
    """
    figure = new_figure(*size)
    room = write_page(figure, title, words, foot, key)
    return figure, panels(figure, layout, room, **options)


def panels(
    figure: Figure,
    layout: str,
    room: Room,
    keys: int = 1,
    polar: str = "",
    **options: Any,
) -> list[Axes]:
    """The panels of a layout, "ab;cc" for two above a wide one, in the order of their letters.

    room : of the page's height, as `write_page` leaves it.
    keys : rows of the longest legend.
    polar : the panels that are round.
    options : of Matplotlib's `subplot_mosaic`.
    """
    width, height = figure.get_size_inches().tolist()
    rows, above = layout.split(";"), _ABOVE + _KEYS * keys
    ends = {
        "left": _LEFT / width,
        "right": 1.0 - _RIGHT / width,
        "bottom": room[0] + _BELOW / height,
        "top": room[1] - above / height,
    }
    wide, tall = (ends["right"] - ends["left"]) * width, (ends["top"] - ends["bottom"]) * height
    ends["wspace"] = _share(_LEFT + _RIGHT, wide, len(rows[0]))
    ends["hspace"] = _share(_BELOW + above, tall, len(rows))
    made = figure.subplot_mosaic(
        layout,
        gridspec_kw=ends,
        per_subplot_kw={name: {"projection": "polar"} for name in polar},
        **options,
    )
    return [made[name] for name in sorted(made)]


def draw_panels(places: Iterable[Axes], drawn: Iterable[Panel]) -> None:
    """Draw panels in the places of a page, as many as there are of both, each with its title."""
    for axes, (title, draw) in zip(places, drawn, strict=False):
        draw(axes)
        entitle(axes, title)


def rows_of(*counts: int) -> str:
    """The layout of rows with so many panels each, all as wide as the page.

    >>> rows_of(2, 3)
    'aaabbb;ccddee'
    """
    cells, letters = math.lcm(*counts), iter(ascii_letters)
    rows = [[next(letters) * (cells // count) for _ in range(count)] for count in counts]
    return ";".join("".join(row) for row in rows)


def _share(gap: float, whole: float, count: int) -> float:
    """A gap between `count` panels that fill `whole`, as a share of their mean size."""
    return gap * count / (whole - gap * (count - 1))


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
    look: Look = {"borderaxespad": 0.2, "handlelength": 1.8, "columnspacing": 1.0}
    look |= {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0)}
    axes.legend(named.values(), named.keys(), ncols=columns, **look)
    return math.ceil(len(named) / columns)


def entitle(axes: Axes, title: str) -> None:
    """The legend of `legend_above`, and the title beside it, or above it where both are long."""
    rows = legend_above(axes)
    legend = axes.get_legend()
    keys = [_key_width(text.get_text()) for text in legend.get_texts()] if legend else []
    beside = rows == 1 and sum(keys) + _text_width(title, _TITLED) + _KEY <= _width(axes)
    axes.set_title(title, pad=8.0 + _ROW * (0 if beside else rows))


def _columns(labels: list[str], width: float) -> int:
    """How many columns of a legend a width (inches) has room for, where they are filled evenly."""
    widths = np.array([_key_width(label) for label in labels])
    for columns in range(len(labels), 1, -1):
        if sum(column.max() for column in np.array_split(widths, columns)) <= width:
            return columns
    return 1


def _key_width(label: str) -> float:
    return _KEY + _text_width(label, _KEYED)


def _text_width(text: str, font: FontProperties) -> float:
    """The width of a line as it is rendered, inches."""
    shown = typeset(printable(text))
    with warnings.catch_warnings():
        # Of letters that the font lacks rendering tells.
        warnings.simplefilter("ignore", UserWarning)
        width, _, _ = text_to_path.get_text_width_height_descent(shown, font, ismath=False)
    return float(width) / 72.0


def _width(axes: Axes) -> float:
    """The width of a panel, inches."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    return float(axes.get_position().width * figure.get_size_inches()[0])


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
