"""The ranking: what is demanded of a reset, which of many candidates meets it, and which of those
to take.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from cyclemap.arrays import Array, Place
from cyclemap.checks import finite_number, positive_number, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import SidePush
from cyclemap.progress import Progress
from cyclemap.protocol.strategy import GRIPPER, RING, CycleAction, ResetStrategy
from cyclemap.resets.action_cycles import room_needed, seconds
from cyclemap.resets.material_range import MaterialRange
from cyclemap.resets.reset_search import (
    MORE_SLANTS,
    SLANTS,
    Candidates,
    own_pushes,
    push_set,
    searched,
)
from cyclemap.resets.strategy_run import independent_distance

if TYPE_CHECKING:
    import pandas

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
_SIMPLE = ("actions", "untidy")
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
            if whole_number(name, getattr(self, name), least=1) > MOST_PUSHES:
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
    """All candidates in one table.

    sets : those they are from.
    rows : by the number of the set and that of the candidate in it: the set's family, whether the
        robot can do it (able), how many actions, how far from simple a mixture of so many is
        (untidy), all values that demands or ranks are about, and how far it misses what is demanded
        in all.
    excess : by how many e-foldings a value lies on the wrong side of its limit, negative on the
        right one; a column for each demand.
    limits : what is demanded.
    """

    sets: tuple[Candidates, ...]
    rows: pandas.DataFrame
    excess: pandas.DataFrame
    limits: dict[str, float]

    @property
    def has_enough(self) -> bool:
        """Whether the robot can do something that meets all demands."""
        return bool((self.rows["able"] & (self.rows["missed"] == 0.0)).any())

    def strategy(self, index: tuple[int, int]) -> ResetStrategy:
        """Return a candidate as a strategy."""
        place, row = index
        return self.sets[place].strategy(row)


def candidate_pool(
    loop: CollectionLoop,
    demands: ResetDemands,
    about: MaterialRange,
    sigma: float,
    progress: Progress,
) -> Pool:
    """Every candidate, those that need what the robot cannot do included, for they are told too."""
    sets = own_pushes(loop, about, sigma, demands.within)
    places: list[Place | None] = [] if demands.keep_push else [None]
    if RING in demands.abilities and not demands.keep_push:
        x, y = loop.slider.hitch
        places += [(-y, x), (-x, -y), (y, -x), (2.0 * x / 3.0, 2.0 * y / 3.0)]
    pool = gathered(loop, demands, tuple(sets))
    for share, slants in zip(CONTACTS, (SLANTS, MORE_SLANTS), strict=True):
        # Where pushes that keep the object for long do not do, shorter and more slanted ones may.
        if pool.has_enough or not places:
            break
        contact = demands.contact or share * loop.push.distance
        for hitch in places:
            source = push_set(loop, about, sigma, contact, slants, hitch)
            if source is not None:
                sets.append(searched(source, demands.within, progress))
        pool = gathered(loop, demands, tuple(sets))
    return pool


def gathered(loop: CollectionLoop, demands: ResetDemands, sets: tuple[Candidates, ...]) -> Pool:
    """Return the candidates with their values; the second set starts with the loop's own drag."""
    import pandas

    own_drag = float(sets[1].source.turns.drag_length[0, 0])
    asked = {
        TV: demands.allow_tv,
        AFTER: demands.allow_after,
        DRAG: demands.drag_ratio * own_drag,
        SECONDS: demands.seconds,
        REACH: demands.reach,
        CONTACT: demands.contact,
    }
    limits = {name: limit for name, limit in asked.items() if limit is not None}
    frames = [pandas.DataFrame(_values(loop, each, REACH in limits)) for each in sets]
    rows = pandas.concat(frames, keys=range(len(sets)))
    excess = np.log(rows[list(limits)].clip(lower=1e-9) / pandas.Series(limits))
    if CONTACT in limits:
        excess[CONTACT] = -excess[CONTACT]
    family = rows["family"]
    rows["missed"] = excess.clip(lower=0.0).sum(axis=1)
    rows["able"] = ~family.isin(ABILITIES) | family.isin(demands.abilities)
    return Pool(sets, rows, excess, limits)


def _values(loop: CollectionLoop, candidates: Candidates, reach: bool) -> dict[str, object]:
    """The columns of a set in a `Pool`; that of the room they need takes long."""
    source, shares = candidates.source, candidates.shares
    prepared = ResetStrategy(OWN.actions, hitch=source.hitch).prepared(loop)
    drag = source.turns.drag_length[0]
    return {
        "family": source.family,
        "actions": (shares > 0.0).sum(axis=1),
        "untidy": _untidy(loop.push, source.actions, shares),
        TV: candidates.tv,
        AFTER: candidates.after,
        **mixture_costs(prepared, source.actions, shares, drag, source.contact, reach),
    }


def mixture_costs(
    loop: CollectionLoop,
    actions: Sequence[CycleAction],
    shares: Array,
    drag: Array,
    contact: Array,
    reach: bool = True,
) -> dict[str, Array]:
    """What mixtures of k actions, shares (..., k), cost: mean drag, m, mean time of a cycle, s,
    shortest contact, m, and unless not `reach` the room they need, m; each (...).

    drag, contact : (k,) m, of each action.
    """
    used = shares > 0.0
    pushes = np.array([(action.push or loop.push).distance for action in actions])
    turned = np.array([float(action.turn != 0.0) for action in actions])
    costs = {
        DRAG: shares @ drag,
        SECONDS: seconds(shares @ (drag + pushes), shares @ turned),
        CONTACT: np.where(used, contact, np.inf).min(axis=-1),
    }
    if reach:
        still = [replace(action, turn=0.0) for action in actions]
        rooms = {action: room_needed(loop, action) for action in dict.fromkeys(still)}
        costs[REACH] = np.where(used, [rooms[action] for action in still], 0.0).max(axis=-1)
    return costs


def _untidy(own: SidePush, actions: Sequence[CycleAction], shares: Array) -> Array:
    """How far mixtures are from simple: unequal weights, then places not the loop's own."""
    used = shares > 0.0
    places = [(push.fraction, push.angle) for push in (action.push or own for action in actions)]
    strange = np.zeros(len(used))
    for place in set(places) - {(own.fraction, own.angle)}:
        strange += used[:, [other == place for other in places]].any(axis=1)
    unequal = np.abs(shares.sum(axis=1) - used.sum(axis=1) * shares.max(axis=1)) >= 1e-9
    return np.asarray(100.0 * unequal + strange)


def picked(
    pool: Pool, demands: ResetDemands, firm: float
) -> tuple[list[tuple[str, ResetStrategy]], tuple[Limit, ...]]:
    """The rows to tell, by role, the chosen one first, and the demands that it misses by the
    search's numbers.

    Of these demands the best that any candidate without a gripper reaches.
    """
    rows = pool.rows
    able = rows[rows["able"]]
    enough = able[able["missed"] == 0.0]
    # A closer look may find a little more: what is well within is taken where there is some.
    sure = enough[
        (enough[AFTER] <= firm * demands.allow_after) & (enough[TV] <= firm * demands.allow_tv)
    ]
    if len(sure):
        best = _ranked(sure, demands)
        enough = sure
    else:
        best = enough[AFTER].idxmin() if len(enough) else _first(able, "missed", *_SIMPLE)
    chosen = rows.loc[best]
    nearly = able[
        (able["missed"] <= max(math.log(_NEARLY) * 2.0, 1.1 * chosen["missed"]))
        & (able[AFTER] <= _NEARLY * max(demands.allow_after, chosen[AFTER]))
    ]
    roles = {CHOSEN: best}
    if len(nearly):
        roles[SIMPLEST] = _first(nearly, *_SIMPLE, AFTER)
    roles[EVENEST] = able[AFTER].idxmin()
    if len(enough):
        roles[CHEAPEST] = enough[SECONDS].idxmin()
    for role, name in ((WAY_BACK, "way back"), (WITH_GRIPPER, GRIPPER)):
        of_family = rows[rows["family"] == name]
        if len(of_family):
            roles[role] = _evenest(of_family)
    limits = []
    others = pool.excess[rows["family"] != GRIPPER]
    for name in (name for name in pool.limits if pool.excess.at[best, name] > 0.0):
        least = others[name].idxmin()
        limits.append(Limit(name, float(rows.at[least, name]), pool.strategy(least)))
    return [(role, pool.strategy(index)) for role, index in roles.items()], tuple(limits)


def _evenest(rows: pandas.DataFrame) -> tuple[int, int]:
    """The most uniform, of those of the fewest actions where some meet the demands."""
    enough = rows[rows["missed"] == 0.0]
    fewest = enough[enough["actions"] == enough["actions"].min()]
    best: tuple[int, int] = (fewest if len(fewest) else rows)[AFTER].idxmin()
    return best


def _ranked(rows: pandas.DataFrame, demands: ResetDemands) -> tuple[int, int]:
    """The best of those that meet the demands: evenness as far as the pushes can tell, then cost,
    then simplicity.
    """
    tell = _TELL_APART * independent_distance(demands.pushes)
    rows = rows[rows[AFTER] <= rows[AFTER].min() + tell]
    rows = rows[rows[SECONDS] <= _SAME_COST * rows[SECONDS].min()]
    return _first(rows, *_SIMPLE, AFTER)


def _first(rows: pandas.DataFrame, *by: str) -> tuple[int, int]:
    first: tuple[int, int] = rows.sort_values(list(by), kind="stable").index[0]
    return first
