"""How often to draw each push so that orientations spread evenly on every material of a set."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import Noise
from cyclemap.maps.operator.fourier_discretisation import needed_modes
from cyclemap.mechanics import Material, SidePush
from cyclemap.resets.drawn_pushes.push_weights import PushWeights
from cyclemap.resets.robust.material_score import DEFAULT_GRID, DEFAULT_NOISE, QuickGrid
from cyclemap.resets.robust.sampled_materials import SOBOL, MaterialSource, material_source
from cyclemap.resets.robust.scenario_weights import least_worst_weights, scenario_library, scenario_row
from cyclemap.resets.robust.worst_case import DEFAULT_ALLOWANCE, Allowance, WorstCase, spread_work, worst_case
from cyclemap.resets.strategies.strategy import ResetStrategy

Array = NDArray[np.float64]

# With these the worst corner of ratio +-10 %, offset +-50 % about plywood came out at .041; with .2 to .8 at .060.
FRACTIONS = (0.1, 0.25, 0.75, 0.9)
_SCREENED = 64  # materials of the check that comes before the full one
_MODES = 96  # of the search: as many as tell any law that is nearly even


@dataclass(frozen=True, eq=False)
class RobustPushes:
    """Drawn pushes that were made for many materials at once.

    found : pushes and weights on the scenarios, by `best_push_weights`. scenarios : the materials that they were made
    for, those that a check added last. check : the last check, on the full sample if `holds`. history : the largest
    total variation in each check. holds : whether the allowance is kept on every material of the full sample.
    """

    found: PushWeights
    scenarios: tuple[Material, ...]
    check: WorstCase
    history: tuple[float, ...]
    holds: bool

    @property
    def strategy(self) -> ResetStrategy:
        """The pushes, drawn independently."""
        return self.found.strategy()


def robust_push_weights(
    loop: CollectionLoop,
    materials: MaterialSource | Material | Sequence[Material],
    pushes: Sequence[SidePush] | None = None,
    *,
    allowance: Allowance = DEFAULT_ALLOWANCE,
    count: int = 1000,
    seed: int = 0,
    draw: str = SOBOL,
    rounds: int = 6,
    most_pushes: int | None = None,
    starts: int = 4,
    noise: Noise = DEFAULT_NOISE,
    grid: QuickGrid = DEFAULT_GRID,
    workers: int | None = 1,
    progress: Callable[[float], None] | None = None,
) -> RobustPushes:
    """Return the push weights whose worst total variation over the materials is least, within the drag allowed.

    By scenarios (Calafiore & Campi 2006; with the worst of each check added, a cutting-plane method): weights are found
    for the source's scenarios, then checked on 64 materials and, where these hold, on all `count`; the worst material
    that exceeds becomes a scenario, up to `rounds` times. Where that is one already, or the scenarios are too much
    as they are, no more can be done with these pushes: `check` names it. A local optimum, as `best_push_weights` finds
    it.

    pushes : to choose from; None: those of the loop's own distance at fractions .1, .25, .75 and .9 of every side.
    most_pushes : how many may be drawn; None: as many as help. starts : of each search. Others: see `worst_case`.
    progress : called with the fraction of the rounds done, one at the end.

    >>> from cyclemap.mechanics import EllipseFriction
    >>> even = Material("even", EllipseFriction.isotropic(0.25))
    >>> short = CollectionLoop.mit(even, push=SidePush(distance=0.02))
    >>> quick = QuickGrid(samples=8, modes=8)
    >>> slow = Allowance(reach=1.0)
    >>> made = robust_push_weights(short, even, [short.push], count=1, allowance=slow, grid=quick, starts=1)
    >>> made.holds, [push.fraction for push in made.found.pushes]
    (True, [0.7])
    """
    source, report = material_source(materials).without_direction(), progress or (lambda fraction: None)
    whole_number("rounds", rounds, least=1)
    choice, known = choice_of_pushes(loop, pushes), list(source.scenarios().materials)
    rows = list(spread_work(partial(scenario_row, loop, choice, grid), known, workers))
    check = partial(worst_case, loop, allowance=allowance, noise=noise, grid=grid, workers=workers)
    history, modes = list[float](), max(grid.modes, min(_MODES, needed_modes(noise)))
    for number in range(rounds):
        library = scenario_library(choice, rows, noise, modes)
        drags = np.array([row.own_drag for row in rows])
        found = least_worst_weights(library, drags, allowance, most_pushes, starts, seed)
        tried = check(found.strategy(), source, count=min(count, _SCREENED), seed=seed + 1, draw=draw)
        if tried.holds:
            tried = check(found.strategy(), source, count=count, seed=seed, draw=draw)
        history.append(tried.worst()[1].total_variation)
        report((number + 1) / rounds)
        worst = tried.furthest
        hopeless = worst in known or found.bias > allowance.total_variation  # more scenarios only make it harder
        if tried.holds or hopeless or number + 1 == rounds:
            break
        known.append(worst)
        rows.append(scenario_row(loop, choice, grid, worst))
    report(1.0)
    return RobustPushes(found, tuple(known), tried, tuple(history), tried.holds)


def choice_of_pushes(loop: CollectionLoop, pushes: Sequence[SidePush] | None = None) -> tuple[SidePush, ...]:
    """Return the pushes to choose from: those given, each once, or the loop's at four fractions of every side.

    >>> len(choice_of_pushes(CollectionLoop.mit()))
    16
    """
    if pushes is None:
        sides = range(loop.slider.outline.sides)
        return tuple(replace(loop.push, side=side, fraction=place) for side in sides for place in FRACTIONS)
    given = tuple(dict.fromkeys(pushes))
    if not given or not all(isinstance(push, SidePush) for push in given):
        raise InvalidInput(f"pushes must be one or more of SidePush, not {pushes!r}")
    return given
