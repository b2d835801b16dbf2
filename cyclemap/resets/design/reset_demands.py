"""What is demanded of a reset, and by how much a strategy misses it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from cyclemap.checks import finite_number, positive_number, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.resets.design.reset_numbers import ResetNumbers
from cyclemap.resets.strategies.action_cost import StrategyCost

# Metres: contact that counts as none.
_LITTLE = 1e-6
# Abilities by their short names, and what strategies call the same.
ABILITIES = {"ring": "ring at another place", "gripper": "gripper"}
# The demands, in the order in which they are told.
TV, TV_AFTER, DRAG, REACH, SECONDS, CONTACT = "tv", "tv_after", "drag", "reach", "seconds", "contact"
DEMANDS = (TV, TV_AFTER, DRAG, REACH, SECONDS, CONTACT)
# Those whose values are in metres.
LENGTHS = (DRAG, REACH, CONTACT)
# Of all but this the limit is the most that is allowed; of this it is the least.
AT_LEAST = CONTACT


@dataclass(frozen=True)
class Miss:
    """A demand that is missed. demand : one of `DEMANDS`. value, limit : a probability, m or s."""

    demand: str
    value: float
    limit: float

    @property
    def excess(self) -> float:
        """|ln(value/limit)|: how many e-foldings the value lies on the wrong side of its limit."""
        return abs(math.log(max(self.value, _LITTLE) / self.limit))


@dataclass(frozen=True)
class ResetDemands:
    """What a reset must keep to.

    Parameters
    ----------
    allow_tv : most total variation of the stationary law from uniform, in (0, 1).
    extra_tv : how much further off, at most, the law may be after `within` pushes, from any start; in (0, 1).
    within : pushes until then, at least 1.
    drag_ratio : most mean drag, in mean drags of the loop's own reset.
    reach : largest distance (m) of rod or object from the target; None: any.
    seconds : most mean time of a cycle (s); None: any.
    abilities : what the robot can do besides the same rod and ring: "ring" (another place of the ring), "gripper", or
        what strategies of one's own call it in `needs`.
    contact : shortest way (m) that the rod must go in contact in every push, whatever the orientation; None: any.

    Raises InvalidInput for a value out of its range.

    >>> ResetDemands(allow_tv=0.02).limits(own_drag=0.1)
    {'tv': 0.02, 'tv_after': 0.07, 'drag': 0.2}
    """

    allow_tv: float = 0.05
    extra_tv: float = 0.05
    within: int = 50
    drag_ratio: float = 2.0
    reach: float | None = None
    seconds: float | None = None
    abilities: tuple[str, ...] = ()
    contact: float | None = None

    def __post_init__(self) -> None:
        for name in ("allow_tv", "extra_tv"):
            value = finite_number(name, getattr(self, name))
            if not 0.0 < value < 1.0:
                raise InvalidInput(f"{name} is {value:g}: a total variation that is allowed lies between 0 and 1")
        object.__setattr__(self, "within", whole_number("within", self.within, least=1))
        positive_number("drag_ratio", self.drag_ratio)
        for name in ("reach", "seconds", "contact"):
            if getattr(self, name) is not None:
                positive_number(name, getattr(self, name))
        given = (self.abilities,) if isinstance(self.abilities, str) else tuple(self.abilities)
        if not all(isinstance(ability, str) and ability for ability in given):
            raise InvalidInput(f"abilities are names such as {' and '.join(map(repr, ABILITIES))}, not {given!r}")
        object.__setattr__(self, "abilities", given)

    @property
    def near_tv(self) -> float:
        """What the law of every start must be within after `within` pushes; at most 1."""
        return min(1.0, self.allow_tv + self.extra_tv)

    def limits(self, own_drag: float) -> dict[str, float]:
        """Return the limit of each demand that is made; own_drag : mean drag (m) of the loop's own reset."""
        made = {TV: self.allow_tv, TV_AFTER: self.near_tv, DRAG: self.drag_ratio * own_drag}
        asked = {REACH: self.reach, SECONDS: self.seconds, CONTACT: self.contact}
        return {**made, **{name: limit for name, limit in asked.items() if limit is not None}}

    def lacking(self, needs: Sequence[str]) -> tuple[str, ...]:
        """Return what of the `needs` of a strategy the robot cannot do.

        >>> ResetDemands(abilities=("ring",)).lacking(("gripper", "ring at another place"))
        ('gripper',)
        """
        known = {*self.abilities, *(ABILITIES.get(ability, ability) for ability in self.abilities)}
        return tuple(need for need in needs if need not in known)

    def misses(
        self, numbers: ResetNumbers, cost: StrategyCost, own_drag: float, contact: float = math.inf
    ) -> tuple[Miss, ...]:
        """Return the demands that a strategy with these scores and this cost misses; by the best estimates.

        contact : m, the shortest of its pushes.
        """
        found = demanded_values(numbers, cost, contact)
        limits = self.limits(own_drag).items()
        return tuple(Miss(name, found[name], limit) for name, limit in limits if is_beyond(name, found[name], limit))

    def are_certain(self, numbers: ResetNumbers) -> bool:
        """Whether the bounds of the scores confirm that both total variations are within their limits."""
        return numbers.tv.upper <= self.allow_tv and numbers.tv_after.upper <= self.near_tv


def is_beyond(demand: str, value: float, limit: float) -> bool:
    """Whether a value lies on the wrong side of its limit.

    >>> is_beyond("drag", 0.2, 0.1), is_beyond("contact", 0.2, 0.1)
    (True, False)
    """
    return value < limit if demand == AT_LEAST else value > limit


def demanded_values(numbers: ResetNumbers, cost: StrategyCost, contact: float = math.inf) -> dict[str, float]:
    """Return what each demand is about: probabilities, m and s."""
    return {
        TV: float(numbers.tv),
        TV_AFTER: float(numbers.tv_after),
        DRAG: cost.mean_drag_length,
        REACH: cost.reach,
        SECONDS: cost.mean_seconds,
        CONTACT: contact,
    }
