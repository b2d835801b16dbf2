"""Choose, of the pushes that a person or a robot can set up, those after which what is asked will
be known best, on average over what is believed and if any of them is lost.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import astuple, dataclass, replace

import numpy as np

from cyclemap.arrays import TWO_PI, Array, placed
from cyclemap.checks import non_negative_number, positive_number, require_room, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput, RodMissesObject
from cyclemap.evidence.predicted_strokes import push_from_contact
from cyclemap.evidence.push_design import (
    TARGETS,
    Design,
    push_sensitivity,
    sampled_beliefs,
    target_of,
)
from cyclemap.evidence.pushes.measured_strokes import READ, MeasuredPush, ReadErrors, push_noise
from cyclemap.mechanics import Ellipse, Pose, SidePush, Slider
from cyclemap.mechanics.contact_curve import first_contact
from cyclemap.progress import Progress, unheard

MOST_PUSHES = 32
# Candidates times samples: each is a push that is run, and some thousand numbers.
MOST_RUNS = 50_000
# Of random pushes, how many sets are looked at.
_RANDOM_SETS = 12
COUNTS = (4, 8, 16)
# Where on a side, how slanted (rad) and, by the size of the object, how long a push may be.
_FRACTIONS = (0.15, 0.3, 0.5, 0.7, 0.85)
_ANGLES = tuple(math.radians(angle) for angle in (-20.0, 0.0, 20.0))
_LENGTHS = (0.55, 1.1, 1.65)
# Places around an ellipse, whose whole outline is one side.
_AROUND = tuple((place + 0.5) / 16 for place in range(16))
_RULED = 5e-3
# A side shorter than this share of the longest is no place for a rod.
_SHORT = 0.3
# The rod comes in from so far before it touches, m.
APPROACH = 0.03


@dataclass(frozen=True)
class SetPush:
    """A push to be set up: how the rod pushes, and the pose that the object is put in before (m,
    rad).

    The pose is in the frame of the room, whose origin is the corner at its left and near side.
    """

    push: SidePush
    start: Pose

    def rod(self, slider: Slider, radius: float) -> Array:
        """Return where the rod's centre first touches and where it ends (2, 2), m in the frame of
        `start`.
        """
        measured = self.measured(slider, radius)
        return np.array((measured.tip_start, measured.tip_end))

    def measured(self, slider: Slider, radius: float) -> MeasuredPush:
        """Return the push as one that was measured, and has not moved the object."""
        return push_from_contact(slider, radius, self.push, self.start, self.start)


@dataclass(frozen=True)
class Knowledge:
    """What will be known after a number of pushes.

    Attributes
    ----------
    pushes : int
        How many.
    planned : mapping of str to float
        After those of the plan, by name: `direction`, root mean square error of a stable
        direction, rad; `wrong`, chance of a wrong answer to whether the loop locks in; `map`,
        root mean square error of the map, rad; `place` and `turn`, of where a push ends, m and
        rad.
    random : mapping of str to float
        The same after as many random pushes.
    """

    pushes: int
    planned: Mapping[str, float]
    random: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class PushPlan:
    """Pushes to make, in the order in which they tell most, and what they will tell.

    Attributes
    ----------
    loop : CollectionLoop
        The loop whose floor is not known well.
    target : str
        What is asked: `direction`, `map` or `pushes`.
    pushes : tuple of SetPush
        How the rod pushes, and the pose that the object is put in before, in the order in which
        they tell most.
    ends : ndarray, shape (n, 3)
        Where each is likely to end, m and rad, in the frame of the room.
    knowledge : tuple of Knowledge
        Before any push, then after some.
    without : mapping of str to float
        What will be known after all but the one that is missed most, by name as in `Knowledge`.
    chance : float or None
        That the loop locks in, as it is believed now; None where that is not asked.
    room : tuple[float, float]
        Width and depth, m.
    read : tuple[float, float]
        Error of a reading, m and rad.
    samples, candidates : int
        Of how many floors and pushes it was chosen.

    Examples
    --------
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.evidence import plan_pushes
    >>> loop = CollectionLoop.mit("unknown")
    >>> plan = plan_pushes(loop, 2, samples=4, candidates=8, target="pushes")
    >>> [step.pushes for step in plan.knowledge], plan.ends.shape
    ([0, 2, 4, 8], (2, 3))
    """

    loop: CollectionLoop
    target: str
    pushes: tuple[SetPush, ...]
    ends: Array
    knowledge: tuple[Knowledge, ...]
    without: Mapping[str, float]
    chance: float | None
    room: tuple[float, float]
    read: ReadErrors
    samples: int
    candidates: int


def plan_pushes(
    loop: CollectionLoop,
    count: int = 8,
    *,
    target: str = "direction",
    grid: float | None = math.radians(15.0),
    room: tuple[float, float] = (0.6, 0.4),
    read: ReadErrors = READ,
    samples: int = 30,
    candidates: int = 160,
    seed: int = 0,
    progress: Progress | None = None,
) -> PushPlan:
    """Return the pushes that tell most of a loop whose floor is not known well.

    Parameters
    ----------
    loop : CollectionLoop
        The object, its push, ring and rod; its material has samples of what is believed of
        floor and plate.
    count : int, default 8
        How many pushes, 1 to 32.
    target : {'direction', 'map', 'pushes'}
        What is asked: the stable directions and whether there are any; the whole cycle map;
        where single pushes end.
    grid : float or None, optional
        Between orientations that the object is put in, rad, at most 2 pi; None: any.
    room : tuple[float, float], default (0.6, 0.4)
        Width and depth of the table that object and rod may need, m.
    read : tuple[float, float], optional
        Standard deviations of a measured place and angle, m and rad. What the best model misses
        comes on top.
    samples : int, default 30
        How many floors are looked at.
    candidates : int, default 160
        Among how many pushes is chosen; time and memory go with both, 5 s on two cores for the
        defaults. Their product is at most 50,000.
    seed : int, default 0
        Of the choice of candidates.
    progress : callable or None, optional
        Called with the fraction done.

    Returns
    -------
    PushPlan
        The pushes, and what they will tell.

    Raises
    ------
    InvalidInput
        For a material without samples, a room too small, more samples and candidates than there is
        room for, or numbers that make no sense.

    Notes
    -----
    A rod is taken to be set 2 mm off its mark (standard deviation), and an object to lie as wrongly
    as it is read, so that pushes which depend on that tell less. No push is planned twice: most of
    what a model misses of a push it misses again when that is repeated. Errors of pushes are taken
    as independent and alike, of a long push as of a short one.

    Examples
    --------
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.evidence import plan_pushes
    >>> loop = CollectionLoop.mit("unknown")
    >>> plan = plan_pushes(loop, 2, samples=4, candidates=8, target="pushes")
    >>> before, *_, after = plan.knowledge
    >>> after.planned["turn"] < 0.2 * before.planned["turn"]
    True
    """
    asked = whole_number("pushes of a plan", count, least=1)
    _check(target, asked, room, read, samples, candidates)
    report = progress or unheard
    known = sampled_beliefs(loop, samples)
    offered = candidate_pushes(loop, candidates, grid, 0.6 * max(room), seed)
    made = [push.measured(loop.slider, loop.pusher.radius) for push in offered]
    ends, by, measured = push_sensitivity(known, made, read)
    report(0.5)
    kept = dict[int, SetPush]()
    for index, push in enumerate(offered):
        in_middle = in_room(push, ends[:, index], loop, room)
        if in_middle is not None:
            kept[index] = in_middle
    if len(kept) < asked:
        held = f"{1e3 * room[0]:g} x {1e3 * room[1]:g} mm holds {len(kept)} of {len(offered)}"
        raise InvalidInput(f"a room of {held} pushes: give a larger one, or ask for fewer pushes")
    wanted = target_of(known, target, by, push_noise(read)[:3])
    report(0.8)
    design = Design(known.covariance, measured[:, [*kept]], wanted)
    first = design.greedy(min(max(asked, *COUNTS), len(kept)), range(len(kept)))
    chosen = design.greedy(asked, design.exchanged(first[:asked]))
    fewer = [[other for other in chosen if other != index] for index in chosen]
    planned = np.array([*kept])[chosen].tolist()
    pushes = tuple(kept[index] for index in planned)
    shift = np.array([(push.start.x, push.start.y, 0.0) for push in pushes])
    report(1.0)
    return PushPlan(
        loop,
        target,
        pushes,
        ends[:, planned].mean(axis=0) + shift,
        _knowledge(design, first, chosen, seed),
        design.knowledge(max(fewer, key=design.loss)),
        wanted.chance,
        room,
        read,
        len(known.values),
        len(kept),
    )


def _check(
    target: str,
    asked: int,
    room: tuple[float, float],
    read: ReadErrors,
    samples: int,
    candidates: int,
) -> None:
    """Refuse a plan for something else, and numbers that make no sense or are too large."""
    if target not in TARGETS:
        raise InvalidInput(f"a plan is for {', '.join(TARGETS)}, not {target!r}")
    if asked > MOST_PUSHES:
        raise InvalidInput(
            f"pushes of a plan: {asked}, of at most {MOST_PUSHES}; plan some, measure, and plan on"
        )
    for side in room:
        positive_number("width and depth of a room", side)
    for error, unit in zip(read, ("m", "rad"), strict=True):
        non_negative_number(f"error in {unit}", error)
    whole_number("samples", samples, least=2)
    whole_number("candidates", candidates, least=asked)
    require_room("samples times candidates", samples * candidates, "give fewer", MOST_RUNS)


def candidate_pushes(
    loop: CollectionLoop, count: int, grid: float | None, longest: float, seed: int
) -> tuple[SetPush, ...]:
    """Return at most `count` of the pushes that can be set up, a random choice of them, of all
    sides alike.

    grid : rad, between orientations that a hand sets; None: any, for a robot.
    longest : m, of a push.

    Raises InvalidInput for an object without a place for the rod, or a grid of more than a turn.
    """
    whole_number("seed", seed, least=0)
    if grid is not None and positive_number("grid", grid) > TWO_PI:
        raise InvalidInput(f"grid must be at most 2 pi rad, not {grid:g}")
    slider = loop.slider
    radius = loop.pusher.radius
    rng = np.random.default_rng(seed)
    size = math.sqrt(slider.outline.area)
    lengths = [_RULED * max(round(share * size / _RULED), 1) for share in _LENGTHS]
    lengths = [length for length in lengths if length <= longest] or [longest]
    contacts = []
    for side, fraction, angle in itertools.product(*_places(slider), _ANGLES):
        push = SidePush(side, fraction, angle, lengths[0])
        with suppress(InvalidInput, RodMissesObject):
            first_contact(slider, push, radius)
            contacts.append(push)
    if not contacts:
        raise InvalidInput(
            f"{slider.name} has no side that a rod of {1e3 * radius:.3g} mm can push"
        )
    rounds = -(-count // len(contacts))
    order = [*itertools.chain(*(rng.permutation(len(contacts)) for _ in range(rounds)))]
    offered = []
    for index in order[:count]:
        turned = rng.uniform(0.0, TWO_PI)
        if grid is not None:
            turned = grid * math.floor(turned / grid)
        push = replace(contacts[index], distance=float(rng.choice(lengths)))
        offered.append(SetPush(push, Pose(theta=turned)))
    return tuple(dict.fromkeys(offered))


def _places(slider: Slider) -> tuple[list[int], tuple[float, ...]]:
    """The sides that are long enough, and the places on each."""
    if isinstance(slider.outline, Ellipse):
        return [0], _AROUND
    corners = slider.outline.array
    length = np.hypot(*(np.roll(corners, -1, axis=0) - corners).T)
    return np.flatnonzero(length >= _SHORT * length.max()).tolist(), _FRACTIONS


def in_room(
    push: SetPush, ends: Array, loop: CollectionLoop, room: tuple[float, float]
) -> SetPush | None:
    """Return the push in the middle of a room (m); None where object and rod need more than that.

    ends (s, 3) : poses in which it may end, from the start pose of `push`.
    """
    outline = loop.slider.outline_points(60)
    first, last = push.rod(loop.slider, loop.pusher.radius)
    begin = np.array(astuple(push.start))
    reach = [placed(pose, outline) for pose in (begin, *ends)]
    reach += [first - APPROACH * (last - first) / push.push.distance, last]
    places = np.vstack(reach)
    low = places.min(axis=0)
    high = places.max(axis=0)
    if np.any(high - low > room):
        return None
    x, y = np.round(begin[:2] + 0.5 * np.array(room) - 0.5 * (low + high), 3).tolist()
    return replace(push, start=Pose(x, y, push.start.theta))


def _knowledge(
    design: Design, first: list[int], chosen: list[int], seed: int
) -> tuple[Knowledge, ...]:
    """What will be known after none, after some of `first`, after those `chosen`, and after as many
    random ones.
    """
    rng = np.random.default_rng(seed)
    sets = [rng.permutation(design.rows.shape[1]).tolist() for _ in range(_RANDOM_SETS)]
    steps = []
    for count in sorted({0, len(chosen), *(few for few in COUNTS if few <= len(first))}):
        planned = design.knowledge(chosen if count == len(chosen) else first[:count])
        drawn = [design.knowledge(order[:count]) for order in sets]
        random = {}
        for name in planned:
            random[name] = math.sqrt(float(np.mean([after[name] ** 2 for after in drawn])))
        steps.append(Knowledge(count, planned, random))
    return tuple(steps)
