"""The command `cyclemap experiment`: its arguments and options."""

from collections.abc import Callable
from typing import Any

import click

from cyclemap.cli.number_types import MOST_CYCLES, Real, Whole
from cyclemap.cli.options import LoopOptions, decorated, loop_options, result_options


def _results(command: Callable[..., None]) -> Callable[..., None]:
    return decorated(command, result_options("experiment_MATERIAL.png and .json"))


@click.command("experiment")
@loop_options
@click.option("--batches", type=Whole(min=1), default=6, show_default=True, help="Batches, evenly spaced.")
@click.option("--cycles", type=Whole(1, MOST_CYCLES), default=100, show_default=True, help="Cycles a batch.")
@click.option("--speed-mm-s", type=Real(), default=20.0, show_default=True, help="Speed of the rod.")
@click.option("--quasi-static", is_flag=True, help="Quasi-static cycles, without inertia, in place of dynamic ones.")
@_results
def experiment_command(
    options: LoopOptions,
    json_target: str | None,
    **request: Any,
) -> None:
    """Run the paper's numerical experiment: batches of cycles from several θ0, and on isotropic friction.

    It takes a minute or two; --quasi-static on the exact footprint a quarter of that. Dynamic cycles stand on the
    footprint if it is made of points, else on points that carry its pressure: the paper's grid:8 where it is even,
    weighted and with points along the rim where it leans or has parts.
    """
    from cyclemap.cli.run_experiment import ExperimentRequest, run_experiment

    run_experiment(options, ExperimentRequest(**request), json_target)
