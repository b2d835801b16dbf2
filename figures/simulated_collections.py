"""Simulated repeated pushes on each material, sampled from maps of the cycle and of the push: not 2000 full cycles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import positive_number, whole_number
from cyclemap.collection import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.evidence import PushSet, SetLaws, Theta0Pairs, set_laws
from cyclemap.evidence.published_statistics import (
    PUBLISHED_CYCLES,
    PublishedStatistics,
    published_statistics,
)
from cyclemap.maps import (
    CircleMap,
    DriftingMap,
    Staircase,
    TransferOperator,
    WrappedNormal,
    sample_staircase,
    transfer_operator,
)

from .surface_states import MAP_TOLERANCE, SurfaceState, surface_state

# The material that stands for each of the paper's: for plywood the one inferred from the measured staircase, since it
# alone wears and climbs as the robot saw it; Table I's plywood locks in and stays.
STANDS_FOR = {"plywood": "plywood-measured", "abs": "abs", "delrin": "delrin", "pu": "pu"}
SURFACES = tuple(STANDS_FOR)
NOISE = WrappedNormal(DEFAULT_SIGMA)


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
    share = _shares(states, cycle[:-1])
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


def _shares(states: tuple[SurfaceState, ...], cycle: Array) -> Array:
    """(states, n): how much of each state the surface of each cycle has, linear between neighbours."""
    places = [state.cycle for state in states]
    return np.array([np.interp(cycle, places, unit) for unit in np.eye(len(states))])
