"""Mean passage times too long for a float, by their logarithm."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import log_ndtr

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.arcs import TWO_PI, Arc, Array, arc_ends, required_inside
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise_law import Noise, WrappedNormal
from cyclemap.maps.passages.nystrom import KilledChain, circle_exit, killed_chain, line_exits
from cyclemap.maps.passages.passage_times import LONGEST, mean_passage_time
from cyclemap.maps.rounding import LOG_PASSAGE

_STRETCH = 1.3  # bandwidth of the second solution over that of the first
_ROUNDS = 5_000  # of the iteration for h
_TURNS = TWO_PI * np.arange(-2.0, 2.0)  # images of a gap in [0, 2π) that may count
_BLOCK = 48  # unknowns eliminated together
_SETTLED = 1.0  # change of ln h a round that ends it: h need not be exact
_ACCEPTED = 1e-6  # error bound of ln T that is accepted at all


def log10_passage_time(
    circle_map: CircleMap,
    noise: Noise,
    start: float,
    arc: Arc,
    *,
    lifted: bool = False,
    progress: Callable[[float], None] | None = None,
) -> Estimate:
    """log10 of the mean passage time of ``mean_passage_time``, also where that exceeds every float.

    Arguments as there. Up to 1e300 cycles it is the logarithm of that time with its bound. Beyond, for
    ``WrappedNormal`` only: T at the node visited most is the mean length of an excursion from it over the chance of
    leaving in one, and T(start) is that times the chance of reaching that node first. The chance of leaving is
    eliminated, without subtraction, from transitions multiplied by h(y)/h(x), with h(x) nearly the chance of leaving
    from x before the next visit (Doob's transform): along the likely ways out they are of order one, however rare
    these are.

    ``error_bound`` beyond 1e300: three times the difference from a solution on other nodes and 2e-14 of ln T for
    rounding; measured, and without the map's ``max_error``.

    progress : called with the fraction done, at most, after each of up to five solutions: with the 6000 nodes that are
        allowed they take a minute each. An exception from it ends the work.

    Raises InvalidInput as ``mean_passage_time``, and beyond 1e300 cycles for other noise; ConvergenceError when the
    bound of ln T exceeds 1e-6, or two parts of the arc are each left less than once in 1e300 cycles.

    >>> stuck = CircleMap.arnold(0.1, 0.9)
    >>> round(log10_passage_time(stuck, WrappedNormal(0.028), 0.77, (-3.0, 2.37), lifted=True), 6)
    312.235583
    """
    tell = progress or (lambda fraction: None)
    time = mean_passage_time(circle_map, noise, start, arc, lifted=lifted)
    tell(0.2)
    if time < LONGEST:
        return Estimate(np.log10(time), time.error_bound / time / np.log(10.0))
    if not isinstance(noise, WrappedNormal):
        raise InvalidInput(f"the passage takes more than 1e300 cycles, and for {noise!r} no more is known")
    ends = arc_ends(arc, "arc", whole=lifted)
    inside = required_inside(start, ends)
    exits = line_exits(ends) if lifted else circle_exit(ends)
    for every_sample in (False, True):
        found = []
        for stretch in (1.0, _STRETCH):
            chain = killed_chain(circle_map, noise, (ends,), exits, lifted, every_sample=every_sample, stretch=stretch)
            found.append(_log_time(chain, noise, inside))
            tell(0.2 * len(found) + (0.6 if every_sample else 0.2))
        value, again = found
        bound = 3.0 * abs(value - again) + LOG_PASSAGE * abs(value)
        if bound <= _ACCEPTED:
            return Estimate(again / np.log(10.0), bound / np.log(10.0))
    raise ConvergenceError(f"ln of the mean passage time came out as {again:.9g} with error bound {bound:.3g}")


def _log_time(chain: KilledChain, noise: WrappedNormal, start: float) -> float:
    """ln T(start) for a long passage under normal noise."""
    elimination, order = chain.elimination, chain.elimination.order
    pivot = np.diag(elimination.packed)
    if not np.all(pivot[1:] > 0.0):
        raise ConvergenceError("two parts of the arc are each left less than once in 1e300 cycles: take a shorter arc")
    shares = -np.triu(elimination.packed, 1)
    excursion = _collected(shares, np.ones(order.size))
    moves = _log_transitions(chain, noise.sigma)[np.ix_(order, order)]
    moves[:, 0] = -np.inf  # excursions end on their return
    out = _log_departures(chain, noise.sigma)[order]
    log_h = _log_leaving(moves, out)
    tilted = np.exp(moves + log_h - log_h[:, None])
    _given_pivots(tilted, pivot)
    leaving = np.log(_collected(np.triu(tilted, 1), np.exp(out - log_h))) + log_h[0]
    first = chain.map(np.array([start]))
    step, left = chain.transitions(first)[0], float(np.sum(chain.departures(first)))
    home = step @ elimination.returns() / (step.sum() + left)
    return float(np.log(excursion) - leaving + np.log(home))


def _collected(shares: Array, reward: Array) -> float:
    """Mean reward of an excursion from the first state: its entry of (I - U)⁻¹ reward, U = ``shares``."""
    after = solve_triangular(np.eye(reward.size) - shares, reward, unit_diagonal=True, check_finite=False)
    return float(after[0])


def _given_pivots(work: Array, pivot: Array) -> None:
    """Eliminate with known pivots, in place: U stands above the diagonal afterwards."""
    for high in range(pivot.size, 0, -_BLOCK):
        low = max(0, high - _BLOCK)
        for k in range(high - 1, low - 1, -1):
            work[:k, k] /= pivot[k]
            work[:k, low:k] += np.multiply.outer(work[:k, k], work[k, low:k])
            work[low:k, :low] += np.multiply.outer(work[low:k, k], work[k, :low])
        work[:low, :low] += work[:low, low:high] @ work[low:high, :low]


def _log_leaving(moves: Array, out: Array) -> Array:
    """ln of the chance h of leaving before the next visit of the first state: h = out + K h, iterated from out."""
    value: Array = out
    for _ in range(_ROUNDS):
        terms = moves + value
        most = np.maximum(terms.max(axis=1), out)
        after = most + np.log(np.exp(terms - most[:, None]).sum(axis=1) + np.exp(out - most))
        change, value = float(np.max(after - value)), after
        if change < _SETTLED:
            return value
    raise ConvergenceError(
        f"the chance of leaving still grows by a factor {np.exp(change):.3g} a round: raise the noise"
    )


def _log_transitions(chain: KilledChain, sigma: float) -> Array:
    """(n, n): ln of the chances of going from node to node."""
    gap = chain.theta - chain.images[:, None]
    height = np.log(chain.weight / (sigma * np.sqrt(TWO_PI)))
    if chain.lifted:
        return np.asarray(height - 0.5 * (gap / sigma) ** 2)
    near = np.mod(gap, TWO_PI)
    return np.asarray(height + np.logaddexp.reduce([-0.5 * ((near + turn) / sigma) ** 2 for turn in _TURNS], axis=0))


def _log_departures(chain: KilledChain, sigma: float) -> Array:
    """(n,): ln of the chance of leaving at once."""
    start, end = chain.arcs[0]
    if chain.lifted:
        return np.asarray(
            np.logaddexp(log_ndtr((chain.images - end) / sigma), log_ndtr((start - chain.images) / sigma))
        )
    low = np.mod(end - chain.images, TWO_PI)
    exits = [_log_between((low + turn) / sigma, (low + turn + start + TWO_PI - end) / sigma) for turn in _TURNS]
    return np.asarray(np.logaddexp.reduce(exits, axis=0))


def _log_between(low: Array, high: Array) -> Array:
    """ln P(low < ξ < high) for standard normal ξ, without cancellation where it is small."""
    mirrored = low + high < 0.0
    near, far = np.where(mirrored, -high, low), np.where(mirrored, -low, high)
    most = log_ndtr(-near)
    return np.asarray(most + np.log1p(-np.exp(log_ndtr(-far) - most)))
