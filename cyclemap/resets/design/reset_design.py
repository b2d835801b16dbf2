"""Which reset to use: strategies scored, ranked and set against demands; the best there is where none meets them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import InvalidInput
from cyclemap.maps import Noise, WrappedNormal
from cyclemap.resets.design.action_cache import MAP_TOLERANCE, ActionCache
from cyclemap.resets.design.push_proof import PushProof, push_proof
from cyclemap.resets.design.push_stages import widen
from cyclemap.resets.design.reset_candidates import (
    Effort,
    ResetCandidate,
    combined_candidates,
    direction_nodes,
    effort,
    gripper_candidates,
    leg_candidates,
    push_candidates,
    scheduled_candidates,
)
from cyclemap.resets.design.reset_demands import ResetDemands
from cyclemap.resets.design.reset_ranking import DemandOutlook, ScoredReset, outlooks
from cyclemap.resets.design.reset_survey import LeftOutStrategy, Progress, ResetSurvey
from cyclemap.resets.design.searched_candidates import drawn_push_candidates, gripper_spread, ring_candidates
from cyclemap.resets.parameters.pareto_front import non_dominated
from cyclemap.resets.strategies.action_cost import Pace
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.strategy import ResetStrategy


@dataclass(frozen=True, eq=False)
class ResetDesign:
    """The strategies that were looked at, in order, and the one to use.

    ranking : as `ranked` orders them. own : the loop's own reset as it is. chosen : the first of the ranking
    that error bounds confirm; where they confirm none, the first. met : whether it meets all demands. outlooks : what
    can be had of each demand. left_out : what could not be looked at. cache : of the maps and costs. proof : that
    pushes which were looked at cannot do it, by any rule; None where the demands are met, or nothing is proved.
    """

    loop: CollectionLoop
    noise: Noise
    demands: ResetDemands
    keep_push: bool
    ranking: tuple[ScoredReset, ...]
    own: ScoredReset
    chosen: ScoredReset
    outlooks: tuple[DemandOutlook, ...]
    left_out: tuple[LeftOutStrategy, ...]
    cache: ActionCache
    proof: PushProof | None = None

    @property
    def met(self) -> bool:
        """Whether the chosen strategy meets all demands."""
        return self.chosen.meets

    @property
    def certified(self) -> bool:
        """Whether error bounds confirm that it does."""
        return self.met and self.chosen.certain

    @property
    def binding(self) -> tuple[DemandOutlook, ...]:
        """The demands that stand in the way: each that no strategy meets; else each that alone would have to be given
        up; else those that the chosen strategy misses. Empty where all are met."""
        if self.met:
            return ()
        hopeless = tuple(one for one in self.outlooks if one.out_of_reach)
        alone = tuple(one for one in self.outlooks if one.binds_alone)
        missed = {miss.demand for miss in self.chosen.misses}
        return hopeless or alone or tuple(one for one in self.outlooks if one.demand in missed)

    @property
    def front(self) -> tuple[ScoredReset, ...]:
        """Those that the robot can do and none other betters in both bias and mean drag, by rising drag."""
        able = [one for one in self.ranking if not one.lacking]
        best = non_dominated([(float(one.numbers.tv), one.cost.mean_drag_length) for one in able])
        kept = [one for one, use in zip(able, best.tolist(), strict=True) if use]
        return tuple(sorted(kept, key=lambda one: one.cost.mean_drag_length))

    @property
    def push_floor(self) -> float:
        """Room (m) about the target without which no push as long as the loop's can be made, wherever it begins.

        A straight way as long is nowhere nearer, at both its ends, than half its length.
        """
        return 0.5 * self.loop.push.distance + self.loop.pusher.radius

    @property
    def seconds_floor(self) -> float:
        """Time (s) of a push and of handling, before any drag."""
        return (self.cache.pace or Pace()).seconds(self.loop.push.distance, CycleAction())

    @property
    def with_more(self) -> tuple[ScoredReset, ...]:
        """Those that would meet all demands, if the robot could do what they need."""
        return tuple(one for one in self.ranking if one.lacking and not one.misses)


def design_reset(
    loop: CollectionLoop,
    demands: ResetDemands | None = None,
    noise: Noise | None = None,
    *,
    keep_push: bool = False,
    thoroughness: str | Effort = "normal",
    also: Sequence[ResetStrategy] = (),
    pace: Pace | None = None,
    tolerance: float = MAP_TOLERANCE,
    progress: Progress | None = None,
) -> ResetDesign:
    """Return the strategies for the loop, ranked: first what meets the demands, by mean drag.

    demands : those of `ResetDemands()`. noise : of a cycle; a wrapped normal of 1.1 degrees where None.
    keep_push : only the way back may change, every push is the loop's own. thoroughness : "quick", "normal" (about a
    minute), "thorough", or an `Effort`. also : strategies of one's own. pace : of the robot. tolerance : of the
    maps that strategies are compared by, rad. progress : called with what is being done and the fraction of it.

    Scores are quick ones, without error bounds, but for those of the first that meet the demands. Demands that none
    meets are no error: see `ResetDesign.binding` and `outlooks`. A strategy that leads out of the mechanics is left
    out and named. Raises InvalidInput for bad values, and what the loop's own reset raises.
    """
    wanted, work, report = demands or ResetDemands(), effort(thoroughness), progress or (lambda stage, done: None)
    if not isinstance(wanted, ResetDemands):
        raise InvalidInput(f"the demands are {demands!r}: give ResetDemands(allow_tv=0.05, ...)")
    cache = ActionCache(loop, noise or WrappedNormal(DEFAULT_SIGMA), tolerance, pace=pace)
    survey = ResetSurvey(cache, wanted, keep_push, report)
    survey.look_at_pushes(work)
    survey.look(_candidates(survey, work, also), "scoring strategies")
    survey.look(drawn_push_candidates(survey, work), "scoring pushes that were searched for")
    widen(survey, work)
    survey.look(scheduled_candidates(survey.best_drawn), "scoring schedules")
    survey.look([*ring_candidates(survey, work), *gripper_spread(survey)], "scoring ring and gripper")
    survey.confirm(work.certified)
    order = survey.order
    sure = (one for one in order if one.meets and one.certain)
    found = outlooks(order, wanted, survey.own_drag)
    left_out, chosen = survey.all_left_out, next(sure, order[0])
    proof = None if chosen.meets else push_proof(cache, order, found, report)
    return ResetDesign(loop, cache.noise, wanted, keep_push, order, survey.own, chosen, found, left_out, cache, proof)


def _candidates(survey: ResetSurvey, work: Effort, also: Sequence[ResetStrategy]) -> list[ResetCandidate]:
    """All that needs no search, and strategies of one's own."""
    places, drag = survey.places(work), survey.own_drag
    work = replace(work, nodes=direction_nodes(survey.cache.loop, work))
    own = [ResetCandidate(name, one, work.nodes) for name, one in zip(_given_names(also), also, strict=True)]
    drags = leg_candidates(work, drag)
    return [*own, *push_candidates(places), *drags, *combined_candidates(places, work, drag), *gripper_candidates()]


def _given_names(also: Sequence[ResetStrategy]) -> list[str]:
    """Names of strategies of one's own, with numbers where several are called the same."""
    names = [one.name for one in also]
    numbers = [f", {names[:at].count(name) + 1}" if names.count(name) > 1 else "" for at, name in enumerate(names)]
    return [f"{name} (given{number})" for name, number in zip(names, numbers, strict=True)]
