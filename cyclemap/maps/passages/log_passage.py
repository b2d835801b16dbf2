"""Mean passage times too long for a float, by their logarithm."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array
from scipy.special import log_ndtr

from cyclemap.arrays import TWO_PI, Array, Whole
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import LOG_PASSAGE, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise import Noise, WrappedNormal, reduced
from cyclemap.maps.passages.killed_chain import (
    MAX_UNKNOWNS,
    Arc,
    KilledChain,
    Passage,
    killed_chain,
)
from cyclemap.maps.passages.passage_times import LONGEST, mean_passage_time
from cyclemap.one_thread import one_thread

_STRETCH = 1.3  # bandwidth of the second solution over that of the first
_MOST_NODES = 60_000
# nodes that are solved without a wider noise first, and whose plain passage time is sought first
_FEW = 1_000
_CUT = 45.0  # moves below e^-45 of the largest one of their node are left out
_BLOCK = 16  # neighbouring nodes that are left out together
_ENTRIES = 4_000_000
_SWEEPS = 4_000
_STEADY = 1e-13  # relative change a sweep that ends it
_ROUNDS = 5_000  # of the iteration for h
_SETTLED = 1.0  # change of ln h a round that ends it: h need not be exact
_TURNS = TWO_PI * np.arange(-2.0, 2.0)  # images of a gap in [0, 2π) that may count
_ACCEPTED = 1e-6  # error bound of ln T that is accepted at all


@one_thread
def log10_passage_time(
    circle_map: CircleMap,
    noise: Noise,
    start: float,
    arc: Arc,
    *,
    lifted: bool = False,
) -> Estimate:
    """log10 of the mean passage time of ``mean_passage_time``, also where that exceeds every float.

    Parameters
    ----------
    circle_map : CircleMap
        As of ``mean_passage_time``.
    noise : Noise
        As of ``mean_passage_time``; beyond 1e300 cycles a ``WrappedNormal``.
    start : float
        Radians, inside the arc.
    arc : tuple[float, float]
        (start, end), counter-clockwise, radians.
    lifted : bool, default False
        As of ``mean_passage_time``.

    Returns
    -------
    Estimate
        log10 of the mean number of cycles.

    Raises
    ------
    InvalidInput
        As ``mean_passage_time``, and beyond 1e300 cycles for other noise or where more than
        60,000 nodes are needed.
    ConvergenceError
        When the bound of ln T exceeds 1e-6, or the path may stay in several parts of the arc for
        thousands of cycles.

    Notes
    -----
    Up to 1e300 cycles it is the logarithm of that time with its bound. Beyond, for
    ``WrappedNormal`` only: T at the node visited most is the mean length of an excursion from it
    over the chance of leaving in one, and T(start) is that times the chance of reaching that node
    first. The chance of leaving is sought from transitions multiplied by h(y)/h(x), h(x) nearly the
    chance of leaving from x before the next visit (Doob's transform): along the likely ways out
    they are of order one. Sparse sweeps over the few dozen moves that count solve it; a first h
    comes from twice as wide a noise, where σ² ln h is nearly the same (large deviations).

    ``error_bound`` beyond 1e300: three times the difference from a solution on other nodes and
    2e-14 of ln T for rounding; measured, and without the map's ``max_error``.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, WrappedNormal, log10_passage_time
    >>> stuck = CircleMap.arnold(0.1, 0.9)
    >>> round(log10_passage_time(stuck, WrappedNormal(0.028), 0.77, (-3.0, 2.37), lifted=True), 6)
    312.235583
    """
    passage = Passage.out_of(circle_map, noise, arc, lifted)
    inside = passage.begun(start)
    if noise.sigma is None or not _is_endless(_chain(passage, False), inside):
        time = mean_passage_time(circle_map, noise, start, arc, lifted=lifted)
        if time < LONGEST:
            return Estimate(np.log10(time), time.error_bound / time / np.log(10.0))
        if noise.sigma is None:
            raise InvalidInput(
                f"the passage takes more than 1e300 cycles, and for {noise!r} no more is known"
            )
    for every_sample in (False, True):
        value, again = (
            _log_time(_chain(passage, every_sample, stretch), inside) for stretch in (1.0, _STRETCH)
        )
        bound = 3.0 * abs(value - again) + LOG_PASSAGE * abs(value)
        if bound <= _ACCEPTED:
            return Estimate(again / np.log(10.0), bound / np.log(10.0))
    raise ConvergenceError(
        f"ln of the mean passage time came out as {again:.9g} with error bound {bound:.3g}"
    )


def _chain(passage: Passage, every_sample: bool, stretch: float = 1.0) -> KilledChain:
    return killed_chain(passage, every_sample=every_sample, stretch=stretch, most=_MOST_NODES)


def _is_endless(chain: KilledChain, start: float) -> bool:
    """Whether the passage is longer than a float holds, as far as that need not be tried first."""
    return chain.theta.size > _FEW and _log_time(chain, start) >= np.log(LONGEST)


def _log_time(chain: KilledChain, start: float) -> float:
    """ln T(start) for a long passage under normal noise."""
    out = _log_departures(chain)
    size = chain.theta.size
    chances = _moves(chain, np.zeros(size), out)
    mass = np.ones(size)
    for _ in range(64):
        mass = mass @ chances
        mass /= max(mass.sum(), np.finfo(float).tiny)
    first = int(np.argmax(mass))
    away = _without(chances, first)
    excursion = _fixed(away, np.ones(size))
    returns = _fixed(away, chances[:, [first]].toarray().ravel())
    returns[first] = 1.0
    log_h = _log_chance(chain, first, out)
    return float(np.log(excursion[first]) - log_h[first] + np.log(_reaching(chain, start, returns)))


def _log_chance(chain: KilledChain, first: int, out: Array) -> Array:
    """ln h, h the chance of leaving before the next visit of node ``first``."""
    wider = chain
    if chain.theta.size > _FEW:
        noise = WrappedNormal(2.0 * _sigma(chain))
        wider = _chain(replace(chain.passage, noise=noise), chain.every_sample)
    if wider.theta.size < chain.theta.size:
        at = int(np.argmin(np.abs(wider.theta - chain.theta[first])))
        coarse = _log_chance(wider, at, _log_departures(wider))
        log_h = np.interp(chain.theta, wider.theta, 4.0 * coarse)
    else:  # few nodes, or as coarse as the map allows
        log_h = _log_leaving(chain, first, out)
    for _ in range(2):  # the second time with the moves that count for h itself
        tilted = _without(_moves(chain, log_h, out), first)
        log_h = log_h + np.log(_fixed(tilted, np.exp(out - log_h)))
    return log_h


def _fixed(moves: csr_array, source: Array) -> Array:
    """x = source + moves x by iteration, all >= 0."""
    x = np.ones_like(source)
    for _ in range(_SWEEPS):
        after = source + moves @ x
        if np.all(np.abs(after - x) <= _STEADY * after):
            return np.asarray(after)
        x = after
    raise ConvergenceError(
        "the path stays for thousands of cycles in several parts of the arc: take a shorter arc, "
        "or raise the noise"
    )


def _without(moves: csr_array, column: int) -> csr_array:
    return moves.multiply(np.arange(moves.shape[1]) != column).tocsr()


def _moves(chain: KilledChain, log_h: Array, out: Array) -> csr_array:
    """(n, n), sparse: chances times h(y)/h(x), of the moves that count."""
    row, column, term = _terms(chain, log_h, out)
    return csr_array((np.exp(term - log_h[row]), (row, column)), shape=(out.size, out.size))


def _terms(chain: KilledChain, log_h: Array, out: Array) -> tuple[Whole, Whole, Array]:
    """From where, to where, and ln of chance times h(y): but for those below e^-45 of the largest
    term of out + K h at x.

    Blocks of neighbouring nodes are ruled out together, by their largest h and their smallest
    distance.
    """
    theta = chain.theta
    size = theta.size
    sigma = _sigma(chain)
    value = log_h + np.log(chain.weight / (sigma * np.sqrt(TWO_PI)))
    begin = np.arange(0, size, _BLOCK)
    last = np.minimum(begin + _BLOCK, size) - 1
    middle = 0.5 * (theta[begin] + theta[last])
    half = 0.5 * (theta[last] - theta[begin])
    best = np.minimum(begin + _BLOCK // 2, last)
    top = np.maximum.reduceat(value, begin)
    kept = []
    step = max(1, _ENTRIES // begin.size)
    for at in range(0, size, step):
        image = chain.images[at : at + step, None]
        sure = value[best] - 0.5 * (_distance(chain, theta[best] - image) / sigma) ** 2
        least = np.maximum(sure.max(axis=1), out[at : at + step]) - _CUT
        nearest = np.maximum(_distance(chain, middle - image) - half, 0.0)
        row, block = np.nonzero(top - 0.5 * (nearest / sigma) ** 2 > least[:, None])
        column = (begin[block, None] + np.arange(_BLOCK)).ravel()
        row = np.repeat(row, _BLOCK)[column < size]
        column = column[column < size]
        near = _distance(chain, theta[column] - image[row, 0])
        term = value[column] - 0.5 * (near / sigma) ** 2
        if not chain.passage.lifted:  # from the two nearest images
            term = np.logaddexp(term, value[column] - 0.5 * ((TWO_PI - near) / sigma) ** 2)
        counts = term > least[row]
        kept.append((at + row[counts], column[counts], term[counts]))
    row, column, term = map(np.concatenate, zip(*kept, strict=True))
    return row, column, term


def _sigma(chain: KilledChain) -> float:
    return math.sqrt(chain.passage.noise.variance)


def _distance(chain: KilledChain, gap: Array) -> Array:
    """How far a noise must carry the path over a gap, at least: the shorter way where it is on the
    circle.
    """
    return np.abs(gap if chain.passage.lifted else reduced(gap))


def _reaching(chain: KilledChain, start: float, returns: Array) -> float:
    """The chance that the path from ``start`` visits the first state before it leaves."""
    image = chain.passage.map(np.array([start]))
    step = chain.transitions(image)[0]
    left = float(np.sum(chain.departures(image)))
    return float(step @ returns / (step.sum() + left))


def _log_leaving(chain: KilledChain, first: int, out: Array) -> Array:
    """Nearly ln h, h as of ``_log_chance``, by all moves: h = out + K h, iterated from out."""
    if out.size > MAX_UNKNOWNS:
        raise ConvergenceError(
            f"the map is too fine for {out.size} nodes: raise the noise, or smooth the map"
        )
    value = out
    for _ in range(_ROUNDS):
        row, column, term = _terms(chain, value, out)
        elsewhere = column != first
        after = out.copy()
        np.logaddexp.at(after, row[elsewhere], term[elsewhere])
        change = float(np.max(after - value))
        value = after
        if change < _SETTLED:
            return value
    raise ConvergenceError(
        f"the chance of leaving still grows by a factor {np.exp(change):.3g} a round: raise the "
        "noise"
    )


def _log_departures(chain: KilledChain) -> Array:
    """(n,): ln of the chance of leaving at once."""
    start, end = chain.passage.arcs[0]
    sigma = _sigma(chain)
    if chain.passage.lifted:
        return np.asarray(
            np.logaddexp(
                log_ndtr((chain.images - end) / sigma), log_ndtr((start - chain.images) / sigma)
            )
        )
    low = np.mod(end - chain.images, TWO_PI) + _TURNS[:, None]
    high = low + start + TWO_PI - end
    # P(low < ξ < high) for each turn, without cancellation where it is small.
    mirrored = low + high < 0.0
    near = np.where(mirrored, -high, low)
    far = np.where(mirrored, -low, high)
    most = log_ndtr(-near / sigma)
    return np.asarray(
        np.logaddexp.reduce(most + np.log1p(-np.exp(log_ndtr(-far / sigma) - most)), axis=0)
    )
