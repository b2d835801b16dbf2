"""`cyclemap fit`: laws fitted to measured pushes, in tables and sentences, as JSON, and as a
picture of each set.
"""

from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np
from rich.table import Table

from cyclemap.arrays import TWO_PI
from cyclemap.cli.collected.readable_data import (
    UNITS,
    facts_report,
    readable_data,
    reasons_of,
    selected_values,
)
from cyclemap.cli.commands import FitOptions
from cyclemap.cli.output import (
    PeopleConsole,
    file_stem,
    people_table,
    progress_bar,
    publish_json,
    write_result,
)
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.evidence import PushTable, load_pushes
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
from cyclemap.progress import part_of
from cyclemap.protocol.chosen_loop import loop_beside
from cyclemap.views.fit_page import fit_page, set_sentences
from cyclemap.written import DEGREES, Json, Unit, degrees, if_known, json_of, rows, written

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
        reasons = "; ".join(reasons_of(pushes.unreadable))
        raise CycleMapError(f"{data}: no push could be read: {reasons}")
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
    for fit in fits:
        if not fit.is_empty:
            name = f"fit_{file_stem(fit.pushes.name)}"
            pictures.append(write_result(set_report(fit), fit_page(fit), results, name))
    as_json: Json = {
        "pushes": len(pushes.table),
        "scans": len(pushes.scans),
        "unreadable": written(pushes.unreadable),
        "sets": [set_report(fit) for fit in fits],
    }
    if not publish_json(as_json, results.json):
        _tell(pushes, fits, pictures)


def _tell(pushes: PushTable, fits: Sequence[SetFit], pictures: Sequence[Path]) -> None:
    """Tell people what was read and fitted, and where it is drawn."""
    scans = f" and {len(pushes.scans)} friction scans" if len(pushes.scans) else ""
    tables = []
    if any(fit.pushes.has_motion for fit in fits):
        statistics = [(*_statistic_cells(fit), fit.statistics.problem or "") for fit in fits]
        laws = [(*_law_cells(fit), fit.law_problem or "") for fit in fits]
        tables = [
            _table(STATISTICS, fits, statistics, "mean", "σ", "%"),
            _table(LAWS, fits, laws, "RMSE", "%", "cv", "K"),
        ]
    sentences = ["\n".join(set_sentences(fit)) for fit in fits if not fit.is_empty]
    PeopleConsole().tell(
        f"{len(pushes.table)} pushes{scans} read, in {len(fits)} set{'s' * (len(fits) != 1)}",
        *(f"could not be read: {reason}" for reason in reasons_of(pushes.unreadable)),
        *tables,
        *(sentences or ["nothing could be fitted", *_largest_in_words(fits)]),
        *(f"picture: {picture}" for picture in pictures),
    )


def _largest_in_words(fits: Sequence[SetFit]) -> list[str]:
    """What the largest set is, and why nothing was fitted to it."""
    largest = max(fits, key=lambda fit: fit.pushes.count)
    law = largest.law_problem if largest.pushes.has_motion else None
    return [*set_sentences(largest), *([f"No law: {law}."] if law else [])]


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
            **{name: _moments(getattr(statistics, name), unit) for name, unit in UNITS.items()},
        },
        "laws": {law.quantity: _law(law) for law in fit.laws},
        "dtheta_histogram": if_known(_histogram, fit.histogram),
        "last_cycles": written(fit.rest),
        "cycle_map": {"problem": fit.map_problem}
        if fit.cycle_map is None
        else _cycle_map(fit.cycle_map),
    }


def _moments(statistics: MotionStatistics | None, unit: Unit) -> Json | None:
    if statistics is None:
        return None
    return json_of(statistics, "count", "mean", "std", "percent", mean=unit, std=unit)


def _histogram(histogram: TurnHistogram) -> Json:
    distances = ("distance", "law_alone_total_variation", "law_alone_distance")
    in_degrees = dict.fromkeys(("edges", "distance", "law_alone_distance"), DEGREES)
    shares = ("measured", "predicted", "law_alone", "total_variation", "chance_total_variation")
    return {
        **json_of(histogram, "edges", *shares, **in_degrees),
        "p_value": written(histogram.chance.value),
        **json_of(histogram, *distances, **in_degrees),
    }


def _law(motion: MotionLaw) -> Json:
    law = motion.law
    report = json_of(motion, "problem")
    if law is None:
        return report
    unit = UNITS[motion.quantity]
    noise = law.noise(np.linspace(0.0, TWO_PI, 361))
    return {
        **report,
        **json_of(law, "count", "harmonics", "rmse", "percent", rmse=unit),
        **json_of(motion, "cross_validated_rmse", "explained", cross_validated_rmse=unit),
        **json_of(law, "sigma", unit=unit),
        unit.named("least_scatter"): written(np.min(noise), unit),
        unit.named("most_scatter"): written(np.max(noise), unit),
        **json_of(law, "lag_correlation", "cosine", "sine", "log_variance", cosine=unit, sine=unit),
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
        "rmse_deg": degrees(law.rmse),
        "rmse_without_wear_deg": degrees(measured.fitted.law.rmse),
        **json_of(law, "sigma", unit=DEGREES),
        **json_of(measured, "quietest", "loudest"),
        **json_of(law, "lag_correlation"),
        "early": _state(measured.early),
        "late": _state(measured.late),
        "forecast": if_known(_forecast, measured.forecast),
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


def _table(
    title: str, fits: Sequence[SetFit], lines: Sequence[tuple[str, ...]], *columns: str
) -> Table:
    """A row a set, its last cell a note; without notes no column of them."""
    notes = any(line[-1] for line in lines)
    named = [
        f"{label if column == columns[0] else ''}\n{column}"
        for label in QUANTITIES.values()
        for column in columns
    ]
    rows = []
    for fit, line in zip(fits, lines, strict=True):
        rows.append((fit.pushes.name, str(fit.pushes.count), *(line if notes else line[:-1])))
    headings = ("set", "pushes", *named, *["note"] * notes)
    table = people_table(title, headings, rows, words=(0, 2 + len(named)))
    if notes:
        table.columns[-1].max_width = NOTE_LETTERS
    return table


def _statistic_cells(fit: SetFit) -> list[str]:
    """Mean, standard deviation and percentage of each quantity."""
    cells = []
    for name, unit in UNITS.items():
        statistics: MotionStatistics | None = getattr(fit.statistics, name)
        if statistics is None:
            cells += [NOTHING] * 3
        else:
            sizes = [f"{unit.of_si(size):.2f}" for size in (statistics.mean, statistics.std)]
            cells += [*sizes, _percent(statistics.percent)]
    return cells


def _law_cells(fit: SetFit) -> list[str]:
    """Error, percentage, error in pushes left out, and order of the law of each quantity."""
    cells = []
    for motion in fit.laws:
        law = motion.law
        unit = UNITS[motion.quantity]
        if law is None:
            cells += [NOTHING] * 4
        else:
            rmse, left_out = (
                f"{unit.of_si(size):.2f}" for size in (law.rmse, motion.cross_validated_rmse)
            )
            cells += [rmse, _percent(law.percent), left_out, str(law.harmonics)]
    return cells


def _percent(value: float) -> str:
    return f"{value:.2f}" if value < MOST_PERCENT else f">{MOST_PERCENT:.0f}"
