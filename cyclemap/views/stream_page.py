"""A stream of poses and how it was cut into pushes: for whoever doubts it."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from cyclemap.evidence.pushes.pose_streams import Segments
from cyclemap.views.style import FORCE, INK, PREDICTED_FILL, QUIET, new_figure, picture_style

# Samples drawn, and pushes shown: the first ones tell what was taken for what.
_MOST_SAMPLES, _MOST_PUSHES = 4000, 12


@picture_style()
def stream_page(seen: Segments) -> Figure:
    """Draw place and orientation over time, pushes shaded, rests marked below, and what is unclear
    hatched.
    """
    figure = new_figure(13.333, 6.0)
    above, below = figure.subplots(2, 1, sharex=True)
    figure.subplots_adjust(left=0.07, right=0.98, top=0.86, bottom=0.1, hspace=0.12)
    begin = max(0.0, float(seen.t[0]))
    shown = [*seen.pushes[:_MOST_PUSHES], *seen.unclear[:_MOST_PUSHES]]
    last = max(
        (int(seen.rests[b][1]) for _, b in shown), default=min(_MOST_SAMPLES, seen.t.size) - 1
    )
    every = slice(0, last + 1, max(1, (last + 1) // _MOST_SAMPLES))
    t = seen.t[every]
    above.plot(t, 1e3 * (seen.x[every] - seen.x[0]), color=INK, linewidth=0.9, label="x (mm)")
    above.plot(t, 1e3 * (seen.y[every] - seen.y[0]), color=QUIET, linewidth=0.9, label="y (mm)")
    below.plot(t, np.degrees(seen.theta[every]), color=INK, linewidth=0.9)
    above.set_ylabel("place from the first (mm)")
    below.set(ylabel="orientation (°)", xlabel="time (s)", xlim=(begin, float(seen.t[last])))
    for axes in (above, below):
        for first, end in seen.pushes[:_MOST_PUSHES]:
            axes.axvspan(
                seen.t[seen.rests[first][1]],
                seen.t[seen.rests[end][0]],
                color=PREDICTED_FILL,
                zorder=0,
            )
        for first, end in seen.unclear[:_MOST_PUSHES]:
            axes.axvspan(
                seen.t[seen.rests[first][1]],
                seen.t[seen.rests[end][0]],
                facecolor="none",
                edgecolor=FORCE,
                hatch="//",
            )
    floor = below.get_ylim()[0]
    for first, end in seen.rests:
        if seen.t[first] <= seen.t[last]:
            below.plot(
                seen.t[[first, end]], [floor, floor], color=INK, linewidth=4, solid_capstyle="butt"
            )
    above.legend(loc="upper right", ncols=2)
    figure.text(0.02, 0.95, seen.words, fontsize=13, fontweight="bold", va="center")
    figure.text(
        0.02,
        0.9,
        "shaded: pushes; bars: rests; hatched: neither a push nor a drag",
        color=QUIET,
        va="center",
    )
    return figure
