"""Frames of pixels as an animated GIF, and a matplotlib figure as such pixels."""

from collections.abc import Iterable
from io import BytesIO

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from cyclemap.errors import InvalidInput

from .exhibit import Frame

# Colours of the one palette that all frames share: a palette of its own a frame would flicker and take space.
COLOURS = 64
_ALL_BUT_WHITE = 14.0
# Frames from which the palette is taken.
_SAMPLED = 8
# A GIF counts hundredths of a second, and viewers do not show less than two of them.
_TICK, _SHORTEST = 0.01, 0.02


def animated_gif(frames: Iterable[Frame]) -> bytes:
    """Return the frames as a GIF that repeats for ever; InvalidInput without frames or where their sizes differ.

    Durations are rounded to 0.01 s, and are 0.02 s at least.
    """
    given = list(frames)
    if not given:
        raise InvalidInput("an animation needs at least one frame")
    shapes = {frame.pixels.shape for frame in given}
    if len(shapes) > 1:
        raise InvalidInput(f"frames have sizes {sorted(shapes)}: give frames of one size")
    pictures = _with_one_palette([frame.pixels for frame in given])
    buffer = BytesIO()
    pictures[0].save(
        buffer,
        format="GIF",
        save_all=True,
        append_images=pictures[1:],
        duration=[_milliseconds(frame.seconds) for frame in given],
        loop=0,
        optimize=False,
        disposal=1,
    )
    return buffer.getvalue()


def figure_pixels(figure: Figure, dpi: float) -> NDArray[np.uint8]:
    """Return the figure as (height, width, 3) pixels."""
    figure.set_dpi(dpi)
    canvas = figure.canvas if isinstance(figure.canvas, FigureCanvasAgg) else FigureCanvasAgg(figure)
    canvas.draw()  # type: ignore[no-untyped-call]
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()  # type: ignore[no-untyped-call]


def _with_one_palette(pixels: list[NDArray[np.uint8]]) -> list[Image.Image]:
    """The frames in the colours that are commonest in a sample of them."""
    sample = np.concatenate(pixels[:: max(1, len(pixels) // _SAMPLED)])
    palette = Image.fromarray(sample).quantize(COLOURS, method=Image.Quantize.MEDIANCUT)
    colours = np.array(palette.getpalette(), dtype=float).reshape(-1, 3)
    # The commonest colours are means of a few; what is all but white must stay white.
    colours[np.abs(colours - 255.0).sum(axis=1) < _ALL_BUT_WHITE] = 255.0
    palette.putpalette(colours.astype(np.uint8).ravel().tolist())
    return [Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE) for frame in pixels]


def _milliseconds(seconds: float) -> int:
    return round(1000 * max(_TICK * round(seconds / _TICK), _SHORTEST))
