"""`cyclemap staircase`: in sentences, as JSON, and as a picture."""

from pathlib import Path

from cyclemap.cli.json_report import staircase_report
from cyclemap.cli.options import ResultOptions, TableOptions, measured_orientations
from cyclemap.cli.output import progress_bar, publish, result_stem
from cyclemap.collection.portrait import DEFAULT_CYCLES, staircase_forecast
from cyclemap.evidence import measured_staircase
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_collection
from cyclemap.views import staircase_page
from cyclemap.views.sentences import ahead_sentence, uncertainty_sentence


def run_staircase(
    options: LoopOptions,
    data: Path | None,
    table: TableOptions,
    cycles: int | None,
    seed: int,
    results: ResultOptions,
) -> None:
    """Predict the staircase, set the measured one beside it, draw both, and print them for people
    or as JSON.
    """
    pairs, chosen = (
        measured_orientations(data, table, results.out),
        chosen_collection(options, data).simplified(),
    )
    loop, sigma = chosen.loop, chosen.sigma
    measured = None if pairs is None else measured_staircase(pairs, seed)
    if chosen.strategy is not None:
        from cyclemap.cli.run_strategy import run_strategy_staircase

        run_strategy_staircase(chosen, chosen.strategy, measured, cycles, seed, results)
        return
    # The run starts where the data start and is as long, unless told otherwise.
    length, start = (
        (DEFAULT_CYCLES, 0.0)
        if measured is None
        else (len(measured.path) - 1, float(measured.path[0]))
    )
    with progress_bar(f"staircase of {loop.material.name}") as report:
        forecast = staircase_forecast(
            loop, sigma=sigma, cycles=cycles or length, start=start, seed=seed, progress=report
        )
    stem = result_stem(results.out, "staircase", loop)
    page = staircase_page.staircase_page(forecast, measured)
    publish(
        staircase_report(forecast, measured),
        page,
        stem,
        results,
        staircase_page.forecast_sentence(forecast),
        staircase_page.worn_sentence(forecast),
        staircase_page.run_sentence(forecast),
        uncertainty_sentence(loop.material.name, forecast.uncertainty),
        ahead_sentence(forecast.forecast),
        "" if measured is None else staircase_page.measured_sentence(measured),
        "" if measured is None else staircase_page.fitted_sentence(measured),
    )
