"""The strategies that a design looks at: the loop's own reset, and others by how little they change it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cyclemap.checks import whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.mechanics import Ellipse, SidePush
from cyclemap.mechanics.stroke_variation import rotation
from cyclemap.resets.drawn_pushes.push_library import LEAST_SHARE
from cyclemap.resets.strategies.combined import combine
from cyclemap.resets.strategies.drag_strategies import (
    GripperTurn,
    RingPlace,
    ScatteredAim,
    StraightReset,
    TrailingLeg,
    WayPoints,
)
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes
from cyclemap.resets.strategies.schedules import INDEPENDENT, GoldenAngle, LatinBlocks
from cyclemap.resets.strategies.spread import Spread
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.resets.strategies.strategy_maps import checked_strategy
from cyclemap.suggestions import unknown_name

# Fractions this near to the middle of a side push its mirror image at almost the same place.
_MIDDLE, _ASIDE = 0.05, 0.2
_MOST_SIDES, _AROUND = 8, 8
_SLANT = math.radians(30.0)
_MANY_NODES, _FEW_NODES = 64, 4
# Radians and mean drags: how far the direction and the length of a last leg from one side are drawn.
_FAN, _STRETCH = math.radians(45.0), 0.5
# Fractions that are tried further out, and the share of its distance that a push must then last in contact.
_OUTER, _THIRD = (0.15, 0.85), 1.0 / 3.0
_BLOCK = 12


@dataclass(frozen=True)
class Effort:
    """How much a design looks at.

    fractions : of every side that are tried besides the loop's own and its mirror image. angles : of slanted pushes,
    rad off the loop's own, that are tried where upright ones do not meet the demands. lengths : of trailing legs, in
    mean drags of the loop's own reset. side_steps : of those legs, in their lengths. aims : radii of a scattered aim,
    in the same mean drags; where there are any, drawn fractions and a leg together are tried too. nodes : of a law, for
    a full turn. rings : directions in which other places of the ring are tried. searches : starts of the search for
    the best weights of pushes. certified : how many strategies that meet the demands are looked at with bounds, at
    most. outer : fractions of every side that are tried where those do not meet the demands. least_share : of its
    distance, that a push must then last in contact. random_legs : whether the length, or the direction, of a last leg
    from one side is drawn too.
    """

    fractions: tuple[float, ...]
    angles: tuple[float, ...]
    lengths: tuple[float, ...]
    side_steps: tuple[float, ...]
    aims: tuple[float, ...]
    nodes: int
    rings: int
    searches: int
    certified: int
    outer: tuple[float, ...] = ()
    least_share: float = LEAST_SHARE
    random_legs: bool = False


EFFORTS = {
    "quick": Effort((), (), (1.0,), (0.5,), (), 12, 0, 1, 1),
    "normal": Effort((0.5,), (_SLANT,), (1.0,), (0.5,), (), 8, 2, 2, 1, _OUTER, _THIRD, True),
    "thorough": Effort(
        (0.15, 0.3, 0.5, 0.7, 0.85),
        (0.5 * _SLANT, _SLANT),
        (0.5, 1.0, 1.5),
        (0.0, 0.5),
        (0.125, 0.25, 0.5),
        12,
        8,
        4,
        8,
        _OUTER,
        _THIRD,
        True,
    ),
}


@dataclass(frozen=True)
class ResetCandidate:
    """A strategy under a name that tells it from the others. nodes : of its law, for a full turn."""

    name: str
    strategy: ResetStrategy
    nodes: int = 12

    def __post_init__(self) -> None:
        checked_strategy(self.strategy)
        whole_number("nodes", self.nodes, least=1)

    def keeps_push(self, loop: CollectionLoop) -> bool:
        """Whether every push is the loop's own."""
        actions = self.strategy.law(self.nodes).actions
        return self.strategy.prepared(loop).push == loop.push and all(a.push in (None, loop.push) for a in actions)


def effort(name: str | Effort) -> Effort:
    """Return how much is looked at: "quick", "normal", "thorough" or what is given; InvalidInput for another name."""
    if isinstance(name, Effort):
        return name
    if name not in EFFORTS:
        raise unknown_name("effort", str(name), EFFORTS)
    return EFFORTS[name]


def own_candidate(loop: CollectionLoop) -> ResetCandidate:
    """The loop's own reset, as it is.

    >>> own_candidate(CollectionLoop.mit()).strategy
    StraightReset()
    """
    points = loop.reset.way_points
    return ResetCandidate("as it is", WayPoints(points) if points else StraightReset(), 1)


@dataclass(frozen=True)
class PushPlaces:
    """Where the loop's push could be made as well. own : the loop's. mirrored : at the mirror image of its place.

    opposite : on the far side. around : at the same place of each side. everywhere : all these and their mirror images.
    """

    own: SidePush
    mirrored: SidePush
    opposite: SidePush
    around: tuple[SidePush, ...]
    everywhere: tuple[SidePush, ...]

    @classmethod
    def of(cls, loop: CollectionLoop, fractions: Sequence[float] = ()) -> PushPlaces:
        """For a polygon its sides, at most eight, evenly picked; for an ellipse eight places around it.

        fractions : further ones, of each side.

        >>> places = PushPlaces.of(CollectionLoop.mit())
        >>> [push.side for push in places.around], round(places.mirrored.fraction, 12), len(places.everywhere)
        ([0, 1, 2, 3], 0.3, 8)
        """
        if isinstance(loop.slider.outline, Ellipse):
            return cls._around_ellipse(loop.push)
        own, sides = loop.push, loop.slider.outline.sides
        picked = range(sides) if sides <= _MOST_SIDES else [(k * sides) // _MOST_SIDES for k in range(_MOST_SIDES)]
        numbers = sorted({(own.side + k) % sides for k in picked})
        aside = _ASIDE if abs(own.fraction - 0.5) < _MIDDLE else 0.0
        mirrored = replace(own, fraction=round(1.0 - own.fraction - aside, 12), angle=-own.angle or 0.0)
        given = [own, mirrored, *(replace(own, fraction=fraction) for fraction in fractions)]
        different = {round(push.fraction, 3): push for push in reversed(given)}
        opposite = replace(own, side=(own.side + sides // 2) % sides)
        everywhere = tuple(replace(push, side=side) for side in numbers for push in different.values())
        return cls(own, mirrored, opposite, tuple(replace(own, side=side) for side in numbers), everywhere)

    @classmethod
    def _around_ellipse(cls, own: SidePush) -> PushPlaces:
        around = tuple(replace(own, fraction=(own.fraction + k / _AROUND) % 1.0) for k in range(_AROUND))
        mirrored = replace(own, fraction=round((1.0 - own.fraction) % 1.0, 12))
        return cls(own, mirrored, around[_AROUND // 2], around, around)

    def slanted(self, angles: Sequence[float], fractions: Sequence[float] = ()) -> tuple[SidePush, ...]:
        """The pushes at the loop's fraction, its mirror image and `fractions`, turned by each angle (rad) both ways."""
        near = {round(fraction, 3) for fraction in (self.own.fraction, self.mirrored.fraction, *fractions)}
        pushes = [push for push in self.everywhere if round(push.fraction, 3) in near or len(near) == 1]
        turned = [(push, push.angle + sign * angle) for angle in angles for push in pushes for sign in (1.0, -1.0)]
        return tuple(replace(push, angle=angle) for push, angle in turned if abs(angle) < 0.5 * math.pi)


def push_candidates(places: PushPlaces) -> list[ResetCandidate]:
    """Pushes in turn or drawn, alike in weight."""
    two, mirror = (places.own, places.opposite), (places.own, places.mirrored)
    four = tuple(dict.fromkeys((*two, places.mirrored, replace(places.opposite, fraction=places.mirrored.fraction))))
    made = [
        ResetCandidate("two sides in turn", AlternatingPushes(two)),
        ResetCandidate("all sides in turn", AlternatingPushes(places.around)),
        ResetCandidate("two sides, drawn", DrawnPushes(two)),
        ResetCandidate("all sides, drawn", DrawnPushes(places.around)),
        ResetCandidate("two fractions, drawn", DrawnPushes(mirror)),
        ResetCandidate("two sides x fractions, drawn", DrawnPushes(four)),
        ResetCandidate("all sides x fractions, drawn", DrawnPushes(places.everywhere)),
    ]
    seen: dict[ResetStrategy, ResetCandidate] = {}
    for one in made:
        seen.setdefault(one.strategy, one)
    return [one for one in seen.values() if len(set(one.strategy.law().actions)) > 1]


def direction_nodes(loop: CollectionLoop, work: Effort) -> int:
    """Nodes of a random direction: many where they share one map, as on an isotropic surface.

    So few leave a bias of their own, which is no bias of the strategy: with K of them that of the K-th harmonic.
    """
    friction = loop.material.friction
    centred = friction.m0 == friction.n0 == 0.0
    return _MANY_NODES if centred and friction.mu_a == friction.mu_b else work.nodes


def leg_candidates(work: Effort, own_drag: float) -> list[ResetCandidate]:
    """Drags whose last leg comes from a random direction, with or without a side step, and scattered aims."""
    made = []
    for length in work.lengths:
        for aside in work.side_steps:
            metres, step = round(length * own_drag, 3), round(aside * length * own_drag, 3)
            words = f", side step {1000 * step:.0f} mm" if step else ""
            leg = TrailingLeg(metres, side_step=step)
            name = f"trailing leg {1000 * metres:.0f} mm{words}"
            made.append(ResetCandidate(name, leg, work.nodes))
            made.append(ResetCandidate(f"{name}, golden angle", replace(leg, schedule=GoldenAngle()), work.nodes))
    if work.random_legs:
        made.extend(_random_legs(work, own_drag))
    for aim in work.aims:
        radius = round(aim * own_drag, 3)
        made.append(
            ResetCandidate(f"aim scattered by {1000 * radius:.0f} mm", ScatteredAim(radius), max(4, work.nodes // 2))
        )
    return made


def _random_legs(work: Effort, own_drag: float) -> list[ResetCandidate]:
    """A last leg from one side, its length or its direction drawn."""
    metres, near, far = (round(share * own_drag, 3) for share in (1.0, 1.0 - _STRETCH, 1.0 + _STRETCH))
    drawn = TrailingLeg(Spread(near, far), 0.0)
    turned = TrailingLeg(metres, Spread.within(0.0, _FAN))
    return [
        ResetCandidate(f"leg of {1000 * near:.0f} to {1000 * far:.0f} mm, drawn", drawn, _FEW_NODES),
        ResetCandidate(f"leg {1000 * metres:.0f} mm within ±{math.degrees(_FAN):.0f}°, drawn", turned, _FEW_NODES),
    ]


def scheduled_candidates(best: ResetCandidate | None) -> list[ResetCandidate]:
    """The same pushes as often, by golden angle and in Latin blocks; none for what is not drawn independently.

    >>> pushes = DrawnPushes((SidePush(0), SidePush(2)))
    >>> [made.name for made in scheduled_candidates(ResetCandidate("two", pushes))]
    ['two: golden angle', 'two: blocks of 12']
    """
    if best is None or not isinstance(best.strategy, DrawnPushes) or best.strategy.schedule.kind != INDEPENDENT:
        return []
    orders = (("golden angle", GoldenAngle()), (f"blocks of {_BLOCK}", LatinBlocks(_BLOCK)))
    return [
        replace(best, name=f"{best.name}: {words}", strategy=replace(best.strategy, schedule=order))
        for words, order in orders
    ]


def combined_candidates(places: PushPlaces, work: Effort, own_drag: float) -> list[ResetCandidate]:
    """Drawn fractions and a trailing leg together."""
    if not work.aims or places.own == places.mirrored:
        return []
    length = round(0.5 * own_drag, 3)
    both = combine(DrawnPushes((places.own, places.mirrored)), TrailingLeg(length))
    return [ResetCandidate(f"two fractions, drawn + leg {1000 * length:.0f} mm", both, max(4, work.nodes // 2))]


def ring_places(loop: CollectionLoop, directions: int) -> list[ResetCandidate]:
    """The ring nearer to the centre of mass and further away, in that many directions."""
    count = whole_number("directions", directions, least=0)
    centre, hitch = np.array(loop.slider.centre_of_mass), np.array(loop.slider.hitch)
    lever = hitch - centre
    if not lever.any():
        lever = np.array([0.25 * float(np.abs(loop.slider.outline_points()).max()), 0.0])
    made = []
    for k in range(count):
        turned = rotation(2.0 * math.pi * k / count) @ lever
        for factor in (0.5, 1.0, 2.0):
            place = tuple((centre + factor * turned).round(6).tolist())
            if np.hypot(*(np.array(place) - hitch)) > 1e-6:
                made.append(_ring_candidate(place))
    return made


def _ring_candidate(place: tuple[float, float]) -> ResetCandidate:
    x, y = (1000 * part for part in place)
    return ResetCandidate(f"ring at ({x:.1f}, {y:.1f}) mm", RingPlace(place), 1)


def gripper_candidates() -> list[ResetCandidate]:
    """A gripper that turns the object by anything."""
    return [ResetCandidate("gripper, any turn", GripperTurn(), 1)]
