"""The frames, angles and signs of one cycle in one drawing: before the push, and after it."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, Ellipse

import cyclemap as cm
from cyclemap.arrays import placed
from cyclemap.views.panels.layout import new_figure
from cyclemap.views.panels.scene import LATER, MM, draw_object, draw_rod, draw_way
from cyclemap.views.panels.style import FORCE, INK, MEASURED_EDGE, PREDICTED, QUIET

THETA0 = math.radians(30)
WINDOWS = ((-80.0, 130.0, -108.0, 86.0), (-66.0, 144.0, -108.0, 86.0))


def draw() -> Figure:
    """Return the drawing: one cycle of the MIT protocol on plywood from θ0 = 30°."""
    loop = cm.CollectionLoop.mit(material="plywood")
    cycle = loop.cycle(THETA0)
    figure = new_figure(10.4, 5.3)
    left, right = figure.subplots(1, 2)
    figure.subplots_adjust(left=0.01, right=0.99, bottom=0.02, top=0.92, wspace=0.02)
    draw_before(left, cycle)
    draw_after(right, cycle)
    titles = ("Before the push", "After the push, and the way back")
    for axes, window, title in zip((left, right), WINDOWS, titles, strict=True):
        axes.set(xlim=window[:2], ylim=window[2:], aspect="equal", title=title)
        axes.axis("off")
    return figure


def draw_before(axes: Axes, cycle: cm.Cycle) -> None:
    """Draw the world and the object's frame, θ0, the sides, the contact, the rod and the ring."""
    course, slider = cycle.push.trajectory, cycle.loop.slider
    pose = course.pose[0]
    world_frame(axes)
    draw_object(axes, placed(pose, slider.outline_points()))
    object_frame(axes, pose)
    number_sides(axes, cycle.loop, pose)
    place = MM * placed(pose, np.array(slider.hitch))
    ring(axes, place, "-")
    label(axes, "ring, at the target\n(the world's origin)", place, (-78, -66))
    draw_rod(axes, course.pusher[0], cycle.loop.pusher.radius, facecolor="white")
    contact = MM * placed(pose, np.array([-0.018, 0.045]))
    label(axes, "contact: side 0,\nfraction 0.7", contact, (-76, 74))
    way = MM * (placed(pose, np.array([-0.018, 0.0])) - placed(pose, np.array([-0.018, 0.045])))
    start = MM * course.pusher[0]
    arrow(axes, start, start + 0.55 * way, FORCE)
    label(
        axes,
        "push direction:\nagainst the\nside's normal\n(angle 0)",
        start + 0.3 * way,
        (-78, -14),
    )
    turn_arc(axes, MM * pose[:2], 26.0, 0.0, THETA0, r"$\theta_0$")
    surface_axes(axes)


def draw_after(axes: Axes, cycle: cm.Cycle) -> None:
    """Draw the object at both ends of the push, Δx, Δy and Δθ, and the ring's way back."""
    course, slider = cycle.push.trajectory, cycle.loop.slider
    first, last = course.pose[[0, -1]]
    before, after = (placed(pose, slider.outline_points()) for pose in (first, last))
    draw_object(axes, before, **LATER)
    draw_object(axes, after)
    home, away = (MM * placed(pose, np.array(slider.hitch)) for pose in (first, last))
    ring(axes, home, "--")
    ring(axes, away, "-")
    draw_way(axes, course.pusher, color=INK, linewidth=1.2, linestyle=":")
    draw_rod(axes, course.pusher[-1], cycle.loop.pusher.radius)
    displacement(axes, first, cycle.push_displacement)
    turn_arc(axes, MM * last[:2], 30.0, float(first[2]), float(last[2]), r"$\Delta\theta$")
    axes.plot(*(MM * last[:2]), "o", color=PREDICTED, markersize=4)
    arrow(axes, away, home, MEASURED_EDGE)
    middle = 0.45 * away + 0.55 * home
    label(axes, "drag: the ring goes straight\nback to the target", middle, (-62, -84))
    label(axes, "before", MM * before[0], (66, 70))


def world_frame(axes: Axes) -> None:
    """Draw the world's axes, in a corner: the ring stands on their origin."""
    origin = np.array([86.0, -62.0])
    for way, name in (((26.0, 0.0), "x"), ((0.0, 26.0), "y")):
        arrow(axes, origin, origin + way, INK)
        axes.text(*(origin + 1.22 * np.array(way)), name, ha="center", va="center")
    axes.text(
        origin[0] + 12, origin[1] - 10, "world's directions", ha="center", color=QUIET, fontsize=8
    )


def object_frame(axes: Axes, pose: np.ndarray) -> None:
    """Draw the object's axes from its centre."""
    for way, name in ((np.array([0.034, 0.0]), r"$x_o$"), (np.array([0.0, 0.034]), r"$y_o$")):
        arrow(axes, MM * pose[:2], MM * placed(pose, way), PREDICTED)
        axes.text(*(MM * placed(pose, 1.2 * way)), name, ha="center", va="center", color=PREDICTED)
    axes.plot(
        [MM * pose[0], MM * pose[0] + 36],
        [MM * pose[1]] * 2,
        color=QUIET,
        linewidth=0.9,
        linestyle="--",
    )


def number_sides(axes: Axes, loop: cm.CollectionLoop, pose: np.ndarray) -> None:
    """Write the number of each side along it, outside."""
    corners = np.asarray(loop.slider.outline.vertices, dtype=float)
    for side, (start, end) in enumerate(zip(corners, np.roll(corners, -1, axis=0), strict=True)):
        share = 0.65 if side else 0.4  # away from the contact and the lines to labels
        place = MM * placed(pose, ((1 - share) * start + share * end) * 1.13)
        turned = math.degrees(pose[2]) + (0 if side % 2 == 0 else -90)
        axes.text(
            *place,
            f"side {side}",
            ha="center",
            va="center",
            fontsize=8,
            color=QUIET,
            rotation=turned,
        )


def surface_axes(axes: Axes) -> None:
    """Draw the surface's own axes m and n, turned by φ, with the limit ellipse off their centre."""
    origin, phi = np.array([88.0, 34.0]), math.radians(25)
    m, n = np.array([math.cos(phi), math.sin(phi)]), np.array([-math.sin(phi), math.cos(phi)])
    axes.add_patch(
        Ellipse(
            tuple(origin + 3.5 * m + 2 * n),
            50,
            36,
            angle=math.degrees(phi),
            fill=False,
            edgecolor=QUIET,
        )
    )
    for way, name in ((m, "m"), (n, "n")):
        arrow(axes, origin, origin + 30 * way, QUIET)
        axes.text(*(origin + 36 * way), name, ha="center", va="center", color=QUIET)
    axes.plot(
        [origin[0], origin[0] + 30], [origin[1]] * 2, color=QUIET, linewidth=0.9, linestyle="--"
    )
    turn_arc(axes, origin, 16.0, 0.0, phi, r"$\phi$", QUIET)
    axes.text(
        origin[0],
        origin[1] + 42,
        "surface: m, n, limit ellipse",
        ha="center",
        color=QUIET,
        fontsize=8,
    )


def displacement(axes: Axes, first: np.ndarray, moved: np.ndarray) -> None:
    """Draw Δx and Δy along the axes that the object had before the push."""
    corner = np.array([moved[0], 0.0])
    for start, end, name in (
        (np.zeros(2), corner, r"$\Delta x$"),
        (corner, np.asarray(moved), r"$\Delta y < 0$"),
    ):
        a, b = MM * placed(first, start), MM * placed(first, end)
        arrow(axes, a, b, INK)
        away = 7.5 * np.array([a[1] - b[1], b[0] - a[0]]) / math.hypot(*(b - a))
        axes.text(
            *(0.5 * (a + b) + away * (1.0 if name == r"$\Delta x$" else 2.1)),
            name,
            ha="center",
            va="center",
        )


def turn_arc(
    axes: Axes,
    place: np.ndarray,
    radius: float,
    low: float,
    high: float,
    name: str,
    color: str = INK,
) -> None:
    """Draw an arc from one angle to another with an arrow head at its end, and name it."""
    axes.add_patch(
        Arc(
            tuple(place),
            2 * radius,
            2 * radius,
            theta1=math.degrees(low),
            theta2=math.degrees(high),
            color=color,
        )
    )
    end = place + radius * np.array([math.cos(high), math.sin(high)])
    back = place + radius * np.array([math.cos(high - 0.06), math.sin(high - 0.06)])
    axes.annotate(
        "",
        xy=end,
        xytext=back,
        arrowprops={"arrowstyle": "-|>", "color": color, "shrinkA": 0, "shrinkB": 0},
    )
    middle = 0.5 * (low + high)
    axes.text(
        *(place + 1.25 * radius * np.array([math.cos(middle), math.sin(middle)])),
        name,
        ha="center",
        va="center",
        color=color,
    )


def ring(axes: Axes, place: np.ndarray, style: str) -> None:
    """Draw the ring."""
    axes.add_patch(
        Circle(
            tuple(place),
            7.0,
            facecolor="white",
            edgecolor=MEASURED_EDGE,
            linestyle=style,
            linewidth=1.6,
        )
    )


def arrow(axes: Axes, start: np.ndarray, end: np.ndarray, color: str) -> None:
    """Draw an arrow."""
    look = {"arrowstyle": "-|>", "color": color, "linewidth": 1.5, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", xy=tuple(end), xytext=tuple(start), arrowprops=look, zorder=6)


def label(axes: Axes, text: str, place: np.ndarray, where: tuple[float, float]) -> None:
    """Write a text beside the drawing, and a thin line to what it names."""
    look = {"arrowstyle": "-", "color": QUIET, "linewidth": 0.7, "shrinkA": 1, "shrinkB": 2}
    axes.annotate(
        text, xy=tuple(place), xytext=where, fontsize=8, va="center", arrowprops=look, zorder=7
    )
