"""A strategy's portrait and staircase in sentences."""

import math

import numpy as np

from cyclemap.resets.strategies.strategy_maps import StrategyMaps
from cyclemap.resets.strategy_portrait import TRIED_BETWEEN, StrategyPortrait
from cyclemap.resets.strategy_portrait_curves import StrategyCurves
from cyclemap.resets.strategy_staircase import StrategyStaircase
from cyclemap.views.panel_parts import small
from cyclemap.views.sentences import MOST_PEAKS, angle, cycles, number
from cyclemap.views.strategy_words import strategy_words


def portrait_headline(portrait: StrategyPortrait) -> str:
    """The answer in a line: how far from even the orientations are."""
    away = portrait.scores.total_variation
    return f"{portrait.maps.loop.material.name} with {portrait.maps.strategy.name}: {away:.1%} away from uniform"


def law_sentence(portrait: StrategyPortrait) -> str:
    """Where the law of the orientations is highest, and how surely its distance from uniform is known."""
    peaks = portrait.highest_peaks[:MOST_PEAKS]
    away = portrait.scores.total_variation
    bound = f" ± {small(away.error_bound)}" if math.isfinite(away.error_bound) else ", no bound known"
    where = f"peak at {', '.join(angle(peak) for peak in peaks)}" if peaks else "have no peak"
    noise = f"With {angle(portrait.noise.sigma)} of noise a cycle"
    return f"{noise} the recorded directions {where}; total variation from uniform {away:.4f}{bound}."


def memory_sentence(portrait: StrategyPortrait) -> str:
    """How soon a start is forgotten."""
    memory, far = portrait.memory_cycles, portrait.scores.curve.total_variation
    left = f"after {far.size} pushes from the worst start they are {far[-1]:.1%} away from uniform"
    if memory is None:
        return f"The cycles of the schedule know of each other, so that no single operator forgets; {left}."
    return f"What is left of a start falls by e in {cycles(memory)}; {left}."


def mean_turn_sentence(portrait: StrategyPortrait) -> str:
    """How far θ0 moves a cycle, and what that was found with."""
    mean = portrait.mean_turn
    how = "" if portrait.mean_turn_certified else " (simulated, two standard errors)"
    bound = small(math.degrees(2 * math.pi * mean.error_bound))
    return f"On average a cycle turns the object by {angle(2 * math.pi * mean, 2)} ± {bound}°{how}."


def strategy_line(maps: StrategyMaps) -> str:
    """What the strategy is."""
    return strategy_words(maps.strategy, len(maps.law.actions), maps.law.kind)


def gripper_words(curves: StrategyCurves) -> str:
    """By how much a gripper turns the object; empty where none does."""
    turns = curves.gripper
    if not np.any(turns):
        return ""
    if turns.size == 1:
        return f"a gripper turns the object by {angle(turns[0])} after the drag"
    return f"a gripper turns the object by {angle(turns[0])} to {angle(turns[-1])} after the drag ({turns.size} nodes)"


def accuracy_line(portrait: StrategyPortrait) -> str:
    """How the maps were computed, and how well they stand for what lies between them."""
    maps = portrait.maps
    told = f"{maps.computed} cycle maps, error below {small(math.degrees(maps.max_error))}°"
    if portrait.interpolation:
        off = small(math.degrees(portrait.interpolation))
        told += f"; drawn actions between them up to {off}° off in {TRIED_BETWEEN} tried"
    proved = "certified" if portrait.law_certified else "not certified"
    if portrait.law_certified and portrait.interpolation:
        proved += " for the law of those maps alone"
    return f"{told}; the distance from uniform is {proved}"


def staircase_headline(found: StrategyStaircase) -> str:
    """What is shown."""
    return f"Staircase of {found.loop.material.name} with {found.strategy.name}"


def run_sentence(found: StrategyStaircase) -> str:
    """What was found in the run."""
    steps, how = found.steps, "by the full mechanics" if found.maps is None else "from its cycle maps"
    run = f"In one run of {found.run.cycles} cycles {how} (seed {found.run.seed})"
    moved = f"θ0 moves {angle(found.run.mean_turn, 2)} a cycle on average"
    if not steps.levels.size:
        return f"{run} it rests nowhere: {moved}."
    rest = number(float(np.median(steps.lengths)))
    return f"{run} it makes {steps.count} steps after rests of {rest} cycles (median); {moved}."
