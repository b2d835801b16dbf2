"""`cyclemap watch`: a collection watched for locking in, once over a whole file or as the file
grows; `cyclemap audit`: what a data set that exists is worth.
"""

import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import click

from cyclemap.cli.collected.readable_data import readable_data, tell_what_was_read
from cyclemap.cli.commands import AuditOptions, WatchOptions
from cyclemap.cli.options import ResultOptions, is_said
from cyclemap.cli.output import (
    PeopleConsole,
    data_stem,
    progress_bar,
    publish,
    publish_json,
    write_result,
)
from cyclemap.collection.lock_forecast import forecast_from_turns, sampled_turns, turns_after_log
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import noises_of
from cyclemap.errors import InvalidInput
from cyclemap.evidence.tables.columns import convention_of
from cyclemap.maps import rest_multiplier
from cyclemap.protocol.chosen_loop import chosen_collection, loop_beside, strategy_file
from cyclemap.resets import (
    BiasMonitor,
    BiasReport,
    next_action,
    strategy_maps,
    watch,
)
from cyclemap.resets.audit import audit
from cyclemap.resets.theta0_feed import check_feed, theta0_feed
from cyclemap.views import watch_page as page
from cyclemap.views.reset_page import action_words
from cyclemap.views.sentences import ahead_sentence, multiplier_sentence
from cyclemap.views.watch_page import audit_headline, audit_page, audit_paragraph
from cyclemap.written import Json, degrees, direction_deg, json_of, written

# Shares of the circle whose covering is told; rad, of the maps that tell the next action, far below
# what is recorded.
_TOLD_SHARES = 10
_TOLERANCE = 1e-3
# Pushes of a forecast from where the log stands: some hours of the robot's work.
_PUSHES_AHEAD = 300


# The next action of a strategy, or what the next pushes of a loop bring: as JSON, and in words.
Ahead = tuple[Json, str]
LookAhead = Callable[[BiasMonitor], Ahead]


def run_watch(asked: WatchOptions) -> None:
    """Watch the file to its end, or as it grows, and tell what is seen."""
    file = asked.file
    table = asked.table
    results = asked.results
    convention = convention_of(file, **table.convention)
    feed = theta0_feed(file, table.named_columns, table.named_units, convention)
    monitor = BiasMonitor(asked.alarm_rate)
    reports = list[BiasReport]()
    if not asked.follow:
        if is_said("every"):
            raise InvalidInput(f"--every {asked.every:g}: only --follow looks again; add it")
        news = feed.look(finished=True)
        loop = loop_beside(file)
        check_feed(file, table.named_columns, table.named_units, loop=loop, **table.convention)
        look_ahead = _ahead_of(asked)
        tell_what_was_read(news.words, news.guessed)
        _conclude(file, monitor, watch(news.theta, monitor), look_ahead, results)
        return
    look_ahead = _ahead_of(asked)
    as_json = results.json == "-"
    if not as_json:
        click.echo(f"watching {file} until interrupted (Ctrl-C)", err=True)
    try:
        while True:
            news = feed.look()
            if not reports:
                tell_what_was_read(news.words, news.guessed)
            if news.began_anew:
                click.echo(f"{file} began anew, and so does the watch", err=True)
                monitor = BiasMonitor(asked.alarm_rate)
                reports = []
            for left, theta in zip(reversed(range(len(news.theta))), news.theta, strict=True):
                before = monitor.report
                reports.append(monitor.update(theta))
                # From orientations that were left long ago nothing is ahead.
                ahead = ({}, "") if left else look_ahead(monitor)
                _tell(before, reports[-1], theta, ahead, as_json)
            time.sleep(asked.every)
    finally:
        # However following ends the last report is kept, and what ended it goes on.
        if reports:
            _conclude(file, monitor, reports, look_ahead, results, quiet=as_json)


def _ahead_of(asked: WatchOptions) -> LookAhead:
    """What tells what is ahead; InvalidInput where surface and protocol leave nothing to tell."""
    if asked.protocol is None and asked.material is None:
        return lambda monitor: ({}, "")
    chosen = chosen_collection(asked.material, asked.protocol, data=asked.file).simplified()
    loop = chosen.loop
    strategy = chosen.strategy
    if strategy is None:
        return _forecasts(loop, chosen.sigma)
    if len(strategy.actions) == 1:
        raise InvalidInput(
            f"{strategy_file(asked.material, asked.protocol)}: there is no action to choose: it "
            "needs a [strategy] of two actions or more"
        )
    with progress_bar(f"cycle maps on {loop.material.name}") as report:
        maps = strategy_maps(loop, strategy, tolerance=_TOLERANCE, progress=report)

    def choose(monitor: BiasMonitor) -> Ahead:
        chosen_action = next_action(maps, monitor.coverage, monitor.path[-1])
        action = strategy.actions[chosen_action.number]
        report: Json = {
            "next_action": {
                "number": chosen_action.number,
                "name": action_words(action),
                **json_of(chosen_action, "lands", "crowding"),
            }
        }
        return report, page.next_action_sentence(action, chosen_action)

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
        ahead = forecast_from_turns(
            logged.turns, logged.sigma, _PUSHES_AHEAD, start, change=logged.change
        )
        return {"forecast": json_of(ahead)}, ahead_sentence(ahead, start)

    return forecast


def _tell(before: BiasReport, after: BiasReport, theta: float, ahead: Ahead, as_json: bool) -> None:
    """A line of JSON; or what changed: alarm, rest, another tenth of the circle;
    and what is ahead."""
    report, words = ahead
    if as_json:
        line_of_json = {
            "push": after.push,
            "theta0_deg": direction_deg(theta),
            **_report(after),
            **report,
        }
        click.echo(json.dumps(line_of_json, allow_nan=False, ensure_ascii=False))
        return
    news: list[str] = []
    if after.alarm is not None and before.alarm is None:
        news += [page.alarm_sentence(after.alarm), page.advice_sentence(after)]
    elif after.alarm is not None and (after.rest is None) != (before.rest is None):
        news.append(page.rest_sentence(after) or "θ0 moves on.")
    if int(_TOLD_SHARES * after.coverage.covered) > int(_TOLD_SHARES * before.coverage.covered):
        news.append(f"{page.covered(after.coverage)}.")
    for line in filter(None, (*news, words)):
        click.echo(f"push {after.push}: {line}")


def _conclude(
    file: Path,
    monitor: BiasMonitor,
    reports: Sequence[BiasReport],
    look_ahead: LookAhead,
    results: ResultOptions,
    quiet: bool = False,
) -> None:
    """Write the picture and the JSON, and print the report, unless ``quiet``."""
    last = reports[-1]
    report, words = look_ahead(monitor)
    rest = rest_multiplier(monitor.path)
    as_json = {
        "file": file.name,
        "pushes": len(reports),
        "alarm_rate": monitor.alarm_rate,
        **_report(last),
        **report,
        "multiplier": written(rest),
    }
    figure = page.watch_page(monitor, reports, file.name)
    picture = write_result(as_json, figure, results, f"watch_{data_stem(file)}")
    if quiet or publish_json(as_json, results.json):
        return
    PeopleConsole().tell(
        *page.watch_sentences(last),
        multiplier_sentence(rest),
        words,
        f"picture: {picture}",
    )


def _report(state: BiasReport) -> Json:
    """What the monitor tells."""
    return {
        **json_of(state, "alarm"),
        "evidence": json_of(state, "rest_evidence", "visit_evidence", "threshold"),
        **json_of(state, "rest", "useful_pushes", "recent_worth", "coverage", "advice"),
    }


def run_audit(asked: AuditOptions) -> None:
    """Audit the data, draw it, and print the paragraph for its card, or all of it as JSON."""
    data = asked.data
    read = readable_data(data, asked.table, asked.results.out)
    with progress_bar(f"auditing {data.name}") as progress:
        audited = audit(read, loop=loop_beside(data), progress=progress)
    alarm = audited.report.alarm
    reset = audited.reset
    as_json = {
        "data": str(data),
        "headline": audit_headline(audited),
        "paragraph": audit_paragraph(audited),
        "pushes": len(audited.theta),
        **json_of(audited, "others", "ordered", "covered"),
        "covered_share": audited.report.coverage.covered,
        "locked_from": audited.locked_from,
        "locked_towards_deg": [] if alarm is None else [*map(direction_deg, alarm.directions)],
        "worth": audited.worth,
        "reset": None
        if reset is None
        else {
            "push_turn_deg": degrees(reset.push_turn.mean()),
            "reset_turn_deg": degrees(reset.reset_turn.mean()),
            **json_of(reset, "undone", "slope"),
        },
        "good": audited.is_good,
    }
    publish(
        as_json,
        audit_page(audited),
        asked.results,
        f"audit_{data_stem(data)}",
        audit_headline(audited),
        audit_paragraph(audited),
    )
