"""The command `cyclemap watch`: its arguments and options."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.number_types import Real
from cyclemap.cli.options import decorated, result_options

SHORTEST_WAIT, LONGEST_WAIT = 0.01, 86400.0
_WAITS = f"{SHORTEST_WAIT:g} to {LONGEST_WAIT:g}"


def _wait(context: click.Context, option: click.Parameter, seconds: float) -> float:
    """Refuse what no clock can wait for; a range would let nan pass."""
    if not (math.isfinite(seconds) and SHORTEST_WAIT <= seconds <= LONGEST_WAIT):
        raise click.BadParameter(f"{seconds:g} is no wait; give a finite number of {_WAITS} seconds")
    return seconds


def _results(command: Callable[..., None]) -> Callable[..., None]:
    return decorated(command, result_options("watch_FILE.png and .json"))


@click.command("watch")
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--alarm-rate",
    type=Real(min=0.0, max=1.0, min_open=True, max_open=True),
    default=0.01,
    show_default=True,
    help="Chance of ever raising an alarm where turns do not depend on θ0 and θ0 does not linger.",
)
@click.option("--follow", is_flag=True, help="Wait for new rows, and tell what changes, until interrupted (Ctrl-C).")
@click.option(
    "--every",
    metavar="SECONDS",
    type=Real(),
    callback=_wait,
    default=1.0,
    show_default=True,
    help=f"How often --follow looks for new rows: every {_WAITS} seconds.",
)
@click.option(
    "--protocol",
    metavar="TOML",
    type=click.Path(path_type=Path),
    help="Protocol with a [strategy]: which of its actions to take next.",
)
@click.option(
    "--material", metavar="MATERIAL", help="With --protocol: name or TOML file of the surface. [default: isotropic]"
)
@_results
def watch_command(json_target: str | None, **request: Any) -> None:
    """Watch a collection of θ0 for locking in: FILE is a CSV with theta0_deg in order, or a folder of MIT pushes.

    With --protocol it also tells which action of the strategy takes the object to where least is recorded. With
    --follow, `--json -` prints a line of JSON for each push.
    """
    from cyclemap.cli.run_watch import WatchRequest, run_watch

    run_watch(WatchRequest(**request), json_target)
