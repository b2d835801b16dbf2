"""What is measured of a planned push: two corners of the object, three times, from the room's
corner.
"""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

import cyclemap as cm
from cyclemap.evidence.tables.planned_table import mark_columns, marks_of
from cyclemap.mechanics import Pose, SidePush, Slider
from cyclemap.views.panels.layout import new_figure
from cyclemap.views.panels.style import FORCE, INK, PREDICTED, PREDICTED_FILL, QUIET, arrow

MM = 1000.0
START = Pose(0.13, 0.18, math.radians(30.0))
PUSH = SidePush(side=0, fraction=0.7, angle=0.0, distance=0.09)
SHOWN = ("before: as it is set", "after the push", "after the ring is pulled back")
WINDOW = (-12.0, 282.0, -22.0, 252.0)


def draw() -> Figure:
    """Return the drawing: a push of a plate on plywood, and what the table asks for."""
    loop = cm.CollectionLoop.mit(material="plywood", slider=Slider.mit("rect1"))
    pushed = loop.model.push(START, PUSH)
    ring = START.to_world(*loop.slider.hitch)
    back = loop.model.drag(pushed.end, (ring,)).end
    rod = MM * pushed.trajectory.pusher[[0, -1]]
    figure = new_figure(11.6, 4.6)
    panels = figure.subplots(1, 3)
    figure.subplots_adjust(left=0.01, right=0.99, bottom=0.02, top=0.9, wspace=0.03)
    states = (START, pushed.end, back)
    for index, axes in enumerate(panels):
        room(axes)
        for other in states[max(index - 1, 0) : index]:
            outline(axes, loop.slider, other, moved=True)
        outline(axes, loop.slider, states[index], moved=False)
        measured(axes, loop.slider, states[index], str(index))
        axes.set(xlim=WINDOW[:2], ylim=WINDOW[2:], aspect="equal", title=SHOWN[index])
        axes.axis("off")
    arrow(panels[1], rod[0], rod[1], FORCE)
    panels[1].text(*(rod[0] + (-6.0, 2.0)), "the rod's way", color=FORCE, fontsize=9, ha="right")
    hitch = MM * np.array(pushed.end.to_world(*loop.slider.hitch))
    arrow(panels[2], hitch, MM * np.array(ring), FORCE)
    panels[2].text(
        *(hitch + np.array((22.0, -34.0))), "the ring's way", color=FORCE, fontsize=9, ha="center"
    )
    return figure


def room(axes: Axes) -> None:
    """Draw the room's near left corner, from which all is measured."""
    axes.plot([0.0, 0.0, 275.0], [245.0, 0.0, 0.0], color=INK, linewidth=1.6)
    axes.text(4.0, -14.0, "near left corner of the room", color=INK, fontsize=9)


def outline(axes: Axes, slider: Slider, pose: Pose, *, moved: bool) -> None:
    """Draw the object with its ring; where it was, dashed."""
    corners = np.array([pose.to_world(*corner) for corner in slider.outline.vertices])
    ring = MM * np.array(pose.to_world(*slider.hitch))
    if moved:
        axes.add_patch(Polygon(MM * corners, fill=False, edgecolor=QUIET, linestyle="--"))
        return
    filled = {"facecolor": PREDICTED_FILL, "edgecolor": PREDICTED, "linewidth": 1.6}
    axes.add_patch(Polygon(MM * corners, **filled))
    axes.add_patch(Circle(tuple(ring), 4.0, fill=False, edgecolor=PREDICTED))


def measured(axes: Axes, slider: Slider, pose: Pose, state: str) -> None:
    """Draw the two corners with their distances from the room's sides, by the table's columns."""
    names = mark_columns(state)
    for index, mark in enumerate(marks_of(slider)):
        x, y = MM * np.array(pose.to_world(*mark))
        across, up = names[2 * index : 2 * index + 2]
        axes.plot([0.0, x], [y, y], color=QUIET, linewidth=0.9, linestyle=":")
        axes.plot([x, x], [0.0, y], color=QUIET, linewidth=0.9, linestyle=":")
        axes.plot([x], [y], "o", color=INK, markersize=5)
        axes.text(x + 5.0, y + 5.0, "ab"[index], color=INK, fontsize=12, weight="bold")
        axes.text(2.0, y + 3.0, across, color=INK, fontsize=9)
        axes.text(x + 3.0, 3.0, up, color=INK, fontsize=9, rotation=90.0, va="bottom")
