"""Search for the weights of pushes: smooth programmes by SLSQP from several starts, then fewer pushes by exchange."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.resets.drawn_pushes.push_mixture import PushMixture

Array = NDArray[np.float64]
Rows = Callable[[Array], tuple[Array, Array]]

# Smoothing of |.| and sharpness of the largest start. The fine ones overrate a bias by at most 0.008.
_ROUGH, _FINE = (0.02, 200.0), (0.004, 600.0)
_STEPS, _TOLERANCE = 150, 1e-7
_CORRECTIONS, _MARGIN = 3, 1e-4
_COARSE = 32  # modes of the search; what it finds is polished on all
_NEGLIGIBLE = 1e-3  # weights below are left out
_SHRINK = 0.6  # share of the pushes that is kept from one round of leaving out to the next
_NEWCOMERS, _EXCHANGES = 4, 3


@dataclass(frozen=True, eq=False)
class Candidate:
    """Weights (k,) of the pushes with `numbers` (k,). excess : of the bias over the allowance, 0 where it is met.

    objective : what is least: the bias where none is allowed by number, else the drag.
    """

    numbers: NDArray[np.int64]
    weights: Array
    excess: float
    objective: float

    @property
    def order(self) -> tuple[float, float]:
        """Candidates are better the smaller this is: allowance first, then the objective."""
        return self.excess, self.objective


@dataclass(frozen=True, eq=False)
class PushProblem:
    """Pushes on S loops. mixtures : (S). drags : (S, P), mean drag over the largest allowed, or m where none is.

    The bias of weights is the largest over the loops of the stationary law's total variation from uniform, and of that
    after `within` pushes from the worst start less `extra_tv`. Drag: the largest Σ w_i drags over the loops.

    allow_tv : None: the least bias is sought with a drag of at most 1 (where `limited`); else the least drag with this
    bias, under the same limit. smoothing : of |.|, and the sharpness of the largest start.
    """

    mixtures: tuple[PushMixture, ...]
    drags: Array
    limited: bool
    allow_tv: float | None
    within: int
    extra_tv: float
    smoothing: tuple[float, float] = _FINE

    @property
    def size(self) -> int:
        """P."""
        return int(self.drags.shape[1])

    def only(self, numbers: NDArray[np.int64]) -> PushProblem:
        """The problem of these pushes alone."""
        kept = tuple(PushMixture(one.matrices[numbers]) for one in self.mixtures)
        return replace(self, mixtures=kept, drags=self.drags[:, numbers])

    def biases(self, weights: Array, smoothing: float = 0.0, sharpness: float = math.inf) -> tuple[Array, Array]:
        """The 2S biases, (2S,), whose largest counts, and their gradients (2S, P)."""
        rows = []
        for mixture in self.mixtures:
            rows.append(mixture.bias(weights, smoothing))
            value, slope = mixture.bias_after(weights, self.within, smoothing, sharpness)
            rows.append((value - self.extra_tv, slope))
        return np.array([value for value, _ in rows]), np.array([slope for _, slope in rows])

    def judged(self, numbers: NDArray[np.int64], weights: Array) -> Candidate:
        """Weights of this problem's pushes, `numbers` in the whole one, as a candidate."""
        bias, drag = float(self.biases(weights)[0].max()), float((self.drags @ weights).max())
        over = max(0.0, drag - 1.0 - _TOLERANCE) if self.limited else 0.0
        if self.allow_tv is None:
            return Candidate(numbers, weights, over, bias)
        return Candidate(numbers, weights, max(0.0, bias - self.allow_tv) + over, drag)

    def local_optimum(self, start: Array) -> Array:
        """Weights (P,), locally best from `start`: least bias first, then the least drag where that is sought."""
        smoothed = _Smoothed(self, *self.smoothing)
        weights = self._least_bias(start, smoothed)
        if self.allow_tv is None or self.biases(weights)[0].max() > self.allow_tv:
            return weights
        return self._least_drag(weights, smoothed, self.allow_tv)

    def _least_bias(self, start: Array, biases: _Smoothed) -> Array:
        """min t with every bias at most t, and the drag within its limit."""
        held = [(_Linear(self.drags), 1.0)] if self.limited else []
        return _minimised(start, biases, held)

    def _least_drag(self, start: Array, biases: _Smoothed, allow_tv: float) -> Array:
        """min t with every drag at most t, every bias within the allowance: what smoothing adds is taken off again."""
        everything = np.arange(self.size)
        best, trial = self.judged(everything, start), start
        for _ in range(_CORRECTIONS):
            overrated = float(biases(trial)[0].max() - self.biases(trial)[0].max())
            trial = _minimised(trial, _Linear(self.drags), [(biases, allow_tv + overrated - _MARGIN)])
            best = min(best, self.judged(everything, trial), key=lambda found: found.order)
        return best.weights


class _Smoothed:
    """The smoothed biases and their gradients; the last weights asked for are remembered."""

    def __init__(self, problem: PushProblem, smoothing: float, sharpness: float) -> None:
        self._problem, self._options = problem, (smoothing, sharpness)
        self._last: tuple[bytes, tuple[Array, Array]] | None = None

    def __call__(self, weights: Array) -> tuple[Array, Array]:
        key = weights.tobytes()
        if self._last is None or self._last[0] != key:
            self._last = key, self._problem.biases(weights, *self._options)
        return self._last[1]


@dataclass(frozen=True, eq=False)
class _Linear:
    """rows @ weights and its gradients, the rows."""

    rows: Array

    def __call__(self, weights: Array) -> tuple[Array, Array]:
        return self.rows @ weights, self.rows


def _minimised(start: Array, least: Rows, held: Sequence[tuple[Rows, float]]) -> Array:
    """Weights that minimise t with `least` ≤ t and the rows `held` within their limits: SLSQP (Kraft 1988)."""
    from scipy.optimize import minimize

    size, rise = start.size, np.append(np.zeros(start.size), 1.0)
    constraints = [{"type": "eq", "fun": lambda z: z[:size].sum() - 1.0, "jac": lambda z: 1.0 - rise}]
    constraints.append(_at_most(least, None))
    constraints.extend(_at_most(rows, limit) for rows, limit in held)
    found = minimize(
        lambda z: z[size],
        np.append(start, least(start)[0].max()),
        jac=lambda z: rise,
        bounds=[(0.0, 1.0)] * size + [(None, None)],
        constraints=constraints,
        method="SLSQP",
        options={"maxiter": _STEPS, "ftol": _TOLERANCE},
    )
    kept = np.clip(found.x[:size], 0.0, 1.0)
    return np.asarray(kept / kept.sum()) if np.isfinite(kept.sum()) and kept.sum() > 0.0 else start


def _at_most(rows: Rows, limit: float | None) -> dict[str, Any]:
    """SLSQP's constraint rows(w) ≤ limit, or ≤ t where the limit is None."""

    def slack(z: Array) -> Array:
        return np.asarray((z[-1] if limit is None else limit) - rows(z[:-1])[0])

    def slope(z: Array) -> Array:
        gradients = rows(z[:-1])[1]
        return np.hstack([-gradients, np.full((len(gradients), 1), float(limit is None))])

    return {"type": "ineq", "fun": slack, "jac": slope}


# -- few pushes ------------------------------------------------------------------------------------------------


def search(
    problem: PushProblem, most_pushes: int | None, starts: int, seed: int, progress: Callable[[float], None]
) -> Candidate:
    """The best weights found: from several starts, pruned to at most so many pushes, then improved by exchanges."""
    fewer = tuple(one.cut(_COARSE) for one in problem.mixtures)
    coarse, found = replace(problem, mixtures=fewer, smoothing=_ROUGH), []
    for number, start in enumerate(_starts(problem, starts, seed)):
        best = _pruned(coarse, _improved(coarse, np.arange(problem.size), start), most_pushes)
        found.append(_exchanged(coarse, best, most_pushes) if most_pushes else best)
        progress((number + 1) / starts)
    best = min(found, key=lambda candidate: candidate.order)
    fine = problem.only(best.numbers).judged(best.numbers, best.weights)
    return min(fine, _improved(problem, best.numbers, best.weights), key=lambda candidate: candidate.order)


def _starts(problem: PushProblem, count: int, seed: int) -> Iterator[Array]:
    """Even weights, then random ones of which few are large; all leaning to short drags where those are limited."""
    rng, longest = np.random.default_rng(seed), problem.drags.max(axis=0)
    cheapest = int(np.argmin(longest))
    for number in range(count):
        weights = rng.dirichlet(np.full(problem.size, 0.3)) if number else np.full(problem.size, 1.0 / problem.size)
        if problem.limited:
            over = max(0.0, float((problem.drags @ weights).max()) - 1.0)
            share = min(1.0, over / max(over + 1.0 - float(longest[cheapest]), 1e-9))
            weights = (1.0 - share) * weights
            weights[cheapest] += share
        yield weights


def _improved(problem: PushProblem, numbers: NDArray[np.int64], start: Array) -> Candidate:
    """The local optimum of the pushes `numbers` from weights (k,), without those that hardly come."""
    part = problem.only(numbers)
    weights = part.local_optimum(start / start.sum())
    kept = weights > min(_NEGLIGIBLE, 0.5 * float(weights.max()))
    if kept.all():
        return part.judged(numbers, weights)
    fewer = problem.only(numbers[kept])
    return fewer.judged(numbers[kept], fewer.local_optimum(weights[kept] / weights[kept].sum()))


def _pruned(problem: PushProblem, candidate: Candidate, most: int | None) -> Candidate:
    """The lightest pushes are left out, some at a time, and the others weighted anew, until few enough are left."""
    while most is not None and candidate.numbers.size > most:
        count = max(most, int(_SHRINK * candidate.numbers.size))
        heaviest = np.sort(np.argsort(-candidate.weights)[:count])
        candidate = _improved(problem, candidate.numbers[heaviest], candidate.weights[heaviest])
    return candidate


def _exchanged(problem: PushProblem, candidate: Candidate, most: int) -> Candidate:
    """One push more, the most promising by the gradient, then back to as many: while that improves."""
    for _ in range(_EXCHANGES):
        better = min(
            (_with_newcomer(problem, candidate, number, most) for number in _promising(problem, candidate)),
            key=lambda found: found.order,
            default=candidate,
        )
        if better.order >= candidate.order:
            break
        candidate = better
    return candidate


def _promising(problem: PushProblem, candidate: Candidate) -> list[int]:
    """The pushes outside whose weight would lower the worst bias fastest, smoothed as the problem says."""
    weights = np.zeros(problem.size)
    weights[candidate.numbers] = candidate.weights
    values, slopes = problem.biases(weights, *problem.smoothing)
    order = np.argsort(slopes[int(np.argmax(values))])
    return [int(i) for i in order if i not in candidate.numbers][:_NEWCOMERS]


def _with_newcomer(problem: PushProblem, candidate: Candidate, number: int, most: int) -> Candidate:
    numbers = np.append(candidate.numbers, number)
    share = 1.0 / numbers.size
    return _pruned(problem, _improved(problem, numbers, np.append((1.0 - share) * candidate.weights, share)), most)
