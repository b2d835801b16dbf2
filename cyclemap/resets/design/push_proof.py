"""A proof, where there is one, that the best of the pushes cannot meet the demands, however they are chosen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cyclemap.errors import CycleMapError
from cyclemap.mechanics import SidePush
from cyclemap.resets.design.action_cache import ActionCache
from cyclemap.resets.design.reset_demands import DRAG, TV
from cyclemap.resets.design.reset_ranking import DemandOutlook, ScoredReset
from cyclemap.resets.drawn_pushes.push_bound import push_bound
from cyclemap.resets.drawn_pushes.push_library import push_library
from cyclemap.resets.strategies.push_strategies import PushChoice

# Pushes that are looked at, the most frequent ones; radians, of their maps.
_MOST_PUSHES, _TOLERANCE = 4, 1e-4


@dataclass(frozen=True)
class PushProof:
    """No rule that takes one of the pushes, by the orientation or by chance, gets below `lower`.

    demand : "tv": the long-run total variation from uniform with a mean drag of at most `beside` (m); or "drag": the
    mean drag (m) with a total variation of at most `beside`. limit : what was asked, less than `lower`.
    """

    pushes: tuple[SidePush, ...]
    demand: str
    lower: float
    limit: float
    beside: float


def push_proof(
    cache: ActionCache,
    ranking: Sequence[ScoredReset],
    outlooks: Sequence[DemandOutlook],
    progress: Callable[[str, float], None],
) -> PushProof | None:
    """Return the proof for the pushes of the first strategy of the ranking that chooses among pushes and does no more.

    None where the strategies meet the demands on total variation and drag together, and where nothing is proved: a
    rule that looks at the orientation may do what drawing cannot. About 2 s a push, for finer maps.
    """
    limits = {one.demand: one.limit for one in outlooks}
    missed = {miss.demand for miss in ranking[0].misses}
    pushes = _pushes(ranking)
    if len(pushes) < 2 or not missed & {TV, DRAG}:
        return None
    progress("proving what the pushes cannot do", 0.1)
    try:
        library = push_library(cache.loop, pushes, noise=cache.noise, tolerance=_TOLERANCE, least_travel=0.0)
        if float(library.drag_lengths.min()) > limits[DRAG]:
            demand, beside, found = DRAG, limits[TV], push_bound(library, allow_tv=limits[TV])
        else:
            demand, beside, found = TV, limits[DRAG], push_bound(library, drag_limit=limits[DRAG])
    except CycleMapError:
        return None
    finally:
        progress("proving what the pushes cannot do", 1.0)
    limit = limits[demand]
    return PushProof(pushes, demand, found.lower, limit, beside) if found.lower > limit else None


def _pushes(ranking: Sequence[ScoredReset]) -> tuple[SidePush, ...]:
    """The most frequent pushes of the first strategy that is a choice of pushes."""
    choices = (one.candidate.strategy for one in ranking if isinstance(one.candidate.strategy, PushChoice))
    first = next(choices, None)
    if first is None:
        return ()
    often = np.argsort(-first.chances, kind="stable")[:_MOST_PUSHES]
    return tuple(first.pushes[i] for i in often.tolist())
