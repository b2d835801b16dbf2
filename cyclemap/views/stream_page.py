"""A stream of poses and how it was cut into pushes: for whoever doubts it."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import Whole
from cyclemap.evidence.pushes.pose_streams import Segments
from cyclemap.views import style
from cyclemap.views.style import FORCE, INK, PREDICTED_FILL

# Samples drawn, and pushes shown: the first ones tell what was taken for what.
_MOST_SAMPLES, _MOST_PUSHES = 4000, 12


@style.picture_style()
def stream_page(seen: Segments) -> Figure:
    """Draw place and orientation over time, pushes shaded, rests marked below, and what is unclear
    hatched.
    """
    foot = "shaded: pushes; bars: rests; hatched: neither a push nor a drag"
    figure, (above, below) = style.page("a;b", seen.words, foot=foot, sharex=True)
    pushes, unclear = seen.pushes[:_MOST_PUSHES], seen.unclear[:_MOST_PUSHES]
    ends = [int(seen.rests[end][1]) for _, end in (*pushes, *unclear)]
    last = max(ends, default=min(_MOST_SAMPLES, seen.t.size) - 1)
    every = slice(0, last + 1, max(1, (last + 1) // _MOST_SAMPLES))
    for name, place, look in (("x (mm)", seen.x, style.LINE), ("y (mm)", seen.y, style.FOURTH)):
        above.plot(seen.t[every], 1e3 * (place[every] - place[0]), label=name, **look)
    below.plot(seen.t[every], np.degrees(seen.theta[every]), **style.LINE)
    above.set_ylabel("place from the first (mm)")
    below.set(ylabel="orientation (°)", xlabel="time (s)")
    below.set_xlim(max(0.0, float(seen.t[0])), float(seen.t[last]))
    for axes in (above, below):
        _shade(axes, seen, pushes, color=PREDICTED_FILL, zorder=0)
        _shade(axes, seen, unclear, facecolor="none", edgecolor=FORCE, hatch="//")
    floor = below.get_ylim()[0]
    for first, end in seen.rests:
        if seen.t[first] <= seen.t[last]:
            below.plot(
                seen.t[[first, end]], [floor, floor], color=INK, linewidth=4, solid_capstyle="butt"
            )
    style.legend_above(above)
    return figure


def _shade(axes: Axes, seen: Segments, spans: Whole, **look: Any) -> None:
    """Shade the times between the rests of each pair."""
    for first, end in spans:
        axes.axvspan(seen.t[seen.rests[first][1]], seen.t[seen.rests[end][0]], **look)
