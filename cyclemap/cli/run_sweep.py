"""`cyclemap sweep`: a sweep run or gone on with, stored, exported, drawn and told."""

import math
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import click

from cyclemap.cli.json_report import Json, number, numbers
from cyclemap.cli.options import LoopOptions
from cyclemap.cli.output import PeopleConsole, file_stem, progress_bar, publish_json
from cyclemap.cli.settings import set_settings, told_settings
from cyclemap.collection.settings import layered, warn_of_defaults
from cyclemap.errors import InvalidInput
from cyclemap.suggestions import unknown_name
from cyclemap.sweeps.point_sets import MATERIAL_KEY, Grid, Sample, parse_over
from cyclemap.sweeps.portrait_numbers import PortraitNumbers
from cyclemap.sweeps.run_sweep import run_sweep, sweep_status
from cyclemap.sweeps.sweep_curves import sweep_curves
from cyclemap.sweeps.sweep_plan import SweepPlan
from cyclemap.sweeps.sweep_results import Sweep, load_sweep, write_csv, write_netcdf
from cyclemap.sweeps.sweep_store import SweepStatus
from cyclemap.views.style import render
from cyclemap.views.sweep_page import sweep_headline, sweep_page, sweep_sentences
from cyclemap.whole_files import write_whole

_EXPORTS = {"csv": (".csv", write_csv), "netcdf": (".nc", write_netcdf)}
_MOST_DRAWN_KEYS = 2
_LONGEST_NAME = 60


@dataclass(frozen=True)
class SweepRequest:
    """What is asked of a sweep: its points and quantities, who works, and where and as what results go."""

    over: tuple[str, ...]
    sample: int | None
    seed: int
    sequence: str
    quantities: str
    tolerance_deg: float | None
    rotation_tolerance: float
    workers: int | None
    export: str
    draw: str
    status: bool
    out: Path
    picture_format: str


def run_sweep_command(options: LoopOptions, request: SweepRequest, json_target: str | None) -> None:
    """Run what is missing of the sweep, then export, draw and tell; with --status only tell how far it is."""
    exports, drawn = _words(request.export, _EXPORTS, "format to export"), _words(request.draw)
    plan = sweep_plan(options, request)
    _words(request.draw, [one.name for one in plan.numbers.quantities if not one.listed], "quantity to draw")
    # The material, or the first few letters of those that are swept.
    name = "_".join(plan.materials)[:_LONGEST_NAME] if MATERIAL_KEY in plan.keys else plan.materials[""].name
    stem = request.out / f"sweep_{file_stem(name)}"
    store = stem.with_name(f"{stem.name}.sqlite")
    if request.status:
        _tell_status(sweep_status(store, plan), store, json_target)
        return
    # Run what is missing; tell on Ctrl-C what is kept and how to go on.
    begun = time.monotonic()
    try:
        with progress_bar(f"sweep of {len(plan)} points") as report:
            run_sweep(
                plan, store, workers=request.workers, progress=lambda status: report(status.stored / status.points)
            )
    except KeyboardInterrupt:
        status = sweep_status(store, plan)
        kept = f"{status.stored} of {status.points} points are stored in {store}"
        click.echo(f"stopped after {time.monotonic() - begun:.0f} s: {kept}; the same command goes on", err=True)
        raise
    sweep = load_sweep(store, plan)
    files = [store, *_exported(sweep, stem, exports), *_drawn(sweep, stem, request, drawn)]
    if not publish_json(sweep_report(sweep, store), json_target):
        console = PeopleConsole()
        console.tell(sweep_headline(sweep), *sweep_sentences(sweep), *(f"file: {path}" for path in files))
        if len(sweep.keys) > _MOST_DRAWN_KEYS:
            console.print("more than two keys: select values of the others in Python, or export, to draw", style="dim")


def sweep_plan(options: LoopOptions, request: SweepRequest) -> SweepPlan:
    """The plan that the options ask for: what is swept overrules the protocol file, as --set does."""
    over = tuple(parse_over(text) for text in request.over)
    swept = {one.key for one in over}
    material, told, strategy = told_settings(options)
    if strategy is not None:
        raise InvalidInput(
            f"{options.protocol or material}: a sweep is about one push and one drag back: take the table [strategy] "
            "out of it"
        )
    # What is swept takes the place of what a file says, as --set does.
    settings = {key: value for key, value in layered(told, dict.fromkeys(swept)).items() if key not in swept}
    settings |= set_settings(options.settings)
    warn_of_defaults(settings)
    tolerance = {} if request.tolerance_deg is None else {"tolerance": math.radians(request.tolerance_deg)}
    numbers = PortraitNumbers(_words(request.quantities), rotation_tolerance=request.rotation_tolerance, **tolerance)
    if request.sample is None:
        return SweepPlan(Grid(over), material, settings, numbers)  # type: ignore[arg-type]
    return SweepPlan(Sample(over, request.sample, request.seed, request.sequence), material, settings, numbers)


def _words(text: str, known: Iterable[str] | None = None, what: str = "") -> tuple[str, ...]:
    """The words of a list by commas; InvalidInput for one that is not among those known."""
    words = tuple(word.strip() for word in text.split(",") if word.strip())
    for word in words:
        if known is not None and word not in known:
            raise unknown_name(what, word, known)
    return words


def _exported(sweep: Sweep, stem: Path, exports: tuple[str, ...]) -> list[Path]:
    written = []
    for name in exports:
        ending, write = _EXPORTS[name]
        written.append(stem.with_name(f"{stem.name}{ending}"))
        write(sweep, written[-1])
    return written


def _drawn(sweep: Sweep, stem: Path, request: SweepRequest, names: tuple[str, ...]) -> list[Path]:
    """The picture, where one or two keys are swept."""
    if len(sweep.keys) > _MOST_DRAWN_KEYS:
        return []
    if not sweep.axes and len(sweep.keys) == _MOST_DRAWN_KEYS and not all(map(sweep.is_numeric, sweep.keys)):
        return []
    picture = stem.with_name(f"{stem.name}.{request.picture_format}")
    page = sweep_page(sweep, sweep_curves(sweep, names))
    write_whole(picture, render(page, request.picture_format))
    return [picture]


def _tell_status(status: SweepStatus, store: Path, json_target: str | None) -> None:
    if publish_json(status_report(status, store), json_target):
        return
    share = 100.0 * status.stored / status.points
    told = "complete" if status.complete else f"{share:.0f} %"
    print_ = PeopleConsole().print
    print_(f"{store}: {status.stored} of {status.points} points stored ({told}), {status.refused} refused")


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
