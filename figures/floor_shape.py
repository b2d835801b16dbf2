"""Figure: what the anisotropy of friction explains of the measured plywood map, and what the
floor's shape explains.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.image import AxesImage
from matplotlib.patches import Polygon as Patch

from cyclemap.arrays import Array
from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs, TurnBins, turn_bins
from cyclemap.mechanics import (
    EllipseFriction,
    Pose,
    PressedFootprint,
    SurfaceShape,
    resting_pressure,
)
from cyclemap.views.style import (
    FORCE,
    INK,
    MEASURED,
    MEASURED_EDGE,
    PREDICTED,
    QUIET,
    Look,
    degree_axis,
    legend_above,
    new_figure,
    picture_style,
)

from .catalogue import NO_DATA, MeasuredFolder
from .measured_sets import measured_theta0

SURFACE = "plywood"
# The same board as identified from single pushes and drag-backs; no cycle was among them.
FROM_PUSHES = "plywood-floor"
# The plywood board as single pushes see it: a stiff trough along the robot's x axis, q = 20 y^2, in
# mean pressures.
TROUGH = SurfaceShape(dome=10.0, bow=10.0, axis=math.pi / 2)
# Measured pushes that are taken: the board still changes before them.
FIRST_CYCLE = 500
# Orientations at which the plate is drawn, rad.
RESTING = (0.0, math.pi / 6, math.pi / 3)
_ACCURACY = 1e-6
_BINS = 36
_PIXELS = 160


@dataclass(frozen=True, eq=False)
class FloorTurn:
    """Turns of a cycle on one floor.

    name : what the floor is. turn : (n,) rad, at the orientations of the figure. miss : rad, root
        mean square of the measured turns less these, nan where nothing was measured.
    """

    name: str
    turn: Array
    miss: float

    def harmonic(self, order: int) -> float:
        """Amplitude (rad) of a harmonic of the turn over θ0."""
        return float(abs(np.fft.rfft(self.turn)[order]) * 2.0 / self.turn.size)


@dataclass(frozen=True, eq=False)
class FloorShapes:
    """Turns over θ0 (n,), rad, of floors, measured ones where there are some, and where the plate
    rests.

    resting : for each of RESTING the pressure (k, k), mean pressures, over the square of half width
        `reach` (m) about the plate's centre, world axes; nan outside the plate.
    """

    theta: Array
    floors: tuple[FloorTurn, ...]
    measured: TurnBins | None
    resting: Array
    reach: float
    outline: Array


def compute(measured: MeasuredFolder, angles: int = 72) -> FloorShapes:
    """Run cycles from `angles` orientations on each floor, and look for measured ones."""
    theta = 2.0 * np.pi * np.arange(angles) / angles
    plywood = CollectionLoop.mit(SURFACE, accuracy=_ACCURACY)
    law = EllipseFriction.isotropic(
        math.sqrt(plywood.material.friction.mu_a * plywood.material.friction.mu_b)
    )
    even = replace(plywood, material=replace(plywood.material, friction=law))
    footprint = PressedFootprint(even.slider.outline, floor=TROUGH)
    loops = {
        "friction alike all around, flat floor": even,
        "ellipse of friction (Table I), flat floor": plywood,
        "friction alike all around, floor a trough": replace(even, footprint=footprint),
        "shapes identified from pushes and drag-backs": CollectionLoop.mit(
            FROM_PUSHES, accuracy=_ACCURACY
        ),
    }
    pairs = measured_theta0(measured, SURFACE)
    bins = None
    if pairs is not None and pairs.cycle is not None:
        kept = pairs.cycle >= FIRST_CYCLE
        bins = turn_bins(Theta0Pairs(pairs.theta[kept], pairs.theta_next[kept]), _BINS)
    floors = []
    for name, loop in loops.items():
        turn = loop.next_theta(theta) - theta
        miss = math.nan
        if bins is not None:
            predicted = np.interp(bins.centre, theta, turn, period=2.0 * np.pi)
            miss = float(np.sqrt(np.mean((bins.median - predicted) ** 2)))
        floors.append(FloorTurn(name, turn, miss))
    outline = even.slider.outline_points(200)
    reach = 1.05 * float(np.hypot(*outline.T).max())
    resting = np.array([_resting(footprint, angle, reach) for angle in RESTING])
    return FloorShapes(theta, tuple(floors), bins, resting, reach, outline)


def _resting(footprint: PressedFootprint, theta: float, reach: float) -> Array:
    """Pressures over a square about the plate's centre in the world's axes;
    nan outside the plate."""
    places = reach * (2.0 * (np.arange(_PIXELS) + 0.5) / _PIXELS - 1.0)
    x, y = np.meshgrid(places, places)
    c, s = math.cos(theta), math.sin(theta)
    own = np.stack([c * x + s * y, c * y - s * x], axis=-1)
    pressure = resting_pressure(footprint, theta, own)
    return np.where(
        footprint.outline.contains(own.reshape(-1, 2)).reshape(x.shape), pressure, np.nan
    )


def draw(result: FloorShapes) -> Figure:
    """Turns over θ0, their harmonics, and the plate at three orientations."""
    with picture_style():
        figure = new_figure(10.5, 6.4)
        upper = GridSpec(
            1,
            2,
            figure,
            width_ratios=(2.2, 1.0),
            left=0.07,
            right=0.98,
            bottom=0.53,
            top=0.9,
            wspace=0.2,
        )
        widths = (1.0,) * len(RESTING) + (0.05,)
        lower = GridSpec(
            1,
            len(widths),
            figure,
            width_ratios=widths,
            left=0.07,
            right=0.93,
            bottom=0.09,
            top=0.39,
            wspace=0.3,
        )
        _draw_turns(figure.add_subplot(upper[0]), result)
        _draw_harmonics(figure.add_subplot(upper[1]), result)
        for place, angle in enumerate(RESTING):
            axes = figure.add_subplot(lower[place])
            image = _draw_resting(axes, result, place, angle)
        bar = figure.colorbar(image, cax=figure.add_subplot(lower[-1]))
        bar.set_label("pressure (mean pressures)")
    return figure


_LOOKS: tuple[Look, ...] = (
    {"color": QUIET, "linestyle": ":", "linewidth": 1.6},
    {"color": INK, "linestyle": "--", "linewidth": 1.5},
    {"color": PREDICTED, "linestyle": "-", "linewidth": 2.2},
    {"color": FORCE, "linestyle": "-.", "linewidth": 1.8},
)


def _draw_turns(axes: Axes, result: FloorShapes) -> None:
    around = np.append(result.theta, 2.0 * np.pi)
    for floor, line in zip(result.floors, _LOOKS, strict=True):
        axes.plot(
            np.degrees(around),
            np.degrees(np.append(floor.turn, floor.turn[0])),
            label=floor.name,
            **line,
        )
    if result.measured is not None:
        look: Look = {
            "color": MEASURED,
            "markeredgecolor": MEASURED_EDGE,
            "markersize": 4.5,
            "linestyle": "none",
        }
        bins = result.measured
        axes.plot(np.degrees(bins.centre), np.degrees(bins.median), "o", label="measured", **look)
    degree_axis(axes)
    axes.set_ylabel("turn of a cycle (°)")
    legend_above(axes)


def _draw_harmonics(axes: Axes, result: FloorShapes) -> None:
    orders = range(1, 5)
    width = 0.24
    for place, (floor, look) in enumerate(zip(result.floors[1:], _LOOKS[1:], strict=True)):
        heights = [math.degrees(floor.harmonic(order)) for order in orders]
        axes.bar(
            np.add(orders, (place - 1.0) * width),
            heights,
            width,
            color=look["color"],
            edgecolor=INK,
            linewidth=0.6,
        )
    axes.set_xticks(orders)
    axes.set_xlabel("harmonic of θ0")
    axes.set_ylabel("amplitude of the turn (°)")
    axes.set_title("Ellipse, trough, from pushes")


def _draw_resting(axes: Axes, result: FloorShapes, place: int, angle: float) -> AxesImage:
    millimetres = 1e3 * result.reach
    extent = (-millimetres, millimetres, -millimetres, millimetres)
    top = float(np.nanmax(result.resting))
    image = axes.imshow(
        result.resting[place],
        origin="lower",
        extent=extent,
        cmap="Blues",
        vmin=0.0,
        vmax=top,
        zorder=1,
    )
    pose = Pose(theta=angle)
    corners = np.array([pose.to_world(x, y) for x, y in result.outline])
    axes.add_patch(Patch(1e3 * corners, fill=False, edgecolor=INK, linewidth=1.2, zorder=3))
    axes.grid(False)
    axes.set_aspect("equal")
    axes.set_title(f"rests at θ = {math.degrees(angle):.0f}°")
    axes.set_xlabel("robot's x (mm)")
    if place == 0:
        axes.set_ylabel("robot's y (mm)")
    return image


def caption(result: FloorShapes) -> str:
    """What is drawn, and how much of the measured turns each floor explains."""
    flat, ellipse, trough, pushes = result.floors
    mean = [math.degrees(float(np.mean(floor.turn))) for floor in result.floors]
    low, high = np.degrees([trough.turn.min(), trough.turn.max()])
    sentences = [
        "Turn of a whole cycle over θ0. On a flat floor with friction alike in all directions "
        f"every cycle turns by the same {mean[0]:.1f}°. The friction ellipse of Table I makes it "
        f"depend on θ0, by a first harmonic (its offset, {math.degrees(ellipse.harmonic(1)):.1f}°) "
        f"and a second ({math.degrees(ellipse.harmonic(2)):.1f}°). So does the floor's shape with "
        "friction alike in all directions and nothing fitted to any cycle: on a trough along the "
        "robot's x axis (q = 20 y² mean pressures at 50 mm, as single pushes of other plates found "
        f"it) turns go from {low:.1f}° to {high:.1f}°, a second harmonic of "
        f"{math.degrees(trough.harmonic(2)):.1f}°, and the same half a turn further: a floor's "
        "shape alone makes no first harmonic. The shapes of floor and plate that are identified "
        f"from single pushes and drag-backs ({FROM_PUSHES}), where the floor's varies with the "
        f"place, make one of {math.degrees(pushes.harmonic(1)):.1f}°. Below: where the square "
        "rests on the trough.",
    ]
    if result.measured is None:
        sentences.append(f"{NO_DATA.capitalize()} of plywood.")
    else:
        sentences.append(
            f"Measured: medians over 10° of pushes {FIRST_CYCLE} to 2000. They lie "
            f"{math.degrees(flat.miss):.1f}° (root mean square) from the rotation, "
            f"{math.degrees(ellipse.miss):.1f}° from Table I's map, "
            f"{math.degrees(trough.miss):.1f}° from the trough's and "
            f"{math.degrees(pushes.miss):.1f}° from that of the shapes found in pushes."
        )
    return " ".join(sentences)
