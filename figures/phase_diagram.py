"""Figure: ring radius against anisotropy: where the robot locks into a direction, and how it winds
elsewhere.
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

from cyclemap.arrays import Array, even_angles
from cyclemap.collection.fingerprint import TurnResponse, fingerprint
from cyclemap.collection.fingerprint_prediction import first_order_lock_in
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import Anisotropy
from cyclemap.maps import RotationPlane, rotation_plane
from cyclemap.views.panels.layout import entitle, page
from cyclemap.views.panels.rotation import draw_shades
from cyclemap.views.panels.scene import MM, draw_object, draw_way
from cyclemap.views.panels.style import (
    INK,
    LINE,
    LINES,
    OPEN,
    PREDICTED,
    QUIET,
    SECOND,
    ZERO,
    Look,
    cross,
    picture_style,
)

from .catalogue import Exhibit, MeasuredFolder
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

RADII, SCALES = (0.006, 0.034), (0.0, 1.5)
# Turns a cycle, to which the shade is computed.
TOLERANCE = 2e-4
_ACCURACY = 1e-6
_THETA = even_angles(720)
LEVELS = (-5.0, 10.0, 20.0, 30.0)
ROWS = (0.0, 0.25, 0.5, 1.0)


@dataclass(frozen=True, eq=False)
class FirstOrder:
    """The lock-in boundary to first order in the anisotropy: Ω(r) + ε h(θ; r) touches zero, h by
    the fingerprint.

    radius : (n,) m.
    turn : (n,) rad, Ω, the isotropic turn of a cycle.
    scale : (n,) ε at which it locks.
    neutral : m, the radius where Ω is zero: the tip of the tongue.
    """

    radius: Array
    turn: Array
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


def compute(
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
        theta = _THETA[np.argmin(side * family.turn(_THETA, radius, scale))]
        folds.append(
            (
                scale,
                ring_fold(
                    partial(with_ring_at, with_anisotropy_times(loop, scale)), float(theta), radius
                ),
            )
        )
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
    return FirstOrder(radius, np.array([cycle.turn for cycle in responses]), scale, neutral)


@picture_style()
def draw(result: PhaseDiagram) -> Figure:
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


def caption(result: PhaseDiagram) -> str:
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
    "phase-diagram": Exhibit(compute, caption, draw),
}
