"""Figure: a staircase and the bottleneck of the cycle map that makes it, computed and measured."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from cyclemap.arrays import TWO_PI, Array
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence import (
    AngleHistogram,
    TurnBins,
    angle_histogram,
    fit_map,
    read_theta0_pairs,
    turn_bins,
)
from cyclemap.evidence.laws.fit_map import HARMONICS
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
    draw_histogram,
    draw_medians,
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
    Look,
    count_axis,
    degree_axis,
    picture_style,
)
from cyclemap.views.sentences import angle

from .catalogue import NO_DATA, THETA0_FILE, Exhibit, MeasuredFolder
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
        [0, 2π] by the
    transfer operator. path : (m,) rad, unwrapped. lengths : cycles of its visits of the predicted
        slow zone that were seen whole; visit : mean and standard deviation of one as predicted, nan
        where they could not be computed.
    histogram : of the path's directions. bins : medians of measured turns, None of a sampled path.
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
    visit: tuple[float, float]
    histogram: AngleHistogram
    bins: TurnBins | None = None
    run: Array | None = None


@dataclass(frozen=True)
class StaircaseBottleneck:
    """The bottleneck of plywood with its ring near the saddle-node, and of the measured plywood
    (None without data).
    """

    computed: Bottleneck
    measured: Bottleneck | None


def compute(
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
    steps, zone = find_steps(path, zones=prediction.zones), prediction.zones[0]
    lengths = steps.lengths[~steps.censored].astype(float)
    mean, spread = (
        math.nan if value is None else value for value in (zone.visit_cycles, zone.visit_spread)
    )
    return Bottleneck(
        title,
        circle_map,
        sigma,
        slowest,
        prediction,
        operator.density(CIRCLE),
        path,
        lengths,
        (mean, spread),
        angle_histogram(path),
        bins,
    )


@picture_style()
def draw(result: StaircaseBottleneck) -> Figure:
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
    look = BAND if case.bins is None else BARS
    draw_histogram(axes, case.histogram, _seen(case), fill=True, **look)
    axes.plot(np.degrees(CIRCLE), PER_DEGREE * case.density, label="predicted", **LINE)
    theta, pace = _parabola(case)
    share = PER_DEGREE * float(case.prediction.mean_turn) / (TWO_PI * pace)
    axes.plot(np.degrees(theta), share, label="1/(ε + a x²)", **SECOND)
    axes.set_ylabel("share of cycles (per degree)")
    axes.set_ylim(bottom=0.0)


def _draw_path(axes: Axes, case: Bottleneck) -> None:
    """The path in turns from its start, beside the fitted map's run, or its mean pace."""
    shown = case.path if case.bins is not None else case.path[: DRAWN + 1]
    pace = float(case.prediction.mean_turn)
    run = {**LINE, "linewidth": 1.2}
    turns = (shown - shown[0]) / TWO_PI
    axes.plot(turns, label=_seen(case), **(run if case.bins is None else PATH))
    if case.run is None:
        mean = pace / TWO_PI * np.arange(shown.size)
        axes.plot(mean, label="its mean", **FOURTH)
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


def caption(result: StaircaseBottleneck) -> str:
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


EXHIBITS = {
    "staircase-bottleneck": Exhibit(compute, caption, draw),
}
