"""Strategies of one loop scored one after the other, sharing maps; those that lead out of the mechanics put aside."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from cyclemap.errors import CycleMapError
from cyclemap.mechanics import SidePush
from cyclemap.resets.design.action_cache import ActionCache, has_kernel
from cyclemap.resets.design.reset_candidates import Effort, PushPlaces, ResetCandidate, own_candidate
from cyclemap.resets.design.reset_demands import ResetDemands
from cyclemap.resets.design.reset_ranking import ScoredReset, ranked
from cyclemap.resets.drawn_pushes.push_library import LEAST_SHARE, PushLibrary, push_library
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.push_strategies import DrawnPushes

Progress = Callable[[str, float], None]
# Radians: maps that error bounds are taken from.
FINE_TOLERANCE = 1e-5
# Of a law, for a full turn: drags are smooth in what is drawn, so that costs need fewer than laws.
COST_NODES = 8


@dataclass(frozen=True)
class LeftOutStrategy:
    """A strategy, or a push, that could not be looked at. reason : in words."""

    name: str
    reason: str


@dataclass
class ResetSurvey:
    """What has been scored so far, by name. brief : pushes put aside, with the way (m) until they lose the object.

    keep_push : only strategies with the loop's own push are looked at."""

    cache: ActionCache
    demands: ResetDemands
    keep_push: bool
    progress: Progress
    scored: dict[str, ScoredReset] = field(default_factory=dict)
    left_out: list[LeftOutStrategy] = field(default_factory=list)
    library: PushLibrary | None = None
    brief: dict[SidePush, float] = field(default_factory=dict)

    @cached_property
    def own_drag(self) -> float:
        """Mean drag (m) of the loop's own reset."""
        own = own_candidate(self.cache.loop)
        return self.cache.cost(own.strategy, own.nodes).mean_drag_length

    @cached_property
    def own(self) -> ScoredReset:
        """The loop's own reset as it is; what it raises is raised."""
        return self._score(own_candidate(self.cache.loop))

    @cached_property
    def fine(self) -> ActionCache:
        """Maps fine enough for error bounds."""
        return self.cache.finer(min(FINE_TOLERANCE, self.cache.tolerance))

    def places(self, work: Effort, further: bool = False) -> PushPlaces:
        """Where the push can be made as well. further : at the outer fractions too."""
        return PushPlaces.of(self.cache.loop, (*work.fractions, *(work.outer if further else ())))

    def look_at_pushes(self, work: Effort) -> None:
        """Score the loop's own reset, and compute the maps of the pushes that can be made."""
        self.scored[self.own.name] = self.own
        if not self.keep_push:
            self.add_pushes(self.places(work).everywhere, "cycle maps of pushes", self.contact_for(work, whole=True))

    def add_pushes(self, pushes: Sequence[SidePush], stage: str, contact: float = 0.0) -> bool:
        """Add to the library what of the pushes can be made; the others are left out by name. Whether any was added.

        contact : m; pushes in which the rod goes less far in contact, from some orientation, are put aside.
        """
        loop = self.cache.loop
        options: dict[str, Any] = {"noise": self.cache.noise, "tolerance": self.cache.tolerance, "least_travel": 0.0}
        try:
            new = self._held(pushes, contact)
            if not new:
                return False
            made = push_library(loop, new, progress=lambda done: self.progress(stage, done), **options)
        except CycleMapError as error:
            self.left_out.append(LeftOutStrategy("pushes at other places", str(error)))
            return False
        for push, row in zip(made.pushes, made.random_maps[0], strict=True):
            self.cache.put(loop, CycleAction(push=push), row.maps[0])
        self.library = made if self.library is None else _joined(self.library, made)
        for one in made.left_out:
            self.left_out.append(LeftOutStrategy(_push_name(one.push), one.reason))
        return True

    def _held(self, pushes: Sequence[SidePush], contact: float) -> list[SidePush]:
        """Those of the pushes that are new and last so long (m) in contact; the others are remembered."""
        known = () if self.library is None else self.library.pushes
        new = [push for push in dict.fromkeys(pushes) if push not in known]
        self.brief.update({push: self.cache.contact(push) for push in new})
        held = [push for push in new if self.brief[push] >= contact]
        for push in held:
            del self.brief[push]
        return held

    def contact_for(self, work: Effort, whole: bool = False) -> float:
        """How far (m) the rod must go in contact in a push. whole : while nothing calls for shorter ones."""
        distance, asked = self.cache.loop.push.distance, self.demands.contact
        least = work.least_share * distance if asked is None else asked
        return max(least, LEAST_SHARE * distance) if whole else least

    @property
    def all_left_out(self) -> tuple[LeftOutStrategy, ...]:
        """All that was left out, the pushes that lose the object early together."""
        if not self.brief:
            return tuple(self.left_out)
        low, high = 1000 * min(self.brief.values()), 1000 * max(self.brief.values())
        reason = f"the rod loses the object after {low:.0f} to {high:.0f} mm"
        name = f"{len(self.brief)} push{'es' if len(self.brief) > 1 else ''} at other places"
        return *self.left_out, LeftOutStrategy(name, reason)

    @property
    def order(self) -> tuple[ScoredReset, ...]:
        """All that was scored, ranked."""
        return ranked(list(self.scored.values()))

    @property
    def best_drawn(self) -> ResetCandidate | None:
        """The first in the order of those that draw pushes and nothing else."""
        drawn = (one.candidate for one in self.order if isinstance(one.candidate.strategy, DrawnPushes))
        return next(drawn, None)

    @property
    def any_meets(self) -> bool:
        """Whether anything that was scored so far meets all demands."""
        return any(one.meets for one in self.scored.values())

    def look(self, candidates: Sequence[ResetCandidate], stage: str) -> None:
        """Score the candidates that are new; those that fail are left out by name."""
        loop = self.cache.loop
        known = {one.candidate.strategy for one in self.scored.values()}
        new = [one for one in {one.strategy: one for one in reversed(candidates)}.values() if one.strategy not in known]
        kept = [one for one in reversed(new) if not self.keep_push or one.keeps_push(loop)]
        for number, candidate in enumerate(kept):
            try:
                self.scored[candidate.name] = self._score(candidate)
            except CycleMapError as error:
                self.left_out.append(LeftOutStrategy(candidate.name, str(error)))
            self.progress(stage, (number + 1) / len(kept))

    def confirm(self, most: int) -> None:
        """Score anew, with error bounds, the first that meet the demands, until `most` of them are looked at.

        At least one is sought that the bounds confirm: as many more are looked at as that takes, up to three.
        """
        done: set[str] = set()
        while True:
            order = [one for one in self.order if one.meets and has_kernel(one.candidate.strategy)]
            sure = any(one.certain for one in order)
            waiting = [one for one in order if one.name not in done]
            if not waiting or len(done) >= (most if sure else most + 2):
                return
            done.add(waiting[0].name)
            self.scored[waiting[0].name] = self._score(waiting[0].candidate, bounded=True)
            self.progress("confirming with error bounds", len(done) / (len(done) + 1))

    def _score(self, candidate: ResetCandidate, bounded: bool = False) -> ScoredReset:
        wanted = self.demands
        cache = self.fine if bounded else self.cache
        numbers = cache.numbers(candidate.strategy, candidate.nodes, wanted.within, wanted.near_tv, bounded)
        cost = self.cache.cost(candidate.strategy, min(candidate.nodes, COST_NODES))
        contact = self.cache.shortest_contact(candidate.strategy, candidate.nodes)
        return ScoredReset.of(candidate, numbers, cost, wanted, self.own_drag, contact)


def _push_name(push: SidePush) -> str:
    slanted = f", {math.degrees(push.angle):+.0f}°" if push.angle else ""
    return f"push on side {push.side} at {push.fraction:.2f}{slanted}"


def _joined(one: PushLibrary, other: PushLibrary) -> PushLibrary:
    """The pushes of both libraries of the same loop."""
    return PushLibrary(
        one.pushes + other.pushes,
        tuple(a + b for a, b in zip(one.random_maps, other.random_maps, strict=True)),
        np.concatenate([one.drag_lengths, other.drag_lengths], axis=1),
        one.modes,
        one.legs,
        one.loops,
        one.left_out + other.left_out,
    )
