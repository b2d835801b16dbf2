"""Simulated repeated pushes on each material, sampled from maps of the cycle and of the push: not 2000 full cycles."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import positive_number, read_only, whole_number
from cyclemap.collection import CollectionLoop, worn_loop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.evidence import PushSet, SetLaws, Theta0Pairs, set_laws
from cyclemap.evidence.published_statistics import PUBLISHED_CYCLES, PublishedStatistics, published_statistics
from cyclemap.maps import (
    CircleMap,
    DriftingMap,
    Staircase,
    TransferOperator,
    WrappedNormal,
    sample_staircase,
    transfer_operator,
)

from .catalogue import MeasuredFolder
from .measured_sets import MeasuredRun, measured_run

# The material that stands for each of the paper's: for plywood the one inferred from the measured staircase, since it
# alone wears and climbs as the robot saw it; Table I's plywood locks in and stays.
STANDS_FOR = {"plywood": "plywood-measured", "abs": "abs", "delrin": "delrin", "pu": "pu"}
NOISE = WrappedNormal(DEFAULT_SIGMA)
# Radians: accuracy of the cycle maps, far below the noise of a cycle.
MAP_TOLERANCE = 1e-4
# Of the integration of pushes and drags, relative: a hundredth of that.
_ACCURACY = 1e-6
# Orientations at which derivatives are computed: they only scale noise.
_SLOPES = 36
# Orientations, golden-ratio steps round the circle, at which interpolated pushes are compared with the mechanics.
_CHECKED, _GOLDEN = 12, 0.6180339887498949
_OUTPUTS = ("push_turn", "push_dx", "push_dy", "theta_next")
_OFFSET = ("m0", "n0")
# Of each of the paper's materials, those that a table simulates: plywood by Table I, and as the staircase tells it.
SIMULATED = {surface: tuple(dict.fromkeys((surface, material))) for surface, material in STANDS_FOR.items()}
# Names and units of Δθ, Δx and Δy in the paper's convention, and the factors from radians, m and this package's signs.
QUANTITIES = (("Δθ", "°", 57.29577951308232), ("Δx", "mm", 1e3), ("Δy", "mm", -1e3))


@dataclass(frozen=True)
class Sampling:
    """How long and how finely a run is sampled.

    pushes : in the run, 2 or more. states : of a wearing surface, 2 or more, between which maps are blended; with 5 the
    blend is within 0.07 degrees of the map of a cycle between them. tolerance : rad, of the cycle maps.
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
class SampledRun:
    """A run of noisy cycles on one material, each push with its motion.

    surface, material : the paper's name, and that of what stands for it. states : one, or several of a surface that
    wears. map : of the cycle. run : the orientations, rad, lifted. pushes : the same as recorded pushes.
    jitter : (n,), by how much each push's friction was off, over the mean coefficient.
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

    @property
    def wears(self) -> bool:
        """Whether the surface changes during the run."""
        return len(self.states) > 1

    @property
    def motion_error(self) -> Array:
        """(3,), the largest difference of a state's pushes from the mechanics: Δθ (rad), Δx, Δy (m)."""
        return np.asarray(np.max([state.motion_error for state in self.states], axis=0))

    @cached_property
    def operators(self) -> tuple[TransferOperator, ...]:
        """The transfer operator of each state's map with the noise."""
        return tuple(transfer_operator(state.map, NOISE) for state in self.states)

    def density(self, theta: ArrayLike) -> Array:
        """Stationary density (...), per rad, of θ0 at angles (...); the mean over the cycles where the surface wears.

        As if each state had been there for ever: a run of finite length need not have forgotten where it began.
        """
        found = np.array([operator.density(np.asarray(theta, dtype=float)) for operator in self.operators])
        return np.asarray(np.tensordot(self._weights, found, axes=1))

    @property
    def density_error(self) -> float:
        """Bound on the error of ``density``, per rad."""
        return float(self._weights @ [operator.error_bound for operator in self.operators])

    @property
    def _weights(self) -> Array:
        weight = np.ones(len(self.states))
        if self.wears:
            weight[[0, -1]] = 0.5
        return np.asarray(weight / weight.sum())


@lru_cache(maxsize=32)
def sampled_run(material: str, sampling: Sampling = PAPER, seed: int = 0) -> SampledRun:
    """Return a run of pushes on a built-in material, from the direction that the paper names first, else 0.

    θ_{n+1} = f_n(θ_n) + ξ_n, ξ_n normal with the scatter of measured plywood cycles, 1.1 degrees. The cause is taken to
    be friction that is not the same everywhere: in each push the centre of the limit ellipse is off by a random vector,
    equally likely in any direction and of the size at which the next θ0 scatters by just that much. The same vector
    moves Δθ, Δx and Δy, by their exact derivatives: their scatter is predicted from that of θ0.

    Where the material wears, cycle map and push are blended between states evenly spread over the cycles of its wear.

    >>> run = sampled_run("pu", Sampling(pushes=50, states=2, tolerance=1e-3))
    >>> run.pushes.count, run.wears
    (50, False)
    """
    surface = material.split("-")[0]
    start = (*published_statistics(surface).directions, 0.0)[0]
    found = _states(material, sampling.states, sampling.tolerance)
    cycle_map = found[0].map if len(found) == 1 else DriftingMap.between([(one.cycle, one.map) for one in found])
    run = sample_staircase(cycle_map, NOISE, sampling.pushes, start, seed)
    recorded, jitter = _recorded(material, found, run)
    return SampledRun(surface, material, found, cycle_map, run, recorded, jitter)


@lru_cache(maxsize=32)
def fitted_laws(pushes: PushSet, harmonics: int | None = None) -> SetLaws:
    """The laws of Δθ, Δx and Δy over θ0 of a set; one and the same set is fitted once."""
    return set_laws(pushes, harmonics=harmonics)


@lru_cache(maxsize=32)
def _states(material: str, count: int, tolerance: float) -> tuple[SurfaceState, ...]:
    loop = CollectionLoop.mit(material)
    wear = loop.material.wear
    cycles = [0.0] if wear is None else np.linspace(0.0, wear.cycles, count).tolist()
    return tuple(surface_state(loop, cycle, tolerance) for cycle in cycles)


def _recorded(material: str, states: tuple[SurfaceState, ...], run: Staircase) -> tuple[PushSet, Array]:
    """The run as a set of recorded pushes, and the jitter (n,) of their friction."""
    path, cycle = run.theta, np.arange(run.cycles + 1.0)
    theta, ahead = path[:-1], path[1:]
    # How much of each state the surface of each cycle has, linear between neighbours.
    places = [state.cycle for state in states]
    share = np.array([np.interp(cycle[:-1], places, unit) for unit in np.eye(len(states))])
    kick = ahead - np.einsum("kn,kn->n", share, np.array([state.map(theta) for state in states]))
    motion = np.einsum("kn,knj->nj", share, np.array([state.push_motion(theta) for state in states]))
    slopes = np.einsum("kn,knij->nij", share, np.array([state.by_offset(theta) for state in states]))
    offset = _friction_errors(kick, slopes[:, -1], run.seed)
    dtheta, dx, dy = (motion + np.einsum("nij,nj->ni", slopes[:, :-1], offset)).T
    pairs = Theta0Pairs(theta, ahead, path, {}, cycle[:-1], cycle)
    facts = {"surface": material, "object": "rect1"}
    pushes = PushSet(f"{material}, simulated", Path(f"simulated {material}"), facts, 1, theta, dtheta, dx, dy, pairs)
    return pushes, np.hypot(*offset.T) / states[0].mean_friction


def _friction_errors(kick: Array, slope: Array, seed: int) -> Array:
    """Offsets (n, 2) of the friction that turn the cycle by ``kick`` (n,), rad; ``slope`` (n, 2), rad per unit.

    Along the slope an offset is kick / |slope|; across it, where it turns nothing, it is as large on average.
    """
    size = np.hypot(*slope.T)
    along = slope / size[:, np.newaxis]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    free = NOISE.sigma * np.random.default_rng((seed, 1)).standard_normal(kick.size)
    return np.asarray((kick / size)[:, np.newaxis] * along + (free / size)[:, np.newaxis] * across)


@dataclass(frozen=True, eq=False)
class SurfaceState:
    """The cycle and the push on a surface as it is at one cycle.

    cycle : its number. map : the cycle map, rad. theta : (k,) rad in [0, 2π), orientations of computed pushes.
    motion : (k, 3), their Δθ (rad), Δx and Δy (m, initial object frame). motion_error : (3,), the largest difference
    of interpolated pushes from the mechanics at 12 other orientations. slopes : (36, 4, 2), derivatives of Δθ, Δx, Δy
    and the next θ0 by the centre (m0, n0) of the limit ellipse, evenly round the circle.
    mean_friction : sqrt(mu_a mu_b).
    """

    cycle: float
    map: CircleMap
    theta: Array
    motion: Array
    motion_error: Array
    slopes: Array
    mean_friction: float

    def push_motion(self, theta: ArrayLike) -> Array:
        """(..., 3) of pushes from orientations (...), rad: the periodic cubic spline through the computed ones."""
        return _periodic_spline(self.theta, self.motion)(_base(theta))

    def by_offset(self, theta: ArrayLike) -> Array:
        """(..., 4, 2), the derivatives of ``slopes`` at orientations (...), rad, linear between neighbours."""
        places = 2 * np.pi * np.arange(_SLOPES + 1) / _SLOPES
        rows = np.concatenate([self.slopes, self.slopes[:1]]).reshape(_SLOPES + 1, -1)
        angles = _base(theta)
        found = np.stack([np.interp(angles, places, row) for row in rows.T], axis=-1)
        return np.asarray(found.reshape(*angles.shape, *self.slopes.shape[1:]))


def surface_state(loop: CollectionLoop, cycle: float = 0.0, tolerance: float = MAP_TOLERANCE) -> SurfaceState:
    """Compute the state of ``loop``'s surface at ``cycle``; pushes are computed where the map had to be sampled.

    Time: about 2 s. Raises what the mechanics raise where they have no answer.

    >>> state = surface_state(CollectionLoop.mit("isotropic"), tolerance=1e-3)
    >>> np.degrees(state.push_motion([0.0, 1.0])[:, 0]).round(3)
    array([74.52, 74.52])
    """
    frozen = replace(worn_loop(loop, cycle), accuracy=_ACCURACY)
    cycle_map = frozen.circle_map(tolerance)
    assert cycle_map.pieces is not None
    theta = cycle_map.pieces.knots[:-1]
    motion = _motion(frozen, theta)
    others = 2 * np.pi * np.mod(_GOLDEN * np.arange(1, _CHECKED + 1), 1.0)
    error = np.max(np.abs(_periodic_spline(theta, motion)(others) - _motion(frozen, others)), axis=0)
    law = frozen.material.friction
    slopes = []
    for start in (2 * np.pi * np.arange(_SLOPES) / _SLOPES).tolist():
        found = frozen.sensitivity(start, _OFFSET)
        slopes.append([[found.by(parameter, output) for parameter in _OFFSET] for output in _OUTPUTS])
    mean, pushes = math.sqrt(law.mu_a * law.mu_b), (read_only(theta), read_only(motion), read_only(error))
    return SurfaceState(cycle, cycle_map, *pushes, read_only(slopes), mean)


def _base(theta: ArrayLike) -> Array:
    return np.asarray(np.mod(np.asarray(theta, dtype=float), 2 * np.pi))


def _motion(loop: CollectionLoop, theta: Array) -> Array:
    runs = loop.cycles(theta)
    return np.column_stack([runs.push_turn, runs.push_displacement])


def _periodic_spline(theta: Array, values: Array) -> Callable[[Array], Array]:
    from scipy.interpolate import CubicSpline

    whole = np.append(theta, theta[0] + 2 * np.pi)
    return CubicSpline(whole, np.vstack([values, values[:1]]), bc_type="periodic")  # type: ignore[no-any-return]


@dataclass(frozen=True, eq=False)
class MaterialPushes:
    """One of the paper's materials. runs : simulated, of each material that stands for it. measured : None without."""

    surface: str
    runs: tuple[SampledRun, ...]
    measured: MeasuredRun | None

    @property
    def published(self) -> PublishedStatistics:
        """What the paper prints."""
        return published_statistics(self.surface)

    @property
    def sets(self) -> list[tuple[str, PushSet]]:
        """The sets with the words for where they come from, the recorded one last."""
        found = [(f"simulated, {run.material}", run.pushes) for run in self.runs]
        return found if self.measured is None else [*found, ("recorded", self.measured.pushes)]


def material_pushes(measured: MeasuredFolder, sampling: Sampling = PAPER) -> tuple[MaterialPushes, ...]:
    """Simulate pushes on every material and look for recorded ones, in the paper's order."""
    return tuple(
        MaterialPushes(
            surface, tuple(sampled_run(material, sampling) for material in materials), measured_run(measured, surface)
        )
        for surface, materials in SIMULATED.items()
    )


def absent(materials: Sequence[MaterialPushes]) -> list[str]:
    """The materials without recorded pushes."""
    return [one.surface for one in materials if one.measured is None]
