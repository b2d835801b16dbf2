"""`cyclemap compare`: its options, and the one call that it is."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.options import (
    LoopOptions,
    Whole,
    loop_options,
    readable_data,
    result_options,
    select_option,
    table_options,
)


@dataclass(frozen=True)
class CompareRequest:
    """What is compared, how, and where results go."""

    data: Path
    read: Path
    first: int
    select: tuple[str, ...]
    runs: int
    seed: int
    out: Path
    picture_format: str


@click.command("compare")
@loop_options
@table_options
@click.option(
    "--data",
    metavar="DATA",
    required=True,
    type=click.Path(path_type=Path),
    help="Measured pushes: a CSV table of θ0 or of poses, or a file or folder of the MIT layout.",
)
@click.option("--first", type=Whole(min=0), default=0, show_default=True, help="Leave out pushes before this one.")
@select_option
@click.option("--runs", type=Whole(min=19), default=199, show_default=True, help="Simulated collections.")
@click.option("--seed", type=Whole(min=0), default=0, show_default=True, help="Seed of their noise.")
@result_options("compare_MATERIAL.png and .json")
def compare_command(
    options: LoopOptions,
    columns: str | None,
    units: str | None,
    json_target: str | None,
    **request: Any,
) -> None:
    """Set the prediction of a material beside measured data, and say where they agree."""
    from cyclemap.cli.run_compare import run_compare

    request["read"] = readable_data(request["data"], columns, units, request["out"])
    run_compare(options, CompareRequest(**request), json_target)
