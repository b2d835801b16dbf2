"""The search: every subset of at most four actions with equal weights, then weights, at the worst
of a range.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import reduce
from itertools import combinations, compress, product

import numpy as np

from cyclemap.arrays import Array, Place
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError
from cyclemap.mechanics import Material, Polygon
from cyclemap.progress import Progress
from cyclemap.protocol.strategy import (
    GRIPPER,
    RING,
    CycleAction,
    ResetStrategy,
    gripper_turns,
    legs,
)
from cyclemap.resets.action_cycles import SampledTurns, contact_lengths, sample_turns
from cyclemap.resets.material_range import MaterialRange
from cyclemap.resets.orientation_law import (
    affine_kernels,
    farthest,
    long_run,
    total_variation,
)

FRACTIONS = (0.15, 0.3, 0.5, 0.7, 0.85)
# Slants (rad) of pushes that are looked at first, and where those do not do.
SLANTS = (-math.radians(10.0), 0.0, math.radians(10.0))
MORE_SLANTS = tuple(math.radians(10.0 * step) for step in range(-3, 4))
# In eight equal directions a leg leaves the same whichever way the surface lies, but for its eighth
# harmonic.
LEG_LENGTHS = (0.10, 0.20)
LEG_DIRECTIONS = 8
MOST_TOGETHER = 4
# Of an object with more sides than this only straight pushes are considered, and not on every side.
_MANY_SIDES = 4
_MOST_SIDES = 8
SAMPLES = 36
_REFINED = 256
# A slope of the turn above this jumps where friction is a little different: such pushes are not
# certain.
STEEPEST = 2.5
_ROUGH_MODES = 8
_MODES = 12
_AT_ONCE = 2_000
# Starts and places at which the search compares densities of twelve harmonics with uniform.
_STARTS = 24
_PLACES = 48
# Subsets kept from the rough look at few materials, and those whose weights are varied.
_KEPT = 150
_WEIGHED = 40
_PARTS = (1, 2, 3)
_MATERIALS_FIRST = 3


@dataclass(frozen=True, eq=False)
class ActionSet:
    """Actions that can be done together, with all that the search asks of them.

    family : "pushes", "way back", "gripper" or "ring".
    hitch : m, of the ring, None: the loop's.
    turns : on all materials of the range.
    contact : (k,), m, shortest.
    kernels : (materials, k, 2M + 1, 2M + 1).
    """

    family: str
    actions: tuple[CycleAction, ...]
    hitch: Place | None
    turns: SampledTurns
    contact: Array
    kernels: Array


@dataclass(frozen=True, eq=False)
class Candidates:
    """Mixtures of the actions of a set, n of them.

    shares : (n, k), how often each action comes.
    tv, after : (n,), total variation from uniform at the worst of the range, in the long run and
        after the pushes asked for from the worst start.
    """

    source: ActionSet
    shares: Array
    tv: Array
    after: Array

    def strategy(self, index: int) -> ResetStrategy:
        """Return one of them as a strategy, actions in random order."""
        shares = self.shares[index]
        used = shares[shares > 0.0]
        weights = np.round(used / used.min()).tolist()
        actions = tuple(compress(self.source.actions, shares > 0.0))
        return ResetStrategy(actions, tuple(weights), hitch=self.source.hitch)


def own_pushes(
    loop: CollectionLoop, about: MaterialRange, sigma: float, within: int
) -> list[Candidates]:
    """Return what can be done with the loop's own push.

    It is dragged back by legs of two lengths, each in eight directions drawn at random; or followed
    by a gripper's turn, of half, quarter or 10° turns.
    """
    actions = tuple(leg for length in LEG_LENGTHS for leg in legs(length, LEG_DIRECTIONS))
    dragged = _action_set("way back", loop, actions, about.searched, sigma)
    each = np.kron(np.eye(len(LEG_LENGTHS)), np.full((1, LEG_DIRECTIONS), 1.0 / LEG_DIRECTIONS))
    turned = _action_set(GRIPPER, loop, gripper_turns(36), about.searched, sigma)
    shares = np.array(
        [[float(step % (36 // count) == 0) / count for step in range(36)] for count in (2, 4, 36)]
    )
    return [scored(dragged, each, within), scored(turned, shares, within)]


def push_set(
    loop: CollectionLoop,
    about: MaterialRange,
    sigma: float,
    least_contact: float,
    slants: tuple[float, ...] = SLANTS,
    hitch: Place | None = None,
) -> ActionSet | None:
    """Return the pushes of the loop's length on all sides that keep the object for `least_contact`
    (m) and never jump.

    slants : rad, beside the loop's own.
    hitch : the ring there, pushed with the loop's own slant. None where none does.
    """
    prepared = ResetStrategy((CycleAction(),), hitch=hitch).prepared(loop)
    possible = []
    for action in _pushes_around(loop, slants, hitch is not None):
        # The object may not allow it: in a concave corner, or running into two sides.
        with suppress(CycleMapError):
            action.on(prepared).cycle(0.0)
            possible.append(action)
    kept = [*compress(possible, contact_lengths(prepared, possible) >= least_contact)]
    if not kept:
        return None
    nominal = sample_turns(prepared, kept, [about.nominal], SAMPLES)
    calm = tuple(compress(kept, nominal.steepest <= STEEPEST))
    if not calm:
        return None
    family = "pushes" if hitch is None else RING
    made = _action_set(family, prepared, calm, about.searched, sigma, hitch)
    steepest = made.turns.steepest
    # Where every push jumps somewhere in the range, the one that is least steep.
    chosen = steepest <= max(STEEPEST, steepest.min())
    return replace(
        made,
        actions=tuple(compress(made.actions, chosen)),
        turns=SampledTurns(made.turns.turn[:, chosen], made.turns.drag_length[:, chosen]),
        contact=made.contact[chosen],
        kernels=made.kernels[:, chosen],
    )


def _pushes_around(
    loop: CollectionLoop, slants: tuple[float, ...], straight: bool
) -> list[CycleAction]:
    """The loop's push at several places and slants of every side, those of the loop itself among
    them; `straight`: with its own slant alone.
    """
    outline = loop.slider.outline
    own = loop.push
    count = min(outline.sides, _MOST_SIDES)
    sides = sorted({round(side) for side in np.linspace(0, outline.sides - 1, count)})
    fractions = sorted(
        {own.fraction, 0.3, 0.7} if straight else {*FRACTIONS, own.fraction, 1.0 - own.fraction}
    )
    if not isinstance(outline, Polygon):
        fractions = [step / 12.0 for step in range(12)]
    apart = np.diff(np.round(fractions, 6), prepend=-1.0) > 1e-3
    has_many = outline.sides > _MANY_SIDES
    angles = (own.angle,) if straight or has_many else sorted({*slants, own.angle})
    places = product(sides, np.array(fractions)[apart].tolist(), angles)
    return [
        CycleAction(push=replace(own, side=side, fraction=fraction, angle=slant))
        for side, fraction, slant in places
    ]


def searched(source: ActionSet, within: int, progress: Progress) -> Candidates:
    """Return the best mixtures of at most four actions, over the whole range.

    Every subset is looked at with equal weights: roughly on the materials farthest apart, then all
    of one or two actions and the best 150 of three and of four on all materials; then the best 40
    of two or three with all weights of one to three parts.
    """
    # Roughly: on the nominal material and the two farthest away, with fewer harmonics.
    turn = source.turns.turn
    chosen = [0]
    while len(chosen) < min(_MATERIALS_FIRST, len(turn)):
        apart = np.min([np.abs(turn - turn[place]).mean(axis=(1, 2)) for place in chosen], axis=0)
        chosen.append(int(np.argmax(apart)))
    kept = [*range(_ROUGH_MODES), *range(_MODES, _MODES + _ROUGH_MODES), 2 * _MODES]
    count = len(source.actions)
    rough = replace(source, kernels=source.kernels[np.ix_(chosen, range(count), kept, kept)])
    mixed = []
    for size in range(1, min(MOST_TOGETHER, count) + 1):
        subsets = np.array(list(combinations(range(count), size)))
        shares = np.zeros((len(subsets), count))
        np.put_along_axis(shares, subsets, 1.0 / subsets.shape[1], axis=1)
        order = np.argsort(scored(rough, shares).tv, kind="stable")
        mixed.append(scored(source, shares[order[: _KEPT if size > 2 else None]], within))
        progress(0.8 * size / MOST_TOGETHER)
    if count > 1:
        few = _joined(mixed[1 : MOST_TOGETHER - 1])
        best = few.shares[np.argsort(few.after, kind="stable")[:_WEIGHED]]
        mixed.append(scored(source, _weighed(best), within))
    return _joined(mixed)


def _joined(mixed: list[Candidates]) -> Candidates:
    """The mixtures of the same actions as one."""
    columns = zip(*((each.shares, each.tv, each.after) for each in mixed), strict=True)
    return Candidates(mixed[0].source, *map(np.concatenate, columns))


def scored(source: ActionSet, shares: Array, within: int | None = None) -> Candidates:
    """Return mixtures with the given shares (n, k) and their total variations at the worst of the
    range.

    Without `within` those after so many pushes are not looked at.
    """
    tv = np.zeros(len(shares))
    after = np.zeros(len(shares))
    for kernels in source.kernels:
        for begin in range(0, len(shares), _AT_ONCE):
            rows = slice(begin, begin + _AT_ONCE)
            mixed = np.tensordot(shares[rows], kernels, axes=1)
            tv[rows] = np.maximum(
                tv[rows], np.minimum(total_variation(long_run(mixed), _PLACES), 1.0)
            )
            if within is not None:
                after[rows] = np.maximum(
                    after[rows], farthest(np.linalg.matrix_power(mixed, within), _STARTS, _PLACES)
                )
    return Candidates(source, shares, tv, after)


def _action_set(
    family: str,
    loop: CollectionLoop,
    actions: tuple[CycleAction, ...],
    materials: tuple[Material, ...],
    sigma: float,
    hitch: Place | None = None,
) -> ActionSet:
    turns = sample_turns(loop, actions, materials, SAMPLES)
    kernels = affine_kernels(turns.refined(_REFINED), _MODES, sigma)
    return ActionSet(family, actions, hitch, turns, contact_lengths(loop, actions), kernels)


def _weighed(shares: Array) -> Array:
    """The mixtures with unequal weights of one to three parts for each of their actions."""
    rows = []
    for row in shares:
        chosen = np.flatnonzero(row)
        for weights in product(_PARTS, repeat=len(chosen)):
            if reduce(math.gcd, weights) == 1 and len(set(weights)) > 1:
                made = np.zeros_like(row)
                made[chosen] = np.array(weights) / sum(weights)
                rows.append(made)
    return np.array(rows).reshape(-1, shares.shape[1])
