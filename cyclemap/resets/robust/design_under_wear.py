"""What becomes of a reset as the surface wears: its law push by push, when it leaves the allowance, and redesigns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_number, read_only, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import Noise
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.law_evolution import complex_moments, real_coefficients
from cyclemap.maps.operator.fourier_discretisation import waves
from cyclemap.mechanics import SidePush
from cyclemap.resets.robust.material_score import DEFAULT_GRID, DEFAULT_NOISE, QuickGrid
from cyclemap.resets.robust.robust_weights import RobustPushes, robust_push_weights
from cyclemap.resets.robust.wear_stages import WearStage, wear_path, wear_stage
from cyclemap.resets.strategies.strategy import ResetStrategy

Array = NDArray[np.float64]
Stages = Sequence[tuple[int, ResetStrategy]]

_KNOTS = 5
_ON_PATH = 3  # materials of a stage that a redesign is made for


@dataclass(frozen=True, eq=False)
class ResetUnderWear:
    """A collection on a surface that wears.

    stages : each strategy, from its first push to the next one's. pushes : N. start : rad, orientation before push 0.
    variation : (N - 1,), total variation from uniform of the law of the orientation before pushes 1, ..., N - 1.
    collection : the mean of those laws, which a histogram of the whole collection follows.
    """

    stages: tuple[WearStage, ...]
    pushes: int
    start: float
    variation: Array
    collection: FourierLaw

    def stage(self, push: int) -> WearStage:
        """Return the stage that a push belongs to."""
        number = whole_number("push", push, least=0)
        return next((stage for stage in self.stages if number < stage.last), self.stages[-1])

    def frozen_variation(self, push: int) -> float:
        """Return the total variation from uniform of the stationary law, were the wear to stop at a push."""
        return float(self.stage(push).frozen_law(push).total_variation())

    def frozen_course(self, count: int = 41) -> tuple[Array, Array]:
        """Return `count` pushes evenly from the first to past the last, and `frozen_variation` there: two (count,)."""
        places = np.linspace(0, self.pushes, whole_number("count", count, least=2))
        laws = [self.stage(int(place)).frozen_law(place) for place in places.tolist()]
        return places, np.array([float(law.total_variation()) for law in laws])

    @cached_property
    def collection_variation(self) -> float:
        """Total variation of the whole collection's law from uniform."""
        return float(self.collection.total_variation())

    @property
    def blend_error(self) -> float:
        """Largest total variation by which blending operators was seen to be off; see `WearStage.blend_error`."""
        return max(stage.blend_error for stage in self.stages)

    def leaves(self, allow_tv: float = 0.05) -> int | None:
        """Return the first push whose frozen law is further from uniform than allowed; None where there is none.

        Looked for at the stages' knots, then halved in between: an excursion between two knots can be missed.
        """
        limit = finite_number("allow_tv", allow_tv)
        for stage in self.stages:
            low = stage.first
            for knot in np.ceil(stage.knots).astype(int).tolist():
                push = min(max(knot, stage.first), stage.last - 1)
                if self.frozen_variation(push) > limit:
                    return self._first_above(low, push, limit)
                low = push
        return None

    def _first_above(self, low: int, high: int, limit: float) -> int:
        """The first push in (low, high] above the limit, high being above; `low` itself if it is above too."""
        if self.frozen_variation(low) > limit:
            return low
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if self.frozen_variation(middle) > limit else (middle, high)
        return high


def reset_under_wear(
    loop: CollectionLoop,
    strategy: ResetStrategy | Stages,
    pushes: int,
    *,
    start: float = 0.0,
    knots: int = _KNOTS,
    noise: Noise = DEFAULT_NOISE,
    grid: QuickGrid = DEFAULT_GRID,
) -> ResetUnderWear:
    """Follow the law of the orientation through a collection of `pushes` pushes on a surface that wears.

    strategy : one, or (first push, strategy) in order, the first from push 0: a schedule of redesigns. Each draws its
    actions independently. start : rad, before push 0. knots : surfaces computed a stage, evenly in its pushes; the
    operator is blended in between (`blend_error` tells how well). noise : of a cycle. grid : of orientations.
    A material without wear stays as it is. Raises InvalidInput for bad values.

    >>> from cyclemap.mechanics import EllipseFriction, Material, SidePush
    >>> from cyclemap.resets.strategies.drag_strategies import StraightReset
    >>> even = Material("even", EllipseFriction.isotropic(0.25))
    >>> short = CollectionLoop.mit(even, push=SidePush(distance=0.02))
    >>> course = reset_under_wear(short, StraightReset(), 20, knots=2, grid=QuickGrid(samples=8, modes=8))
    >>> course.variation.shape, course.leaves(0.05)
    ((19,), None)
    """
    count, steps = whole_number("pushes", pushes, least=2), whole_number("knots", knots, least=2)
    plan = _checked_stages(strategy, count)
    ends = [first for first, _ in plan[1:]] + [count]
    stages = tuple(
        wear_stage(loop, one, first, last, steps, noise, grid) for (first, one), last in zip(plan, ends, strict=True)
    )
    begin = finite_number("start", start)
    size = max(stage.modes for stage in stages)
    total, variation, law = np.zeros(2 * size + 1), [], waves(np.array([begin]), stages[0].modes)[:, 0]
    for stage in stages:
        law = _resized(law, stage.modes)
        for push in range(stage.first, min(stage.last, count - 1)):
            law = stage.carried(law, push)
            total += _resized(law, size)
            variation.append(float(FourierLaw(complex_moments(law)).total_variation()))
    collection = FourierLaw(complex_moments(total / (count - 1)))
    return ResetUnderWear(stages, count, begin, read_only(variation), collection)


def redesign_under_wear(
    loop: CollectionLoop,
    pushes: int,
    choice: Sequence[SidePush] | None = None,
    *,
    stages: int = 1,
    on_path: int = _ON_PATH,
    progress: Callable[[float], None] | None = None,
    **options: Any,
) -> tuple[tuple[int, RobustPushes], ...]:
    """Return drawn pushes for each of `stages` equal parts of a collection, robust over the wear within each part.

    One stage is a single design for the whole wear. on_path : surfaces of a part, evenly from its first push to its
    last, for which `robust_push_weights` is asked, with its `options`. choice : of pushes to choose from.
    Raises InvalidInput where the material does not wear, or there are more stages than pushes.
    """
    parts, count = whole_number("stages", stages, least=1), whole_number("pushes", pushes, least=1)
    if parts > count:
        raise InvalidInput(f"{parts} stages do not fit into {count} pushes")
    bounds, made = np.linspace(0, count, parts + 1).astype(int).tolist(), []
    for number, (first, last) in enumerate(pairwise(bounds)):
        path = wear_path(loop.material, last, whole_number("on_path", on_path, least=1), first)
        made.append((first, robust_push_weights(loop, path, choice, **options)))
        if progress is not None:
            progress((number + 1) / parts)
    return tuple(made)


def _checked_stages(strategy: ResetStrategy | Stages, pushes: int) -> list[tuple[int, ResetStrategy]]:
    if isinstance(strategy, ResetStrategy):
        return [(0, strategy)]
    plan = [(whole_number("first push of a stage", first, least=0), one) for first, one in strategy]
    firsts = [first for first, _ in plan]
    if not plan or firsts[0] != 0 or any(b <= a for a, b in zip(firsts, [*firsts[1:], pushes], strict=True)):
        raise InvalidInput(
            f"stages begin at pushes {firsts}: the first at 0, each later than the one before, below {pushes}"
        )
    return plan


def _resized(law: Array, modes: int) -> Array:
    """Coefficients (n,) cut or filled with zeros to as many modes."""
    return real_coefficients(complex_moments(law), modes)
