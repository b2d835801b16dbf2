"""A designed reset in sentences: which one, what it leaves, what it costs, and why where none meets the demands."""

from __future__ import annotations

import math
from collections.abc import Callable

from cyclemap.mechanics import SidePush
from cyclemap.resets.design.reset_demands import CONTACT, DRAG, LENGTHS, REACH, SECONDS, TV, TV_AFTER, Miss
from cyclemap.resets.design.reset_design import ResetDesign
from cyclemap.resets.design.reset_ranking import DemandOutlook, ScoredReset
from cyclemap.resets.design.reset_trial import ResetTrial, SampledStatistic
from cyclemap.resets.drawn_pushes.push_library import LEAST_SHARE
from cyclemap.resets.strategies.combined import Combined
from cyclemap.resets.strategies.push_strategies import PushChoice
from cyclemap.resets.strategies.schedules import INDEPENDENT
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.views.sentences import number

_MOST_PUSHES = 8
# Metres: a push whose contact ends this shortly before its end keeps the object.
_LOST = 1e-4


def reset_sentences(design: ResetDesign) -> tuple[str, ...]:
    """The whole answer; the first sentence is the verdict."""
    told = [verdict_sentence(design), what_to_do(design.chosen.candidate.strategy, design.cache.contact)]
    told += [brief_sentence(design), own_sentence(design)]
    return tuple(filter(None, (*told, *reason_sentences(design), left_out_sentence(design))))


def reason_sentences(design: ResetDesign) -> tuple[str, ...]:
    """Why no strategy meets the demands, and what would; none where one does."""
    if design.met:
        return ()
    told = [binding_sentence(design), *(outlook_sentence(design, one) for one in design.binding)]
    return tuple(filter(None, (*told, proof_sentence(design), more_sentence(design))))


def verdict_sentence(design: ResetDesign) -> str:
    """Whether the demands are met, and by what."""
    chosen, name = design.chosen, design.loop.material.name
    scores = f"{scores_words(chosen)}; {cost_words(chosen)}"
    if not design.met:
        missed = " and ".join(miss_words(miss) for miss in chosen.misses) or f"needs {', '.join(chosen.lacking)}"
        return f"NO RESET MEETS ALL DEMANDS on {name}. The nearest, “{chosen.name}”, misses {missed}: {scores}."
    sure = "" if design.certified else " (error bounds do not confirm it)"
    return f"{name}: “{chosen.name}” meets all demands{sure}: {scores}."


def scores_words(one: ScoredReset) -> str:
    """Bias, speed and worth of a strategy."""
    found = one.numbers
    bound = f" ± {found.tv.error_bound:.1g}" if found.bounded and found.tv.error_bound < 1.0 else ""
    late = f"{found.tv_after:.3f} after {found.within} pushes from the worst start"
    return f"total variation from uniform {found.tv:.3f}{bound} in the long run, {late}"


def cost_words(one: ScoredReset) -> str:
    """Drag, time and room of a strategy."""
    cost = one.cost
    drag = f"mean drag {1000 * cost.mean_drag_length:.0f} mm ({one.drag_ratio:.2f} of the loop's own)"
    return f"{drag}, {cost.mean_seconds:.1f} s a cycle, room {1000 * cost.reach:.0f} mm about the target"


def own_sentence(design: ResetDesign) -> str:
    """What the loop's own reset does, unless it is the chosen one."""
    own = design.own
    if own is design.chosen:
        return ""
    worth = own.numbers.effective_per_100
    return (
        f"As it is: total variation {own.numbers.tv:.3f}, 100 pushes are worth {number(worth)}, "
        f"mean drag {1000 * own.cost.mean_drag_length:.0f} mm."
    )


def what_to_do(strategy: ResetStrategy, contact: Callable[[SidePush], float]) -> str:
    """The pushes of a strategy and how often each comes; empty where it has no pushes of its own.

    contact : gives the shortest way (m) of the rod in contact in a push; told where the object is lost before its end.
    """
    parts = strategy.parts if isinstance(strategy, Combined) else (strategy,)
    choices = [part for part in parts if isinstance(part, PushChoice)]
    if not choices or len(choices[0].pushes) > _MOST_PUSHES:
        return ""
    pushes, chances = choices[0].pushes, choices[0].chances.tolist()
    listed = ", ".join(
        f"{push_words(push)} ({chance:.1%}{_lost_words(push, contact(push))})"
        for push, chance in zip(pushes, chances, strict=True)
    )
    return f"{_order_words(choices[0])}: {listed}."


def _order_words(choice: PushChoice) -> str:
    if choice.name == "alternating pushes":
        return "In turn"
    schedule = choice.schedule
    orders = {"GoldenAngle": "by golden angle ", "LatinBlocks": "in Latin blocks "}
    order = "" if schedule.kind == INDEPENDENT else orders.get(type(schedule).__name__, f"by {schedule} ")
    return f"Draw {order}before every push"


def _lost_words(push: SidePush, contact: float) -> str:
    lost = contact < push.distance - _LOST
    return f", the object lost after {1000 * contact:.0f} mm" if lost else ""


def brief_sentence(design: ResetDesign) -> str:
    """That the chosen pushes lose the object before half their way, and how to forbid it; empty where they do not."""
    distance, contact = design.loop.push.distance, design.chosen.contact
    if contact >= LEAST_SHARE * distance:
        return ""
    return (
        f"Its pushes lose the object early: from some orientation after {1000 * contact:.0f} mm of "
        f"{1000 * distance:.0f} mm, so that they record less; --least-push-mm forbids it."
    )


def push_words(push: SidePush) -> str:
    """Where a push is made.

    >>> push_words(SidePush(2, 0.7)), push_words(SidePush(0, 0.3, 0.5))
    ('side 2 at 0.70', 'side 0 at 0.30, +29°')
    """
    slanted = f", {math.degrees(push.angle):+.0f}°" if push.angle else ""
    return f"side {push.side} at {push.fraction:.2f}{slanted}"


def miss_words(miss: Miss) -> str:
    """A demand that is missed, with its numbers."""
    value, limit = amount(miss.demand, miss.value), amount(miss.demand, miss.limit)
    asked = "is asked for" if miss.demand == CONTACT else "is allowed"
    return f"{DEMAND_WORDS[miss.demand]} ({value} where {limit} {asked})"


def binding_sentence(design: ResetDesign) -> str:
    """Which demands stand in the way."""
    names = " and ".join(DEMAND_WORDS[one.demand] for one in design.binding)
    if any(one.out_of_reach for one in design.binding):
        return f"No strategy that was looked at meets the demand on {names}, whatever else is given up."
    if any(one.binds_alone for one in design.binding):
        return f"What binds: {names}; the other demands can be met together."
    return f"Every demand can be met, but not together: {names} stand against each other."


def outlook_sentence(design: ResetDesign, one: DemandOutlook) -> str:
    """What can be had of a demand."""

    def say(value: float) -> str:
        return amount(one.demand, value)

    asked = "is asked for" if one.demand == CONTACT else "is allowed"
    told = f"{DEMAND_WORDS[one.demand].capitalize()}: {say(one.limit)} {asked}"
    told += (
        f"; the {'longest' if one.demand == CONTACT else 'least'} of any is {say(one.least)} (“{one.least_by.name}”)"
    )
    if one.least_with_others is not None and one.with_others_by is not None and one.with_others_by is not one.least_by:
        told += f", {say(one.least_with_others)} with all other demands met (“{one.with_others_by.name}”)"
    if one.demand == REACH:
        told += f". A push of {1000 * design.loop.push.distance:.0f} mm alone takes {1000 * design.push_floor:.0f} mm"
    if one.demand == SECONDS:
        told += f". Push and handling alone take {design.seconds_floor:.1f} s"
    return f"{told}."


def proof_sentence(design: ResetDesign) -> str:
    """What no rule can do with the best of the pushes; empty where nothing is proved."""
    proof = design.proof
    if proof is None:
        return ""
    pushes, lower = ", ".join(push_words(push) for push in proof.pushes), amount(proof.demand, proof.lower)
    if proof.demand == TV:
        what = f"total variation {lower} in the long run with a mean drag of at most {amount(DRAG, proof.beside)}"
    else:
        what = f"a mean drag of {lower} with a total variation of at most {amount(TV, proof.beside)}"
    return f"Proved: no rule with the pushes {pushes}, even one that looks at the orientation, gets below {what}."


def more_sentence(design: ResetDesign) -> str:
    """What the robot could do if it could do more; empty where it already does, or that would not help."""
    if design.met or not design.with_more:
        return ""
    first = design.with_more[0]
    needs = " and ".join(first.lacking)
    return f"With more ({needs}) “{first.name}” would meet all demands: {scores_words(first)}."


def left_out_sentence(design: ResetDesign) -> str:
    """What could not be looked at; empty where that is nothing."""
    if not design.left_out:
        return ""
    return "Left out: " + "; ".join(f"{one.name} ({one.reason.split(':')[0]})" for one in design.left_out) + "."


def trial_sentence(trial: ResetTrial) -> str:
    """How a run by the full mechanics compares with the prediction."""
    verdict, size = ("agree with", "nothing") if trial.agrees else ("DISAGREE with", "something")
    return (
        f"{trial.pushes} pushes by the full mechanics {verdict} the prediction ({size} is larger than in 99 of 100 "
        f"predicted runs): total variation from uniform in {trial.bins} bins {_range(trial.total_variation)}, Kuiper's "
        f"distance {_range(trial.kuiper)}, distance from the predicted law {_range(trial.misfit, 'nearer')}."
    )


def _range(found: SampledStatistic, small: str = "more even") -> str:
    below = f", below them: {small} than predicted" if found.value < found.low else ""
    return f"{found.value:.3f} (95 % of predicted runs {found.low:.3f} to {found.high:.3f}{below})"


DEMAND_WORDS = {
    TV: "total variation from uniform",
    TV_AFTER: "total variation from the worst start",
    DRAG: "mean drag",
    REACH: "room about the target",
    SECONDS: "time of a cycle",
    CONTACT: "contact in a push",
}


def amount(demand: str, value: float) -> str:
    """A value that a demand is about, with its unit.

    >>> amount("tv", 0.0481), amount("drag", 0.0726), amount("seconds", 21.0)
    ('0.048', '73 mm', '21.0 s')
    """
    if demand in LENGTHS:
        return f"{1000 * value:.0f} mm"
    if demand == SECONDS:
        return f"{value:.1f} s"
    return f"{value:.3f}" if value >= 0.001 else f"{value:.1g}"


def standing(one: ScoredReset) -> str:
    """In a word or two: that it meets the demands, or why not."""
    missed = ", ".join(SHORT_WORDS[miss.demand] for miss in one.misses)
    if one.lacking:
        return f"would need {' and '.join(one.lacking)}" + (f"; misses {missed}" if missed else "")
    if missed:
        return f"misses {missed}"
    if one.certain:
        return "meets all"
    return "meets all, within error" if one.numbers.bounded else "meets all, no bounds taken"


SHORT_WORDS = {TV: "TV", TV_AFTER: "TV after", DRAG: "drag", REACH: "room", SECONDS: "time", CONTACT: "contact"}
