"""A noisy map killed when it leaves some arcs: its chain on quadrature nodes (Nyström), solved
without subtraction; and the quasi-stationary distribution of an arc: where a path is that has not
left it, how soon and where it does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, Whole
from cyclemap.checks import finite_array, finite_number, point
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import ANGLE, ELIMINATION, EPS, SAME_ANGLE, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap, require_map
from cyclemap.maps.noise import Noise, require_noise
from cyclemap.maps.quadrature import Rule, arc_rule
from cyclemap.one_thread import one_thread

Arc = tuple[float, float]
_OTHER = 1.4  # bandwidth of the second solution over that of the first
_APART = 10.0  # times the difference of the two: the bound
_ROUNDS = 5_000
_SETTLED = 1e-13  # relative difference of every node's chances that ends them
_NOTHING = 1e-290  # chances that are none
_ACCEPTED = 1e-6  # relative error bound of the escape rate, ``max_error`` apart


def arc_ends(arc: Arc, name: str, whole: bool = False) -> Arc:
    """An arc (start, end), counter-clockwise, as floats with start < end; length in (0, 2π), or (0,
    2π].
    """
    start, end = point(name, arc)
    after = end + TWO_PI if -TWO_PI < end - start < 0.0 else end
    longest = TWO_PI * (1.0 + 2e-15) if whole else TWO_PI
    if not 0.0 < after - start < longest:
        raise InvalidInput(
            f"{name} is ({start:g}, {end:g}): its length must lie between 0 and 2π radians"
        )
    return start, after


def into_arc(theta: float, arc: Arc) -> float | None:
    """The representative of ``theta`` (mod 2π) inside the closed arc, or None."""
    inside = arc[0] + float(np.mod(theta - arc[0], TWO_PI))
    if inside - TWO_PI > arc[0] - ANGLE:
        return arc[0]
    return min(inside, arc[1]) if inside <= arc[1] + ANGLE else None


@dataclass(frozen=True, eq=False)
class Passage:
    """A path θ' = F(θ) + ξ as long as it stays in ``arcs``; it ends in one of ``exits``, and both
    together fill the space.

    lifted : the space is the real line, where an exit reaches to ±inf; else the circle.
    """

    map: CircleMap
    noise: Noise
    arcs: tuple[Arc, ...]
    exits: tuple[Arc, ...]
    lifted: bool

    def __post_init__(self) -> None:
        require_map(self.map)
        require_noise(self.noise)

    @classmethod
    def out_of(cls, circle_map: CircleMap, noise: Noise, arc: Arc, lifted: bool) -> Passage:
        """The passage out of one arc: into the rest of the circle, or below or above it on the
        line.
        """
        start, end = arc_ends(arc, "arc", whole=lifted)
        exits = ((-np.inf, start), (end, np.inf)) if lifted else ((end, start + TWO_PI),)
        return cls(circle_map, noise, ((start, end),), exits, lifted)

    @classmethod
    def between(cls, circle_map: CircleMap, noise: Noise, a: Arc, b: Arc) -> Passage:
        """The passage on the circle into one of two disjoint arcs, in this order the exits."""
        begin = a[1] + float(np.mod(b[0] - a[1], TWO_PI))
        finish = begin + (b[1] - b[0])
        if begin > a[0] + TWO_PI or finish > a[0] + TWO_PI + SAME_ANGLE:
            raise InvalidInput(f"arc_a {a} and arc_b {b} overlap: give disjoint arcs")
        rest = (a[1], begin), (finish, a[0] + TWO_PI)
        arcs = tuple(ends for ends in rest if ends[1] - ends[0] > SAME_ANGLE)
        return cls(circle_map, noise, arcs, (a, b), False)

    def begun(self, start: float) -> float:
        """``start``, moved by whole turns into the arc; InvalidInput where it lies outside."""
        low, high = self.arcs[0]
        inside = into_arc(finite_number("start", start), self.arcs[0])
        if inside is None:
            raise InvalidInput(
                f"start is {start:g}, outside the arc ({low:g}, {high:g}): start inside it"
            )
        return inside


_VISITS = 64  # cycles after which the states are ranked by how often they are visited


@dataclass(frozen=True, eq=False)
class Elimination:
    """A chain as its excursions from the state that it visits most; ``order`` puts that one first.

    Of the other states: ``within``, (n - 1, n - 1), how often each is visited from each before an
    excursion ends; ``back`` and ``gone``, (n - 1,), the chances that it ends at the first state and
    that the path leaves. Of the first: ``ahead``, (n - 1,), the chances of going to the others, and
    ``leaving``, that of leaving before it is visited again.
    """

    order: Whole
    within: Array
    back: Array
    gone: Array
    ahead: Array
    leaving: float

    def expected(self, reward: Array) -> tuple[Array, Array, Array]:
        """x = (I - q)⁻¹ reward, what is collected on average until the path leaves, (n,) or (n,
        columns); x at the most visited state; and its differences from that, with their own digits.
        """
        first = self.order[0]
        others = self.order[1:]
        values = np.empty_like(reward)
        change = np.zeros_like(reward)
        with np.errstate(all="ignore"):
            collected = self.within @ reward[others]
            top = np.asarray((reward[first] + self.ahead @ collected) / self.leaving)
            values[others] = collected + np.multiply.outer(self.back, top)
            change[others] = collected - np.multiply.outer(self.gone, top)
        values[first] = top
        return values, top, change


def eliminated(q: Array, out: Array) -> Elimination:
    """Grassmann-Taksar-Heyman elimination (1985): without a difference, so small chances keep their
    digits.

    q : (n, n) chances of going from i to j (the diagonal is not used); out : (n,) of leaving. Every
        entry of what it solves has a small relative error whatever the sizes (O'Cinneide 1993).
    """
    # In falling order of visits: each state that is eliminated then has a fair chance to go to one
    # that is not.
    mass = np.full(out.size, 1.0 / out.size)
    for _ in range(_VISITS):
        mass = mass @ q
        mass /= max(mass.sum(), np.finfo(float).tiny)
    order = np.argsort(-mass, kind="stable")
    moves = q[np.ix_(order, order)]
    leaving = out[order]
    # Numbers beyond all floats are said to be inf by who reads them.
    with np.errstate(all="ignore"):
        within = visits(moves[1:, 1:], leaving[1:] + moves[1:, 0])
        gone = within @ leaving[1:]
        ahead = moves[0, 1:]
        first = float(leaving[0] + ahead @ gone)
        return Elimination(order, within, within @ moves[1:, 0], gone, ahead, first)


def visits(q: Array, out: Array) -> Array:
    """(I - q)⁻¹, how often each state is visited from each before the chain leaves, in sums of >= 0
    alone: the second half of the states in its excursions from the first, then the first.
    """
    if out.size < 2:
        return np.diag(1.0 / out)
    early = slice(0, out.size // 2)
    late = slice(out.size // 2, out.size)
    within = visits(q[late, late], out[late] + q[late, early].sum(axis=1))
    onward = q[early, late] @ within
    back = within @ q[late, early]
    whole = np.empty_like(q)
    whole[early, early] = visits(
        q[early, early] + onward @ q[late, early], out[early] + onward @ out[late]
    )
    whole[early, late] = whole[early, early] @ onward
    whole[late, early] = back @ whole[early, early]
    whole[late, late] = within + whole[late, early] @ onward
    return whole


MAX_UNKNOWNS = 6_000
NEGLECTED = (
    1e-6  # noise coefficients beyond the nodes' bandwidth are smaller; residuals then are rounding
)
_MIN_BANDWIDTH = 4


def killed_chain(
    passage: Passage,
    *,
    every_sample: bool = True,
    stretch: float = 1.0,
    most: int = MAX_UNKNOWNS,
) -> KilledChain:
    """The chain of a passage on nodes of its arcs.

    every_sample : panels of nodes end at every sample of a sampled map.
    stretch : factor on the nodes' bandwidth.

    Raises InvalidInput where more than ``most`` nodes would be needed, and for noise whose density
    jumps.
    """
    noise = passage.noise
    if noise.jump > 0.0:
        raise InvalidInput(
            f"{noise!r} has a density that jumps, which this method cannot resolve: take a "
            "smooth law"
        )
    bandwidth = float(_MIN_BANDWIDTH)
    while noise.coefficients(bandwidth) > NEGLECTED and bandwidth < 1e5:
        bandwidth *= 1.05
    chain = KilledChain(passage, every_sample, stretch * bandwidth)
    if chain.theta.size > most:
        raise InvalidInput(
            f"{noise!r} needs {chain.theta.size} nodes on the arc, more than {most}: raise its "
            "width"
        )
    return chain


@dataclass(frozen=True, eq=False)
class KilledChain:
    """A passage on ``theta`` (n nodes of its arcs), until it enters an exit.

    Below ``images`` are values F(x), shape (m,): the same questions are asked at nodes and between
    them.
    """

    passage: Passage
    every_sample: bool
    bandwidth: float
    finer: int = 1

    @cached_property
    def rule(self) -> Rule:
        """The nodes and their weights, ``finer`` times as many as the bandwidth asks for."""
        rules = [
            arc_rule(self.passage.map, *ends, self.bandwidth, self.finer, self.every_sample)
            for ends in self.passage.arcs
        ]
        theta, weight = np.concatenate(rules, axis=1)
        return theta, weight

    @property
    def theta(self) -> Array:
        """(n,): the nodes."""
        return self.rule[0]

    @property
    def weight(self) -> Array:
        """(n,): their weights."""
        return self.rule[1]

    @cached_property
    def images(self) -> Array:
        """(n,): F at the nodes."""
        return self.passage.map(self.theta)

    @cached_property
    def elimination(self) -> Elimination:
        """The chain on its own nodes, eliminated."""
        return eliminated(self.transitions(self.images), self.departures(self.images).sum(axis=0))

    def transitions(self, images: Array) -> Array:
        """(m, n): g(θ_j - F(x)) w_j, the chance of going to node j."""
        gap = self.theta - images[:, None]
        return self.passage.noise.density(gap, self.passage.lifted) * self.weight

    def pushes(self, images: Array, values: Array) -> Array:
        """(m,): d/dF of Σ_j g(θ_j - F(x)) w_j values_j; or columns of several."""
        gap = self.theta - images[:, None]
        slopes = self.passage.noise.slope(gap, self.passage.lifted)
        return np.asarray(-slopes * self.weight @ values)

    def departures(self, images: Array) -> Array:
        """(exits, m): P(F(x) + ξ in the exit), to full relative accuracy also where it is small."""
        low, high = np.array(self.passage.exits).T[:, :, None]
        if not self.passage.lifted:
            return self.passage.noise.arc_probability(low - images, high - images)
        # An exit is (-inf, end) or (end, inf): how far the noise must carry the image to enter it.
        return self.passage.noise.exceedance(np.where(np.isinf(high), low - images, images - high))

    def departure_slopes(self, images: Array) -> Array:
        """(exits, m): d/dF of ``departures``."""
        ends = np.array(self.passage.exits).T[:, :, None]
        at_low, at_high = self.passage.noise.density(ends - images, self.passage.lifted)
        return np.asarray(at_low - at_high)

    def expected(self, each: float, at: Array) -> Expectation:
        """What a path collects on average until it leaves: ``each`` a cycle, and ``at[e]`` on
        leaving by exit e.
        """
        reward = each + at @ self.departures(self.images)
        values, top, change = self.elimination.expected(reward)
        return Expectation(self, each, at, values, float(top), change)


@dataclass(frozen=True, eq=False)
class Expectation:
    """X(x), the solution of X = c + ∫_arcs g(y - F(x)) X(y) dy with c(x) = each + at·(chances of
    leaving).

    It is kept twice at the nodes: as ``values``, and as ``top`` + ``change``, top its value at the
    node visited most. Values have their digits where they are small, changes have theirs where top
    is 1e100 and the path is most of the time; each, at >= 0.
    """

    chain: KilledChain
    each: float
    at: Array
    values: Array
    top: float
    change: Array

    def values_at(self, images: Array) -> tuple[Array, Array]:
        """X, and X - top, at points whose images are given: Nyström's interpolant."""
        moves = self.chain.transitions(images)
        gone = self.chain.departures(images)
        share = 1.0 / (gone.sum(axis=0) + moves.sum(axis=1))
        value = self.each + self.at @ gone + moves @ self.values
        change = self.each + (self.at - self.top) @ gone + moves @ self.change
        return value * share, change * share

    def value_at(self, theta: float) -> float:
        """X(θ)."""
        return float(self.values_at(self.chain.passage.map(np.array([theta])))[0][0])

    def growth(self, images: Array, chain: KilledChain) -> Array:
        """How fast c + ∫ g(y - F) X dy grows with F alone, at ``images``; the integral on the nodes
        of ``chain``.
        """
        around = self.values_at(chain.images)[1]
        leaving = (self.at - self.top) @ chain.departure_slopes(images)
        return np.asarray(leaving + chain.pushes(images, around))

    def error_bounds(self, theta: float) -> tuple[float, float]:
        """Bounds on the error of X(θ): of the discretisation with rounding, and from the map's
        ``max_error``.

        The operator I - K is monotone: if (I - K)Φ >= |r|, r the residual of the interpolant on a
        finer rule, then Φ bounds the error everywhere. Φ is solved for on the chain's own nodes.
        """
        chain = self.chain
        fine = replace(chain, finer=2)
        images = np.append(chain.images, chain.passage.map(theta))
        on_fine = self.values_at(fine.images)
        # X - c - ∫ g X dy at the images, and the sum of its terms' sizes: of the two forms the
        # better. A constant part of X, however large, drops out of the second one exactly.
        moves = fine.transitions(images)
        gone = fine.departures(images)
        here = self.values_at(images)
        forms = []
        for value, around, top in zip(here, on_fine, (0.0, self.top), strict=True):
            stay = value * moves.sum(axis=1)
            lost = value * gone.sum(axis=0) - (self.at - top) @ gone
            terms = np.abs(lost) + np.abs(stay) + moves @ np.abs(around) + self.each
            forms.append((terms, lost + stay - moves @ around - self.each))
        (size, residual), (other_size, other) = forms
        residual = np.where(size <= other_size, residual, other)
        size = np.minimum(size, other_size)
        # What lies between the nodes.
        widened = sliding_window_view(np.pad(np.abs(residual), 1, mode="edge"), 3).max(axis=1)
        slope = np.abs(self.growth(images, fine))
        # The distances to the exits are rounded one by one, so that their slopes do not cancel.
        ruggedness = slope + np.abs(self.at - self.top) @ np.abs(chain.departure_slopes(images))
        own = widened + 2.0 * EPS * (size + ruggedness * (1.0 + np.abs(images)))
        max_error = chain.passage.map.max_error
        sources = np.stack([own, slope * max_error], axis=1)
        with np.errstate(over="ignore", invalid="ignore"):
            onward, _, _ = chain.elimination.expected(sources[:-1])
            bounds = sources[-1] + chain.transitions(images[-1:])[0] @ onward
        own_bound, from_map = np.where(np.isfinite(bounds), bounds, np.inf)
        return float(own_bound), float(from_map) if max_error else 0.0


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
