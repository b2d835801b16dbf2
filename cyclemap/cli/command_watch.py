"""The command `cyclemap watch`: its arguments and options."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.options import decorated, result_options


def _results(command: Callable[..., None]) -> Callable[..., None]:
    return decorated(command, result_options("watch_FILE.png and .json"))


@click.command("watch")
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--alarm-rate",
    type=click.FloatRange(min=0.0, max=1.0, min_open=True, max_open=True),
    default=0.01,
    show_default=True,
    help="Chance of ever raising an alarm on a collection without bias.",
)
@click.option("--follow", is_flag=True, help="Wait for new rows, and tell what changes, until interrupted (Ctrl-C).")
@click.option(
    "--every",
    metavar="SECONDS",
    type=click.FloatRange(min=0.01),
    default=1.0,
    show_default=True,
    help="How often --follow looks for new rows.",
)
@_results
def watch_command(json_target: str | None, **request: Any) -> None:
    """Watch a collection of θ0 for locking in: FILE is a CSV with theta0_deg in order, or a folder of MIT pushes.

    With --follow, `--json -` prints a line of JSON for each push.
    """
    from cyclemap.cli.run_watch import WatchRequest, run_watch

    run_watch(WatchRequest(**request), json_target)
