"""The command `cyclemap replay`: its arguments and options."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.number_types import Real
from cyclemap.cli.options import LoopOptions, decorated, loop_options, result_options, select_option


def _results(command: Callable[..., None]) -> Callable[..., None]:
    return decorated(command, result_options("replay_MATERIAL.png and .json"))


@click.command("replay")
@loop_options
@click.option(
    "--data",
    metavar="PATH",
    required=True,
    type=click.Path(path_type=Path),
    help="Recorded pushes: in the MIT layout (a file, a folder or a tree), or CSV of poses and places of the tip.",
)
@select_option
@click.option("--pusher-friction", type=Real(min=0.0), help="Friction of rod and object. [default: 0.25, or as set]")
@_results
def replay_command(options: LoopOptions, json_target: str | None, **request: Any) -> None:
    """Replay recorded pushes along their own tip paths on MATERIAL, and tell how far off each ends.

    How plates press on it is taken from MATERIAL, and errors stand beside those of isotropic friction. The object is
    the data's: MIT's by its name in them, any other from MATERIAL, --protocol or the collection.toml beside the data.
    On an isotropic surface the friction coefficient changes no motion.
    """
    from cyclemap.cli.run_replay import ReplayRequest, run_replay

    run_replay(options, ReplayRequest(**request), json_target)
