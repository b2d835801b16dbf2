"""The command `cyclemap sweep`: its arguments and options."""

from collections.abc import Callable
from typing import Any

import click

from cyclemap.cli.options import LoopOptions, Real, Whole, decorated, protocol_options, result_options

_GROUPS = "rotation, fixed_points, turns, stationary, staircase, or all"


def _sweep_options(command: Callable[..., None]) -> Callable[..., None]:
    files = result_options("the store sweep_MATERIAL.sqlite, .png, .csv and .nc")
    return decorated(command, [*_options_of_points(), *_options_of_numbers(), *_options_of_work(), files])


def _options_of_points() -> list[Callable[[Any], Any]]:
    over = (
        "A key of --set, noise_deg or material, with start:stop:count or a,b,c; start:stop with --sample. Repeatable."
    )
    sequences: dict[str, Any] = {"type": click.Choice(["sobol", "uniform"]), "default": "sobol", "show_default": True}
    return [
        click.option("--over", metavar="KEY=VALUES", multiple=True, required=True, help=over),
        click.option("--sample", metavar="N", type=Whole(min=1), help="N points of the ranges, not a grid."),
        click.option("--seed", type=Whole(min=0), default=0, show_default=True, help="Seed of the sample."),
        click.option("--sequence", help="How the sample is spread.", **sequences),
    ]


def _options_of_numbers() -> list[Callable[[Any], Any]]:
    groups = f"By commas: {_GROUPS}; stationary and staircase cost most."
    chosen: dict[str, Any] = {"metavar": "LIST", "default": "rotation,fixed_points,turns", "show_default": True}
    tolerance = "Of each cycle map. [default: 5.7e-04; 5.7e-05 is that of portraits, at twice the time]"
    pace = "Turns a cycle to which rotation numbers need be known; 0 is a portrait's effort, far more."
    return [
        click.option("--quantities", help=groups, **chosen),
        click.option("--tolerance-deg", type=Real(), help=tolerance),
        click.option("--rotation-tolerance", type=Real(), default=1e-4, show_default=True, help=pace),
    ]


def _options_of_work() -> list[Callable[[Any], Any]]:
    return [
        click.option("--workers", type=Whole(min=1), help="Processes. [default: one a core]"),
        click.option("--export", metavar="LIST", default="", help="Also write csv, netcdf, or both, by commas."),
        click.option("--draw", metavar="LIST", default="", help="Quantities to draw, by commas."),
        click.option("--status", is_flag=True, help="Tell how far the sweep is, and compute nothing."),
    ]


@click.command("sweep")
@protocol_options
@_sweep_options
def sweep_command(options: LoopOptions, json_target: str | None, **request: Any) -> None:
    """Sweep settings: the portrait's numbers at every point of a grid or a sample.

    Results are stored as they come; the same command again goes on where it stopped, and ends at once when all is
    there. Over one key or two it draws the bifurcation or phase diagram.
    """
    from cyclemap.cli.run_sweep import SweepRequest, run_sweep_command

    run_sweep_command(options, SweepRequest(**request), json_target)
