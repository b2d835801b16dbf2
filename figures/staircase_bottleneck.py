"""Figure: a staircase and the bottleneck of the cycle map that makes it, computed and measured."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.ticker import MaxNLocator

from cyclemap.arrays import Array
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
from cyclemap.views.style import (
    INK,
    MEASURED,
    MEASURED_EDGE,
    PREDICTED,
    PREDICTED_FILL,
    QUIET,
    Look,
    degree_axis,
    new_figure,
    picture_style,
)

from .catalogue import NO_DATA, THETA0_FILE, MeasuredFolder
from .loop_family import with_ring_at

# In time, of the law fitted with wear: what cross-validation finds best in the measured run.
WEAR_DEGREE = 2
# The ring, in metres, a tenth of a millimetre inside the saddle-node; cycles drawn as a staircase.
RADIUS, DRAWN = 0.0097, 800
SAMPLED = "#9db8d2"
_GRID = 2 * np.pi * np.arange(721) / 720


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
    found = bottleneck("measured plywood", fitted.map, fitted.sigma, pairs.path, turn_bins(pairs))
    if pairs.cycle is None:
        return found
    worn = fit_map(
        pairs.theta,
        pairs.theta_next,
        cycle=pairs.cycle,
        harmonics=HARMONICS,
        wear_degree=WEAR_DEGREE,
    )
    return replace(found, run=worn.paths(pairs.path[:1], pairs.path.size - 1)[0])


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
        operator.density(_GRID),
        path,
        lengths,
        (mean, spread),
        angle_histogram(path),
        bins,
    )


def draw(result: StaircaseBottleneck) -> Figure:
    """A row for the computed bottleneck and one for the measured, where there is one.

    Each shows map, directions, staircase, lengths of visits.
    """
    with picture_style():
        shown = [one for one in (result.computed, result.measured) if one is not None]
        tall = len(shown) > 1
        figure = new_figure(12.6, 6.6 if tall else 3.6)
        ends = {"bottom": 0.085, "top": 0.875} if tall else {"bottom": 0.15, "top": 0.78}
        grid = GridSpec(
            len(shown), 4, figure, left=0.05, right=0.99, wspace=0.27, hspace=0.62, **ends
        )
        for row, one in enumerate(shown):
            panels = [figure.add_subplot(grid[row, column]) for column in range(4)]
            figure.text(
                0.008,
                panels[0].get_position().y1 + (0.055 if tall else 0.1),
                one.title.capitalize(),
                fontsize=12,
                weight="bold",
            )
            for axes, panel in zip(
                panels, (_draw_turn, _draw_directions, _draw_path, _draw_lengths), strict=True
            ):
                panel(axes, one)
                if panel is not _draw_lengths:
                    axes.legend(
                        loc="lower left",
                        bbox_to_anchor=(-0.02, 1.0),
                        ncols=3,
                        borderaxespad=0.1,
                        columnspacing=0.9,
                        handlelength=1.5,
                        fontsize=7.5,
                    )
    return figure


def _seen(one: Bottleneck) -> str:
    return "sampled" if one.bins is None else "measured"


def _parabola(one: Bottleneck) -> tuple[Array, Array]:
    """Angles (rad) within four widths of the slowest, and ε + a x² there."""
    off = one.passage.width * np.linspace(-4.0, 4.0, 81)
    return one.passage.theta + off, one.passage.gap + one.passage.curvature * off**2


def _draw_turn(axes: Axes, one: Bottleneck) -> None:
    axes.axhline(0.0, color=QUIET, linewidth=0.9)
    if one.bins is not None:
        look: Look = {
            "markersize": 3,
            "markeredgecolor": MEASURED_EDGE,
            "markeredgewidth": 0.5,
        }
        axes.plot(
            np.degrees(one.bins.centre),
            np.degrees(one.bins.median),
            "s",
            color=MEASURED,
            label="medians",
            **look,
        )
    name = "map" if one.bins is None else "fitted map"
    axes.plot(
        np.degrees(_GRID),
        np.degrees(one.map.turn(_GRID)),
        color=PREDICTED,
        linewidth=1.8,
        label=name,
    )
    axes.plot(*np.degrees(_parabola(one)), "--", color=INK, linewidth=1.4, label="ε + a x²")
    degree_axis(axes, "θ0 (°)")
    axes.set_xticks(range(0, 361, 90))
    axes.set_ylabel("turn of a cycle (°)")


def _draw_directions(axes: Axes, one: Bottleneck) -> None:
    per_degree, fill = math.radians(1.0), PREDICTED_FILL if one.bins is None else MEASURED
    edges = np.degrees(one.histogram.edges)
    axes.stairs(per_degree * one.histogram.density, edges, fill=True, color=fill, label=_seen(one))
    axes.plot(
        np.degrees(_GRID),
        per_degree * one.density,
        color=PREDICTED,
        linewidth=1.5,
        label="predicted",
    )
    theta, pace = _parabola(one)
    share = per_degree / (2 * np.pi / float(one.prediction.mean_turn)) / pace
    axes.plot(np.degrees(theta), share, "--", color=INK, linewidth=1.2, label="1/(ε + a x²)")
    degree_axis(axes, "θ0 (°)")
    axes.set_xticks(range(0, 361, 90))
    axes.set(ylabel="share of cycles (per degree)")
    axes.set_ylim(bottom=0.0)


def _draw_path(axes: Axes, one: Bottleneck) -> None:
    shown = one.path if one.bins is not None else one.path[: DRAWN + 1]
    turns = (shown - shown[0]) / (2 * np.pi)
    look: Look = {"color": MEASURED_EDGE, "linewidth": 2.0}
    if one.bins is None:
        look = {"color": PREDICTED, "linewidth": 1.2}
    axes.plot(turns, label=_seen(one), **look)
    if one.run is not None:
        axes.plot(
            (one.run - one.run[0]) / (2 * np.pi),
            color=PREDICTED,
            linewidth=1.0,
            label="run of the map fitted with wear",
        )
    else:
        pace = float(one.prediction.mean_turn) / (2 * np.pi)
        axes.plot(
            [0, shown.size - 1],
            [0, pace * (shown.size - 1)],
            ":",
            color=INK,
            linewidth=1.2,
            label="its mean",
        )
    axes.set(xlabel="cycle", ylabel="turns climbed (1)", xlim=(0, shown.size - 1))


def _draw_lengths(axes: Axes, one: Bottleneck) -> None:
    mean, spread = one.visit
    top = 1.05 * max(float(one.lengths.max()), mean + 3 * spread)
    color, edge = (SAMPLED, PREDICTED) if one.bins is None else (MEASURED, MEASURED_EDGE)
    axes.hist(
        one.lengths,
        bins=np.linspace(0, top, 31).tolist(),
        color=color,
        edgecolor=edge,
        linewidth=0.5,
    )
    axes.axvspan(
        mean - spread, mean + spread, color=PREDICTED_FILL, alpha=0.55, zorder=0, linewidth=0
    )
    axes.axvline(mean, color=PREDICTED, linewidth=1.8, label=f"predicted {mean:.0f} ± {spread:.0f}")
    law = one.passage.passage_cycles
    axes.axvline(law, color=INK, linewidth=1.4, linestyle="--", label=f"π/√(εa) = {law:.0f}")
    seen = float(one.lengths.mean())
    axes.plot(
        [], [], "s", color=color, markeredgecolor=edge, label=f"{_seen(one)}, mean {seen:.0f}"
    )
    axes.set(xlabel="cycles on a step", ylabel="number of steps (1)", xlim=(0, top))
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True, min_n_ticks=1))
    axes.legend(loc="upper right", fontsize=7.5, borderaxespad=0.1, handlelength=1.5)


def caption(result: StaircaseBottleneck) -> str:
    """What is seen, with its numbers."""
    one = result.computed
    mean, spread = one.visit
    told = (
        f"Plywood (Table I) with its ring at {1000 * RADIUS:g} mm, just inside the saddle-node: no "
        f"direction repeats, but at {math.degrees(one.passage.theta):.0f}° a cycle turns the "
        f"object by {math.degrees(one.passage.gap):.2f}° only. There the robot spends most cycles, "
        "and each climb of 360° stops there: passage theory gives "
        f"{one.passage.passage_cycles:.0f} cycles, map and noise ({math.degrees(one.sigma):.1f}°) "
        f"together {mean:.0f} ± {spread:.0f}, {one.lengths.size} steps sampled from them lasted "
        f"{one.lengths.mean():.0f} on average."
    )
    found = result.measured
    if found is None:
        return f"{told} Of the robot's own staircase {NO_DATA}."
    climbs = ""
    if found.run is not None:
        climbed, measured = ((path[-1] - path[0]) / (2 * np.pi) for path in (found.run, found.path))
        climbs = (
            f" A run of the map fitted with its wear climbs {climbed:.1f} turns, the "
            f"measured path {measured:.1f}."
        )
    (mean, spread), halves = found.visit, np.array_split(found.lengths, 2)
    return (
        f"{told} The measured plywood staircase has such a bottleneck at "
        f"{math.degrees(found.passage.theta):.0f}°: its fitted map predicts steps of {mean:.0f} ± "
        f"{spread:.0f} cycles. The {found.lengths.size} measured ones that were seen whole lasted "
        f"{found.lengths.mean():.0f} ± {found.lengths.std(ddof=1):.0f}: they differ more than "
        f"noise makes them, since the surface wears: the first half {halves[0].mean():.0f}, the "
        f"second {halves[1].mean():.0f}.{climbs}"
    )
