"""An audited data set: a paragraph for its card, and a page."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from cyclemap.resets.monitor.audit import Audit, ResetEffect
from cyclemap.views import style
from cyclemap.views.sentences import angle
from cyclemap.views.watch_page import directions, draw_course

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


@style.picture_style()
def audit_page(found: Audit) -> Figure:
    """Draw the orientations push by push, their rose, their worth, and each reset's turn over its
    push's.
    """
    figure = style.new_figure(13.333, 7.9)
    room = style.write_page(figure, audit_headline(found), [audit_paragraph(found)])
    reset = draw_course(figure, room, found.theta, found.reports)
    if found.reset is None:
        reset.axis("off")
        style.say(reset, "no poses after pushes: what the reset did is unknown")
        return figure
    push, back = np.degrees([found.reset.push_turn, found.reset.reset_turn])
    reset.plot(push, back, label="measured", **style.DOTS)
    reset.axline((0.0, 0.0), slope=-1.0, label="undoes the push", **style.SECOND)
    reset.set(xlabel="turn by the push (°)", ylabel="turn by the reset (°)")
    style.entitle(reset, "What the reset did")
    return figure
