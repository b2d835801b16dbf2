"""Strategies whose numbers are searched for: how often each push is drawn, the ring's place, a gripper's least turn."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cyclemap.errors import CycleMapError
from cyclemap.resets.design.reset_candidates import Effort, ResetCandidate, ring_places
from cyclemap.resets.design.reset_survey import ResetSurvey
from cyclemap.resets.drawn_pushes.push_library import PushLibrary
from cyclemap.resets.drawn_pushes.push_weights import PushWeights, best_push_weights
from cyclemap.resets.strategies.action_cost import Pace
from cyclemap.resets.strategies.drag_strategies import GripperTurn
from cyclemap.resets.strategies.push_strategies import DrawnPushes
from cyclemap.resets.strategies.spread import Spread

# What is searched for keeps this share of the allowance, and of what may be left of the start, so that
# error bounds do not take it over.
_MARGIN, _SPEED_MARGIN = 0.96, 0.75
_FEW = 4
_WEIGHT_DIGITS = 4
# Steps of the search for a gripper's least turn; each halves the interval (a fifth of a degree is left).
_HALVINGS = 10


def drawn_push_candidates(survey: ResetSurvey, work: Effort, kind: str = "") -> list[ResetCandidate]:
    """Pushes drawn with the best weights that are found: the least drag, with few pushes and many; the least bias.

    kind : of pushes, in the names.
    """
    library = _within_reach(survey)
    if library is None or len(library.pushes) < 2:
        return []
    wanted, allowed = survey.demands, _MARGIN * survey.demands.allow_tv
    options: dict[str, Any] = {
        "within": wanted.within,
        "extra_tv": _SPEED_MARGIN * wanted.extra_tv,
        "starts": work.searches,
    }
    asked, most_drag = _drag_limit(survey), float(library.mean_drags.max())
    # A limit that no push keeps to is no limit of the search: what the evenness would cost is told instead.
    limit = asked if asked >= library.mean_drags.min() else most_drag
    aims: tuple[tuple[str, float | None, int | None], ...] = (
        (f"{kind}pushes of least drag", allowed, None),
        (f"at most {_FEW} {kind}pushes, least drag", allowed, _FEW),
        (f"{kind}pushes of least bias", None, None),
    )
    found, stage = [], f"searching for {kind}pushes"
    for number, (name, allow_tv, most) in enumerate(aims):
        best = best_push_weights(library, allow_tv=allow_tv, most_pushes=most, drag_limit=limit, **options)
        survey.progress(stage, (number + 1) / len(aims))
        if not (best.met or number):
            # Many pushes do no better where few cannot: the least bias is all that is left to look for.
            best = best_push_weights(library, drag_limit=limit, **options)
            found.append(ResetCandidate(aims[-1][0], rounded_pushes(best)))
            if limit < most_drag:
                best = best_push_weights(library, allow_tv=allowed, drag_limit=most_drag, **options)
                found.append(ResetCandidate(f"{name}, more than is allowed", rounded_pushes(best)))
            survey.progress(stage, 1.0)
            return found
        found.append(ResetCandidate(name, rounded_pushes(best)))
    return found


def rounded_pushes(best: PushWeights) -> DrawnPushes:
    """Return the pushes, drawn by weights of four digits, without those that hardly ever come."""
    weights = best.weights.round(_WEIGHT_DIGITS)
    pushes = tuple(push for push, weight in zip(best.pushes, weights, strict=True) if weight > 0.0)
    return DrawnPushes(pushes, weights=tuple(weights[weights > 0.0].tolist()))


def ring_candidates(survey: ResetSurvey, work: Effort) -> list[ResetCandidate]:
    """The place of the ring, among some nearer to the centre and further away, that leaves the least bias."""
    places, best, least = ring_places(survey.cache.loop, work.rings), None, math.inf
    for number, candidate in enumerate(places):
        try:
            left = survey.cache.kernel(candidate.strategy, candidate.nodes).quick_tv()
        except CycleMapError:
            continue
        finally:
            survey.progress("places of the ring", (number + 1) / len(places))
        if left < least:
            best, least = candidate, left
    return [] if best is None else [best]


def gripper_spread(survey: ResetSurvey) -> list[ResetCandidate]:
    """The narrowest even turn of a gripper, about none, that meets both total variations; found by halving.

    Where the bias does not fall with the width all along, a narrower one may do too.
    """
    enough, too_little = math.pi, 0.0
    for step in range(_HALVINGS):
        width = 0.5 * (enough + too_little)
        numbers = survey.cache.kernel(GripperTurn(Spread.within(0.0, width))).numbers(
            survey.demands.within, survey.demands.near_tv
        )
        meets = numbers.tv <= _MARGIN * survey.demands.allow_tv and numbers.tv_after <= survey.demands.near_tv
        enough, too_little = (width, too_little) if meets else (enough, width)
        survey.progress("turn of a gripper", (step + 1) / _HALVINGS)
    turn = Spread.within(0.0, enough)
    return [ResetCandidate(f"gripper, turn within ±{math.degrees(enough):.0f}°", GripperTurn(turn), 4)]


def _drag_limit(survey: ResetSurvey) -> float:
    """The largest mean drag (m) that keeps within the drag and the time allowed."""
    wanted, loop, pace = survey.demands, survey.cache.loop, survey.cache.pace or Pace()
    limit = wanted.drag_ratio * survey.own_drag
    if wanted.seconds is None:
        return limit
    return min(limit, (wanted.seconds - pace.handling) * pace.speed - loop.push.distance)


def _within_reach(survey: ResetSurvey) -> PushLibrary | None:
    """The pushes that keep within the room allowed; all of them where too few do to be drawn from."""
    library, limit = survey.library, survey.demands.reach
    if library is None or limit is None:
        return library
    reaches = [survey.cache.cost(DrawnPushes((push,)), 1).reach for push in library.pushes]
    kept = np.flatnonzero(np.array(reaches) <= limit)
    return library.only(kept.tolist()) if kept.size > 1 else library
