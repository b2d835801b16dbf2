"""`cyclemap compare`: a prediction beside data, in sentences, tables, JSON and a picture."""

import math
from pathlib import Path

from rich.table import Table

from cyclemap.cli.command_compare import CompareRequest
from cyclemap.cli.compare_report import compare_report
from cyclemap.cli.options import LoopOptions
from cyclemap.cli.output import file_stem, progress_bar, publish_json, write_json
from cyclemap.cli.run_fit import selected_values
from cyclemap.cli.settings import chosen_loop, told_settings
from cyclemap.cli.terminal import PeopleConsole
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait_curves import turn_curve
from cyclemap.evidence.comparison.compare import Comparison, compare
from cyclemap.evidence.comparison.push_agreement import QuantityAgreement
from cyclemap.maps import WrappedNormal
from cyclemap.views import compare_sentences as sentences
from cyclemap.views.compare_page import compare_page
from cyclemap.views.style import render
from cyclemap.whole_files import write_whole

PUSH_COLUMNS = ("", "measured", "std", "predicted", "bias", "spread", "RMSE", "%", "std %")
SYMBOLS = {"dtheta": "Δθ (°)", "dx": "Δx (mm)", "dy": "Δy (mm)"}


def run_compare(options: LoopOptions, request: CompareRequest, json_target: str | None) -> None:
    """Compare the loop's prediction with the data, draw both, and print the answers for people or as JSON."""
    loop, sigma = chosen_loop(options, request.data)
    name = loop.material.name
    with progress_bar(f"{name} beside {request.data.name}") as report:
        found = compare(
            loop,
            request.read,
            noise=None if sigma is None else WrappedNormal(sigma),
            first=request.first,
            select=selected_values(request.select),
            push_length=_push_length(options, request.data, loop),
            runs=request.runs,
            seed=request.seed,
            progress=report,
        )
    told = compare_report(name, found)
    stem = request.out / f"compare_{file_stem(name)}"
    write_json(stem.with_name(f"{stem.name}.json"), told)
    picture = stem.with_name(f"{stem.name}.{request.picture_format}")
    page = compare_page(name, found, turn_curve(found.prediction.map_at(found.middle)))
    write_whole(picture, render(page, request.picture_format))
    if not publish_json(told, json_target):
        _print_for_people(name, found, picture)


def _push_length(options: LoopOptions, data: Path, loop: CollectionLoop) -> float | None:
    """How far the rod moves, m, where the options say so: MIT's own 150 mm are no answer for data that do not tell."""
    return loop.push.distance if "push_mm" in told_settings(options, data)[1] else None


def _print_for_people(name: str, found: Comparison, picture: Path) -> None:
    console = PeopleConsole()
    console.print(sentences.headline(name, found), style="bold")
    console.print(sentences.data_sentence(found))
    for verdict in found.verdicts:
        console.print(verdict.words)
    for sentence in sentences.trust_sentences(found):
        console.print(sentence)
    for whose, quantities in found.told_pushes:
        console.print_table(_push_table(whose, quantities))
    if found.orientations is not None:
        console.print_table(_test_table(found))
    console.print(f"picture: {picture}")


def _push_table(whose: str, quantities: tuple[QuantityAgreement, ...]) -> Table:
    table = Table(title=f"{quantities[0].count} pushes{whose}", title_justify="left")
    for column in PUSH_COLUMNS:
        table.add_column(column, justify="right")
    for one in quantities:
        scale = math.degrees(1.0) if one.name == "dtheta" else 1000.0
        lengths = (one.measured_mean, one.measured_std, one.predicted_mean, one.bias, one.spread, one.rmse)
        values = [f"{scale * value:.2f}" for value in lengths]
        # Of a mean that is nothing beside the spread a percentage says nothing.
        shares = (f"{share:.1f}" if one.std_percent < 100.0 else "–" for share in (one.percent, one.std_percent))
        table.add_row(SYMBOLS[one.name], *values, *shares)
    return table


def _test_table(found: Comparison) -> Table:
    assert found.orientations is not None
    table = Table(title="Histogram of directions, measured against predicted", title_justify="left")
    for column in ("test", "statistic", "p-value"):
        table.add_column(column, justify="right")
    for name, one in found.orientations.tests.items():
        value = f"{math.degrees(one.statistic):.2f}°" if name == "wasserstein" else f"{one.statistic:.3f}"
        table.add_row(name.replace("_", " "), value, f"{one.value:.3f} ± {one.standard_error:.3f}")
    return table
