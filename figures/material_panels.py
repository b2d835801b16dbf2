"""What the figures of the four materials share: a grid of panels, the look of simulated data, a
line at the foot.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from cyclemap.views import style
from cyclemap.views.style import QUIET

One = TypeVar("One")

PANEL_INCHES = (5.2, 3.7)
SIMULATED_FILL = "#c4c4c4"


@style.picture_style()
def draw_materials(
    names: Sequence[str], panels: Sequence[One], draw_one: Callable[[Axes, One], None]
) -> Figure:
    """A figure with a panel for each of a few materials, titled with the names; room above each for
    a legend.
    """
    columns = 2 if len(names) <= 4 else 3
    rows = -(-len(names) // columns)
    width, height = PANEL_INCHES
    size, layout = (width * columns, height * rows), style.rows_of(*(columns,) * rows)
    figure, places = style.page(layout, size=size, keys=2)
    for axes, name, one in zip(places, names, panels, strict=False):
        draw_one(axes, one)
        style.entitle(axes, name)
    for axes in places[len(names) :]:
        axes.remove()
    return figure


def as_simulated(axes: Axes) -> None:
    """Show what a view drew as measured for what it is here: simulated, in grey,
    in the legend too."""
    for artist in axes.get_children():
        if artist.get_label() != "measured":
            continue
        artist.set_label("simulated")
        if isinstance(artist, Line2D):
            artist.set(color=QUIET, markeredgecolor=QUIET)
        elif isinstance(artist, Patch):
            artist.set(facecolor=SIMULATED_FILL, edgecolor=QUIET)
