"""Staircases: a path with the dwells found in it, how long they last, and how the prediction moves under wear."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import Normal, Stroke
from matplotlib.ticker import MaxNLocator

from cyclemap.arrays import Array
from cyclemap.maps import StepComparison, Steps
from cyclemap.views import style
from cyclemap.views.sentences import angle, number
from cyclemap.views.style import INK, MEASURED, MEASURED_EDGE, PREDICTED, UNSTABLE

# With more dwells than this their levels are not written beside them.
MOST_NAMED = 12
# A predicted length so many times the panel's height is not drawn to scale.
FAR = 4.0


def draw_steps(axes: Axes, path: Array, steps: Steps) -> None:
    """`path` (rad, lifted) over the cycles, its dwells as thick bars at their levels, open where censored.

    Where the steps were found in zones that turn w times a cycle, the path is drawn less these turns.
    """
    winding = steps.zones[0].winding if steps.zones else 0
    cycles = np.arange(path.size)
    axes.plot(cycles, np.degrees(path - 2 * np.pi * winding * cycles), color=MEASURED, linewidth=1.2, label="path")
    # Every dwell as a bar, filled, or open where the path begins or ends in it.
    labels = {False: "dwell", True: "dwell not seen whole"}
    for start, end, level, censored in zip(steps.start, steps.end, steps.levels, steps.censored, strict=True):
        level_deg, open_ended = float(np.degrees(level)), bool(censored)
        look: dict[str, Any] = {"solid_capstyle": "butt", "zorder": 4}
        label = labels.pop(open_ended, None)
        (bar,) = axes.plot([start, end], [level_deg] * 2, color=INK, linewidth=5.0, label=label, **look)
        if open_ended:
            bar.set(color=UNSTABLE, linewidth=2.2, path_effects=[Stroke(linewidth=5.0, foreground=INK), Normal()])
        if steps.levels.size <= MOST_NAMED:
            style.name_beside_path(axes, start, end, level_deg, angle(level), steps.climb >= 0.0)
    turning = f" less {360 * winding}° a cycle" if winding else ""
    axes.set(xlabel="cycle", xlim=(0, max(path.size - 1, 1)))
    axes.xaxis.set_major_locator(MaxNLocator(6, integer=True, min_n_ticks=1))
    axes.margins(y=0.08)
    style.unwrapped_axis(axes, f"θ, unwrapped{turning}")
    style.legend_above(axes)


def draw_step_lengths(axes: Axes, steps: Steps, comparison: StepComparison | None = None) -> None:
    """The dwells' lengths in order, arrows where they lasted longer than was seen; means beside the prediction."""
    number_of = np.arange(1, steps.lengths.size + 1)
    open_ended = steps.censored
    look: dict[str, Any] = {"linestyle": "none", "markeredgecolor": MEASURED_EDGE, "zorder": 4}
    whole, cut = ~open_ended, open_ended
    if not steps.lengths.size:
        style.say(axes, "no dwell")
    if whole.any():
        axes.plot(number_of[whole], steps.lengths[whole], "o", color=MEASURED, label="dwell", **look)
    if cut.any():
        open_look = {**look, "markerfacecolor": UNSTABLE}
        axes.plot(number_of[cut], steps.lengths[cut], "^", label="lasted longer than seen", **open_look)
    if comparison is not None:
        # The measured mean with its standard error, and the predicted one.
        mean, error, predicted = comparison.mean_length, comparison.length_error, comparison.predicted_length
        if mean is not None:
            spread = 0.0 if error is None else error
            label = f"mean {mean:.1f}" if error is None else f"mean {mean:.1f} ± {error:.1f}"
            axes.axhspan(mean - spread, mean + spread, color=MEASURED, alpha=0.25, linewidth=0, zorder=1)
            axes.axhline(mean, color=MEASURED_EDGE, linewidth=1.0, label=label, zorder=2)
        if predicted is not None:
            # The predicted mean as a line, or told alone where the line would dwarf what was measured.
            line: dict[str, Any] = {"color": PREDICTED, "linewidth": 1.8, "linestyle": "--", "zorder": 3}
            if predicted > FAR * axes.get_ylim()[1]:
                axes.plot([], [], label=f"predicted {number(predicted)}, beyond the panel", **line)
            else:
                written = f"{predicted:.1f}" if predicted < 1000 else number(predicted)
                axes.axhline(predicted, label=f"predicted {written}", **line)
    axes.set(xlabel="dwell", ylabel="length (cycles)", xlim=(0.5, max(steps.lengths.size, 1) + 0.5))
    axes.set_ylim(bottom=0.0)
    axes.xaxis.set_major_locator(MaxNLocator(8, integer=True, min_n_ticks=1))
    style.legend_above(axes, columns=4)
