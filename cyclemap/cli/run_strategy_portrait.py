"""`cyclemap portrait` with a strategy: the law of the orientations in sentences, as JSON, and as a picture."""

import math
from pathlib import Path

from cyclemap.cli.json_numbers import degrees, direction_deg, number
from cyclemap.cli.json_report import Json
from cyclemap.cli.options import RunRequest
from cyclemap.cli.output import file_stem, progress_bar, publish_json, write_json
from cyclemap.cli.strategy_cycles import action_report
from cyclemap.cli.terminal import PeopleConsole
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_CYCLES
from cyclemap.evidence import Theta0Pairs, measured_overlay
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.resets.strategy_portrait import StrategyPortrait, strategy_portrait
from cyclemap.resets.strategy_portrait_curves import StrategyCurves, mean_turns, strategy_curves
from cyclemap.views import strategy_sentences as sentences
from cyclemap.views.sentences import material_line
from cyclemap.views.strategy_portrait_page import strategy_portrait_page
from cyclemap.views.strategy_words import action_words
from cyclemap.views.style import render
from cyclemap.whole_files import write_whole

_NO_FIXED_POINTS = "cycles differ from each other, so that no orientation is fixed: see stationary"


def run_strategy_portrait(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    sigma: float,
    request: RunRequest,
    pairs: Theta0Pairs | None,
    json_target: str | None,
) -> None:
    """Compute the portrait of the strategy, draw it, and print it for people or as JSON."""
    drawn = _compute(loop, strategy, sigma, request, pairs)
    curves = strategy_curves(drawn)
    measured = None if pairs is None else measured_overlay(pairs, lambda theta: mean_turns(drawn, theta))
    report = strategy_portrait_report(drawn, curves, pairs)
    stem = request.out / f"portrait_{file_stem(loop.material.name)}"
    write_json(stem.with_name(f"{stem.name}.json"), report)
    picture = stem.with_name(f"{stem.name}.{request.picture_format}")
    write_whole(picture, render(strategy_portrait_page(drawn, curves, measured), request.picture_format))
    if not publish_json(report, json_target):
        _print_for_people(drawn, picture)


def _compute(
    loop: CollectionLoop, strategy: ResetStrategy, sigma: float, request: RunRequest, pairs: Theta0Pairs | None
) -> StrategyPortrait:
    path = None if pairs is None else pairs.path
    with progress_bar(f"cycle maps of {loop.material.name}") as report:
        return strategy_portrait(
            loop,
            strategy,
            sigma=sigma,
            cycles=request.cycles or (DEFAULT_CYCLES if path is None else len(path) - 1),
            start=0.0 if path is None else float(path[0]),
            seed=request.seed,
            progress=report,
        )


def strategy_portrait_report(drawn: StrategyPortrait, curves: StrategyCurves, pairs: Theta0Pairs | None) -> Json:
    """The keys of the report without a strategy where they mean something: `map` is a list, one entry an action."""
    maps = drawn.maps
    report: Json = {
        "strategy": {
            "name": maps.strategy.name,
            "needs": list(maps.strategy.needs),
            "kind": maps.law.kind,
            "computed_maps": maps.computed,
            "interpolation_error_deg": degrees(drawn.interpolation),
        },
        "map": [_map(drawn, index) for index in range(len(maps.maps))],
        "fixed_points": [],
        "fixed_points_reason": _NO_FIXED_POINTS,
        "rotation_number": _rotation(drawn),
        "stationary": _stationary(drawn, curves),
        "staircase": _staircase(drawn),
    }
    return report if pairs is None else {**report, "data": {"pairs": len(pairs.theta), "dropped": dict(pairs.dropped)}}


def _rotation(drawn: StrategyPortrait) -> Json:
    mean = drawn.mean_turn
    return {
        "value": number(mean),
        "lower": number(mean - mean.error_bound),
        "upper": number(mean + mean.error_bound),
        "locked": None,
        "certified": drawn.mean_turn_certified,
    }


def _stationary(drawn: StrategyPortrait, curves: StrategyCurves) -> Json:
    scores, away = drawn.scores, drawn.scores.total_variation
    return {
        "noise_deg": degrees(drawn.noise.sigma),
        "peaks_deg": sorted(direction_deg(peak) for peak in drawn.highest_peaks),
        "spectral_gap": number(scores.spectral_gap),
        "mixing_cycles": number(drawn.memory_cycles),
        "tv_from_uniform": number(away),
        "tv_error": number(away.error_bound),
        "tv_after_pushes_from_worst_start": {"pushes": int(curves.pushed[-1]), "tv": number(curves.farthest[-1])},
        "effective_size_per_100": number(scores.effective_size_per_100),
        "certified": drawn.law_certified,
    }


def _staircase(drawn: StrategyPortrait) -> Json:
    run = drawn.staircase
    return {
        "mean_turn_deg": degrees(2.0 * math.pi * drawn.mean_turn),
        "mean_residence_cycles": None,
        "step_deg": None,
        "run": {
            "seed": run.seed,
            "cycles": run.cycles,
            "climb_deg": degrees(float(run.theta[-1] - run.theta[0])),
        },
    }


def _map(drawn: StrategyPortrait, index: int) -> Json:
    maps, turns = drawn.maps, drawn.turns[index]
    one, action = maps.maps[index], maps.law.actions[index]
    return {
        "action": action_report(action.filled(maps.loop), action_words(action), float(maps.weights[index])),
        "degree": int(one.degree),
        "samples": int(one.samples),
        "max_error_deg": degrees(one.max_error),
        "mean_turn_deg": degrees(turns.mean),
        "min_turn_deg": degrees(turns.minimum),
        "max_turn_deg": degrees(turns.maximum),
        "min_slope": number(turns.min_slope),
        "max_slope": number(turns.max_slope),
    }


def _print_for_people(drawn: StrategyPortrait, picture: Path) -> None:
    console = PeopleConsole()
    console.print(sentences.portrait_headline(drawn), style="bold")
    for sentence in (sentences.law_sentence, sentences.memory_sentence, sentences.mean_turn_sentence):
        console.print(sentence(drawn))
    console.print(sentences.strategy_line(drawn.maps))
    if told := material_line(drawn.maps.loop.material):
        console.print(told)
    console.print(sentences.accuracy_line(drawn), style="dim")
    console.print(f"picture: {picture}")
