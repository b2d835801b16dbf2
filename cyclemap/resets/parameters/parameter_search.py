"""The best strategy of a family: least bias for a cost allowed, or least cost for a bias allowed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import positive_number, read_only, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.maps import Noise
from cyclemap.resets.parameters.parameter_check import checked_scores
from cyclemap.resets.parameters.parameter_gradient import (
    TOTAL_VARIATION,
    BiasGradient,
    Resolution,
    StrategyEvaluator,
    score_index,
)
from cyclemap.resets.parameters.parameter_space import StrategyFamily
from cyclemap.resets.strategies.strategy import ResetStrategy

Array = NDArray[np.float64]

# Cycles of a search are no more accurate than this, rad: far within what the interpolation of maps leaves.
_ACCURACY = 1e-5
# A limit is met if it is exceeded by no more than this share, and binds if it is met by no more than that.
_SLACK, _BINDS = 1e-4, 1e-2
# Share of a parameter's range within which it is at its bound.
_AT_BOUND = 1e-6
# How far scores by adaptive maps may be from those of the search.
AGREEMENT = 0.01


@dataclass(frozen=True, eq=False)
class SearchStart:
    """One start of a search: where it began and ended (k,), whether it converged, and what the optimiser says."""

    begin: Array
    end: Array
    converged: bool
    message: str


@dataclass(frozen=True, eq=False)
class ParameterSearch:
    """What a search found.

    family, minimise, limits : what was asked, by the names of `parameter_gradient.SCORES`.
    best : scores and gradient at the best parameters, before certification. feasible : whether all limits are met
    there; if not, it is what exceeds them least. converged : whether the start that led there says so.
    stationarity : what is left of the objective's gradient beside those of what binds, by the parameters as shares of
    their ranges, over the objective: zero at a constrained optimum. binding : the limits and the parameters' bounds
    that bind. prices : of each limit, by how much the objective falls for one unit more of it, to first order.
    evaluations : of a strategy, with gradient. cycles : of the mechanics. runs : the starts.
    checked : (5,), the scores by adaptive maps that keep their jumps; None where not asked for.
    """

    family: StrategyFamily
    minimise: str
    limits: Mapping[str, float]
    best: BiasGradient
    feasible: bool
    converged: bool
    stationarity: float
    binding: tuple[str, ...]
    prices: Mapping[str, float]
    evaluations: int
    cycles: int
    runs: tuple[SearchStart, ...]
    checked: Array | None

    @property
    def values(self) -> Array:
        """The best parameters (k,)."""
        return self.best.values

    @property
    def strategy(self) -> ResetStrategy:
        """The strategy with these parameters."""
        return self.family.strategy(self.best.values)

    @property
    def exceeded(self) -> tuple[str, ...]:
        """The limits that the best strategy found does not keep: why a demand cannot be met."""
        return tuple(name for name, limit in self.limits.items() if self.best.score(name) > limit * (1.0 + _SLACK))

    @property
    def disagreement(self) -> float:
        """The largest difference of the scores from those by adaptive maps, of the drag as a share; inf unchecked."""
        if self.checked is None:
            return math.inf
        scale = np.array([1.0, 1.0, 1.0, 1.0, max(self.checked[-1], 1e-300)])
        return float(np.abs((self.best.value - self.checked) / scale).max())

    @property
    def confirmed(self) -> bool:
        """Whether the adaptive maps agree to `AGREEMENT`, and keep the limits to it."""
        if self.checked is None or self.disagreement > AGREEMENT:
            return False
        kept = (self.checked[score_index(name)] <= limit * (1.0 + AGREEMENT) for name, limit in self.limits.items())
        return self.feasible and all(kept)


def search_parameters(
    loop: CollectionLoop,
    family: StrategyFamily,
    noise: Noise,
    minimise: str = TOTAL_VARIATION,
    limits: Mapping[str, float] | None = None,
    *,
    start: ArrayLike | None = None,
    starts: int = 4,
    seed: int = 0,
    iterations: int = 40,
    resolution: Resolution | None = None,
    check: bool = True,
    progress: Callable[[float], None] | None = None,
) -> ParameterSearch:
    """Minimise a score of the family's strategy within its bounds, other scores within `limits`.

    minimise : one of `SCORES`, or a parameter of the family. limits : on scores, by name. start : parameters (k,) to
    begin with; None: the middle. starts : how many beginnings in all, the others from a Latin hypercube by `seed`.
    iterations : of each, at most. check : whether to compute the best one's maps again, adaptively.
    progress : called with the fraction done.

    By sequential quadratic programming (Kraft 1988) on the exact gradients of `bias_gradient`, from several starts: a
    local optimum is certain to first order at best (`stationarity`), a global one never. What cannot be run is left.

    Raises InvalidInput for bad values, and what the mechanics raises where no strategy tried could be run.
    """
    allowed = _checked_limits(limits)
    rough = replace(loop, accuracy=max(loop.accuracy, _ACCURACY))
    evaluator = StrategyEvaluator(rough, family, noise, resolution or Resolution())
    search = _Search(evaluator, _checked_objective(family, minimise), allowed)
    begins = _beginnings(family, start, whole_number("starts", starts, least=1), whole_number("seed", seed, least=0))
    most = whole_number("iterations", iterations, least=1)
    runs, report = [], progress or (lambda fraction: None)
    for number, begin in enumerate(begins):
        runs.append(search.run(begin, most))
        report((number + 1) / len(begins))
    best = search.best()
    ended = min(runs, key=lambda run: float(np.abs(family.to_unit(run.end) - family.to_unit(best.values)).max()))
    left, binding, prices = search.optimality(best)
    checked = checked_scores(rough, best, noise, evaluator.resolution) if check else None
    return ParameterSearch(
        *(family, minimise, allowed, best, search.excess(best) <= _SLACK, ended.converged, left, binding, prices),
        *(evaluator.evaluations, evaluator.sampler.cycles, tuple(runs), checked),
    )


def _checked_objective(family: StrategyFamily, name: str) -> str:
    if name not in family.names:
        score_index(name)
    return name


def _checked_limits(limits: Mapping[str, float] | None) -> dict[str, float]:
    given = dict(limits or {})
    for name in given:
        score_index(name)
    return {name: positive_number(f"limit of {name}", value) for name, value in given.items()}


def _beginnings(family: StrategyFamily, start: ArrayLike | None, count: int, seed: int) -> list[Array]:
    from scipy.stats import qmc

    first = family.from_unit(np.full(len(family.names), 0.5)) if start is None else family.checked(start)
    shares = qmc.LatinHypercube(len(family.names), rng=np.random.default_rng(seed)).random(max(count - 1, 1))
    return [first, *family.from_unit(shares)][:count]


@dataclass(eq=False)
class _Search:
    """A search under way, in shares of the parameters' ranges; it remembers all that it evaluated."""

    evaluator: StrategyEvaluator
    objective: str
    limits: Mapping[str, float]
    known: dict[bytes, BiasGradient] = field(default_factory=dict)
    failed: CycleMapError | None = None

    @property
    def _range(self) -> Array:
        low, high = self.evaluator.family.bounds
        return np.asarray(high - low)

    def at(self, shares: Array) -> BiasGradient:
        """The scores at shares (k,) of the ranges, each evaluated once."""
        key = np.ascontiguousarray(shares).tobytes()
        if key not in self.known:
            self.known[key] = self.evaluator.at(self.evaluator.family.from_unit(shares))
        return self.known[key]

    def run(self, begin: Array, iterations: int) -> SearchStart:
        """Run the optimiser from parameters (k,)."""
        from scipy.optimize import minimize

        shares = self.evaluator.family.to_unit(begin)
        try:
            unit = max(abs(self._value(self.at(shares))), 1e-9)
            found = minimize(
                lambda x: self._value(self.at(x)) / unit,
                shares,
                jac=lambda x: self._slopes(self.at(x)) / unit,
                bounds=[(0.0, 1.0)] * shares.size,
                constraints=[self._constraint(name, limit) for name, limit in self.limits.items()],
                method="SLSQP",
                options={"maxiter": iterations, "ftol": 1e-6},
            )
        except CycleMapError as error:
            self.failed = error
            return SearchStart(read_only(begin), read_only(begin), False, f"{type(error).__name__}: {error}")
        end = self.evaluator.family.from_unit(found.x)
        return SearchStart(read_only(begin), read_only(end), bool(found.success), str(found.message))

    def _value(self, found: BiasGradient) -> float:
        """What is minimised: a score, or a parameter itself."""
        names = self.evaluator.family.names
        if self.objective in names:
            return float(found.values[names.index(self.objective)])
        return found.score(self.objective)

    def _slopes(self, found: BiasGradient) -> Array:
        """Its derivatives by the shares (k,)."""
        names = self.evaluator.family.names
        if self.objective in names:
            return np.asarray(np.eye(len(names))[names.index(self.objective)] * self._range)
        return np.asarray(found.slopes(self.objective) * self._range)

    def _constraint(self, name: str, limit: float) -> dict[str, object]:
        row = score_index(name)
        return {
            "type": "ineq",
            "fun": lambda x: 1.0 - self.at(x).value[row] / limit,
            "jac": lambda x: -self.at(x).gradient[row] * self._range / limit,
        }

    def excess(self, found: BiasGradient) -> float:
        """By what share the most exceeded limit is exceeded; zero or less where all are kept."""
        return max((found.score(name) / limit - 1.0 for name, limit in self.limits.items()), default=0.0)

    def best(self) -> BiasGradient:
        """The best of all that was evaluated: least objective among those within the limits, else least excess."""
        if not self.known:
            raise self.failed or InvalidInput("nothing was evaluated")
        kept = [one for one in self.known.values() if self.excess(one) <= _SLACK]
        if kept:
            return min(kept, key=self._value)
        return min(self.known.values(), key=self.excess)

    def optimality(self, best: BiasGradient) -> tuple[float, tuple[str, ...], dict[str, float]]:
        """What is left of the objective's gradient, what binds, and the limits' prices (Karush-Kuhn-Tucker)."""
        from scipy.optimize import nnls

        slope = self._slopes(best)
        names, rows = [], []
        for name, limit in self.limits.items():
            if abs(best.score(name) / limit - 1.0) <= _BINDS:
                names.append(name)
                rows.append(best.slopes(name) * self._range)
        shares = self.evaluator.family.to_unit(best.values)
        for index, name in enumerate(self.evaluator.family.names):
            if min(shares[index], 1.0 - shares[index]) <= _AT_BOUND:
                names.append(name)
                rows.append(np.eye(shares.size)[index] * (1.0 if shares[index] > 0.5 else -1.0))
        size = max(abs(self._value(best)), 1e-300)
        if not rows:
            return float(np.linalg.norm(slope)) / size, (), dict.fromkeys(self.limits, 0.0)
        forces, left = nnls(np.array(rows).T, -slope)
        held = {name: float(force) for name, force in zip(names, forces, strict=True)}
        prices = {name: held.get(name, 0.0) for name in self.limits}
        return float(left) / size, tuple(name for name in names if held[name] > 0.0), prices
