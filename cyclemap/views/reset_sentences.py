"""A reset in sentences: what to do, what it leaves, what it costs."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cyclemap.mechanics import SidePush
from cyclemap.resets import CycleAction, ResetDesign, ResetRow, ResetStrategy
from cyclemap.views.sentences import angle

# More actions or way-points than this are counted, not told one by one.
_MOST_TOLD = 6
_DRAWS = {2: "toss a coin", 4: "toss two coins", 6: "throw a die"}
ROLES = {
    "chosen": "chosen", "simplest": "simplest", "evenest": "most uniform", "cheapest": "cheapest",
    "way back": "way back only", "gripper": "with a gripper", "yours": "yours", "as it is": "as it is",
}  # fmt: skip
COLUMNS = ("", "what to do", "long run", "at worst", "after, worst", "histogram", "drag", "cycle", "contact")
_UNITS = {"drag": (1e3, " mm"), "reach": (1e3, " mm"), "contact": (1e3, " mm"), "seconds": (1.0, " s")}
DEMANDS = {
    "tv": "total variation in the long run",
    "after": "total variation after the pushes allowed",
    "drag": "mean drag",
    "seconds": "time of a cycle",
    "reach": "room about the target",
    "contact": "shortest contact",
}


def action_words(action: CycleAction) -> str:
    """The push, the drag and the gripper's turn of a cycle; what the loop does of itself is left out.

    >>> action_words(CycleAction(((0.05, 0.0),), SidePush(side=1, distance=0.08), math.pi / 6))
    'push 80 mm on side 1 at 0.7, drag by 50 mm at 0.0°, gripper 30.0°'
    >>> action_words(CycleAction()), action_words(CycleAction(()))
    ('as the loop does', 'straight drag')
    """
    push, told = action.push, []
    if push is not None:
        told.append(f"push {1e3 * push.distance:.4g} mm on side {push.side}{_place(push)}")
    if action.way_points is not None:
        places = [f"{1e3 * math.hypot(x, y):.4g} mm at {angle(math.atan2(y, x))}" for x, y in action.way_points]
        more = f", and {len(places) - _MOST_TOLD} places more" if len(places) > _MOST_TOLD else ""
        told.append(f"drag by {', then '.join(places[:_MOST_TOLD])}{more}" if places else "straight drag")
    if action.turn:
        told.append(f"gripper {angle(action.turn)}")
    return ", ".join(told) or "as the loop does"


def _place(push: SidePush) -> str:
    slant = f", {angle(push.angle, 0)} off its normal" if push.angle else ""
    return f" at {push.fraction:.4g}{slant}"


def recipe(strategy: ResetStrategy) -> str:
    """What a robot program has to do, in one sentence.

    >>> recipe(ResetStrategy.pushes(SidePush(), (1, 2)))
    'before every push toss a coin: heads push side 1, tails push side 2, each at 0.7'
    """
    ring = ""
    if strategy.hitch is not None:
        ring = f"put the ring at ({1e3 * strategy.hitch[0]:.1f}, {1e3 * strategy.hitch[1]:.1f}) mm of the object; "
    actions = strategy.actions
    if len(actions) == 1:
        return ring + ("leave everything as it is" if actions[0] == CycleAction() else f"always {_one(actions[0])}")
    if strategy.weights is None and strategy.order == "random":
        if (turns := _equal_turns(actions)) is not None:
            return f"{ring}after every drag let a gripper turn the object by {turns}, drawn at random"
        if (length := _leg_length(actions)) is not None:
            ways = f"one of {len(actions)} equal directions, drawn at random"
            return f"{ring}drag back by a place {1e3 * length:.4g} mm off the target, in {ways}"
    shuffled = f"in shuffled blocks of {sum(strategy.counts)}"
    ordered = {"random": "drawn before every push", "in turn": "in turn"}.get(strategy.order, shuffled)
    if len(actions) > _MOST_TOLD:
        return f"{ring}take one of {len(actions)} actions, {ordered} (see the protocol file)"
    return ring + _listed(strategy, ordered)


def _listed(strategy: ResetStrategy, ordered: str) -> str:
    actions, common = strategy.actions, ""
    pushes = [action.push for action in actions if action.push is not None]
    plain = len(pushes) == len(actions) and all(action == CycleAction(push=action.push) for action in actions)
    plain = plain and len({push.distance for push in pushes}) == 1
    if plain and len({(push.fraction, push.angle) for push in pushes}) == 1:
        common, words = f", each{_place(pushes[0])}", [f"push side {push.side}" for push in pushes]
    else:
        words = [_one(action) if plain else action_words(action) for action in actions]
    if strategy.order != "random":
        return f"{ordered}: {', '.join(words)}{common}"
    parts = (1.0,) * len(words) if strategy.weights is None else strategy.weights
    whole = [round(part) for part in parts]
    if any(abs(part - near) > 1e-9 for part, near in zip(parts, whole, strict=True)):
        shares = ", ".join(f"{share:.1%} {word}" for share, word in zip(strategy.shares.tolist(), words, strict=True))
        return f"before every push draw: {shares}{common}"
    if whole == [1, 1]:
        return f"before every push toss a coin: heads {words[0]}, tails {words[1]}{common}"
    lots = ", ".join(f"{count} of {sum(whole)} {word}" for count, word in zip(whole, words, strict=True))
    return f"before every push {_DRAWS.get(sum(whole), f'draw one of {sum(whole)} lots')}: {lots}{common}"


def _one(action: CycleAction) -> str:
    if action.push is not None and action == CycleAction(push=action.push):
        return f"push side {action.push.side}{_place(action.push)}"
    return action_words(action)


def _equal_turns(actions: Sequence[CycleAction]) -> str | None:
    step = 2.0 * math.pi / len(actions)
    alone = all(action.push is None and action.way_points is None for action in actions)
    if not alone or any(abs(action.turn - step * number) > 1e-9 for number, action in enumerate(actions)):
        return None
    return {2: "a half turn or not", 4: "0, 90, 180 or 270°"}.get(len(actions), f"a multiple of {angle(step, 0)}")


def _leg_length(actions: Sequence[CycleAction]) -> float | None:
    points = [action.way_points for action in actions if action.way_points and action.push is None and not action.turn]
    lengths = {round(math.hypot(*point[0]), 9) for point in points if len(point) == 1}
    return lengths.pop() if len(points) == len(actions) and len(lengths) == 1 else None


def design_sentences(design: ResetDesign) -> tuple[str, str, str]:
    """What to do, what that leaves, what it costs."""
    row, own, about, pushes = design.chosen, design.rows[-1], design.about, design.demands.pushes
    told = f", {about.told}" if about.told else ""
    materials = f"{len(about.materials)} materials{told}" if about.others else "that material alone"
    steered = design.orders.get("steered")
    seeing = "" if steered is None else f"; chosen from what is seen (cyclemap watch --protocol) {steered:.3f}"
    left = (
        f"What it leaves: {row.nominal.total_variation:.3f} of total variation from uniform in the long run, "
        f"{row.nominal.after:.3f} after {design.demands.within} pushes from the worst start; at the worst of "
        f"{materials} {row.worst:.3f} and {row.worst_after:.3f}; a histogram of {pushes} pushes in 36 bins lies "
        f"{row.histogram[0]:.3f} ± {row.histogram[1]:.3f} from uniform, {row.worst_histogram[0]:.3f} at worst, that of "
        f"independent uniform ones {design.independent:.3f}, of the loop as it is {own.histogram[0]:.3f}{seeing}."
    )
    cost = (
        f"What it costs: {1e3 * row.drag:.0f} mm of drag ({row.drag / own.drag:.2f} of now), {row.seconds:.1f} s a "
        f"cycle, {1e3 * row.room:.0f} mm of room about the target, shortest contact {1e3 * row.contact:.0f} mm."
    )
    return f"What to do: {recipe(row.strategy)}.", left, cost


def miss_sentences(design: ResetDesign) -> tuple[str, ...]:
    """Where nothing meets the demands: what the nearest misses, and what any reset considered reaches of it."""
    if design.met:
        return ()
    missed = ", ".join(DEMANDS[name] for name in design.chosen.misses) or "none by itself"
    told = [f"Nothing that was considered meets all demands. The nearest is told; it misses: {missed}."]
    for limit in design.binding:
        scale, unit = _UNITS.get(limit.demand, (1.0, ""))
        best = f"{'most' if limit.demand == 'contact' else 'least'} {DEMANDS[limit.demand]}"
        told.append(f"The {best} considered is {scale * limit.value:.3g}{unit}: {recipe(limit.strategy)}.")
    return tuple(told)


def row_cells(row: ResetRow) -> tuple[str, ...]:
    """A row as words, in the order of `COLUMNS`; a row that misses a demand says so."""
    told = ", ".join(ROLES[role] for role in row.roles) + (" (misses)" if row.misses else "")
    numbers = (row.nominal.total_variation, row.worst, row.worst_after, row.histogram[0])
    costs = f"{1e3 * row.drag:.0f} mm", f"{row.seconds:.1f} s", f"{1e3 * row.contact:.0f} mm"
    return told, recipe(row.strategy), *(f"{number:.3f}" for number in numbers), *costs
