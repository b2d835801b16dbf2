"""The set-up of the repeated push, to scale, and two cycles of push and drag that follow each
other.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.patches import Circle, Polygon

from cyclemap.arrays import Array
from cyclemap.collection.cycle_scene import CycleScene, StrokeScene, placed
from cyclemap.collection.loop import CollectionLoop, Cycle
from cyclemap.views.style import (
    FORCE,
    INK,
    PREDICTED,
    PREDICTED_FILL,
    QUIET,
    Look,
    arrow,
    new_figure,
    picture_style,
)

from .catalogue import MeasuredFolder

MM = 1000.0
# Where the first cycle starts: there the cycle turns the object enough to be seen.
START = math.radians(270.0)
# The shade of the first cycle and of the second, by lightness.
_CYCLE_COLOURS = (QUIET, PREDICTED)
# Drawn size of the ring, mm: as in the drawing of a cycle elsewhere.
_RING = 7.0
_ARROW, _WORDS = 38.0, 46.0


@dataclass(frozen=True, eq=False)
class SetupAndCycles:
    """The loop, two cycles of it, the second from where the first ended, and their scenes."""

    loop: CollectionLoop
    cycles: tuple[Cycle, Cycle]
    scenes: tuple[CycleScene, CycleScene]

    @property
    def contact(self) -> Array:
        """(2,) m, where the rod first touches, in the object's frame."""
        side = np.array(self.loop.slider.outline.points(4))
        first, second = side[self.loop.push.side], side[self.loop.push.side + 1]
        return np.asarray(first + self.loop.push.fraction * (second - first))


def compute(measured: MeasuredFolder) -> SetupAndCycles:
    """Run two cycles of the MIT loop on plywood from `START`; nothing here is measured."""
    loop = CollectionLoop.mit("plywood")
    first = loop.cycle(START)
    second = loop.cycle(first.theta_next)
    return SetupAndCycles(loop, (first, second), (first.scene(), second.scene()))


def draw(result: SetupAndCycles) -> Figure:
    """Draw the set-up in the object's frame on the left,
    the two cycles in the world on the right."""
    with picture_style():
        figure = new_figure(10.6, 5.9)
        grid = GridSpec(
            1,
            2,
            figure,
            left=0.06,
            right=0.985,
            bottom=0.1,
            top=0.9,
            wspace=0.18,
            width_ratios=(1, 1.33),
        )
        _draw_setup(figure.add_subplot(grid[0]), result)
        _draw_cycles(figure.add_subplot(grid[1]), result)
    return figure


def _draw_setup(axes: Axes, result: SetupAndCycles) -> None:
    loop = result.loop
    outline = MM * loop.slider.outline.points(4)
    axes.add_patch(Polygon(outline, facecolor=PREDICTED_FILL, edgecolor=PREDICTED, linewidth=1.6))
    axes.plot(0.0, 0.0, "+", color=INK, markersize=9)
    _name(axes, (3.0, -5.0), "centre", ha="left")
    for number, middle in enumerate(0.5 * (outline[:-1] + outline[1:])):
        place = middle * (38.0 / 45.0) if number else np.add(middle, (34.0, -7.0))
        _name(
            axes,
            (float(place[0]), float(place[1])),
            f"side {number}",
            rotation=90.0 if number % 2 else 0.0,
        )
    hitch = MM * np.array(loop.slider.hitch)
    axes.add_patch(Circle(tuple(hitch), _RING, fill=False, edgecolor=INK, linewidth=1.4))
    axes.plot([0.0, hitch[0]], [0.0, hitch[1]], color=QUIET, linewidth=1.0, linestyle="--")
    _name(axes, (-1.0, 20.0), f"ring, {np.hypot(*hitch):.0f} mm\nfrom centre", ha="left")
    loop, contact = result.loop, MM * result.contact
    radius, length = MM * loop.pusher.radius, MM * loop.push.distance
    rod = np.add(contact, (0.0, radius))
    axes.add_patch(Circle(tuple(rod), radius, facecolor=INK, zorder=4))
    arrow(axes, rod, (rod[0], rod[1] - length), FORCE, 2.0)
    _name(axes, (rod[0] - 3.0, -88.0), f"push,\n{length:.0f} mm", ha="right", color=FORCE)
    _name(axes, (rod[0] - 8.0, rod[1] + 2.0), f"rod, radius {radius:.2f} mm", ha="right")
    _dimension(axes, (contact[0], 62.0), (0.0, 62.0), f"{abs(contact[0]):.0f} mm", above=True)
    _dimension(axes, (-45.0, -57.0), (45.0, -57.0), f"{np.ptp(outline[:, 0]):.0f} mm")
    axes.set(
        xlim=(-78, 68),
        ylim=(-118, 78),
        aspect="equal",
        xlabel="x (mm), object's frame",
        ylabel="y (mm)",
    )
    axes.set_title("Set-up, to scale")


def _dimension(
    axes: Axes,
    start: tuple[float, float],
    end: tuple[float, float],
    words: str,
    above: bool = False,
) -> None:
    """A level line with arrows at both ends and its length."""
    axes.annotate(
        "",
        xy=end,
        xytext=start,
        arrowprops={"arrowstyle": "<->", "color": INK, "shrinkA": 0, "shrinkB": 0},
    )
    place = 0.5 * (start[0] + end[0]), start[1] + (3.0 if above else -3.0)
    _name(axes, place, words, va="bottom" if above else "top")


def _name(axes: Axes, place: tuple[float, float], words: str, **look: Any) -> None:
    given: Look = {"fontsize": 8, "ha": "center", "va": "center", "zorder": 6, **look}
    axes.text(*place, words, **given)


def _draw_cycles(axes: Axes, result: SetupAndCycles) -> None:
    corners = []
    for number, (cycle, scene) in enumerate(zip(result.cycles, result.scenes, strict=True)):
        colour = _CYCLE_COLOURS[number]
        for outline, width in ((scene.push.before, 1.6), (scene.push.after, 0.7)):
            axes.add_patch(Polygon(MM * outline, fill=False, edgecolor=colour, linewidth=width))
        _path(axes, scene.push, colour, "-", f"push {_INDEX[number]}")
        _path(axes, scene.drag, colour, (0, (4, 2)), f"drag back {_INDEX[number]}")
        tip = MM * scene.push.rod[0]
        # The touched side's inward normal is -y in the object's frame.
        way = placed(
            np.array([0.0, 0.0, cycle.theta + result.loop.push.angle]), np.array([0.0, -1.0])
        )
        corners += [*(MM * scene.push.reach), tip - (_ARROW + _WORDS) * way]
        tail = tip - _ARROW * way
        arrow(axes, tail, tip, FORCE, 2.2, 8)
        words = (
            f"push {_INDEX[number]}, from\nθ₀{_RAISED[number]} = {math.degrees(cycle.theta):.0f}°"
        )
        (x, y), lean = (
            (tail - 4.0 * way).tolist(),
            "right" if way[0] > 0.3 else "left" if way[0] < -0.3 else "center",
        )
        axes.text(x, y, words, color=FORCE, fontsize=9, ha=lean, va="center", zorder=8)
    axes.plot(
        0.0,
        0.0,
        "x",
        color=INK,
        markersize=8,
        markeredgewidth=1.8,
        label="target of the ring",
        zorder=7,
    )
    # A square window about all that is drawn, with room for the words behind the arrows.
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    middle, half = 0.5 * (low + high), (high - low).max() / 2 + 12.0
    axes.set(
        xlim=(middle[0] - half, middle[0] + half),
        ylim=(middle[1] - half, middle[1] + half),
        aspect="equal",
    )
    axes.set(xlabel="x (mm), world frame", ylabel="y (mm)")
    axes.set_title("Path of the centre in cycles k and k+1")
    axes.legend(loc="lower right")


_INDEX, _RAISED = ("k", "k+1"), ("ᵏ", "ᵏ⁺¹")


def _path(axes: Axes, stroke: StrokeScene, colour: str, style: Any, label: str) -> None:
    path = MM * stroke.centre
    axes.plot(*path.T, color=colour, linewidth=2.2, linestyle=style, label=label, zorder=5)
    middle = len(path) // 2
    look = {"arrowstyle": "-|>", "color": colour, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 13}
    axes.annotate(
        "", xy=tuple(path[middle + 1]), xytext=tuple(path[middle - 1]), arrowprops=look, zorder=6
    )


def caption(result: SetupAndCycles) -> str:
    """The lengths of the set-up, and how the orientation goes from one cycle to the next."""
    loop, (first, second) = result.loop, result.cycles
    told = [
        math.degrees(turn) for turn in (first.theta, first.push_turn, first.drag_turn, second.theta)
    ]
    return (
        f"Left: a square of {MM * np.ptp(loop.slider.outline.points(4)[:, 0]):.0f} mm is pushed "
        f"over {MM * loop.push.distance:.0f} mm at side {loop.push.side}, "
        f"{MM * abs(result.contact[0]):.0f} mm from its middle, and dragged back by a ring "
        f"{MM * math.hypot(*loop.slider.hitch):.0f} mm from its centre; the size of the ring is "
        "not published, that drawn is free. Right: path of the centre in two cycles that follow "
        f"each other, solid in the push, dashed in the drag, computed on {loop.material.name}. "
        "Arrows are the directions of the pushes, alike in the object's frame; beside them, the "
        f"orientation before the push. From θ0 = {told[0]:.0f}° the push turns the object by "
        f"{told[1]:.1f}°, the drag by {told[2]:.1f}°, so that the next push starts at "
        f"{told[3]:.1f}°: the ring is back at its target, the centre is not where it was."
    )
