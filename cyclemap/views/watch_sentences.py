"""A watched collection in sentences: whether it locks in, towards where, what is covered, and what to do."""

from collections.abc import Sequence

from cyclemap.resets import Alarm, BiasReport, CoverageState, CycleAction, NextAction
from cyclemap.views.reset_sentences import action_words
from cyclemap.views.sentences import angle, power_of_ten


def watch_sentences(report: BiasReport) -> tuple[str, ...]:
    """The whole report: alarm, or how far it is from one, present rest, coverage, advice."""
    if report.alarm is not None:
        verdict = alarm_sentence(report.alarm)
    else:
        evidence = _power(max(report.rest_evidence, report.visit_evidence))
        needed = f"of the {_power(report.threshold)} needed at an alarm rate of {2.0 * 10.0**-report.threshold:g}"
        verdict = f"No alarm in {_pushes(report.push + 1)}: evidence {evidence} {needed}."
    told = (verdict, rest_sentence(report), coverage_sentence(report), advice_sentence(report))
    return tuple(filter(None, told))


def alarm_sentence(alarm: Alarm) -> str:
    """When the alarm was raised, and towards which directions."""
    rests = "θ0 goes round" if len(alarm.directions) > 1 else "θ0 rests near"
    how, since = (rests, f" since push {alarm.began}") if alarm.kind == "rest" else ("visits gather near", "")
    return f"ALARM at push {alarm.push}: {how} {directions(alarm.directions)}{since}."


def rest_sentence(report: BiasReport) -> str:
    """Where it rests just now, and whether more pushes there are of use; empty where it does not rest."""
    if report.rest is None:
        return ""
    useful = report.useful_pushes
    pushes = _pushes(useful) if useful else "no push"
    worth = "" if useful is None else f"; {pushes} more there would tell much that is new"
    return f"It rests near {directions(report.rest.directions)} since push {report.rest.began}{worth}."


def coverage_sentence(report: BiasReport) -> str:
    """How much of the circle is covered, and what that is worth."""
    count, effective = report.push + 1, report.coverage.effective_pushes
    worth = f"worth {effective:.{int(effective < 10.0)}f} spread evenly ({report.recent_worth:.2f} a push lately)"
    return f"{covered(report.coverage)}; the {_pushes(count)} {'is' if count == 1 else 'are'} {worth}."


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
    return f"{10.0 ** max(log10, 0.0):.3g}" if log10 < 6.0 else power_of_ten(round(log10))
