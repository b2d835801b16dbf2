"""Strategies in order: what meets the demands by its cost, the rest by how far it misses, and what binds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from cyclemap.resets.design.reset_candidates import ResetCandidate
from cyclemap.resets.design.reset_demands import AT_LEAST, DEMANDS, Miss, ResetDemands, demanded_values, is_beyond
from cyclemap.resets.design.reset_numbers import ResetNumbers
from cyclemap.resets.strategies.action_cost import StrategyCost


@dataclass(frozen=True, eq=False)
class ScoredReset:
    """A strategy with its scores and its cost, set against the demands.

    misses : what it misses, by the best estimates. lacking : what it needs that the robot cannot do. certain :
    whether error bounds confirm its scores. drag_ratio : mean drag, in those of the loop's own reset. contact : m, the
    shortest way that the rod goes in contact in any of its pushes, from any orientation.
    """

    candidate: ResetCandidate
    numbers: ResetNumbers
    cost: StrategyCost
    misses: tuple[Miss, ...]
    lacking: tuple[str, ...]
    certain: bool
    drag_ratio: float
    contact: float = math.inf

    @classmethod
    def of(
        cls,
        candidate: ResetCandidate,
        numbers: ResetNumbers,
        cost: StrategyCost,
        demands: ResetDemands,
        own_drag: float,
        contact: float = math.inf,
    ) -> ScoredReset:
        """Set scores and cost against the demands; own_drag : mean drag (m) of the loop's own reset."""
        return cls(
            candidate,
            numbers,
            cost,
            demands.misses(numbers, cost, own_drag, contact),
            demands.lacking(candidate.strategy.needs),
            demands.are_certain(numbers),
            cost.mean_drag_length / own_drag,
            contact,
        )

    @property
    def name(self) -> str:
        """Of the candidate."""
        return self.candidate.name

    @property
    def meets(self) -> bool:
        """Whether nothing is missed and nothing lacking."""
        return not self.misses and not self.lacking

    @property
    def excess(self) -> float:
        """By how much all demands together are missed: the sum of the logarithms of value over limit."""
        return math.fsum(miss.excess for miss in self.misses)

    @property
    def order(self) -> tuple[bool, bool, float, float, float]:
        """The key that ranks: the robot can do it; it misses nothing, or little; short drags; short cycles."""
        cost = self.cost
        return bool(self.lacking), bool(self.misses), self.excess, cost.mean_drag_length, cost.mean_seconds

    def value(self, demand: str) -> float:
        """What a demand is about: a probability, m or s."""
        return demanded_values(self.numbers, self.cost, self.contact)[demand]


def ranked(scored: Sequence[ScoredReset]) -> tuple[ScoredReset, ...]:
    """Return them in order: those that meet all, by mean drag and then time; those that miss, by how far; and last,
    in the same order, those that need what the robot cannot do."""
    return tuple(sorted(scored, key=lambda one: one.order))


@dataclass(frozen=True, eq=False)
class DemandOutlook:
    """What can be had of one demand: least value over the strategies that the robot can do; of contact the largest.

    limit : what was asked. least : of all; least_by : whose it is. least_with_others : of those that meet every other
    demand, None where there is none; with_others_by : whose. Limits and values are probabilities, m or s.
    """

    demand: str
    limit: float
    least: float
    least_by: ScoredReset
    least_with_others: float | None
    with_others_by: ScoredReset | None

    @property
    def binds_alone(self) -> bool:
        """Whether giving up this demand alone would leave a strategy."""
        found = self.least_with_others
        return found is not None and is_beyond(self.demand, found, self.limit)

    @property
    def out_of_reach(self) -> bool:
        """Whether no strategy meets it, whatever else is asked."""
        return is_beyond(self.demand, self.least, self.limit)


def outlooks(scored: Sequence[ScoredReset], demands: ResetDemands, own_drag: float) -> tuple[DemandOutlook, ...]:
    """Return the outlook of every demand that was made, in the order of `DEMANDS`; none where nothing can be done."""
    able = [one for one in scored if not one.lacking]
    limits = demands.limits(own_drag)
    return tuple(_outlook(able, name, limits[name]) for name in DEMANDS if name in limits and able)


def _outlook(able: Sequence[ScoredReset], name: str, limit: float) -> DemandOutlook:
    def value(one: ScoredReset) -> float:
        return one.value(name)

    def order(one: ScoredReset) -> float:
        return -value(one) if name == AT_LEAST else value(one)

    least = min(able, key=order)
    others = [one for one in able if all(miss.demand == name for miss in one.misses)]
    best = min(others, key=order) if others else None
    return DemandOutlook(name, limit, value(least), least, None if best is None else value(best), best)
