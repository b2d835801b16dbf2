"""`cyclemap probe`: does a simulator, or a robot, push alike in all directions? In sentences, JSON
and a picture.
"""

import shlex
import sys
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import click

from cyclemap.cli.commands import ProbeOptions
from cyclemap.cli.json_report import PLAIN_UNITS, UNITS
from cyclemap.cli.output import publish
from cyclemap.cli.readable_data import readable_data
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence import load_pushes
from cyclemap.evidence.motion_check import check_pushes
from cyclemap.evidence.push_probe import (
    OUTCOMES,
    Harmonic,
    Probe,
    Push,
    command_push,
    probe,
    probe_pushes,
)
from cyclemap.evidence.pushes.measured_strokes import told
from cyclemap.mechanics import load_material
from cyclemap.views.push_pages import probe_page, probe_sentences
from cyclemap.written import Json, degrees, json_of


def run_probe(asked: ProbeOptions) -> None:
    """Probe what is asked for, draw it, and print it for people or as JSON."""
    probed = _probed(asked)
    results = asked.results
    report = {
        "pushes": len(probed.theta),
        **json_of(probed, "found", "p_value"),
        "harmonics": [*map(_harmonic, probed.harmonics)],
        **json_of(probed, "ratio"),
        "axis_deg": degrees(probed.anisotropy.ellipse_direction),
        **json_of(probed, "offset"),
        "offset_deg": degrees(probed.anisotropy.offset_direction),
        **json_of(probed, "explained"),
        "locks_at_deg": degrees(probed.stable) if probed.found else [],
    }
    publish(report, probe_page(probed), results.out / "probe", results, *probe_sentences(probed))


def _harmonic(harmonic: Harmonic) -> Json:
    name = harmonic.outcome
    return {
        **json_of(harmonic, unit=PLAIN_UNITS[name]),
        "outcome": UNITS[name].named(name),
    }


def _probed(asked: ProbeOptions) -> Probe:
    if sum(given is not None for given in (asked.data, asked.program, asked.python)) != 1:
        raise InvalidInput(
            "say what is probed by one of --data DATA, --command PROGRAM, --python MODULE:FUNCTION"
        )
    loop = replace(
        asked.loop.chosen_loop(asked.data).loop,
        material=load_material("isotropic"),
        accuracy=1e-6,
    )
    if asked.data is not None:
        return _probed_data(asked, asked.data, loop)
    if asked.program is not None:
        return probe(command_push(shlex.split(asked.program)), loop, asked.count)
    return probe(_imported(str(asked.python)), loop, asked.count)


def _probed_data(asked: ProbeOptions, data: Path, loop: CollectionLoop) -> Probe:
    pushes = load_pushes(readable_data(data, asked.table, asked.results.out))
    for words in check_pushes(pushes, loop):
        click.echo(words, err=True)
    table = pushes.table.dropna(subset=["theta0", *OUTCOMES])
    if not len(table):
        raise InvalidInput(
            f"{data}: no push with a pose before and after it: x0, y0, theta0, x1, y1, theta1"
        )
    for name in ("object", "surface"):
        listed = sorted(told(table[name]))
        if len(listed) > 1:
            several = f"pushes of several {name}s, {', '.join(listed)[:80]}"
            raise InvalidInput(f"{data}: {several}: give a table of one")
    return probe_pushes(table["theta0"].to_numpy(), table[list(OUTCOMES)].to_numpy(), loop)


def _imported(name: str) -> Push:
    """The function MODULE:FUNCTION, its module looked for in the working directory, too."""
    module, colon, function = name.partition(":")
    if not (module and colon and function):
        raise InvalidInput(f"--python {name}: give it as module:function")
    sys.path.insert(0, str(Path.cwd()))
    try:
        push: Push = getattr(import_module(module), function)
    except (ImportError, AttributeError) as error:
        raise InvalidInput(f"--python {name}: {error}") from error
    return push
