"""More pushes, by stages, cheapest first, where those that were looked at do not meet the demands."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from cyclemap.mechanics import SidePush
from cyclemap.resets.design.reset_candidates import Effort
from cyclemap.resets.design.reset_survey import ResetSurvey
from cyclemap.resets.design.searched_candidates import drawn_push_candidates


@dataclass(frozen=True)
class PushStage:
    """Pushes that are looked at together. kind : in names. contact : m, shortest way of the rod in contact."""

    kind: str
    pushes: tuple[SidePush, ...]
    contact: float


def push_stages(survey: ResetSurvey, work: Effort) -> Iterator[PushStage]:
    """Further fractions; slanted pushes; and pushes that lose the object early, where the demands let them.

    >>> from cyclemap.collection.loop import CollectionLoop
    >>> from cyclemap.maps import WrappedNormal
    >>> from cyclemap.resets.design.action_cache import ActionCache
    >>> from cyclemap.resets.design.reset_candidates import EFFORTS
    >>> from cyclemap.resets.design.reset_demands import ResetDemands
    >>> cache = ActionCache(CollectionLoop.mit(), WrappedNormal(0.02))
    >>> stages = push_stages(ResetSurvey(cache, ResetDemands(), False, print), EFFORTS["normal"])
    >>> [(one.kind, len(one.pushes), round(1000 * one.contact)) for one in stages]
    [('outer', 8, 75), ('slanted', 32, 75), ('brief', 52, 50)]
    """
    places, wider = survey.places(work), survey.places(work, further=True)
    outer = tuple(push for push in wider.everywhere if push not in places.everywhere)
    slanted, whole = wider.slanted(work.angles, work.outer), survey.contact_for(work, whole=True)
    yield PushStage("outer", outer, whole)
    yield PushStage("slanted", slanted, whole)
    if survey.contact_for(work) < whole:
        yield PushStage("brief", (*wider.everywhere, *slanted), survey.contact_for(work))


def widen(survey: ResetSurvey, work: Effort) -> None:
    """Look at more and more pushes until something meets all demands."""
    for stage in push_stages(survey, work):
        if survey.any_meets or survey.keep_push:
            return
        if survey.add_pushes(stage.pushes, f"cycle maps of {stage.kind} pushes", stage.contact):
            found = drawn_push_candidates(survey, work, f"{stage.kind} ")
            survey.look(found, f"scoring {stage.kind} pushes")
