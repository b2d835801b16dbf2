"""Drawn pushes made for a range of materials, and checked on materials that they were not made with."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.maps import Noise
from cyclemap.mechanics import Material, SidePush
from cyclemap.resets.design.searched_candidates import rounded_pushes
from cyclemap.resets.robust.material_range import MaterialRange
from cyclemap.resets.robust.material_score import DEFAULT_NOISE, QuickGrid, independent_law
from cyclemap.resets.robust.robust_weights import RobustPushes, choice_of_pushes, robust_push_weights
from cyclemap.resets.robust.sampled_materials import INDEPENDENT
from cyclemap.resets.robust.worst_case import DEFAULT_ALLOWANCE, Allowance, WorstCase, worst_case
from cyclemap.resets.strategies.action_cost import strategy_cost
from cyclemap.resets.strategies.push_strategies import DrawnPushes
from cyclemap.resets.strategies.strategy import ResetStrategy

Array = NDArray[np.float64]
Progress = Callable[[str, float], None]

# Total variations came out within .0001 of those of 48 samples on plywood.
ROBUST_GRID = QuickGrid(samples=24)
SLANTS = (-math.radians(30.0), math.radians(30.0))
_PRECHECKED, _ROUNDS, _STARTS = 32, 3, 2
# Orientations that a push is tried from, and the share of its way that a slanted one must stay at the object: with half
# of it the worst corner of the range about delrin came out at .110, with a third at .057, and at .043 with slanted
# pushes at further fractions.
_SLANTED_FRACTIONS = (0.15, 0.3, 0.7, 0.85)
_TRIED, _LEAST_SHARE = 8, 1.0 / 3.0


@dataclass(frozen=True, eq=False)
class RobustReset:
    """Drawn pushes for a range of materials.

    materials : the range. made : how they were found. strategy : they, with weights of four digits. check : the same
    pushes on the nominal material, the corners of the range, and materials drawn independently, with none of which
    they were made: what holds for the share of these holds for the range. slanted : whether slanted pushes were to
    choose from.
    seed : of the check.
    """

    materials: MaterialRange
    made: RobustPushes
    strategy: DrawnPushes
    check: WorstCase
    slanted: bool
    seed: int

    @property
    def holds(self) -> bool:
        """Whether the allowance is kept on every material of the check."""
        return self.check.holds

    @property
    def drawn(self) -> int:
        """Materials that were drawn."""
        return self.check.sample.drawn

    @property
    def exceeding_drawn(self) -> int:
        """How many of the drawn materials exceed the allowance."""
        return self.check.exceeding_drawn

    @property
    def mean_drag_ratio(self) -> float:
        """Mean drag over that of the loop's own reset, mean over the drawn materials."""
        return float(np.mean(self.check.column("drag_ratio")[self.check.sample.chosen :]))

    @property
    def worst_material(self) -> Material:
        """The one that exceeds the allowance by most, or comes nearest to it."""
        return self.check.furthest

    def changes(self, name: str) -> Array:
        """Return by how much a coordinate of the sample is off nominal, (n,): a share; of phi, rad."""
        names = self.check.sample.names
        if name not in names:
            raise InvalidInput(f"the sample has no {name!r}: it has {', '.join(names) or 'no coordinate'}")
        source = self.materials
        width = {"phi": source.half_turn, "ratio": source.ratio, "pusher_friction": source.pusher_friction}
        return np.asarray(width.get(name, source.offset) * self.check.sample.points[:, names.index(name)])


def robust_reset(
    loop: CollectionLoop,
    materials: MaterialRange,
    *,
    allowance: Allowance = DEFAULT_ALLOWANCE,
    count: int = 200,
    seed: int = 0,
    pushes: Sequence[SidePush] | None = None,
    slants: Sequence[float] = SLANTS,
    reach: float | None = None,
    contact: float | None = None,
    noise: Noise = DEFAULT_NOISE,
    grid: QuickGrid = ROBUST_GRID,
    starts: int = _STARTS,
    workers: int | None = 1,
    progress: Progress | None = None,
) -> RobustReset:
    """Return drawn pushes with the least worst total variation over the range, checked on `count` drawn materials.

    pushes : to choose from; None: as `robust_push_weights`. slants : angles (rad, off the loop's own) of further pushes
    at these places (and, where none are given, some between), tried where the first ones do not hold. reach, contact :
    m; pushes that need more room about the target, or in which the rod may lose the object sooner, are left out; as
    the nominal material has it. seed : of the check. starts : of each search. Others: see `worst_case`.
    progress : called with what is being done and the fraction of it. About two minutes on two cores.

    The check's materials are drawn anew, so that Clopper & Pearson's bound on the share that exceeds is valid for it.
    Raises InvalidInput for bad values, and where no push is left.

    >>> from cyclemap.mechanics import EllipseFriction
    >>> even = MaterialRange(Material("even", EllipseFriction.isotropic(0.25)), ratio=0.0)
    >>> short = CollectionLoop.mit(even.material, push=SidePush(distance=0.02))
    >>> quick, slow = QuickGrid(samples=8, modes=8), Allowance(reach=1.0)
    >>> made = robust_reset(short, even, count=2, pushes=[short.push], allowance=slow, grid=quick, starts=1)
    >>> made.holds, made.exceeding_drawn, made.drawn
    (True, 0, 2)
    """
    many, number = whole_number("count", count, least=1), whole_number("seed", seed, least=0)
    report = progress or (lambda stage, done: None)
    options: dict[str, Any] = {"allowance": allowance, "noise": noise, "grid": grid, "workers": workers}
    choice = _possible(loop, choice_of_pushes(loop, pushes), reach, contact)
    if not choice:
        raise InvalidInput("no push keeps to reach and contact: allow more room about the target, or a shorter contact")
    search = {**options, "starts": starts, "count": min(_PRECHECKED, many)}
    made = _designed(loop, materials, choice, search, report, "robust pushes")
    slanted = () if made.holds else _possible(loop, _slanted(choice, slants, pushes is None), reach, contact)
    if slanted:
        both = (*choice, *slanted)
        other = _designed(loop, materials, both, search, report, "robust pushes, slanted too")
        made = min(made, other, key=lambda one: (not one.holds, one.found.bias))
    strategy = rounded_pushes(made.found)
    corners = len(materials.without_direction().scenarios())
    check = worst_case(
        loop,
        strategy,
        materials,
        count=corners + many,
        seed=number + 2,  # the two before are those of the design
        draw=INDEPENDENT,
        progress=lambda done: report(f"checking on {many} materials", done),
        **options,
    )
    return RobustReset(materials, made, strategy, check, bool(slanted), number)


def corner_check(
    loop: CollectionLoop, strategy: ResetStrategy, materials: MaterialRange, robust: RobustReset, **options: Any
) -> WorstCase | None:
    """Return what another strategy does on the corners of the range; None where its cycles know of each other.

    The direction is left nominal. options : as of `worst_case`; unless told, the allowance is that of the robust check
    and the grid `ROBUST_GRID`.
    """
    try:
        independent_law(strategy, ROBUST_GRID.nodes)
    except InvalidInput:
        return None
    corners = materials.without_direction().scenarios().materials
    given = {"allowance": robust.check.allowance, "grid": ROBUST_GRID, **options}
    return worst_case(loop, strategy, corners, count=len(corners), **given)


def _designed(
    loop: CollectionLoop,
    materials: MaterialRange,
    choice: Sequence[SidePush],
    options: dict[str, Any],
    report: Progress,
    stage: str,
) -> RobustPushes:
    report(stage, 0.0)
    return robust_push_weights(
        loop,
        materials,
        choice,
        rounds=_ROUNDS,
        draw=INDEPENDENT,
        progress=lambda done: report(stage, done),
        **options,
    )


def _slanted(choice: Sequence[SidePush], slants: Sequence[float], further: bool) -> tuple[SidePush, ...]:
    """The pushes turned by each angle; further : at other fractions too."""
    places = [replace(push, fraction=place) for push in choice for place in _SLANTED_FRACTIONS if further]
    every = dict.fromkeys((*choice, *places))
    turned = [replace(push, angle=push.angle + angle) for push in every for angle in slants]
    return tuple(push for push in turned if push not in choice and abs(push.angle) < 0.5 * math.pi)


def _possible(
    loop: CollectionLoop, choice: Sequence[SidePush], reach: float | None, contact: float | None
) -> tuple[SidePush, ...]:
    """Those in which the rod stays at the object long enough, and that need no more room than allowed.

    Slanted pushes must stay for a third of their way, whatever is asked.
    """
    kept = []
    for push in choice:
        least = max(contact or 0.0, _LEAST_SHARE * push.distance if push.angle != loop.push.angle else 0.0)
        if least and _least_travel(loop, push) < least:
            continue
        if reach is None or strategy_cost(loop, DrawnPushes((push,))).reach <= reach:
            kept.append(push)
    return tuple(kept)


def _least_travel(loop: CollectionLoop, push: SidePush) -> float:
    """The shortest way (m) in contact from some orientations; zero where the push cannot be made."""
    starts = (2.0 * math.pi * np.arange(_TRIED) / _TRIED).tolist()
    try:
        return min(loop.model.push(loop.start_pose(start), push).travel for start in starts)
    except CycleMapError:
        return 0.0
