"""Expected coverage after n pushes by simulation, with standard errors: what no formula gives for a chain."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from cyclemap.checks import finite_array, finite_number, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.circular_law import CircularLaw
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.mixtures.law_evolution import CycleOperator
from cyclemap.maps.mixtures.mixture_operator import MixtureOperator
from cyclemap.maps.mixtures.periodic_schedule import PeriodicSchedule
from cyclemap.maps.mixtures.random_map import RandomMap, sample_random_paths
from cyclemap.resets.scores.coverage_measures import DEFAULT_SECTORS, coverage_measures

Start = float | Literal["stationary", "uniform"]
Sampler = Callable[[int, int, int], Array]
_TABLE = 1 << 13  # cells of the table from which starts of a law are drawn


@dataclass(frozen=True)
class SampledMean:
    """The mean of ``runs`` simulated collections, its standard error, and the standard deviation of one."""

    mean: float
    standard_error: float
    deviation: float
    runs: int

    @classmethod
    def of(cls, values: Array) -> SampledMean:
        """Of values (runs,), at least two."""
        spread = float(np.std(values, ddof=1))
        return cls(float(np.mean(values)), spread / float(np.sqrt(values.size)), spread, int(values.size))

    def agrees(self, truth: float, deviations: float = 4.0) -> bool:
        """Whether ``truth`` is within so many standard errors."""
        return abs(self.mean - truth) <= deviations * self.standard_error


@dataclass(frozen=True)
class SimulatedCoverage:
    """Mean coverage after ``pushes`` pushes: largest gap (radians), Kuiper's discrepancy, share of sectors visited."""

    pushes: int
    sectors: int
    largest_gap: SampledMean
    kuiper: SampledMean
    sector_share: SampledMean


def simulated_coverage(
    sampler: Sampler,
    pushes: int,
    *,
    sectors: int = DEFAULT_SECTORS,
    target: CircularLaw | None = None,
    runs: int = 400,
    seed: int = 0,
) -> SimulatedCoverage:
    """Mean coverage of ``runs`` simulated collections of ``pushes`` orientations.

    sampler : (runs, pushes, seed) -> orientations (runs, pushes), radians, collections independent of each other;
        ``chain_sampler`` makes one of an operator, and any strategy or the full mechanics can be one.
    target : of the discrepancy; None is uniform.

    >>> independent = lambda runs, pushes, seed: np.random.default_rng(seed).uniform(0, TWO_PI, (runs, pushes))
    >>> found = simulated_coverage(independent, 20, sectors=8)
    >>> found.sector_share.agrees(1 - (7 / 8) ** 20)
    True
    """
    size = whole_number("runs", runs, least=2), whole_number("pushes", pushes, least=1)
    theta = finite_array("the sampler's orientations", sampler(*size, whole_number("seed", seed, least=0)))
    if theta.shape != size:
        raise InvalidInput(f"the sampler gave shape {theta.shape} for {size}: give one row a collection")
    found = coverage_measures(theta, sectors, target)
    parts = (found.largest_gap, found.kuiper, found.sector_share)
    return SimulatedCoverage(size[1], sectors, *(SampledMean.of(part) for part in parts))


def chain_sampler(operator: CycleOperator, start: Start = "stationary") -> Sampler:
    """A sampler of the operator's chain: collections whose first push is at ``start``.

    start : an angle, radians, the same for all; "stationary" or "uniform" draws each collection's own.
    """
    random_map = random_map_of(operator)
    begin: Any = start if isinstance(start, str) else finite_number("start", start)
    if isinstance(begin, str) and begin not in ("stationary", "uniform"):
        raise InvalidInput(f"start is {start!r}: give an angle in radians, 'stationary' or 'uniform'")

    def sample(runs: int, pushes: int, seed: int) -> Array:
        rng = np.random.default_rng([seed, 1])
        starts = drawn_starts(operator, begin, runs, rng) if isinstance(begin, str) else np.full(runs, begin)
        if pushes == 1:
            return starts[:, None]
        return sample_random_paths(random_map, pushes - 1, starts, seed)

    return sample


def schedule_sampler(schedule: PeriodicSchedule, start: float | Literal["uniform"] = "uniform") -> Sampler:
    """A sampler of a periodic or shuffled schedule: collections whose first push is at ``start`` and begins a block.

    >>> from cyclemap.maps import CircleMap, WrappedNormal, transfer_operator
    >>> still = transfer_operator(CircleMap.rigid(0.0), WrappedNormal(0.1))
    >>> schedule_sampler(PeriodicSchedule([still, still]), 1.0)(3, 5, 0).shape
    (3, 5)
    """
    parts = [random_map_of(operator) for operator in schedule.operators]
    begin: Any = start if start == "uniform" else finite_number("start", start)

    def sample(runs: int, pushes: int, seed: int) -> Array:
        rng = np.random.default_rng([seed, 1])
        paths = np.empty((runs, pushes))
        paths[:, 0] = TWO_PI * rng.uniform(0.0, 1.0, runs) if begin == "uniform" else begin
        orders = _orders(schedule, runs, pushes, rng)
        for n in range(pushes - 1):
            for i in np.unique(orders[:, n]):
                use, own = np.flatnonzero(orders[:, n] == i), int(rng.integers(1 << 62))
                paths[use, n + 1] = sample_random_paths(parts[i], 1, paths[use, n], own)[:, 1]
        return paths

    return sample


def _orders(schedule: PeriodicSchedule, runs: int, pushes: int, rng: np.random.Generator) -> Any:
    """Which operator each cycle goes by: (runs, at least pushes)."""
    blocks = -(-pushes // schedule.period)
    rows = np.tile(np.arange(schedule.period), (runs * blocks, 1))
    return (rng.permuted(rows, axis=1) if schedule.shuffled else rows).reshape(runs, -1)


def random_map_of(operator: CycleOperator) -> RandomMap:
    """The random map whose operator this is; of one map, that map alone."""
    if isinstance(operator, MixtureOperator):
        return operator.random_map
    return RandomMap((operator.map,), None, operator.noise)


def drawn_starts(operator: CycleOperator, law: str, count: int, rng: np.random.Generator) -> Array:
    """Angles (count,) in [0, 2π] of the uniform or the stationary law, the latter from a table of 8192 cells."""
    shares = rng.uniform(0.0, 1.0, count)
    if law == "uniform":
        return TWO_PI * shares
    return density_quantiles(operator.density, shares)


def density_quantiles(density: Callable[[Array], Array], shares: Array) -> Array:
    """Angles (n,) in [0, 2π] below which ``shares`` (n,), in [0, 1], of a density on the circle lie; by 8192 cells."""
    grid = TWO_PI * np.arange(_TABLE + 1) / _TABLE
    heights = np.maximum(density(grid), 0.0)
    below = np.append(0.0, np.cumsum(0.5 * (heights[1:] + heights[:-1])))
    return np.asarray(np.interp(shares, below / below[-1], grid))
