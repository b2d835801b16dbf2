"""`cyclemap watch`: a collection watched for locking in, once over a whole file or as the file grows."""

import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import click

from cyclemap.cli.json_numbers import degrees, direction_deg, number
from cyclemap.cli.json_report import Json
from cyclemap.cli.options import LoopOptions
from cyclemap.cli.output import file_stem, progress_bar, publish_json, write_json
from cyclemap.cli.settings import chosen_collection
from cyclemap.cli.terminal import PeopleConsole
from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap
from cyclemap.resets import (
    Alarm,
    BiasReport,
    CoverageState,
    CycleAction,
    NextAction,
    ResetStrategy,
    Rest,
    next_action,
    strategy_maps,
)
from cyclemap.resets.monitor.bias_monitor import WatchedCollection, WatchedCourse
from cyclemap.resets.monitor.theta0_feed import NewOrientations, theta0_feed
from cyclemap.views import watch_sentences as sentences
from cyclemap.views.reset_sentences import action_words
from cyclemap.views.style import render
from cyclemap.views.watch_page import watch_page
from cyclemap.whole_files import write_whole

# Shares of the circle whose covering is told.
TOLD_SHARES = 10
# Radians: of the maps that tell the next action, far below what recorded directions are told apart by.
_TOLERANCE = 1e-3


@dataclass(frozen=True)
class Followed:
    """The strategy that a collection follows, and the map of each of its actions."""

    strategy: ResetStrategy
    maps: tuple[CircleMap, ...]


Chosen = tuple[CycleAction, NextAction]


@dataclass(frozen=True)
class WatchRequest:
    """What is asked of the watch: the file, the alarm rate, whether to wait for more, and where results go.

    protocol, material : of the strategy whose next action is told; None for no such advice.
    """

    file: Path
    alarm_rate: float
    follow: bool
    every: float
    out: Path
    picture_format: str
    protocol: Path | None = None
    material: str | None = None


def run_watch(request: WatchRequest, json_target: str | None) -> None:
    """Watch the file, write picture and JSON, and print for people or as JSON."""
    if request.follow:
        _follow(request, _strategy_to_follow(request.protocol, request.material), json_target)
        return
    watched = WatchedCollection(request.alarm_rate)
    found = theta0_feed(request.file).look(finished=True).theta
    followed = _strategy_to_follow(request.protocol, request.material)
    with progress_bar(f"watching {request.file.name}") as report:
        for done, theta in enumerate(found, 1):
            watched.add(theta)
            report(done / len(found))
    _conclude(request, watched, followed, json_target)


def _follow(request: WatchRequest, followed: Followed | None, json_target: str | None) -> None:
    """Look for new rows until interrupted or anything fails; the last report is kept, what ended the watch goes on."""
    tell = _tell_as_json if json_target == "-" else _tell_people
    feed, watched = theta0_feed(request.file), WatchedCollection(request.alarm_rate)
    if json_target != "-":
        click.echo(f"watching {request.file} until interrupted (Ctrl-C)", err=True)
    try:
        while True:
            found = feed.look()
            if found.began_anew:
                click.echo(f"{request.file} began anew, and so does the watch", err=True)
                watched = WatchedCollection(request.alarm_rate)
            _take(watched, followed, found, tell)
            time.sleep(request.every)
    finally:
        if watched.pushes:
            _conclude(request, watched, followed, json_target, quiet=json_target == "-")


def _take(
    watched: WatchedCollection, followed: Followed | None, found: NewOrientations, tell: Callable[..., None]
) -> None:
    """Feed what was found, and tell about each push."""
    before = watched.monitor.report
    for theta in found.theta:
        after = watched.add(theta)
        tell(before, after, theta, _chosen(watched, followed))
        before = after


def _chosen(watched: WatchedCollection, followed: Followed | None) -> Chosen | None:
    """What to do next, and where that leads; None where no strategy is followed."""
    if followed is None:
        return None
    found = next_action(followed.maps, watched.monitor.coverage, watched.monitor.path[-1])
    return followed.strategy.actions[found.number], found


def _strategy_to_follow(protocol: Path | None, material: str | None) -> Followed | None:
    """The protocol's strategy and its maps; InvalidInput where it leaves nothing to choose, or has no protocol."""
    if protocol is None:
        if material is not None:
            raise InvalidInput(f"--material {material} is for --protocol: give the protocol, too, or leave both out")
        return None
    chosen = chosen_collection(LoopOptions(material, protocol, ()))
    if chosen.strategy is None or len(chosen.strategy.actions) == 1:
        raise InvalidInput(f"{protocol}: there is no action to choose: it needs a [strategy] of two actions or more")
    with progress_bar(f"cycle maps on {chosen.loop.material.name}") as report:
        maps = strategy_maps(chosen.loop, chosen.strategy, tolerance=_TOLERANCE, progress=report)
    return Followed(chosen.strategy, maps)


def _tell_as_json(before: BiasReport, after: BiasReport, theta: float, chosen: Chosen | None) -> None:
    click.echo(json.dumps(push_report(after, theta, chosen), allow_nan=False, ensure_ascii=False))


def _tell_people(before: BiasReport, after: BiasReport, theta: float, chosen: Chosen | None) -> None:
    """A line where something changed: an alarm, a rest that began or ended after it, another tenth of the circle.

    And one for each push that a strategy answers.
    """
    for line in _news(before, after):
        click.echo(f"push {after.push}: {line}")
    if chosen is not None:
        click.echo(f"push {after.push}: {sentences.next_action_sentence(*chosen)}")


def _news(before: BiasReport, after: BiasReport) -> list[str]:
    news = []
    if after.alarm is not None and before.alarm is None:
        news += [sentences.alarm_sentence(after.alarm), sentences.advice_sentence(after)]
    elif after.alarm is not None and (after.rest is None) != (before.rest is None):
        news.append(sentences.rest_sentence(after) or "θ0 moves on.")
    if int(TOLD_SHARES * after.coverage.covered) > int(TOLD_SHARES * before.coverage.covered):
        news.append(f"{sentences.covered(after.coverage)}.")
    return news


def _conclude(
    request: WatchRequest,
    watched: WatchedCollection,
    followed: Followed | None,
    json_target: str | None,
    quiet: bool = False,
) -> None:
    """Write the picture and the JSON, and print the report, unless ``quiet``."""
    course, name, chosen = watched.course(), request.file.name, _chosen(watched, followed)
    report = watch_report(course, name, chosen)
    stem = f"watch_{file_stem(request.file.stem)}"
    write_json(request.out / f"{stem}.json", report)
    picture = request.out / f"{stem}.{request.picture_format}"
    write_whole(picture, render(watch_page(course, name), request.picture_format))
    if quiet or publish_json(report, json_target):
        return
    console = PeopleConsole()
    for place, sentence in enumerate(sentences.watch_sentences(course)):
        console.print(sentence, style=None if place else "bold")
    if chosen is not None:
        console.print(sentences.next_action_sentence(*chosen))
    console.print(f"picture: {picture}")


def watch_report(course: WatchedCourse, name: str, chosen: Chosen | None = None) -> Json:
    """The report on a whole collection; ``name`` : of its file; ``chosen`` : what its strategy should do next."""
    return {
        "file": name,
        "pushes": course.pushes,
        "alarm_rate": course.alarm_rate,
        **bias_report_json(course.report),
        **_next(chosen),
    }


def push_report(report: BiasReport, theta: float, chosen: Chosen | None = None) -> Json:
    """The report after one push of θ0 (rad)."""
    return {"push": report.push, "theta0_deg": direction_deg(theta), **bias_report_json(report), **_next(chosen)}


def _next(chosen: Chosen | None) -> Json:
    """What to do next; nothing where no strategy is followed."""
    if chosen is None:
        return {}
    action, found = chosen
    about = {"name": action_words(action), "lands_deg": direction_deg(found.lands)}
    return {"next_action": {"number": found.number, **about, "crowding": number(found.crowding)}}


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
