"""A staircase and the bottleneck of the cycle map that makes it, computed and measured; and the
bottleneck as plywood wears: it opens, and a turn takes fewer and fewer cycles.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from cyclemap.arrays import TWO_PI, Array, shorter_way
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import BLEND_TOLERANCE, drifting_map
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence import (
    MeasuredCycleMap,
    TurnBins,
    angle_histogram,
    fit_map,
    measured_cycle_map,
    read_theta0_pairs,
    turn_bins,
)
from cyclemap.evidence.laws.fit_map import HARMONICS
from cyclemap.evidence.laws.measured_cycle_map import TurnPace
from cyclemap.maps import (
    CircleMap,
    SlowPassage,
    StaircaseSummary,
    WrappedNormal,
    find_steps,
    predict_staircase,
    sample_staircase,
    slow_passages,
    transfer_operator,
)
from cyclemap.views.panels.layout import entitle, legend_above, page, rows_of
from cyclemap.views.panels.orientation import (
    CIRCLE,
    PER_DEGREE,
    SEEN_BARS,
    draw_histogram,
    draw_medians,
    draw_pace,
    draw_turns,
)
from cyclemap.views.panels.style import (
    BAND,
    BARS,
    FOURTH,
    LINE,
    PATH,
    PREDICTED,
    SECOND,
    THIRD,
    ZERO,
    Look,
    count_axis,
    degree_axis,
    picture_style,
    plain_ticks,
)
from cyclemap.views.sentences import LONGEST_STAY, angle

from . import NO_DATA, THETA0_FILE, Exhibit, MeasuredFolder
from .loop_family import with_ring_at

# In time, of the law fitted with wear: what cross-validation finds best in the measured run.
WEAR_DEGREE = 2
# The ring, in metres, a tenth of a millimetre inside the saddle-node; cycles drawn as a staircase.
RADIUS, DRAWN = 0.0097, 800

SAMPLED: Look = {**BARS, "facecolor": "#9db8d2", "edgecolor": PREDICTED}


@dataclass(frozen=True, eq=False)
class Bottleneck:
    """A map with a bottleneck, and a path through it.

    passage : the slowest. prediction : the staircase of map and noise. density : (721,) per rad on
        [0, 2π] by the transfer operator. path : (m,) rad, unwrapped.
    lengths : cycles of the path's visits of the predicted slow zone that were seen whole.
    bins : medians of measured turns, None of a sampled path.
    run : (m,) rad, of a measured path: one noisy path from the same start of the map fitted with
        wear; else None.
    """

    title: str
    map: CircleMap
    sigma: float
    passage: SlowPassage
    prediction: StaircaseSummary
    density: Array
    path: Array
    lengths: Array
    bins: TurnBins | None = None
    run: Array | None = None

    @property
    def visit(self) -> tuple[float, float]:
        """Mean and standard deviation of one visit as predicted, cycles; nan where they could not
        be computed.
        """
        zone = self.prediction.zones[0]
        return float(zone.visit_cycles or math.nan), float(zone.visit_spread or math.nan)


@dataclass(frozen=True)
class StaircaseBottleneck:
    """The bottleneck of plywood with its ring near the saddle-node, and of the measured plywood
    (None without data).
    """

    computed: Bottleneck
    measured: Bottleneck | None


def staircase_bottleneck(
    measured: MeasuredFolder, cycles: int = 20_000, tolerance: float = 1e-5
) -> StaircaseBottleneck:
    """Find the bottlenecks, predict their staircases, and walk a path of `cycles` cycles through
    the computed one.
    """
    loop = with_ring_at(CollectionLoop.mit(material="plywood"), RADIUS)
    circle_map, noise = loop.circle_map(tolerance=tolerance), WrappedNormal(DEFAULT_SIGMA)
    path = sample_staircase(circle_map, noise, cycles, seed=0).theta
    computed = bottleneck(
        f"computed, ring at {1000 * RADIUS:g} mm", circle_map, DEFAULT_SIGMA, path
    )
    file = measured.find(THETA0_FILE)
    return StaircaseBottleneck(computed, None if file is None else measured_bottleneck(file))


def measured_bottleneck(file: Path) -> Bottleneck:
    """Return the bottleneck of the map fitted to measured θ0, beside their path and a run of the
    map fitted with wear.

    Raises InvalidInput where the file is none of `read_theta0_pairs`, or its pushes come in no
    known order.
    """
    pairs = read_theta0_pairs(file)
    if pairs.path is None:
        raise InvalidInput(
            f"{file}: the pairs come in no known order; a staircase needs one row a push in order"
        )
    fitted = fit_map(pairs.theta, pairs.theta_next, harmonics=HARMONICS)
    seen = bottleneck("measured plywood", fitted.map, fitted.sigma, pairs.path, turn_bins(pairs))
    if pairs.cycle is None:
        return seen
    worn = fit_map(
        pairs.theta,
        pairs.theta_next,
        cycle=pairs.cycle,
        harmonics=HARMONICS,
        wear_degree=WEAR_DEGREE,
    )
    return replace(seen, run=worn.paths(pairs.path[:1], pairs.path.size - 1)[0])


def bottleneck(
    title: str, circle_map: CircleMap, sigma: float, path: Array, bins: TurnBins | None = None
) -> Bottleneck:
    """Return the slowest passage of the map and the staircase it makes, beside the path (m,), rad.

    Raises ConvergenceError where the map has no bottleneck.
    """
    passages, noise = slow_passages(circle_map), WrappedNormal(sigma)
    operator = transfer_operator(circle_map, noise)
    prediction = predict_staircase(circle_map, noise, operator)
    if not passages or not prediction.zones:
        raise ConvergenceError(
            f"{title}: the map has no bottleneck; move the ring nearer to the saddle-node"
        )
    slowest = max(passages, key=lambda passage: passage.passage_cycles)
    steps, density = find_steps(path, zones=prediction.zones), operator.density(CIRCLE)
    lengths = steps.lengths[~steps.censored].astype(float)
    return Bottleneck(title, circle_map, sigma, slowest, prediction, density, path, lengths, bins)


@picture_style()
def draw_bottleneck(result: StaircaseBottleneck) -> Figure:
    """A row for the computed bottleneck and one for the measured, where there is case.

    Each shows map, directions, staircase, lengths of visits.
    """
    shown = [case for case in (result.computed, result.measured) if case is not None]
    layout, size = rows_of(*(4,) * len(shown)), (13.6, 3.7 * len(shown))
    figure, panels = page(layout, size=size, keys=3)
    for row, case in enumerate(shown):
        turn, directions, path, lengths = panels[4 * row : 4 * row + 4]
        _draw_turn(turn, case)
        _draw_directions(directions, case)
        _draw_path(path, case)
        _draw_lengths(lengths, case)
        for axes in (turn, directions):
            degree_axis(axes, "θ0 (°)", 90)
        entitle(turn, case.title.capitalize())
        for axes in (directions, path, lengths):
            legend_above(axes)
    return figure


def _seen(case: Bottleneck) -> str:
    return "sampled" if case.bins is None else "measured"


def _parabola(case: Bottleneck) -> tuple[Array, Array]:
    """Angles (rad) within four widths of the slowest, and ε + a x² there."""
    off = case.passage.width * np.linspace(-4.0, 4.0, 81)
    return case.passage.theta + off, case.passage.gap + case.passage.curvature * off**2


def _draw_turn(axes: Axes, case: Bottleneck) -> None:
    if case.bins is not None:
        draw_medians(axes, case.bins, "medians")
    name = "map" if case.bins is None else "fitted map"
    draw_turns(axes, CIRCLE, {name: case.map.turn(CIRCLE)})
    axes.plot(*np.degrees(_parabola(case)), label="ε + a x²", **SECOND)
    axes.set_ylabel("turn of a cycle (°)")


def _draw_directions(axes: Axes, case: Bottleneck) -> None:
    look = {**BAND, "label": "sampled"} if case.bins is None else SEEN_BARS
    draw_histogram(axes, angle_histogram(case.path), {**look, "fill": True})
    axes.plot(np.degrees(CIRCLE), PER_DEGREE * case.density, label="predicted", **LINE)
    theta, pace = _parabola(case)
    share = PER_DEGREE * float(case.prediction.mean_turn) / (TWO_PI * pace)
    axes.plot(np.degrees(theta), share, label="1/(ε + a x²)", **SECOND)
    axes.set_ylabel("share of cycles (per degree)")
    axes.set_ylim(bottom=0.0)


def _draw_path(axes: Axes, case: Bottleneck) -> None:
    """The path in turns from its start, beside the fitted map's run, or its mean pace."""
    shown = case.path if case.bins is not None else case.path[: DRAWN + 1]
    run = {**LINE, "linewidth": 1.2}
    turns = (shown - shown[0]) / TWO_PI
    axes.plot(turns, label=_seen(case), **(run if case.bins is None else PATH))
    if case.run is None:
        pace = float(case.prediction.mean_turn) / TWO_PI
        axes.plot(pace * np.arange(shown.size), label="its mean", **FOURTH)
    else:
        axes.plot((case.run - case.run[0]) / TWO_PI, label="run of the fitted map", **run)
    count_axis(axes, "cycle", shown.size - 1)
    axes.set_ylabel("turns climbed (1)")


def _draw_lengths(axes: Axes, case: Bottleneck) -> None:
    mean, spread = case.visit
    top = 1.05 * max(float(case.lengths.max()), mean + 3 * spread)
    label = f"{_seen(case)}, mean {case.lengths.mean():.0f}"
    bars = SAMPLED if case.bins is None else BARS
    axes.hist(case.lengths, np.linspace(0, top, 31).tolist(), label=label, **bars)
    axes.axvspan(mean - spread, mean + spread, **BAND)
    name, law = f"predicted {mean:.0f} ± {spread:.0f}", case.passage.passage_cycles
    axes.axvline(mean, label=name, **LINE)
    axes.axvline(law, label=f"π/√(εa) = {law:.0f}", **SECOND)
    axes.set(xlabel="cycles on a step", ylabel="number of steps (1)", xlim=(0, top))
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True, min_n_ticks=1))


def bottleneck_caption(result: StaircaseBottleneck) -> str:
    """What is seen, with its numbers."""
    computed = result.computed
    mean, spread = computed.visit
    words = (
        f"Plywood (Table I) with its ring at {1000 * RADIUS:g} mm, just inside the saddle-node: no "
        f"direction repeats, but at {angle(computed.passage.theta, 0)} a cycle turns the object by "
        f"{angle(computed.passage.gap, 2)} only. There the robot spends most cycles, and each "
        f"climb of 360° stops there: passage theory gives {computed.passage.passage_cycles:.0f} "
        f"cycles, map and noise ({angle(computed.sigma)}) together {mean:.0f} ± {spread:.0f}, "
        f"{computed.lengths.size} steps sampled from them lasted {computed.lengths.mean():.0f} on "
        "average."
    )
    seen = result.measured
    if seen is None:
        return f"{words} Of the robot's own staircase {NO_DATA}."
    climbs = ""
    if seen.run is not None:
        climbed, measured = ((path[-1] - path[0]) / TWO_PI for path in (seen.run, seen.path))
        climbs = (
            f" A run of the map fitted with its wear climbs {climbed:.1f} turns, the "
            f"measured path {measured:.1f}."
        )
    (mean, spread), halves = seen.visit, np.array_split(seen.lengths, 2)
    return (
        f"{words} The measured plywood staircase has such a bottleneck at "
        f"{angle(seen.passage.theta, 0)}: its fitted map predicts steps of {mean:.0f} ± "
        f"{spread:.0f} cycles. The {seen.lengths.size} measured ones that were seen whole lasted "
        f"{seen.lengths.mean():.0f} ± {seen.lengths.std(ddof=1):.0f}: they differ more than "
        f"noise makes them, since the surface wears: the first half {halves[0].mean():.0f}, the "
        f"second {halves[1].mean():.0f}.{climbs}"
    )


MATERIAL = "plywood-measured"
AGES = (250, 1000, 1750)
# Cycles: pushes that far from an age say where the measured map of that age is known.
NEAR = 240


@dataclass(frozen=True, eq=False)
class WearDrift:
    """The map over the cycles, computed and measured.

    cycles : (n,).
    least, measured_least : (n,) rad, the least turn of a cycle, where the bottleneck is.
    turns : the turn (rad) at `CIRCLE` at AGES, computed; measured_turns : as fitted, nan where the
        robot hardly was; None without data.
    ages, rotation : (k,) rotation numbers, turns a cycle, of the map frozen at some cycles, with
        noise.
    error : rad, bound on that of the maps between those computed.
    pace : cycles of each measured turn, beside what the fitted map foretells; None without data.
    """

    cycles: Array
    least: Array
    turns: tuple[Array, ...]
    ages: Array
    rotation: Array
    error: float
    pace: TurnPace | None = None
    measured_least: Array | None = None
    measured_turns: tuple[Array, ...] | None = None

    @property
    def opened(self) -> float:
        """The cycle from which on no direction repeats; nan where one always does or never did."""
        crossing = np.flatnonzero((self.least[:-1] < 0.0) & (self.least[1:] >= 0.0))
        if crossing.size == 0:
            return math.nan
        at = slice(crossing[-1], crossing[-1] + 2)
        return float(np.interp(0.0, self.least[at], self.cycles[at]))

    @property
    def cycles_a_turn(self) -> Array:
        """Cycles in which the frozen map climbs a turn, at `ages`; nan where it takes more than any
        collection has.
        """
        climbs = self.rotation > 1.0 / LONGEST_STAY
        never = np.full(climbs.shape, np.nan)
        return np.asarray(np.divide(1.0, self.rotation, out=never, where=climbs))

    @property
    def expected_turns(self) -> float:
        """Turns over the run, as if each cycle's map had been there for ever."""
        return float(np.trapezoid(self.rotation, self.ages))


def wear_drift(
    measured: MeasuredFolder, points: int = 17, tolerance: float = BLEND_TOLERANCE
) -> WearDrift:
    """Follow the map as the loop wears, foretell its staircase, and fit the measured map with its
    wear.

    points : ages at which the pace is foretold.
    tolerance : of `drifting_map`.
    """
    loop = CollectionLoop.mit(material=MATERIAL)
    wear = loop.material.wear
    assert wear is not None
    drifting = drifting_map(loop, int(wear.cycles) + 1, tolerance)
    ages = np.linspace(0.0, wear.cycles, points)
    noise = WrappedNormal(DEFAULT_SIGMA)
    rotation = [transfer_operator(drifting.at(age), noise).rotation_number for age in ages.tolist()]
    cycles = np.linspace(0.0, wear.cycles, 41)
    turns = tuple(drifting.at(float(age)).turn(CIRCLE) for age in AGES)
    least = np.array([drifting.at(float(age)).turn(CIRCLE).min() for age in cycles])
    computed = WearDrift(cycles, least, turns, ages, np.array(rotation), drifting.max_error)
    file = measured.find(THETA0_FILE)
    return computed if file is None else beside_measured(computed, file)


def beside_measured(
    computed: WearDrift, file: Path, runs: int = 50, harmonics: int | None = None
) -> WearDrift:
    """Return the computed map with the one fitted to measured θ0 beside it.

    runs : paths of the fitted map a measured turn.
    harmonics : of the fitted map, None to choose them.
    """
    fitted = measured_cycle_map(read_theta0_pairs(file), harmonics=harmonics, runs=runs)
    least = [fitted.fitted.map_at(float(age)).turn(CIRCLE).min() for age in computed.cycles]
    seen = tuple(_where_seen(fitted, age) for age in AGES)
    pace = None if fitted.forecast is None else fitted.forecast.pace
    return replace(computed, pace=pace, measured_least=np.array(least), measured_turns=seen)


def _where_seen(fitted: MeasuredCycleMap, age: int) -> Array:
    """The fitted turn at `CIRCLE`, nan where no push within NEAR cycles of the age began within 8°
    of there.
    """
    pairs = fitted.pairs
    assert pairs.cycle is not None
    near = pairs.theta[np.abs(pairs.cycle - age) <= NEAR]
    apart = np.abs(shorter_way(CIRCLE[:, None] - near)).min(axis=1)
    turn = fitted.fitted.map_at(float(age)).turn(CIRCLE)
    return np.asarray(np.where(apart <= math.radians(8.0), turn, np.nan))


@picture_style()
def draw_wear(result: WearDrift) -> Figure:
    """The turn at three ages, computed and measured; the least turn and the cycles of a turn over
    the cycles.
    """
    seen = result.measured_turns
    layout = "aa;cd" if seen is None else "ab;cd"
    figure, (computed, *measured, least, pace) = page(layout, size=(10.5, 6.8))
    draw_turns(computed, CIRCLE, _by_age(result.turns))
    entitle(computed, "Computed: turn of a cycle")
    if seen is not None:
        draw_turns(measured[0], CIRCLE, _by_age(seen))
        measured[0].sharey(computed)
        entitle(measured[0], "Measured: turn of a cycle, fitted")
    least.axhline(0.0, **ZERO)
    least.plot(result.cycles, np.degrees(result.least), label="computed", **LINE)
    if result.measured_least is not None:
        fitted = np.degrees(result.measured_least)
        least.plot(result.cycles, fitted, label="measured, fitted", **THIRD)
    count_axis(least, "cycle", int(result.cycles[-1]))
    least.set_ylabel("least turn of a cycle (°)")
    entitle(least, "The bottleneck opens")
    pace.plot(result.ages, result.cycles_a_turn, marker="o", label="computed", **LINE)
    if result.pace is not None:
        draw_pace(pace, result.pace)
    pace.set(xlabel="cycle", ylabel="cycles a turn", xlim=(0, result.cycles[-1]), yscale="log")
    pace.set_ylim(15, 1000)
    plain_ticks(pace.yaxis, (20, 50, 100, 200, 500))
    entitle(pace, "Cycles a turn")
    return figure


def _by_age(turns: tuple[Array, ...]) -> dict[str, Array]:
    return {f"cycle {age}": turn for age, turn in zip(AGES, turns, strict=True)}


def wear_caption(result: WearDrift) -> str:
    """What is seen, with its numbers."""
    last, least = result.cycles_a_turn[-1], np.degrees(result.least[[0, -1]])
    words = (
        f"The cycle map of {MATERIAL}, whose friction was inferred from the measured staircase, as "
        f"the surface wears. The least turn of a cycle grows from {least[0]:.2f}° on the fresh "
        f"surface to {least[1]:.2f}° after {result.cycles[-1]:.0f} cycles: up to about cycle "
        f"{result.opened:.0f} a stable direction holds the robot and only noise "
        f"({angle(DEFAULT_SIGMA)}) frees it, then the bottleneck opens, and at the end "
        f"a turn takes {last:.0f} cycles; {result.expected_turns:.1f} turns are expected in all."
    )
    pace = result.pace
    if pace is None:
        return f"{words} Of the robot's own turns {NO_DATA}."
    return (
        f"{words} The robot's own turns took {pace.measured[0]:.0f} cycles early on and "
        f"{pace.measured[-1]:.0f} late (the measured curves are drawn where it has been within "
        f"{NEAR} cycles); a map fitted to its path, free to wear, holds {100 * pace.inside:.0f} % "
        "of them within its 95 % bands."
    )


EXHIBITS = {
    "staircase-bottleneck": Exhibit(staircase_bottleneck, bottleneck_caption, draw_bottleneck),
    "wear-drift": Exhibit(wear_drift, wear_caption, draw_wear),
}
