"""The quasi-stationary distribution of an arc: where a path is that has not left it, how soon and
where it does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import finite_array
from cyclemap.errors import ConvergenceError
from cyclemap.maps.estimate import ELIMINATION, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise import Noise
from cyclemap.maps.passages.killed_chain import Arc, KilledChain, Passage, killed_chain, visits
from cyclemap.one_thread import one_thread

_OTHER = 1.4  # bandwidth of the second solution over that of the first
_APART = 10.0  # times the difference of the two: the bound
_ROUNDS = 5_000
_SETTLED = 1e-13  # relative difference of every node's chances that ends them
_NOTHING = 1e-290  # chances that are none
_ACCEPTED = 1e-6  # relative error bound of the escape rate, ``max_error`` apart


@dataclass(frozen=True, eq=False)
class QuasiStationary:
    """What becomes of a noisy path as long as it stays in an arc, however it began; made by
    ``quasi_stationary``.

    Attributes
    ----------
    escape_rate : Estimate
        Chance a cycle of leaving, 1 - λ; the path stays 1/escape_rate cycles on average.
    below, above : Estimate
        The chances of leaving past the arc's start and past its end.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, WrappedNormal, quasi_stationary
    >>> held = quasi_stationary(CircleMap.rigid(0.0), WrappedNormal(0.3), (-1.0, 1.0))
    >>> held.below.holds(0.5), bool(held.density(0.0) > held.density(0.9))
    (True, True)
    """

    escape_rate: Estimate
    below: Estimate
    above: Estimate
    _chain: KilledChain = field(repr=False)
    _mass: Array = field(repr=False)

    def density(self, theta: ArrayLike) -> Array:
        """The distribution's density, per radian, at angles of the arc, any shape: one cycle on
        from its nodes.
        """
        angles = finite_array("theta", theta)
        passage = self._chain.passage
        gaps = angles.ravel() - self._chain.images[:, None]
        density = self._mass @ passage.noise.density(gaps, lifted=True) / (1.0 - self.escape_rate)
        low, high = passage.arcs[0]
        return np.where((angles >= low) & (angles <= high), density.reshape(angles.shape), 0.0)


@one_thread
def quasi_stationary(circle_map: CircleMap, noise: Noise, arc: Arc) -> QuasiStationary:
    """Where a noisy path is given that it has not left an arc for long, and how it leaves.

    Parameters
    ----------
    circle_map : CircleMap
        The map F.
    noise : Noise
        ξ, added after it; the path is on the line.
    arc : tuple[float, float]
        (start, end), counter-clockwise, radians, length in (0, 2π].

    Returns
    -------
    QuasiStationary
        ``escape_rate`` 1 - λ with λ the largest eigenvalue of the chain that is killed outside
        the arc, ``below`` and ``above`` the chances of slipping out to either side, the
        ``density``.

    Raises
    ------
    InvalidInput
        As ``mean_passage_time``.
    ConvergenceError
        Where the rate is not known to 1e-6 of itself, is nearly the same from several parts of the
        arc, or is below every float.

    Notes
    -----
    ν K = λ ν by inverse iteration on Nyström's nodes, (I - K)⁻¹ by elimination without subtraction:
    sums of positive terms, so that small chances keep their digits, and 1 - λ is ν's chance of
    leaving in a cycle, never a difference. ``error_bound``: ten times the difference from other
    nodes, measured, and what the map's ``max_error`` ε may change: to first order ε ∫ν|∂/∂F| of the
    chance of leaving and of w(F + ξ), w the solution of (λ - K) w = chance of leaving - mean; and
    how far from that maps change it that are off by ±ε, as a whole and with the signs of ∂/∂F
    (measured).

    References
    ----------
    Collet, P., Martínez, S. & San Martín, J. (2013), Quasi-stationary distributions.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, WrappedNormal, quasi_stationary
    >>> slips = quasi_stationary(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.3), (-0.8, 2.37))
    >>> round(1.0 / slips.escape_rate, 3), slips.above > 0.999
    (3575.286, True)
    """
    passage = Passage.out_of(circle_map, noise, arc, lifted=True)
    chain = killed_chain(passage, every_sample=False, stretch=_OTHER)
    other = killed_chain(passage)
    mass, rates = _lasting(chain, chain.images)
    total = float(rates.sum())
    others = _lasting(other, other.images)[1]
    own = _APART * abs(float(others.sum()) - total) + ELIMINATION * total
    if not own <= _ACCEPTED * total:
        raise ConvergenceError(
            f"the escape rate came out as {total:.9g} with error bound {own:.3g}: the map is too "
            "rough for so small a noise; raise the noise or give the map's breaks"
        )
    shares = rates / total
    share_error = _APART * float(np.abs(others / others.sum() - shares).max()) + ELIMINATION
    of_rate, of_share = (
        _moved_by_map(chain, mass, rates) if circle_map.max_error > 0.0 else (0.0, 0.0)
    )
    below, above = (Estimate(float(share), share_error + of_share) for share in shares)
    return QuasiStationary(Estimate(total, own + of_rate), below, above, chain, mass)


def _moved_by_map(chain: KilledChain, mass: Array, rates: Array) -> tuple[float, float]:
    """How much the escape rate and the shares of the exits may change by the map's
    ``max_error``."""
    epsilon = chain.passage.map.max_error
    total = rates.sum()
    slopes = _slopes(chain, mass, rates)
    shares = rates / total

    def change(slope: Array, quantity: Callable[[Array], Array]) -> float:
        """To first order, and how far from that maps lead that are off by ±ε, with the signs of
        ``slope`` or as a whole.
        """
        beyond = []
        for signs in (np.sign(slope), np.ones_like(slope)):
            for shift in (-epsilon * signs, epsilon * signs):
                moved = quantity(_lasting(chain, chain.images + shift)[1]) - quantity(rates)
                beyond.append(float(np.max(np.abs(np.abs(moved) - abs(mass @ (shift * slope))))))
        return epsilon * float(mass @ np.abs(slope)) + max(beyond)

    of_rate = change(slopes.sum(axis=0), lambda after: after.sum(keepdims=True))
    of_share = change(
        (slopes[0] * shares[1] - slopes[1] * shares[0]) / total,
        lambda after: after / after.sum(),
    )
    return of_rate, of_share


def _lasting(chain: KilledChain, images: Array) -> tuple[Array, Array]:
    """The quasi-stationary chances of the nodes, (n,), and those of leaving in a cycle by each
    exit; F at the nodes.

    By inverse iteration: of all eigenvalues λ of the chain the largest one is the nearest to 1.
    From two random laws, which agree in the end: a law that changes little may be far from it yet.
    """
    gone = chain.departures(images)
    with np.errstate(all="ignore"):
        runs = visits(chain.transitions(images), gone.sum(axis=0))
    if not np.all(np.isfinite(runs)):
        raise ConvergenceError(
            "the path stays longer than any number says: take a shorter arc, or raise the noise"
        )
    laws = np.random.default_rng(1).uniform(size=(2, chain.theta.size))
    for _ in range(_ROUNDS):
        laws = laws @ runs
        laws /= laws.sum(axis=1, keepdims=True)
        mass, other = laws
        if np.all(np.abs(mass - other) <= _SETTLED * mass + _NOTHING):
            return mass, gone @ mass
    raise ConvergenceError(
        "the escape rate is nearly the same from several parts of the arc: take a shorter arc"
    )


def _slopes(chain: KilledChain, mass: Array, rates: Array) -> Array:
    """(exits, n): how fast each exit's rate grows with F at the nodes, per unit of ν."""
    moves = chain.transitions(chain.images)
    gone = chain.departures(chain.images)
    # (λ - K) w = gone - rate·u with ν w = 0, u the right eigenvector: bordered, so that it is
    # regular.
    size = mass.size
    bordered = np.zeros((size + 1, size + 1))
    bordered[:size, :size] = (1.0 - rates.sum()) * np.eye(size) - moves
    bordered[:size, size] = 1.0
    bordered[size, :size] = mass
    later = np.linalg.solve(bordered, np.append(gone, np.zeros((rates.size, 1)), axis=1).T)[:size]
    # But for its value at the most visited node, which moves with the chance of staying.
    level = later[np.argmax(mass)]
    leaving = chain.departure_slopes(chain.images)
    pushed = chain.pushes(chain.images, later - level).T
    return np.asarray(leaving + pushed - np.multiply.outer(level, leaving.sum(axis=0)))
