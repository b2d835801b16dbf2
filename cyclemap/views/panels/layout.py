"""Pages and pictures as layouts of panels: titles and sentences above, legends that cover nothing,
and the bytes of them.
"""

import math
import re
import warnings
from collections.abc import Callable, Iterable, Iterator
from io import BytesIO
from string import ascii_letters
from textwrap import wrap
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.text import Text
from matplotlib.textpath import text_to_path

from cyclemap.errors import InvalidInput
from cyclemap.plain_text import printable, typeset
from cyclemap.views.panels.style import QUIET, Look, picture_style

# A panel's title, and what draws it.
Panel = tuple[str, Callable[[Axes], None]]
# Where on a page there is room: from here up to there, as shares of its height.
Room = tuple[float, float]
# How each format is saved. Level 3 packs a drawing's PNG about as small as the usual 6 does, in
# half the time.
_SAVED: dict[str, Look] = {
    "png": {"metadata": {}, "pil_kwargs": {"compress_level": 3}},
    "pdf": {"metadata": {"CreationDate": None}},
    "svg": {"metadata": {"Date": None}},
}
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


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of `width` by `height` inches."""
    figure = Figure(figsize=(width, height), facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def write_page(figure: Figure, title: str, words: Iterable[str] = (), foot: str = "") -> Room:
    """Write the title, the sentences below it (those that are empty left out), and what is small at
    the foot; return what is left between them.
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
    lines = [line for block in foot.split("\n") for line in _wrapped(block, _KEYED, wide)]
    look: Look = {"va": "bottom", "fontsize": 8, "color": QUIET, "linespacing": 1.35}
    _write(figure, height - 0.1, lines, **look)
    return (0.16 * len(lines) + 0.12 * bool(lines)) / height, 1.0 - y / height


def _write(figure: Figure, y: float, lines: list[str], **look: Any) -> None:
    """Write lines, if any, at the left edge, from so many inches below the top."""
    width, height = figure.get_size_inches().tolist()
    if lines:
        figure.text(0.2 / width, 1.0 - y / height, "\n".join(lines), **{"va": "top", **look})


def _wrapped(text: str, font: FontProperties, width: float) -> list[str]:
    """The lines of a text that fit a width in inches, by how wide its letters are on average."""
    lines = _text_width(text, font) / width
    return wrap(text, int(_SAFE * len(text) / lines)) if lines > 0.0 else []


def page(
    layout: str,
    title: str = "",
    words: Iterable[str] = (),
    foot: str = "",
    size: tuple[float, float] = (13.333, 7.5),
    **options: Any,
) -> tuple[Figure, list[Axes]]:
    """A figure of a size in inches with its words, and its panels in what these leave.

    title, words, foot : of `write_page`.
    layout, options : of `panels_in`.
    """
    figure = new_figure(*size)
    room = write_page(figure, title, words, foot)
    return figure, panels_in(figure, layout, room, **options)


def panels_in(
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
    """Draw panels in the places of a page, as many as there are of both, each with its title and
    its legend.
    """
    for axes, (title, draw) in zip(places, drawn, strict=False):
        draw(axes)
        entitle(axes, title)


def picture(layout: str, drawn: Iterable[Panel], **options: Any) -> Figure:
    """A page of panels in cyclemap's look.

    layout, options : of `page`.
    """
    with picture_style():
        figure, places = page(layout, **options)
        draw_panels(places, drawn)
    return figure


def rows_of(*counts: int) -> str:
    """The layout of rows with so many panels each, all as wide as the page.

    >>> rows_of(2, 3)
    'aaabbb;ccddee'
    """
    cells, letters = math.lcm(*counts), iter(ascii_letters)
    rows = [[next(letters) * (cells // count) for _ in range(count)] for count in counts]
    return ";".join("".join(row) for row in rows)


def grid_of(count: int, columns: int) -> str:
    """The layout of so many panels in rows of as many columns, the last places left empty.

    >>> grid_of(5, 3)
    'abc;de.'
    """
    rows = -(-count // columns)
    places = ascii_letters[:count].ljust(rows * columns, ".")
    return ";".join(places[row * columns : (row + 1) * columns] for row in range(rows))


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
    children = (
        [artist.label, artist.offsetText] if isinstance(artist, Axis) else artist.get_children()
    )
    for child in children:
        yield from _texts(child)


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
