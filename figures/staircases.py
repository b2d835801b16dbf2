"""The staircases: how θ0, not wrapped, climbs over 2000 pushes on four materials."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import TWO_PI, Array
from cyclemap.evidence.laws.measured_cycle_map import full_turns
from cyclemap.maps import Steps, find_steps
from cyclemap.maps.staircases.staircase import sample_staircases
from cyclemap.views.map_panels import CIRCLE
from cyclemap.views.staircase_panels import draw_staircase

from .catalogue import MeasuredFolder
from .measured_sets import measured_theta0, not_found
from .simulated_collections import (
    NOISE,
    PAPER,
    STANDS_FOR,
    SampledRun,
    Sampling,
    draw_materials,
    sampled_run,
)

DEFAULT_RUNS = 200
# A path has left a direction when it is further from it than this (rad).
AWAY = float(np.deg2rad(30.0))


@dataclass(frozen=True, eq=False)
class Climb:
    """A path and what it does.

    path : (m,) rad, not wrapped, one entry a push.
    steps : the dwells and steps found in it, without a model.
    turns : from the first push to the last.
    turn_pushes : (k,) pushes that each full turn took, in order, from where the map is fastest.
    first_stay : pushes before the path is first more than 30 degrees from where it began; all,
        where it never is.
    """

    path: Array
    steps: Steps
    turns: float
    turn_pushes: Array
    first_stay: int


@dataclass(frozen=True, eq=False)
class MaterialStaircase:
    """One panel.

    run, climb : the predicted path that is drawn.
    lower, upper : (m,) rad, between which 95 % of such paths lie at each push.
    turns : (runs,) full turns that these climb.
    recorded : the measured path; None where none was found.
    """

    run: SampledRun
    climb: Climb
    lower: Array
    upper: Array
    turns: Array
    recorded: Climb | None


def compute(
    measured: MeasuredFolder, sampling: Sampling = PAPER, runs: int = DEFAULT_RUNS
) -> tuple[MaterialStaircase, ...]:
    """Run cycles on each material, ``runs`` times, with its wear, and look for recorded paths."""
    found = []
    for surface, material in STANDS_FOR.items():
        run = sampled_run(material, sampling)
        level = float(CIRCLE[np.argmax(np.abs(run.states[0].map.turn(CIRCLE)))])
        starts = np.full(runs, run.run.start)
        paths = sample_staircases(run.map, NOISE, run.run.cycles - 1, starts, run.run.seed + 1)
        lower, upper = np.quantile(paths, [0.025, 0.975], axis=0)
        turns = (paths[:, -1] - paths[:, 0]) / TWO_PI
        pairs = measured_theta0(measured, surface)
        recorded = None
        if pairs is not None and pairs.path is not None:
            # By whole turns as near as may be to where the simulated run starts.
            beside = pairs.path - TWO_PI * np.round((pairs.path[0] - run.run.start) / TWO_PI)
            recorded = climb_of(beside, level)
        found.append(
            MaterialStaircase(
                run, climb_of(run.run.theta[:-1], level), lower, upper, turns, recorded
            )
        )
    return tuple(found)


def climb_of(path: Array, level: float) -> Climb:
    """Find the steps of a path (m,), rad, and how long its full turns take; level : rad, where a
    turn begins.

    >>> climb = climb_of(np.linspace(0.0, 13.0, 131), 0.0)
    >>> round(climb.turns, 3), climb.turn_pushes.tolist(), climb.first_stay
    (2.069, [63, 63], 6)
    """
    away = np.flatnonzero(np.abs(path - path[0]) > AWAY)
    turns, stay = float(path[-1] - path[0]) / TWO_PI, int((*away, path.size)[0])
    return Climb(path, find_steps(path), turns, np.diff(full_turns(path, level)), stay)


def draw(result: tuple[MaterialStaircase, ...]) -> Figure:
    """Draw a panel a material; measured and predicted together where there is a measured path."""
    return draw_materials([panel.run.surface for panel in result], result, _draw_material)


def _draw_material(axes: Axes, panel: MaterialStaircase) -> None:
    recorded = None if panel.recorded is None else panel.recorded.path
    draw_staircase(axes, panel.climb.path, recorded, (panel.lower, panel.upper), "push")


def caption(result: tuple[MaterialStaircase, ...]) -> str:
    """What is drawn, and how each material climbs."""
    first = result[0]
    told = [
        f"θ0 before each of {first.climb.path.size} pushes, not wrapped, as one run of the "
        "predicted cycle map climbs with 1.1° of noise a cycle, and where 95 % of "
        f"{first.turns.size} runs are. Plywood is plywood-measured, which wears over the run and "
        "was inferred from the very path that is drawn beside it where it was found: that "
        "agreement is a fit, not a test. The other materials are inferred from the paper's tables "
        "and words.",
        *[_sentence(panel) for panel in result],
        not_found("θ0", [panel.run.surface for panel in result if panel.recorded is None]),
    ]
    return " ".join(filter(None, told))


def _sentence(panel: MaterialStaircase) -> str:
    low, high = np.quantile(panel.turns, [0.025, 0.975])
    told = f"On {panel.run.surface} the predicted run {_told(panel.climb)}; "
    told += f"95 % of runs end {_signed(low)} to {_signed(high)} turns on"
    if panel.run.published.first_share is not None:
        first = float(np.degrees(panel.climb.path[0])) % 360.0
        told += (
            f"; it stays within 30° of its first direction, {first:.0f}°, for "
            f"{panel.climb.first_stay} pushes"
        )
        told += " (paper: about 150)"
    if panel.recorded is not None:
        told += f". The recorded path of {panel.recorded.path.size} pushes {_told(panel.recorded)}"
    return f"{told}."


def _told(climb: Climb) -> str:
    """The steps, the rests and the turns of one path."""
    steps, turns, pushes = (
        climb.steps,
        f"ends {_signed(climb.turns)} turns from its start",
        climb.turn_pushes,
    )
    paces = (
        f", the first whole one in {pushes[0]} pushes and the last in {pushes[-1]}"
        if pushes.size > 1
        else ""
    )
    if not steps.levels.size:
        return f"rests nowhere and {turns}{paces}"
    if not steps.count:
        return f"stays at {float(np.degrees(steps.levels[0])) % 360.0:.0f}° and {turns}"
    heights = np.degrees(steps.heights)
    return (
        f"makes {steps.count} steps of {np.median(heights):.0f}° ({heights.min():.0f}° to "
        f"{heights.max():.0f}°) after rests of {np.median(steps.lengths):.0f} pushes (median; "
        f"{steps.lengths.min()} to {steps.lengths.max()}) and {turns}{paces}"
    )


def _signed(turns: float) -> str:
    return f"{round(turns, 1) + 0.0:+.1f}"
