"""The command `cyclemap fingerprint`: its arguments and options."""

from collections.abc import Callable
from typing import Any

import click

from cyclemap.cli.options import LoopOptions, decorated, protocol_options, result_options


def _results(command: Callable[..., None]) -> Callable[..., None]:
    return decorated(command, result_options("fingerprint_MATERIAL.png and .json"))


@click.command("fingerprint")
@protocol_options
@click.option("--check", is_flag=True, help="Compute the full cycle map too, and set its directions beside.")
@_results
def fingerprint_command(
    options: LoopOptions,
    json_target: str | None,
    **request: Any,
) -> None:
    """Print the five numbers of a protocol and, for a material, the directions they predict.

    Without MATERIAL and friction settings only the protocol's own numbers are told.
    """
    from cyclemap.cli.run_fingerprint import FingerprintRequest, run_fingerprint

    run_fingerprint(options, FingerprintRequest(**request), json_target)
