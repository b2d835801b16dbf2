"""The command `cyclemap reset`: its arguments and options."""

from collections.abc import Callable
from typing import Any

import click

from cyclemap.cli.options import LoopOptions, decorated, loop_options, result_options

_SHARE = click.FloatRange(min=0.0, max=1.0, min_open=True, max_open=True)
_ABOVE_ZERO = click.FloatRange(min=0.0, min_open=True)


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
    more = "What the robot can do besides: put the ring elsewhere, turn the object. Repeatable."
    able: dict[str, Any] = {"type": click.Choice(["ring", "gripper"]), "multiple": True}
    decorators: list[Callable[[Any], Any]] = [
        click.option("--drag-ratio", type=_ABOVE_ZERO, default=2.0, help=ratio, show_default=True),
        click.option("--reach-mm", type=_ABOVE_ZERO, help="Most distance of rod or object from the target."),
        click.option("--seconds", type=_ABOVE_ZERO, help="Most mean time of a cycle."),
        click.option("--with", "abilities", help=more, **able),
        click.option("--keep-push", is_flag=True, help="Change only the way back: every push stays the loop's own."),
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
@_work_options
def reset_command(options: LoopOptions, json_target: str | None, **request: Any) -> None:
    """Design a reset that spreads θ0 evenly: rank strategies, and write the chosen protocol.

    Demands that no strategy meets are answered by the best there is, and why.
    """
    from cyclemap.cli.run_reset import ResetRequest, run_reset

    run_reset(options, ResetRequest(**request), json_target)
