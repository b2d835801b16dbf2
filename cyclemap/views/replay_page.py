"""Replayed pushes on a landscape page: errors by object, predicted over measured motion, and a few
courses.
"""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from cyclemap.arrays import Array
from cyclemap.evidence.replay.replay_push import Replay
from cyclemap.evidence.replay.replay_table import ReplayedPushes
from cyclemap.views import style
from cyclemap.views.style import FORCE, MEASURED, MEASURED_EDGE, PREDICTED, QUIET, Look

# Courses are drawn of the pushes at these shares of the order of their errors: a good, a usual, a
# bad one.
_SHARES = (0.25, 0.5, 0.75)
_MARKERS = "osD^vP*X<>ph"


def replay_headline(replayed: ReplayedPushes) -> str:
    """How many pushes were replayed and how far off they end, in a sentence."""
    error, turn_error = replayed.mean_errors
    count, left_out = len(replayed.table), len(replayed.not_replayed)
    also = f"; {left_out} file{'s' * (left_out != 1)} could not be" if left_out else ""
    ends = "ends" if count == 1 else "they end"
    who = "1 push replayed: it" if count == 1 else f"{count} pushes replayed:"
    return (
        f"{who} {ends} {1e3 * error:.1f} mm and {math.degrees(turn_error):.1f}° off on "
        f"average{also}."
    )


@style.picture_style()
def replay_page(replayed: ReplayedPushes, material: str) -> Figure:
    """Draw the replays of a collection on `material`; at least one replay is needed."""
    figure = style.new_figure()
    grid = GridSpec(
        2,
        12,
        figure,
        left=0.055,
        right=0.985,
        bottom=0.12,
        top=0.83,
        wspace=1.9,
        hspace=0.62,
    )
    for turn in (False, True):
        errors, motions = (
            figure.add_subplot(grid[0, left : left + 3]) for left in (3 * turn, 6 + 3 * turn)
        )
        _draw_whole(errors, motions, replayed, turn)
    order = np.argsort(replayed.table["error"].to_numpy(), kind="stable")
    for place, share in enumerate(_SHARES):
        row = int(order[min(int(share * len(order)), len(order) - 1)])
        # One push seen from above: the object before, and after it as measured and as predicted,
        # with its ways.
        axes = figure.add_subplot(grid[1, 4 * place : 4 * place + 4])
        replay, facts = replayed.replays[row], replayed.table.iloc[row]
        axes.plot(
            *_outline(replay, replay.measured[0]),
            color=QUIET,
            linewidth=1.0,
            linestyle=":",
            label="before",
        )
        for poses, colour, width, name in (
            (replay.measured, MEASURED, 3.0, "measured"),
            (replay.predicted, PREDICTED, 1.5, "predicted"),
        ):
            axes.plot(*_outline(replay, poses[-1]), color=colour, linewidth=width, label=name)
            axes.plot(*1e3 * poses[:, :2].T, color=colour, linewidth=width)
        axes.plot(*1e3 * replay.tip.T, color=FORCE, linewidth=1.5, label="rod's way")
        axes.plot(*1e3 * replay.tip[0], "o", color=FORCE, markersize=4.0)
        axes.set_aspect("equal", adjustable="datalim")
        axes.set(xlabel="x (mm)", ylabel="y (mm)")
        speed = "" if math.isnan(facts["speed"]) else f", {1e3 * facts['speed']:.0f} mm/s"
        off = f"{1e3 * replay.error[-1]:.1f} mm, {math.degrees(abs(replay.turn_error[-1])):.1f}°"
        axes.set_title(f"{facts['object']}{speed}: off {off}", pad=20.0)
        style.legend_above(axes)
    foot = (
        "quasi-static prediction along the recorded tip; poses at the recorded times; a dot a "
        "push, a bar a mean"
    )
    style.write_page(figure, f"Replayed on {material}", [replay_headline(replayed)], foot)
    return figure


def _draw_whole(errors: Axes, motions: Axes, replayed: ReplayedPushes, turn: bool) -> None:
    """Errors at the end by object, each push and their mean; predicted over measured motion, a
    marker an object.
    """
    table, kinds = replayed.table, sorted(set(replayed.table["object"]))
    name, factor, unit = ("turn", math.degrees(1.0), "°") if turn else ("motion", 1e3, "mm")
    off = factor * table["turn_error" if turn else "error"].abs().to_numpy()
    both = factor * table[[f"measured_{name}", f"predicted_{name}"]].to_numpy()
    ends = [float(both.min()), float(both.max())]
    motions.plot(ends, ends, color=QUIET, linewidth=0.9, zorder=2)
    look: Look = {
        "markersize": 4.0,
        "mfc": "white",
        "mec": PREDICTED,
        "linestyle": "none",
    }
    for place, kind in enumerate(kinds):
        chosen = (table["object"] == kind).to_numpy()
        error = off[chosen]
        spread = place + 0.5 * (np.arange(error.size) + 0.5) / error.size - 0.25
        errors.plot(
            spread,
            error,
            "o",
            color=MEASURED,
            markeredgecolor=MEASURED_EDGE,
            markersize=3.5,
            zorder=3,
        )
        errors.hlines(
            error.mean(), place - 0.36, place + 0.36, color=PREDICTED, linewidth=2.5, zorder=4
        )
        motions.plot(
            *both[chosen].T, marker=_MARKERS[place % len(_MARKERS)], label=kind, zorder=3, **look
        )
    errors.set_xticks(range(len(kinds)), kinds, rotation=30 if len(kinds) > 3 else 0)
    errors.set(xlim=(-0.6, len(kinds) - 0.4), ylim=(0.0, 1.08 * max(float(off.max()), 1e-12)))
    errors.set(
        ylabel=f"{'turn ' * turn}error ({unit})",
        title=f"{'Turn' if turn else 'Place'}, off at the end",
    )
    motions.set(xlabel=f"measured {name} ({unit})", ylabel=f"predicted {name} ({unit})")
    motions.set_title("Turn" if turn else "Distance")
    if turn and len(kinds) > 1:
        motions.legend(loc="upper left", fontsize=7.0, handletextpad=0.2)


def _outline(replay: Replay, pose: Array) -> Array:
    """The object's outline (2, k) at a pose, mm."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    x, y = replay.outline.T
    return 1e3 * np.stack([pose[0] + c * x - s * y, pose[1] + s * x + c * y])
