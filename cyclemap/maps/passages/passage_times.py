"""Mean passage times, hitting probabilities and survival of a noisy circle map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cyclemap.arrays import Array, Mask
from cyclemap.checks import finite_number, require_room, whole_number
from cyclemap.errors import ConvergenceError
from cyclemap.maps.estimate import ELIMINATION, SOLUTION, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise import Noise
from cyclemap.maps.operator.cells import Cells, cells_of
from cyclemap.maps.passages.killed_chain import (
    Arc,
    Passage,
    arc_ends,
    eliminated,
    into_arc,
    killed_chain,
)
from cyclemap.one_thread import one_thread

LONGEST = 1e300  # cycles: a longer passage is given as inf
_GOOD = 1e-9  # relative error bound with which few nodes will do
_ACCEPTED = 1e-6  # relative error bound that is accepted at all
_BESIDE = (
    0.01  # share of what the map's own error makes uncertain, below which more nodes are of no use
)
_MORE = 1.4  # bandwidth of the second attempt over that of the first
_CELLS = 256  # of the arcs together, and twice as many for the error
_LARGEST = 0.02  # relative error bound that is accepted on cells


@one_thread
def mean_passage_time(
    circle_map: CircleMap, noise: Noise, start: float, arc: Arc, *, lifted: bool = False
) -> Estimate:
    """Mean number of cycles until the path θ' = F(θ) + ξ from ``start`` is first outside ``arc``.

    Parameters
    ----------
    circle_map : CircleMap
        The map F.
    noise : Noise
        ξ, added after it.
    start : float
        Radians, inside the arc.
    arc : tuple[float, float]
        (start, end), counter-clockwise, radians, length in (0, 2π).
    lifted : bool, default False
        False counts positions mod 2π, so that a step of a whole turn comes back; True follows
        the path on the real line, where the arc may be a whole turn.

    Returns
    -------
    Estimate
        Cycles, with a bound.

    Raises
    ------
    ConvergenceError
        When the bound exceeds 1e-6 of the time, ``max_error`` apart.

    Notes
    -----
    T(x) = 1 + ∫_arc g(y - F(x)) T(y) dy, g the noise's density, on Gauss-Legendre nodes with panels
    between the map's breaks and samples (Nyström), is eliminated without subtraction from the
    exactly known chances of leaving (Grassmann, Taksar & Heyman 1985), so that even 1e100 cycles
    keep their digits; inf above 1e300, where ``log10_passage_time`` goes on. Under ``UniformNoise``
    the arcs are cut into cells, and the bound is measured.

    ``error_bound``: with r the residual of the interpolant on twice as many nodes, rounding
    included, Φ = (I - K)⁻¹|r| bounds the error, since K is positive (Collatz 1952): proved; r and Φ
    are measured on nodes. The map's ``max_error`` is included to first order. Where several deep
    wells drown the residual in rounding, the bound is ten times the difference from a solution on
    other nodes.

    References
    ----------
    Grassmann, W. K., Taksar, M. I. & Heyman, D. P. (1985), Regenerative analysis and steady state
    distributions for Markov chains, Operations Research 33.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CircleMap, WrappedNormal, mean_passage_time
    >>> stuck = CircleMap.arnold(0.1, 0.9)
    >>> time = mean_passage_time(stuck, WrappedNormal(0.1 * np.pi), 0.77278, (0.0, np.pi / 2))
    >>> round(time, 3), time.error_bound < 1e-9
    (44.624, True)
    """
    passage = Passage.out_of(circle_map, noise, arc, lifted)
    goals = np.zeros(len(passage.exits))
    return _collected(passage, passage.begun(start), 1.0, goals, "mean passage time")


@one_thread
def hitting_probability(
    circle_map: CircleMap, noise: Noise, start: float, arc_a: Arc, arc_b: Arc
) -> Estimate:
    """Probability that a noisy path is in one arc at an earlier cycle than in another.

    Parameters
    ----------
    circle_map : CircleMap
        The map F.
    noise : Noise
        ξ, added after it.
    start : float
        Radians; inside one of the arcs it gives 1 or 0.
    arc_a, arc_b : tuple[float, float]
        (start, end), counter-clockwise, radians; they must not overlap.

    Returns
    -------
    Estimate
        The chance that ``arc_a`` comes first, with a bound.

    Raises
    ------
    ConvergenceError
        As ``mean_passage_time``, and when neither arc is reached within 1e300 cycles.

    Notes
    -----
    u(x) = P(F(x) + ξ in a) + ∫ over the rest of g(y - F(x)) u(y) dy, solved and bounded as in
    ``mean_passage_time``: small chances keep their digits too.

    Examples
    --------
    >>> from cyclemap import CircleMap, WrappedNormal, hitting_probability
    >>> still, noise = CircleMap.rigid(0.0), WrappedNormal(0.3)
    >>> even = hitting_probability(still, noise, 0.0, (1.0, 2.0), (-2.0, -1.0))
    >>> round(even, 9), even.holds(0.5)
    (0.5, True)
    """
    arcs = arc_ends(arc_a, "arc_a"), arc_ends(arc_b, "arc_b")
    passage = Passage.between(circle_map, noise, *arcs)
    theta = finite_number("start", start)
    for ends, answer in zip(arcs, (1.0, 0.0), strict=True):
        if into_arc(theta, ends) is not None:
            return Estimate(answer, 0.0)
    chance = _collected(passage, theta, 0.0, np.array([1.0, 0.0]), "hitting probability")
    if not np.isfinite(chance):
        raise ConvergenceError(
            "neither arc is reached within 1e300 cycles: raise the noise or widen the arcs"
        )
    return Estimate(min(chance, 1.0), chance.error_bound)


def _collected(passage: Passage, start: float, each: float, at: Array, name: str) -> Estimate:
    """What a path collects on average until it leaves: ``each`` a cycle, ``at[e]`` by exit e.

    On few nodes first, on more where their bound is not good.
    """
    if passage.noise.jump > 0.0:
        return _collected_on_cells(passage, start, each, at)
    for every_sample, stretch in (False, 1.0), (True, _MORE):
        chain = killed_chain(passage, every_sample=every_sample, stretch=stretch)
        expected = chain.expected(each, at)
        if not abs(expected.top) < LONGEST:
            return Estimate(np.inf, np.inf)
        value = expected.value_at(start)
        own, from_map = expected.error_bounds(start)
        own += SOLUTION * abs(value)
        if own <= max(_GOOD * abs(value), min(_ACCEPTED * abs(value), _BESIDE * from_map)):
            return Estimate(value, own + from_map)
    other = killed_chain(passage).expected(each, at).value_at(start)
    own = min(own, 10.0 * abs(other - value) + ELIMINATION * abs(value))
    if not own <= _ACCEPTED * abs(value):
        raise ConvergenceError(
            f"the {name} came out as {value:.9g} with error bound {own:.3g}: the map is too rough "
            "for so small a noise; raise the noise or give the map's breaks"
        )
    return Estimate(value, own + from_map)


def _collected_on_cells(passage: Passage, start: float, each: float, at: Array) -> Estimate:
    """The same under noise whose density jumps.

    The arcs are cut into 512 cells, on each of which F is taken for straight; chances of going from
    cell to cell are exact then, and nothing is subtracted when the chain is eliminated.
    ``error_bound``: twice the difference from half as many cells, the error being of their second
    order, and what the map's ``max_error`` changes, to first order where every cell's image is off
    to its own side, or moved up and down by it; measured. inf where a part of the arcs that the
    path comes to is left by none of the cells' chances.

    Raises ConvergenceError where the bound, ``max_error`` apart, is above 2 %: where a passage
    hangs on a gap as narrow as a cell.
    """
    few, many = (_cells(passage, start, count) for count in (_CELLS, 2 * _CELLS))
    off = passage.map.max_error
    value, moved = _collected_by(many, passage, each, at, off)
    coarse, _ = _collected_by(few, passage, each, at)
    if np.isinf(value) and np.isinf(coarse):
        return Estimate(np.inf, 0.0)
    with np.errstate(invalid="ignore"):
        bound = 2.0 * abs(value - coarse) + SOLUTION * value
    if not bound <= max(_LARGEST * value, SOLUTION):
        raise ConvergenceError(
            f"the passage came out as {value:.6g} with error bound {bound:.2g}: it hangs on a gap "
            f"as narrow as a cell of the arcs; raise the width of {passage.noise!r} or take a "
            "noise with a smooth density"
        )
    if off > 0.0:
        above, below = (
            _collected_by(few.moved(shift), passage, each, at)[0] for shift in (off, -off)
        )
        bound += max(moved, abs(above - below))
    return Estimate(value, bound)


def _cells(passage: Passage, start: float, count: int) -> Cells:
    """``start``, as a cell without length, and ``count`` cells of the arcs."""
    cells = cells_of(passage.map, passage.noise.jump, passage.arcs, count)
    image = float(passage.map(start))
    return replace(
        cells,
        start=np.append(start, cells.start),
        end=np.append(start, cells.end),
        images=np.insert(cells.images, 0, image, axis=1),
    )


def _chances(cells: Cells, passage: Passage) -> tuple[Array, Array]:
    """(n, n): of going from cell to cell; (n, exits): of leaving by each exit."""
    starts, ends = np.array(passage.exits).T
    moves = cells.between(cells.start, cells.end, passage.lifted)
    return moves, cells.between(starts, ends, passage.lifted)


def _collected_by(
    cells: Cells, passage: Passage, each: float, at: Array, off: float = 0.0
) -> tuple[float, float]:
    """What a path from the first cell collects on average.

    And what that changes, to first order, where every image may be ``off`` by so much, each to its
    own side. Paths that can leave no more collect nothing further, or for ever where ``each`` is
    above 0.
    """
    moves, gone = _chances(cells, passage)
    leads = _grown(gone.sum(axis=1) > 0.0, moves.T > 0.0)
    visited = _grown(np.arange(leads.size) == 0, moves > 0.0)
    if not leads[0] or (each > 0.0 and np.any(visited & ~leads)):
        return (float("inf") if each > 0.0 else 0.0), 0.0
    kept = np.ix_(leads, leads)
    chain = eliminated(moves[kept], gone[leads].sum(axis=1) + moves[leads][:, ~leads].sum(axis=1))
    solved, _, _ = chain.expected(each + gone[leads] @ at)
    here = moves[kept] @ solved + gone[leads] @ at
    change = np.zeros_like(here)
    for shift in (-off, off) if off else ():
        there, gone_there = _chances(cells.moved(shift), passage)
        after = there[kept] @ solved + gone_there[leads] @ at
        change = np.maximum(change, np.abs(after - here))
    return float(solved[0]), float(chain.expected(change)[0][0])


def _grown(mask: Mask, leads: Mask) -> Mask:
    """All states that are reached from those of ``mask``, leads[i, j] saying that i leads to j."""
    while True:
        more = mask | np.any(leads[mask], axis=0)
        if np.array_equal(more, mask):
            return mask
        mask = more


@one_thread
def survival_probabilities(
    circle_map: CircleMap,
    noise: Noise,
    start: float,
    arc: Arc,
    cycles: int,
    *,
    lifted: bool = False,
) -> Array:
    """Chances that a noisy path has not left an arc after 0, 1, 2, ... cycles.

    Parameters
    ----------
    circle_map : CircleMap
        The map F.
    noise : Noise
        ξ, added after it.
    start : float
        Radians, inside the arc.
    arc : tuple[float, float]
        As of ``mean_passage_time``.
    cycles : int
        How many cycles.
    lifted : bool, default False
        As of ``mean_passage_time``.

    Returns
    -------
    ndarray, shape (cycles + 1,)
        S_0 = 1, S_1, ...

    Notes
    -----
    S_{n+1}(x) = ∫_arc g(y - F(x)) S_n(y) dy on Nyström's nodes; ``mean_passage_time`` is the sum of
    S_n over all n. Chances of going to the nodes and the exactly known ones of leaving are scaled
    to add up to 1; the relative error grows with n, by about 1e-15 a cycle, where S_n is above
    1e-12, and is below 1e-6 where it is smaller (measured).

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, WrappedNormal, survival_probabilities
    >>> stuck, noise = CircleMap.arnold(0.1, 0.9), WrappedNormal(0.3)
    >>> chances = survival_probabilities(stuck, noise, 0.77, (0.0, 1.5), 2)
    >>> bool(chances[0] == 1.0 and chances[0] > chances[1] > chances[2])
    True
    """
    count = whole_number("cycles", cycles, least=0)
    require_room("the chances", count, "give fewer cycles")
    passage = Passage.out_of(circle_map, noise, arc, lifted)
    chain = killed_chain(passage)
    images = np.append(chain.images, circle_map(passage.begun(start)))
    moves = chain.transitions(images)
    moves /= (chain.departures(images).sum(axis=0) + moves.sum(axis=1))[:, None]
    staying = np.ones(chain.theta.size)
    chances = np.ones(count + 1)
    for n in range(1, count + 1):
        after = moves @ staying
        staying = after[:-1]
        chances[n] = after[-1]
    return chances
