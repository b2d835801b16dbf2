"""`cyclemap fit`: laws fitted to measured pushes, in tables and sentences, as JSON, and as a
picture of each set.
"""

import math
from collections.abc import Callable, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

import click
import numpy as np
from rich.table import Table

from cyclemap.cli.json_report import Json, degrees, multiplier_report, number, numbers, numbers_of
from cyclemap.cli.options import ResultOptions, TableOptions, readable_data
from cyclemap.cli.output import (
    PeopleConsole,
    file_stem,
    people_table,
    progress_bar,
    publish_json,
    write_result,
)
from cyclemap.errors import CycleMapError, InvalidInput, unknown_name
from cyclemap.evidence import PushTable, UnreadableFile, load_pushes
from cyclemap.evidence.motion_check import check_pushes
from cyclemap.evidence.pushes.theta0_pairs import AngleHistogram, covered_arcs
from cyclemap.evidence.tables.measured_cycle_map import (
    MapState,
    MeasuredCycleMap,
    TurnPlace,
    WornForecast,
)
from cyclemap.evidence.tables.push_sets import MotionStatistics, push_sets
from cyclemap.evidence.tables.set_fit import MotionLaw, SetFit, fit_set
from cyclemap.plain_text import plain_number
from cyclemap.protocol.chosen_loop import loop_beside
from cyclemap.views.fit_page import fit_page, set_sentences

# Bad files are told by name up to this many, and counted beyond.
MOST_NAMED = 10
SELECT_KEYS = {
    "surface": ("surface", None),
    "object": ("object", None),
    "shape": ("object", None),
    "speed_mm_s": ("speed", 1e-3),
    "side": ("side", 1.0),
    "fraction": ("fraction", 1.0),
    "angle_deg": ("angle", math.radians(1.0)),
}
# Quantities: their heading, and their unit in the report with the factor to it.
QUANTITIES = {"dtheta": "Δθ (°)", "dx": "Δx (mm)", "dy": "Δy (mm)"}
UNITS = {"dtheta": ("deg", math.degrees(1.0)), "dx": ("mm", 1000.0), "dy": ("mm", 1000.0)}
# Facts of a set by their names in the report, and the factor to its units.
FACTS = {
    "acceleration": ("acceleration_mm_s2", 1000.0),
    "speed": ("speed_mm_s", 1000.0),
    "side": ("side", 1.0),
    "fraction": ("fraction", 1.0),
    "angle": ("angle_deg", math.degrees(1.0)),
}
# Titles of the tables: per cent and RMSE as in the paper, RMSE in pushes left out, order of the
# law.
STATISTICS = "Pushes: mean, standard deviation σ, and σ in per cent of the mean"
LAWS = "Laws of θ0: RMSE, its per cent of the mean, RMSE in pushes left out (cv), harmonics (K)"
NOTHING = "–"
# A percentage of a mean near 0 says nothing but that.
MOST_PERCENT = 1000.0
NOTE_LETTERS = 60


def run_fit(
    data: Path,
    table: TableOptions,
    select: tuple[str, ...],
    harmonics: int | None,
    wear: bool,
    seed: int,
    results: ResultOptions,
) -> None:
    """Read the pushes, fit every set of them, write pictures and JSON, and print for people or as
    JSON.
    """
    read, chosen = readable_data(data, table, results.out), selected_values(select)
    with progress_bar(f"reading {data.name}") as report:
        pushes = load_pushes(read, progress=report)
    if not len(pushes.table) and pushes.unreadable:
        raise CycleMapError(f"{data}: no push could be read: {reasons_of(pushes.unreadable)}")
    if not len(pushes.table):
        raise InvalidInput(
            f"{data}: holds {len(pushes.scans)} friction scans and no push; give pushes to fit"
        )
    for words in check_pushes(pushes, loop_beside(data)):
        click.echo(words, err=True)
    sets, fits, pictures = push_sets(pushes, chosen), list[SetFit](), list[Path]()
    with progress_bar("fitting") as report:
        for one in sets:

            def share(fraction: float) -> None:
                report((len(fits) + fraction) / len(sets))

            fits.append(fit_set(one, harmonics=harmonics, wear=wear, seed=seed, progress=share))
    for fit in (one for one in fits if not one.is_empty):
        stem = results.out / f"fit_{file_stem(fit.pushes.name)}"
        pictures.append(write_result(set_report(fit), fit_page(fit), stem, results.picture_format))
    if publish_json(fit_report(pushes, fits), results.json_target):
        return
    console = PeopleConsole()
    scans = f" and {len(pushes.scans)} friction scans" if len(pushes.scans) else ""
    console.print(
        f"{len(pushes.table)} pushes{scans} read, in {len(fits)} set{'s' * (len(fits) != 1)}",
        style="bold",
    )
    for file in pushes.unreadable[:MOST_NAMED]:
        console.print(f"could not be read: {file.path}: {file.reason}")
    if len(pushes.unreadable) > MOST_NAMED:
        console.print(f"could not be read: {len(pushes.unreadable)} files in all")
    if any(fit.pushes.has_motion for fit in fits):
        console.print_table(
            _table(
                STATISTICS, [fit.statistics for fit in fits], _statistic_fields, "mean", "σ", "%"
            )
        )
        console.print_table(
            _table(LAWS, [fit.laws for fit in fits], _law_fields, "RMSE", "%", "cv", "K")
        )
    told = ["\n".join(set_sentences(fit)) for fit in fits if not fit.is_empty]
    for line in (
        *(told or ["nothing could be fitted: no set has enough pushes"]),
        *(f"picture: {one}" for one in pictures),
    ):
        console.print(line)


def selected_values(pairs: tuple[str, ...]) -> dict[str, str | float]:
    """The columns and values of `key=value` texts, in SI units and radians; `shape` is another word
    for `object`.

    >>> selected_values(("surface=plywood", "speed_mm_s=20"))
    {'surface': 'plywood', 'speed': 0.02}
    """
    values: dict[str, str | float] = {}
    for pair in pairs:
        key, equals, text = (part.strip() for part in pair.partition("="))
        if not (key and equals and text):
            raise InvalidInput(f"--select {pair!r} is not of the form key=value")
        if key not in SELECT_KEYS:
            raise unknown_name("selection", key, SELECT_KEYS)
        column, unit = SELECT_KEYS[key]
        values[column] = text
        if unit is not None:
            try:
                values[column] = value = unit * plain_number(text)
            except ValueError:
                value = math.nan
            if not math.isfinite(value):
                raise InvalidInput(f"--select {key}={text}: give a finite number")
    return values


def reasons_of(left_out: Sequence[UnreadableFile]) -> str:
    """Why files were left out, the first of them by name, the others counted."""
    told = "; ".join(f"{file.path}: {file.reason}" for file in left_out[:MOST_NAMED])
    return told + (f"; and {len(left_out) - MOST_NAMED} more" if len(left_out) > MOST_NAMED else "")


def fit_report(pushes: PushTable, fits: list[SetFit]) -> Json:
    """The report of a whole collection: what was read, what could not be, and every set."""
    unreadable = [{"path": str(file.path), "reason": file.reason} for file in pushes.unreadable]
    return {
        "pushes": len(pushes.table),
        "scans": len(pushes.scans),
        "unreadable": unreadable,
        "sets": [set_report(fit) for fit in fits],
    }


def set_report(fit: SetFit) -> Json:
    """The report of one set, as fit_NAME.json holds it."""
    pushes = fit.pushes
    told: Json = {name: fit.pushes.facts.get(name) for name in ("surface", "object")}
    for column, (name, unit) in FACTS.items():
        value = fit.pushes.facts.get(column)
        told[name] = None if value is None else number(unit * value)
    found = fit.histogram
    given = {name: getattr(fit.statistics, name) for name in UNITS}
    return {
        "name": pushes.name,
        "source": str(pushes.source),
        **told,
        "contacts": pushes.contacts,
        "pushes": pushes.count,
        "covered_deg": [[degrees(edge) for edge in arc] for arc in covered_arcs(pushes.theta)]
        if pushes.count
        else [],
        "statistics": {
            "problem": fit.statistics.problem,
            **{
                name: None if one is None else _statistics_report(one, *UNITS[name])
                for name, one in given.items()
            },
        },
        "laws": {law.quantity: _law(law) for law in fit.laws.laws},
        "dtheta_histogram": None
        if found is None
        else {
            "edges_deg": numbers(np.degrees(found.edges)),
            "measured": found.measured.tolist(),
            "predicted": numbers(found.predicted.tolist()),
            "law_alone": numbers(found.law_alone.tolist()),
            **numbers_of(found, "total_variation", "chance_total_variation"),
            "p_value": number(found.chance.value),
            "distance_deg": degrees(found.distance),
            "law_alone_total_variation": number(found.law_alone_total_variation),
            "law_alone_distance_deg": degrees(found.law_alone_distance),
        },
        "last_cycles": multiplier_report(fit.rest),
        "cycle_map": {"problem": fit.map_problem}
        if fit.cycle_map is None
        else _cycle_map(fit.cycle_map),
    }


def _statistics_report(statistics: MotionStatistics, unit: str, scale: float) -> Json:
    sizes = {
        f"{name}_{unit}": number(scale * getattr(statistics, name)) for name in ("mean", "std")
    }
    return {"count": statistics.count, **sizes, "percent": number(statistics.percent)}


def _law(found: MotionLaw) -> Json:
    law, (unit, scale) = found.law, UNITS[found.quantity]
    if law is None:
        return {"problem": found.problem}
    noise = law.noise(np.linspace(0.0, 2 * np.pi, 361))
    return {
        "problem": None,
        "count": law.count,
        "harmonics": law.harmonics,
        f"rmse_{unit}": number(scale * law.rmse),
        "percent": number(law.percent),
        f"cross_validated_rmse_{unit}": number(scale * found.cross_validated_rmse),
        "explained": number(found.explained),
        f"scatter_{unit}": number(scale * law.sigma),
        f"least_scatter_{unit}": number(scale * float(np.min(noise))),
        f"most_scatter_{unit}": number(scale * float(np.max(noise))),
        "lag_correlation": number(law.lag_correlation),
        f"cosine_{unit}": numbers(scale * law.cosine),
        f"sine_{unit}": numbers(scale * law.sine),
        "log_variance": numbers(law.log_variance.tolist()),
    }


def _cycle_map(found: MeasuredCycleMap) -> Json:
    law = found.fitted.law if found.fitted.wear is None else found.fitted.wear.whole
    return {
        "problem": None,
        "pairs": int(found.pairs.theta.size),
        "dropped": dict(found.pairs.dropped),
        "harmonics": law.harmonics,
        "wear_degree": None if found.fitted.wear is None else found.fitted.wear.degree,
        "rmse_deg": degrees(law.rmse),
        "rmse_without_wear_deg": degrees(found.fitted.law.rmse),
        "scatter_deg": degrees(law.sigma),
        "least_scatter": _place(found.quietest, "scatter_deg"),
        "most_scatter": _place(found.loudest, "scatter_deg"),
        "lag_correlation": number(law.lag_correlation),
        "early": _state(found.early),
        "late": _state(found.late),
        "forecast": None if found.forecast is None else _forecast(found.forecast),
    }


def _place(place: tuple[float, float], name: str) -> Json:
    return {"theta_deg": degrees(place[0]), name: degrees(place[1])}


def _state(state: MapState) -> Json:
    return {
        "cycle": number(state.cycle),
        "fixed_points": [
            {
                "theta_deg": degrees(orbit.points[0]),
                "multiplier": number(orbit.multiplier),
                "kind": orbit.kind,
            }
            for orbit in state.fixed_points
        ],
        "bottlenecks": [
            {**_turn_place(p), "cycles": number(p.cycles or math.nan)} for p in state.passages
        ],
        "undecided": [_turn_place(p) for p in state.undecided],
        "slowest": _turn_place(state.slowest),
    }


def _turn_place(place: TurnPlace) -> Json:
    edges = [degrees(place.lower), degrees(place.upper)]
    return {
        "theta_deg": degrees(place.theta),
        "turn_deg": degrees(place.turn),
        "turn_95_deg": edges,
    }


def _forecast(found: WornForecast) -> Json:
    low, high = np.quantile(found.turns, [0.025, 0.975])
    pace = found.pace
    columns = zip(pace.start, pace.measured, pace.predicted, pace.lower, pace.upper, strict=True)
    return {
        **numbers_of(found, "first_cycle", "measured_turns", "left_out_turns"),
        "predicted_turns": number(float(np.mean(found.turns))),
        "predicted_turns_std": number(float(np.std(found.turns))),
        "predicted_turns_95": [number(float(low)), number(float(high))],
        "full_turns": [
            {
                "start_cycle": number(start),
                "measured_pushes": number(measured),
                "predicted_pushes": number(predicted),
                "predicted_95": [number(low), number(high)],
            }
            for start, measured, predicted, low, high in columns
        ],
        "peak_deg": _peak(found.measured_histogram),
        "predicted_peak_deg": _peak(found.histogram),
        "total_variation": number(found.total_variation),
        "wasserstein_deg": degrees(found.wasserstein),
    }


def _peak(histogram: AngleHistogram) -> list[float]:
    """The ends of the highest bin."""
    highest = int(np.argmax(histogram.density))
    return [round(float(edge), 9) for edge in np.degrees(histogram.edges[highest : highest + 2])]


def _table(
    title: str, parts: Sequence[Any], fields: Callable[[Any, float], list[str]], *columns: str
) -> Table:
    notes, rows = any(part.problem for part in parts), []
    for part in parts:
        told = chain.from_iterable(
            fields(getattr(part, name), scale) for name, (_, scale) in UNITS.items()
        )
        rows.append((part.name, str(part.count), *told, *([part.problem or ""] if notes else [])))
    named = [
        f"{label if column == columns[0] else ''}\n{column}"
        for label in QUANTITIES.values()
        for column in columns
    ]
    table = people_table(
        title, ("set", "pushes", *named, *["note"] * notes), rows, words=(0, 2 + len(named))
    )
    if notes:
        table.columns[-1].max_width = NOTE_LETTERS
    return table


def _statistic_fields(statistics: MotionStatistics | None, unit: float) -> list[str]:
    if statistics is None:
        return [NOTHING] * 3
    return [
        f"{unit * statistics.mean:.2f}",
        f"{unit * statistics.std:.2f}",
        _percent(statistics.percent),
    ]


def _percent(value: float) -> str:
    return f"{value:.2f}" if value < MOST_PERCENT else f">{MOST_PERCENT:.0f}"


def _law_fields(found: MotionLaw, unit: float) -> list[str]:
    law = found.law
    if law is None:
        return [NOTHING] * 4
    errors = (
        f"{unit * law.rmse:.2f}",
        _percent(law.percent),
        f"{unit * found.cross_validated_rmse:.2f}",
    )
    return [*errors, str(law.harmonics)]
