"""The command `cyclemap identify`: its arguments and options."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.options import Real, Whole, readable_data, result_options, select_option, table_options

_PATH = click.Path(path_type=Path)


@dataclass(frozen=True)
class IdentifyRequest:
    """What is asked of an identification, in the units of the command line."""

    select: tuple[str, ...]
    protocol: Path | None
    settings: tuple[str, ...]
    start: str | None
    free: str | None
    fix: tuple[str, ...]
    first: int
    most: int
    wear: bool
    no_priors: bool
    name: str | None
    folds: int | None
    student: float
    starts: int
    seed: int
    out: Path
    picture_format: str


@click.command("identify")
@click.argument("data", nargs=-1, required=True, type=_PATH)
@table_options
@select_option
@click.option("--protocol", metavar="TOML", type=_PATH, help="The --set keys in TOML tables.")
@click.option(
    "--set",
    "settings",
    metavar="KEY=VALUE",
    multiple=True,
    help="One fact of the experiment (rod, ring, object); repeatable.",
)
@click.option("--first", type=Whole(min=0), default=0, show_default=True, help="Leave out cycles before this one.")
@click.option(
    "--most", type=Whole(min=2), default=2000, show_default=True, help="Pushes or drags of an object and file, at most."
)
@click.option("--start", metavar="MATERIAL", help="Where the search begins: a name or a TOML file.")
@click.option("--free", metavar="NAMES", help="Parameters to identify, by commas. [default: what the data tell]")
@click.option("--fix", metavar="NAME=VALUE", multiple=True, help="Hold a parameter (SI units); repeatable.")
@click.option("--wear", is_flag=True, help="Let the friction change over the cycles.")
@click.option("--no-priors", is_flag=True, help="Believe nothing beforehand: the data alone speak.")
@click.option("--folds", type=Whole(min=0), help="Parts for cross-validation; 0: none. [default: 5]")
@click.option(
    "--student",
    type=Real(min=1.0, min_open=True),
    default=4.0,
    show_default=True,
    help="Freedom of Student noise, which lets outliers count less; a large one is normal noise.",
)
@click.option("--starts", type=Whole(min=1), default=2, show_default=True, help="Searches.")
@click.option("--seed", type=Whole(min=0), default=0, show_default=True, help="Seed of starts, folds and draws.")
@click.option("--name", help="Of the material. [default: SURFACE-identified]")
@result_options("NAME.toml, identify_NAME.png and .json")
def identify_command(
    data: tuple[Path, ...], columns: str | None, units: str | None, json_target: str | None, **request: Any
) -> None:
    """Identify a surface from measured data, and write it as a material.

    DATA are files, folders or trees: friction scans and pushes in the MIT layout, and CSV tables of push ends with
    tip, of drag-backs, of θ0, or of wrenches and twists, of any number of objects on one surface. All are explained at
    once: friction is the surface's, pressure each object's, the shift between robot and camera each data set's.
    """
    from cyclemap.cli.run_identify import run_identify

    data = tuple(readable_data(path, columns, units, request["out"]) for path in data)
    run_identify(data, IdentifyRequest(**request), json_target)
