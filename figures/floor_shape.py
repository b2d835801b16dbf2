"""Figure: what the anisotropy of friction explains of the measured plywood map, and what the
floor's shape explains.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from cyclemap.arrays import Array
from cyclemap.collection.cycle_scene import placed
from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs, TurnBins, turn_bins
from cyclemap.mechanics import (
    EllipseFriction,
    PressedFootprint,
    SurfaceShape,
    resting_pressure,
)
from cyclemap.views import style
from cyclemap.views.map_panels import draw_medians, draw_turns
from cyclemap.views.object_page import MM, draw_object
from cyclemap.views.sentences import angle

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

    name : what the floor is.
    turn : (n,) rad, at the orientations of the figure.
    miss : rad, root mean square of the measured turns less these, nan where nothing was measured.
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


@style.picture_style()
def draw(result: FloorShapes) -> Figure:
    """Turns over θ0, their harmonics, and the plate at three orientations."""
    figure = style.new_figure(10.5, 7.2)
    turns, harmonics = style.panels(figure, "ab", (0.46, 0.985), keys=2, width_ratios=(2.2, 1.0))
    around = np.append(result.theta, 2.0 * np.pi)
    looks = [style.FOURTH, style.SECOND, style.LINE, style.THIRD]
    curves = {floor.name: np.append(floor.turn, floor.turn[0]) for floor in result.floors}
    draw_turns(turns, around, curves, looks)
    if result.measured is not None:
        draw_medians(turns, result.measured, "measured")
    style.legend_above(turns)
    _draw_harmonics(harmonics, result)
    places = style.panels(figure, "abc", (0.0, 0.5))
    for axes, pressure, theta in zip(places, result.resting, RESTING, strict=True):
        image = _draw_resting(axes, result, pressure, theta)
    figure.colorbar(image, ax=places, label="pressure (mean pressures)")
    return figure


def _draw_harmonics(axes: Axes, result: FloorShapes) -> None:
    orders, width = np.arange(1, 5), 0.24
    colours = (style.INK, style.PREDICTED, style.FORCE)
    for place, (floor, colour) in enumerate(zip(result.floors[1:], colours, strict=True)):
        heights = [math.degrees(floor.harmonic(order)) for order in orders.tolist()]
        axes.bar(orders + (place - 1.0) * width, heights, width, color=colour)
    axes.set_xticks(orders)
    axes.set(xlabel="harmonic of θ0", ylabel="amplitude of the turn (°)")
    style.entitle(axes, "Ellipse, trough, from pushes")


def _draw_resting(axes: Axes, result: FloorShapes, pressure: Array, theta: float) -> AxesImage:
    reach, top = MM * result.reach, float(np.nanmax(result.resting))
    image = axes.imshow(
        pressure,
        cmap="Blues",
        vmin=0.0,
        vmax=top,
        origin="lower",
        extent=(-reach, reach, -reach, reach),
        zorder=1,
    )
    corners = placed(np.array([0.0, 0.0, theta]), result.outline)
    draw_object(axes, corners, facecolor="none", edgecolor=style.INK)
    axes.grid(visible=False)
    axes.set(aspect="equal", xlabel="robot's x (mm)", ylabel="robot's y (mm)")
    axes.set_title(f"rests at θ = {angle(theta, 0)}")
    return image


def caption(result: FloorShapes) -> str:
    """What is drawn, and how much of the measured turns each floor explains."""
    flat, ellipse, trough, pushes = result.floors
    mean = [math.degrees(float(np.mean(floor.turn))) for floor in result.floors]
    low, high = np.degrees([trough.turn.min(), trough.turn.max()])
    sentences = [
        "Turn of a whole cycle over θ0. On a flat floor with friction alike in all directions "
        f"every cycle turns by the same {mean[0]:.1f}°. The friction ellipse of Table I makes it "
        f"depend on θ0, by a first harmonic (its offset, {angle(ellipse.harmonic(1))}) "
        f"and a second ({angle(ellipse.harmonic(2))}). So does the floor's shape with "
        "friction alike in all directions and nothing fitted to any cycle: on a trough along the "
        "robot's x axis (q = 20 y² mean pressures at 50 mm, as single pushes of other plates found "
        f"it) turns go from {low:.1f}° to {high:.1f}°, a second harmonic of "
        f"{angle(trough.harmonic(2))}, and the same half a turn further: a floor's "
        "shape alone makes no first harmonic. The shapes of floor and plate that are identified "
        f"from single pushes and drag-backs ({FROM_PUSHES}), where the floor's varies with the "
        f"place, make one of {angle(pushes.harmonic(1))}. Below: where the square "
        "rests on the trough.",
    ]
    if result.measured is None:
        sentences.append(f"{NO_DATA.capitalize()} of plywood.")
    else:
        sentences.append(
            f"Measured: medians over 10° of pushes {FIRST_CYCLE} to 2000. They lie "
            f"{angle(flat.miss)} (root mean square) from the rotation, "
            f"{angle(ellipse.miss)} from Table I's map, "
            f"{angle(trough.miss)} from the trough's and "
            f"{angle(pushes.miss)} from that of the shapes found in pushes."
        )
    return " ".join(sentences)
