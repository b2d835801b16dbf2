"""Figure: the cycle map as plywood wears: its bottleneck opens, and a turn takes fewer and fewer
cycles.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure

from cyclemap.arrays import TWO_PI, Array
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import drifting_map
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.evidence import MeasuredCycleMap, measured_cycle_map, read_theta0_pairs
from cyclemap.evidence.laws.measured_cycle_map import TurnPace
from cyclemap.maps import WrappedNormal, transfer_operator
from cyclemap.views.panels.layout import entitle, page
from cyclemap.views.panels.orientation import CIRCLE, draw_pace, draw_turns
from cyclemap.views.panels.style import LINE, THIRD, ZERO, count_axis, picture_style, plain_ticks
from cyclemap.views.sentences import LONGEST_STAY, angle

from .catalogue import NO_DATA, THETA0_FILE, Exhibit, MeasuredFolder

MATERIAL = "plywood-measured"
AGES = (250, 1000, 1750)
# Cycles: pushes that far from an age say where the measured map of that age is known.
NEAR = 240
_EVEN = TWO_PI * np.arange(4096) / 4096


@dataclass(frozen=True, eq=False)
class WearDrift:
    """The map over the cycles, computed and measured.

    cycles : (n,).
    least, measured_least : (n,) rad, the least turn of a cycle, where the bottleneck is.
    turns : the turn (rad) at `CIRCLE` at AGES, computed; measured_turns : as fitted, nan where the
        robot hardly was; None without data.
    ages, mean_turn : (k,) of the map frozen at some cycles, with noise, rad a cycle.
    error : rad, bound on that of the maps between those computed.
    pace : cycles of each measured turn, beside what the fitted map foretells; None without data.
    """

    cycles: Array
    least: Array
    turns: tuple[Array, ...]
    ages: Array
    mean_turn: Array
    error: float
    pace: TurnPace | None = None
    measured_least: Array | None = None
    measured_turns: tuple[Array, ...] | None = None

    @property
    def opened(self) -> float:
        """The cycle from which on no direction repeats; nan where one always does or never did."""
        crossing = np.flatnonzero((self.least[:-1] < 0.0) & (self.least[1:] >= 0.0))
        if crossing.size == 0:
            return math.nan
        at = slice(crossing[-1], crossing[-1] + 2)
        return float(np.interp(0.0, self.least[at], self.cycles[at]))

    @property
    def cycles_a_turn(self) -> Array:
        """Cycles in which the frozen map climbs a turn, at `ages`; nan where it takes more than any
        collection has.
        """
        climbs = self.mean_turn > TWO_PI / LONGEST_STAY
        return np.asarray(np.where(climbs, TWO_PI / np.where(climbs, self.mean_turn, 1.0), np.nan))

    @property
    def expected_turns(self) -> float:
        """Turns over the run, as if each cycle's map had been there for ever."""
        return float(np.trapezoid(self.mean_turn, self.ages)) / TWO_PI


def compute(
    measured: MeasuredFolder, points: int = 17, runs: int = 50, harmonics: int | None = None
) -> WearDrift:
    """Follow the map as the loop wears, foretell its staircase, and fit the measured map with its
    wear.

    points : ages at which the pace is foretold.
    runs : paths of the fitted map a measured turn.
    harmonics : of the fitted map, None to choose them.
    """
    loop = CollectionLoop.mit(material=MATERIAL)
    wear = loop.material.wear
    assert wear is not None
    drifting = drifting_map(loop, int(wear.cycles) + 1)
    ages = np.linspace(0.0, wear.cycles, points)
    # Under noise on the frozen surface; the trapezoidal rule is exact for waves.
    means = []
    for frozen in map(drifting.at, ages.tolist()):
        density = transfer_operator(frozen, WrappedNormal(DEFAULT_SIGMA)).density(_EVEN)
        means.append(float(np.mean(density * frozen.turn(_EVEN))) * TWO_PI)
    mean_turn = np.array(means)
    cycles = np.linspace(0.0, wear.cycles, 41)
    turns = tuple(drifting.at(float(age)).turn(CIRCLE) for age in AGES)
    error = drifting.max_error
    least = np.array([drifting.at(float(age)).turn(CIRCLE).min() for age in cycles])
    computed, file = (
        WearDrift(cycles, least, turns, ages, mean_turn, error),
        measured.find(THETA0_FILE),
    )
    if file is None:
        return computed
    fitted = measured_cycle_map(read_theta0_pairs(file), harmonics=harmonics, runs=runs)
    fitted_least = np.array([fitted.fitted.map_at(float(n)).turn(CIRCLE).min() for n in cycles])
    seen = tuple(_where_seen(fitted, age) for age in AGES)
    pace = None if fitted.forecast is None else fitted.forecast.pace
    return replace(computed, pace=pace, measured_least=fitted_least, measured_turns=seen)


def _where_seen(fitted: MeasuredCycleMap, age: int) -> Array:
    """The fitted turn at `CIRCLE`, nan where no push within NEAR cycles of the age began within 8°
    of there.
    """
    pairs = fitted.pairs
    assert pairs.cycle is not None
    near = np.sort(np.mod(pairs.theta[np.abs(pairs.cycle - age) <= NEAR], TWO_PI))
    around = np.concatenate([near[-1:] - TWO_PI, near, near[:1] + TWO_PI])
    after = np.clip(np.searchsorted(around, CIRCLE), 1, around.size - 1)
    apart = np.minimum(np.abs(around[after] - CIRCLE), np.abs(CIRCLE - around[after - 1]))
    turn = fitted.fitted.map_at(float(age)).turn(CIRCLE)
    return np.asarray(np.where(apart <= math.radians(8.0), turn, np.nan))


@picture_style()
def draw(result: WearDrift) -> Figure:
    """The turn at three ages, computed and measured; the least turn and the cycles of a turn over
    the cycles.
    """
    seen = result.measured_turns
    layout = "aa;cd" if seen is None else "ab;cd"
    figure, (computed, *measured, least, pace) = page(layout, size=(10.5, 6.8))
    draw_turns(computed, CIRCLE, _by_age(result.turns))
    entitle(computed, "Computed: turn of a cycle")
    if seen is not None:
        draw_turns(measured[0], CIRCLE, _by_age(seen))
        measured[0].sharey(computed)
        entitle(measured[0], "Measured: turn of a cycle, fitted")
    least.axhline(0.0, **ZERO)
    least.plot(result.cycles, np.degrees(result.least), label="computed", **LINE)
    if result.measured_least is not None:
        fitted = np.degrees(result.measured_least)
        least.plot(result.cycles, fitted, label="measured, fitted", **THIRD)
    count_axis(least, "cycle", int(result.cycles[-1]))
    least.set_ylabel("least turn of a cycle (°)")
    entitle(least, "The bottleneck opens")
    pace.plot(result.ages, result.cycles_a_turn, marker="o", label="computed", **LINE)
    if result.pace is not None:
        draw_pace(pace, result.pace)
    pace.set(xlabel="cycle", ylabel="cycles a turn", xlim=(0, result.cycles[-1]), yscale="log")
    pace.set_ylim(15, 1000)
    plain_ticks(pace.yaxis, (20, 50, 100, 200, 500))
    entitle(pace, "Cycles a turn")
    return figure


def _by_age(turns: tuple[Array, ...]) -> dict[str, Array]:
    return {f"cycle {age}": turn for age, turn in zip(AGES, turns, strict=True)}


def caption(result: WearDrift) -> str:
    """What is seen, with its numbers."""
    last, least = result.cycles_a_turn[-1], np.degrees(result.least[[0, -1]])
    words = (
        f"The cycle map of {MATERIAL}, whose friction was inferred from the measured staircase, as "
        f"the surface wears. The least turn of a cycle grows from {least[0]:.2f}° on the fresh "
        f"surface to {least[1]:.2f}° after {result.cycles[-1]:.0f} cycles: up to about cycle "
        f"{result.opened:.0f} a stable direction holds the robot and only noise "
        f"({angle(DEFAULT_SIGMA)}) frees it, then the bottleneck opens, and at the end "
        f"a turn takes {last:.0f} cycles; {result.expected_turns:.1f} turns are expected in all."
    )
    pace = result.pace
    if pace is None:
        return f"{words} Of the robot's own turns {NO_DATA}."
    return (
        f"{words} The robot's own turns took {pace.measured[0]:.0f} cycles early on and "
        f"{pace.measured[-1]:.0f} late (the measured curves are drawn where it has been within "
        f"{NEAR} cycles); a map fitted to its path, free to wear, holds {100 * pace.inside:.0f} % "
        "of them within its 95 % bands."
    )


EXHIBITS = {
    "wear-drift": Exhibit(compute, caption, draw),
}
