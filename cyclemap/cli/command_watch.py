"""The command `cyclemap watch`: a collection watched for locking in, once over a whole file or as the file grows."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cyclemap.cli.options import LoopOptions, Real, decorated, result_options
from cyclemap.errors import InvalidInput

if TYPE_CHECKING:
    from cyclemap.cli.json_report import Json
    from cyclemap.resets import BiasMonitor, BiasReport, CycleAction, NextAction

    Chosen = tuple[CycleAction, NextAction]
    Choose = Callable[[BiasMonitor], Chosen | None]

SHORTEST_WAIT, LONGEST_WAIT = 0.01, 86400.0
_WAITS = f"{SHORTEST_WAIT:g} to {LONGEST_WAIT:g}"
# Shares of the circle whose covering is told.
_TOLD_SHARES = 10
# Radians: of the maps that tell the next action, far below what recorded directions are told apart by.
_TOLERANCE = 1e-3


def _wait(context: click.Context, option: click.Parameter, seconds: float) -> float:
    """Refuse what no clock can wait for; a range would let nan pass."""
    if not (math.isfinite(seconds) and SHORTEST_WAIT <= seconds <= LONGEST_WAIT):
        raise click.BadParameter(f"{seconds:g} is no wait; give a finite number of {_WAITS} seconds")
    return seconds


def _watch_options(command: Callable[..., None]) -> Callable[..., None]:
    rate = "Chance of ever raising an alarm where turns do not depend on θ0 and θ0 does not linger."
    again = f"How often --follow looks for new rows: every {_WAITS} seconds."
    share, toml = Real(min=0.0, max=1.0, min_open=True, max_open=True), click.Path(path_type=Path)
    waits: dict[str, Any] = {"metavar": "SECONDS", "type": Real(), "callback": _wait, "help": again}
    actions = "Protocol with a [strategy]: which of its actions to take next."
    surface = "With --protocol: name or TOML file of the surface. [default: isotropic]"
    waiting = "Wait for new rows, and tell what changes, until interrupted (Ctrl-C)."
    decorators: list[Callable[[Any], Any]] = [
        click.argument("file", type=click.Path(path_type=Path)),
        click.option("--alarm-rate", type=share, default=0.01, show_default=True, help=rate),
        click.option("--follow", is_flag=True, help=waiting),
        click.option("--every", default=1.0, show_default=True, **waits),
        click.option("--protocol", metavar="TOML", type=toml, help=actions),
        click.option("--material", metavar="MATERIAL", help=surface),
        result_options("watch_FILE.png and .json"),
    ]
    return decorated(command, decorators)


@click.command("watch")
@_watch_options
def watch_command(
    file: Path,
    alarm_rate: float,
    follow: bool,
    every: float,
    protocol: Path | None,
    material: str | None,
    **results: Any,
) -> None:
    """Watch a collection of θ0 for locking in: FILE is a CSV with theta0_deg in order, or a folder of MIT pushes.

    With --protocol it also tells which action of the strategy takes the object to where least is recorded. With
    --follow, `--json -` prints a line of JSON for each push.
    """
    from cyclemap.cli.output import progress_bar
    from cyclemap.resets import BiasMonitor
    from cyclemap.resets.monitor.theta0_feed import theta0_feed

    feed, monitor, reports = theta0_feed(file), BiasMonitor(alarm_rate), list[Any]()
    if not follow:
        recorded, choose = feed.look(finished=True).theta, _chooser(protocol, material)
        with progress_bar(f"watching {file.name}") as report:
            for done, theta in enumerate(recorded, 1):
                reports.append(monitor.update(theta))
                report(done / len(recorded))
        _conclude(file, monitor, reports, choose(monitor), **results)
        return
    choose, as_json = _chooser(protocol, material), results["json_target"] == "-"
    if not as_json:
        click.echo(f"watching {file} until interrupted (Ctrl-C)", err=True)
    try:
        while True:
            found = feed.look()
            if found.began_anew:
                click.echo(f"{file} began anew, and so does the watch", err=True)
                monitor, reports = BiasMonitor(alarm_rate), []
            for theta in found.theta:
                before = monitor.report
                reports.append(monitor.update(theta))
                _tell(before, reports[-1], theta, choose(monitor), as_json)
            time.sleep(every)
    finally:
        # However following ends the last report is kept, and what ended it goes on.
        if reports:
            _conclude(file, monitor, reports, choose(monitor), **results, quiet=as_json)


def _chooser(protocol: Path | None, material: str | None) -> Choose:
    """What tells the protocol's next action; InvalidInput where it leaves nothing to choose, or has no protocol."""
    if protocol is None:
        if material is not None:
            raise InvalidInput(f"--material {material} is for --protocol: give the protocol, too, or leave both out")
        return lambda monitor: None
    from cyclemap.cli.output import progress_bar
    from cyclemap.cli.settings import chosen_collection
    from cyclemap.resets import next_action, strategy_maps

    chosen = chosen_collection(LoopOptions(material, protocol, ()))
    if chosen.strategy is None or len(chosen.strategy.actions) == 1:
        raise InvalidInput(f"{protocol}: there is no action to choose: it needs a [strategy] of two actions or more")
    actions = chosen.strategy.actions
    with progress_bar(f"cycle maps on {chosen.loop.material.name}") as report:
        maps = strategy_maps(chosen.loop, chosen.strategy, tolerance=_TOLERANCE, progress=report)

    def choose(monitor: BiasMonitor) -> Chosen:
        found = next_action(maps, monitor.coverage, monitor.path[-1])
        return actions[found.number], found

    return choose


def _tell(before: BiasReport, after: BiasReport, theta: float, chosen: Chosen | None, as_json: bool) -> None:
    """A line of JSON; or one where something changed: an alarm, a rest that began or ended after it, another tenth of
    the circle; and one for each push that a strategy answers."""
    from cyclemap.cli.json_report import direction_deg
    from cyclemap.views import watch_sentences as sentences

    if as_json:
        told = {"push": after.push, "theta0_deg": direction_deg(theta), **_report(after, chosen)}
        click.echo(json.dumps(told, allow_nan=False, ensure_ascii=False))
        return
    news = []
    if after.alarm is not None and before.alarm is None:
        news += [sentences.alarm_sentence(after.alarm), sentences.advice_sentence(after)]
    elif after.alarm is not None and (after.rest is None) != (before.rest is None):
        news.append(sentences.rest_sentence(after) or "θ0 moves on.")
    if int(_TOLD_SHARES * after.coverage.covered) > int(_TOLD_SHARES * before.coverage.covered):
        news.append(f"{sentences.covered(after.coverage)}.")
    for line in (*news, *([] if chosen is None else [sentences.next_action_sentence(*chosen)])):
        click.echo(f"push {after.push}: {line}")


def _conclude(
    file: Path, monitor: BiasMonitor, reports: list[BiasReport], chosen: Chosen | None, out: Path, picture_format: str,
    json_target: str | None, quiet: bool = False,
) -> None:  # fmt: skip
    """Write the picture and the JSON, and print the report, unless ``quiet``."""
    from cyclemap.cli.output import file_stem, publish
    from cyclemap.cli.terminal import PeopleConsole
    from cyclemap.views.watch_page import watch_page
    from cyclemap.views.watch_sentences import next_action_sentence, watch_sentences

    told = {"file": file.name, "pushes": len(reports), "alarm_rate": monitor.alarm_rate, **_report(reports[-1], chosen)}
    page, stem = watch_page(monitor, reports, file.name), out / f"watch_{file_stem(file.stem)}"
    picture = publish(told, page, stem, picture_format, None if quiet else json_target)
    if picture is not None and not quiet:
        following = () if chosen is None else (next_action_sentence(*chosen),)
        PeopleConsole().tell(*watch_sentences(reports[-1]), *following, f"picture: {picture}")


def _report(report: BiasReport, chosen: Chosen | None) -> Json:
    """What the monitor tells, and what to do next where a strategy is followed."""
    from cyclemap.cli.json_report import degrees, direction_deg, number
    from cyclemap.views.reset_sentences import action_words

    alarm, rest, state, advice = report.alarm, report.rest, report.coverage, report.advice
    evidence = {"rest": report.rest_evidence, "visits": report.visit_evidence, "threshold": report.threshold}
    told: Json = {
        "alarm": alarm and {
            "push": alarm.push,
            "kind": alarm.kind,
            "directions_deg": [direction_deg(theta) for theta in alarm.directions],
            "began": alarm.began,
        },
        "evidence": {f"{kind}_log10": number(value) for kind, value in evidence.items()},
        "rest": rest and {
            "began": rest.began,
            "directions_deg": [direction_deg(theta) for theta in rest.directions],
            "towards_deg": [direction_deg(theta) for theta in rest.towards],
        },
        "useful_pushes": report.useful_pushes,
        "recent_worth": number(report.recent_worth),
        "coverage": {
            "covered": number(state.covered),
            "largest_gap_deg": degrees(state.largest_gap),
            "gap_centre_deg": direction_deg(state.gap_centre),
            "effective_pushes": number(state.effective_pushes),
            "gain": number(state.gain),
        },
        "advice": {"change_reset": advice.change_reset, "direction_deg": direction_deg(advice.direction)},
    }  # fmt: skip
    if chosen is not None:
        action, found = chosen
        lands = {"lands_deg": direction_deg(found.lands), "crowding": number(found.crowding)}
        told["next_action"] = {"number": found.number, "name": action_words(action), **lands}
    return told
