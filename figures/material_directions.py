"""Fig. 6 and the paper's staircases: how often each orientation θ0 is pushed from on four
materials, and how θ0, not wrapped, climbs over 2000 pushes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array
from cyclemap.evidence import AngleHistogram, angle_histogram, total_variation
from cyclemap.evidence.laws.measured_cycle_map import full_turns
from cyclemap.maps import Steps, find_steps
from cyclemap.maps.staircases.staircase import sample_staircases
from cyclemap.views.panels.orientation import (
    CIRCLE,
    PER_DEGREE,
    draw_histogram,
    draw_recorded,
    draw_staircase,
)
from cyclemap.views.panels.style import LINE, SECOND, THIRD, name_tag
from cyclemap.views.sentences import angle, listed

from . import Exhibit, MeasuredFolder
from .repeated_pushes import (
    NOISE,
    PAPER,
    STANDS_FOR,
    SampledRun,
    Sampling,
    draw_each,
    measured_theta0,
    not_found,
    sampled_run,
)

UNIFORM = 1.0 / TWO_PI
# A maximum of the density counts as a peak from this many times the uniform density on.
LEAST_PEAK = 0.5
# The paper's words for the peaks, in the order of `PublishedStatistics.directions`.
PEAK_WORDS = {"plywood": ("high", "small"), "abs": ("small", "high"), "delrin": ("only",), "pu": ()}
# Pushes within so many rad of a direction are counted as there.
NEAR = float(np.deg2rad(30.0))


@dataclass(frozen=True, eq=False)
class MaterialDirections:
    """One panel.

    run : simulated pushes.
    simulated : their histogram.
    density : (721,) per rad at ``CIRCLE``, stationary, of the map with its noise, known to
        density_error.
    theta0 : (m,) rad, the recorded orientations, and recorded, their histogram; None where not
        found.
    """

    run: SampledRun
    simulated: AngleHistogram
    density: Array
    density_error: float
    theta0: Array | None
    recorded: AngleHistogram | None

    @property
    def peaks(self) -> Array:
        """(k,) rad, where the stationary density has a maximum above half the uniform one, the
        highest first.
        """
        value = self.density[:-1]
        top = (
            (value >= np.roll(value, 1))
            & (value > np.roll(value, -1))
            & (value > LEAST_PEAK * UNIFORM)
        )
        places = np.flatnonzero(top)
        return np.asarray(CIRCLE[places[np.argsort(-value[places])]])


def share_near(theta: ArrayLike, directions: ArrayLike) -> float:
    """The share of the angles (n,), rad, within NEAR (rad) of one of the directions (k,).

    >>> share_near([0.1, 3.0, 6.2], [0.0])
    0.6666666666666666
    """
    apart = np.cos(
        np.subtract.outer(np.asarray(theta, dtype=float), np.asarray(directions, dtype=float))
    )
    return float(np.mean((apart >= np.cos(NEAR)).any(axis=-1)))


def theta0_histograms(
    measured: MeasuredFolder, sampling: Sampling = PAPER
) -> tuple[MaterialDirections, ...]:
    """Simulate pushes on each material and look for recorded ones."""
    panels = []
    for surface, material in STANDS_FOR.items():
        run, pairs = sampled_run(material, sampling), measured_theta0(measured, surface)
        theta0 = None if pairs is None else pairs.path if pairs.path is not None else pairs.theta
        recorded = None if theta0 is None else angle_histogram(theta0)
        simulated = angle_histogram(run.pushes.theta)
        panels.append(MaterialDirections(run, simulated, *run.density, theta0, recorded))
    return tuple(panels)


def _draw_directions(axes: Axes, panel: MaterialDirections) -> None:
    draw_recorded(axes, panel.recorded)
    look = {**SECOND, "linestyle": "-", "label": "simulated"}
    draw_histogram(axes, panel.simulated, look)
    around, density = np.degrees(CIRCLE), PER_DEGREE * panel.density
    axes.plot(around, density, label="stationary density", **LINE)
    top = 1.3 * axes.dataLim.y1
    axes.set_ylim(0.0, top)
    for place, word in zip(_published(panel), PEAK_WORDS[panel.run.surface], strict=True):
        axes.axvline(place, ymax=0.9, label="paper's peak", **THIRD)
        name_tag(axes, place, 0.94 * top, f"{place:.0f}° {word}")
    if not PEAK_WORDS[panel.run.surface]:
        name_tag(axes, 180.0, 0.94 * top, "paper: no stable direction")


def _published(panel: MaterialDirections) -> list[float]:
    return [float(np.degrees(angle) % 360.0) for angle in panel.run.published.directions]


def histogram_caption(result: tuple[MaterialDirections, ...]) -> str:
    """What is drawn, and where each material's histogram has its peaks."""
    count = result[0].run.pushes.count
    error = max(panel.density_error for panel in result) * PER_DEGREE
    sentences = [
        f"Orientation before each push: {count} simulated pushes a material, 1.1° of noise a "
        f"cycle, and the stationary density of the noisy map (within {error:.1g} per degree). "
        f"Plywood is plywood-measured, whose density is the mean over {len(result[0].run.states)} "
        "states of its wear. Dashed: the peaks that the paper names. Maxima above half the uniform "
        "density count as peaks.",
        *[_histogram_sentence(panel) for panel in result],
        not_found("θ0", [panel.run.surface for panel in result if panel.theta0 is None]),
    ]
    return " ".join(filter(None, sentences))


def _histogram_sentence(panel: MaterialDirections) -> str:
    name, peaks = panel.run.surface, [f"{angle(peak, 0)}" for peak in panel.peaks]
    where = f"peaks at {listed(peaks)}" if peaks else "has no peak"
    sentence = f"On {name} the density {where}"
    if not _published(panel):
        return (
            f"{sentence}, {panel.density.max() / UNIFORM:.1f} times the uniform one at most "
            "(paper: none)."
        )
    words = [
        f"{at:.0f}° {word}" for at, word in zip(_published(panel), PEAK_WORDS[name], strict=True)
    ]
    near = share_near(panel.run.pushes.theta, panel.run.published.directions)
    sentence += (
        f" (paper: {listed(words)}); {near:.0%} of the simulated pushes start within 30° of "
        "the paper's"
    )
    if panel.theta0 is None or panel.recorded is None:
        return f"{sentence}."
    recorded = share_near(panel.theta0, panel.run.published.directions)
    highest = int(np.argmax(panel.recorded.density))
    low, high = np.degrees(panel.recorded.edges[highest : highest + 2])
    apart = float(total_variation(panel.theta0, panel.run.pushes.theta))
    return (
        f"{sentence}, {recorded:.0%} of the {panel.theta0.size} recorded ones, whose highest bin "
        "is "
        f"{low:.0f}° to {high:.0f}°; the two histograms are {apart:.2f} apart in total variation."
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


def staircases(
    measured: MeasuredFolder, sampling: Sampling = PAPER, runs: int = DEFAULT_RUNS
) -> tuple[MaterialStaircase, ...]:
    """Run cycles on each material, ``runs`` times, with its wear, and look for recorded paths."""
    panels = []
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
        panels.append(
            MaterialStaircase(
                run, climb_of(run.run.theta[:-1], level), lower, upper, turns, recorded
            )
        )
    return tuple(panels)


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


def _draw_climb(axes: Axes, panel: MaterialStaircase) -> None:
    """Measured and predicted together where there is a measured path."""
    recorded = None if panel.recorded is None else panel.recorded.path
    draw_staircase(axes, panel.climb.path, recorded, (panel.lower, panel.upper), "push")


def staircase_caption(result: tuple[MaterialStaircase, ...]) -> str:
    """What is drawn, and how each material climbs."""
    first = result[0]
    sentences = [
        f"θ0 before each of {first.climb.path.size} pushes, not wrapped, as one run of the "
        "predicted cycle map climbs with 1.1° of noise a cycle, and where 95 % of "
        f"{first.turns.size} runs are. Plywood is plywood-measured, which wears over the run and "
        "was inferred from the very path that is drawn beside it where it was found: that "
        "agreement is a fit, not a test. The other materials are inferred from the paper's tables "
        "and words.",
        *[_climb_sentence(panel) for panel in result],
        not_found("θ0", [panel.run.surface for panel in result if panel.recorded is None]),
    ]
    return " ".join(filter(None, sentences))


def _climb_sentence(panel: MaterialStaircase) -> str:
    low, high = np.quantile(panel.turns, [0.025, 0.975])
    words = f"On {panel.run.surface} the predicted run {_course_words(panel.climb)}; "
    words += f"95 % of runs end {_signed(low)} to {_signed(high)} turns on"
    if panel.run.published.first_share is not None:
        first = float(np.degrees(panel.climb.path[0])) % 360.0
        words += (
            f"; it stays within 30° of its first direction, {first:.0f}°, for "
            f"{panel.climb.first_stay} pushes"
        )
        words += " (paper: about 150)"
    if panel.recorded is not None:
        recorded = panel.recorded
        words += f". The recorded path of {recorded.path.size} pushes {_course_words(recorded)}"
    return f"{words}."


def _course_words(climb: Climb) -> str:
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


EXHIBITS = {
    "theta0-histograms": Exhibit(
        theta0_histograms, histogram_caption, partial(draw_each, _draw_directions)
    ),
    "staircases": Exhibit(staircases, staircase_caption, partial(draw_each, _draw_climb)),
}
