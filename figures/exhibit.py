"""What a figure, a table and an animation of the gallery are: how each is computed, drawn or set, and captioned."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from .catalogue import BEYOND as BEYOND
from .measured_folder import MeasuredFolder


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


@dataclass(frozen=True, eq=False)
class Frame:
    """One picture of an animation. pixels : (height, width, 3), 0 to 255. seconds : how long it is shown."""

    pixels: NDArray[np.uint8]
    seconds: float


@dataclass(frozen=True)
class PaperAnimation:
    """One animation: as a figure, but drawn as frames, all of one size."""

    name: str
    source: str
    title: str
    compute: Callable[[MeasuredFolder], Any]
    frames: Callable[[Any], Iterator[Frame]]
    caption: Callable[[Any], str]


Exhibit = PaperFigure | PaperTable | PaperAnimation
