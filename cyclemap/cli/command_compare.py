"""`cyclemap compare`: its options, and the one call that it is."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.options import (
    LoopOptions,
    Whole,
    decorated,
    loop_options,
    readable_data,
    result_options,
    table_options,
)

Decorator = Callable[[Any], Any]


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


def _compare_options(command: Callable[..., None]) -> Callable[..., None]:
    return decorated(command, [*_data_options(), result_options("compare_MATERIAL.png and .json")])


def _data_options() -> list[Decorator]:
    """What is compared, and how."""
    tables = "Measured pushes: a CSV table of θ0 or of poses, or a file or folder of the MIT layout."
    early = "Leave out pushes before this one."
    kept = "Compare pushes with surface, object, speed_mm_s, side, fraction or angle_deg of this value; repeatable."
    runs: dict[str, Any] = {"type": Whole(min=19), "default": 199, "help": "Simulated collections."}
    return [
        click.option("--data", metavar="DATA", required=True, type=click.Path(path_type=Path), help=tables),
        click.option("--first", type=Whole(min=0), default=0, show_default=True, help=early),
        click.option("--select", metavar="KEY=VALUE", multiple=True, help=kept),
        click.option("--runs", show_default=True, **runs),
        click.option("--seed", type=Whole(min=0), default=0, show_default=True, help="Seed of their noise."),
    ]


@click.command("compare")
@loop_options
@table_options
@_compare_options
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
