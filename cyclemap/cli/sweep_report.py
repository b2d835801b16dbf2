"""The report of `cyclemap sweep` as JSON: swept keys in their units, angles in degrees."""

from pathlib import Path

from cyclemap.cli.json_numbers import number, numbers
from cyclemap.cli.json_report import Json
from cyclemap.sweeps.sweep_results import Sweep
from cyclemap.sweeps.sweep_store import SweepStatus


def status_report(status: SweepStatus, store: Path) -> Json:
    """How far a sweep is."""
    return {
        "store": str(store),
        "points": status.points,
        "stored": status.stored,
        "refused": status.refused,
        "complete": status.complete,
    }


def sweep_report(sweep: Sweep, store: Path) -> Json:
    """The whole sweep, one entry a point."""
    count = int(sweep.description["count"])
    status = SweepStatus(count, len(sweep), int(sweep.refused.sum()))
    plan = sweep.description["plan"]
    return {
        **status_report(status, store),
        "over": plan["points"],
        "settings": plan["settings"],
        "quantities": plan["quantities"],
        "units": {one.written_name: one.written_unit for one in sweep.quantities},
        "results": [_point(sweep, place) for place in range(len(sweep))],
    }


def _point(sweep: Sweep, place: int) -> Json:
    found: Json = {key: sweep.swept[key][place] for key in sweep.keys}
    for one in sweep.quantities:
        if one.listed:
            found[one.written_name] = numbers(one.written(value) for value in sweep.lists[one.name][place].tolist())
        else:
            found[one.written_name] = number(one.written(float(sweep.columns[one.name][place])))
    return {**found, "refusal": sweep.refusals[place] or None}
