"""Figure: as the ring moves towards the centre, the stable and the unstable direction walk together
and meet.
"""

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import TWO_PI, Array
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import ConvergenceError
from cyclemap.maps import OrbitBranch, orbit_branches, rotation_numbers
from cyclemap.views.panels.layout import entitle, page
from cyclemap.views.panels.orbits import LOST, STABLE
from cyclemap.views.panels.orientation import draw_turns
from cyclemap.views.panels.scene import MM
from cyclemap.views.panels.style import (
    LINE,
    MARKS,
    OPEN,
    QUIET,
    SECOND,
    ZERO,
    degree_axis,
    name_beside,
    picture_style,
    plain_ticks,
)
from cyclemap.views.sentences import angle

from .catalogue import Exhibit, MeasuredFolder
from .loop_family import RingFold, loop_family, ring_fold, with_ring_at

RADII = (0.008, 0.0155)
_FOLD = "saddle-node"
SHOWN = (0.013, 0.0085)
NEAREST, FARTHEST = 1e-5, 1.7e-3
_GRID = np.linspace(0.0, TWO_PI, 361)
# Radians, of the cycles that are interpolated.
_ACCURACY = 1e-6


@dataclass(frozen=True, eq=False)
class SaddleNode:
    """The pair of fixed points over the ring's radius (m), and what is left beyond their meeting.

    branch : both, stable and unstable, followed round the fold.
    fold : where they meet, by the exact tangents of the mechanics.
    error : rad, the most by which f on the branch differs from cycles that were run.
    distances : (n,) m, of the radius inside the fold.
    cycles_a_turn : (n,) there.
    counted : (k, 2) distance (m) and cycles of one turn, run cycle by cycle.
    graphs : (radius m, θ (m,), turn (m,)) of the map before, at and beyond the fold.
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
        thetas = []
        for chosen in (self.branch.stable, ~self.branch.stable):
            order = np.argsort(self.branch.parameter[chosen])
            places = self.branch.parameter[chosen][order], self.branch.points[chosen, 0][order]
            thetas.append(float(np.interp(radius, *places)))
        return thetas[0], thetas[1]


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
        candidate
        for candidate in orbit_branches(family, RADII, resolution=6)
        if [s.kind for s in candidate.special] == [_FOLD]
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
    end = theta + TWO_PI
    while True:
        following = loop.cycle(theta).theta_next
        if following >= end:
            return cycles + (end - theta) / (following - theta)
        theta, cycles = following, cycles + 1


@picture_style()
def draw(result: SaddleNode) -> Figure:
    """The pair over the radius, its multiplier, the passage beyond,
    and three graphs of the turn."""
    figure, panels = page("aab;aac;def", size=(11.0, 8.2))
    pair, multiplier, passage, *lower = panels
    branch, fold = result.branch, result.fold
    _draw_sides(pair, branch, np.degrees(branch.points[:, 0]))
    pair.axvspan(MM * RADII[0], MM * fold.radius, color="#eeeeee", zorder=0, linewidth=0)
    middle = 0.5 * MM * (RADII[0] + fold.radius)
    pair.text(middle, 60, "no fixed\ndirection", ha="center", color=QUIET)
    place = MM * fold.radius, math.degrees(fold.theta)
    pair.plot(*place, "o", markersize=7, zorder=5, **OPEN)
    name = f"saddle-node {place[0]:.3f} mm, {place[1]:.1f}°"
    name_beside(pair, *place, name, (10, -4))
    pair.set_ylabel("direction θ0 (°)")
    pair.set_yticks(range(45, 226, 45))
    entitle(pair, "Directions that repeat")
    _draw_sides(multiplier, branch, branch.multiplier)
    multiplier.axhline(1.0, **ZERO)
    multiplier.plot(MM * fold.radius, 1.0, "o", markersize=7, zorder=5, **OPEN)
    multiplier.set_ylabel("multiplier f'(θ0) (1)")
    entitle(multiplier, "Multipliers meet at 1")
    _draw_passage(passage, result)
    graphs = zip(result.graphs, ("two zeros", "a touch", "none"), strict=True)
    for axes, ((radius, theta, turn), zeros) in zip(lower, graphs, strict=True):
        axes.sharey(lower[0])
        draw_turns(axes, theta, {"turn": turn})
        degree_axis(axes, "θ0 (°)", 90)
        axes.set_ylabel("turn of a cycle (°)")
        axes.label_outer()
        axes.set_title(f"ring {MM * radius:.{3 if zeros == 'a touch' else 1}f} mm: {zeros}")
    return figure


def _draw_sides(axes: Axes, branch: OrbitBranch, values: Array) -> None:
    """Values along the stable and the unstable part of the branch, by radius, each from the fold
    on.
    """
    fold = int(np.argmin(branch.parameter))
    for side, look in ((branch.stable, STABLE), (~branch.stable, LOST)):
        chosen = np.union1d(np.flatnonzero(side), [fold])
        chosen = chosen[np.argsort(branch.parameter[chosen])]
        axes.plot(MM * branch.parameter[chosen], values[chosen], **look)
    axes.set_xlabel("distance of the ring from the centre (mm)")
    axes.set_xlim(MM * RADII[0], MM * RADII[1])


def _draw_passage(axes: Axes, result: SaddleNode) -> None:
    beyond = MM * result.distances
    axes.loglog(beyond, result.cycles_a_turn, marker=".", label="cycles a turn", **LINE)
    axes.loglog(beyond, result.passage, label="bottleneck, π/√(εa)", **SECOND)
    if result.counted.size:
        distance, counted = result.counted.T
        axes.plot(MM * distance, counted, "D", label="run cycle by cycle", **MARKS)
    axes.set(xlabel="distance inside the saddle-node (mm)", ylabel="cycles")
    plain_ticks(axes.xaxis, (0.01, 0.03, 0.1, 0.3, 1.0))
    plain_ticks(axes.yaxis, (20, 50, 100, 200))
    axes.set_title("What is left: a passage")
    axes.legend(loc="upper right", borderaxespad=0.1)


def caption(result: SaddleNode) -> str:
    """What is seen, with its numbers."""
    stable, unstable = (math.degrees(theta) for theta in result.directions(0.013))
    near, law = result.distances[0], result.passage[0]
    return (
        "Plywood (Table I), exact patch. With the ring 13 mm from the centre the robot locks in at "
        f"{stable:.1f}° and is driven away from {unstable:.1f}°; as the ring moves in the two "
        f"directions walk together and meet at {angle(result.fold.theta)} with the "
        f"ring at {MM * result.fold.radius:.3f} mm, both multipliers 1. Nearer the centre no "
        f"direction repeats, but the robot lingers: a turn takes {result.cycles_a_turn[0]:.0f} "
        f"cycles {MM * near:.2g} mm inside, {law:.0f} of which passage theory gives the "
        "bottleneck, and the passage shortens as one over the square root of the distance. The "
        f"curves miss cycles that were run by at most {math.degrees(result.error):.2g}°."
    )


EXHIBITS = {
    "saddle-node": Exhibit(compute, caption, draw),
}
