"""`cyclemap probe`: does a simulator, or a robot, push alike in all directions? In sentences, JSON and a picture."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cyclemap.cli.options import (
    PATH,
    LoopOptions,
    Whole,
    protocol_options,
    readable_data,
    result_options,
    table_options,
)
from cyclemap.errors import InvalidInput

if TYPE_CHECKING:
    from cyclemap.evidence.push_probe import Probe


@click.command("probe")
@protocol_options
@click.option("--data", metavar="DATA", type=PATH, help="Pushes made: a table with end poses.")
@click.option(
    "--command", "program", metavar="PROGRAM", help='A program: {"theta_deg"} in, {"dx_mm","dy_mm","dtheta_deg"} out.'
)
@click.option(
    "--python", metavar="MODULE:FUNCTION", help="push(theta) -> (dx, dy, dtheta): rad; m in the object's frame."
)
@click.option("--count", type=Whole(12, 3600), default=72, help="Orientations, of a program or function.")
@table_options
@result_options("probe.png and .json")
def probe_command(options: LoopOptions, json_target: str | None, **asked: Any) -> None:
    """Ask whether pushes depend on their direction, what friction ellipse does the same, and where it would lock in.

    MATERIAL, or --protocol, tells the object and its push; the surface is taken as isotropic. Give one of --data,
    --command and --python.
    """
    from cyclemap.cli.json_report import degrees
    from cyclemap.cli.output import PeopleConsole, publish
    from cyclemap.views.probe_page import probe_page, probe_sentences

    found = _probed(options, asked)
    report = {
        "pushes": len(found.theta),
        "found": found.found,
        "p_value": found.p_value,
        "harmonics": [
            {"outcome": f"{one.outcome}_{unit}", "order": one.order}
            | {name: scale * getattr(one, name) for name in ("amplitude", "lower", "upper")}
            for one in found.harmonics
            for unit, scale in [("deg", degrees(1.0)) if one.outcome == "dtheta" else ("mm", 1e3)]
        ],
        "axis_ratio": dict(zip(("value", "lower", "upper"), found.ratio, strict=True)),
        "axis_deg": degrees(found.anisotropy.ellipse_direction),
        "offset": dict(zip(("value", "lower", "upper"), found.offset, strict=True)),
        "offset_deg": degrees(found.anisotropy.offset_direction),
        "explained": found.explained,
        "locks_at_deg": [degrees(theta) for theta in found.stable] if found.found else [],
    }
    picture = publish(report, probe_page(found), asked["out"] / "probe", asked["picture_format"], json_target)
    if picture is not None:
        PeopleConsole().tell(*probe_sentences(found), f"picture: {picture}")


def _probed(options: LoopOptions, asked: dict[str, Any]) -> Probe:
    from dataclasses import replace

    from cyclemap.cli.settings import chosen_loop
    from cyclemap.evidence.push_probe import command_push, probe
    from cyclemap.mechanics import load_material

    given = [name for name in ("data", "program", "python") if asked[name] is not None]
    if len(given) != 1:
        raise InvalidInput("say what is probed by one of --data DATA, --command PROGRAM, --python MODULE:FUNCTION")
    loop = replace(chosen_loop(options, asked["data"])[0], material=load_material("isotropic"), accuracy=1e-6)
    if given == ["data"]:
        from cyclemap.evidence import load_pushes
        from cyclemap.evidence.push_probe import OUTCOMES, probe_pushes

        table = load_pushes(readable_data(asked["data"], asked["columns"], asked["units"], asked["out"])).table
        table = table.dropna(subset=["theta0", *OUTCOMES])
        if not len(table):
            raise InvalidInput(
                f"{asked['data']}: no push with a pose before and after it: x0, y0, theta0, x1, y1, theta1"
            )
        return probe_pushes(table["theta0"].to_numpy(), table[list(OUTCOMES)].to_numpy(), loop)
    if given == ["program"]:
        return probe(command_push(shlex.split(asked["program"])), loop, asked["count"])
    return probe(_function(asked["python"]), loop, asked["count"])


def _function(name: str) -> Any:
    import sys
    from importlib import import_module

    module, colon, function = name.partition(":")
    if not (module and colon and function):
        raise InvalidInput(f"--python {name}: give it as module:function")
    sys.path.insert(0, str(Path.cwd()))
    try:
        return getattr(import_module(module), function)
    except (ImportError, AttributeError) as error:
        raise InvalidInput(f"--python {name}: {error}") from error
