"""The command `cyclemap reset`: its arguments and options."""

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import click

from cyclemap.cli.options import LoopOptions, decorated, loop_options, result_options

_SHARE = click.FloatRange(min=0.0, max=1.0, min_open=True, max_open=True)
_ABOVE_ZERO = click.FloatRange(min=0.0, min_open=True)
_FROM_ZERO = click.FloatRange(min=0.0)
_UNDER_100 = click.FloatRange(min=0.0, max=100.0, max_open=True)


def _law_options(command: Callable[..., None]) -> Callable[..., None]:
    shown: dict[str, Any] = {"show_default": True}
    decorators: list[Callable[[Any], Any]] = [
        click.option(
            "--allow-tv", type=_SHARE, default=0.05, help="Most total variation of θ0's law from uniform.", **shown
        ),
        click.option(
            "--extra-tv", type=_SHARE, default=0.05, help="How much more after --within pushes from any start.", **shown
        ),
        click.option("--within", type=click.IntRange(min=1), default=50, help="Pushes until then.", **shown),
    ]
    return decorated(command, decorators)


def _robot_options(command: Callable[..., None]) -> Callable[..., None]:
    ratio = "Most mean drag, in those of the loop as it is."
    held = "Shortest way of the rod in contact, in every push; else a third of the push will do, where it must."
    more = "What the robot can do besides: put the ring elsewhere, turn the object. Repeatable."
    able: dict[str, Any] = {"type": click.Choice(["ring", "gripper"]), "multiple": True}
    decorators: list[Callable[[Any], Any]] = [
        click.option("--drag-ratio", type=_ABOVE_ZERO, default=2.0, help=ratio, show_default=True),
        click.option("--reach-mm", type=_ABOVE_ZERO, help="Most distance of rod or object from the target."),
        click.option("--seconds", type=_ABOVE_ZERO, help="Most mean time of a cycle."),
        click.option("--least-push-mm", type=_ABOVE_ZERO, help=held),
        click.option("--with", "abilities", help=more, **able),
        click.option("--keep-push", is_flag=True, help="Change only the way back: every push stays the loop's own."),
    ]
    return decorated(command, decorators)


def _beyond_options(command: Callable[..., None]) -> Callable[..., None]:
    wears = "Follow the chosen reset over --cycles pushes as the surface wears."
    shown: dict[str, Any] = {"show_default": True}
    decorators: list[Callable[[Any], Any]] = [
        click.option("--robust", is_flag=True, help="Design pushes that hold over a range of materials."),
        click.option(
            "--ratio-percent", type=_UNDER_100, default=10.0, help="Of --robust: the axis ratio's range, ±.", **shown
        ),
        click.option(
            "--offset-percent", type=_FROM_ZERO, default=50.0, help="Of --robust: the offsets' range, ±.", **shown
        ),
        click.option(
            "--materials",
            type=click.IntRange(min=1),
            default=200,
            help="Of --robust: materials drawn for the check.",
            **shown,
        ),
        click.option("--workers", type=click.IntRange(min=1), help="Processes of --robust.  [default: one a core]"),
        click.option("--wear", is_flag=True, help=wears),
        click.option("--wear-to", metavar="MATERIAL", help="The same, the surface at the last push: a name or a file."),
    ]
    return decorated(command, decorators)


def _work_options(command: Callable[..., None]) -> Callable[..., None]:
    decorators: list[Callable[[Any], Any]] = [
        click.option("--quick", "thoroughness", flag_value="quick", help="Look at fewer strategies."),
        click.option("--thorough", "thoroughness", flag_value="thorough", help="Look at many more strategies."),
        click.option(
            "--pushes",
            type=click.IntRange(min=0),
            default=500,
            show_default=True,
            help="Pushes of the chosen strategy run by the full mechanics; 0: none.",
        ),
        click.option(
            "--cycles", type=click.IntRange(min=1), default=2000, show_default=True, help="Length of the schedule."
        ),
        click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of the schedule."),
        *result_options("reset_MATERIAL.png and .json, the protocol (.toml) and the schedule (.csv)"),
    ]
    return decorated(command, decorators)


@click.command("reset")
@loop_options
@_law_options
@_robot_options
@_beyond_options
@_work_options
def reset_command(options: LoopOptions, json_target: str | None, **request: Any) -> None:
    """Design a reset that spreads θ0 evenly: rank strategies, and write the chosen protocol.

    Demands that no strategy meets are answered by the best there is, and why. With --robust the demands hold on every
    material about MATERIAL, as far as the sampled ones tell.
    """
    from cyclemap.cli.reset_robust import BeyondRequest
    from cyclemap.cli.run_reset import ResetRequest, run_reset

    beyond = BeyondRequest(**{field.name: request.pop(field.name) for field in fields(BeyondRequest)})
    run_reset(options, ResetRequest(**request, beyond=beyond), json_target)
