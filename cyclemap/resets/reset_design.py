"""The design of a reset: what to do, what that leaves and what it costs, beside a few others to ask
about.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import positive_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.mechanics import Material
from cyclemap.progress import Progress, unheard
from cyclemap.protocol.strategy import IN_TURN, RANDOM, SHUFFLED, ResetStrategy
from cyclemap.resets.action_cycles import (
    SampledTurns,
    contact_lengths,
    sample_turns,
)
from cyclemap.resets.material_range import MaterialRange, range_of, stretched
from cyclemap.resets.orientation_law import OrientationLaw, orientation_law
from cyclemap.resets.reset_ranking import (
    AFTER,
    AS_IT_IS,
    CHOSEN,
    CONTACT,
    DRAG,
    FIRM,
    GIVEN,
    OWN,
    REACH,
    RESET,
    SECONDS,
    SIMPLEST,
    TV,
    WITH_GRIPPER,
    Limit,
    Pool,
    ResetDemands,
    candidate_pool,
    mixture_costs,
    picked,
)
from cyclemap.resets.strategy_run import (
    histogram_distances,
    histogram_shares,
    independent_distance,
    sampled_orientations,
    steered_orientations,
)

STEERED = "steered"
# The chosen one, and six to compare it with.
MOST_ROWS = 7
_SAMPLES = 48
_REFINED = 720
# Fourier modes at most of the laws on materials that are not nominal.
_ENOUGH_MODES = 96
# Collections simulated for a histogram, and cycles of them all at most.
_RUNS = 200
_MOST_SIMULATED = 4_000_000
# Those by which the material is found where a histogram is worst.
_ROUGH_RUNS = 20
_RATIO_STEPS = (-0.2, -0.15, -0.1, -0.05, 0.0, 0.05, 0.1, 0.15, 0.2)
# Where a row tells the value of a demand.
_FIELD_OF = {
    TV: "worst",
    AFTER: "worst_after",
    DRAG: "drag",
    SECONDS: "seconds",
    REACH: "room",
    CONTACT: "contact",
}
# Strategies by what they are told for.
Picks = list[tuple[str, ResetStrategy]]


@dataclass(frozen=True, eq=False)
class ResetRow:
    """A strategy with what it leaves and costs.

    Attributes
    ----------
    roles : tuple of str
        Why it is told.
    strategy : ResetStrategy
        What the robot does.
    nominal : OrientationLaw
        Law on the nominal material.
    worst, worst_after : float
        Total variation in the long run, and after some pushes from the worst start, each at the
        worst of the materials, as `MaterialRange.worst` takes it.
    worst_material : Material
        That of the latter.
    drag : float
        Mean drag of a cycle, m.
    seconds : float
        Mean time of a cycle, s.
    room : float
        Farthest distance of rod or object from the target, m.
    contact : float
        Least way of the rod in contact, m.
    histogram : tuple[float, float]
        Mean and standard deviation over 200 runs of the histogram distance of the pushes to be
        collected, nominal.
    worst_histogram : tuple[float, float]
        The same where that is worst.
    misses : tuple of str
        Demands missed; a histogram that lies no further from uniform at worst than that of
        independent pushes misses none about uniformity.
    lacking : tuple of str
        Abilities that it needs and the robot has not.

    Examples
    --------
    >>> from cyclemap import CollectionLoop, design_reset
    >>> from cyclemap.resets import ResetDemands
    >>> loop = CollectionLoop.mit("isotropic", accuracy=1e-5)
    >>> demands = ResetDemands(pushes=50, within=10)
    >>> design = design_reset(loop, demands, materials=[loop.material])  # doctest: +SKIP
    >>> round(design.chosen.drag, 4), round(design.chosen.seconds, 1)  # doctest: +SKIP
    (0.0979, 22.4)
    """

    roles: tuple[str, ...]
    strategy: ResetStrategy
    nominal: OrientationLaw
    worst: float
    worst_after: float
    worst_material: Material
    drag: float
    seconds: float
    room: float
    contact: float
    histogram: tuple[float, float]
    worst_histogram: tuple[float, float]
    misses: tuple[str, ...]
    lacking: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class ResetDesign:
    """The answer of `design_reset`.

    Attributes
    ----------
    loop : CollectionLoop
        The loop as it is.
    sigma : float
        Noise of a cycle, rad.
    demands : ResetDemands
        What was asked for.
    about : MaterialRange
        The range of materials.
    rows : tuple of ResetRow
        The chosen one first, the loop as it is last where it is not chosen, seven at most.
    binding : tuple of Limit
        What the demands that the chosen one misses could be at least.
    independent : float
        Mean histogram distance of independent uniform pushes.
    orders : dict of str to float
        Histogram distance of the chosen actions by order, and "steered" by the monitor.
    ratio_errors : ndarray, shape (n,)
        By how much the ratio of the axes is off.
    ratio_tv : ndarray, shape (2, n) or (1, n)
        Total variation in the long run there, of the chosen row and of the simplest.
    before, after : ndarray, shape (runs, 36)
        Histograms of the pushes as shares, of the loop as it is and of the chosen one.

    Examples
    --------
    >>> from cyclemap import CollectionLoop, design_reset
    >>> from cyclemap.resets import ResetDemands
    >>> loop = CollectionLoop.mit("isotropic", accuracy=1e-5)
    >>> demands = ResetDemands(pushes=50, within=10)
    >>> design = design_reset(loop, demands, materials=[loop.material])  # doctest: +SKIP
    >>> design.met, design.chosen is design.own  # doctest: +SKIP
    (True, True)
    """

    loop: CollectionLoop
    sigma: float
    demands: ResetDemands
    about: MaterialRange
    rows: tuple[ResetRow, ...]
    binding: tuple[Limit, ...]
    independent: float
    orders: dict[str, float]
    ratio_errors: Array
    ratio_tv: Array
    before: Array
    after: Array

    @property
    def chosen(self) -> ResetRow:
        """The first row."""
        return self.rows[0]

    @property
    def met(self) -> bool:
        """Whether the chosen one meets every demand."""
        return not self.chosen.misses

    @property
    def own(self) -> ResetRow:
        """The row of the loop as it is."""
        return next(row for row in self.rows if AS_IT_IS in row.roles)


def design_reset(
    loop: CollectionLoop,
    demands: ResetDemands | None = None,
    *,
    sigma: float = math.radians(1.1),
    materials: Sequence[Material] | MaterialRange | None = None,
    given: ResetStrategy | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> ResetDesign:
    """Return the reset to use: the most uniform at the worst of a range of materials, then cheap,
    then simple.

    Parameters
    ----------
    loop : CollectionLoop
        The loop as it is.
    demands : ResetDemands or None, optional
        What the reset must keep to; None: `ResetDemands()`.
    sigma : float, optional
        Noise of a cycle, rad.
    materials : sequence of Material or MaterialRange or None, optional
        The range, or materials that are as likely as the loop's own, such as draws from an
        identification; None: `material_range`.
    given : ResetStrategy or None, optional
        A strategy to rank with them.
    seed : int, default 0
        Of the runs whose histograms are told.
    progress : callable or None, optional
        Called with the fraction done.

    Returns
    -------
    ResetDesign
        The chosen reset, what else was considered, and what binds.

    Raises
    ------
    InvalidInput
        For values that make no sense.
    CycleMapError
        What a cycle raises that leads out of the mechanics.

    Notes
    -----
    Candidates are pushes on any side at several places and slants, in every mixture of up to four;
    the loop's own push dragged back by a leg in a random direction, or followed by a gripper's
    turn; the ring elsewhere, where the robot can put it there. Those whose total variations differ
    by less than a fifth of `independent_distance` are equally uniform: `demands.pushes` pushes
    cannot tell them apart. Of those the cheapest (time) within 5 %, of those the one of the fewest
    actions, equal weights, and pushes most like the loop's own. Where the loop as it is leaves, at
    the worst of the range, a histogram of `demands.pushes` pushes nearer to uniform than that, it
    is left as it is.

    Examples
    --------
    An isotropic floor turns the object on by 8 degrees a cycle, which is even enough as it is; the
    search takes a minute and a half:

    >>> from cyclemap import CollectionLoop, design_reset
    >>> from cyclemap.resets import ResetDemands
    >>> loop = CollectionLoop.mit("isotropic", accuracy=1e-5)
    >>> demands = ResetDemands(pushes=50, within=10)
    >>> design = design_reset(loop, demands, materials=[loop.material])  # doctest: +SKIP
    >>> design.met, design.chosen.roles, len(design.rows)  # doctest: +SKIP
    (True, ('chosen', 'as it is'), 7)
    >>> design_reset(loop, sigma=-1.0)
    Traceback (most recent call last):
        ...
    cyclemap.errors.InvalidInput: sigma must be positive, not -1.0
    """
    wanted = demands or ResetDemands()
    report = progress or unheard
    report(0.0)
    about = range_of(loop.material, materials)
    nominal = replace(loop, material=about.nominal)
    positive_number("sigma", sigma)
    pool = candidate_pool(nominal, wanted, about, sigma, lambda done: report(0.4 * done))
    judge = _Judge(nominal, pool.limits, wanted, about, sigma, seed)
    picks, binding = _closely_picked(pool, judge)
    rows, cycles = _assessed(judge, _roles(picks, given), report)
    binding = tuple(_as_its_row_says(limit, rows) for limit in binding)
    chosen = rows[0]
    own, turn = (cycles[strategy].refined(_REFINED)[0] for strategy in (OWN, chosen.strategy))
    simplest = [row.strategy for row in rows[1:] if SIMPLEST in row.roles]
    return ResetDesign(
        loop=loop,
        sigma=sigma,
        demands=wanted,
        about=about,
        rows=tuple(rows),
        binding=binding if chosen.misses else (),
        independent=independent_distance(wanted.pushes),
        orders=judge.distances_by_order(chosen, turn),
        ratio_errors=np.array(_RATIO_STEPS),
        ratio_tv=np.array([judge.off_ratio(each) for each in (chosen.strategy, *simplest)]),
        before=judge.histograms(OWN, own),
        after=judge.histograms(chosen.strategy, turn),
    )


def _closely_picked(pool: Pool, judge: _Judge) -> tuple[Picks, tuple[Limit, ...]]:
    """What is picked, so far within the demands that the best keeps them on a closer look, too."""
    for firm in FIRM:
        picks, binding = picked(pool, judge.demands, firm)
        if binding or judge.is_kept_by(picks[0][1]):
            break
    return picks, binding


def _roles(picks: Picks, given: ResetStrategy | None) -> dict[ResetStrategy, list[str]]:
    """The strategies that are told, each once, with all that it is."""
    own = () if given is None else ((GIVEN, given),)
    roles: dict[ResetStrategy, list[str]] = {}
    for role, strategy in (*picks, *own, (AS_IT_IS, OWN)):
        roles.setdefault(strategy, []).append(role)
    if len(roles) > MOST_ROWS:
        # One's own strategy is told in place of what a gripper could do.
        roles = {
            strategy: reasons for strategy, reasons in roles.items() if reasons != [WITH_GRIPPER]
        }
    return roles


def _assessed(
    judge: _Judge, roles: dict[ResetStrategy, list[str]], report: Progress
) -> tuple[list[ResetRow], dict[ResetStrategy, SampledTurns]]:
    """The rows, from more samples and on all materials of the range, and those samples."""
    cycles: dict[ResetStrategy, SampledTurns] = {}
    for strategy in roles:
        report(0.4 + 0.4 * len(cycles) / len(roles))
        cycles[strategy] = judge.sampled(strategy)
    rows: list[ResetRow] = []
    for strategy, reasons in roles.items():
        report(0.8 + 0.1 * len(rows) / len(roles))
        rows.append(judge.row(strategy, reasons, cycles[strategy]))
    return _best_first(rows), cycles


def _as_its_row_says(limit: Limit, rows: Sequence[ResetRow]) -> Limit:
    """The limit with what the row of its reset tells, where there is one: the search is coarser."""
    for row in rows:
        if row.strategy == limit.strategy:
            return replace(limit, value=getattr(row, _FIELD_OF[limit.demand]))
    return limit


def _best_first(rows: list[ResetRow]) -> list[ResetRow]:
    """The rows, the loop as it is chosen where it is as uniform as can be told."""
    own = next(row for row in rows if AS_IT_IS in row.roles)
    if (
        own is not rows[0]
        and not own.misses
        and own.worst_histogram[0] <= rows[0].worst_histogram[0]
    ):
        best = tuple(role for role in rows[0].roles if role != CHOSEN) or (RESET,)
        leave = replace(own, roles=(CHOSEN, *own.roles))
        return [leave, replace(rows[0], roles=best), *(row for row in rows[1:] if row is not own)]
    return rows


@dataclass(frozen=True, eq=False)
class _Judge:
    """Looks at strategies more closely than the search did: on all materials of the range."""

    loop: CollectionLoop
    limits: dict[str, float]
    demands: ResetDemands
    about: MaterialRange
    sigma: float
    seed: int

    def sampled(self, strategy: ResetStrategy) -> SampledTurns:
        """What its actions do on every material."""
        prepared = strategy.prepared(self.loop)
        return sample_turns(prepared, strategy.actions, self.about.materials, _SAMPLES)

    def laws(
        self, strategy: ResetStrategy, turns: Array, modes: int | None
    ) -> list[OrientationLaw]:
        """The law of the orientations by each of the turns."""
        within = self.demands.within
        return [orientation_law(turn, strategy, self.sigma, within, modes) for turn in turns]

    def worst(self, laws: Sequence[OrientationLaw]) -> tuple[float, float, int]:
        """The worst distances from uniform of the laws on all materials, in the long run and after
        some pushes, and the material of the latter.
        """
        long_run = np.array([law.total_variation for law in laws])
        after = np.array([law.after for law in laws])
        where = self.about.worst(after)
        return float(long_run[self.about.worst(long_run)]), float(after[where]), where

    def is_kept_by(self, strategy: ResetStrategy) -> bool:
        """Whether it is as uniform as is demanded."""
        turns = self.sampled(strategy).refined(_REFINED)
        tv, after, _ = self.worst(self.laws(strategy, turns, _ENOUGH_MODES // 2))
        return tv <= self.demands.allow_tv and after <= self.demands.allow_after

    def row(self, strategy: ResetStrategy, roles: Sequence[str], cycles: SampledTurns) -> ResetRow:
        """What it leaves and costs."""
        turns = cycles.refined(_REFINED)
        (nominal,) = self.laws(strategy, turns[:1], None)
        others = self.laws(strategy, turns[1:], min(nominal.modes, _ENOUGH_MODES))
        tv, after, where = self.worst((nominal, *others))
        prepared = strategy.prepared(self.loop)
        contact = contact_lengths(prepared, strategy.actions)
        drag = cycles.drag_length[0]
        priced = mixture_costs(prepared, strategy.actions, strategy.shares, drag, contact)
        values = {name: float(cost) for name, cost in priced.items()} | {TV: tv, AFTER: after}
        histogram, worst_histogram = self.distances(strategy, turns)
        is_even = worst_histogram[0] <= independent_distance(self.demands.pushes)
        misses = []
        for name, limit in self.limits.items():
            # Contact is demanded at least, all else at most.
            is_missed = values[name] < limit if name == CONTACT else values[name] > limit
            if is_missed and not (is_even and name in (TV, AFTER)):
                misses.append(name)
        return ResetRow(
            roles=tuple(roles),
            strategy=strategy,
            nominal=nominal,
            worst_material=self.about.materials[where],
            histogram=histogram,
            worst_histogram=worst_histogram,
            misses=tuple(misses),
            lacking=tuple(need for need in strategy.needs if need not in self.demands.abilities),
            **{field: values[name] for name, field in _FIELD_OF.items()},
        )

    def distances(self, strategy: ResetStrategy, turns: Array) -> list[tuple[float, float]]:
        """Mean and deviation of histograms' distances from uniform, nominal and where worst."""
        rough = [self.histograms(strategy, turn, _ROUGH_RUNS) for turn in turns]
        peak = self.about.worst(np.array([histogram_distances(shares).mean() for shares in rough]))
        spreads = []
        for turn in (turns[0], turns[peak]):
            distances = histogram_distances(self.histograms(strategy, turn))
            spreads.append((float(distances.mean()), float(distances.std(ddof=1))))
        return spreads

    def histograms(self, strategy: ResetStrategy, turn: Array, most: int = _RUNS) -> Array:
        """The histograms (runs, 36) of simulated collections."""
        pushes = self.demands.pushes
        runs = _runs(pushes, most)
        theta = sampled_orientations(turn, strategy, pushes, runs, self.sigma, self.seed)
        return histogram_shares(theta)

    def distances_by_order(self, row: ResetRow, turn: Array) -> dict[str, float]:
        """The mean histogram distance of the same actions in other orders, and chosen from the
        orientation seen.
        """
        distances = {RANDOM: row.histogram[0]}
        strategy = row.strategy
        if len(strategy.actions) == 1:
            return distances
        orders = (IN_TURN, SHUFFLED) if strategy.weights is None else (SHUFFLED,)
        shares = {order: self.histograms(replace(strategy, order=order), turn) for order in orders}
        pushes = self.demands.pushes
        steered = steered_orientations(turn, pushes, _runs(pushes, _RUNS), self.sigma, self.seed)
        shares[STEERED] = histogram_shares(steered)
        for order, runs in shares.items():
            distances[order] = float(histogram_distances(runs).mean())
        return distances

    def off_ratio(self, strategy: ResetStrategy) -> list[float]:
        """The total variation where the ratio of the friction's axes is off by shares of it, their
        geometric mean kept.
        """
        nominal = self.about.nominal
        bent = [stretched(nominal.friction, 1.0 + step) for step in _RATIO_STEPS]
        materials = [replace(nominal, friction=friction) for friction in bent]
        prepared = strategy.prepared(self.loop)
        turns = sample_turns(prepared, strategy.actions, materials, _SAMPLES).refined(_REFINED)
        return [orientation_law(turn, strategy, self.sigma, 1).total_variation for turn in turns]


def _runs(pushes: int, most: int) -> int:
    return max(2, min(most, _MOST_SIMULATED // pushes))
