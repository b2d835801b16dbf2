"""A watched collection, and an audited data set: in sentences, and as pages of θ0 push by push,
directions, what they are worth, and evidence or what the reset did.
"""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from cyclemap.arrays import TWO_PI
from cyclemap.evidence import angle_histogram
from cyclemap.resets import Alarm, BiasMonitor, BiasReport, CoverageState, CycleAction, NextAction
from cyclemap.resets.audit import Audit, ResetEffect
from cyclemap.views.panels.layout import entitle, page
from cyclemap.views.panels.orientation import CIRCLE
from cyclemap.views.panels.style import (
    BARS,
    DOTS,
    EVEN,
    FORCE,
    INK,
    LINE,
    MEASURED_EDGE,
    PREDICTED,
    SECOND,
    THETA0,
    THIRD,
    Look,
    count_axis,
    picture_style,
    say,
    whole_turn_ticks,
)
from cyclemap.views.reset_page import action_words
from cyclemap.views.sentences import angle, counted

_DECADES = (0, 1, 2, 3, 10, 30, 100, 300, 1000)
# The panels of a course: the third is round.
_COURSE: Look = {"polar": "c", "width_ratios": (1.9, 1.0)}


@picture_style()
def watch_page(monitor: BiasMonitor, reports: Sequence[BiasReport], name: str) -> Figure:
    """Draw the course of a watched collection, its monitor's report after each push; ``name`` : of
    its file.
    """
    last = reports[-1]
    title = f"{name}: {'no sign of locking in' if last.alarm is None else 'locks in'}"
    foot = "chance of an alarm, however long the collection, where no orientation lingers:"
    foot = f"{foot} {monitor.alarm_rate:g} at most"
    figure, panels = page("ac;bd", title, watch_sentences(last), foot, **_COURSE)
    axes = draw_course(panels, monitor.path, reports)
    rest = [report.rest_evidence for report in reports]
    visits = [report.visit_evidence for report in reports]
    axes.plot(rest, label="of a rest", **LINE)
    axes.plot(visits, label="of visits gathering", **THIRD)
    label = f"alarm, rate {monitor.alarm_rate:g}"
    axes.axhline(last.threshold, label=label, **SECOND)
    if last.alarm is not None:
        axes.axvline(last.alarm.push, color=FORCE, linewidth=1.6)
    # Powers of ten: even steps up to the third, then narrower ones, for evidence may pass any
    # bound.
    highest, lowest = max(*rest, *visits, 2.0 * last.threshold), min(*rest, *visits, -0.5)
    axes.set_yscale("symlog", linthresh=3.0)
    axes.set(ylim=(1.1 * lowest, 1.3 * highest), ylabel="evidence against no bias")
    powers = [power for power in _DECADES if power <= 1.3 * highest]
    axes.yaxis.set_major_locator(FixedLocator(powers))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda power, _: f"$10^{{{power:.0f}}}$"))
    count_axis(axes, "push", len(reports))
    entitle(axes, "Evidence")
    return figure


def draw_course(
    panels: Sequence[Axes], theta: Sequence[float], reports: Sequence[BiasReport]
) -> Axes:
    """Draw the orientations (rad) push by push, their rose, and what they are worth, by the
    monitor's reports; return the panel that is left, below the first.
    """
    path, left, rose, worth = panels
    draw_path(path, theta, reports[-1])
    draw_rose(rose, theta, reports[-1])
    draw_worth(worth, [report.coverage.effective_pushes for report in reports])
    return left


def draw_path(axes: Axes, theta: Sequence[float], last: BiasReport) -> None:
    """Draw the orientations (rad) push by push, and the alarm."""
    # A few dots must be seen, many must not run into each other.
    size = float(np.clip(90.0 / len(theta), 2.5, 9.0))
    axes.plot(np.degrees(theta) % 360.0, ".", color=MEASURED_EDGE, markersize=size, zorder=2)
    if last.alarm is not None:
        for direction in last.alarm.directions:
            axes.axhline(np.degrees(direction), **{**THIRD, "linewidth": 1.0, "zorder": 1})
        towards = directions(last.alarm.directions)
        label = f"alarm at push {last.alarm.push}, towards {towards}"
        axes.axvline(last.alarm.push, color=FORCE, linewidth=1.6, label=label, zorder=3)
    axes.set_ylabel(THETA0)
    whole_turn_ticks(axes)
    count_axis(axes, "push", len(theta))
    entitle(axes, "Orientations")


def draw_rose(axes: Axes, theta: Sequence[float], last: BiasReport) -> None:
    """Draw the histogram of directions with equal areas for equal counts: radii are roots of
    densities.
    """
    histogram, aim = angle_histogram(np.mod(theta, TWO_PI), 36), last.advice.direction
    radii = np.sqrt(histogram.density * TWO_PI)
    axes.bar(histogram.edges[:-1], radii, np.diff(histogram.edges), align="edge", **BARS)
    axes.plot(CIRCLE, np.ones_like(CIRCLE), label="spread evenly", **EVEN)
    top = 1.12 * max(float(radii.max()), 1.2)
    axes.plot(
        [aim],
        [top],
        "v",
        ms=9,
        color=PREDICTED,
        label=f"least covered: {angle(aim, 0)}",
        clip_on=False,
    )
    axes.set(ylim=(0.0, top), yticklabels=[], xticks=np.radians(range(0, 360, 45)))
    axes.tick_params(axis="x", pad=1)
    axes.set_title("Directions recorded", loc="left", x=-0.62, y=1.0)
    axes.legend(loc="upper left", bbox_to_anchor=(-0.64, 0.1))


def draw_worth(axes: Axes, effective: Sequence[float]) -> None:
    """Draw what the pushes recorded so far are worth, after each."""
    pushes = len(effective)
    axes.plot([0, pushes], [0, pushes], label="spread evenly", **EVEN)
    axes.plot(np.arange(1, pushes + 1), effective, color=INK, linewidth=1.8, label="recorded")
    axes.set_ylabel("worth, in pushes spread evenly")
    axes.set_ylim(bottom=0.0)
    count_axis(axes, "pushes recorded", pushes)
    entitle(axes, "What the pushes are worth")


def watch_sentences(report: BiasReport) -> tuple[str, ...]:
    """The whole report: alarm, or how far it is from one, present rest, coverage, advice."""
    if report.alarm is not None:
        verdict = alarm_sentence(report.alarm)
    else:
        evidence = _power(max(report.rest_evidence, report.visit_evidence))
        needed = (
            f"of the {_power(report.threshold)} needed at an alarm rate of "
            f"{2.0 * 10.0**-report.threshold:g}"
        )
        verdict = (
            f"No alarm in {counted(report.push + 1, 'push', 'es')}: evidence {evidence} {needed}."
        )
    sentences = (verdict, rest_sentence(report), coverage_sentence(report), advice_sentence(report))
    return tuple(filter(None, sentences))


def alarm_sentence(alarm: Alarm) -> str:
    """When the alarm was raised, and towards which directions."""
    rests = "θ0 goes round" if len(alarm.directions) > 1 else "θ0 rests near"
    how, since = (
        (rests, f" since push {alarm.began}")
        if alarm.kind == "rest"
        else ("visits gather near", "")
    )
    when = f"ALARM at push {alarm.push}, counted from 0"
    return f"{when}: {how} {directions(alarm.directions)}{since}."


def rest_sentence(report: BiasReport) -> str:
    """Where it rests just now, and whether more pushes there are of use; empty where it does not
    rest.
    """
    if report.rest is None:
        return ""
    useful = report.useful_pushes
    pushes = counted(useful, "push", "es") if useful else "no push"
    worth = "" if useful is None else f"; {pushes} more there would tell much that is new"
    # The sentence of an alarm before it has said how pushes are counted.
    count = ", counted from 0" if report.alarm is None else ""
    since = f"since push {report.rest.began}{count}"
    return f"It rests near {directions(report.rest.directions)} {since}{worth}."


def coverage_sentence(report: BiasReport) -> str:
    """How much of the circle is covered, and what that is worth."""
    count, effective = report.push + 1, report.coverage.effective_pushes
    worth = (
        f"worth {effective:.{int(effective < 10.0)}f} spread evenly ({report.recent_worth:.2f} a "
        "push lately)"
    )
    are = "is" if count == 1 else "are"
    return f"{covered(report.coverage)}; the {counted(count, 'push', 'es')} {are} {worth}."


def covered(state: CoverageState) -> str:
    """The share of the circle that is covered, and the widest gap."""
    gap = f"the widest gap is {angle(state.largest_gap, 0)} about {angle(state.gap_centre, 0)}"
    return f"{state.covered:.0%} of the circle is covered, {gap}"


def advice_sentence(report: BiasReport) -> str:
    """What to do next."""
    aim, change = angle(report.advice.direction, 0), report.advice.change_reset
    bring = f"Change the reset: bring θ0 to {aim}, the direction least covered."
    return bring if change else f"Carry on; least covered: {aim}."


def next_action_sentence(action: CycleAction, chosen: NextAction) -> str:
    """Which action of the strategy to take next, and where it leads."""
    where = f"{angle(chosen.lands, 0)}, where {chosen.crowding:.0%} of the mean are recorded"
    return f"Next: {action_words(action)}; it brings θ0 to {where}."


def directions(angles: Sequence[float]) -> str:
    """Directions (rad) in degrees, one after the other."""
    return ", ".join(angle(theta) for theta in angles)


def _power(log10: float) -> str:
    return f"{10.0 ** max(log10, 0.0):.3g}" if log10 < 6.0 else f"10^{log10:.0f}"


# Of the pushes behind an alarm, so many near its direction are a lock-in; fewer come and go.
_LOCKED = 0.8


def audit_headline(audit: Audit) -> str:
    """Whether the data set can be used as it is."""
    if audit.is_good:
        return f"{audit.name}: the orientations are spread well"
    if audit.locked_from is not None:
        how = "locks in" if audit.gathered > _LOCKED else "lingers"
        return f"{audit.name}: {how} from push {audit.locked_from} on"
    return f"{audit.name}: the orientations are not spread over the circle"


def audit_paragraph(audit: Audit) -> str:
    """What stands on the data set's card: cover, lock-in, worth, what the reset did, what to
    change.
    """
    pushes, others = len(audit.theta), audit.others
    of = f" (and {others} pushes of other sets, not looked at)" if others else ""
    cover = f"The orientations of the object before {pushes} pushes{of} {_covering(audit)}."
    worth = (
        f"The {pushes} pushes tell as much of how motion depends on orientation as "
        f"{audit.worth:.0f} spread evenly."
    )
    return " ".join([cover, _gathering(audit), worth, _undone(audit), _change(audit)])


def _covering(audit: Audit) -> str:
    state, arcs = audit.report.coverage, audit.covered
    if len(arcs) == 1 and arcs[0][1] - arcs[0][0] > 6.28:
        return (
            f"cover the whole circle, their widest gap {angle(state.largest_gap, 0)} about "
            f"{angle(state.gap_centre, 0)}"
        )
    arc_words = ", ".join(f"{angle(low, 0)} to {angle(high % TWO_PI, 0)}" for low, high in arcs[:4])
    more = f" and {counted(len(arcs) - 4, 'more arc')}" if len(arcs) > 4 else ""
    return f"cover {arc_words}{more}: {state.covered:.0%} of the circle is within 5° of one"


def _gathering(audit: Audit) -> str:
    alarm, start = audit.report.alarm, audit.locked_from
    if not audit.ordered:
        return "Their order is not known, so that nothing can be said of when they gathered."
    if alarm is None or start is None:
        return f"Nothing shows that they lock in (at an alarm rate of {audit.alarm_rate:g})."
    how = "lock in" if audit.gathered > _LOCKED else "linger again and again"
    return (
        f"From push {start} on, of those read, counted from 0, they {how} about "
        f"{directions(alarm.directions)}: "
        f"{audit.gathered:.0%} of the {len(audit.theta) - start} pushes from there on lie within "
        "10° of it."
    )


def _change(audit: Audit) -> str:
    start, aim = audit.locked_from, angle(audit.report.coverage.least_covered, 0)
    if audit.is_good:
        return f"Nothing needs to change; the orientation least covered is {aim}."
    if start is not None and audit.gathered > _LOCKED:
        return (
            f"Weigh what follows push {start} less, or leave it out; for more data change the "
            f"reset (cyclemap reset finds one) and begin at {aim}, the orientation least covered."
        )
    return (
        f"For more data begin at {aim}, the orientation least covered, or with a reset that "
        "cyclemap reset finds."
    )


def _undone(audit: Audit) -> str:
    reset: ResetEffect | None = audit.reset
    if reset is None and audit.posed:
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
    share = "" if math.isnan(reset.undone) else f": that took {reset.undone:.0%} back"
    return (
        f"A push turned the object by {push}, the reset behind it by {back}{share}, so that the "
        f"next push began {moved} farther on average."
    )


@picture_style()
def audit_page(audit: Audit) -> Figure:
    """Draw the orientations push by push, their rose, their worth, and each reset's turn over its
    push's.
    """
    title, words = audit_headline(audit), [audit_paragraph(audit)]
    figure, panels = page("ac;bd", title, words, **_COURSE)
    reset = draw_course(panels, audit.theta, audit.reports)
    if audit.reset is None:
        reset.axis("off")
        say(reset, "no poses after pushes: what the reset did is unknown")
        return figure
    push, back = np.degrees([audit.reset.push_turn, audit.reset.reset_turn])
    reset.plot(push, back, label="measured", **DOTS)
    reset.axline((0.0, 0.0), slope=-1.0, label="undoes the push", **SECOND)
    reset.set(xlabel="turn by the push (°)", ylabel="turn by the reset (°)")
    entitle(reset, "What the reset did")
    return figure
