"""The command `cyclemap fit`: its arguments and options."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.number_types import Whole
from cyclemap.cli.options import decorated, result_options, select_option
from cyclemap.cli.own_data import readable_data, table_options

MOST_HARMONICS = 50


def _results(command: Callable[..., None]) -> Callable[..., None]:
    return decorated(command, result_options("fit_NAME.png and .json, for each set,"))


@click.command("fit")
@click.argument("data", type=click.Path(path_type=Path))
@select_option
@click.option("--harmonics", type=Whole(0, MOST_HARMONICS), help="Order of every law. [default: by cross-validation]")
@click.option("--wear/--no-wear", default=True, show_default=True, help="Let the cycle map drift in time.")
@click.option("--seed", type=Whole(min=0), default=0, show_default=True, help="Seed of folds and paths.")
@table_options
@_results
def fit_command(data: Path, columns: str | None, units: str | None, json_target: str | None, **request: Any) -> None:
    """Fit laws to measured pushes: Δθ, Δx, Δy over θ0, their histogram, and the cycle map with its wear.

    DATA is a file, a folder or a tree in the MIT layout, a CSV table of poses or of θ0, or a table of
    your own (CSV, Excel, LeRobot, ROS bag), whose columns are guessed, or told by --columns.
    """
    from cyclemap.cli.run_fit import FitRequest, run_fit

    data = readable_data(data, columns, units, request["out"])
    run_fit(data, FitRequest(**request), json_target)
