"""One look for every picture: colours that differ in lightness too, so that a grey print still reads."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from cyclemap.errors import InvalidInput
from cyclemap.plain_text import printable, typeset

INK = "#222222"
QUIET = "#666666"
PREDICTED = "#0b3d6b"
PREDICTED_FILL = "#d5e3ef"
MEASURED = "#e69f00"
MEASURED_EDGE = "#8a5a00"
UNSTABLE = "#ffffff"
FORCE = "#c1440e"

# How each format is saved. Level 3 packs a drawing's PNG about as small as the usual 6 does, in half the time.
_SAVED: dict[str, dict[str, Any]] = {
    "png": {"metadata": {}, "pil_kwargs": {"compress_level": 3}},
    "pdf": {"metadata": {"CreationDate": None}},
    "svg": {"metadata": {"Date": None}},
}
PICTURE_FORMATS = tuple(_SAVED)

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


@contextmanager
def picture_style() -> Iterator[None]:
    """The look of cyclemap's pictures, for as long as the block lasts."""
    with matplotlib.rc_context(_STYLE):
        yield


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of `width` by `height` inches."""
    figure = Figure(figsize=(width, height), facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def render(figure: Figure, picture_format: str = "png", dpi: int = 144) -> bytes:
    """The bytes of `figure` as "png", "pdf" or "svg"; InvalidInput for any other format."""
    if picture_format not in PICTURE_FORMATS:
        raise InvalidInput(f"picture format {picture_format!r} is unknown; use one of {', '.join(PICTURE_FORMATS)}")
    for text in figure.findobj(Text):
        # A dollar sign in a name begins no formula; one that is escaped already stays so.
        text.set_text(re.sub(r"(?<!\\)\$", r"\$", typeset(printable(text.get_text()))))
    buffer = BytesIO()
    with picture_style():
        figure.savefig(buffer, format=picture_format, dpi=dpi, **_SAVED[picture_format])
    return buffer.getvalue()


def degree_axis(axes: Axes, label: str) -> None:
    """Make the x axis of `axes` one circle in degrees."""
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(range(0, 361, 45))
    axes.set_xlabel(label)
