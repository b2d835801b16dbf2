"""Small pictures in a notebook: lines and marks as inline SVG, in the colours of the page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array

BLUE, GREY = "#2f6fb3", "#999"
DISC = "disc"
CIRCLE = "circle"
_MARGIN = 8
_DECIMALS = 1


@dataclass(frozen=True, eq=False)
class Stroke:
    """A line through points (n, 2), or a mark at each of them
    (DISC or CIRCLE, of `width` pixels)."""

    points: ArrayLike
    colour: str = "currentColor"
    mark: str = ""
    width: float = 1.5


def inline_svg(
    strokes: Sequence[Stroke], caption: str, height: int = 160, equal: bool = False
) -> str:
    """Return an HTML figure of strokes, y upwards, scaled to fill 320 pixels by `height`; `equal`:
    both axes alike.

    >>> inline_svg([Stroke([[0, 0], [1, 1]])], "a line").count("polyline")
    1
    """
    arrays = [np.asarray(stroke.points, dtype=float) for stroke in strokes]
    low, high = (end(np.concatenate(arrays), axis=0) for end in (np.min, np.max))
    room = np.array([320, height]) - 2 * _MARGIN
    scale = room / np.maximum(high - low, 1e-12)
    scale = np.full(2, scale.min()) if equal else scale
    shapes = []
    for stroke, array in zip(strokes, arrays, strict=True):
        x, y = (
            (np.array([320, height]) / 2 + (array - (low + high) / 2) * scale * (1, -1))
            .round(_DECIMALS)
            .T.tolist()
        )
        if stroke.mark:
            fill = stroke.colour if stroke.mark == DISC else "none"
            look = f'r="{stroke.width}" fill="{fill}" stroke="{stroke.colour}"'
            shapes += [f'<circle cx="{a}" cy="{b}" {look}/>' for a, b in zip(x, y, strict=True)]
        else:
            places = " ".join(f"{a},{b}" for a, b in zip(x, y, strict=True))
            look = f'fill="none" stroke="{stroke.colour}" stroke-width="{stroke.width}"'
            shapes.append(f'<polyline points="{places}" {look}/>')
    picture = (
        f'<svg width="320" height="{height}" viewBox="0 0 320 {height}" '
        f'role="img">{"".join(shapes)}</svg>'
    )
    return f"<figure>{picture}<figcaption>{escape(caption)}</figcaption></figure>"


def map_strokes(theta: Array, turn: Array, breaks: Array) -> list[Stroke]:
    """The turn (n,) of a map over theta (n,) in [0, 2π], both rad, cut at its breaks, above the
    line of no turn.
    """
    cuts = [0, *np.searchsorted(theta, breaks).tolist(), len(theta)]
    pieces = [np.column_stack([theta[a:b], turn[a:b]]) for a, b in pairwise(cuts) if b > a]
    return [
        Stroke([[0.0, 0.0], [TWO_PI, 0.0]], GREY, width=1.0),
        *(Stroke(piece, BLUE) for piece in pieces),
    ]
