"""The command `cyclemap dynamics`: its arguments and options."""

from collections.abc import Callable
from typing import Any

import click

from cyclemap.cli.number_types import Real
from cyclemap.cli.options import LoopOptions, decorated, loop_options, result_options, theta0_option


def _results(command: Callable[..., None]) -> Callable[..., None]:
    return decorated(command, result_options("dynamics_MATERIAL.png and .json"))


@click.command("dynamics")
@loop_options
@theta0_option
@click.option("--speed-mm-s", type=Real(), default=20.0, show_default=True, help="Speed of the rod.")
@_results
def dynamics_command(
    options: LoopOptions,
    json_target: str | None,
    **request: Any,
) -> None:
    """Set dynamic cycles (with inertia) beside quasi-static ones, on MATERIAL and on isotropic friction.

    Both stand on the footprint if it is made of points, else on points that carry its pressure: the paper's grid:8
    where it is even, weighted and with points along the rim where it leans or has parts.
    """
    from cyclemap.cli.run_dynamics import DynamicsRequest, run_dynamics

    run_dynamics(options, DynamicsRequest(**request), json_target)
