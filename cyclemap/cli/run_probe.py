"""`cyclemap probe`: does a simulator, or a robot, push alike in all directions? In sentences, JSON
and a picture.
"""

import shlex
import sys
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.options import ResultOptions, readable_data
from cyclemap.cli.output import PeopleConsole, publish
from cyclemap.errors import InvalidInput
from cyclemap.evidence import load_pushes
from cyclemap.evidence.motion_check import check_pushes
from cyclemap.evidence.push_probe import OUTCOMES, Probe, command_push, probe, probe_pushes
from cyclemap.mechanics import load_material
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_loop
from cyclemap.views.probe_page import probe_page, probe_sentences
from cyclemap.written import degrees


def run_probe(options: LoopOptions, results: ResultOptions, **asked: Any) -> None:
    """Probe what is asked for, draw it, and print it for people or as JSON."""
    found = _probed(options, results.out, asked)
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
    picture = publish(report, probe_page(found), results.out / "probe", results)
    if picture is not None:
        PeopleConsole().tell(*probe_sentences(found), f"picture: {picture}")


def _probed(options: LoopOptions, out: Path, asked: dict[str, Any]) -> Probe:
    given = [name for name in ("data", "program", "python") if asked[name] is not None]
    if len(given) != 1:
        raise InvalidInput(
            "say what is probed by one of --data DATA, --command PROGRAM, --python MODULE:FUNCTION"
        )
    loop = replace(
        chosen_loop(options, asked["data"])[0], material=load_material("isotropic"), accuracy=1e-6
    )
    if given == ["data"]:
        pushes = load_pushes(readable_data(asked["data"], asked["table"], out))
        for words in check_pushes(pushes, loop):
            click.echo(words, err=True)
        table = pushes.table.dropna(subset=["theta0", *OUTCOMES])
        if not len(table):
            raise InvalidInput(
                f"{asked['data']}: no push with a pose before and after it: x0, y0, theta0, x1, "
                "y1, theta1"
            )
        return probe_pushes(table["theta0"].to_numpy(), table[list(OUTCOMES)].to_numpy(), loop)
    if given == ["program"]:
        return probe(command_push(shlex.split(asked["program"])), loop, asked["count"])
    name = asked["python"]
    module, colon, function = name.partition(":")
    if not (module and colon and function):
        raise InvalidInput(f"--python {name}: give it as module:function")
    sys.path.insert(0, str(Path.cwd()))
    try:
        push = getattr(import_module(module), function)
    except (ImportError, AttributeError) as error:
        raise InvalidInput(f"--python {name}: {error}") from error
    return probe(push, loop, asked["count"])
