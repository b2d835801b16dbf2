"""Evidence that orientations lock in: that theta0 rests where it was, that visits gather over
many pushes, or that the first dozens keep to an arc of the circle.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, even_angles, shorter_way
from cyclemap.written import DIRECTION

CHANCE = 0.5  # a rest is where θ0 comes back more likely than not
_RATES = np.array([0.75, 0.9, 0.98])  # chances of coming back that are betted on, in equal shares
_PRESENT = 0.7  # weight of earlier directions, step by step, where the present one is told
_MEMORY = 0.95  # the same where the pull is fitted: rests creep
_STEPS_TOLD = 500  # what lies further back weighs less than 1e-11
_WANDER = math.radians(6.0)  # how far a rest may wander; the prior of its pull
_LEAST_PULL = 0.1  # of the distance a step; a weaker pull is not told from none within a rest
KERNEL = math.radians(12.0)  # standard deviation of the kernel of the law of visits
# The first harmonic left out weighs exp(-12.5), under 4e-6.
_HARMONICS = np.arange(1, math.ceil(5.0 / KERNEL) + 1)
_WEIGHTS = np.exp(-0.5 * (KERNEL * _HARMONICS) ** 2)
BLOCK = 48  # pushes that are shuffled together
ORDERS = 199  # other orders of a block that it is compared with
_REMEMBERED = 20.0  # blocks: older visits are forgotten, for surfaces wear
_PRIOR = 24.0  # pushes that the uniform law counts for
_FLOOR = 0.1  # share of the uniform law that is never given up
_POWERS = np.array([0.25, 1.0])  # how boldly the law learned is believed, in equal shares
_PEAK_KERNEL = math.radians(25.0)
CELLS = 36  # visits are counted in cells of ten degrees, arcs begin and end between them
# of a cell: the first push lies off the cells' ends, where rounding would move it to and fro
_OFFSET = 0.382
_WIDTHS = (6, 9, 12, 15, 18, 21, 24)  # of the arcs, in cells
# Pushes after which the orders are compared; all have the same weight.
CHECKS = (*range(14, 31, 2), 34, 40, 48)
_FEW, _MANY = 199, 19_999  # other orders: to see whether more are worth it, and what counts
_PROMISING = 20.0


@dataclass(frozen=True)
class RestRule:
    """What counts as a rest. A steady climb slower than 2 half_width / (window + 1) a push, 1.2°,
    lingers, too.

    half_width : rad, below π/4.
    window : how many pushes a rest must have lasted before it is betted on.
    longest_period : rests on cycles of up to this many directions are looked for.
    """

    half_width: float = math.radians(3.0)
    window: int = 4
    longest_period: int = 4


class SpreadStakes:
    """The wealth of fair bets, its stakes spread over the bet at which they begin (1/s(s + 1) on
    the s-th) and, in equal shares, over a few ways of betting.
    """

    def __init__(self, ways: int) -> None:
        self._log_stakes = np.full(ways, -np.inf)
        self._bets = 0

    def settle(self, log_factors: Array) -> None:
        """Multiply the stakes of each way (ways,) by what its bet came to, natural logarithms."""
        self._bets += 1
        new = -math.log(self._bets * (self._bets + 1))
        self._log_stakes = np.logaddexp(self._log_stakes, new) + log_factors

    @property
    def log_wealth(self) -> float:
        """Natural logarithm of what the stakes have become, and of what is still unspent."""
        staked = float(np.logaddexp.reduce(self._log_stakes)) - math.log(self._log_stakes.size)
        return float(np.logaddexp(staked, -math.log1p(self._bets)))


class RestEvidence:
    """A bet against the chance of coming back, whose gains are the evidence.

    For each period p up to ``rule.longest_period`` look at the ``window`` pushes p, 2p, ..., back.
    Where they lie close together (mean resultant length at least cos(half_width)) a bet is placed
    that θ0 comes within ``half_width`` of their mean direction. The bet is fair for a chance of ½:
    a hit multiplies the stake by 2r, a miss by 2(1 - r), for three rates r > ½. Stakes are spread
    over the rates, over the periods (in proportion to 1/p²) and over the bet at which the rest
    begins (1/s(s + 1) on the s-th).

    The wealth is a non-negative supermartingale that starts at 1 whenever, given the past, each
    betted chance is at most ½. So P(it ever exceeds c) ≤ 1/c, over a collection without end (Ville
    1939; testing by betting: Shafer 2021; Ramdas, Grünwald, Vovk & Shafer 2023).
    """

    def __init__(self, rule: RestRule, first: int = 0) -> None:
        """first : number of the first push that will be fed."""
        self.rule = rule
        self._first = first
        periods = np.arange(1, rule.longest_period + 1)
        self._shares = (1.0 / periods**2) / np.sum(1.0 / periods**2)
        self._stakes = [SpreadStakes(_RATES.size) for _ in periods]
        self._visits: list[complex] = []
        # Of each period the visit at which the rest under way began.
        self._began: list[int | None] = [None] * periods.size

    @property
    def log_evidence(self) -> float:
        """Natural logarithm of the wealth."""
        return float(np.logaddexp.reduce(self._log_wealth()))

    @property
    def rest(self) -> Rest | None:
        """The rest that θ0 is in just now, of the period with the most evidence; None where it is
        in none.
        """
        wealth = self._log_wealth()
        active = [index for index, began in enumerate(self._began) if began is not None]
        if not active:
            return None
        index = max(active, key=lambda index: float(wealth[index]))
        began = self._began[index]
        assert began is not None
        period = index + 1
        skipped = max((len(self._visits) - began) // period - _STEPS_TOLD, 0) * period
        visits = np.angle(self._visits[began + skipped :])
        settled = [settling(visits[place::period], _WANDER) for place in range(period)]
        present, limits = (np.mod(places, TWO_PI) % TWO_PI for places in zip(*settled, strict=True))
        return Rest(self._first + began, tuple(present.tolist()), tuple(limits.tolist()))

    def add(self, theta: float) -> None:
        """Take the next θ0 (rad, any number of turns): settle the bets on it."""
        point = complex(math.cos(theta), math.sin(theta))
        for index in range(self._shares.size):
            self._settle(index, point)
        self._visits.append(point)

    def _settle(self, index: int, point: complex) -> None:
        """Settle the bet on the period ``index + 1``, if one is placed."""
        reach = self.rule.window * (index + 1)
        back = self._visits[-reach :: index + 1]
        centre = sum(back) / self.rule.window
        if len(self._visits) < reach or abs(centre) < math.cos(self.rule.half_width):
            self._began[index] = None
            return
        hit = (point * centre.conjugate()).real >= abs(centre) * math.cos(self.rule.half_width)
        self._stakes[index].settle(np.log((_RATES if hit else 1.0 - _RATES) / CHANCE))
        if not hit:
            self._began[index] = None
        elif self._began[index] is None:
            self._began[index] = len(self._visits) - reach

    def _log_wealth(self) -> Array:
        """Per period, by its share."""
        return np.log(self._shares) + [stakes.log_wealth for stakes in self._stakes]


@dataclass(frozen=True)
class Rest:
    """Where θ0 rests, one direction for each push of the period.

    Attributes
    ----------
    began : int
        Push at which it began, counted from the first one fed, to within the window of the
        rule.
    directions : tuple of float
        Where it is by now, rad in [0, 2π).
    towards : tuple of float
        Where its last steps lead, rad in [0, 2π).

    Examples
    --------
    >>> from cyclemap.resets import watch
    >>> rest = watch([0.5] * 20)[-1].rest
    >>> rest.began, [round(direction, 3) for direction in rest.directions]
    (0, [0.5])
    """

    began: int
    directions: tuple[float, ...] = field(metadata=DIRECTION)
    towards: tuple[float, ...] = field(metadata=DIRECTION)


def settling(visits: Sequence[float] | Array, scatter: float) -> tuple[float, float]:
    """Return the present place of a path of visits, rad, n ≥ 2, and the limit of the linear law
    θ' = θ + s·(limit - θ) fitted to it, neither wrapped; steps are the shorter way round.

    The pull s is fitted by least squares, with a prior of no pull as strong as points spread over
    ``scatter`` (rad), and kept in [0.1, 1]. The path from the stable point of plywood's map is told
    to 3° (median) after twenty pushes under 1.1° of noise, where the place reached is still 5° off.

    >>> round(settling([1.0 + 0.5 * 0.8**step for step in range(30)], 0.1)[1], 2)
    1.0
    """
    steps = shorter_way(np.diff(visits))
    path = np.append(0.0, np.cumsum(steps))
    ago = np.arange(path.size)[::-1]
    present = (1.0 - _PRESENT) * _PRESENT**ago @ path
    weights = _MEMORY ** ago[1:]
    x, y = (weights @ values / weights.sum() for values in (path[:-1], steps))
    off = path[:-1] - x
    pull = -(weights @ (off * (steps - y))) / (weights @ off**2 + scatter**2)
    return float(visits[0] + present), float(visits[0] + x + y / min(max(pull, _LEAST_PULL), 1.0))


class VisitLaw:
    """The law of the visits so far: a Gaussian kernel estimate as a Fourier series, mixed with the
    uniform law.
    """

    def __init__(self) -> None:
        self._moments = np.zeros(_HARMONICS.size, dtype=np.complex128)
        # Those that are remembered, old ones counted less.
        self.visits = 0.0

    def add(self, theta: Array, kept: float = 1.0) -> None:
        """Take visits ``theta`` (n,) rad, after forgetting all but the share ``kept`` of the older
        ones.
        """
        waves = np.exp(-1j * np.multiply.outer(_HARMONICS, theta))
        self._moments = kept * self._moments + waves.sum(axis=1)
        self.visits = kept * self.visits + theta.size

    def ratio(self, theta: ArrayLike) -> Array:
        """The density at ``theta`` (rad, any shape) over that of the uniform law; at least about
        0.1.
        """
        point = np.exp(1j * np.asarray(theta, dtype=np.float64))
        series = polyval(point, np.append(0.0, _WEIGHTS * self._moments)).real
        learned = (_PRIOR + self.visits + 2.0 * series) / (_PRIOR + self.visits)
        return np.asarray(_FLOOR + (1.0 - _FLOOR) * np.maximum(learned, 0.0), dtype=np.float64)

    def peak(self) -> float:
        """Where the density is highest, rad in [0, 2π), under a kernel of 25° at least: narrower
        ones follow chance.
        """
        grid = even_angles(720)
        widest = np.exp(-0.5 * (_PEAK_KERNEL * _HARMONICS) ** 2)
        smoothed = np.append(0.0, np.minimum(_WEIGHTS, widest) * self._moments)
        return float(grid[np.argmax(polyval(np.exp(1j * grid), smoothed).real)])


class VisitEvidence:
    """Blocks of pushes, each set against its own turns in other orders.

    Where a reset has no bias, how far one cycle turns the object does not depend on where it stood:
    the turns of a block can be exchanged, and each order of them is as likely as the recorded one.
    A block's e-value is the likelihood of its visits under the law learned from the blocks before
    it, over the mean of that likelihood over the recorded order and ``orders`` random ones. Its
    mean is 1 for any law of the turns, known or not, narrow or wide, constant or worn from block to
    block. The product over blocks, stakes spread over the block at which the gathering begins
    (1/s(s + 1) on the s-th) and over two powers of the likelihood, is a martingale that starts at
    1, and P(it ever exceeds c) ≤ 1/c (Ville 1939). Shuffling within blocks as an e-value: compare
    Grünwald, de Heide & Koolen 2024; e-values: Vovk & Wang 2021.
    """

    def __init__(self, block: int = BLOCK, orders: int = ORDERS, seed: int = 0) -> None:
        self._block = block
        self._orders = orders
        self._random = np.random.default_rng(seed)
        self.law = VisitLaw()
        self._waiting: list[float] = []
        self._stakes = SpreadStakes(_POWERS.size)

    @property
    def log_evidence(self) -> float:
        """Natural logarithm of the wealth; it changes where a block is full."""
        return self._stakes.log_wealth

    def add(self, theta: float) -> None:
        """Take the next θ0 (rad, any number of turns)."""
        self._waiting.append(theta)
        if len(self._waiting) > self._block:
            path = np.array(self._waiting)
            if self.law.visits > 0.0:
                # The visits of the recorded order, then of others.
                turns = np.tile(np.diff(path), (self._orders + 1, 1))
                turns[1:] = self._random.permuted(turns[1:], axis=1)
                likelihoods = np.log(self.law.ratio(path[0] + np.cumsum(turns, axis=1))).sum(axis=1)
                raised = np.multiply.outer(_POWERS, likelihoods)
                log_mean = np.logaddexp.reduce(raised, axis=1) - math.log(raised.shape[1])
                self._stakes.settle(raised[:, 0] - log_mean)
            self.law.add(path[1:], kept=math.exp(-1.0 / _REMEMBERED))
            # The last visit of a block is where the next one starts.
            self._waiting = self._waiting[-1:]

    def peak(self) -> float:
        """The direction most visited, rad in [0, 2π); the block under way counts too."""
        law = copy.copy(self.law)
        law.add(np.array(self._waiting[1:] if self.law.visits > 0.0 else self._waiting))
        return law.peak()


class ArcEvidence:
    """All pushes so far set against their own turns in other orders, at a few early times.

    Where a reset has no bias its turns t_1, ..., t_n are exchangeable: the path from the first θ0
    with the turns in another order is as likely as the recorded one. Let L(path) be the likelihood
    of its visits where they spread evenly over an arc, all of them on it, against chance, mixed
    over arcs (60 to 240 degrees, beginning anywhere), and

        E_n = L(recorded) / mean of L over the recorded order and N orders drawn at random.

    Recorded and drawn orders are exchangeable, so the mean of E_n is 1 whatever the law of the
    turns (0 for 0 / 0 only lessens it). A climb that never turns back, by turns of less than 120
    degrees, cannot leap over what an arc leaves out, and lies between its first and its last θ0 in
    every order: its E_n is 1 at most, however slow it is and however its turns depend on θ0, as
    those of the mechanics do. A collection that keeps to half a circle with turns
    that would carry it off in most other orders has an E_n near N + 1. A single visit elsewhere
    ends it; what gathers more loosely, blocks of pushes tell (`VisitEvidence`).

    Theorem: with weights w_n of sum 1, S_n = sum of w_k E_k over the times k up to n never exceeds
    c, at any n, but with probability 1/c. Proof: S_n grows with n, and the mean of its limit is at
    most 1 (Markov). Its conditional means E[S_∞ | n pushes] ≥ S_n are a martingale that starts at 1
    or less, so S shared with another martingale obeys Ville's inequality (1939). An E_n that is not
    looked at counts as 0, which only lessens the mean: where 199 orders promise little the 19,999
    are not drawn. E-values and their means: Vovk & Wang 2021.

    >>> evidence = ArcEvidence()
    >>> for theta in np.random.default_rng(1).uniform(0.0, math.pi, 31).tolist():
    ...     evidence.add(theta)
    >>> evidence.log_evidence > math.log(400.0)
    True
    """

    def __init__(self, seed: int = 0) -> None:
        self._random = np.random.default_rng([seed, 1])
        self._path: list[float] = []
        self._sum = 0.0

    @property
    def log_evidence(self) -> float:
        """Natural logarithm of S; minus infinity while nothing was seen."""
        return math.log(self._sum) if self._sum > 0.0 else -math.inf

    def add(self, theta: float) -> None:
        """Take the next θ0 (rad, any number of turns)."""
        if len(self._path) > CHECKS[-1]:
            return
        self._path.append(theta)
        if len(self._path) - 1 in CHECKS:
            turns = np.diff(self._path)
            if self._e_value(turns, _FEW) >= _PROMISING:
                self._sum += self._e_value(turns, _MANY) / len(CHECKS)

    def _e_value(self, turns: Array, orders: int) -> float:
        """E of the recorded turns among so many other orders."""
        paths = np.tile(turns, (orders + 1, 1))
        paths[1:] = self._random.permuted(paths[1:], axis=1)
        likelihoods = arc_likelihoods(np.cumsum(paths, axis=1))
        return float(likelihoods[0] / np.mean(likelihoods)) if likelihoods[0] > 0.0 else 0.0


def arc_likelihoods(paths: Array) -> Array:
    """Return the likelihood of the visits of each path (n, m), rad from its start, mixed over arcs;
    of chance: 1.
    """
    # The start is a visit, too.
    visits = np.insert(paths, 0, 0.0, axis=1)
    cells = np.sort(np.floor(visits * (CELLS / TWO_PI) + _OFFSET).astype(np.int64) % CELLS, axis=1)
    empty = np.diff(cells, axis=1, append=cells[:, :1] + CELLS) - 1
    total = np.zeros(len(paths))
    for width in _WIDTHS:
        # What an arc leaves out lies in one stretch of empty cells: in so many places.
        arcs = np.maximum(empty - (CELLS - width) + 1, 0).sum(axis=1)
        total += (CELLS / width) ** visits.shape[1] * arcs
    return total / (CELLS * len(_WIDTHS))
