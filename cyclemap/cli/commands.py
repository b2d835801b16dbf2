"""The commands: their options, and the few calls that each of them is.

The rooms they call are imported inside them, so that `cyclemap --help` waits for none of them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

DEFAULT_THETA0_DEG = "0,30,60,90,120,150,180,210,240,270,300,330"


@dataclass(frozen=True)
class LoopOptions:
    """Which loop a command is about: the options shared by every command."""

    material: str
    protocol: Path | None
    settings: tuple[str, ...]


@dataclass(frozen=True)
class RunRequest:
    """What is asked of a command that predicts a run: its measured data, its length, and where results go."""

    data: Path | None
    cycles: int | None
    seed: int
    out: Path
    picture_format: str


def loop_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give `command` the MATERIAL argument and the options shared by every command."""
    decorators: list[Callable[[Any], Any]] = [
        click.argument("material", required=False),
        click.option("--material", "material_file", metavar="TOML", help="A material file, in place of MATERIAL."),
        click.option(
            "--protocol",
            metavar="TOML",
            type=click.Path(path_type=Path),
            help="The --set keys in TOML tables.",
        ),
        click.option(
            "--set",
            "settings",
            metavar="KEY=VALUE",
            multiple=True,
            help="One fact of the experiment; repeatable.",
        ),
    ]
    return _decorated(command, decorators)


def run_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give `command` the options of a command that predicts a run of cycles."""
    decorators: list[Callable[[Any], Any]] = [
        click.option("--data", metavar="CSV", type=click.Path(path_type=Path), help="Measured θ0 to set beside it."),
        click.option(
            "--cycles", type=click.IntRange(min=1), help="Length of the staircase. [default: 2000, or the data's]"
        ),
        click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of its noise."),
        click.option(
            "--out",
            metavar="DIR",
            type=click.Path(path_type=Path),
            default="out",
            show_default=True,
            help="Where COMMAND_MATERIAL.png and .json go.",
        ),
        click.option(
            "--format",
            "picture_format",
            type=click.Choice(["png", "pdf", "svg"]),
            default="png",
            show_default=True,
            help="Format of the picture.",
        ),
        click.option(
            "--json", "json_target", metavar="FILE", help="Write JSON there; '-' prints JSON and nothing else."
        ),
    ]
    return _decorated(command, decorators)


def _decorated(command: Callable[..., None], decorators: list[Callable[[Any], Any]]) -> Callable[..., None]:
    for decorate in reversed(decorators):
        command = decorate(command)
    return command


def _options(
    material: str | None, material_file: str | None, protocol: Path | None, settings: tuple[str, ...]
) -> LoopOptions:
    if (material is None) == (material_file is None):
        raise click.UsageError("give one material: a name or a TOML file, as MATERIAL or with --material")
    return LoopOptions(material or material_file or "", protocol, settings)


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

    run_cycle(_options(material, material_file, protocol, settings), theta0_deg, out, json_target)


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

    run_portrait(_options(material, material_file, protocol, settings), RunRequest(**request), json_target)


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

    run_staircase(_options(material, material_file, protocol, settings), RunRequest(**request), json_target)
