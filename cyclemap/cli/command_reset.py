"""The command `cyclemap reset`: its arguments and options."""

from collections.abc import Callable
from typing import Any

import click

from cyclemap.cli.number_types import Real, Whole
from cyclemap.cli.options import LoopOptions, decorated, loop_options, result_options

_SHARE = Real(min=0.0, max=1.0, min_open=True, max_open=True)
_ABOVE_ZERO = Real(min=0.0, min_open=True)
_SHOWN: dict[str, Any] = {"show_default": True}


def _demands(command: Callable[..., None]) -> Callable[..., None]:
    held = "Shortest way of the rod in contact, in every push.  [default: two thirds of the push, else one]"
    more = "What the robot can do besides: put the ring elsewhere, turn the object. Repeatable."
    able: dict[str, Any] = {"type": click.Choice(["ring", "gripper"]), "multiple": True}
    tv = "Most total variation of θ0 from uniform, in the long run, at the worst of the range."
    decorators: list[Callable[[Any], Any]] = [
        click.option("--allow-tv", type=_SHARE, default=0.10, help=tv, **_SHOWN),
        click.option("--extra-tv", type=_SHARE, default=0.02, help="More after --within pushes.", **_SHOWN),
        click.option("--within", type=Whole(1, 10_000), default=50, help="Pushes from the worst start.", **_SHOWN),
        click.option("--drag-ratio", type=_ABOVE_ZERO, default=2.0, help="Most mean drag, in those of now.", **_SHOWN),
        click.option("--reach-mm", type=_ABOVE_ZERO, help="Most distance of rod or object from the target."),
        click.option("--seconds", type=_ABOVE_ZERO, help="Most mean time of a cycle."),
        click.option("--least-push-mm", type=_ABOVE_ZERO, help=held),
        click.option("--with", "abilities", help=more, **able),
        click.option("--keep-push", is_flag=True, help="Change only the way back: every push stays the loop's own."),
    ]
    return decorated(command, decorators)


def _range(command: Callable[..., None]) -> Callable[..., None]:
    axes = "How much one axis of friction may be longer against the other."
    percent = Real(min=0.0, max=100.0, max_open=True)
    likely = "A material as likely as MATERIAL, in place of these percentages. Repeatable."
    decorators: list[Callable[[Any], Any]] = [
        click.option("--axes-percent", type=percent, default=10.0, help=axes, **_SHOWN),
        click.option(
            "--offsets-percent", type=_ABOVE_ZERO, default=50.0, help="How much m0 and n0 may vary.", **_SHOWN
        ),
        click.option("--likely", metavar="MATERIAL", multiple=True, help=likely),
        click.option("--pushes", type=Whole(1, 10_000), default=500, help="How many to collect.", **_SHOWN),
        click.option("--cycles", type=Whole(1, 10_000_000), default=2000, help="Schedule's length.", **_SHOWN),
        click.option("--seed", type=Whole(min=0), default=0, help="Seed of the schedule.", **_SHOWN),
        *result_options("reset_MATERIAL.png and .json, the protocol (.toml) and the schedule (.csv)"),
    ]
    return decorated(command, decorators)


@click.command("reset")
@loop_options
@_demands
@_range
def reset_command(options: LoopOptions, json_target: str | None, **request: Any) -> None:
    """Find a reset that spreads θ0 uniformly on MATERIAL and its likes, and write it as protocol and schedule."""
    from cyclemap.cli.run_reset import ResetRequest, run_reset

    run_reset(options, ResetRequest(**request), json_target)
