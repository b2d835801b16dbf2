"""Animation: the loop of push and drag locks in: seen from above, as a cobweb, and as θ0 over the
cycles.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from io import BytesIO

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MultipleLocator
from PIL import Image

from cyclemap.arrays import TWO_PI, Array, along_way, placed
from cyclemap.collection.loop import CollectionLoop, Cycle
from cyclemap.collection.portrait_curves import Cobweb
from cyclemap.errors import ConvergenceError
from cyclemap.maps import Orbit, fixed_points
from cyclemap.views.panels.layout import page
from cyclemap.views.panels.orientation import draw_cobweb
from cyclemap.views.panels.scene import MM, draw_object, draw_ring, draw_rod, draw_way
from cyclemap.views.panels.style import (
    INK,
    MARKS,
    PREDICTED,
    SECOND,
    count_axis,
    cross,
    picture_style,
    show_window,
)
from cyclemap.views.sentences import angle

from . import Exhibit, Frame, MeasuredFolder

START = math.radians(215.0)
# Radians from the stable direction at which the robot counts as locked in.
LOCKED = math.radians(0.5)
MOST_CYCLES = 120
# Pictures of the push and of the drag of a cycle: slow at first, then faster, until one shows a
# whole cycle.
PACE = ((2, 13, 9), (5, 6, 4), (9, 3, 2))
SLOW, FAST = (13, 9), (1, 0)
SECONDS, LAST_SECONDS = 0.07, 2.0
INCHES, DPI = (7.2, 4.1), 100
MARGIN_MM = 12.0
TABLE_COLOUR = "#faf6ee"
# Colours of the one palette that all frames share: a palette of its own a frame would flicker and
# take space.
COLOURS = 64
# Frames from which the palette is taken.
_SAMPLED = 8


@dataclass(frozen=True, eq=False)
class Moment:
    """One picture's worth of motion.

    cycle : number of the cycle, from 0.
    pose : (3,) m, m, rad, of the object.
    pushing : else dragged.
    rod_path : (n, 2) m, of the rod since this stroke began, to where it is.
    seconds : how long it is shown.
    """

    cycle: int
    pose: Array
    pushing: bool
    rod_path: Array
    seconds: float


@dataclass(frozen=True, eq=False)
class LockingIn:
    """A run of the loop until it locks in.

    loop : what was run.
    theta : (n + 1,) rad, unwrapped: θ0 of every cycle.
    directions : the stable and the unstable one.
    curve : (m, 2) rad, θ0 and next θ0 over the run's range.
    moments : what the pictures show.
    """

    loop: CollectionLoop
    theta: Array
    directions: tuple[Orbit, Orbit]
    curve: Array
    moments: list[Moment]

    @property
    def stable(self) -> float:
        """The stable direction, rad, on the turn where the run ends."""
        place = float(self.directions[0].points[0])
        return place + TWO_PI * round(float(self.theta[-1] - place) / TWO_PI)

    @property
    def multiplier(self) -> float:
        """The multiplier of the stable direction."""
        return self.directions[0].multiplier

    @property
    def cycles(self) -> int:
        """How many cycles were run."""
        return int(self.theta.size - 1)


def compute(
    measured: MeasuredFolder,
    start: float = START,
    locked: float = LOCKED,
    pace: tuple[tuple[int, int, int], ...] = PACE,
    slow: tuple[int, int] = SLOW,
) -> LockingIn:
    """Run the MIT loop on plywood from `start` (rad) until it is within `locked` (rad) of its
    stable direction.

    pace : (up to this cycle, pictures of its push, of its drag), in order; slow : those of the last
        cycle.

    Raises ConvergenceError where MOST_CYCLES cycles do not lock in.
    """
    del measured
    loop = CollectionLoop.mit(material="plywood")
    circle_map = loop.circle_map(tolerance=1e-4)
    rest, edge = (
        next(orbit for orbit in fixed_points(circle_map) if orbit.stable == kind)
        for kind in (True, False)
    )
    run = [loop.cycle(start)]
    while abs(math.remainder(run[-1].theta - rest.points[0], TWO_PI)) > locked:
        if len(run) > MOST_CYCLES:
            raise ConvergenceError(
                f"{MOST_CYCLES} cycles from {math.degrees(start):.4g} deg do not lock in"
            )
        run.append(loop.cycle(run[-1].theta_next))
    theta = np.array([run[0].theta, *(cycle.theta_next for cycle in run)])
    behind = float(edge.points[0]) + TWO_PI * math.floor((theta[0] - edge.points[0]) / TWO_PI)
    reach = np.linspace(min(theta.min(), behind) - 0.1, theta.max() + 0.25, 241)
    curve = np.stack([reach, circle_map(reach)], axis=1)
    return LockingIn(loop, theta, (rest, edge), curve, moments(run, pace, slow))


def moments(
    run: list[Cycle], pace: tuple[tuple[int, int, int], ...], slow: tuple[int, int]
) -> list[Moment]:
    """Return the pictures of all cycles: of each stroke so many, at equal distances along it, the
    last at its end.
    """
    shown = []
    for index, cycle in enumerate(run):
        counts = next(((p, d) for until, p, d in pace if index < until), FAST)
        strokes = (cycle.trajectory.push, cycle.trajectory.drag)
        for motion, count in zip(strokes, slow if index == len(run) - 1 else counts, strict=True):
            way = motion.path / motion.path[-1]
            for share in np.linspace(0.0, 1.0, count + 1)[1:].tolist():
                pose, rod = (along_way(share, way, rows) for rows in (motion.pose, motion.pusher))
                path = np.vstack([motion.pusher[way < share], rod])
                shown.append(Moment(index, pose, motion is strokes[0], path, SECONDS))
    shown[-1] = replace(shown[-1], seconds=LAST_SECONDS)
    return shown


def caption(result: LockingIn) -> str:
    """What is seen, with its numbers."""
    near = math.degrees(result.theta[-1] - result.stable)
    return (
        "The loop of push and drag on plywood (Table I), to scale: the rod pushes the object, then "
        "drags it back by its ring to the same spot (first cycles slowly, later ones at a glance). "
        f"Started at {angle(result.theta[0], 0)}, each cycle begins where the last one "
        f"left θ0: on the cycle map it climbs the stairs of a cobweb, until after {result.cycles} "
        f"cycles it repeats the same push at {math.degrees(result.stable) % 360:.0f}°, "
        f"{abs(near):.1f}° from the stable direction. There every cycle leaves "
        f"{100 * result.multiplier:.0f} % of the distance."
    )


def frames(result: LockingIn) -> Iterator[Frame]:
    """Draw every moment of the run."""
    for moment in result.moments:
        figure = _drawn(result, moment)
        figure.set_dpi(DPI)
        figure.canvas.draw()
        pixels = np.asarray(figure.canvas.buffer_rgba())  # type: ignore[attr-defined]
        yield Frame(pixels[..., :3].copy(), moment.seconds)


@picture_style()
def _drawn(result: LockingIn, moment: Moment) -> Figure:
    """The table from above, the cobweb up to here, and θ0 over the cycles."""
    figure, (stairs, course) = page(
        ".a;.b", size=INCHES, keys=0, width_ratios=(1.3, 1.0), height_ratios=(1.4, 1.0)
    )
    table = figure.add_axes((0.015, 0.06, 0.54, 0.84))
    theta = result.theta[: moment.cycle + 1]
    _draw_table(table, result, moment)
    doing = "push" if moment.pushing else "drag back"
    start = f"from θ0 = {math.degrees(theta[-1]) % 360:.1f}°"
    table.set_title(f"Cycle {moment.cycle + 1}, {start}: {doing}")
    corners = np.repeat(theta, 2)
    walked, curve = np.stack([corners[:-1], corners[1:]], axis=1), result.curve
    cobweb = Cobweb(curve[0, 0], curve[-1, 0], ((curve[:, 0], curve[:, 1]),), (walked,))
    draw_cobweb(stairs, cobweb, result.directions)
    stairs.set_aspect("auto")
    stairs.set_title("The cycle map")
    course.axhline(math.degrees(result.stable), **SECOND)
    course.plot(np.degrees(theta), "o", **{**MARKS, "markersize": 3.5})
    count_axis(course, "cycle", result.cycles)
    low, high = np.degrees([result.theta.min(), result.theta.max()])
    course.set(ylim=(low - 12.0, high + 15.0), ylabel="θ0 (°)")
    for axis in (stairs.xaxis, stairs.yaxis, course.yaxis):
        axis.set_major_locator(MultipleLocator(45.0))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value % 360:.0f}"))
    return figure


def _draw_table(axes: Axes, result: LockingIn, moment: Moment) -> None:
    """The table from above; the world's origin is where the ring is set down."""
    slider, push = result.loop.slider, result.loop.push
    outline = slider.outline.points(4)
    poses = np.array([each.pose for each in result.moments])
    everything = MM * placed(poses.T[..., None], outline).reshape(-1, 2)
    low, high = everything.min(axis=0) - MARGIN_MM, everything.max(axis=0) + MARGIN_MM
    show_window(axes, low, high)
    axes.set(aspect="equal", anchor="W", xticks=[], yticks=[], facecolor=TABLE_COLOUR)
    axes.spines[:].set_visible(False)
    cross(axes, zorder=1)
    corners = placed(moment.pose, outline)
    draw_object(axes, corners)
    side = corners[push.side : push.side + 2]
    draw_way(axes, side, zorder=3, color=PREDICTED, linewidth=4.5, solid_capstyle="butt")
    ring = placed(moment.pose, np.array(slider.hitch))
    draw_ring(axes, ring, edgecolor=PREDICTED, linewidth=1.6)
    dash = "-" if moment.pushing else ":"
    draw_way(axes, moment.rod_path, dash, color=INK, linewidth=1.2, zorder=4)
    draw_rod(axes, moment.rod_path[-1], result.loop.pusher.radius)
    x, y = (low + 14.0).tolist()
    axes.plot([x, x + 50.0], [y, y], color=INK, linewidth=2.0)
    axes.text(x + 25.0, y + 4.0, "50 mm", ha="center", fontsize=7.5)


def animated_gif(frames: Iterable[Frame]) -> bytes:
    """Return the frames, all of one size, as a GIF that repeats for ever.

    Durations are rounded to 0.01 s, and are 0.02 s at least: a GIF counts hundredths of a second,
    and viewers do not show less than two of them.
    """
    given = list(frames)
    pixels = [frame.pixels for frame in given]
    sample = np.concatenate(pixels[:: max(1, len(pixels) // _SAMPLED)])
    # Of the methods the one that keeps white white.
    palette = Image.fromarray(sample).quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE)
    pictures = [
        Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in pixels
    ]
    buffer = BytesIO()
    pictures[0].save(
        buffer,
        format="GIF",
        save_all=True,
        append_images=pictures[1:],
        duration=[max(10 * round(100 * frame.seconds), 20) for frame in given],
        loop=0,
        optimize=False,
        disposal=1,
    )
    return buffer.getvalue()


EXHIBITS = {
    "locking-in": Exhibit(compute, caption, frames=frames),
}
