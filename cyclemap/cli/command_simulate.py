"""The command `cyclemap simulate`: its options, and the one call that it is."""

from pathlib import Path
from typing import Any

import click

from cyclemap.cli.number_types import MOST_CYCLES, Real, Whole
from cyclemap.cli.options import LoopOptions, loop_options

_NOT_NEGATIVE = Real(min=0.0)


@click.command("simulate")
@loop_options
@click.option(
    "--out", "folder", metavar="DIR", type=click.Path(path_type=Path), required=True, help="Folder of the collection."
)
@click.option("--cycles", type=Whole(1, MOST_CYCLES), default=2000, show_default=True, help="How many pushes.")
@click.option("--seed", type=Whole(min=0), default=0, show_default=True, help="Seed of all noise.")
@click.option("--start-deg", type=Real(), default=0.0, show_default=True, help="θ0 of the first push.")
@click.option("--noise-deg", type=_NOT_NEGATIVE, help="Scatter of θ0 from cycle to cycle. [default: its own or 1.1]")
@click.option(
    "--pose-noise-mm", type=_NOT_NEGATIVE, default=0.0, show_default=True, help="Error of recorded positions."
)
@click.option("--pose-noise-deg", type=_NOT_NEGATIVE, default=0.0, show_default=True, help="Error of recorded angles.")
@click.option("--force-noise-n", type=_NOT_NEGATIVE, default=0.0, show_default=True, help="Error of recorded forces.")
@click.option("--wear-to", metavar="MATERIAL", help="The surface at the last push: a name or a TOML file.")
@click.option("--speed-mm-s", type=Real(min=0.0, min_open=True), default=20.0, show_default=True, help="Of the rod.")
@click.option("--scans", is_flag=True, help="Friction scans of the fresh surface, too.")
@click.option(
    "--format", "suffix", type=click.Choice(["h5", "json"]), default="h5", show_default=True, help="Kind of the files."
)
@click.option("--json", "json_target", metavar="FILE", help="Write JSON there; '-' prints JSON and nothing else.")
def simulate_command(
    options: LoopOptions,
    json_target: str | None,
    **request: Any,
) -> None:
    """Write a simulated collection as files of the MIT dataset's layout, to rehearse what comes after.

    Run it again with the same arguments to go on with a collection that was broken off.
    """
    from cyclemap.cli.run_simulate import SimulationRequest, run_simulate

    run_simulate(options, SimulationRequest(**request), json_target)
