"""Turns over θ0 on plywood: simulated and measured (Fig. 13), and what the anisotropy of friction
and the floor's shape each explain of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from cyclemap.arrays import TWO_PI, Array, even_angles, turned
from cyclemap.checks import read_only, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import isotropic_twin, worn_loop
from cyclemap.evidence.laws.push_sets import PushSet
from cyclemap.evidence.laws.turn_bins import (
    MeasuredOverlay,
    TurnBins,
    measured_overlay,
    root_mean_square,
    turn_bins,
)
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs
from cyclemap.maps import CircleMap
from cyclemap.mechanics import (
    PressedFootprint,
    SurfaceShape,
    grid_footprint,
    resting_pressure,
)
from cyclemap.views.panels.layout import entitle, legend_above, page
from cyclemap.views.panels.orientation import (
    CIRCLE,
    OUTCOMES,
    draw_curves,
    draw_measured,
    draw_measured_turns,
    draw_medians,
    draw_turns,
)
from cyclemap.views.panels.scene import MM, draw_object
from cyclemap.views.panels.style import (
    DOTS,
    FORCE,
    FOURTH,
    INK,
    LINE,
    MEASURED_EDGE,
    PREDICTED,
    SECOND,
    THIRD,
    degree_axis,
    picture_style,
)
from cyclemap.views.sentences import angle

from . import NO_DATA, THETA0_FILE, Exhibit, MeasuredFolder
from .repeated_pushes import measured_theta0, published_statistics, recorded_set

SURFACE = "plywood"
# As in the paper.
GRID = 8
NODES = 72
_ACCURACY = 1e-6


@dataclass(frozen=True, eq=False)
class SimulatedTurns:
    """Simulated pushes and cycles from equally spaced orientations, and curves through them.

    name : what was simulated.
    theta : (n,) rad.
    push, cycle : of which the turns are those of a push, Δθ, and of a whole cycle; shape-preserving
        cubics.
    """

    name: str
    theta: Array
    push: CircleMap
    cycle: CircleMap


@dataclass(frozen=True, eq=False)
class SimulatedAgainstMeasured:
    """Table I on the paper's grid, then plywood-measured, fresh and worn; and what was measured,
    None where it is not.

    recorded : the repeated pushes with their Δθ.
    cycles : for each of `simulated` the measured turns of the whole cycle, push and drag, set
        against it; empty where no θ0 was found.
    """

    simulated: tuple[SimulatedTurns, ...]
    recorded: PushSet | None
    cycles: tuple[MeasuredOverlay, ...]

    def push_statistics(self, index: int) -> tuple[float, float]:
        """Mean and standard deviation (rad) of the simulated Δθ at the measured θ0, without any at
        all θ0 alike.
        """
        simulated = self.simulated[index]
        turn = simulated.push.turn(self.cycles[0].pairs.theta if self.cycles else simulated.theta)
        return float(np.mean(turn)), float(np.std(turn))

    def recorded_error(self, index: int) -> float:
        """Root mean square (rad) of recorded less simulated Δθ; nan where no push is recorded."""
        if self.recorded is None:
            return float("nan")
        off = self.recorded.dtheta - self.simulated[index].push.turn(self.recorded.theta)
        return float(np.sqrt(np.nanmean(off**2)))


def simulated_against_measured(
    measured: MeasuredFolder, nodes: int = NODES
) -> SimulatedAgainstMeasured:
    """Simulate cycles from `nodes` orientations on each of three floors, and look for measured
    pushes and θ0.
    """
    table = CollectionLoop.mit("plywood", accuracy=_ACCURACY)
    gridded = replace(table, footprint=grid_footprint(table.slider.outline, GRID))
    inferred = CollectionLoop.mit("plywood-measured", accuracy=_ACCURACY)
    assert inferred.material.wear is not None
    simulated = (
        simulated_turns("Table I, 8 x 8 points", gridded, nodes),
        simulated_turns("plywood-measured, fresh", worn_loop(inferred, 0.0), nodes),
        simulated_turns(
            "plywood-measured, worn", worn_loop(inferred, inferred.material.wear.cycles), nodes
        ),
    )
    pairs = measured_theta0(measured, SURFACE)
    cycles = (
        ()
        if pairs is None
        else tuple(measured_overlay(pairs, turns.cycle.turn) for turns in simulated)
    )
    return SimulatedAgainstMeasured(simulated, recorded_set(measured, SURFACE), cycles)


def simulated_turns(name: str, loop: CollectionLoop, nodes: int = NODES) -> SimulatedTurns:
    """Return pushes and cycles of `loop` from `nodes` equally spaced orientations."""
    theta = even_angles(whole_number("nodes", nodes, least=4))
    runs = loop.cycles(theta)
    push, cycle = (
        CircleMap.from_samples(theta, end) for end in (theta + runs.push_turn, runs.theta_next)
    )
    return SimulatedTurns(name, read_only(theta), push, cycle)


def _published_turn() -> tuple[float, float]:
    """Mean and standard deviation of the turn of a push that are published, degrees."""
    published = published_statistics(SURFACE)
    return math.degrees(published.mean[0]), math.degrees(published.std[0])


@picture_style()
def draw_turns_beside(result: SimulatedAgainstMeasured) -> Figure:
    """Draw Δθ of the push on the left, the turn of the whole cycle on the right."""
    figure, (push, cycle) = page("ab", size=(12.2, 5.0), keys=2)
    if result.cycles:
        draw_measured_turns(cycle, result.cycles[0].pairs, result.cycles[0].bins)
    draw_curves(push, CIRCLE, {turns.name: turns.push.turn(CIRCLE) for turns in result.simulated})
    draw_turns(cycle, CIRCLE, {turns.name: turns.cycle.turn(CIRCLE) for turns in result.simulated})
    mean, spread = _published_turn()
    push.axhspan(
        mean - spread, mean + spread, color="#f6e3bd", label="published, mean ± σ", zorder=0
    )
    push.axhline(mean, color=MEASURED_EDGE, linewidth=1.0, zorder=1)
    if result.recorded is not None:
        look = {**DOTS, "label": "recorded pushes"}
        draw_measured(push, result.recorded.theta, np.degrees(result.recorded.dtheta), look)
    degree_axis(push)
    push.set_ylabel(OUTCOMES["dtheta"][1])
    entitle(push, "Push")
    cycle.set_ylabel("turn of push and drag (°)")
    entitle(cycle, "Whole cycle")
    return figure


def turns_caption(result: SimulatedAgainstMeasured) -> str:
    """What is measured here and what is not, and how far the simulations lie from it."""
    mean, spread = _published_turn()
    where = "at the measured θ0" if result.cycles else "over all θ0"
    pushes = []
    for index, simulated in enumerate(result.simulated):
        here = np.degrees(result.push_statistics(index))
        off = "" if result.recorded is None else f", {angle(result.recorded_error(index))} RMS off"
        pushes.append(f"{simulated.name} {here[0]:.1f}° ± {here[1]:.1f}°{off}")
    dots = f"{NO_DATA} of Δθ."
    if result.recorded is not None:
        dots = f"dots, {result.recorded.count} recorded pushes."
    cycles = f"{NO_DATA} of θ0 ({THETA0_FILE})."
    if result.cycles:
        both = zip(result.simulated, result.cycles, strict=True)
        errors = [f"{turns.name} {angle(cycle.agreement.bin_rms)}" for turns, cycle in both]
        cycles = (
            f"dots, {result.cycles[0].pairs.theta.size} measured cycles, from the θ0 of successive "
            "pushes; squares, their medians in 5°. Root mean square of these less the simulated: "
            f"{', '.join(errors)}."
        )
    return (
        "Turns over the orientation before the push, on plywood. Simulated: Table I on the paper's "
        "8 x 8 points, and plywood-measured, which was inferred from the measured turns of the "
        f"cycle, fresh and after 2000 cycles. Left, the push: {dots} The band is the published "
        f"mean and standard deviation, {mean:.1f}° ± {spread:.1f}° (Table II); simulated {where}: "
        f"{'; '.join(pushes)}. Right, push and drag together: {cycles}"
    )


# The same board as identified from single pushes and drag-backs; no cycle was among them.
FROM_PUSHES = "plywood-floor"
# The plywood board as single pushes see it: a stiff trough along the robot's x axis, q = 20 y^2, in
# mean pressures.
TROUGH = SurfaceShape(dome=10.0, bow=10.0, axis=math.pi / 2)
# Measured pushes that are taken: the board still changes before them.
FIRST_CYCLE = 500
# Orientations at which the plate is drawn, rad.
RESTING = (0.0, math.pi / 6, math.pi / 3)
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


def floor_shapes(measured: MeasuredFolder, angles: int = 72) -> FloorShapes:
    """Run cycles from `angles` orientations on each floor, and look for measured ones."""
    theta = even_angles(angles)
    plywood = CollectionLoop.mit(SURFACE, accuracy=_ACCURACY)
    even = isotropic_twin(plywood)
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
    if pairs is not None and pairs.cycle is not None and pairs.cycle[-1] >= FIRST_CYCLE:
        kept = pairs.cycle >= FIRST_CYCLE
        bins = turn_bins(Theta0Pairs(pairs.theta[kept], pairs.theta_next[kept]), _BINS)
    floors = []
    for name, loop in loops.items():
        turn = loop.next_theta(theta) - theta
        miss = math.nan
        if bins is not None:
            predicted = np.interp(bins.centre, theta, turn, period=TWO_PI)
            miss = root_mean_square(bins.median - predicted)
        floors.append(FloorTurn(name, turn, miss))
    outline = even.slider.outline_points(200)
    reach = 1.05 * float(np.hypot(*outline.T).max())
    resting = np.array([_resting(footprint, angle, reach) for angle in RESTING])
    return FloorShapes(theta, tuple(floors), bins, resting, reach, outline)


def _resting(footprint: PressedFootprint, theta: float, reach: float) -> Array:
    """Pressures over a square about the plate's centre in the world's axes;
    nan outside the plate."""
    places = reach * (2.0 * (np.arange(_PIXELS) + 0.5) / _PIXELS - 1.0)
    world = np.stack(np.meshgrid(places, places), axis=-1)
    own = turned(world, -theta)
    inside = footprint.outline.contains(own.reshape(-1, 2)).reshape(own.shape[:-1])
    return np.where(inside, resting_pressure(footprint, theta, own), np.nan)


@picture_style()
def draw_floors(result: FloorShapes) -> Figure:
    """Turns over θ0, their harmonics, and the plate at three orientations."""
    figure, (turns, harmonics, *places) = page("aab;cde", size=(10.5, 7.2), keys=2)
    around = np.append(result.theta, TWO_PI)
    looks = [FOURTH, SECOND, LINE, THIRD]
    curves = {floor.name: np.append(floor.turn, floor.turn[0]) for floor in result.floors}
    draw_turns(turns, around, curves, looks)
    if result.measured is not None:
        draw_medians(turns, result.measured, "measured")
    legend_above(turns)
    _draw_harmonics(harmonics, result)
    for axes, pressure, theta in zip(places, result.resting, RESTING, strict=True):
        image = _draw_resting(axes, result, pressure, theta)
    figure.colorbar(image, ax=places, label="pressure (mean pressures)")
    return figure


def _draw_harmonics(axes: Axes, result: FloorShapes) -> None:
    orders, width = np.arange(1, 5), 0.24
    colours = (INK, PREDICTED, FORCE)
    for place, (floor, colour) in enumerate(zip(result.floors[1:], colours, strict=True)):
        heights = [math.degrees(floor.harmonic(order)) for order in orders.tolist()]
        axes.bar(orders + (place - 1.0) * width, heights, width, color=colour)
    axes.set_xticks(orders)
    axes.set(xlabel="harmonic of θ0", ylabel="amplitude of the turn (°)")
    entitle(axes, "Ellipse, trough, from pushes")


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
    draw_object(axes, turned(result.outline, theta), facecolor="none", edgecolor=INK)
    axes.grid(visible=False)
    axes.set(aspect="equal", xlabel="robot's x (mm)", ylabel="robot's y (mm)")
    axes.set_title(f"rests at θ = {angle(theta, 0)}")
    return image


def floor_caption(result: FloorShapes) -> str:
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


EXHIBITS = {
    "simulated-against-measured": Exhibit(
        simulated_against_measured, turns_caption, draw_turns_beside
    ),
    "floor-shape": Exhibit(floor_shapes, floor_caption, draw_floors),
}
