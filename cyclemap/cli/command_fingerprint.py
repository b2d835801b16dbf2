"""The command `cyclemap fingerprint`: its arguments and options."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.options import decorated, loop_options, result_options


def _results(command: Callable[..., None]) -> Callable[..., None]:
    return decorated(command, result_options("fingerprint_MATERIAL.png and .json"))


@click.command("fingerprint")
@loop_options
@click.option("--check", is_flag=True, help="Compute the full cycle map too, and set its directions beside.")
@_results
def fingerprint_command(
    material: str | None,
    material_file: str | None,
    protocol: Path | None,
    settings: tuple[str, ...],
    json_target: str | None,
    **request: Any,
) -> None:
    """Print the five numbers of a protocol and, for a material, the directions they predict.

    Without MATERIAL and friction settings only the protocol's own numbers are told.
    """
    from cyclemap.cli.run_fingerprint import FingerprintRequest, run_fingerprint

    if material is not None and material_file is not None:
        raise click.UsageError("give at most one material: a name or a TOML file, as MATERIAL or with --material")
    run_fingerprint(FingerprintRequest(material or material_file, protocol, settings, **request), json_target)
