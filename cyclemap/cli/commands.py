"""The commands: the few calls that each of them is.

The rooms they call are imported inside them, so that `cyclemap --help` waits for none of them.
"""

from pathlib import Path
from typing import Any

import click

from cyclemap.cli.options import RunRequest, chosen_options, loop_options, run_options

DEFAULT_THETA0_DEG = "0,30,60,90,120,150,180,210,240,270,300,330"


@click.command("cycle")
@loop_options
@click.option(
    "--theta0-deg",
    metavar="LIST",
    default=DEFAULT_THETA0_DEG,
    show_default=True,
    help="Start angles, by commas.",
)
@click.option("--out", metavar="DIR", type=click.Path(path_type=Path), help="Also write cycles_MATERIAL.json there.")
@click.option("--json", "json_target", metavar="FILE", help="Write JSON there; '-' prints JSON and nothing else.")
def cycle_command(
    material: str | None,
    material_file: str | None,
    protocol: Path | None,
    settings: tuple[str, ...],
    theta0_deg: str,
    out: Path | None,
    json_target: str | None,
) -> None:
    """Run single cycles: one push and one drag back from each start angle."""
    from cyclemap.cli.run_cycle import run_cycle

    run_cycle(chosen_options(material, material_file, protocol, settings), theta0_deg, out, json_target)


@click.command("portrait")
@loop_options
@run_options
def portrait_command(
    material: str | None,
    material_file: str | None,
    protocol: Path | None,
    settings: tuple[str, ...],
    json_target: str | None,
    **request: Any,
) -> None:
    """Compute the cycle map of a material, tell what it implies, and draw it."""
    from cyclemap.cli.run_portrait import run_portrait

    run_portrait(chosen_options(material, material_file, protocol, settings), RunRequest(**request), json_target)


@click.command("staircase")
@loop_options
@run_options
def staircase_command(
    material: str | None,
    material_file: str | None,
    protocol: Path | None,
    settings: tuple[str, ...],
    json_target: str | None,
    **request: Any,
) -> None:
    """Predict the staircase of θ0: its steps, how long it rests on them, and one run."""
    from cyclemap.cli.run_staircase import run_staircase

    run_staircase(chosen_options(material, material_file, protocol, settings), RunRequest(**request), json_target)
