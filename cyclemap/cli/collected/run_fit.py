"""`cyclemap fit`: laws fitted to measured pushes, in tables and sentences, as JSON, and as a
picture of each set.
"""

import math
from collections.abc import Sequence
from itertools import chain, starmap
from pathlib import Path

import click
import numpy as np
from rich.table import Table

from cyclemap.cli.commands import FitOptions
from cyclemap.cli.json_report import FACT_UNITS, UNITS, facts_report
from cyclemap.cli.output import (
    PeopleConsole,
    file_stem,
    people_table,
    progress_bar,
    publish_json,
    write_result,
)
from cyclemap.cli.readable_data import readable_data
from cyclemap.errors import CycleMapError, InvalidInput, unknown_name
from cyclemap.evidence import PushTable, UnreadableFile, load_pushes
from cyclemap.evidence.laws.measured_cycle_map import (
    MapState,
    MeasuredCycleMap,
    TurnPlace,
    WornForecast,
)
from cyclemap.evidence.laws.push_sets import MotionStatistics, push_sets
from cyclemap.evidence.laws.set_fit import MotionLaw, SetFit, TurnHistogram, fit_set
from cyclemap.evidence.laws.turn_bins import AngleHistogram, covered_arcs
from cyclemap.evidence.motion_check import check_pushes
from cyclemap.plain_text import plain_number
from cyclemap.progress import part_of
from cyclemap.protocol.chosen_loop import loop_beside
from cyclemap.views.fit_page import fit_page, set_sentences
from cyclemap.written import DEGREES, Json, Unit, degrees, json_of, rows, written

# Bad files are told by name up to this many, and counted beyond.
MOST_NAMED = 10
# Facts by which pushes are selected, and the names of these in the files.
SELECT_KEYS = {
    unit.named(fact): fact for fact, unit in FACT_UNITS.items() if fact != "acceleration"
} | {"shape": "object"}
_TEXTS = ("surface", "object")
# Headings of what a push changes.
QUANTITIES = {"dtheta": "Δθ (°)", "dx": "Δx (mm)", "dy": "Δy (mm)"}
# Titles of the tables: per cent and RMSE as in the paper, RMSE in pushes left out, order of the
# law.
STATISTICS = "Pushes: mean, standard deviation σ, and σ in per cent of the mean"
LAWS = "Laws of θ0: RMSE, its per cent of the mean, RMSE in pushes left out (cv), harmonics (K)"
NOTHING = "–"
# A percentage of a mean near 0 says nothing but that.
MOST_PERCENT = 1000.0
NOTE_LETTERS = 60


def run_fit(asked: FitOptions) -> None:
    """Read the pushes, fit every set of them, write pictures and JSON, and print for people or as
    JSON.
    """
    data = asked.data
    results = asked.results
    read = readable_data(data, asked.table, results.out)
    selected = selected_values(asked.select)
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
    sets = push_sets(pushes, selected)
    fits = list[SetFit]()
    pictures = list[Path]()
    with progress_bar("fitting") as report:
        for index, pushed_alike in enumerate(sets):
            share = part_of(report, index, len(sets))
            fits.append(
                fit_set(
                    pushed_alike,
                    harmonics=asked.harmonics,
                    wear=asked.wear,
                    seed=asked.seed,
                    progress=share,
                )
            )
    for fit in (fit for fit in fits if not fit.is_empty):
        stem = results.out / f"fit_{file_stem(fit.pushes.name)}"
        pictures.append(write_result(set_report(fit), fit_page(fit), stem, results.format))
    if publish_json(fit_report(pushes, fits), results.json):
        return
    _tell(pushes, fits, pictures)


def _tell(pushes: PushTable, fits: Sequence[SetFit], pictures: Sequence[Path]) -> None:
    """Tell people what was read and fitted, and where it is drawn."""
    scans = f" and {len(pushes.scans)} friction scans" if len(pushes.scans) else ""
    unreadable = [f"{file.path}: {file.reason}" for file in pushes.unreadable[:MOST_NAMED]]
    if len(pushes.unreadable) > MOST_NAMED:
        unreadable.append(f"{len(pushes.unreadable)} files in all")
    tables = []
    if any(fit.pushes.has_motion for fit in fits):
        statistics = []
        laws = []
        for fit in fits:
            row = fit.statistics
            name = fit.pushes.name
            count = str(fit.pushes.count)
            moments = zip((row.dtheta, row.dx, row.dy), UNITS.values(), strict=True)
            cells = chain.from_iterable(starmap(_statistic_fields, moments))
            statistics.append((name, count, *cells, row.problem or ""))
            of_laws = zip(fit.laws, UNITS.values(), strict=True)
            cells = chain.from_iterable(starmap(_law_fields, of_laws))
            laws.append((name, count, *cells, fit.law_problem or ""))
        tables = [
            _table(STATISTICS, statistics, "mean", "σ", "%"),
            _table(LAWS, laws, "RMSE", "%", "cv", "K"),
        ]
    sentences = ["\n".join(set_sentences(fit)) for fit in fits if not fit.is_empty]
    PeopleConsole().tell(
        f"{len(pushes.table)} pushes{scans} read, in {len(fits)} set{'s' * (len(fits) != 1)}",
        *(f"could not be read: {line}" for line in unreadable),
        *tables,
        *(sentences or ["nothing could be fitted: no set has enough pushes"]),
        *(f"picture: {picture}" for picture in pictures),
    )


def selected_values(pairs: tuple[str, ...]) -> dict[str, str | float]:
    """The columns and values of `key=value` texts, in SI units and radians; `shape` is another word
    for `object`.

    >>> selected_values(("surface=plywood", "speed_mm_s=20"))
    {'surface': 'plywood', 'speed': 0.02}
    """
    values: dict[str, str | float] = {}
    for pair in pairs:
        key, equals, text = (word.strip() for word in pair.partition("="))
        if not (key and equals and text):
            raise InvalidInput(f"--select {pair!r} is not of the form key=value")
        if key not in SELECT_KEYS:
            raise unknown_name("selection", key, SELECT_KEYS)
        column = SELECT_KEYS[key]
        values[column] = text
        if column not in _TEXTS:
            try:
                values[column] = value = plain_number(text) / FACT_UNITS[column].of_si(1.0)
            except ValueError:
                value = math.nan
            if not math.isfinite(value):
                raise InvalidInput(f"--select {key}={text}: give a finite number")
    return values


def reasons_of(left_out: Sequence[UnreadableFile]) -> str:
    """Why files were left out, the first of them by name, the others counted."""
    named = "; ".join(f"{file.path}: {file.reason}" for file in left_out[:MOST_NAMED])
    return named + (
        f"; and {len(left_out) - MOST_NAMED} more" if len(left_out) > MOST_NAMED else ""
    )


def fit_report(pushes: PushTable, fits: list[SetFit]) -> Json:
    """The report of a whole collection: what was read, what could not be, and every set."""
    return {
        "pushes": len(pushes.table),
        "scans": len(pushes.scans),
        "unreadable": written(pushes.unreadable),
        "sets": [set_report(fit) for fit in fits],
    }


def set_report(fit: SetFit) -> Json:
    """The report of one set, as fit_NAME.json holds it."""
    pushes = fit.pushes
    statistics = fit.statistics
    return {
        **json_of(pushes, "name", "source"),
        **facts_report(pushes.facts),
        "contacts": pushes.contacts,
        "pushes": pushes.count,
        "covered_deg": degrees(covered_arcs(pushes.theta)) if pushes.count else [],
        "statistics": {
            "problem": statistics.problem,
            **{name: _statistics(getattr(statistics, name), UNITS[name]) for name in UNITS},
        },
        "laws": {law.quantity: _law(law) for law in fit.laws},
        "dtheta_histogram": None if fit.histogram is None else _histogram(fit.histogram),
        "last_cycles": written(fit.rest),
        "cycle_map": {"problem": fit.map_problem}
        if fit.cycle_map is None
        else _cycle_map(fit.cycle_map),
    }


def _statistics(statistics: MotionStatistics | None, unit: Unit) -> Json | None:
    if statistics is None:
        return None
    return {
        **json_of(statistics, "count"),
        **json_of(statistics, "mean", "std", unit=unit),
        **json_of(statistics, "percent"),
    }


def _histogram(histogram: TurnHistogram) -> Json:
    return {
        **json_of(histogram, "edges", unit=DEGREES),
        **json_of(histogram, "measured", "predicted", "law_alone", "total_variation"),
        **json_of(histogram, "chance_total_variation"),
        "p_value": written(histogram.chance.value),
        **json_of(histogram, "distance", unit=DEGREES),
        **json_of(histogram, "law_alone_total_variation"),
        **json_of(histogram, "law_alone_distance", unit=DEGREES),
    }


def _law(motion: MotionLaw) -> Json:
    law = motion.law
    unit = UNITS[motion.quantity]
    if law is None:
        return json_of(motion, "problem")
    noise = law.noise(np.linspace(0.0, 2 * np.pi, 361))
    return {
        **json_of(motion, "problem"),
        **json_of(law, "count", "harmonics"),
        **json_of(law, "rmse", unit=unit),
        **json_of(law, "percent"),
        **json_of(motion, "cross_validated_rmse", unit=unit),
        **json_of(motion, "explained"),
        **json_of(law, "sigma", unit=unit),
        f"least_scatter_{unit.ending}": written(np.min(noise), unit),
        f"most_scatter_{unit.ending}": written(np.max(noise), unit),
        **json_of(law, "lag_correlation"),
        **json_of(law, "cosine", "sine", unit=unit),
        **json_of(law, "log_variance"),
    }


def _cycle_map(measured: MeasuredCycleMap) -> Json:
    wear = measured.fitted.wear
    law = measured.fitted.law if wear is None else wear.whole
    return {
        "problem": None,
        "pairs": measured.pairs.theta.size,
        "dropped": dict(measured.pairs.dropped),
        "harmonics": law.harmonics,
        "wear_degree": None if wear is None else wear.degree,
        **json_of(law, "rmse", unit=DEGREES),
        "rmse_without_wear_deg": degrees(measured.fitted.law.rmse),
        **json_of(law, "sigma", unit=DEGREES),
        **json_of(measured, "quietest", "loudest"),
        **json_of(law, "lag_correlation"),
        "early": _state(measured.early),
        "late": _state(measured.late),
        "forecast": None if measured.forecast is None else _forecast(measured.forecast),
    }


def _state(state: MapState) -> Json:
    return {
        **json_of(state, "cycle"),
        "fixed_points": [
            {"theta_deg": degrees(orbit.points[0]), **json_of(orbit, "multiplier", "kind")}
            for orbit in state.fixed_points
        ],
        "bottlenecks": [
            {**_turn_place(place), "cycles": place.cycles or None} for place in state.passages
        ],
        "undecided": [*map(_turn_place, state.undecided)],
        "slowest": _turn_place(state.slowest),
    }


def _turn_place(place: TurnPlace) -> Json:
    return {**json_of(place, "theta", "turn"), "turn_95_deg": degrees((place.lower, place.upper))}


def _forecast(forecast: WornForecast) -> Json:
    pace = forecast.pace
    return {
        **json_of(forecast, "first_cycle", "measured_turns", "left_out_turns"),
        "predicted_turns": written(np.mean(forecast.turns)),
        "predicted_turns_std": written(np.std(forecast.turns)),
        "predicted_turns_95": written(np.quantile(forecast.turns, [0.025, 0.975])),
        "full_turns": rows(
            start_cycle=pace.start,
            measured_pushes=pace.measured,
            predicted_pushes=pace.predicted,
            predicted_95=np.column_stack([pace.lower, pace.upper]),
        ),
        "peak_deg": _peak(forecast.measured_histogram),
        "predicted_peak_deg": _peak(forecast.histogram),
        **json_of(forecast, "total_variation", "wasserstein"),
    }


def _peak(histogram: AngleHistogram) -> list[float]:
    """The ends of the highest bin."""
    highest = int(np.argmax(histogram.density))
    return [round(float(edge), 9) for edge in np.degrees(histogram.edges[highest : highest + 2])]


def _table(title: str, lines: Sequence[tuple[str, ...]], *columns: str) -> Table:
    """A row a set, its last cell a note; without notes no column of them."""
    notes = any(line[-1] for line in lines)
    named = [
        f"{label if column == columns[0] else ''}\n{column}"
        for label in QUANTITIES.values()
        for column in columns
    ]
    table = people_table(
        title,
        ("set", "pushes", *named, *["note"] * notes),
        lines if notes else [line[:-1] for line in lines],
        words=(0, 2 + len(named)),
    )
    if notes:
        table.columns[-1].max_width = NOTE_LETTERS
    return table


def _statistic_fields(statistics: MotionStatistics | None, unit: Unit) -> list[str]:
    if statistics is None:
        return [NOTHING] * 3
    return [
        f"{unit.of_si(statistics.mean):.2f}",
        f"{unit.of_si(statistics.std):.2f}",
        _percent(statistics.percent),
    ]


def _percent(value: float) -> str:
    return f"{value:.2f}" if value < MOST_PERCENT else f">{MOST_PERCENT:.0f}"


def _law_fields(motion: MotionLaw, unit: Unit) -> list[str]:
    law = motion.law
    if law is None:
        return [NOTHING] * 4
    errors = (
        f"{unit.of_si(law.rmse):.2f}",
        _percent(law.percent),
        f"{unit.of_si(motion.cross_validated_rmse):.2f}",
    )
    return [*errors, str(law.harmonics)]
