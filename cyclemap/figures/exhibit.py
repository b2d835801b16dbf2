"""What a figure and a table of the gallery are: how each is computed, drawn or set in rows, and captioned."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from cyclemap.figures.measured_folder import MeasuredFolder

BEYOND = "not in the paper"


@dataclass(frozen=True)
class PaperFigure:
    """One figure.

    name : as the command line says it. source : the paper's figure, or `BEYOND`. title : a few words.
    compute : measured data -> result, the only slow part. draw : result -> figure. caption : result -> sentences that
    hold for this result, with its numbers.
    """

    name: str
    source: str
    title: str
    compute: Callable[[MeasuredFolder], Any]
    draw: Callable[[Any], Figure]
    caption: Callable[[Any], str]


@dataclass(frozen=True)
class PaperTable:
    """One table: as a figure, but set in rows of words under a header."""

    name: str
    source: str
    title: str
    compute: Callable[[MeasuredFolder], Any]
    header: tuple[str, ...]
    rows: Callable[[Any], list[tuple[str, ...]]]
    caption: Callable[[Any], str]
