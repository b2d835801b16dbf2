"""The options that commands share, and what they come to: which loop, which run."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.number_types import MOST_CYCLES, Whole

_QUIET = "cyclemap.quiet"


@dataclass(frozen=True)
class LoopOptions:
    """Which loop a command is about; material: None where none was named, which stands for isotropic friction."""

    material: str | None
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
    """Give `command` the MATERIAL argument and the options of a loop; they reach it as one `LoopOptions`."""
    return _gathering(command, needs_material=True)


def protocol_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give `command` the options of a loop, whose material may be left out."""
    return _gathering(command, needs_material=False)


def _gathering(command: Callable[..., None], needs_material: bool) -> Callable[..., None]:
    @wraps(command)
    def gathered(
        material: str | None,
        material_file: str | None,
        protocol: Path | None,
        settings: tuple[str, ...],
        **others: Any,
    ) -> None:
        one = (material is None) != (material_file is None)
        if not one and (needs_material or material is not None):
            raise click.UsageError("give one material: a name or a TOML file, as MATERIAL or with --material")
        command(LoopOptions(material or material_file, protocol, settings), **others)

    decorators: list[Callable[[Any], Any]] = [
        click.argument("material", required=False),
        click.option("--material", "material_file", metavar="TOML", help="A material file, in place of MATERIAL."),
        click.option(
            "--protocol",
            metavar="TOML",
            type=click.Path(path_type=Path),
            help="The --set keys in TOML tables, and a [strategy].",
        ),
        click.option(
            "--set",
            "settings",
            metavar="KEY=VALUE",
            multiple=True,
            help="One fact of the experiment; repeatable.",
        ),
    ]
    return decorated(gathered, decorators)


def theta0_option(command: Callable[..., None]) -> Callable[..., None]:
    """Give `command` the list of start angles, every 30 degrees by default."""
    return click.option(
        "--theta0-deg",
        metavar="LIST",
        default=",".join(str(angle) for angle in range(0, 360, 30)),
        show_default=True,
        help="Start angles, by commas.",
    )(command)


def run_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give `command` the options of a command that predicts a run of cycles."""
    decorators: list[Callable[[Any], Any]] = [
        click.option("--data", metavar="CSV", type=click.Path(path_type=Path), help="Measured θ0 to set beside it."),
        click.option(
            "--cycles", type=Whole(1, MOST_CYCLES), help="Length of the staircase. [default: 2000, or the data's]"
        ),
        click.option("--seed", type=Whole(min=0), default=0, show_default=True, help="Seed of its noise."),
        *result_options("COMMAND_MATERIAL.png and .json"),
    ]
    return decorated(command, decorators)


def result_options(files: str) -> list[Callable[[Any], Any]]:
    """Options of where results go, and as what; `files` names them in the help."""
    only = "Write JSON there; '-' prints JSON and nothing else."
    folder: dict[str, Any] = {"metavar": "DIR", "type": click.Path(path_type=Path), "default": "out"}
    formats: dict[str, Any] = {"type": click.Choice(["png", "pdf", "svg"]), "default": "png"}
    return [
        click.option("--out", show_default=True, help=f"Where {files} go.", **folder),
        click.option("--format", "picture_format", show_default=True, help="Format of the picture.", **formats),
        click.option("--json", "json_target", metavar="FILE", help=only),
    ]


def quiet_option() -> click.Option:
    """The option of every command that leaves its words and its progress unsaid; see `is_quiet`."""

    def keep(context: click.Context, _: click.Parameter, value: bool) -> None:
        context.meta[_QUIET] = value

    told = "Say nothing but errors, warnings and --json."
    return click.Option(["--quiet"], is_flag=True, expose_value=False, callback=keep, help=told)


def is_quiet() -> bool:
    """Whether the command that runs was given --quiet."""
    context = click.get_current_context(silent=True)
    return context is not None and bool(context.meta.get(_QUIET))


def decorated(command: Callable[..., None], decorators: list[Callable[[Any], Any]]) -> Callable[..., None]:
    """Give `command` the options, in this order."""
    for decorate in reversed(decorators):
        command = decorate(command)
    return command
