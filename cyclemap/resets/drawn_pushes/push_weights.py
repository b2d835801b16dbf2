"""How often to draw each push of a library: the least bias for a drag, or the least drag for a bias."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import finite_array, non_negative_number, positive_number, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.law_evolution import complex_moments, images_law
from cyclemap.maps.mixtures.mixture_discretisation import MixtureDiscretisation, mixture_discretisation
from cyclemap.maps.mixtures.random_map import RandomMap
from cyclemap.maps.mixtures.worst_start import largest_variation
from cyclemap.mechanics import SidePush
from cyclemap.resets.drawn_pushes.push_library import PushLibrary
from cyclemap.resets.drawn_pushes.push_mixture import PushMixture
from cyclemap.resets.drawn_pushes.push_search import PushProblem, search
from cyclemap.resets.least_noise.least_correction import checked_allowance
from cyclemap.resets.scores.reset_scores import ResetScores, reset_scores
from cyclemap.resets.strategies.strategy import ResetStrategy

Array = NDArray[np.float64]

_STARTS = 128  # starting angles that are compared in what is reported
_TAIL = 1e-3  # of the last quarter of a law's moments, that calls for more modes
_CLOSE = 1e-6  # of a limit, that counts as within it
_NEAR = 0.98  # of a limit, from which on it is named as limiting


@dataclass(frozen=True, eq=False)
class PushLimits:
    """What is asked of drawn pushes on S loops.

    allow_tv : total variation from uniform allowed, None where the least is sought. drag : (S,), mean drag allowed, m,
    inf for any. within, extra_tv : so many pushes from the worst start the law may be so much further off.
    """

    allow_tv: float | None
    drag: Array
    within: int = 50
    extra_tv: float = 0.05

    def __post_init__(self) -> None:
        if self.allow_tv is not None:
            object.__setattr__(self, "allow_tv", checked_allowance(self.allow_tv))
        object.__setattr__(self, "drag", read_only(self.drag))
        whole_number("within", self.within, least=1)
        object.__setattr__(self, "extra_tv", non_negative_number("extra_tv", self.extra_tv))

    @classmethod
    def on(
        cls, library: PushLibrary, allow_tv: float | None, drag_limit: ArrayLike | None, within: int, extra_tv: float
    ) -> PushLimits:
        """The limits on a library's loops; drag_limit : m, None, one for all loops or one for each."""
        if drag_limit is None:
            return cls(allow_tv, np.full(library.scenarios, math.inf), within, extra_tv)
        given = np.atleast_1d(finite_array("drag_limit", drag_limit))
        if given.shape not in ((1,), (library.scenarios,)) or np.any(given <= 0.0):
            raise InvalidInput(f"drag_limit is {drag_limit!r}: give one positive length (m), or one for each loop")
        return cls(allow_tv, np.broadcast_to(given, (library.scenarios,)), within, extra_tv)

    def bias(self, tv: Array, tv_within: Array) -> float:
        """What is compared with the allowance: the worst loop's bias, in the long run or early, less `extra_tv`."""
        return float(max(tv.max(), tv_within.max() - self.extra_tv))


@dataclass(frozen=True, eq=False)
class PushWeights:
    """Pushes of a library, drawn with weights, and what is predicted of them on each of its S loops.

    numbers, weights : (k,), in the library; the weights sum to one. tv : (S,), total variation of the stationary law
    from uniform. tv_within : (S,), of the law after `limits.within` pushes from the worst start. second_eigenvalue :
    (S,), |λ₂|. drag : (S,), mean over even orientations, m. met : whether every limit is kept. limiting : which of
    "bias", "speed", "drag", "reach" and "number of pushes" are at their limits; where the least bias is sought, "bias"
    or "speed" tells whether the long run or the first pushes set it.

    All from the library's maps, without bounds: `scores` gives certified ones.
    """

    library: PushLibrary
    numbers: tuple[int, ...]
    weights: Array
    tv: Array
    tv_within: Array
    second_eigenvalue: Array
    drag: Array
    limits: PushLimits
    met: bool
    limiting: tuple[str, ...]

    @property
    def bias(self) -> float:
        """What is compared with the allowance, or was made least; see `PushLimits.bias`."""
        return self.limits.bias(self.tv, self.tv_within)

    @property
    def pushes(self) -> tuple[SidePush, ...]:
        """(k)."""
        return tuple(self.library.pushes[i] for i in self.numbers)

    @cached_property
    def long_run_drag(self) -> Array:
        """(S,): mean drag under the stationary law, m: what `push_bound` compares; `drag` is that without bias."""
        chosen = self.library.drag_lengths[:, list(self.numbers)]
        even = 2.0 * math.pi * np.arange(chosen.shape[2]) / chosen.shape[2]
        shares = [self._law(s).density(even) for s in range(self.library.scenarios)]
        return np.array([(self.weights @ row) @ share / share.sum() for row, share in zip(chosen, shares, strict=True)])

    def _law(self, scenario: int) -> FourierLaw:
        basis = _resolved(self.random_map(scenario), self.library.modes)
        return FourierLaw(_stationary_moments(basis))

    @cached_property
    def reach(self) -> Array:
        """(S,): radius (m) about the target that rod and object need; found by running cycles, 0.2 s a push."""
        return np.asarray(np.max([self.library.reach(i) for i in self.numbers], axis=0))

    def strategy(self) -> ResetStrategy:
        """Return the drawn pushes, combined with the library's legs."""
        return self.library.strategy(self.numbers, self.weights.tolist())

    def random_map(self, scenario: int = 0) -> RandomMap:
        """Return the cycle on one loop."""
        return self.library.random_map(scenario, self.numbers, self.weights.tolist())

    def scores(self, scenario: int = 0, *, modes: int | None = None, **options: Any) -> ResetScores:
        """Return all scores on one loop from the library's maps, certified as finely as these allow.

        modes : None: all that the noise lets through. options : those of `ResetScores`.
        """
        cycle = self.random_map(scenario)
        return reset_scores(cycle.maps, cycle.noise, cycle.weights, modes=modes, **options)


def best_push_weights(
    library: PushLibrary,
    *,
    allow_tv: float | None = None,
    drag_limit: ArrayLike | None = None,
    within: int = 50,
    extra_tv: float = 0.05,
    reach_limit: float | None = None,
    most_pushes: int | None = None,
    starts: int = 4,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> PushWeights:
    """Return how often to draw each push, so that orientations spread evenly and fast on every loop at once.

    allow_tv : total variation from uniform allowed in the long run. Given: the least drag with it, within drag_limit if
    that is given too. None: the least bias within drag_limit, or at any drag. The bias is the worst loop's; it counts
    the law after `within` pushes from the worst start too, which may be `extra_tv` further off.
    drag_limit : m, of the mean drag, one number or one a loop, (S,); where they differ, drags are compared with them.
    reach_limit : m: pushes that need more room are not used. most_pushes : None: as many as help.
    starts, seed : of the search. A mixture's law is no convex function of its weights: what is found is a local
    optimum, the best of so many starts; `push_bound` tells how much better any rule could be.

    Where the allowance cannot be kept the least bias found is returned, `met` False, and `limiting` names why.
    Raises InvalidInput for bad values, for neither limit, and where no push is within reach_limit.

    >>> from cyclemap.maps import CircleMap, WrappedNormal
    >>> maps = [[CircleMap.arnold(0.0, 0.9), CircleMap.rigid(0.31)]]
    >>> library = PushLibrary.of_maps(maps, WrappedNormal(0.5), [[0.1, 0.2]], modes=16)
    >>> found = best_push_weights(library, allow_tv=0.05)
    >>> found.met, bool(0.1 < found.drag[0] < 0.2), found.limiting
    (True, True, ('bias',))
    """
    if allow_tv is None and drag_limit is None:
        raise InvalidInput("give allow_tv, the bias allowed, or drag_limit, the mean drag allowed, or both")
    limits = PushLimits.on(library, allow_tv, drag_limit, within, extra_tv)
    numbers = _within_reach(library, reach_limit)
    most = None if most_pushes is None else whole_number("most_pushes", most_pushes, least=1)
    count, number = whole_number("starts", starts, least=1), whole_number("seed", seed, least=0)
    report = progress or (lambda fraction: None)
    found = search(_problem(library, limits, numbers), most, count, number, report)
    order = np.argsort(-found.weights, kind="stable")
    chosen = tuple(int(i) for i in numbers[found.numbers[order]])
    binding = {"reach": len(numbers) < len(library.pushes), "number of pushes": most == len(chosen)}
    further = tuple(name for name, binds in binding.items() if binds)
    return _predicted(library, chosen, found.weights[order], limits, further)


def push_weights(
    library: PushLibrary,
    numbers: ArrayLike,
    weights: ArrayLike,
    *,
    allow_tv: float | None = None,
    drag_limit: ArrayLike | None = None,
    within: int = 50,
    extra_tv: float = 0.05,
) -> PushWeights:
    """Return what is predicted of given pushes, `numbers` (k,) of the library, and weights (k,), positive.

    >>> from cyclemap.maps import CircleMap, WrappedNormal
    >>> turns = [[CircleMap.rigid(0.1), CircleMap.rigid(0.4)]]
    >>> library = PushLibrary.of_maps(turns, WrappedNormal(0.1), [[0.1, 0.2]], modes=8)
    >>> push_weights(library, [0, 1], [1.0, 1.0]).drag.round(3).tolist()
    [0.15]
    """
    asked, share = finite_array("numbers", np.atleast_1d(numbers), ndim=1), finite_array("weights", weights, ndim=1)
    given = tuple(int(i) for i in asked)
    known = set(asked.tolist()) <= set(range(len(library.pushes)))
    if share.size != len(given) or not given or np.any(share <= 0.0) or not known:
        raise InvalidInput(
            f"give positive weights for pushes of the library, one each: {asked.tolist()} and {share.tolist()}"
        )
    limits = PushLimits.on(library, allow_tv, drag_limit, within, extra_tv)
    share = share / share.max()  # so that the largest of doubles have a sum, too
    return _predicted(library, given, share / share.sum(), limits, ())


def _problem(library: PushLibrary, limits: PushLimits, numbers: NDArray[np.int64]) -> PushProblem:
    """The search's problem of these pushes, drags over what is allowed."""
    limited = bool(np.all(np.isfinite(limits.drag)))
    return PushProblem(
        tuple(PushMixture(library.matrices[s][numbers]) for s in range(library.scenarios)),
        library.mean_drags[:, numbers] / (limits.drag[:, None] if limited else 1.0),
        limited,
        limits.allow_tv,
        limits.within,
        limits.extra_tv,
    )


def _within_reach(library: PushLibrary, reach_limit: float | None) -> NDArray[np.int64]:
    every = np.arange(len(library.pushes))
    if reach_limit is None:
        return every
    limit = positive_number("reach_limit", reach_limit)
    reaches = np.array([library.reach(int(i)).max() for i in every])
    if reaches.min() > limit:
        raise InvalidInput(
            f"reach_limit is {limit:g} m: every push needs more room about the target, the least {reaches.min():.4f} m"
        )
    return np.asarray(np.flatnonzero(reaches <= limit))


def _predicted(
    library: PushLibrary, numbers: tuple[int, ...], weights: Array, limits: PushLimits, further: tuple[str, ...]
) -> PushWeights:
    rows = [_laws(library, s, numbers, weights, limits.within) for s in range(library.scenarios)]
    tv, late, second = (read_only(column) for column in np.array(rows).T)
    drag = read_only(library.mean_drags[:, list(numbers)] @ weights)
    allowed = limits.bias(tv, late) if limits.allow_tv is None else limits.allow_tv
    shares = {
        "bias": tv.max() / max(allowed, _CLOSE),
        "speed": late.max() / max(allowed + limits.extra_tv, _CLOSE),
        "drag": np.max(drag / limits.drag),
    }
    limiting = tuple(name for name, share in shares.items() if share >= _NEAR) + further
    met = all(share <= 1.0 + _CLOSE for share in shares.values())
    return PushWeights(library, numbers, read_only(weights), tv, late, second, drag, limits, met, limiting)


def _laws(
    library: PushLibrary, scenario: int, numbers: tuple[int, ...], weights: Array, within: int
) -> tuple[float, float, float]:
    """Total variation in the long run and after `within` pushes from the worst start, and |λ₂|."""
    basis = _resolved(library.random_map(scenario, numbers, weights.tolist()), library.modes)
    first = images_law(basis, 2.0 * math.pi * np.arange(_STARTS) / _STARTS)
    late = np.linalg.matrix_power(basis.matrix, within - 1) @ first
    worst = largest_variation(complex_moments(late), FourierLaw.uniform())
    law = FourierLaw(_stationary_moments(basis))
    return float(law.total_variation()), worst, PushMixture(basis.matrix[None]).second_eigenvalue(np.ones(1))


def _stationary_moments(basis: MixtureDiscretisation) -> NDArray[np.complex128]:
    """(modes + 1,): E exp(imθ) under the stationary law, those of no law where the modes do not resolve it."""
    return complex_moments(PushMixture(basis.matrix[None]).stationary(np.ones(1)))


def _resolved(cycle: RandomMap, modes: int) -> MixtureDiscretisation:
    """The cycle on so many modes, or, where the stationary law still has some of the last ones, on all that matter."""
    basis = mixture_discretisation(cycle, modes)
    tail = float(np.linalg.norm(_stationary_moments(basis)[-(modes // 4 + 1) :]))
    return basis if tail < _TAIL else mixture_discretisation(cycle)
