"""Figure: as the ring moves towards the centre, the stable and the unstable direction walk together
and meet.
"""

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.ticker import FuncFormatter, NullFormatter
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import ConvergenceError
from cyclemap.maps import OrbitBranch, orbit_branches, rotation_numbers
from cyclemap.views.style import (
    INK,
    MEASURED,
    PREDICTED,
    QUIET,
    UNSTABLE,
    Look,
    degree_axis,
    new_figure,
    picture_style,
)

from .catalogue import MeasuredFolder
from .loop_family import RingFold, loop_family, ring_fold, with_ring_at

MM = 1000.0
RADII = (0.008, 0.0155)
_FOLD = "saddle-node"
SHOWN = (0.013, 0.0085)
NEAREST, FARTHEST = 1e-5, 1.7e-3
_GRID = np.linspace(0.0, 2 * np.pi, 361)
# Radians, of the cycles that are interpolated.
_ACCURACY = 1e-6


@dataclass(frozen=True, eq=False)
class SaddleNode:
    """The pair of fixed points over the ring's radius (m), and what is left beyond their meeting.

    branch : both, stable and unstable, followed round the fold. fold : where they meet, by the
        exact tangents of the
    mechanics. error : rad, the most by which f on the branch
        differs from cycles that were run. distances : (n,) m, of the radius inside the fold.
        cycles_a_turn : (n,) there. counted : (k,
        2) distance (m) and cycles of one turn,
    run cycle by cycle. graphs : (radius m, θ (m,), turn (m,)) of the map before, at and beyond the
        fold.
    """

    branch: OrbitBranch
    fold: RingFold
    error: float
    distances: Array
    cycles_a_turn: Array
    counted: Array
    graphs: tuple[tuple[float, Array, Array], ...]

    @property
    def passage(self) -> Array:
        """Cycles that passage theory gives the bottleneck alone, π/√(ε a), at `distances`."""
        return np.array([self.fold.passage_cycles(self.fold.radius - d) for d in self.distances])

    def directions(self, radius: float) -> tuple[float, float]:
        """Return the stable and the unstable direction (rad) at a radius (m) that has both."""
        found = []
        for chosen in (self.branch.stable, ~self.branch.stable):
            order = np.argsort(self.branch.parameter[chosen])
            places = self.branch.parameter[chosen][order], self.branch.points[chosen, 0][order]
            found.append(float(np.interp(radius, *places)))
        return found[0], found[1]


def compute(
    measured: MeasuredFolder,
    nodes: int = 9,
    angles: int = 96,
    count: int = 14,
    counted: tuple[float, ...] = (1e-4, 5e-4),
) -> SaddleNode:
    """Follow the pair, meet it exactly, and time what is left: `nodes` radii of `angles` cycles
    each.

    count : distances beyond the fold at which cycles a turn are computed; counted : those (m) at
        which they are run.
    """
    del measured
    loop = CollectionLoop.mit(material="plywood")
    loop_at = partial(with_ring_at, loop)
    family = loop_family(
        partial(with_ring_at, replace(loop, accuracy=_ACCURACY)), (RADII,), (nodes,), angles
    )
    folding = (
        one
        for one in orbit_branches(family, RADII, resolution=6)
        if [s.kind for s in one.special] == [_FOLD]
    )
    if (branch := next(folding, None)) is None:
        raise ConvergenceError(
            "no pair of fixed points meets between these radii: take a wider range of radii"
        )
    fold = ring_fold(loop_at, branch.special[0].theta, float(branch.special[0].parameter))
    distances = np.geomspace(NEAREST, FARTHEST, count)
    # The interpolated pair meets a hair beside the exact fold: distances are taken from there.
    turns = rotation_numbers(
        family.parametric, float(branch.special[0].parameter) - distances, tolerance=2e-5, threads=1
    )
    runs = [
        (distance, _counted(loop_at(fold.radius - distance), fold.theta)) for distance in counted
    ]
    graphs = tuple(
        (radius, _GRID, family.turn(_GRID, radius)) for radius in (SHOWN[0], fold.radius, SHOWN[1])
    )
    places = np.linspace(0, branch.parameter.size - 1, 7).astype(int)
    error = max(
        float(family.error_at(branch.points[i], float(branch.parameter[i])).max()) for i in places
    )
    return SaddleNode(
        branch, fold, error, distances, 1.0 / turns.value, np.array(runs).reshape(-1, 2), graphs
    )


def _counted(loop: CollectionLoop, slow: float) -> float:
    """Cycles of one turn, run one by one from half a turn behind the slow direction `slow` (rad);
    part cycles count.
    """
    theta, cycles = slow - np.pi, 0
    end = theta + 2 * np.pi
    while True:
        following = loop.cycle(theta).theta_next
        if following >= end:
            return cycles + (end - theta) / (following - theta)
        theta, cycles = following, cycles + 1


def draw(result: SaddleNode) -> Figure:
    """The pair over the radius, its multiplier, the passage beyond,
    and three graphs of the turn."""
    with picture_style():
        figure = new_figure(10.0, 7.2)
        grid = GridSpec(
            2,
            1,
            figure,
            height_ratios=(2.0, 1.0),
            left=0.075,
            right=0.98,
            bottom=0.08,
            top=0.95,
            hspace=0.36,
        )
        upper = grid[0].subgridspec(2, 2, width_ratios=(1.35, 1.0), hspace=0.62, wspace=0.24)
        _draw_pair(figure.add_subplot(upper[:, 0]), result)
        axes = figure.add_subplot(upper[0, 1])
        branch = result.branch
        for _, chosen, look in _sides(branch):
            axes.plot(MM * branch.parameter[chosen], branch.multiplier[chosen], **look)
        axes.axhline(1.0, color=QUIET, linewidth=0.8)
        _mark(axes, result.fold, 1.0)
        axes.set(xlabel="distance of the ring (mm)", ylabel="multiplier f'(θ0) (1)")
        axes.set_xlim(MM * RADII[0], MM * RADII[1])
        axes.set_title("Multipliers meet at 1")
        axes = figure.add_subplot(upper[1, 1])
        beyond = MM * result.distances
        axes.loglog(
            beyond,
            result.cycles_a_turn,
            "o-",
            color=PREDICTED,
            markersize=3.5,
            label="cycles a turn",
        )
        axes.loglog(
            beyond, result.passage, "--", color=INK, linewidth=1.2, label="bottleneck, π/√(εa)"
        )
        if result.counted.size:
            look = {
                "markerfacecolor": MEASURED,
                "markeredgecolor": INK,
                "markersize": 7,
                "zorder": 5,
            }
            axes.plot(
                MM * result.counted[:, 0],
                result.counted[:, 1],
                "D",
                label="run cycle by cycle",
                **look,
            )
        axes.set(xlabel="distance inside the saddle-node (mm)", ylabel="cycles")
        axes.set_xticks((0.01, 0.03, 0.1, 0.3, 1.0))
        axes.set_yticks((20, 50, 100, 200))
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.set_minor_formatter(NullFormatter())
        axes.set_title("What is left: a passage")
        axes.legend(loc="upper right", borderaxespad=0.1)
        lower = grid[1].subgridspec(1, 3, wspace=0.12)
        first: Axes | None = None
        for place, graph in enumerate(result.graphs):
            axes = figure.add_subplot(lower[place], sharey=first)
            first = first or axes
            _draw_graph(axes, graph, place)
    return figure


def _sides(branch: OrbitBranch) -> list[tuple[str, NDArray[np.intp], Look]]:
    """The stable and the unstable part, by radius, each from the fold on, and its look."""
    fold = int(np.argmin(branch.parameter))
    sides = []
    for stable, name in ((True, "stable"), (False, "unstable")):
        chosen = np.union1d(np.flatnonzero(branch.stable == stable), [fold])
        look = {
            "color": PREDICTED if stable else QUIET,
            "linestyle": "-" if stable else "--",
            "linewidth": 2.0,
        }
        sides.append((name, chosen[np.argsort(branch.parameter[chosen])], look))
    return sides


def _draw_pair(axes: Axes, result: SaddleNode) -> None:
    branch, fold = result.branch, result.fold
    for name, chosen, look in _sides(branch):
        axes.plot(
            MM * branch.parameter[chosen], np.degrees(branch.points[chosen, 0]), label=name, **look
        )
    axes.axvspan(MM * RADII[0], MM * fold.radius, color="#eeeeee", zorder=0, linewidth=0)
    axes.text(
        MM * (RADII[0] + fold.radius) / 2, 60, "no fixed\ndirection", ha="center", color=QUIET
    )
    _mark(axes, fold, math.degrees(fold.theta))
    axes.annotate(
        f"saddle-node\n{MM * fold.radius:.3f} mm, {math.degrees(fold.theta):.1f}°",
        (MM * fold.radius, math.degrees(fold.theta)),
        (16, -4),
        textcoords="offset points",
        va="center",
    )
    axes.set(xlabel="distance of the ring from the centre (mm)", ylabel="direction θ0 (°)")
    axes.set_xlim(MM * RADII[0], MM * RADII[1])
    axes.set_yticks(range(45, 226, 45))
    axes.set_title("Directions that repeat")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2)


def _mark(axes: Axes, fold: RingFold, height: float) -> None:
    look: Look = {
        "markerfacecolor": UNSTABLE,
        "markeredgecolor": INK,
        "markersize": 7,
        "zorder": 5,
    }
    axes.plot(MM * fold.radius, height, "o", **look)


def _draw_graph(axes: Axes, graph: tuple[float, Array, Array], place: int) -> None:
    radius, theta, turn = graph
    axes.axhline(0.0, color=QUIET, linewidth=0.9)
    axes.plot(np.degrees(theta), np.degrees(turn), color=PREDICTED, linewidth=1.8)
    axes.set_title(
        f"ring {MM * radius:.{3 if place == 1 else 1}f} mm: "
        f"{('two zeros', 'a touch', 'none')[place]}"
    )
    degree_axis(axes, "θ0 (°)")
    axes.set_xticks(range(0, 361, 90))
    if place == 0:
        axes.set_ylabel("turn of a cycle (°)")
    else:
        axes.tick_params(labelleft=False)


def caption(result: SaddleNode) -> str:
    """What is seen, with its numbers."""
    stable, unstable = (math.degrees(theta) for theta in result.directions(0.013))
    near, law = result.distances[0], result.passage[0]
    return (
        "Plywood (Table I), exact patch. With the ring 13 mm from the centre the robot locks in at "
        f"{stable:.1f}° and is driven away from {unstable:.1f}°; as the ring moves in the two "
        f"directions walk together and meet at {math.degrees(result.fold.theta):.1f}° with the "
        f"ring at {MM * result.fold.radius:.3f} mm, both multipliers 1. Nearer the centre no "
        f"direction repeats, but the robot lingers: a turn takes {result.cycles_a_turn[0]:.0f} "
        f"cycles {MM * near:.2g} mm inside, {law:.0f} of which passage theory gives the "
        "bottleneck, and the passage shortens as one over the square root of the distance. The "
        f"curves miss cycles that were run by at most {math.degrees(result.error):.2g}°."
    )
