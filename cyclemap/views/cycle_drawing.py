"""The push and the drag of one cycle, drawn to scale in the plane."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon
from matplotlib.ticker import MaxNLocator

from cyclemap.arrays import Array
from cyclemap.collection.cycle_scene import CycleScene, StrokeScene
from cyclemap.views.style import FORCE, INK, PREDICTED, PREDICTED_FILL, QUIET

MM = 1000.0
RING_RADIUS_MM = 7.0
# The longest arrow as a share of the window.
LONGEST_ARROW = 0.13


def draw_cycle(push_axes: Axes, drag_axes: Axes, scene: CycleScene) -> None:
    """The push in one panel, the drag in the other, on the same scale and window."""
    corners = MM * np.stack([scene.push.reach, scene.drag.reach])
    low, high = corners[:, 0].min(axis=0) - 8.0, corners[:, 1].max(axis=0) + 8.0
    mm_per_newton = LONGEST_ARROW * float((high - low).max()) / scene.strongest_force
    for axes, stroke in ((push_axes, scene.push), (drag_axes, scene.drag)):
        _draw_stroke(axes, stroke)
        _draw_forces(axes, stroke, mm_per_newton)
        axes.set_aspect("equal")
        _fill_panel(axes, low, high)
        axes.set(xlabel="x (mm)", ylabel="y (mm)")
        axes.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))


def cycle_key(scene: CycleScene) -> str:
    """What the marks of the drawing mean, in two lines."""
    return (
        "dashed: before, solid: after  ·  path of the rod: solid sticks, dotted slides\n"
        f"arrows: force on the object, longest {scene.strongest_force:.2g} N  ·  circle: ring"
    )


def _draw_stroke(axes: Axes, stroke: StrokeScene) -> None:
    axes.add_patch(Polygon(MM * stroke.before, facecolor="#f4f4f4", edgecolor=QUIET, linestyle="--", zorder=1))
    axes.add_patch(
        Polygon(MM * stroke.after, facecolor=PREDICTED_FILL, edgecolor=PREDICTED, linewidth=1.6, alpha=0.75, zorder=2)
    )
    axes.plot(*(MM * stroke.centre).T, color=QUIET, linewidth=0.9, zorder=3)
    axes.plot(*(MM * stroke.centre[-1]), "+", color=PREDICTED, markersize=7, zorder=4)
    axes.plot(*(MM * stroke.centre[0]), "+", color=QUIET, markersize=7, zorder=3)
    _draw_ring(axes, stroke.ring_before, QUIET, "--")
    _draw_ring(axes, stroke.ring_after, PREDICTED, "-")
    _draw_rod(axes, stroke)


def _fill_panel(axes: Axes, low: Array, high: Array) -> None:
    """Show the window from `low` to `high` (mm), widened to the panel's shape so that no panel shrinks."""
    panel = axes.get_window_extent()
    span = high - low
    scale = max(span[0] / panel.width, span[1] / panel.height)
    margin = (scale * np.array([panel.width, panel.height]) - span) / 2
    axes.set_xlim(low[0] - margin[0], high[0] + margin[0])
    axes.set_ylim(low[1] - margin[1], high[1] + margin[1])


def _draw_ring(axes: Axes, place: Array, color: str, linestyle: str) -> None:
    axes.add_patch(
        Circle(tuple(MM * place), RING_RADIUS_MM, fill=False, edgecolor=color, linestyle=linestyle, zorder=4)
    )


def _draw_rod(axes: Axes, stroke: StrokeScene) -> None:
    """The rod's path: thick where it sticks, thin and dotted where it slides; the rod at both ends."""
    path = MM * stroke.rod
    axes.plot(*path.T, color=INK, linewidth=1.0, linestyle=":", zorder=5)
    axes.plot(*np.where(stroke.sliding[:, None], np.nan, path).T, color=INK, linewidth=1.8, zorder=5)
    radius = max(MM * stroke.rod_radius, 1.0)
    axes.add_patch(Circle(tuple(path[0]), radius, facecolor="white", edgecolor=INK, zorder=6))
    axes.add_patch(Circle(tuple(path[-1]), radius, facecolor=INK, edgecolor=INK, zorder=6))


def _draw_forces(axes: Axes, stroke: StrokeScene, mm_per_newton: float) -> None:
    """Arrows from the contact in the direction of the force on the object, all on one scale."""
    tips = MM * stroke.force_point + mm_per_newton * stroke.force
    for point, tip in zip(MM * stroke.force_point, tips, strict=True):
        axes.annotate(
            "",
            xy=tuple(tip),
            xytext=tuple(point),
            arrowprops={"arrowstyle": "-|>", "color": FORCE, "linewidth": 1.4, "shrinkA": 0, "shrinkB": 0},
            zorder=7,
        )
