"""The report of `cyclemap watch` as JSON: degrees, pushes counted from 0."""

from cyclemap.cli.json_numbers import degrees, direction_deg, number
from cyclemap.cli.json_report import Json
from cyclemap.resets.monitor.bias_report import Alarm, BiasReport
from cyclemap.resets.monitor.coverage import CoverageState
from cyclemap.resets.monitor.forecast import Forecast
from cyclemap.resets.monitor.next_action import NextAction
from cyclemap.resets.monitor.rest_direction import Rest
from cyclemap.resets.monitor.watched_collection import WatchedCourse
from cyclemap.views.strategy_words import action_words


def watch_report(course: WatchedCourse, name: str, chosen: NextAction | None = None) -> Json:
    """The report on a whole collection; ``name`` : of its file; ``chosen`` : what its strategy should do next."""
    return {
        "file": name,
        "pushes": course.pushes,
        "alarm_rate": course.alarm_rate,
        **bias_report_json(course.report),
        "forecast": None if course.forecast is None else _forecast(course.forecast),
        **_next(chosen),
    }


def push_report(report: BiasReport, theta: float, chosen: NextAction | None = None) -> Json:
    """The report after one push of θ0 (rad)."""
    return {"push": report.push, "theta0_deg": direction_deg(theta), **bias_report_json(report), **_next(chosen)}


def _next(chosen: NextAction | None) -> Json:
    """What to do next; nothing where no strategy is followed."""
    if chosen is None:
        return {}
    about = {"name": action_words(chosen.action), "lands_deg": direction_deg(chosen.lands)}
    return {"next_action": {"number": chosen.number, **about, "crowding": number(chosen.crowding)}}


def bias_report_json(report: BiasReport) -> Json:
    """What the monitor tells, without the push it tells it after."""
    return {
        "alarm": None if report.alarm is None else _alarm(report.alarm),
        "evidence": {
            "rest_log10": number(report.rest_evidence),
            "visits_log10": number(report.visit_evidence),
            "threshold_log10": number(report.threshold),
        },
        "rest": None if report.rest is None else _rest(report.rest),
        "useful_pushes": report.useful_pushes,
        "recent_worth": number(report.recent_worth),
        "coverage": _coverage(report.coverage),
        "advice": {
            "change_reset": report.advice.change_reset,
            "direction_deg": direction_deg(report.advice.direction),
        },
    }


def _alarm(alarm: Alarm) -> Json:
    return {
        "push": alarm.push,
        "kind": alarm.kind,
        "directions_deg": [direction_deg(theta) for theta in alarm.directions],
        "began": alarm.began,
    }


def _rest(rest: Rest) -> Json:
    return {
        "began": rest.began,
        "directions_deg": [direction_deg(theta) for theta in rest.directions],
        "towards_deg": [direction_deg(theta) for theta in rest.towards],
    }


def _coverage(state: CoverageState) -> Json:
    return {
        "covered": number(state.covered),
        "largest_gap_deg": degrees(state.largest_gap),
        "gap_centre_deg": direction_deg(state.gap_centre),
        "effective_pushes": number(state.effective_pushes),
        "gain": number(state.gain),
    }


def _forecast(forecast: Forecast) -> Json:
    """Where a median is beyond the look ahead, it is null."""
    return {
        "ahead": forecast.ahead,
        "noise_deg": degrees(forecast.fitted.sigma),
        "worth": number(forecast.worth),
        "pushes_to_leave": number(forecast.pushes_to_leave),
        "cover_target": number(forecast.cover_target),
        "pushes_to_cover": number(forecast.pushes_to_cover),
    }
