"""The command `cyclemap figures`: its arguments and options."""

from collections.abc import Callable
from pathlib import Path

import click

from cyclemap.cli.options import decorated, result_options


def _results(command: Callable[..., None]) -> Callable[..., None]:
    return decorated(command, result_options("pictures, tables and figures.json"))


@click.command("figures")
@click.argument("names", metavar="[NAME ...|all]", nargs=-1)
@click.option(
    "--data",
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Folder of measured data. [default: $CYCLEMAP_DATA, or shared/data beside the checkout]",
)
@_results
def figures_command(
    names: tuple[str, ...], data: Path | None, out: Path, picture_format: str, json_target: str | None
) -> None:
    """Make figures and tables of the paper, and those it lacks; without a NAME, list them.

    Figures become pictures, tables CSV, the animation a GIF. figures.json beside them holds their captions.
    """
    from cyclemap.cli.run_figures import list_figures, run_figures

    if names:
        run_figures(names, data, out, picture_format, json_target)
    else:
        list_figures(json_target)
