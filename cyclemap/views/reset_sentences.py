"""A reset in sentences: what to do, what it leaves, what it costs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cyclemap.mechanics import SidePush
from cyclemap.resets import CycleAction, ResetDesign, ResetRow, ResetStrategy
from cyclemap.views.sentences import angle

# More actions or way-points than this are counted, not told one by one.
_MOST_TOLD = 6
_DRAWS = {2: "toss a coin", 4: "toss two coins", 6: "throw a die"}
COLUMNS = ("", "what to do", "long run", "at worst", "after, worst", "histogram", "drag", "cycle", "contact")
# What each demand is of, in how many of which units.
_DEMANDS = {
    "tv": ("total variation in the long run", 1.0, ""),
    "after": ("total variation after the pushes allowed", 1.0, ""),
    "drag": ("mean drag", 1e3, " mm"),
    "seconds": ("time of a cycle", 1.0, " s"),
    "reach": ("room about the target", 1e3, " mm"),
    "contact": ("shortest contact", 1e3, " mm"),
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
    ring, actions, order = "", strategy.actions, strategy.order
    if strategy.hitch is not None:
        ring = f"put the ring at ({1e3 * strategy.hitch[0]:.1f}, {1e3 * strategy.hitch[1]:.1f}) mm of the object; "
    words, common = _named(actions)
    if len(actions) == 1:
        return ring + ("leave everything as it is" if actions[0] == CycleAction() else f"always {words[0]}{common}")
    if strategy.weights is None and order == "random" and (round_about := _round_about(actions)):
        return f"{ring}{round_about}, drawn at random"
    shuffled = f"in shuffled blocks of {sum(strategy.counts)}"
    ordered = {"random": "drawn before every push", "in turn": "in turn"}.get(order, shuffled)
    if len(actions) > _MOST_TOLD:
        return f"{ring}take one of {len(actions)} actions, {ordered} (see the protocol file)"
    if order != "random":
        return f"{ring}{ordered}: {', '.join(words)}{common}"
    parts = np.array(strategy.weights or (1.0,) * len(words))
    if not np.allclose(parts, parts.round(), rtol=0.0, atol=1e-9):
        shares = [f"{share:.1%} {word}" for share, word in zip(strategy.shares.tolist(), words, strict=True)]
        return f"{ring}before every push draw: {', '.join(shares)}{common}"
    counts, lots = [round(part) for part in parts.tolist()], round(parts.sum())
    if counts == [1, 1]:
        return f"{ring}before every push toss a coin: heads {words[0]}, tails {words[1]}{common}"
    told = ", ".join(f"{count} of {lots} {word}" for count, word in zip(counts, words, strict=True))
    return f"{ring}before every push {_DRAWS.get(lots, f'draw one of {lots} lots')}: {told}{common}"


def _named(actions: Sequence[CycleAction]) -> tuple[list[str], str]:
    """Each action in words, and what is common to them: pushes of one length go by side and place alone."""
    pushes = [action.push for action in actions if action.push is not None and action == CycleAction(push=action.push)]
    if len(pushes) < len(actions) or len({push.distance for push in pushes}) > 1:
        return [action_words(action) for action in actions], ""
    if len({(push.fraction, push.angle) for push in pushes}) > 1 or len(pushes) == 1:
        return [f"push side {push.side}{_place(push)}" for push in pushes], ""
    return [f"push side {push.side}" for push in pushes], f", each{_place(pushes[0])}"


def _round_about(actions: Sequence[CycleAction]) -> str:
    """Turns of a gripper, or legs of one length, in all directions, as one; empty where they are not these."""
    count, step = len(actions), 2.0 * math.pi / len(actions)
    ways = [action.way_points or () for action in actions if action.push is None]
    if len(ways) == count and not any(ways):
        by = {2: "a half turn or not", 4: "0, 90, 180 or 270°"}.get(count, f"a multiple of {angle(step, 0)}")
        even = np.allclose([action.turn for action in actions], step * np.arange(count), rtol=0.0, atol=1e-9)
        return f"after every drag let a gripper turn the object by {by}" if even else ""
    lengths = {round(1e3 * math.hypot(*way[0]), 6) for way in ways if len(way) == 1}
    if [len(way) for way in ways] != [1] * count or len(lengths) > 1 or any(action.turn for action in actions):
        return ""
    return f"drag back by a place {lengths.pop():.4g} mm off the target, in one of {count} equal directions"


def design_sentences(design: ResetDesign) -> tuple[str, str, str]:
    """What to do, what that leaves, what it costs."""
    row, own, about, pushes = design.chosen, design.rows[-1], design.about, design.demands.pushes
    of = [f"{len(about.materials)} materials", about.told] if about.others else ["that material alone"]
    steered = design.orders.get("steered")
    seeing = "" if steered is None else f"; chosen from what is seen (cyclemap watch --protocol) {steered:.3f}"
    left = (
        f"What it leaves: {row.nominal.total_variation:.3f} of total variation from uniform in the long run, "
        f"{row.nominal.after:.3f} after {design.demands.within} pushes from the worst start; at the worst of "
        f"{', '.join(filter(None, of))} {row.worst:.3f} and {row.worst_after:.3f}; a histogram of {pushes} pushes in "
        f"36 bins lies {row.histogram[0]:.3f} ± {row.histogram[1]:.3f} from uniform, {row.worst_histogram[0]:.3f} at "
        f"worst, that of independent uniform ones {design.independent:.3f}, of the loop as it is "
        f"{own.histogram[0]:.3f}{seeing}."
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
    missed = ", ".join(_DEMANDS[name][0] for name in design.chosen.misses) or "none by itself"
    told = [f"Nothing that was considered meets all demands. The nearest is told; it misses: {missed}."]
    for limit in design.binding:
        (of, scale, unit), least = _DEMANDS[limit.demand], "most" if limit.demand == "contact" else "least"
        told.append(f"The {least} {of} considered is {scale * limit.value:.3g}{unit}: {recipe(limit.strategy)}.")
    return tuple(told)


def row_cells(row: ResetRow) -> tuple[str, ...]:
    """A row as words, in the order of `COLUMNS`; a row that misses a demand says so."""
    numbers = (row.nominal.total_variation, row.worst, row.worst_after, row.histogram[0])
    costs = f"{1e3 * row.drag:.0f} mm", f"{row.seconds:.1f} s", f"{1e3 * row.contact:.0f} mm"
    told = ", ".join(row.roles) + (" (misses)" if row.misses else "")
    return told, recipe(row.strategy), *(f"{number:.3f}" for number in numbers), *costs
