"""The command `cyclemap sweep`: its arguments and options."""

from typing import Any

import click

from cyclemap.cli.options import LoopOptions, Real, Whole, protocol_options, result_options


@click.command("sweep")
@protocol_options
@click.option(
    "--over",
    metavar="KEY=VALUES",
    multiple=True,
    required=True,
    help="A key of --set, noise_deg or material, with start:stop:count or a,b,c; start:stop with --sample. Repeatable.",
)
@click.option("--sample", metavar="N", type=Whole(min=1), help="N points of the ranges, not a grid.")
@click.option("--seed", type=Whole(min=0), default=0, show_default=True, help="Seed of the sample.")
@click.option(
    "--sequence",
    type=click.Choice(["sobol", "uniform"]),
    default="sobol",
    show_default=True,
    help="How the sample is spread.",
)
@click.option(
    "--quantities",
    metavar="LIST",
    default="rotation,fixed_points,turns",
    show_default=True,
    help="By commas: rotation, fixed_points, turns, stationary, staircase, or all; stationary and staircase cost most.",
)
@click.option(
    "--tolerance-deg",
    type=Real(),
    help="Of each cycle map. [default: 5.7e-04; 5.7e-05 is that of portraits, at twice the time]",
)
@click.option(
    "--rotation-tolerance",
    type=Real(),
    default=1e-4,
    show_default=True,
    help="Turns a cycle to which rotation numbers need be known; 0 is a portrait's effort, far more.",
)
@click.option("--workers", type=Whole(min=1), help="Processes. [default: one a core]")
@click.option("--export", metavar="LIST", default="", help="Also write csv, netcdf, or both, by commas.")
@click.option("--draw", metavar="LIST", default="", help="Quantities to draw, by commas.")
@click.option("--status", is_flag=True, help="Tell how far the sweep is, and compute nothing.")
@result_options("the store sweep_MATERIAL.sqlite, .png, .csv and .nc")
def sweep_command(options: LoopOptions, json_target: str | None, **request: Any) -> None:
    """Sweep settings: the portrait's numbers at every point of a grid or a sample.

    Results are stored as they come; the same command again goes on where it stopped, and ends at once when all is
    there. Over one key or two it draws the bifurcation or phase diagram.
    """
    from cyclemap.cli.run_sweep import SweepRequest, run_sweep_command

    run_sweep_command(options, SweepRequest(**request), json_target)
