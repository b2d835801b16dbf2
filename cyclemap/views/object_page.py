"""The object with its push and its ring, and a cycle's push and drag,
drawn to scale in the plane."""

from __future__ import annotations

import math
import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from matplotlib.ticker import MaxNLocator

from cyclemap.arrays import Array
from cyclemap.collection.cycle_scene import CycleScene
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError
from cyclemap.mechanics.first_touch import first_contact
from cyclemap.protocol.own_object import CheckedCollection
from cyclemap.views import style
from cyclemap.views.style import FORCE, INK, MEASURED_EDGE, PREDICTED, PREDICTED_FILL, QUIET, Look

MM = 1000.0
# More sides than this are those of a curve, whose numbers nobody needs.
_MOST_NUMBERS = 24
_LETTERS = 128
RING_RADIUS_MM = 7.0
# The longest arrow as a share of the window.
LONGEST_ARROW = 0.13


@style.picture_style()
def object_page(checked: CheckedCollection) -> Figure:
    """Draw the set-up in the object's frame, one cycle in the world, and what the check found below
    them.
    """
    loop = checked.loop
    lines = [
        f"{'wrong' if finding.wrong else 'likely wrong'}: {line}" if not number else f"    {line}"
        for finding in checked.findings
        for number, line in enumerate(textwrap.wrap(finding.words, _LETTERS))
    ]
    height = 5.6 + 0.2 * len(lines)
    figure = style.new_figure(11.0, height)
    panels = figure.subplots(1, 2)
    figure.subplots_adjust(
        left=0.07, right=0.98, top=1.0 - 0.5 / height, bottom=(1.15 + 0.2 * len(lines)) / height
    )
    if loop is not None:
        draw_setup(panels[0], loop)
        _draw_cycle(panels[1], loop)
    figure.text(
        0.02, 0.12 / height, "\n".join(lines), va="bottom", color=INK, fontsize=8.5, linespacing=1.3
    )
    return figure


def draw_setup(axes: Axes, loop: CollectionLoop) -> None:
    """Draw the object in its own frame: its sides by number, the rod at its first touch, its way,
    the ring.
    """
    outline, reach = MM * loop.slider.outline_points(200), MM * loop.slider.outline.extent
    middle = MM * np.array(loop.slider.outline.centroid)
    axes.add_patch(Polygon(outline, facecolor=PREDICTED_FILL, edgecolor=PREDICTED, linewidth=1.6))
    for way, name in ((np.array([1.0, 0.0]), "x"), (np.array([0.0, 1.0]), "y")):
        style.arrow(axes, np.zeros(2), 0.3 * reach * way, QUIET)
        axes.text(
            0.37 * reach * way[0],
            0.37 * reach * way[1],
            name,
            ha="center",
            va="center",
            color=QUIET,
            fontsize=8,
        )
    axes.plot(
        *(MM * np.array(loop.slider.centre_of_mass)),
        "+",
        color=INK,
        markersize=8,
        label="centre of mass",
    )
    number_sides(axes, outline, 0.1)
    place, way = first_contact(loop.slider, loop.push, loop.pusher.radius)
    rod, radius = MM * place, MM * loop.pusher.radius
    length = MM * loop.push.distance
    axes.add_patch(Circle(tuple(rod), radius, facecolor=INK, zorder=4))
    axes.plot([], [], "o", color=INK, label=f"rod, radius {radius:.3g} mm")
    style.arrow(axes, rod, rod + length * way, FORCE)
    axes.plot([], [], color=FORCE, label=f"push, {length:.4g} mm at side {loop.push.side}")
    ring = MM * np.array(loop.slider.hitch)
    told = f"ring ({ring[0]:.4g}, {ring[1]:.4g}) mm"
    axes.plot(*ring, "o", mfc="none", mec=MEASURED_EDGE, markersize=10, mew=1.8, label=told)
    corners = np.vstack(
        [outline, rod, rod + length * way, middle + 1.25 * reach, middle - 1.25 * reach]
    )
    _frame(axes, corners, "object's frame")
    axes.set_title(f"{loop.slider.name}: set-up, to scale")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.11), ncols=2)


def number_sides(axes: Axes, outline: Array, out: float, **look: Any) -> None:
    """Write the number of each side of a closed outline (m, 2), `out` of half its size off it."""
    middle, reach = outline[:-1].mean(axis=0), 0.5 * float(np.ptp(outline, axis=0).max())
    if len(outline) - 1 > _MOST_NUMBERS:
        axes.text(
            middle[0],
            middle[1] - 0.5 * reach,
            "one curve: side 0",
            ha="center",
            color=QUIET,
            fontsize=8,
        )
        return
    edge = np.diff(outline, axis=0)
    outward = np.stack([edge[:, 1], -edge[:, 0]], axis=-1) / np.hypot(*edge.T)[:, None]
    for number, (x, y) in enumerate(
        (0.5 * (outline[:-1] + outline[1:]) + out * reach * outward).tolist()
    ):
        name = f"side {number}" if number == 0 and out > 0.0 else str(number)
        axes.text(x, y, name, ha="center", va="center", **{"fontsize": 8, **look})


def _draw_cycle(axes: Axes, loop: CollectionLoop) -> None:
    """One cycle from θ0 = 0 in the world, whose origin is the target."""
    try:
        scene = loop.cycle(0.0).scene()
    except CycleMapError:
        axes.axis("off")
        axes.text(0.5, 0.5, "no cycle can be run", ha="center", transform=axes.transAxes)
        return
    outlines: tuple[tuple[Array, Look], ...] = (
        (
            scene.push.before,
            {"fc": PREDICTED_FILL, "ec": PREDICTED, "lw": 1.6, "label": "before the push"},
        ),
        (scene.push.after, {"fill": False, "ec": PREDICTED, "ls": "--", "label": "after it"}),
        (scene.drag.after, {"fill": False, "ec": QUIET, "lw": 1.2, "label": "after the drag back"}),
    )
    for outline, look in outlines:
        axes.add_patch(Polygon(MM * outline, **look))
    axes.plot(*(MM * scene.push.rod).T, color=FORCE, linewidth=1.6, label="way of the rod")
    style.arrow(axes, MM * scene.push.ring_after, np.zeros(2), MEASURED_EDGE)
    axes.plot([], [], color=MEASURED_EDGE, label="way of the ring")
    axes.plot(0.0, 0.0, "x", color=INK, markersize=9, mew=1.8, label="target of the ring", zorder=6)
    _frame(
        axes,
        MM * np.vstack([scene.push.before, scene.push.after, scene.drag.after, scene.push.rod]),
        "world",
    )
    way = first_contact(loop.slider, loop.push, loop.pusher.radius)[1]
    towards = math.degrees(math.atan2(way[1], way[0]))
    axes.set_title(f"One cycle from orientation 0°, pushed towards {towards:.4g}°")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.11), ncols=3)


def _frame(axes: Axes, corners: Array, whose: str) -> None:
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle, half = 0.5 * (low + high), 0.56 * float((high - low).max())
    axes.set(
        xlim=(middle[0] - half, middle[0] + half),
        ylim=(middle[1] - half, middle[1] + half),
        aspect="equal",
    )
    axes.set(xlabel=f"x (mm), {whose}", ylabel="y (mm)")


def draw_cycle(push_axes: Axes, drag_axes: Axes, scene: CycleScene) -> None:
    """The push in one panel, the drag in the other, on the same scale and window."""
    corners = MM * np.stack([scene.push.reach, scene.drag.reach])
    low, high = corners[:, 0].min(axis=0) - 8.0, corners[:, 1].max(axis=0) + 8.0
    mm_per_newton = LONGEST_ARROW * float((high - low).max()) / scene.strongest_force
    for axes, stroke in ((push_axes, scene.push), (drag_axes, scene.drag)):
        axes.add_patch(
            Polygon(
                MM * stroke.before, facecolor="#f4f4f4", edgecolor=QUIET, linestyle="--", zorder=1
            )
        )
        axes.add_patch(
            Polygon(
                MM * stroke.after,
                facecolor=PREDICTED_FILL,
                edgecolor=PREDICTED,
                linewidth=1.6,
                alpha=0.75,
                zorder=2,
            )
        )
        axes.plot(*(MM * stroke.centre).T, color=QUIET, linewidth=0.9, zorder=3)
        axes.plot(*(MM * stroke.centre[-1]), "+", color=PREDICTED, markersize=7, zorder=4)
        axes.plot(*(MM * stroke.centre[0]), "+", color=QUIET, markersize=7, zorder=3)
        for place, colour, line in (
            (stroke.ring_before, QUIET, "--"),
            (stroke.ring_after, PREDICTED, "-"),
        ):
            look: Look = {
                "fill": False,
                "edgecolor": colour,
                "linestyle": line,
                "zorder": 4,
            }
            axes.add_patch(Circle(tuple(MM * place), RING_RADIUS_MM, **look))
        # The rod's path: thick where it sticks, thin and dotted where it slides; the rod at both
        # ends.
        path = MM * stroke.rod
        axes.plot(*path.T, color=INK, linewidth=1.0, linestyle=":", zorder=5)
        axes.plot(
            *np.where(stroke.sliding[:, None], np.nan, path).T, color=INK, linewidth=1.8, zorder=5
        )
        radius = max(MM * stroke.rod_radius, 1.0)
        axes.add_patch(Circle(tuple(path[0]), radius, facecolor="white", edgecolor=INK, zorder=6))
        axes.add_patch(Circle(tuple(path[-1]), radius, facecolor=INK, edgecolor=INK, zorder=6))
        tips = MM * stroke.force_point + mm_per_newton * stroke.force
        for point, tip in zip(MM * stroke.force_point, tips, strict=True):
            style.arrow(axes, point, tip, FORCE, 1.4, 7)
        axes.set_aspect("equal")
        # Show the window from `low` to `high` (mm), widened to the panel's shape so that no panel
        # shrinks.
        panel = axes.get_window_extent()
        span = high - low
        scale = max(span[0] / panel.width, span[1] / panel.height)
        margin = (scale * np.array([panel.width, panel.height]) - span) / 2
        axes.set_xlim(low[0] - margin[0], high[0] + margin[0])
        axes.set_ylim(low[1] - margin[1], high[1] + margin[1])
        axes.set(xlabel="x (mm)", ylabel="y (mm)")
        axes.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))


def cycle_key(scene: CycleScene) -> str:
    """What the marks of the drawing mean, in two lines."""
    return (
        "dashed: before, solid: after  ·  path of the rod: solid sticks, dotted slides\n"
        f"arrows: force on the object, longest {scene.strongest_force:.2g} N  ·  circle: ring"
    )
