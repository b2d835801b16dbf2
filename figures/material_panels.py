"""What the figures of the four materials share: a grid of panels, the look of simulated data, a
line at the foot.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from cyclemap.views.style import QUIET, legend_above, new_figure, picture_style

One = TypeVar("One", bound=Any)

PANEL_INCHES = (5.2, 3.6)
SIMULATED_FILL = "#c4c4c4"
_SIDE, _HEAD, _FOOT = 0.75, 0.75, 0.85


def draw_materials(
    names: Sequence[str], panels: Sequence[One], draw_one: Callable[[Axes, One], None]
) -> Figure:
    """A figure with a panel for each of a few materials, titled with the names; room above each for
    a legend.
    """
    columns = 2 if len(names) <= 4 else 3
    rows = -(-len(names) // columns)
    width, height = PANEL_INCHES
    with picture_style():
        figure = new_figure(width * columns, height * rows + 0.1)
        grid = figure.add_gridspec(
            rows,
            columns,
            left=_SIDE / (width * columns),
            right=1.0 - 0.2 / (width * columns),
            bottom=_FOOT / (height * rows),
            top=1.0 - _HEAD / (height * rows),
            hspace=0.5,
            wspace=0.22,
        )
        for place, (name, one) in enumerate(zip(names, panels, strict=True)):
            axes = figure.add_subplot(grid[place // columns, place % columns])
            axes.set_title(name)
            draw_one(axes, one)
    return figure


def as_simulated(axes: Axes) -> None:
    """Show what a view drew as measured for what it is here: simulated, in grey,
    in the legend too."""
    for artist in axes.get_children():
        if artist.get_label() != "measured":
            continue
        artist.set_label("simulated")
        if isinstance(artist, Line2D):
            artist.set_color(QUIET)
        elif isinstance(artist, Patch):
            artist.set(facecolor=SIMULATED_FILL, edgecolor=QUIET)
    legend_above(axes)
