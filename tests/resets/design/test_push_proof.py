"""What is proved of pushes that no strategy makes meet the demands."""

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.maps import WrappedNormal
from cyclemap.resets.design import push_proof as module
from cyclemap.resets.design.action_cache import ActionCache
from cyclemap.resets.design.push_proof import push_proof
from cyclemap.resets.design.reset_candidates import ResetCandidate, own_candidate
from cyclemap.resets.design.reset_demands import ResetDemands
from cyclemap.resets.design.reset_ranking import ScoredReset, outlooks, ranked
from cyclemap.resets.strategies.push_strategies import DrawnPushes, side_pushes

LOOP = CollectionLoop.mit()
TWO = DrawnPushes(side_pushes(LOOP.push, (0, 2)))


@pytest.fixture(autouse=True)
def coarse_maps(monkeypatch) -> None:
    """A bound counts the errors of the maps: it holds on coarse ones too."""
    monkeypatch.setattr(module, "_TOLERANCE", 1e-2)


@pytest.fixture(scope="module")
def cache() -> ActionCache:
    return ActionCache(LOOP, WrappedNormal(0.1), tolerance=1e-2, orientations=6)


def proved(cache: ActionCache, demands: ResetDemands, *candidates: ResetCandidate):
    drag = cache.cost(own_candidate(LOOP).strategy).mean_drag_length
    scored = [
        ScoredReset.of(one, cache.numbers(one.strategy, 1, 50, 0.1), cache.cost(one.strategy), demands, drag)
        for one in candidates
    ]
    order = ranked(scored)
    return push_proof(cache, order, outlooks(order, demands, drag), lambda stage, done: None), drag


def test_drags_shorter_than_every_push_needs_are_proved_impossible(cache) -> None:
    found, drag = proved(cache, ResetDemands(drag_ratio=0.2), own_candidate(LOOP), ResetCandidate("two", TWO))
    assert found is not None and (found.demand, found.beside) == ("drag", 0.05)
    assert set(found.pushes) == set(TWO.pushes) and found.limit == pytest.approx(0.2 * drag)
    lengths = [cache.cost(DrawnPushes((push,))).mean_drag_length for push in TWO.pushes]
    assert found.limit < found.lower <= 1.01 * float(np.max(lengths))


def test_an_allowance_below_what_a_rule_leaves_is_proved_impossible_or_nothing_is_said(cache) -> None:
    found, drag = proved(cache, ResetDemands(allow_tv=1e-5), ResetCandidate("two", TWO))
    own = cache.numbers(TWO, 1, 50, 0.1).tv
    assert found is None or (found.demand == "tv" and 1e-5 < found.lower <= own and found.beside > drag)


def test_nothing_is_proved_of_a_single_push_or_where_room_is_what_is_missed(cache) -> None:
    assert proved(cache, ResetDemands(allow_tv=1e-5), own_candidate(LOOP))[0] is None
    wide = ResetDemands(allow_tv=0.9, drag_ratio=9.0, reach=0.01)
    assert proved(cache, wide, ResetCandidate("two", TWO))[0] is None
