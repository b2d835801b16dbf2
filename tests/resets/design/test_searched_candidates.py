"""Searched pushes: within the limits asked for, and, where no push keeps to a limit, what evenness would cost."""

import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.maps import WrappedNormal
from cyclemap.mechanics import SidePush
from cyclemap.resets.design.action_cache import ActionCache
from cyclemap.resets.design.reset_candidates import EFFORTS
from cyclemap.resets.design.reset_demands import ResetDemands
from cyclemap.resets.design.reset_survey import ResetSurvey
from cyclemap.resets.design.searched_candidates import drawn_push_candidates
from cyclemap.resets.strategies.push_strategies import DrawnPushes

QUICK = EFFORTS["quick"]
PUSHES = (SidePush(2, 0.7), SidePush(3, 0.3), SidePush(0, 0.3))


@pytest.fixture(scope="module")
def cache() -> ActionCache:
    return ActionCache(CollectionLoop.mit(), WrappedNormal(0.05), tolerance=1e-2)


def found(cache: ActionCache, **demands: float) -> dict[str, tuple[float, float]]:
    """Total variation and mean drag (m) of what is found, by name."""
    survey = ResetSurvey(cache, ResetDemands(**demands), False, lambda stage, done: None)
    assert survey.add_pushes(PUSHES, "maps")
    made = drawn_push_candidates(survey, QUICK)
    kernels = {one.name: cache.kernel(one.strategy, 1) for one in made}
    return {one.name: (kernels[one.name].quick_tv(), cache.cost(one.strategy, 1).mean_drag_length) for one in made}


def test_where_no_push_keeps_to_the_drag_the_least_drag_of_an_even_reset_is_found(cache) -> None:
    """As if no drag were asked for: the answer then tells what the demand on evenness costs."""
    free, impossible = found(cache), found(cache, drag_ratio=0.1)
    assert set(free) == set(impossible) and "pushes of least drag" in free
    for name, numbers in free.items():
        assert impossible[name] == pytest.approx(numbers, abs=2e-3)
        assert numbers[0] <= 0.05 and numbers[1] > 0.05


def test_where_no_push_keeps_to_the_room_the_search_is_not_given_up(cache) -> None:
    assert found(cache, reach=0.1)["pushes of least drag"] == pytest.approx(found(cache)["pushes of least drag"])


def test_where_an_even_reset_needs_more_drag_than_is_allowed_both_ends_are_told(cache) -> None:
    """The least bias within the drag, and the drag of a bias within the allowance."""
    drags = sorted(cache.cost(DrawnPushes((push,)), 1).mean_drag_length for push in PUSHES)
    own = cache.cost(DrawnPushes((cache.loop.push,)), 1).mean_drag_length
    made = found(cache, drag_ratio=(drags[0] + 1e-4) / own)
    assert list(made) == ["pushes of least bias", "pushes of least drag, more than is allowed"]
    (least_bias, within), (even, beyond) = made.values()
    assert least_bias > 0.05 >= even and within < beyond
