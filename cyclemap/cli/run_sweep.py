"""`cyclemap sweep`: a sweep run or gone on with, stored, exported, drawn and told."""

import math
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

import click

from cyclemap import sweeps
from cyclemap.cli.commands import SweepOptions
from cyclemap.cli.options import is_said, words_of
from cyclemap.cli.output import (
    PeopleConsole,
    progress_bar,
    publish_json,
    result_name,
    styled,
)
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput, unknown_name
from cyclemap.protocol.chosen_loop import said_settings, set_settings, strategy_file
from cyclemap.protocol.settings import SETTINGS, layered, loop_from_settings, warn_of_defaults
from cyclemap.sweeps.point_sets import MATERIAL_KEY, Grid, Sample, parse_over
from cyclemap.sweeps.portrait_numbers import PortraitNumbers
from cyclemap.sweeps.sweep_plan import SweepPlan
from cyclemap.sweeps.sweep_results import Sweep, load_sweep, write_csv, write_netcdf
from cyclemap.sweeps.sweep_store import SweepStatus
from cyclemap.text_files import write_whole
from cyclemap.views.panels.layout import render
from cyclemap.views.sweep_page import sweep_headline, sweep_page, sweep_sentences
from cyclemap.written import Json, json_of, rows

_EXPORTS = {"csv": (".csv", write_csv), "netcdf": (".nc", write_netcdf)}
_MOST_DRAWN_KEYS = 2
_LONGEST_NAME = 60
_OBJECT_KEYS = {
    key for key, setting in SETTINGS.items() if setting.place in ("slider.outline", "slider.name")
}


def run_sweep(asked: SweepOptions) -> None:
    """Run what is missing of the sweep, then export, draw and tell; with --status only tell how far
    it is.
    """
    exports = _words(asked.export, _EXPORTS, "format to export")
    if asked.status and (exports or asked.draw):
        raise InvalidInput(
            "--status only tells how far the sweep is: leave --export and --draw out"
        )
    of_sample = [f"--{name}" for name in ("seed", "sequence") if is_said(name)]
    if of_sample and asked.sample is None:
        raise InvalidInput(
            f"{' and '.join(of_sample)}: a grid has none; give --sample N, or leave it out"
        )
    plan = sweep_plan(asked)
    drawable = [quantity.name for quantity in plan.numbers.quantities if not quantity.many]
    if _words(asked.draw, drawable, "quantity to draw") and len(plan.keys) > _MOST_DRAWN_KEYS:
        raise InvalidInput(
            f"--draw {asked.draw}: a picture is of one or two keys, not of {len(plan.keys)}; "
            "leave --draw out, or give fewer --over"
        )
    # The material, or the first few letters of those that are swept.
    name = (
        "_".join(plan.materials)[:_LONGEST_NAME]
        if MATERIAL_KEY in plan.keys
        else plan.materials[""].name
    )
    results = asked.results
    store = results.out / f"{result_name('sweep', _object_loop(plan), name)}.sqlite"
    if asked.status:
        now = sweeps.sweep_status(store, plan)
        done = "complete" if now.complete else f"{100.0 * now.stored / now.points:.0f} %"
        if not publish_json(_status_report(now, store), asked.results.json):
            stored = f"{now.stored} of {now.points} points stored ({done}), {now.refused} refused"
            PeopleConsole().print(f"{store}: {stored}")
        return
    begun = time.monotonic()
    try:
        with progress_bar(f"sweep of {len(plan)} points") as report:
            sweeps.run_sweep(
                plan,
                store,
                workers=asked.workers,
                progress=lambda now: report(now.stored / now.points),
            )
    except KeyboardInterrupt:
        now = sweeps.sweep_status(store, plan)
        kept = f"{now.stored} of {now.points} points are stored in {store}"
        click.echo(
            f"stopped after {time.monotonic() - begun:.0f} s: {kept}; the same command goes on",
            err=True,
        )
        raise
    _publish(load_sweep(store, plan), store, asked)


def _publish(sweep: Sweep, store: Path, asked: SweepOptions) -> None:
    files = [store]
    keys = len(sweep.keys)
    results = asked.results
    for name in _words(asked.export):
        ending, write = _EXPORTS[name]
        files.append(store.with_suffix(ending))
        write(sweep, files[-1])
    # One or two keys make a picture; two of a sample only where both are numbers.
    if keys < _MOST_DRAWN_KEYS or (
        keys == _MOST_DRAWN_KEYS and (sweep.axes or all(map(sweep.is_numeric, sweep.keys)))
    ):
        files.append(store.with_suffix(f".{results.format}"))
        page = sweep_page(sweep, _words(asked.draw))
        write_whole(files[-1], render(page, results.format))
    if publish_json(sweep_report(sweep, store), results.json):
        return
    undrawn = "more than two keys: select values of the others in Python, or export, to draw"
    PeopleConsole().tell(
        sweep_headline(sweep),
        *sweep_sentences(sweep),
        *(f"file: {path}" for path in files),
        styled(undrawn, "dim") if keys > _MOST_DRAWN_KEYS else "",
    )


def _object_loop(plan: SweepPlan) -> CollectionLoop:
    """The loop whose object the sweep is of: MIT's where objects are swept, or the first point
    makes none.
    """
    kept = {*_OBJECT_KEYS, "hitch_x_mm", "hitch_y_mm"}
    settings = {key: value for key, value in plan.point(0).settings.items() if key in kept}
    with suppress(InvalidInput):
        return (
            CollectionLoop.mit() if set(plan.keys) & _OBJECT_KEYS else loop_from_settings(settings)
        )
    return CollectionLoop.mit()


def sweep_plan(asked: SweepOptions) -> SweepPlan:
    """The plan that the options ask for: what is swept overrules the protocol file,
    as --set does."""
    ranges = tuple(map(parse_over, asked.over))
    swept = {over.key for over in ranges}
    loop = asked.loop
    material, given, strategy = said_settings(loop.surface, loop.protocol, loop.settings)
    if strategy is not None:
        raise InvalidInput(
            f"{strategy_file(loop.surface, loop.protocol)}: a sweep is about one push and one drag "
            "back: take the table [strategy] out of it"
        )
    # What is swept takes the place of what a file says, as --set does.
    settings = {
        key: value
        for key, value in layered(given, dict.fromkeys(swept)).items()
        if key not in swept
    }
    settings |= set_settings(loop.settings)
    warn_of_defaults({**dict.fromkeys(swept), **settings})
    tolerance = (
        {} if asked.tolerance_deg is None else {"tolerance": math.radians(asked.tolerance_deg)}
    )
    numbers = PortraitNumbers(
        _words(asked.quantities), rotation_tolerance=asked.rotation_tolerance, **tolerance
    )
    points: Grid | Sample = (
        Grid(ranges)  # type: ignore[arg-type]
        if asked.sample is None
        else Sample(ranges, asked.sample, asked.seed, asked.sequence)
    )
    return SweepPlan(points, material, settings, numbers)


def _words(text: str, known: Iterable[str] | None = None, what: str = "") -> tuple[str, ...]:
    """The words of a list by commas; InvalidInput for one that is not among those known."""
    words = tuple(words_of(text))
    for word in words:
        if known is not None and word not in known:
            raise unknown_name(what, word, known)
    return words


def sweep_report(sweep: Sweep, store: Path) -> Json:
    """The whole sweep, one entry a point."""
    status = SweepStatus(int(sweep.description["count"]), len(sweep), int(sweep.refused.sum()))
    plan = sweep.description["plan"]
    columns: dict[str, object] = {key: sweep.table[key] for key in sweep.keys}
    for quantity in sweep.quantities:
        columns[quantity.written_name] = map(quantity.written, sweep.table[quantity.name])
    refusals = [refusal or None for refusal in sweep.table["refusal"]]
    return {
        **_status_report(status, store),
        "over": plan["points"],
        "settings": plan["settings"],
        "quantities": plan["quantities"],
        "units": {column.written_name: column.written_unit for column in sweep.quantities},
        "results": rows(**columns, refusal=refusals),
    }


def _status_report(status: SweepStatus, store: Path) -> Json:
    return {"store": str(store), **json_of(status, "points", "stored", "refused", "complete")}
