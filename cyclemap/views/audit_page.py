"""An audited data set: a paragraph for its card, and a page."""

from __future__ import annotations

import math
import textwrap

import numpy as np
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from cyclemap.resets.monitor.audit import Audit, ResetEffect
from cyclemap.views.sentences import angle
from cyclemap.views.style import INK, MEASURED, MEASURED_EDGE, QUIET, new_figure, picture_style
from cyclemap.views.watch_page import directions, draw_path, draw_rose, draw_worth

_LETTERS = 165
# Of the pushes behind an alarm, so many near its direction are a lock-in; fewer come and go.
_LOCKED = 0.8


def audit_headline(found: Audit) -> str:
    """Whether the data set can be used as it is."""
    if found.is_good:
        return f"{found.name}: the orientations are spread well"
    if found.locked_from is not None:
        how = "locks in" if found.gathered > _LOCKED else "lingers"
        return f"{found.name}: {how} from push {found.locked_from} on"
    return f"{found.name}: the orientations are not spread over the circle"


def audit_paragraph(found: Audit) -> str:
    """What stands on the data set's card: cover, lock-in, worth, what the reset did, what to
    change.
    """
    pushes = len(found.theta)
    state, others = found.report.coverage, found.others
    of = f" (and {others} pushes of other sets, not looked at)" if others else ""
    if len(found.covered) == 1 and found.covered[0][1] - found.covered[0][0] > 6.28:
        where = (
            f"cover the whole circle, their widest gap {angle(state.largest_gap, 0)} about "
            f"{angle(state.gap_centre, 0)}"
        )
    else:
        arcs = ", ".join(
            f"{angle(low, 0)} to {angle(high % (2 * math.pi), 0)}"
            for low, high in found.covered[:4]
        )
        more = f" and {len(found.covered) - 4} arcs more" if len(found.covered) > 4 else ""
        where = f"cover {arcs}{more}: {state.covered:.0%} of the circle is within 5° of one"
    cover = f"The orientations of the object before {pushes} pushes{of} {where}."
    worth = (
        f"The {pushes} pushes tell as much of how motion depends on orientation as "
        f"{found.worth:.0f} spread evenly."
    )
    alarm, start, aim = found.report.alarm, found.locked_from, angle(state.least_covered, 0)
    locks = start is not None and found.gathered > _LOCKED
    if not found.ordered:
        gathered = "Their order is not known, so that nothing can be said of when they gathered."
    elif alarm is None or start is None:
        gathered = f"Nothing shows that they lock in (at an alarm rate of {found.alarm_rate:g})."
    else:
        how = "lock in" if locks else "linger again and again"
        gathered = (
            f"From push {start} on they {how} about {directions(alarm.directions)}: "
            f"{found.gathered:.0%} of the {pushes - start} pushes from there on lie within 10° of "
            "it."
        )
    change = (
        f"For more data begin at {aim}, the orientation least covered, or with a reset that "
        "cyclemap reset finds."
    )
    if found.is_good:
        change = f"Nothing needs to change; the orientation least covered is {aim}."
    elif locks:
        change = (
            f"Weigh what follows push {start} less, or leave it out; for more data change the "
            f"reset (cyclemap reset finds one) and begin at {aim}, the orientation least covered."
        )
    return " ".join([cover, gathered, worth, _undone(found), change])


def _undone(found: Audit) -> str:
    reset: ResetEffect | None = found.reset
    if reset is None and found.posed:
        return (
            "What the reset did cannot be said: poses before and after pushes are there, but not "
            "in a row of pushes that follow each other: it takes their numbers, a column rep, and "
            "no orientations set at random."
        )
    if reset is None:
        return "What the reset did cannot be said: the data have no poses after pushes."
    turns = (np.degrees(turn) for turn in (reset.push_turn, reset.reset_turn))
    push, back = (f"{turn.mean():.1f}° ± {turn.std():.1f}°" for turn in turns)
    moved = angle(float((reset.push_turn + reset.reset_turn).mean()))
    return (
        f"A push turned the object by {push}, the reset behind it by {back}: that took "
        f"{reset.undone:.0%} back, so that the next push began {moved} farther on average."
    )


@picture_style()
def audit_page(found: Audit) -> Figure:
    """Draw the orientations push by push, their rose, their worth, and each reset's turn over its
    push's.
    """
    figure = new_figure(13.333, 7.9)
    edges = {"left": 0.06, "right": 0.975, "bottom": 0.08, "top": 0.74}
    grid = GridSpec(2, 2, figure, width_ratios=(1.9, 1.0), wspace=0.16, hspace=0.5, **edges)
    draw_path(figure.add_subplot(grid[0, 0]), found.theta, found.report)
    draw_rose(figure.add_subplot(grid[0, 1], projection="polar"), found.theta, found.report)
    draw_worth(
        figure.add_subplot(grid[1, 1]), [one.coverage.effective_pushes for one in found.reports]
    )
    axes, reset = figure.add_subplot(grid[1, 0]), found.reset
    if reset is None:
        axes.axis("off")
        axes.text(
            0.5,
            0.5,
            "no poses after pushes: what the reset did is unknown",
            ha="center",
            color=QUIET,
        )
    else:
        push, back = np.degrees(reset.push_turn), np.degrees(reset.reset_turn)
        axes.plot(push, back, "o", mfc=MEASURED, mec=MEASURED_EDGE, markersize=4, label="measured")
        ends = np.array([push.min() - 1.0, push.max() + 1.0])
        axes.plot(ends, -ends, color=INK, linewidth=1.0, linestyle="--", label="undoes the push")
        axes.set(
            xlabel="turn by the push (°)",
            ylabel="turn by the reset (°)",
            title="What the reset did",
        )
        axes.legend(loc="best")
    figure.text(0.015, 0.965, audit_headline(found), fontsize=18, fontweight="bold", va="center")
    told = textwrap.fill(audit_paragraph(found), _LETTERS)
    figure.text(0.015, 0.935, told, fontsize=10, va="top", linespacing=1.35)
    return figure
