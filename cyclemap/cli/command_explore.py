"""`cyclemap explore`: the loop in the browser, with sliders, until Ctrl-C."""

from __future__ import annotations

import math
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cyclemap.cli.options import PATH, LoopOptions, measured_orientations, protocol_options, table_options

if TYPE_CHECKING:
    from collections.abc import Callable

    from cyclemap.views.explorer.server import Answer


@click.command("explore")
@protocol_options
@click.option("--data", metavar="DATA", type=PATH, help="Measured θ0 or pushes to lay over the curves.")
@table_options
@click.option(
    "--browser/--no-browser", default=True, show_default=False, help="Open the page, or only print its address."
)
def explore_command(
    options: LoopOptions, data: Path | None, columns: str | None, units: str | None, browser: bool
) -> None:
    """Move sliders and see the object move, its map, its stable directions and its staircase, in the browser.

    MATERIAL is plywood where none is given. The page is served on this machine only; Ctrl-C ends it.
    """
    from cyclemap.cli.settings import chosen_loop, protocol_of, set_settings
    from cyclemap.views.explorer.answers import coarse, exact, explored, measured
    from cyclemap.views.explorer.server import ExplorerServer

    material = options.material or "plywood"
    chosen_loop(LoopOptions(material, options.protocol, options.settings))
    settings = {**protocol_of(options)[0], **set_settings(options.settings)}
    begun = explored((material,), material, settings)
    pairs = measured_orientations(data, columns, units, Path("out"))

    def start(asked: Answer, check: Callable[[float], None]) -> Answer:
        return {"material": begun.loop.material.name, "controls": begun.controls(), "measured": measured(pairs)}

    def portrait(asked: Answer, check: Callable[[float], None]) -> Answer:
        found = begun.moved(_object(asked, "settings"))
        theta, cycles = _number(asked, "start_deg", -3600, 3600), int(_number(asked, "cycles", 1, 5000))
        run = found.loop, found.sigma, math.radians(theta), cycles
        answer = exact(*run, check) if asked.get("exact") is True else coarse(*run)
        return {**answer, "command": found.command()}

    def protocol(asked: Answer, check: Callable[[float], None]) -> Answer:
        return {"text": begun.moved(_object(asked, "settings")).protocol()}

    with ExplorerServer({"start": start, "portrait": portrait, "protocol": protocol}) as server:
        try:
            click.echo(f"exploring {begun.loop.material.name} at {server.address}  (Ctrl-C ends)")
            if browser:
                webbrowser.open(server.address)
            server.serve_forever()
        except KeyboardInterrupt:
            click.echo("ended")


def _object(asked: Answer, key: str) -> dict[str, object]:
    from cyclemap.errors import InvalidInput

    value = asked.get(key, {})
    if not isinstance(value, dict):
        raise InvalidInput(f"{key} must be an object")
    return value


def _number(asked: Answer, key: str, low: float, high: float) -> float:
    from cyclemap.errors import InvalidInput

    value = asked.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise InvalidInput(f"{key} must be a number from {low} to {high}")
    return float(value)
