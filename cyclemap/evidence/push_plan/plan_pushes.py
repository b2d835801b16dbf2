"""Choose pushes so that what is asked will be known best, on average over what is believed and if
any push is lost.

To first order the covariance of the unknowns after pushes is C = (C0^-1 + Σ J^T R^-1 J)^-1 in each
sample of what is believed, and what is asked has the variance g C g^T (Bayesian design for linear
functionals, Chaloner & Verdinelli 1995). Pushes are chosen one by one, then each is exchanged for a
better one as long as there is any.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import non_negative_number, positive_number, require_room, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.push_plan.candidates import SetPush, candidate_pushes, in_room
from cyclemap.evidence.push_plan.sensitivity import (
    TARGETS,
    Target,
    push_sensitivity,
    sampled_beliefs,
    target_of,
)
from cyclemap.evidence.pushes.measured_strokes import READ, push_noise
from cyclemap.progress import Progress, unheard

MOST_PUSHES = 32
# Candidates times samples: each is a push that is run, and some thousand numbers.
MOST_RUNS = 50_000
# Of random pushes, how many sets are looked at; how often every push may be exchanged.
_RANDOM_SETS, _ROUNDS = 12, 2
# Of what exchanges gain less than this share is left.
_GAIN = 1e-3
COUNTS = (4, 8, 16)


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
    read: tuple[float, float]
    samples: int
    candidates: int


def plan_pushes(
    loop: CollectionLoop,
    count: int = 8,
    *,
    target: str = "direction",
    grid: float | None = math.radians(15.0),
    room: tuple[float, float] = (0.6, 0.4),
    read: tuple[float, float] = READ,
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
    if asked > MOST_PUSHES:
        raise InvalidInput(
            f"pushes of a plan: {asked}, of at most {MOST_PUSHES}; plan some, measure, and plan on"
        )
    if target not in TARGETS:
        raise InvalidInput(f"a plan is for {', '.join(TARGETS)}, not {target!r}")
    for side in room:
        positive_number("width and depth of a room", side)
    for error, unit in zip(read, ("m", "rad"), strict=True):
        non_negative_number(f"error in {unit}", error)
    whole_number("samples", samples, least=2)
    whole_number("candidates", candidates, least=asked)
    require_room("samples times candidates", samples * candidates, "give fewer", MOST_RUNS)
    report = progress or unheard
    known = sampled_beliefs(loop, samples)
    offered = candidate_pushes(loop, candidates, grid, 0.6 * max(room), seed)
    ends, by, measured = push_sensitivity(known, offered, read)
    report(0.5)
    fitting = [in_room(push, ends[:, index], loop, room) for index, push in enumerate(offered)]
    kept = [(index, push) for index, push in enumerate(fitting) if push is not None]
    if len(kept) < asked:
        held = f"{1e3 * room[0]:g} x {1e3 * room[1]:g} mm holds {len(kept)} of {len(offered)}"
        raise InvalidInput(f"a room of {held} pushes: give a larger one, or ask for fewer pushes")
    wanted = target_of(known, target, by, push_noise(read)[:3])
    report(0.8)
    design = Design(known.covariance, measured[:, [index for index, _ in kept]], wanted)
    first = design.greedy(min(max(asked, *COUNTS), len(kept)), range(len(kept)))
    chosen = design.greedy(asked, design.exchanged(first[:asked]))
    fewer = [[other for other in chosen if other != index] for index in chosen]
    planned = [kept[index] for index in chosen]
    shift = np.array([(push.start.x, push.start.y, 0.0) for _, push in planned])
    report(1.0)
    return PushPlan(
        loop,
        target,
        tuple(push for _, push in planned),
        ends[:, [index for index, _ in planned]].mean(axis=0) + shift,
        _knowledge(design, first, chosen, seed),
        design.knowledge(max(fewer, key=design.loss)),
        wanted.chance,
        room,
        read,
        len(known.values),
        len(kept),
    )


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


class Design:
    """Sets of candidates, by number, and what is known after them.

    Attributes
    ----------
    believed : ndarray, shape (k, k)
        Covariance of the unknowns beforehand.
    derivatives : ndarray, shape (s, n, m, k)
        Of the m numbers measured of each of the n candidates, over their noise, in each sample.
    target : Target
        What is asked for.
    """

    def __init__(self, believed: Array, derivatives: Array, target: Target) -> None:
        # In units of what is believed, so that what is known beforehand costs no digits.
        values, vectors = np.linalg.eigh(believed)
        seen = values > 1e-12 * values.max()
        root = vectors[:, seen] * np.sqrt(values[seen])
        self.rows = derivatives @ root
        self.gradient = target.gradient @ root
        self.target = target
        self.information = np.einsum("snik,snil->snkl", self.rows, self.rows)

    def covariance(self, chosen: list[int]) -> Array:
        """Of the unknowns after these pushes, (s, k, k)."""
        size = self.rows.shape[-1]
        return np.asarray(np.linalg.inv(np.eye(size) + self.information[:, chosen].sum(axis=1)))

    def variance(self, chosen: list[int]) -> Array:
        """Of what is asked, (s, m)."""
        return np.asarray(
            np.einsum("smk,skl,sml->sm", self.gradient, self.covariance(chosen), self.gradient)
        )

    def loss(self, chosen: list[int]) -> float:
        """What is to be small, after these pushes."""
        return float(self.target.loss(self.variance(chosen)))

    def knowledge(self, chosen: list[int]) -> dict[str, float]:
        """What is known after these pushes, by name."""
        return self.target.words(self.variance(chosen))

    def with_one_more(self, chosen: list[int]) -> Array:
        """The loss (n,) after these pushes and each of the candidates."""
        before = self.covariance(chosen)[:, None]
        spread = self.rows @ before
        measured = spread @ self.rows.swapaxes(-1, -2) + np.eye(self.rows.shape[2])
        asked = self.gradient[:, None].swapaxes(-1, -2)
        seen = spread @ asked
        gained = (seen * np.linalg.solve(measured, seen)).sum(axis=2)
        variance = (asked * (before @ asked)).sum(axis=2)
        losses = self.target.loss(np.maximum(variance - gained, 0.0).swapaxes(0, 1))
        losses[chosen] = math.inf
        return losses

    def greedy(self, count: int, among: Sequence[int]) -> list[int]:
        """So many of some pushes, each the one that tells most after those before it."""
        chosen = list[int]()
        while len(chosen) < count:
            losses = self.with_one_more(chosen)
            chosen.append(min(among, key=losses.__getitem__))
        return chosen

    def exchanged(self, chosen: list[int]) -> list[int]:
        """The set with pushes exchanged for better ones: in all, and on average over the loss of
        any of them.
        """
        kept = list(chosen)
        for _ in range(_ROUNDS):
            before = [*kept]
            for place in range(len(kept)):
                rest = kept[:place] + kept[place + 1 :]
                losses = self.with_one_more(rest)
                for lost in range(len(rest)):
                    fewer = self.with_one_more(rest[:lost] + rest[lost + 1 :])
                    losses = losses + np.where(np.isinf(losses), 0.0, fewer) / len(rest)
                best = int(np.argmin(losses))
                if losses[best] < (1.0 - _GAIN) * losses[kept[place]]:
                    kept[place] = best
            if kept == before:
                break
        return kept
