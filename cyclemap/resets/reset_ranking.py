"""The ranking: what is demanded of a reset, which of many candidates meets it, and which of those
to take.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array, Mask, Whole
from cyclemap.checks import finite_number, positive_number, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.protocol.strategy import GRIPPER, RING, CycleAction, ResetStrategy
from cyclemap.resets.action_cycles import room_needed, seconds
from cyclemap.resets.reset_search import Candidates
from cyclemap.resets.strategy_run import independent_distance

ABILITIES = (GRIPPER, RING)
# The roles of the rows, in the order in which they are told.
CHOSEN = "chosen"
SIMPLEST = "simplest"
EVENEST = "most uniform"
CHEAPEST = "cheapest"
WAY_BACK = "way back only"
WITH_GRIPPER = "with a gripper"
GIVEN = "yours"
AS_IT_IS = "as it is"
# The best of the resets where the loop is left as it is.
RESET = "best reset"
# Pushes of a collection that is simulated for its histogram.
MOST_PUSHES = 10_000
# The loop as it is.
OWN = ResetStrategy((CycleAction(),))
# Demands by name.
TV, AFTER, DRAG, SECONDS, REACH, CONTACT = "tv", "after", "drag", "seconds", "reach", "contact"

# Two resets are equally uniform where they differ by less than this share of what independent
# pushes miss it by.
_TELL_APART = 0.2
# Shares of what is allowed that the search's numbers keep to, one after the other, until a closer
# look agrees.
FIRM = (0.9, 0.8, 0.7, 0.6)
# Costs within this of each other are alike.
_SAME_COST = 1.05
# A reset nearly does it that leaves so many times what is allowed.
_NEARLY = 1.5
# Contact asked for by itself, as a share of the push; where no push holds it, the second.
CONTACTS = (2.0 / 3.0, 1.0 / 3.0)


@dataclass(frozen=True)
class ResetDemands:
    """What a reset must keep to, at the worst of the range of materials.

    Parameters
    ----------
    allow_tv : float, default 0.1
        Most total variation from uniform in the long run, in (0, 1).
    extra_tv : float, default 0.02
        How much more, at most, after `within` pushes from the worst start, in (0, 1).
    within : int, default 50
        After how many pushes that is asked.
    drag_ratio : float, default 2.0
        Most mean drag, in mean drags of the loop as it is.
    seconds : float or None, optional
        Most mean time of a cycle, s; None: any.
    reach : float or None, optional
        Most distance of rod or object from the target, m; None: any.
    contact : float or None, optional
        Least way of the rod in contact, in every push, m; None: two thirds of the push, or one
        where none holds two.
    abilities : tuple of str, default ()
        What the robot can do besides: "gripper", "ring" (another place of it).
    keep_push : bool, default False
        Every push stays the loop's own.
    pushes : int, default 500
        How many will be collected.

    Raises
    ------
    InvalidInput
        For a value out of its range.

    Examples
    --------
    >>> from cyclemap.resets import ResetDemands
    >>> round(ResetDemands(allow_tv=0.1, extra_tv=0.02).allow_after, 3)
    0.12
    """

    allow_tv: float = 0.10
    extra_tv: float = 0.02
    within: int = 50
    drag_ratio: float = 2.0
    seconds: float | None = None
    reach: float | None = None
    contact: float | None = None
    abilities: tuple[str, ...] = ()
    keep_push: bool = False
    pushes: int = 500

    def __post_init__(self) -> None:
        for name in ("allow_tv", "extra_tv"):
            if not 0.0 < finite_number(name, getattr(self, name)) < 1.0:
                raise InvalidInput(
                    f"{name} is {getattr(self, name):g}: a total variation allowed lies between "
                    "0 and 1"
                )
        for name in ("within", "pushes"):
            object.__setattr__(self, name, whole_number(name, getattr(self, name), least=1))
            if getattr(self, name) > MOST_PUSHES:
                raise InvalidInput(
                    f"{name} is {getattr(self, name)}: more than {MOST_PUSHES} are not simulated"
                )
        for name in ("drag_ratio", "seconds", "reach", "contact"):
            if getattr(self, name) is not None:
                positive_number(name, getattr(self, name))
        for ability in self.abilities:
            if ability not in ABILITIES:
                raise InvalidInput(
                    f"ability {ability!r} is not known: give {' or '.join(map(repr, ABILITIES))}"
                )

    @property
    def allow_after(self) -> float:
        """Most total variation after `within` pushes from the worst start."""
        return min(1.0, self.allow_tv + self.extra_tv)


@dataclass(frozen=True)
class Limit:
    """A demand that binds.

    Attributes
    ----------
    demand : str
        Its name.
    value : float
        The least (of contact the most) that any reset considered reaches of it.
    strategy : ResetStrategy
        Which one does.

    Examples
    --------
    >>> from cyclemap import SidePush
    >>> from cyclemap.resets import Limit, ResetStrategy
    >>> Limit("drag_ratio", 2.4, ResetStrategy.pushes(SidePush(), (0, 1))).value
    2.4
    """

    demand: str
    value: float
    strategy: ResetStrategy


@dataclass(frozen=True, eq=False)
class Pool:
    """All candidates in one list, n of them.

    parts : their sets.
    part, number : (n,), the set of each and its number there.
    family : (n,), the set's.
    able : (n,), whether the robot can do it.
    values : (n,) of all that demands or ranks are about.
    limits : what is demanded.
    excess : (n,), by how many e-foldings a value lies on the wrong side of its limit, negative on
        the right one.
    missed : (n,), the sum of those on the wrong side.
    actions : (n,), how many.
    untidy : (n,), how far from simple a mixture of so many actions is: unequal weights, then places
        not the loop's own.
    """

    parts: tuple[Candidates, ...]
    part: Whole
    number: Whole
    family: NDArray[np.str_]
    able: Mask
    values: dict[str, Array]
    limits: dict[str, float]
    excess: dict[str, Array]
    missed: Array
    actions: Whole
    untidy: Array

    def strategy(self, index: int) -> ResetStrategy:
        """Return a candidate as a strategy."""
        return self.parts[int(self.part[index])].strategy(int(self.number[index]))


def gathered(loop: CollectionLoop, demands: ResetDemands, parts: tuple[Candidates, ...]) -> Pool:
    """Return the candidates with their values; the second part starts with the loop's own drag."""
    own_drag = float(parts[1].source.turns.drag_length[0, 0])
    own = (loop.push.fraction, loop.push.angle)
    limits = {TV: demands.allow_tv, AFTER: demands.allow_after, DRAG: demands.drag_ratio * own_drag}
    asked = {SECONDS: demands.seconds, REACH: demands.reach, CONTACT: demands.contact}
    limits |= {name: limit for name, limit in asked.items() if limit is not None}
    rows: list[dict[str, Any]] = []
    for candidates in parts:
        actions = candidates.source.actions
        used = candidates.shares > 0.0
        sizes = used.sum(axis=1)
        drag = candidates.shares @ candidates.source.turns.drag_length[0]
        turned = candidates.shares @ np.array(
            [bool(action.turn) for action in actions], dtype=float
        )
        contact = np.where(used, candidates.source.contact, np.inf).min(axis=1)
        time = seconds(loop.push.distance + drag, turned)
        row = {
            TV: candidates.tv,
            AFTER: candidates.after,
            DRAG: drag,
            SECONDS: time,
            CONTACT: contact,
        }
        if demands.reach is not None:
            prepared = ResetStrategy(OWN.actions, hitch=candidates.source.hitch).prepared(loop)
            still = [replace(action, turn=0.0) for action in actions]
            rooms = {action: room_needed(prepared, action) for action in dict.fromkeys(still)}
            row[REACH] = np.where(used, [rooms[action] for action in still], 0.0).max(axis=1)
        places = [
            (action.push.fraction, action.push.angle) if action.push else own for action in actions
        ]
        kinds = sorted(set(places) - {own})
        strange = [
            used[:, [place == kind for place in places]].any(axis=1).astype(float) for kind in kinds
        ]
        equal = np.abs(candidates.shares.sum(axis=1) - sizes * candidates.shares.max(axis=1)) < 1e-9
        untidy = 100.0 * ~equal + sum(strange, start=np.zeros(len(used)))
        family = np.full(len(used), candidates.source.family)
        rows.append(
            {
                **row,
                "number": np.arange(len(used)),
                "sizes": sizes,
                "untidy": untidy,
                "family": family,
            }
        )
    values = {name: np.concatenate([row[name] for row in rows]) for name in rows[0]}
    number, counts, untidy, family = (
        values.pop(name) for name in ("number", "sizes", "untidy", "family")
    )
    excess = {
        name: np.log(np.maximum(values[name], 1e-9) / limit) for name, limit in limits.items()
    }
    if CONTACT in excess:
        excess[CONTACT] = -excess[CONTACT]
    missed = np.maximum(np.array(list(excess.values())), 0.0).sum(axis=0)
    able = np.isin(family, [GRIPPER, RING], invert=True) | np.isin(family, demands.abilities)
    part = np.repeat(np.arange(len(parts)), [len(candidates.tv) for candidates in parts])
    return Pool(parts, part, number, family, able, values, limits, excess, missed, counts, untidy)


def picked(
    pool: Pool, demands: ResetDemands, firm: float = FIRM[0]
) -> tuple[list[tuple[str, ResetStrategy]], tuple[Limit, ...]]:
    """The rows to tell, by role, the chosen one first, and the demands that it misses by the
    search's numbers.

    Of these demands the best that any candidate without a gripper reaches.
    """
    able = pool.able
    excess = pool.missed
    after = pool.values[AFTER]
    meets = able & (excess == 0.0)
    simple = pool.actions + 1e-3 * pool.untidy
    if meets.any():
        # A closer look may find a little more: what is well within is taken where there is some.
        sure = (
            meets
            & (after <= firm * demands.allow_after)
            & (pool.values[TV] <= firm * demands.allow_tv)
        )
        best = (
            _ranked(np.flatnonzero(sure), pool, demands)
            if sure.any()
            else int(np.argmin(np.where(meets, after, 2.0)))
        )
        meets = sure if sure.any() else meets
    else:
        best = int(min(np.flatnonzero(able), key=lambda index: (excess[index], simple[index])))
    nearly = np.flatnonzero(able & (excess <= max(math.log(_NEARLY) * 2.0, 1.1 * excess[best])))
    nearly = nearly[after[nearly] <= max(_NEARLY * demands.allow_after, _NEARLY * after[best])]
    roles = [(CHOSEN, best)]
    if nearly.size:
        roles.append((SIMPLEST, min(nearly.tolist(), key=lambda i: (simple[i], after[i]))))
    roles.append((EVENEST, min(np.flatnonzero(able).tolist(), key=lambda i: after[i])))
    if meets.any():
        roles.append(
            (CHEAPEST, min(np.flatnonzero(meets).tolist(), key=lambda i: pool.values[SECONDS][i]))
        )
    for role, name in ((WAY_BACK, "way back"), (WITH_GRIPPER, GRIPPER)):
        ones = np.flatnonzero(pool.family == name)
        if ones.size:
            # Of those that meet the demands the fewest actions, else the most uniform.
            within = ones[excess[ones] == 0.0]
            ones = (
                within[pool.actions[within] == pool.actions[within].min()] if within.size else ones
            )
            roles.append((role, min(ones.tolist(), key=lambda i: after[i])))
    limits = []
    for name in (name for name, excess_of in pool.excess.items() if excess_of[best] > 0.0):
        least = int(np.argmin(np.where(pool.family == GRIPPER, np.inf, pool.excess[name])))
        limits.append(Limit(name, float(pool.values[name][least]), pool.strategy(least)))
    return [(role, pool.strategy(index)) for role, index in roles], tuple(limits)


def _ranked(chosen: Whole, pool: Pool, demands: ResetDemands) -> int:
    """The best of those that meet the demands: evenness as far as the pushes can tell, then cost,
    then simplicity.
    """
    after = pool.values[AFTER]
    time = pool.values[SECONDS]
    tell = _TELL_APART * independent_distance(demands.pushes)
    chosen = chosen[after[chosen] <= after[chosen].min() + tell]
    chosen = chosen[time[chosen] <= _SAME_COST * time[chosen].min()]
    return int(min(chosen.tolist(), key=lambda i: (pool.actions[i], pool.untidy[i], after[i])))
