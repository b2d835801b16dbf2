"""Replayed pushes on a landscape page: errors by object, predicted over measured motion, and a few
courses.
"""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.collection.cycle_scene import placed
from cyclemap.evidence.comparison.replay_push import Replay
from cyclemap.evidence.comparison.replay_table import ReplayedPushes
from cyclemap.views import style
from cyclemap.views.object_page import MM, draw_way
from cyclemap.views.sentences import angle
from cyclemap.views.style import FORCE, PREDICTED

# Courses are drawn of the pushes at these shares of the order of their errors: a good, a usual, a
# bad one.
_SHARES = (0.25, 0.5, 0.75)
_MARKERS = "osD^vP*X<>ph"
# Of motion and turn: the column of errors, titles of both panels, factor and unit.
_WHOLE = {
    "motion": ("error", "Place", "Distance", MM, "mm"),
    "turn": ("turn_error", "Turn", "Turn", math.degrees(1.0), "°"),
}


def replay_headline(replayed: ReplayedPushes) -> str:
    """How many pushes were replayed and how far off they end, in a sentence."""
    error, turn_error = replayed.mean_errors
    count, left_out = len(replayed.table), len(replayed.not_replayed)
    also = f"; {left_out} file{'s' * (left_out != 1)} could not be" if left_out else ""
    ends = "ends" if count == 1 else "they end"
    who = "1 push replayed: it" if count == 1 else f"{count} pushes replayed:"
    return f"{who} {ends} {1e3 * error:.1f} mm and {angle(turn_error)} off on average{also}."


@style.picture_style()
def replay_page(replayed: ReplayedPushes, material: str) -> Figure:
    """Draw the replays of a collection on `material`; at least one replay is needed."""
    foot = (
        "quasi-static prediction along the recorded tip; poses at the recorded times; a dot a "
        "push, a bar a mean"
    )
    layout, words = style.rows_of(4, len(_SHARES)), [replay_headline(replayed)]
    figure, panels = style.page(layout, f"Replayed on {material}", words, foot, keys=2)
    places, distances, turns, angles, *courses = panels
    _draw_whole(places, distances, replayed, "motion")
    _draw_whole(turns, angles, replayed, "turn")
    order = np.argsort(replayed.table["error"].to_numpy(), kind="stable")
    for axes, share in zip(courses, _SHARES, strict=True):
        row = int(order[min(int(share * len(order)), len(order) - 1)])
        _draw_course(axes, replayed.replays[row])
        facts = replayed.table.iloc[row]
        speed = "" if math.isnan(facts["speed"]) else f", {1e3 * facts['speed']:.0f} mm/s"
        off = f"{1e3 * facts['error']:.1f} mm, {angle(abs(facts['turn_error']))}"
        style.entitle(axes, f"{facts['object']}{speed}: off {off}")
    return figure


def _draw_course(axes: Axes, replay: Replay) -> None:
    """One push seen from above: the object before, and after it as measured and as predicted, with
    its ways.
    """
    before = placed(replay.measured[0], replay.outline)
    draw_way(axes, before, label="before", **style.EVEN)
    ways = (("measured", replay.measured, style.PATH), ("predicted", replay.predicted, style.LINE))
    for name, poses, look in ways:
        draw_way(axes, placed(poses[-1], replay.outline), label=name, **look)
        draw_way(axes, poses[:, :2], **look)
    draw_way(
        axes,
        replay.tip,
        linewidth=1.5,
        label="rod's way",
        color=FORCE,
        marker="o",
        markersize=4.0,
        markevery=[0],
    )
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x (mm)", ylabel="y (mm)")


def _draw_whole(errors: Axes, motions: Axes, replayed: ReplayedPushes, name: str) -> None:
    """Errors at the end by object, each push and their mean; predicted over measured motion, a
    marker an object.
    """
    table, kinds = replayed.table, sorted(set(replayed.table["object"]))
    column, title, other, factor, unit = _WHOLE[name]
    off = factor * table[column].abs().to_numpy()
    both = factor * table[[f"measured_{name}", f"predicted_{name}"]].to_numpy()
    motions.axline((0.0, 0.0), slope=1.0, **style.ZERO)
    for place, kind in enumerate(kinds):
        chosen = (table["object"] == kind).to_numpy()
        error = off[chosen]
        spread = place + 0.5 * (np.arange(error.size) + 0.5) / error.size - 0.25
        marker = _MARKERS[place % len(_MARKERS)]
        errors.plot(spread, error, marker, **style.MARKS)
        errors.hlines(
            error.mean(), place - 0.36, place + 0.36, color=PREDICTED, linewidth=2.5, zorder=4
        )
        look = {**style.OPEN, "markeredgecolor": PREDICTED, "markersize": 4.0}
        motions.plot(*both[chosen].T, marker, **look)
    errors.set_xticks(range(len(kinds)), kinds, rotation=30 if len(kinds) > 3 else 0)
    errors.set(xlim=(-0.6, len(kinds) - 0.4), ylim=(0.0, 1.08 * max(float(off.max()), 1e-12)))
    errors.set_ylabel(f"{'turn ' * (name == 'turn')}error ({unit})")
    style.entitle(errors, f"{title}, off at the end")
    motions.set(xlabel=f"measured {name} ({unit})", ylabel=f"predicted {name} ({unit})")
    style.entitle(motions, other)
