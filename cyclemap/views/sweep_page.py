"""A sweep on one page: the phase diagram over two keys, or the bifurcation diagram over one, with what was swept."""

from collections.abc import Callable
from functools import partial
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from cyclemap.arrays import Array
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.settings import apply_settings
from cyclemap.mechanics import MIT_HITCH, MIT_SHAPE_NAMES
from cyclemap.sweeps.portrait_numbers import Quantity
from cyclemap.sweeps.sweep_curves import SweptCurves, SweptLines, SweptPlane
from cyclemap.sweeps.sweep_results import Sweep
from cyclemap.views.panel_parts import name_tag
from cyclemap.views.style import INK, QUIET, UNSTABLE, new_figure, picture_style
from cyclemap.views.sweep_panels import draw_fixed_points, draw_swept_line, draw_swept_plane, draw_swept_scatter
from cyclemap.views.sweep_sentences import settings_line, sweep_headline, sweep_sentences

PAGE_INCHES = (13.333, 6.6)
LINE_LETTERS = 175
MOST_PANELS = 2
# Points between a panel and its title: a row of a legend.
TITLE_PAD = 24.0
RING_KEYS = ("hitch_x_mm", "hitch_y_mm")
MM = 1000.0
Panel = tuple[str, Callable[[Axes], None]]


def sweep_page(sweep: Sweep, curves: SweptCurves) -> Figure:
    """Draw what `sweep_curves` worked out of a sweep: at most two panels side by side."""
    panels = _panels(curves)[:MOST_PANELS]
    with picture_style():
        figure = new_figure(*PAGE_INCHES)
        grid = GridSpec(1, len(panels), figure, left=0.06, right=0.975, bottom=0.14, top=0.74, wspace=0.2)
        for place, (title, draw) in enumerate(panels):
            axes = figure.add_subplot(grid[0, place])
            draw(axes)
            if isinstance(curves, SweptPlane) and (curves.first.key, curves.second.key) == RING_KEYS:
                _draw_object(axes, sweep)
            axes.set_title(title, pad=TITLE_PAD)
        figure.text(0.015, 0.955, sweep_headline(sweep), fontsize=18, fontweight="bold", va="center")
        told = fill(" ".join(sweep_sentences(sweep)), LINE_LETTERS)
        figure.text(0.015, 0.915, told, fontsize=10, va="top", linespacing=1.35)
        figure.text(0.015, 0.025, settings_line(sweep), fontsize=8, color=QUIET)
    return figure


def _draw_object(axes: Axes, sweep: Sweep) -> None:
    """Round a plane of the ring's places, the object that the ring is set in, and MIT's ring where it is MIT's."""
    settings = sweep.description["plan"]["settings"]
    slider = apply_settings(CollectionLoop.mit(material="isotropic"), settings).slider
    outline = MM * slider.outline.points(120)
    axes.plot(*outline.T, color=INK, linewidth=1.6, clip_on=False, zorder=5)
    if slider.name in MIT_SHAPE_NAMES:
        x, y = MM * MIT_HITCH[0], MM * MIT_HITCH[1]
        axes.plot(x, y, "*", markersize=11, markerfacecolor=UNSTABLE, markeredgecolor=INK, zorder=6)
        name_tag(axes, x, y, "MIT's ring", xytext=(0, -11), textcoords="offset points")
    window = np.array([axes.get_xlim(), axes.get_ylim()]).T
    low, high = np.minimum(window[0], outline.min(axis=0) - 3.0), np.maximum(window[1], outline.max(axis=0) + 3.0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")


def _panels(curves: SweptCurves) -> list[Panel]:
    """Titles and drawers; lines begin with the bifurcation diagram where fixed points are known."""
    if isinstance(curves, SweptLines):
        first: list[Panel] = []
        if curves.points is not None:
            first.append(("Fixed points", lambda axes: draw_fixed_points(axes, curves)))
        return first + _one_each(partial(draw_swept_line, swept=curves), curves.lines)
    if isinstance(curves, SweptPlane):
        return _one_each(partial(draw_swept_plane, swept=curves), curves.planes)
    return _one_each(partial(draw_swept_scatter, swept=curves), curves.values)


def _one_each(draw: Callable[..., None], told: tuple[tuple[Quantity, Array], ...]) -> list[Panel]:
    """A panel for each quantity, drawn by its index."""
    return [(_title(one.meaning), partial(draw, index=index)) for index, (one, _) in enumerate(told)]


def _title(meaning: str) -> str:
    """A quantity's meaning as a title, short of its remarks.

    >>> _title("turn of a cycle, mean over start directions")
    'Turn of a cycle'
    """
    words = meaning.partition(",")[0]
    return words[:1].upper() + words[1:]
