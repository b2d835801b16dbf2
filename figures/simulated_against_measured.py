"""Simulated turns of push and of cycle over θ0 for plywood, set against what was measured."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure

from cyclemap.arrays import Array
from cyclemap.checks import read_only, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import worn_loop
from cyclemap.evidence.pushes.theta0_pairs import MeasuredOverlay, measured_overlay
from cyclemap.maps import CircleMap
from cyclemap.mechanics import grid_footprint
from cyclemap.views import style
from cyclemap.views.map_panels import (
    OUTCOMES,
    draw_curves,
    draw_measured,
    draw_measured_turns,
    draw_turns,
)
from cyclemap.views.sentences import angle

from .catalogue import NO_DATA, THETA0_FILE, MeasuredFolder
from .measured_sets import MeasuredRun, measured_run, measured_theta0
from .published_statistics import published_statistics

SURFACE = "plywood"
# As in the paper.
GRID = 8
NODES = 72
_ACCURACY = 1e-6
_CURVE = np.linspace(0.0, 2.0 * np.pi, 721)


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
    recorded: MeasuredRun | None
    cycles: tuple[MeasuredOverlay, ...]

    def push_statistics(self, number: int) -> tuple[float, float]:
        """Mean and standard deviation (rad) of the simulated Δθ at the measured θ0, without any at
        all θ0 alike.
        """
        simulated = self.simulated[number]
        turn = simulated.push.turn(self.cycles[0].pairs.theta if self.cycles else simulated.theta)
        return float(np.mean(turn)), float(np.std(turn))

    def recorded_error(self, number: int) -> float:
        """Root mean square (rad) of recorded less simulated Δθ; nan where no push is recorded."""
        if self.recorded is None:
            return float("nan")
        pushes, simulated = self.recorded.pushes, self.simulated[number]
        return float(np.sqrt(np.nanmean((pushes.dtheta - simulated.push.turn(pushes.theta)) ** 2)))


def compute(measured: MeasuredFolder, nodes: int = NODES) -> SimulatedAgainstMeasured:
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
    return SimulatedAgainstMeasured(simulated, measured_run(measured, SURFACE), cycles)


def simulated_turns(name: str, loop: CollectionLoop, nodes: int = NODES) -> SimulatedTurns:
    """Return pushes and cycles of `loop` from `nodes` equally spaced orientations."""
    theta = np.linspace(0.0, 2.0 * np.pi, whole_number("nodes", nodes, least=4), endpoint=False)
    runs = loop.cycles(theta)
    push, cycle = (
        CircleMap.from_samples(theta, end) for end in (theta + runs.push_turn, runs.theta_next)
    )
    return SimulatedTurns(name, read_only(theta), push, cycle)


@style.picture_style()
def draw(result: SimulatedAgainstMeasured) -> Figure:
    """Draw Δθ of the push on the left, the turn of the whole cycle on the right."""
    figure, (push, cycle) = style.page("ab", size=(12.2, 5.0), keys=2)
    if result.cycles:
        draw_measured_turns(cycle, result.cycles[0].pairs, result.cycles[0].bins)
    draw_curves(push, _CURVE, {turns.name: turns.push.turn(_CURVE) for turns in result.simulated})
    draw_turns(cycle, _CURVE, {turns.name: turns.cycle.turn(_CURVE) for turns in result.simulated})
    published = published_statistics(SURFACE)
    mean, spread = np.degrees([published.mean[0], published.std[0]])
    band: style.Look = {"color": "#f6e3bd", "label": "published, mean ± σ", "zorder": 0}
    push.axhspan(mean - spread, mean + spread, **band)
    push.axhline(mean, color=style.MEASURED_EDGE, linewidth=1.0, zorder=1)
    if result.recorded is not None:
        pushes = result.recorded.pushes
        draw_measured(push, pushes.theta, np.degrees(pushes.dtheta), "recorded pushes")
    style.degree_axis(push)
    push.set_ylabel(OUTCOMES["dtheta"][1])
    style.entitle(push, "Push")
    cycle.set_ylabel("turn of push and drag (°)")
    style.entitle(cycle, "Whole cycle")
    return figure


def caption(result: SimulatedAgainstMeasured) -> str:
    """What is measured here and what is not, and how far the simulations lie from it."""
    published = published_statistics(SURFACE)
    mean, spread = np.degrees([published.mean[0], published.std[0]])
    where = "at the measured θ0" if result.cycles else "over all θ0"
    pushes = []
    for number, simulated in enumerate(result.simulated):
        here = np.degrees(result.push_statistics(number))
        off = "" if result.recorded is None else f", {angle(result.recorded_error(number))} RMS off"
        pushes.append(f"{simulated.name} {here[0]:.1f}° ± {here[1]:.1f}°{off}")
    dots = f"{NO_DATA} of Δθ."
    if result.recorded is not None:
        dots = f"dots, {result.recorded.pushes.count} recorded pushes."
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
