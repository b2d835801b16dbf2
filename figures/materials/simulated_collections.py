"""Simulated repeated pushes on each material, sampled from maps of the cycle and of the push: not
2000 full cycles; and the panels of the figures of all four.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import positive_number, read_only, whole_number
from cyclemap.collection import CollectionLoop, worn_loop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.evidence import PushSet, Theta0Pairs, set_laws
from cyclemap.maps import (
    CircleMap,
    DriftingMap,
    Staircase,
    WrappedNormal,
    sample_staircase,
    transfer_operator,
)
from cyclemap.views.panels.layout import Panel, grid_of, picture
from cyclemap.views.panels.orientation import OUTCOMES
from cyclemap.views.panels.style import BARS, DOTS, QUIET, Look

from ..catalogue import MeasuredFolder
from .paper_pushes import PUBLISHED_CYCLES, PublishedStatistics, measured_run, published_statistics

# The material that stands for each of the paper's: for plywood the one inferred from the measured
# staircase, since it alone wears and climbs as the robot saw it; Table I's plywood locks in and
# stays.
STANDS_FOR = {"plywood": "plywood-measured", "abs": "abs", "delrin": "delrin", "pu": "pu"}
NOISE = WrappedNormal(DEFAULT_SIGMA)
# Radians: accuracy of the cycle maps, far below the noise of a cycle.
MAP_TOLERANCE = 1e-4
# Of the integration of pushes and drags, relative: a hundredth of that.
_ACCURACY = 1e-6
# Orientations at which derivatives are computed: they only scale noise.
_SLOPES = 36
_OUTPUTS = ("push_turn", "push_dx", "push_dy", "theta_next")
_OFFSET = ("m0", "n0")
# Of each of the paper's materials, those that a table simulates: plywood by Table I, and as the
# staircase tells it.
SIMULATED = {
    surface: tuple(dict.fromkeys((surface, material))) for surface, material in STANDS_FOR.items()
}
# Names and units of Δθ, Δx and Δy in the paper's convention, and the factors from radians, m and
# this package's signs.
QUANTITIES = [
    (name, unit.strip(), sign * factor)
    for (name, _, factor, unit), sign in zip(OUTCOMES.values(), (1.0, 1.0, -1.0), strict=True)
]
# The laws of Δθ, Δx and Δy over θ0 of a set; one and the same set is fitted once.
fitted_laws = lru_cache(maxsize=32)(set_laws)


@dataclass(frozen=True)
class Sampling:
    """How long and how finely a run is sampled.

    pushes : in the run, 2 or more.
    states : of a wearing surface, 2 or more, between which maps are blended; with 5 the blend is
        within 0.07 degrees of the map of a cycle between them.
    tolerance : rad, of the cycle maps.
    """

    pushes: int = PUBLISHED_CYCLES
    states: int = 5
    tolerance: float = MAP_TOLERANCE

    def __post_init__(self) -> None:
        whole_number("pushes", self.pushes, least=2)
        whole_number("states", self.states, least=2)
        positive_number("tolerance", self.tolerance)


PAPER = Sampling()


@dataclass(frozen=True, eq=False)
class SurfaceState:
    """The cycle and the push on a surface as it is at one cycle.

    cycle : its number.
    map : the cycle map, rad.
    motion : of θ0 (n,), rad: (n, 3), Δθ (rad), Δx and Δy (m, initial object frame) of the push, the
        periodic cubic spline through pushes computed where the map had to be sampled.
    slopes : of θ0: (n, 4, 2), derivatives of Δθ, Δx, Δy and the next θ0 by the centre (m0, n0) of
        the limit ellipse, linear between 36 orientations.
    """

    cycle: float
    map: CircleMap
    motion: Callable[[Array], Array]
    slopes: Callable[[Array], Array]


@lru_cache(maxsize=32)
def surface_states(
    material: str, count: int, tolerance: float = MAP_TOLERANCE
) -> tuple[SurfaceState, ...]:
    """Compute the state of a built-in material, or `count` of one that wears, evenly over the
    cycles of its wear.

    Time: about 2 s each. Raises what the mechanics raise where they have no answer.

    >>> (state,) = surface_states("isotropic", 1, tolerance=1e-3)
    >>> np.degrees(state.motion(np.array([0.0, 1.0]))[:, 0]).round(3)
    array([74.52, 74.52])
    """
    from scipy.interpolate import BSpline, CubicSpline, make_interp_spline

    loop, states = CollectionLoop.mit(material), []
    wear = loop.material.wear
    for cycle in [0.0] if wear is None else np.linspace(0.0, wear.cycles, count).tolist():
        worn = replace(worn_loop(loop, cycle), accuracy=_ACCURACY)
        cycle_map = worn.circle_map(tolerance)
        assert cycle_map.pieces is not None
        theta = cycle_map.pieces.knots[:-1]
        runs = worn.cycles(theta)
        motion = np.column_stack([runs.push_turn, runs.push_displacement])
        spline = CubicSpline(
            np.append(theta, theta[0] + TWO_PI), np.vstack([motion, motion[:1]]), bc_type="periodic"
        )
        places, slopes = TWO_PI * np.arange(_SLOPES + 1) / _SLOPES, []
        for start in places[:-1].tolist():
            tangent = worn.sensitivity(start, _OFFSET)
            slopes.append(
                [[tangent.by(parameter, output) for parameter in _OFFSET] for output in _OUTPUTS]
            )
        linear = make_interp_spline(places, [*slopes, slopes[0]], k=1)
        states.append(
            SurfaceState(
                cycle, cycle_map, spline, BSpline(linear.t, linear.c, 1, extrapolate="periodic")
            )
        )
    return tuple(states)


@dataclass(frozen=True, eq=False)
class SampledRun:
    """A run of noisy cycles on one material, each push with its motion.

    surface, material : the paper's name, and that of what stands for it.
    states : one, or several of a surface that wears.
    map : of the cycle.
    run : the orientations, rad, lifted.
    pushes : the same as recorded pushes.
    jitter : (n, 2), by how much the centre (m0, n0) of each push's limit ellipse was off, over the
        mean coefficient.
    """

    surface: str
    material: str
    states: tuple[SurfaceState, ...]
    map: CircleMap | DriftingMap
    run: Staircase
    pushes: PushSet
    jitter: Array

    @property
    def published(self) -> PublishedStatistics:
        """What the paper says of this material."""
        return published_statistics(self.surface)

    def density(self, theta: Array) -> tuple[Array, float]:
        """Stationary density (n,), per rad, of θ0 at angles (n,), and a bound on its error; the
        mean over the wear.

        As if each state had been there for ever: a run of finite length need not have forgotten
        where it began.
        """
        weight = np.ones(len(self.states))
        if weight.size > 1:
            weight[[0, -1]] = 0.5
        weight /= weight.sum()
        operators = [transfer_operator(state.map, NOISE) for state in self.states]
        density = weight @ np.array([operator.density(theta) for operator in operators])
        return np.asarray(density), float(weight @ [operator.error_bound for operator in operators])


@lru_cache(maxsize=32)
def sampled_run(material: str, sampling: Sampling = PAPER) -> SampledRun:
    """Return a run of pushes on a built-in material, from the direction that the paper names first,
    else 0.

    θ_{n+1} = f_n(θ_n) + ξ_n, ξ_n normal with the scatter of measured plywood cycles, 1.1 degrees.
    The cause is taken to be friction that is not the same everywhere: in each push the centre of
    the limit ellipse is off by a random vector, equally likely in any direction and of the size at
    which the next θ0 scatters by just that much. The same vector moves Δθ, Δx and Δy, by their
    exact derivatives: their scatter is predicted from that of θ0.

    Where the material wears, cycle map and push are blended between states evenly spread over the
    cycles of its wear.

    >>> run = sampled_run("pu", Sampling(pushes=50, states=2, tolerance=1e-3))
    >>> run.pushes.count, len(run.states)
    (50, 1)
    """
    surface = material.split("-")[0]
    start = (*published_statistics(surface).directions, 0.0)[0]
    states = surface_states(material, sampling.states, sampling.tolerance)
    places = [state.cycle for state in states]
    cycle_map = (
        states[0].map
        if len(states) == 1
        else DriftingMap.between([(stage.cycle, stage.map) for stage in states])
    )
    run = sample_staircase(cycle_map, NOISE, sampling.pushes, start)
    theta, ahead, cycle = run.theta[:-1], run.theta[1:], np.arange(sampling.pushes + 1.0)
    # How much of each state the surface of each cycle has, linear between neighbours.
    share = np.array([np.interp(cycle[:-1], places, unit) for unit in np.eye(len(states))])

    def blended(values: Callable[[SurfaceState], Array]) -> Array:
        of_states = np.array([values(state) for state in states])
        return np.asarray(np.einsum("kn,kn...->n...", share, of_states))

    kick = ahead - blended(lambda state: state.map(theta))
    motion = blended(lambda state: state.motion(theta))
    slopes = blended(lambda state: state.slopes(theta))
    # Along the slope of the next θ0 an offset is kick / |slope|; across it, where it turns nothing,
    # as large: as complex numbers a quarter turn is the factor i.
    free = NOISE.sigma * np.random.default_rng((run.seed, 1)).standard_normal(kick.size)
    turned = (kick + 1j * free) / (slopes[:, -1] @ [1.0, -1j])
    offset = np.column_stack([turned.real, turned.imag])
    dtheta, dx, dy = (motion + np.einsum("nij,nj->ni", slopes[:, :-1], offset)).T
    pairs = Theta0Pairs(theta, ahead, run.theta, {}, cycle[:-1], cycle)
    facts, place = {"surface": material, "object": "rect1"}, Path(f"simulated {material}")
    pushes = PushSet(f"{material}, simulated", place, facts, 1, theta, dtheta, dx, dy, pairs)
    law = CollectionLoop.mit(material).material.friction
    jitter = read_only(offset / math.sqrt(law.mu_a * law.mu_b))
    return SampledRun(surface, material, states, cycle_map, run, pushes, jitter)


@dataclass(frozen=True, eq=False)
class MaterialPushes:
    """One of the paper's materials.

    published : what the paper prints.
    runs : simulated, of each material that stands for it.
    sets : of these and, last, the recorded one where it was found, each with the words for where it
        comes from.
    """

    published: PublishedStatistics
    runs: list[SampledRun]
    sets: list[tuple[str, PushSet]]


def material_pushes(measured: MeasuredFolder, sampling: Sampling = PAPER) -> list[MaterialPushes]:
    """Simulate pushes on every material and look for recorded ones, in the paper's order."""
    result = []
    for surface, materials in SIMULATED.items():
        runs = [sampled_run(material, sampling) for material in materials]
        sets = [(f"simulated, {run.material}", run.pushes) for run in runs]
        if (recorded := measured_run(measured, surface)) is not None:
            sets.append(("recorded", recorded.pushes))
        result.append(MaterialPushes(published_statistics(surface), runs, sets))
    return result


PANEL_INCHES = (5.2, 3.7)
# What simulated pushes look like where the same is drawn of measured ones: grey.
_GREY: Look = {"label": "simulated", "color": QUIET, "markeredgecolor": QUIET}
SIMULATED_DOTS: Look = {**DOTS, **_GREY}
SIMULATED_BARS: Look = {
    **BARS,
    "label": "simulated",
    "facecolor": "#c4c4c4",
    "edgecolor": QUIET,
}


def draw_materials(panels: Sequence[Panel]) -> Figure:
    """A figure of a few panels, a material each, with room above each for a legend."""
    layout = grid_of(len(panels), 2 if len(panels) <= 4 else 3)
    width, height = PANEL_INCHES
    rows = layout.split(";")
    return picture(layout, panels, size=(width * len(rows[0]), height * len(rows)), keys=2)
