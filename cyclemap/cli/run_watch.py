"""`cyclemap watch`: a collection watched for locking in, once over a whole file or as the file grows."""

import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import click

from cyclemap.cli.output import file_stem, progress_bar, publish_json, write_json
from cyclemap.cli.terminal import PeopleConsole
from cyclemap.cli.watch_report import push_report, watch_report
from cyclemap.cli.watched_strategy import strategy_to_follow
from cyclemap.resets.monitor.bias_report import BiasReport
from cyclemap.resets.monitor.next_action import NextAction, next_action
from cyclemap.resets.monitor.theta0_feed import NewOrientations, theta0_feed
from cyclemap.resets.monitor.watched_collection import WatchedCollection
from cyclemap.resets.strategies.strategy_maps import StrategyMaps
from cyclemap.views import watch_sentences as sentences
from cyclemap.views.style import render
from cyclemap.views.watch_page import watch_page
from cyclemap.whole_files import write_whole

# Shares of the circle whose covering is told.
TOLD_SHARES = 10


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
        _follow(request, strategy_to_follow(request.protocol, request.material), json_target)
        return
    watched = WatchedCollection(request.alarm_rate)
    found = theta0_feed(request.file).look(finished=True).theta
    maps = strategy_to_follow(request.protocol, request.material)
    with progress_bar(f"watching {request.file.name}") as report:
        for done, theta in enumerate(found, 1):
            watched.add(theta)
            report(done / len(found))
    _conclude(request, watched, maps, json_target)


def _follow(request: WatchRequest, maps: StrategyMaps | None, json_target: str | None) -> None:
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
            _take(watched, maps, found, tell)
            time.sleep(request.every)
    finally:
        if watched.pushes:
            _conclude(request, watched, maps, json_target, quiet=json_target == "-")


def _take(
    watched: WatchedCollection, maps: StrategyMaps | None, found: NewOrientations, tell: Callable[..., None]
) -> None:
    """Feed what was found, and tell about each push."""
    before = watched.monitor.report
    for theta in found.theta:
        after = watched.add(theta)
        tell(before, after, theta, _chosen(watched, maps))
        before = after


def _chosen(watched: WatchedCollection, maps: StrategyMaps | None) -> NextAction | None:
    return None if maps is None else next_action(maps, watched.monitor.coverage, watched.monitor.path[-1])


def _tell_as_json(before: BiasReport, after: BiasReport, theta: float, chosen: NextAction | None) -> None:
    click.echo(json.dumps(push_report(after, theta, chosen), allow_nan=False, ensure_ascii=False))


def _tell_people(before: BiasReport, after: BiasReport, theta: float, chosen: NextAction | None) -> None:
    """A line where something changed: an alarm, a rest that began or ended after it, another tenth of the circle.

    And one for each push that a strategy answers.
    """
    for line in _news(before, after):
        click.echo(f"push {after.push}: {line}")
    if chosen is not None:
        click.echo(f"push {after.push}: {sentences.next_action_sentence(chosen)}")


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
    maps: StrategyMaps | None,
    json_target: str | None,
    quiet: bool = False,
) -> None:
    """Write the picture and the JSON, and print the report, unless ``quiet``."""
    course, name, chosen = watched.course(), request.file.name, _chosen(watched, maps)
    report = watch_report(course, name, chosen)
    stem = f"watch_{file_stem(request.file.stem)}"
    write_json(request.out / f"{stem}.json", report)
    picture = request.out / f"{stem}.{request.picture_format}"
    write_whole(picture, render(watch_page(course, name), request.picture_format))
    if quiet or publish_json(report, json_target):
        return
    console = PeopleConsole()
    for number, sentence in enumerate(sentences.watch_sentences(course)):
        console.print(sentence, style=None if number else "bold")
    if chosen is not None:
        console.print(sentences.next_action_sentence(chosen))
    console.print(f"picture: {picture}")
