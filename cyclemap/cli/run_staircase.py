"""`cyclemap staircase`: in sentences, as JSON, and as a picture."""

from cyclemap.cli.json_report import staircase_report
from cyclemap.cli.options import RunOptions
from cyclemap.cli.output import progress_bar, publish, result_stem
from cyclemap.collection.portrait import staircase_forecast
from cyclemap.evidence import measured_staircase
from cyclemap.protocol.chosen_loop import chosen_collection
from cyclemap.views import staircase_page
from cyclemap.views.sentences import ahead_sentence, uncertainty_sentence


def run_staircase(asked: RunOptions) -> None:
    """Predict the staircase, set the measured one beside it, draw both, and print them for people
    or as JSON.
    """
    pairs, chosen = asked.pairs(), chosen_collection(asked.options, asked.data).simplified()
    loop = chosen.loop
    measured = None if pairs is None else measured_staircase(pairs, asked.seed)
    if chosen.strategy is not None:
        from cyclemap.cli.run_strategy import run_strategy_staircase

        run_strategy_staircase(chosen, chosen.strategy, measured, asked)
        return
    run = asked.run_beside(None if measured is None else measured.path)
    with progress_bar(f"staircase of {loop.material.name}") as report:
        forecast = staircase_forecast(loop, sigma=chosen.sigma, progress=report, **run)
    stem = result_stem(asked.results.out, "staircase", loop)
    page = staircase_page.staircase_page(forecast, measured)
    publish(
        staircase_report(forecast, measured),
        page,
        stem,
        asked.results,
        staircase_page.forecast_sentence(forecast),
        staircase_page.worn_sentence(forecast),
        staircase_page.run_sentence(forecast),
        uncertainty_sentence(loop.material.name, forecast.uncertainty),
        ahead_sentence(forecast.forecast),
        "" if measured is None else staircase_page.measured_sentence(measured),
        "" if measured is None else staircase_page.fitted_sentence(measured),
    )
