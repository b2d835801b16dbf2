"""Stages of further pushes: their order, where they stop, and that pushes which lose the object early come last."""

import math

import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.maps import WrappedNormal
from cyclemap.mechanics import SidePush
from cyclemap.resets.design import push_stages
from cyclemap.resets.design.action_cache import ActionCache
from cyclemap.resets.design.push_stages import widen
from cyclemap.resets.design.reset_candidates import EFFORTS
from cyclemap.resets.design.reset_demands import ResetDemands
from cyclemap.resets.design.reset_survey import ResetSurvey

NORMAL = EFFORTS["normal"]
SLANTED = SidePush(0, 0.15, math.radians(30.0), 0.15)


def survey(material: str = "delrin", keep_push: bool = False, **demands) -> ResetSurvey:
    cache = ActionCache(CollectionLoop.mit(material), WrappedNormal(0.1), tolerance=1e-2)
    return ResetSurvey(cache, ResetDemands(**demands), keep_push, lambda stage, done: None)


@pytest.mark.parametrize(("asked", "least", "whole"), [(None, 0.05, 0.075), (0.06, 0.06, 0.075), (0.1, 0.1, 0.1)])
def test_contact_may_be_half_the_push_then_a_third_or_what_is_asked_for(asked, least, whole) -> None:
    found = survey(contact=asked)
    assert found.contact_for(NORMAL) == pytest.approx(least)
    assert found.contact_for(NORMAL, whole=True) == pytest.approx(whole)


@pytest.mark.parametrize(
    ("meets_after", "asked", "kinds"),
    [
        (0, None, []),
        (1, None, ["outer"]),
        (2, None, ["outer", "slanted"]),
        (9, None, ["outer", "slanted", "brief"]),
        (9, 0.1, ["outer", "slanted"]),
    ],
)
def test_stages_follow_until_something_meets_the_demands(meets_after, asked, kinds, monkeypatch) -> None:
    looked: list[tuple[str, float]] = []
    monkeypatch.setattr(push_stages, "drawn_push_candidates", lambda *_: [])
    monkeypatch.setattr(ResetSurvey, "any_meets", property(lambda _: len(looked) >= meets_after))
    monkeypatch.setattr(
        ResetSurvey, "add_pushes", lambda _, pushes, stage, contact: looked.append((stage.split()[3], contact))
    )
    widen(survey(contact=asked), NORMAL)
    assert [kind for kind, _ in looked] == kinds
    contacts = [contact for _, contact in looked]
    assert contacts == sorted(contacts, reverse=True)
    widen(survey(keep_push=True), NORMAL)
    assert len(looked) == len(kinds)


def test_a_push_that_loses_the_object_early_is_put_aside_until_it_may_be_used() -> None:
    found = survey()
    contact = found.cache.contact(SLANTED)
    assert 0.04 < contact < 0.05
    assert not found.add_pushes([SLANTED], "maps", 0.05) and found.library is None
    (left,) = found.all_left_out
    assert left.name == "1 push at other places" and left.reason == "the rod loses the object after 48 to 48 mm"
    assert found.add_pushes([SLANTED], "maps", 0.04)
    assert found.library is not None and found.library.pushes == (SLANTED,) and found.all_left_out == ()
    assert not found.add_pushes([SLANTED], "maps", 0.04)
