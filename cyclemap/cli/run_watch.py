"""`cyclemap watch`: a collection watched for locking in, once over a whole file or as the file
grows.
"""

import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.json_report import (
    Json,
    degrees,
    direction_deg,
    forecast_report,
    multiplier_report,
    number,
    numbers_of,
)
from cyclemap.cli.options import TableOptions, tell_what_was_read, told_columns
from cyclemap.cli.output import PeopleConsole, file_stem, progress_bar, publish
from cyclemap.collection.lock_forecast import LockForecast, forecast_from_turns, sampled_turns
from cyclemap.collection.logged_turns import turns_after_log
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import noises_of
from cyclemap.errors import InvalidInput
from cyclemap.evidence.pushes.conventions import convention_of
from cyclemap.maps import rest_multiplier
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_collection
from cyclemap.resets import (
    BiasMonitor,
    BiasReport,
    CycleAction,
    NextAction,
    next_action,
    strategy_maps,
    watch,
)
from cyclemap.resets.monitor.theta0_feed import theta0_feed
from cyclemap.views import watch_page as page
from cyclemap.views.reset_page import action_words
from cyclemap.views.sentences import ahead_sentence, multiplier_sentence

# What is ahead: the next action of a strategy, or what the next pushes of a loop will bring; None
# for neither.
Ahead = tuple[CycleAction, NextAction] | LockForecast | None
LookAhead = Callable[[BiasMonitor], Ahead]
# Shares of the circle whose covering is told; rad, of the maps that tell the next action, far below
# what is recorded.
_TOLD_SHARES, _TOLERANCE = 10, 1e-3
# Pushes of a forecast from where the log stands: some hours of the robot's work.
_PUSHES_AHEAD = 300


def run_watch(
    file: Path,
    alarm_rate: float,
    follow: bool,
    every: float,
    protocol: Path | None,
    material: str | None,
    table: TableOptions,
    **results: Any,
) -> None:
    """Watch the file to its end, or as it grows, and tell what is seen."""
    columns, units = told_columns(table.columns, table.units)
    feed = theta0_feed(file, columns, units, convention_of(file, **table.convention))
    monitor, reports = BiasMonitor(alarm_rate), list[Any]()
    if not follow:
        found, look_ahead = feed.look(finished=True), _ahead_of(file, protocol, material)
        tell_what_was_read(found.words, found.guessed)
        _conclude(file, monitor, watch(found.theta, monitor), look_ahead, **results)
        return
    look_ahead, as_json = _ahead_of(file, protocol, material), results["json_target"] == "-"
    if not as_json:
        click.echo(f"watching {file} until interrupted (Ctrl-C)", err=True)
    try:
        while True:
            found = feed.look()
            if not reports:
                tell_what_was_read(found.words, found.guessed)
            if found.began_anew:
                click.echo(f"{file} began anew, and so does the watch", err=True)
                monitor, reports = BiasMonitor(alarm_rate), []
            for left, theta in zip(reversed(range(len(found.theta))), found.theta, strict=True):
                before = monitor.report
                reports.append(monitor.update(theta))
                # From orientations that were left long ago nothing is ahead.
                ahead = None if left else look_ahead(monitor)
                _tell(before, reports[-1], theta, ahead, as_json)
            time.sleep(every)
    finally:
        # However following ends the last report is kept, and what ended it goes on.
        if reports:
            _conclude(file, monitor, reports, look_ahead, **results, quiet=as_json)


def _ahead_of(file: Path, protocol: Path | None, material: str | None) -> LookAhead:
    """What tells what is ahead; InvalidInput where surface and protocol leave nothing to tell."""
    if protocol is None and material is None:
        return lambda monitor: None
    chosen = chosen_collection(LoopOptions(material, protocol, ()), file).simplified()
    loop, strategy = chosen.loop, chosen.strategy
    if strategy is None:
        return _forecasts(loop, chosen.sigma)
    if len(strategy.actions) == 1:
        raise InvalidInput(
            f"{protocol}: there is no action to choose: it needs a [strategy] of two actions or "
            "more"
        )
    with progress_bar(f"cycle maps on {loop.material.name}") as report:
        maps = strategy_maps(loop, strategy, tolerance=_TOLERANCE, progress=report)

    def choose(monitor: BiasMonitor) -> Ahead:
        found = next_action(maps, monitor.coverage, monitor.path[-1])
        return strategy.actions[found.number], found

    return choose


def _forecasts(loop: CollectionLoop, sigma: float | None) -> LookAhead:
    """Forecasts from the last orientation, by the map that the log shows joined with what is
    believed; the maps of the samples, nearly all of the work, are computed once.
    """
    material = loop.material
    if material.posterior is None or material.wear is not None:
        why = (
            "has no samples of what is believed of it"
            if material.posterior is None
            else "wears as it is used"
        )
        raise InvalidInput(
            f"{material.name} {why}: there is no forecast of it, and without a [strategy] of two "
            "actions or more in --protocol there is no action to choose; leave --material and "
            "--protocol out"
        )
    with progress_bar(f"cycle maps of what is believed of {material.name}") as report:
        turns = sampled_turns(loop, report)
    noise, _ = noises_of(loop, loop.circle_map(_TOLERANCE), sigma)

    def forecast(monitor: BiasMonitor) -> Ahead:
        logged = turns_after_log(turns, monitor.path, noise.sigma, _PUSHES_AHEAD)
        start = float(monitor.path[-1])
        return forecast_from_turns(
            logged.turns, logged.sigma, _PUSHES_AHEAD, start, change=logged.change
        )

    return forecast


def _tell(before: BiasReport, after: BiasReport, theta: float, ahead: Ahead, as_json: bool) -> None:
    """A line of JSON; or what changed: alarm, rest, another tenth of the circle;
    and what is ahead."""
    if as_json:
        told = {"push": after.push, "theta0_deg": direction_deg(theta), **_report(after, ahead)}
        click.echo(json.dumps(told, allow_nan=False, ensure_ascii=False))
        return
    news: list[str] = []
    if after.alarm is not None and before.alarm is None:
        news += [page.alarm_sentence(after.alarm), page.advice_sentence(after)]
    elif after.alarm is not None and (after.rest is None) != (before.rest is None):
        news.append(page.rest_sentence(after) or "θ0 moves on.")
    if int(_TOLD_SHARES * after.coverage.covered) > int(_TOLD_SHARES * before.coverage.covered):
        news.append(f"{page.covered(after.coverage)}.")
    for line in (*news, *_ahead_sentences(ahead, theta)):
        click.echo(f"push {after.push}: {line}")


def _ahead_sentences(ahead: Ahead, theta: float) -> tuple[str, ...]:
    """What to do next, or what the next pushes will bring, from the last orientation (rad) on."""
    if ahead is None:
        return ()
    if isinstance(ahead, LockForecast):
        return (ahead_sentence(ahead, theta),)
    return (page.next_action_sentence(*ahead),)


def _conclude(
    file: Path,
    monitor: BiasMonitor,
    reports: Sequence[BiasReport],
    look_ahead: LookAhead,
    out: Path,
    picture_format: str,
    json_target: str | None,
    quiet: bool = False,
) -> None:
    """Write the picture and the JSON, and print the report, unless ``quiet``."""
    last, ahead, rest = reports[-1], look_ahead(monitor), rest_multiplier(monitor.path)
    told = {
        "file": file.name,
        "pushes": len(reports),
        "alarm_rate": monitor.alarm_rate,
        **_report(last, ahead),
    }
    told["multiplier"] = multiplier_report(rest)
    figure, stem = (
        page.watch_page(monitor, reports, file.name),
        out / f"watch_{file_stem(file.stem)}",
    )
    picture = publish(told, figure, stem, picture_format, None if quiet else json_target)
    if picture is not None and not quiet:
        following = _ahead_sentences(ahead, monitor.path[-1])
        lines = (
            *page.watch_sentences(last),
            multiplier_sentence(rest),
            *following,
            f"picture: {picture}",
        )
        PeopleConsole().tell(*filter(None, lines))


def _report(report: BiasReport, ahead: Ahead) -> Json:
    """What the monitor tells, and what is ahead."""
    alarm, rest, state, advice = report.alarm, report.rest, report.coverage, report.advice
    told: Json = {
        "alarm": None,
        "evidence": {
            "rest_log10": number(report.rest_evidence),
            "visits_log10": number(report.visit_evidence),
            "threshold_log10": number(report.threshold),
        },
        "rest": None,
        "useful_pushes": report.useful_pushes,
        "recent_worth": number(report.recent_worth),
        "coverage": {
            **numbers_of(state, "covered", "effective_pushes", "gain"),
            "largest_gap_deg": degrees(state.largest_gap),
            "gap_centre_deg": direction_deg(state.gap_centre),
        },
        "advice": {
            "change_reset": advice.change_reset,
            "direction_deg": direction_deg(advice.direction),
        },
    }
    if alarm is not None:
        where = [*map(direction_deg, alarm.directions)]
        told["alarm"] = {
            "push": alarm.push,
            "kind": alarm.kind,
            "directions_deg": where,
            "began": alarm.began,
        }
    if rest is not None:
        where, towards = (
            [*map(direction_deg, angles)] for angles in (rest.directions, rest.towards)
        )
        told["rest"] = {"began": rest.began, "directions_deg": where, "towards_deg": towards}
    if isinstance(ahead, LockForecast):
        told["forecast"] = forecast_report(ahead)
    elif ahead is not None:
        action, found = ahead
        lands = {"lands_deg": direction_deg(found.lands), "crowding": number(found.crowding)}
        told["next_action"] = {"number": found.number, "name": action_words(action), **lands}
    return told
