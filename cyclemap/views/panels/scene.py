"""The object with its push and its ring, and a cycle's push and drag, drawn to scale in the
plane.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon
from matplotlib.ticker import MaxNLocator

from cyclemap.arrays import Array, placed
from cyclemap.collection.loop import CollectionLoop, Cycle
from cyclemap.mechanics import Trajectory
from cyclemap.mechanics.contact_curve import first_contact
from cyclemap.views.panels.layout import entitle
from cyclemap.views.panels.style import (
    FORCE,
    INK,
    MEASURED_EDGE,
    PREDICTED,
    PREDICTED_FILL,
    QUIET,
    Look,
    arrow,
    cross,
    name_tag,
    show_window,
    square_window,
)

MM = 1000.0
# More sides than this are those of a curve, whose numbers nobody needs.
_MOST_NUMBERS = 24
RING_RADIUS_MM = 7.0
OUTLINE_POINTS = 400
# Where along the rod's way a force is shown.
FORCE_PLACES = (0.04, 0.36, 0.68)
# The longest arrow as a share of the window.
LONGEST_ARROW = 0.13
# An object as it lies, and where it is later or was before.
LYING: Look = {"facecolor": PREDICTED_FILL, "edgecolor": PREDICTED, "linewidth": 1.6, "zorder": 2}
LATER: Look = {"facecolor": "none", "edgecolor": QUIET, "linewidth": 1.1, "linestyle": "--"}


def draw_object(axes: Axes, outline: Array, **look: object) -> None:
    """An object by its outline (n, 2), m, in millimetres."""
    shown: Look = {**LYING, **look}
    axes.add_patch(Polygon(MM * outline, **shown))


def draw_ring(axes: Axes, place: Array, **look: object) -> None:
    """The ring at a place (2,), m; its size is free."""
    shown: Look = {"fill": False, "edgecolor": INK, "linewidth": 1.2, "zorder": 4, **look}
    axes.add_patch(Circle(tuple(MM * place), RING_RADIUS_MM, **shown))


def draw_rod(axes: Axes, place: Array, radius: float, **look: object) -> None:
    """The rod at a place (2,), m."""
    shown: Look = {"facecolor": INK, "edgecolor": INK, "zorder": 6, **look}
    axes.add_patch(Circle(tuple(MM * place), max(MM * radius, 1.0), **shown))


def draw_way(axes: Axes, places: Array, *mark: str, **look: Any) -> None:
    """A way, or marks of Matplotlib's, at places (n, 2), m, in millimetres."""
    axes.plot(*(MM * places).T, *mark, **look)


def draw_setup(axes: Axes, loop: CollectionLoop) -> None:
    """Draw the object in its own frame: its sides by number, the rod at its first touch, its way,
    the ring.
    """
    outline, reach = loop.slider.outline_points(200), loop.slider.outline.extent
    draw_object(axes, outline)
    for way, name in ((np.array([1.0, 0.0]), "x"), (np.array([0.0, 1.0]), "y")):
        tip = 0.3 * MM * reach * way
        arrow(axes, np.zeros(2), tip, QUIET)
        name_tag(axes, 1.25 * tip[0], 1.25 * tip[1], name, color=QUIET)
    centre = MM * np.array(loop.slider.centre_of_mass)
    cross(axes, centre, INK, label="centre of mass")
    number_sides(axes, MM * outline, 0.1)
    rod, way = first_contact(loop.slider, loop.push, loop.pusher.radius)
    end = rod + loop.push.distance * way
    draw_rod(axes, rod, loop.pusher.radius)
    axes.plot([], [], "o", color=INK, label=f"rod, radius {MM * loop.pusher.radius:.3g} mm")
    arrow(axes, MM * rod, MM * end, FORCE)
    length = f"{MM * loop.push.distance:.4g} mm"
    axes.plot([], [], color=FORCE, label=f"push, {length} at side {loop.push.side}")
    ring = np.array(loop.slider.hitch)
    place = f"ring ({MM * ring[0]:.4g}, {MM * ring[1]:.4g}) mm"
    draw_ring(axes, ring, edgecolor=MEASURED_EDGE, linewidth=1.8)
    axes.plot(
        [],
        [],
        "o",
        markeredgewidth=1.8,
        label=place,
        markerfacecolor="none",
        markeredgecolor=MEASURED_EDGE,
    )
    middle = np.array(loop.slider.outline.centroid)
    corners = [outline, rod, end, middle + 1.25 * reach, middle - 1.25 * reach]
    square_window(axes, MM * np.vstack(corners))
    axes.set(xlabel="x (mm), object's frame", ylabel="y (mm)")
    entitle(axes, "Set-up")


def number_sides(axes: Axes, outline: Array, out: float, **look: Any) -> None:
    """Write the number of each side of a closed outline (m, 2), `out` of half its size off it."""
    middle, reach = outline[:-1].mean(axis=0), 0.5 * float(np.ptp(outline, axis=0).max())
    if len(outline) - 1 > _MOST_NUMBERS:
        name_tag(axes, middle[0], middle[1] - 0.5 * reach, "one curve: side 0")
        return
    edge = np.diff(outline, axis=0)
    outward = np.stack([edge[:, 1], -edge[:, 0]], axis=-1) / np.hypot(*edge.T)[:, None]
    places = 0.5 * (outline[:-1] + outline[1:]) + out * reach * outward
    for side, (x, y) in enumerate(places.tolist()):
        name = f"side {side}" if side == 0 and out > 0.0 else str(side)
        axes.text(x, y, name, ha="center", va="center", **{"fontsize": 8, **look})


def mark_target(axes: Axes) -> None:
    """The target of the ring, the origin of the world."""
    axes.plot(0.0, 0.0, "x", color=INK, ms=9, mew=1.8, label="target of the ring", zorder=7)


def draw_cycle(push_axes: Axes, drag_axes: Axes, cycle: Cycle) -> None:
    """The push in one panel, the drag in the other, on the same scale and window."""
    both = push_axes, drag_axes
    courses = cycle.trajectory.push, cycle.trajectory.drag
    for axes, course in zip(both, courses, strict=True):
        _draw_stroke(axes, course, cycle.loop)
    corners = np.vstack([axes.dataLim.get_points() for axes in both])
    low, high = corners.min(axis=0) - 8.0, corners.max(axis=0) + 8.0
    mm_per_newton = LONGEST_ARROW * float((high - low).max()) / strongest_force(cycle)
    for axes, course in zip(both, courses, strict=True):
        for point, force in zip(*shown_forces(course), strict=True):
            arrow(axes, MM * point, MM * point + mm_per_newton * force, FORCE, 1.4, 7)
        _show(axes, low, high)


def shown_forces(course: Trajectory) -> tuple[Array, Array]:
    """Some places of contact (m, 2), m, and the forces on the object there (m, 2), N."""
    places = np.searchsorted(course.path, course.path[-1] * np.array(FORCE_PLACES))
    shown = np.unique(places.clip(0, course.path.size - 1))
    return course.contact_point[shown], course.contact_force[shown]


def strongest_force(cycle: Cycle) -> float:
    """The largest of the forces shown, N."""
    course = cycle.trajectory
    forces = np.vstack([shown_forces(course.push)[1], shown_forces(course.drag)[1]])
    return float(np.hypot(*forces.T).max())


def _draw_stroke(axes: Axes, course: Trajectory, loop: CollectionLoop) -> None:
    """The object before and after, its centre's way, and the rod's: thick where it sticks, thin and
    dotted where it slides.
    """
    outline, hitch = loop.slider.outline_points(OUTLINE_POINTS), np.array(loop.slider.hitch)
    before, after = course.pose[0], course.pose[-1]
    draw_object(axes, placed(before, outline), **{**LATER, "facecolor": "#f4f4f4", "zorder": 1})
    draw_object(axes, placed(after, outline), alpha=0.75)
    draw_way(axes, course.pose[:, :2], color=QUIET, linewidth=0.9, zorder=3)
    cross(axes, MM * before[:2])
    cross(axes, MM * after[:2], PREDICTED)
    draw_ring(axes, placed(before, hitch), edgecolor=QUIET, linestyle="--")
    draw_ring(axes, placed(after, hitch), edgecolor=PREDICTED)
    draw_way(axes, course.pusher, color=INK, linewidth=1.0, linestyle=":", zorder=5)
    sliding = np.char.startswith(course.mode, "slide")
    sticking = np.where(sliding[:, None], np.nan, course.pusher)
    draw_way(axes, sticking, color=INK, linewidth=1.8, zorder=5)
    draw_rod(axes, course.pusher[0], loop.pusher.radius, facecolor="white")
    draw_rod(axes, course.pusher[-1], loop.pusher.radius)


def _show(axes: Axes, low: Array, high: Array) -> None:
    """Show the window from `low` to `high` (mm), widened to the panel's shape so that no panel
    shrinks.
    """
    panel = axes.get_window_extent()
    size = np.array([panel.width, panel.height])
    margin = 0.5 * (float(((high - low) / size).max()) * size - (high - low))
    low, high = low - margin, high + margin
    show_window(axes, low, high)
    axes.set(aspect="equal", xlabel="x (mm)", ylabel="y (mm)")
    axes.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))


def cycle_key(cycle: Cycle) -> str:
    """What the marks of the drawing mean."""
    return (
        "dashed: before, solid: after  ·  path of the rod: solid sticks, dotted slides  ·  "
        f"arrows: force on the object, longest {strongest_force(cycle):.2g} N  ·  circle: ring"
    )
