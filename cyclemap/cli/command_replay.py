"""The command `cyclemap replay`: its arguments and options."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.number_types import Real
from cyclemap.cli.options import decorated, result_options


def _results(command: Callable[..., None]) -> Callable[..., None]:
    return decorated(command, result_options("replay_MATERIAL.png and .json"))


@click.command("replay")
@click.argument("material")
@click.option(
    "--data",
    metavar="PATH",
    required=True,
    type=click.Path(path_type=Path),
    help="Recorded pushes in the MIT layout: a file, a folder or a tree.",
)
@click.option(
    "--pusher-friction",
    type=Real(min=0.0),
    help="Friction coefficient between rod and object. [default: the material's, else 0.25]",
)
@_results
def replay_command(json_target: str | None, **request: Any) -> None:
    """Replay recorded pushes along their own tip paths on MATERIAL, and tell how far off each ends.

    How plates press on it is taken from MATERIAL, and errors stand beside those of isotropic friction.

    MATERIAL is a name or a TOML file; on an isotropic one the friction coefficient changes no motion.
    """
    from cyclemap.cli.run_replay import ReplayRequest, run_replay

    run_replay(ReplayRequest(**request), json_target)
