"""Cycles of a strategy: from each start one for each action of its law, as tables and as JSON."""

import math
from collections.abc import Sequence

from rich.table import Table

from cyclemap.cli.json_numbers import degrees, number
from cyclemap.cli.json_report import Json, cycle_report
from cyclemap.cli.run_cycle import cycle_table
from cyclemap.collection.loop import CollectionLoop
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.views.strategy_words import action_words

# Nodes of a full turn: a direction every 30 degrees.
NODES = 12


def strategy_cycles(
    loop: CollectionLoop, strategy: ResetStrategy, starts_deg: Sequence[float]
) -> tuple[Json, list[Table]]:
    """The report and the tables of a cycle from each start (degrees) for each action of the strategy's law."""
    law, prepared = strategy.law(NODES), strategy.prepared(loop)
    cycles: list[Json] = []
    tables = []
    for action, weight in zip(law.actions, law.weights.tolist(), strict=True):
        acted = action.on(prepared)
        runs = [acted.cycle(math.radians(start)) for start in starts_deg]
        told = action_report(action.filled(prepared), action_words(action), weight)
        for start, run in zip(starts_deg, runs, strict=True):
            ends = {"theta1_deg": degrees(run.theta_next + action.turn)}
            cycles.append({**cycle_report(start, run), **ends, "action": told})
        title = f"{action_words(action)}: {weight:.3g} of the cycles on {loop.material.name}"
        tables.append(cycle_table(title, runs, action.turn))
    return {"cycles": cycles}, tables


def action_report(action: CycleAction, name: str, weight: float) -> Json:
    """An action, filled in by its loop, with its share of the cycles."""
    assert action.push is not None and action.way_points is not None
    return {
        "name": name,
        "weight": number(weight),
        "side": action.push.side,
        "fraction": number(action.push.fraction),
        "angle_deg": degrees(action.push.angle),
        "push_mm": number(1e3 * action.push.distance),
        "way_points_mm": [[number(1e3 * x), number(1e3 * y)] for x, y in action.way_points],
        "gripper_turn_deg": degrees(action.turn),
    }
