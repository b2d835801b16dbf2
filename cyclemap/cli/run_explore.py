"""`cyclemap explore`: the loop in the browser, with sliders, until Ctrl-C."""

import math
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.options import TableOptions, measured_orientations
from cyclemap.errors import InvalidInput
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_loop, protocol_of, set_settings
from cyclemap.protocol.collection_file import data_settings
from cyclemap.protocol.settings import layered
from cyclemap.views.explorer.answers import coarse, exact, explored, measured
from cyclemap.views.explorer.server import Answer, ExplorerServer


def run_explore(options: LoopOptions, data: Path | None, table: TableOptions, browser: bool) -> None:
    """Serve the page and answer its sliders until Ctrl-C."""
    material = options.material or "plywood"
    options = LoopOptions(material, options.protocol, options.settings)
    chosen_loop(options, data)
    beside = {} if data is None else data_settings(data)
    settings = layered(beside, protocol_of(options)[0], set_settings(options.settings))
    begun = explored((material,), material, settings)
    pairs = measured_orientations(data, table, Path("out"))

    def start(asked: Answer, check: Callable[[float], None]) -> Answer:
        return {"material": begun.loop.material.name, "controls": begun.controls(), "measured": measured(pairs)}

    def portrait(asked: Answer, check: Callable[[float], None]) -> Answer:
        found = begun.moved(moved(asked))
        theta, cycles = _number(asked, "start_deg", -3600, 3600), int(_number(asked, "cycles", 1, 5000))
        run = found.loop, found.sigma, math.radians(theta), cycles
        answer = exact(*run, check) if asked.get("exact") is True else coarse(*run)
        return {**answer, "command": found.command()}

    def protocol(asked: Answer, check: Callable[[float], None]) -> Answer:
        return {"text": begun.moved(moved(asked)).protocol()}

    def moved(asked: Answer) -> dict[str, Any]:
        sliders = asked.get("settings", {})
        if not isinstance(sliders, dict):
            raise InvalidInput("settings must be an object")
        return sliders

    with ExplorerServer({"start": start, "portrait": portrait, "protocol": protocol}) as server:
        try:
            click.echo(f"exploring {begun.loop.material.name} at {server.address}  (Ctrl-C ends)")
            if browser:
                webbrowser.open(server.address)
            server.serve_forever()
        except KeyboardInterrupt:
            click.echo("ended")


def _number(asked: Answer, key: str, low: float, high: float) -> float:
    value = asked.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise InvalidInput(f"{key} must be a number from {low} to {high}")
    return float(value)
