"""An object as a collection pushes it: sides by number, push, rod, ring and frame, and one cycle about the target."""

from __future__ import annotations

import math
import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from numpy.typing import NDArray

from cyclemap.collection.cycle_scene import cycle_scene
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.own_object import CheckedCollection, first_contact
from cyclemap.errors import CycleMapError
from cyclemap.views.style import FORCE, INK, MEASURED_EDGE, PREDICTED, PREDICTED_FILL, QUIET, new_figure, picture_style

Array = NDArray[np.float64]
MM = 1000.0
# More sides than this are those of a curve, whose numbers nobody needs.
_MOST_NUMBERS = 24
_LETTERS = 128


def object_page(checked: CheckedCollection) -> Figure:
    """Draw the set-up in the object's frame, one cycle in the world, and what the check found below them."""
    loop = checked.loop
    lines = [
        f"{'wrong' if finding.wrong else 'likely wrong'}: {line}" if not number else f"    {line}"
        for finding in checked.findings
        for number, line in enumerate(textwrap.wrap(finding.words, _LETTERS))
    ]
    height = 5.6 + 0.2 * len(lines)
    with picture_style():
        figure = new_figure(11.0, height)
        panels = figure.subplots(1, 2)
        figure.subplots_adjust(left=0.07, right=0.98, top=1.0 - 0.5 / height, bottom=(1.15 + 0.2 * len(lines)) / height)
        if loop is not None:
            draw_setup(panels[0], loop)
            _draw_cycle(panels[1], loop)
        figure.text(0.02, 0.12 / height, "\n".join(lines), va="bottom", color=INK, fontsize=8.5, linespacing=1.3)
    return figure


def draw_setup(axes: Axes, loop: CollectionLoop) -> None:
    """Draw the object in its own frame: its sides by number, the rod at its first touch, its way, the ring."""
    outline, reach = MM * loop.slider.outline_points(200), MM * loop.slider.outline.extent
    middle = MM * np.array(loop.slider.outline.centroid)
    axes.add_patch(Polygon(outline, facecolor=PREDICTED_FILL, edgecolor=PREDICTED, linewidth=1.6))
    for way, name in ((np.array([1.0, 0.0]), "x"), (np.array([0.0, 1.0]), "y")):
        _arrow(axes, np.zeros(2), 0.3 * reach * way, QUIET)
        axes.text(0.37 * reach * way[0], 0.37 * reach * way[1], name, ha="center", va="center", color=QUIET, fontsize=8)
    axes.plot(*(MM * np.array(loop.slider.centre_of_mass)), "+", color=INK, markersize=8, label="centre of mass")
    number_sides(axes, outline, 0.1)
    place, way = first_contact(loop.slider, loop.push, loop.pusher.radius)
    rod, radius = MM * place, MM * loop.pusher.radius
    length = MM * loop.push.distance
    axes.add_patch(Circle(tuple(rod), radius, facecolor=INK, zorder=4))
    axes.plot([], [], "o", color=INK, label=f"rod, radius {radius:.3g} mm")
    _arrow(axes, rod, rod + length * way, FORCE)
    axes.plot([], [], color=FORCE, label=f"push, {length:.4g} mm at side {loop.push.side}")
    ring = MM * np.array(loop.slider.hitch)
    axes.plot(
        *ring,
        "o",
        mfc="none",
        mec=MEASURED_EDGE,
        markersize=10,
        mew=1.8,
        label=f"ring ({ring[0]:.4g}, {ring[1]:.4g}) mm",
    )
    corners = np.vstack([outline, rod, rod + length * way, middle + 1.25 * reach, middle - 1.25 * reach])
    _frame(axes, corners, "object's frame")
    axes.set_title(f"{loop.slider.name}: set-up, to scale")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.11), ncols=2)


def number_sides(axes: Axes, outline: Array, out: float, **look: Any) -> None:
    """Write the number of each side of a closed outline (m, 2), `out` of half its size off it."""
    middle, reach = outline[:-1].mean(axis=0), 0.5 * float(np.ptp(outline, axis=0).max())
    if len(outline) - 1 > _MOST_NUMBERS:
        axes.text(middle[0], middle[1] - 0.5 * reach, "one curve: side 0", ha="center", color=QUIET, fontsize=8)
        return
    edge = np.diff(outline, axis=0)
    outward = np.stack([edge[:, 1], -edge[:, 0]], axis=-1) / np.hypot(*edge.T)[:, None]
    for number, (x, y) in enumerate((0.5 * (outline[:-1] + outline[1:]) + out * reach * outward).tolist()):
        name = f"side {number}" if number == 0 and out > 0.0 else str(number)
        axes.text(x, y, name, ha="center", va="center", **{"fontsize": 8, **look})


def _draw_cycle(axes: Axes, loop: CollectionLoop) -> None:
    """One cycle from θ0 = 0 in the world, whose origin is the target."""
    try:
        scene = cycle_scene(loop, loop.cycle(0.0))
    except CycleMapError:
        axes.axis("off")
        axes.text(0.5, 0.5, "no cycle can be run", ha="center", transform=axes.transAxes)
        return
    axes.add_patch(
        Polygon(
            MM * scene.push.before,
            facecolor=PREDICTED_FILL,
            edgecolor=PREDICTED,
            linewidth=1.6,
            label="before the push",
        )
    )
    axes.add_patch(Polygon(MM * scene.push.after, fill=False, edgecolor=PREDICTED, linestyle="--", label="after it"))
    axes.add_patch(
        Polygon(MM * scene.drag.after, fill=False, edgecolor=QUIET, linewidth=1.2, label="after the drag back")
    )
    axes.plot(*(MM * scene.push.rod).T, color=FORCE, linewidth=1.6, label="way of the rod")
    _arrow(axes, MM * scene.push.ring_after, np.zeros(2), MEASURED_EDGE)
    axes.plot([], [], color=MEASURED_EDGE, label="way of the ring")
    axes.plot(0.0, 0.0, "x", color=INK, markersize=9, mew=1.8, label="target of the ring", zorder=6)
    _frame(axes, MM * np.vstack([scene.push.before, scene.push.after, scene.drag.after, scene.push.rod]), "world")
    way = first_contact(loop.slider, loop.push, loop.pusher.radius)[1]
    towards = math.degrees(math.atan2(way[1], way[0]))
    axes.set_title(f"One cycle from orientation 0°, pushed towards {towards:.4g}°")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.11), ncols=3)


def _frame(axes: Axes, corners: Array, whose: str) -> None:
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle, half = 0.5 * (low + high), 0.56 * float((high - low).max())
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half), aspect="equal")
    axes.set(xlabel=f"x (mm), {whose}", ylabel="y (mm)")


def _arrow(axes: Axes, start: Array, end: Array, colour: str) -> None:
    look = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.8, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", xy=tuple(end), xytext=tuple(start), arrowprops=look, zorder=5)
