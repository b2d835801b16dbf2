"""The commands: the few calls that each of them is.

The rooms they call are imported inside them, so that `cyclemap --help` waits for none of them.
"""

from pathlib import Path
from typing import Any

import click

from cyclemap.cli.options import LoopOptions, RunRequest, loop_options, run_options, theta0_option


@click.command("cycle")
@loop_options
@theta0_option
@click.option("--out", metavar="DIR", type=click.Path(path_type=Path), help="Also write cycles_MATERIAL.json there.")
@click.option("--json", "json_target", metavar="FILE", help="Write JSON there; '-' prints JSON and nothing else.")
def cycle_command(
    options: LoopOptions,
    theta0_deg: str,
    out: Path | None,
    json_target: str | None,
) -> None:
    """Run single cycles: one push and one drag back from each start angle."""
    from cyclemap.cli.run_cycle import run_cycle

    run_cycle(options, theta0_deg, out, json_target)


@click.command("portrait")
@loop_options
@run_options
def portrait_command(
    options: LoopOptions,
    json_target: str | None,
    **request: Any,
) -> None:
    """Compute the cycle map of a material, tell what it implies, and draw it."""
    from cyclemap.cli.run_portrait import run_portrait

    run_portrait(options, RunRequest(**request), json_target)


@click.command("staircase")
@loop_options
@run_options
def staircase_command(
    options: LoopOptions,
    json_target: str | None,
    **request: Any,
) -> None:
    """Predict the staircase of θ0: its steps, how long it rests on them, and one run."""
    from cyclemap.cli.run_staircase import run_staircase

    run_staircase(options, RunRequest(**request), json_target)
