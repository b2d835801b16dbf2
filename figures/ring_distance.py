"""Figures of the ring's distance from the centre: as it shrinks the stable and the unstable
direction walk together and meet; and against the anisotropy, where the robot locks in.
"""

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.interpolate import BarycentricInterpolator
from scipy.optimize import brentq

from cyclemap.arrays import TWO_PI, Array, even_angles
from cyclemap.collection.fingerprint import TurnResponse, fingerprint
from cyclemap.collection.fingerprint_prediction import first_order_lock_in
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import Anisotropy
from cyclemap.errors import ConvergenceError
from cyclemap.maps import (
    OrbitBranch,
    RotationPlane,
    orbit_branches,
    rotation_numbers,
    rotation_plane,
)
from cyclemap.views.panels.layout import entitle, page
from cyclemap.views.panels.orbits import LOST, STABLE
from cyclemap.views.panels.orientation import draw_turns
from cyclemap.views.panels.rotation import draw_shades
from cyclemap.views.panels.scene import MM, draw_object, draw_way
from cyclemap.views.panels.style import (
    INK,
    LINE,
    LINES,
    MARKS,
    OPEN,
    PREDICTED,
    QUIET,
    SECOND,
    ZERO,
    Look,
    cross,
    degree_axis,
    name_beside,
    picture_style,
    plain_ticks,
)
from cyclemap.views.sentences import angle

from . import Exhibit, MeasuredFolder
from .loop_family import (
    LoopFamily,
    RingFold,
    chebyshev_nodes,
    loop_family,
    ring_fold,
    ring_radius,
    with_anisotropy_times,
    with_ring_at,
)

PAIR_RADII = (0.008, 0.0155)
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
    graphs : (radius m, turn (361,) rad at `_GRID`) of the map before, at and beyond the fold.
    """

    branch: OrbitBranch
    fold: RingFold
    error: float
    distances: Array
    cycles_a_turn: Array
    counted: Array
    graphs: tuple[tuple[float, Array], ...]

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


def saddle_node(
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
        partial(with_ring_at, replace(loop, accuracy=_ACCURACY)), (PAIR_RADII,), (nodes,), angles
    )
    folding = (
        candidate
        for candidate in orbit_branches(family, PAIR_RADII, resolution=6)
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
        (radius, family.turn(_GRID, radius)) for radius in (SHOWN[0], fold.radius, SHOWN[1])
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
    theta = slow - np.pi
    cycles = 0
    end = theta + TWO_PI
    while True:
        following = loop.cycle(theta).theta_next
        if following >= end:
            return cycles + (end - theta) / (following - theta)
        theta = following
        cycles += 1


@picture_style()
def draw_saddle_node(result: SaddleNode) -> Figure:
    """The pair over the radius, its multiplier, the passage beyond,
    and three graphs of the turn."""
    figure, panels = page("aab;aac;def", size=(11.0, 8.2))
    pair, multiplier, passage, *lower = panels
    branch = result.branch
    fold = result.fold
    _draw_sides(pair, branch, np.degrees(branch.points[:, 0]))
    pair.axvspan(MM * PAIR_RADII[0], MM * fold.radius, color="#eeeeee", zorder=0, linewidth=0)
    middle = 0.5 * MM * (PAIR_RADII[0] + fold.radius)
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
    for axes, ((radius, turn), zeros) in zip(lower, graphs, strict=True):
        axes.sharey(lower[0])
        draw_turns(axes, _GRID, {"turn": turn})
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
    axes.set_xlim(MM * PAIR_RADII[0], MM * PAIR_RADII[1])


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


def saddle_node_caption(result: SaddleNode) -> str:
    """What is seen, with its numbers."""
    stable, unstable = (math.degrees(theta) for theta in result.directions(0.013))
    near = result.distances[0]
    law = result.passage[0]
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


RADII, SCALES = (0.006, 0.034), (0.0, 1.5)
# Turns a cycle, to which the shade is computed.
TOLERANCE = 2e-4
_THETA = even_angles(720)
LEVELS = (-5.0, 10.0, 20.0, 30.0)
ROWS = (0.0, 0.25, 0.5, 1.0)


@dataclass(frozen=True, eq=False)
class FirstOrder:
    """The lock-in boundary to first order in the anisotropy: Ω(r) + ε h(θ; r) touches zero, h by
    the fingerprint.

    radius : (n,) m.
    scale : (n,) ε at which it locks.
    neutral : m, the radius where Ω is zero: the tip of the tongue.
    """

    radius: Array
    scale: Array
    neutral: float


@dataclass(frozen=True, eq=False)
class PhaseDiagram:
    """The loop on plywood with its ring at a radius (m) and its anisotropy times a scale.

    plane : rotation numbers, turns a cycle; rows radii, columns scales.
    stable : (rows, columns) stable fixed points.
    inner, outer : ((scale, fold), ...) of the boundary nearer to the centre and farther from it,
        exact.
    first : to first order.
    error : rad, the most by which the interpolated f differs from cycles that were run at some
        places.
    mit : m, the ring of the MIT protocol; mit_scale : from which scale on it locks, by the
        interpolated maps.
    """

    plane: RotationPlane
    stable: NDArray[np.int64]
    inner: tuple[tuple[float, RingFold], ...]
    outer: tuple[tuple[float, RingFold], ...]
    first: FirstOrder
    error: float
    mit: float
    mit_scale: float


def loop_at(loop: CollectionLoop, radius: float, scale: float) -> CollectionLoop:
    """Return the loop with its ring at `radius` (m) and its anisotropy times `scale`."""
    return replace(with_ring_at(with_anisotropy_times(loop, scale), radius), accuracy=_ACCURACY)


def phase_diagram(
    measured: MeasuredFolder,
    nodes: tuple[int, int] = (9, 6),
    angles: int = 32,
    shape: tuple[int, int] = (85, 43),
    scales: int = 9,
    fingerprints: int = 9,
) -> PhaseDiagram:
    """Interpolate the maps, wind them on a grid of `shape`, and trace the boundary exactly at
    `scales` scales a side.

    nodes, angles : of `loop_family`.
    fingerprints : at so many radii, for the boundary to first order.
    """
    del measured
    loop = CollectionLoop.mit(material="plywood")
    family = loop_family(partial(loop_at, loop), (RADII, SCALES), nodes, angles)
    radius, scale = np.linspace(*RADII, shape[0]), np.linspace(*SCALES, shape[1])
    plane = rotation_plane(family.parametric, radius, scale, TOLERANCE)
    inner, outer = (_boundary(loop, family, side, scales) for side in (1, -1))
    places = ((0.010, 1.0), (0.020, 0.7), (0.030, 1.2))
    error = max(float(family.error_at(_THETA[::36], *place).max()) for place in places)
    # How often the turn falls through zero at each radius and scale.
    stable = []
    for r in radius:
        turn = family.turn(_THETA, np.full((scale.size, 1), r), scale[:, np.newaxis])
        stable.append(np.sum((turn > 0.0) & (np.roll(turn, -1, axis=1) <= 0.0), axis=1))
    first, mit = first_order(loop, fingerprints), ring_radius(loop)
    return PhaseDiagram(
        plane, np.array(stable), inner, outer, first, error, mit, _touch(family, 1, mit)
    )


def _margin(family: LoopFamily, side: int, radius: float, scale: float) -> float:
    """The least turn (side 1), or the largest with its sign changed (side -1): negative where the
    robot may lock.
    """
    return float((side * family.turn(_THETA, radius, scale)).min())


def _touch(family: LoopFamily, side: int, radius: float) -> float:
    """The scale at which the boundary passes a radius; the largest one where it does not."""
    low, high = (_margin(family, side, radius, scale) for scale in SCALES)
    if low * high > 0.0:
        return SCALES[1]
    return float(brentq(lambda scale: _margin(family, side, radius, scale), *SCALES))


def _boundary(
    loop: CollectionLoop, family: LoopFamily, side: int, count: int
) -> tuple[tuple[float, RingFold], ...]:
    """The folds where the least (side 1) or the largest (side -1) turn is zero, up to where they
    leave the radii.
    """
    edge = RADII[0] if side > 0 else RADII[1]
    top, folds = _touch(family, side, edge), []
    for step in range(1, count + 1):
        scale, radius = top * step / count, edge
        if step < count or top == SCALES[1]:
            radius = brentq(lambda r, now=scale: _margin(family, side, r, now), *RADII, xtol=1e-6)
        theta = float(_THETA[np.argmin(side * family.turn(_THETA, radius, scale))])
        surface = with_anisotropy_times(loop, scale)
        folds.append((scale, ring_fold(partial(with_ring_at, surface), theta, radius)))
    return tuple(folds)


def first_order(loop: CollectionLoop, nodes: int) -> FirstOrder:
    """Return the boundary that the fingerprints of the protocol at `nodes` radii foretell, at 201
    radii.

    Turn and gradient of a fingerprint belong to the protocol alone; between the Chebyshev nodes
    they are interpolated.
    """
    radii, radius = chebyshev_nodes(*RADII, nodes), np.linspace(*RADII, 201)
    responses_at = [fingerprint(with_ring_at(loop, r)).cycle for r in radii.tolist()]
    curve = BarycentricInterpolator(
        radii, np.array([[cycle.turn, *cycle.gradient] for cycle in responses_at])
    )
    surface, flat = Anisotropy.of(loop.material.friction), np.zeros((4, 4))
    responses = [TurnResponse(float(row[0]), row[1:], flat) for row in curve(radius)]
    scale = np.array([first_order_lock_in(response, surface).scale for response in responses])
    neutral = float(brentq(lambda r: float(curve(r)[0]), *RADII))
    return FirstOrder(radius, scale, neutral)


@picture_style()
def draw_phase_diagram(result: PhaseDiagram) -> Figure:
    """The plane, shaded by the mean turn, with its boundary; and the mean turn along four of its
    rows.
    """
    figure, (plane, rows) = page("ab", size=(11.4, 5.2), width_ratios=(1.75, 1.0))
    _draw_plane(plane, result)
    planes = result.plane
    rows.axhline(0.0, **ZERO)
    for scale, look in zip(ROWS[::-1], LINES, strict=True):
        column = int(np.argmin(np.abs(planes.second_values - scale)))
        label = "isotropic" if scale == 0.0 else f"× {planes.second_values[column]:.2g}"
        rows.plot(MM * planes.first_values, 360 * planes.value[:, column], label=label, **look)
    rows.set(xlabel="distance of the ring (mm)", ylabel="mean turn of a cycle (°)")
    rows.set_xlim(MM * RADII[0], MM * RADII[1])
    entitle(rows, "Along rows")
    return figure


def _draw_plane(axes: Axes, result: PhaseDiagram) -> None:
    plane, first = result.plane, result.first
    radius, scale, turn = MM * plane.first_values, plane.second_values, 360 * plane.value
    label = "size of the mean turn of a cycle (°)"
    bar = draw_shades(
        axes, radius, scale, np.abs(turn), label, cmap="YlGnBu", vmin=-4, vmax=45, shading="gouraud"
    )
    bar.ax.set_ylim(0.0, np.abs(turn).max())
    lines = axes.contour(radius, scale, turn.T, levels=LEVELS, colors=INK, linewidths=0.7)
    axes.clabel(lines, fmt=lambda value: f"{value:+.0f}°", fontsize=7.5, inline_spacing=3)
    _draw_tongue(axes, result)
    axes.plot(MM * first.radius, first.scale, label="first order", **SECOND)
    star: Look = {"marker": "*", "markersize": 11, "zorder": 6, **OPEN}
    axes.plot(MM * result.mit, 1.0, label="MIT ring, plywood", **star)
    axes.text(20.5, 1.12, "locked\none stable direction", ha="center", va="center", color=PREDICTED)
    axes.set_xlabel("distance of the ring from the centre (mm)")
    axes.set_ylabel("anisotropy over that of Table I (1)")
    axes.set(xlim=(MM * RADII[0], MM * RADII[1]), ylim=SCALES)
    _draw_object(axes.inset_axes((0.72, 0.62, 0.27, 0.36)), result, star)
    entitle(axes, "Mean turn of a cycle")


def _draw_object(axes: Axes, result: PhaseDiagram, star: Look) -> None:
    """The object, and the way of its ring."""
    outline = CollectionLoop.mit("plywood").slider.outline.points(4)
    draw_object(axes, outline, facecolor="#f4f4f4", edgecolor=QUIET)
    way = np.array([-1.0, 1.0]) / math.sqrt(2.0)
    draw_way(axes, np.outer(RADII, way), color=PREDICTED, linewidth=1.0, zorder=3)
    cross(axes, colour=INK)
    axes.plot(*(MM * result.mit * way), **star)
    axes.text(0.0, -22.0, "object, and\nthe ring's way", fontsize=7.5, ha="center", va="center")
    axes.set(xlim=(-48, 48), ylim=(-48, 48), aspect="equal")
    axes.axis("off")


def _draw_tongue(axes: Axes, result: PhaseDiagram) -> None:
    """The tongue in white, and its two edges."""
    tip = np.array([[MM * result.first.neutral, 0.0]])
    inner, outer = (
        np.concatenate([tip, [(MM * fold.radius, scale) for scale, fold in side]])
        for side in (result.inner, result.outer)
    )
    corners = [(MM * RADII[1], SCALES[1]), (MM * RADII[0], SCALES[1])]
    tongue = np.concatenate([outer, corners, inner[::-1]])
    axes.fill(*tongue.T, facecolor="white", linewidth=0, zorder=2)
    for edge in (inner, outer):
        axes.plot(*edge.T, marker="o", markersize=4, label="saddle-nodes", **LINE)


def phase_caption(result: PhaseDiagram) -> str:
    """What is seen, with its numbers."""
    plane, first = result.plane, result.first
    locked = plane.period == 1
    is_one = bool(np.all(result.stable[locked] == 1))
    at_mit = float(np.interp(result.mit, first.radius, first.scale))
    count = int(np.sum(plane.period > 1))
    others = f"At {count} places of the grid the robot locks into a longer period."
    if not count:
        others = f"No other locking was found on the grid, to {TOLERANCE:g} turns a cycle."
    return (
        f"Plywood's anisotropy (offset and ellipticity of Table I, times 0 to {SCALES[1]:g}) "
        "against the distance of the ring from the centre. In the tongue the robot "
        f"locks{' into one stable direction' if is_one else ''}, elsewhere it winds, shaded by "
        "the size of its mean turn (lines: with sign). The tongue starts at "
        f"{MM * first.neutral:.1f} mm, where isotropic friction turns the object by nothing in a "
        "cycle; its edges are saddle-nodes, solved with the mechanics itself. The MIT ring at "
        f"{MM * result.mit:.0f} mm locks from {result.mit_scale:.2f} times Table I on; to first "
        f"order in the anisotropy (dashes) from {at_mit:.2f} times. {others} The interpolated maps "
        f"miss cycles that were run by at most {math.degrees(result.error):.1g}°."
    )


EXHIBITS = {
    "saddle-node": Exhibit(saddle_node, saddle_node_caption, draw_saddle_node),
    "phase-diagram": Exhibit(phase_diagram, phase_caption, draw_phase_diagram),
}
