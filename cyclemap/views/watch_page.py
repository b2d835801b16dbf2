"""A watched collection: in sentences, and as a page of θ0 push by push, evidence, directions, what
it is worth.
"""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator

from cyclemap.evidence import angle_histogram
from cyclemap.resets import Alarm, BiasMonitor, BiasReport, CoverageState, CycleAction, NextAction
from cyclemap.views import style
from cyclemap.views.reset_page import action_words
from cyclemap.views.sentences import angle
from cyclemap.views.style import FORCE, INK, MEASURED, MEASURED_EDGE, PREDICTED, QUIET, Look

_DECADES = (0, 1, 2, 3, 10, 30, 100, 300, 1000)


@style.picture_style()
def watch_page(monitor: BiasMonitor, reports: Sequence[BiasReport], name: str) -> Figure:
    """Draw the course of a watched collection, its monitor's report after each push; ``name`` : of
    its file.
    """
    last = reports[-1]
    figure = style.new_figure()
    edges = {"left": 0.06, "right": 0.975, "bottom": 0.115, "top": 0.8}
    grid = GridSpec(2, 2, figure, width_ratios=(1.9, 1.0), wspace=0.16, hspace=0.45, **edges)
    draw_path(figure.add_subplot(grid[0, 0]), monitor.path, last)
    axes = figure.add_subplot(grid[1, 0])
    rest, visits = (
        [getattr(one, name) for one in reports] for name in ("rest_evidence", "visit_evidence")
    )
    axes.plot(rest, color=PREDICTED, linewidth=1.8, label="of a rest")
    axes.plot(visits, color=MEASURED, linewidth=1.8, linestyle="-.", label="of visits gathering")
    axes.axhline(
        last.threshold,
        color=FORCE,
        linewidth=1.2,
        linestyle="--",
        label=f"alarm, rate {monitor.alarm_rate:g}",
    )
    if last.alarm is not None:
        axes.axvline(last.alarm.push, color=FORCE, linewidth=1.6)
    # Powers of ten: even steps up to the third, then narrower ones, for evidence may pass any
    # bound.
    highest, lowest = max(*rest, *visits, 2.0 * last.threshold), min(*rest, *visits, -0.5)
    axes.set_yscale("symlog", linthresh=3.0)
    axes.set(
        ylim=(1.1 * lowest, 1.3 * highest), ylabel="evidence against no bias", title="Evidence"
    )
    axes.yaxis.set_major_locator(
        FixedLocator([power for power in _DECADES if power <= 1.3 * highest])
    )
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda power, _: f"$10^{{{power:.0f}}}$"))
    _push_axis(axes, len(reports))
    draw_rose(figure.add_subplot(grid[0, 1], projection="polar"), monitor.path, last)
    draw_worth(
        figure.add_subplot(grid[1, 1]), [report.coverage.effective_pushes for report in reports]
    )
    title = f"{name}: {'no sign of locking in' if last.alarm is None else 'locks in'}"
    foot = "chance of an alarm, however long the collection, where no orientation lingers:"
    style.write_page(figure, title, watch_sentences(last), f"{foot} {monitor.alarm_rate:g} at most")
    return figure


def draw_path(axes: Axes, theta: Sequence[float], last: BiasReport) -> None:
    """Draw the orientations (rad) push by push, and the alarm."""
    # A few dots must be seen, many must not run into each other.
    size = float(np.clip(90.0 / len(theta), 2.5, 9.0))
    axes.plot(
        np.degrees(np.mod(theta, 2.0 * np.pi)), ".", color=MEASURED_EDGE, markersize=size, zorder=2
    )
    if last.alarm is not None:
        for direction in last.alarm.directions:
            axes.axhline(
                np.degrees(direction), color=FORCE, linewidth=1.0, linestyle="--", zorder=1
            )
        label = (
            f"alarm at push {last.alarm.push}, towards "
            f"{', '.join(map(angle, last.alarm.directions))}"
        )
        axes.axvline(last.alarm.push, color=FORCE, linewidth=1.6, label=label, zorder=3)
    axes.set(ylabel=style.THETA0, ylim=(0.0, 360.0), yticks=range(0, 361, 90))
    axes.set_title("Orientations")
    _push_axis(axes, len(theta))


def draw_rose(axes: Axes, theta: Sequence[float], last: BiasReport) -> None:
    """Draw the histogram of directions with equal areas for equal counts: radii are roots of
    densities.
    """
    histogram, aim = angle_histogram(np.mod(theta, 2.0 * np.pi), 36), last.advice.direction
    radii = np.sqrt(histogram.density * 2 * np.pi)
    looks: Look = {"color": MEASURED, "edgecolor": MEASURED_EDGE, "linewidth": 0.6}
    axes.bar(histogram.edges[:-1], radii, width=np.diff(histogram.edges), align="edge", **looks)
    around = np.linspace(0.0, 2 * np.pi, 181)
    axes.plot(
        around,
        np.ones_like(around),
        color=QUIET,
        linewidth=0.9,
        linestyle=":",
        label="spread evenly",
    )
    top = 1.12 * max(float(radii.max()), 1.2)
    axes.plot(
        [aim],
        [top],
        "v",
        ms=9,
        color=PREDICTED,
        clip_on=False,
        label=f"least covered: {angle(aim, 0)}",
    )
    axes.set(ylim=(0.0, top), yticklabels=[], xticks=np.radians(range(0, 360, 45)))
    axes.tick_params(axis="x", pad=1)
    axes.grid(color="#ececec")
    axes.set_title("Directions recorded", loc="left", x=-0.62, y=1.0)
    axes.legend(loc="upper left", bbox_to_anchor=(-0.75, 0.12))


def draw_worth(axes: Axes, effective: Sequence[float]) -> None:
    """Draw what the pushes recorded so far are worth, after each."""
    pushes = len(effective)
    axes.plot(
        [0, pushes], [0, pushes], color=QUIET, linewidth=0.9, linestyle=":", label="spread evenly"
    )
    axes.plot(np.arange(1, pushes + 1), effective, color=INK, linewidth=1.8, label="recorded")
    axes.set(
        xlabel="pushes recorded",
        ylabel="worth, in pushes spread evenly",
        xlim=(0, pushes),
        ylim=(0.0, None),
    )
    axes.set_title("What the pushes are worth")
    axes.legend(loc="upper left")
    axes.xaxis.set_major_locator(MaxNLocator(5, integer=True, min_n_ticks=1))


def _push_axis(axes: Axes, pushes: int) -> None:
    axes.set(xlabel="push", xlim=(-0.5, max(pushes, 2) - 0.5))
    axes.xaxis.set_major_locator(MaxNLocator(8, integer=True, min_n_ticks=1))
    style.legend_above(axes)


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
        verdict = f"No alarm in {_pushes(report.push + 1)}: evidence {evidence} {needed}."
    told = (verdict, rest_sentence(report), coverage_sentence(report), advice_sentence(report))
    return tuple(filter(None, told))


def alarm_sentence(alarm: Alarm) -> str:
    """When the alarm was raised, and towards which directions."""
    rests = "θ0 goes round" if len(alarm.directions) > 1 else "θ0 rests near"
    how, since = (
        (rests, f" since push {alarm.began}")
        if alarm.kind == "rest"
        else ("visits gather near", "")
    )
    return f"ALARM at push {alarm.push}: {how} {directions(alarm.directions)}{since}."


def rest_sentence(report: BiasReport) -> str:
    """Where it rests just now, and whether more pushes there are of use; empty where it does not
    rest.
    """
    if report.rest is None:
        return ""
    useful = report.useful_pushes
    pushes = _pushes(useful) if useful else "no push"
    worth = "" if useful is None else f"; {pushes} more there would tell much that is new"
    return (
        f"It rests near {directions(report.rest.directions)} since push {report.rest.began}{worth}."
    )


def coverage_sentence(report: BiasReport) -> str:
    """How much of the circle is covered, and what that is worth."""
    count, effective = report.push + 1, report.coverage.effective_pushes
    worth = (
        f"worth {effective:.{int(effective < 10.0)}f} spread evenly ({report.recent_worth:.2f} a "
        "push lately)"
    )
    return (
        f"{covered(report.coverage)}; the {_pushes(count)} {'is' if count == 1 else 'are'} {worth}."
    )


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


def _pushes(count: int) -> str:
    return f"{count} push" if count == 1 else f"{count} pushes"


def _power(log10: float) -> str:
    return f"{10.0 ** max(log10, 0.0):.3g}" if log10 < 6.0 else f"10^{log10:.0f}"
