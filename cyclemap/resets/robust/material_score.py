"""The bias and cost of a strategy on one material, quickly: cycle maps on a fixed grid of orientations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import positive_number, read_only, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps import CircleMap, Noise, WrappedNormal
from cyclemap.maps.arcs import TWO_PI
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.law_evolution import complex_moments, images_law, stationary_fourier_law
from cyclemap.maps.mixtures.mixture_operator import MixtureOperator, mixture_operator
from cyclemap.maps.mixtures.worst_start import largest_variation
from cyclemap.maps.operator.fourier_discretisation import needed_modes
from cyclemap.mechanics import SidePush
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.schedules import INDEPENDENT
from cyclemap.resets.strategies.shared_strokes import run_action, run_drag
from cyclemap.resets.strategies.strategy import ActionLaw, ResetStrategy
from cyclemap.resets.strategies.strategy_maps import checked_strategy, strategy_maps

Array = NDArray[np.float64]

_STARTS = 96  # compared for the worst one
EVEN = 0.3  # total variation beyond which a law is peaked, and a few modes do not tell it
_OWN_ORIENTATIONS = 12  # for the mean drag of the loop's own reset
DEFAULT_NOISE = WrappedNormal(DEFAULT_SIGMA)


@dataclass(frozen=True)
class QuickGrid:
    """How finely a material is looked at.

    samples : even orientations, even in number, between which the maps are monotone cubics. accuracy : rad, of a cycle.
    modes : Fourier modes of the law. allowed : error of the total variation, as halving the samples shows it, beyond
    which the maps are computed adaptively to `tolerance` (rad) instead. nodes : of a law with drawn directions.

    Total variations of drawn pushes on plywood, about .04, came out within .0002 of those of adaptive maps with 48
    samples, within .0005 with 16.
    """

    samples: int = 48
    accuracy: float = 1e-4
    modes: int = 48
    allowed: float = 0.004
    tolerance: float = 1e-3
    nodes: int = 16

    def __post_init__(self) -> None:
        if whole_number("samples", self.samples, least=8) % 2:
            raise InvalidInput(f"samples is {self.samples}: give an even number, so that half of them are a grid too")
        for name in ("modes", "nodes"):
            whole_number(name, getattr(self, name), least=1)
        for name in ("accuracy", "allowed", "tolerance"):
            positive_number(name, getattr(self, name))


DEFAULT_GRID = QuickGrid()


@dataclass(frozen=True)
class MaterialScore:
    """A strategy on one material.

    total_variation : of the stationary law from uniform. variation_after : of the law after the asked number of
    pushes from the worst start. drag_length : m, mean over the law and even orientations. own_drag : m, of the loop's
    own push and reset. error : of the total variation, as halving the samples shows it (more than
    it is). adaptive : whether the maps were computed adaptively; `error` is then that of the grid, which failed.
    """

    total_variation: float
    variation_after: float
    drag_length: float
    own_drag: float
    error: float
    adaptive: bool = False

    @property
    def drag_ratio(self) -> float:
        """Mean drag over that of the loop's own push and reset."""
        return self.drag_length / self.own_drag


@dataclass(frozen=True, eq=False)
class SampledCycles:
    """The cycles of several actions from even orientations.

    theta : (n,), rad. lifted : (k, n), theta_next on the lift, with the gripper's turn. drag_length : (k, n), m.
    """

    theta: Array
    lifted: Array
    drag_length: Array

    def __post_init__(self) -> None:
        for name in ("theta", "lifted", "drag_length"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @cached_property
    def maps(self) -> tuple[CircleMap, ...]:
        """The map of each action through all samples."""
        return tuple(CircleMap.from_samples(self.theta, row) for row in self.lifted)

    @cached_property
    def coarse_maps(self) -> tuple[CircleMap, ...]:
        """The map of each action through every second sample."""
        return tuple(CircleMap.from_samples(self.theta[::2], row[::2]) for row in self.lifted)

    @property
    def mean_drags(self) -> Array:
        """Mean length (k,), m, of each action's drag."""
        return np.asarray(self.drag_length.mean(axis=1))


def sample_cycles(
    loop: CollectionLoop, actions: Sequence[CycleAction], grid: QuickGrid = DEFAULT_GRID
) -> SampledCycles:
    """Run every action of a prepared loop from the grid's even orientations; actions with one push share its runs.

    >>> from cyclemap.mechanics import SidePush
    >>> short = CollectionLoop.mit(push=SidePush(distance=0.02))
    >>> sample_cycles(short, [CycleAction()], QuickGrid(samples=8)).lifted.shape
    (1, 8)
    """
    theta = TWO_PI * np.arange(grid.samples) / grid.samples
    rough = replace(loop, accuracy=grid.accuracy)
    rows = np.empty((len(actions), theta.size, 2))
    for push, members in _by_push([action.filled(loop) for action in actions]).items():
        for at, start in enumerate(theta.tolist()):
            pushed = rough.model.push(rough.start_pose(start), push)
            for index, action in members:
                drag = run_drag(rough, action, pushed)
                rows[index, at] = drag.end.theta + action.turn, drag.length
    return SampledCycles(theta, rows[..., 0], rows[..., 1])


def material_score(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    pushes: int = 50,
    noise: Noise = DEFAULT_NOISE,
    grid: QuickGrid = DEFAULT_GRID,
) -> MaterialScore:
    """Return how a strategy that draws its actions independently does on the loop's material.

    Some 100 cycles a push of the law, 2 ms each. A surface that wears is taken as it is when fresh.
    Raises InvalidInput for a strategy whose cycles know of each other (a periodic one, blocks, a fixed sequence).

    >>> from cyclemap.mechanics import EllipseFriction, Material, SidePush
    >>> from cyclemap.resets.strategies.drag_strategies import StraightReset
    >>> even = Material("even", EllipseFriction.isotropic(0.25))
    >>> short = CollectionLoop.mit(even, push=SidePush(distance=0.02))
    >>> score = material_score(short, StraightReset(), grid=QuickGrid(samples=8))
    >>> round(score.total_variation, 9), round(score.drag_ratio, 9)
    (0.0, 1.0)
    """
    law = independent_law(strategy, grid.nodes)
    count, prepared = whole_number("pushes", pushes, least=1), strategy.prepared(loop)
    cycles = sample_cycles(prepared, law.actions, grid)
    operator, found = resolved_operator(cycles.maps, law.weights, noise, grid.modes)
    error = abs(found - resolved_operator(cycles.coarse_maps, law.weights, noise, grid.modes)[1])
    if error > grid.allowed:
        made = strategy_maps(loop, strategy, nodes=grid.nodes, tolerance=grid.tolerance)
        operator, found = resolved_operator(made.maps, made.weights, noise, grid.modes)
    after = variation_after(operator, count)
    drag, own = float(law.weights @ cycles.mean_drags), own_drag(loop, grid.accuracy)
    return MaterialScore(found, after, drag, own, error, error > grid.allowed)


def independent_law(strategy: ResetStrategy, nodes: int) -> ActionLaw:
    """Return the law of a strategy, or raise InvalidInput where its cycles know of each other."""
    law = checked_strategy(strategy).law(nodes)
    if law.kind != INDEPENDENT and len(law.actions) > 1:
        raise InvalidInput(
            f"the cycles of {strategy.name!r} know of each other ({law.kind}): a range of materials is looked at for "
            "independent draws only; give the strategy the schedule Independent()"
        )
    return law


def own_drag(loop: CollectionLoop, accuracy: float = DEFAULT_GRID.accuracy) -> float:
    """Return the mean length (m) of the drag of the loop's own push and reset, over even orientations."""
    rough, theta = replace(loop, accuracy=accuracy), TWO_PI * np.arange(_OWN_ORIENTATIONS) / _OWN_ORIENTATIONS
    return float(np.mean([run_action(rough, CycleAction(), start)[1].length for start in theta.tolist()]))


def variation_after(operator: MixtureOperator, pushes: int) -> float:
    """Return the total variation from uniform after `pushes` cycles of an operator, from the worst of 96 starts."""
    basis, starts = operator.discretisation, TWO_PI * np.arange(_STARTS) / _STARTS
    columns = np.linalg.matrix_power(basis.matrix, pushes - 1) @ images_law(basis, starts)
    return min(1.0, largest_variation(complex_moments(columns), FourierLaw.uniform()))


def resolved_operator(
    maps: Sequence[CircleMap], weights: Array, noise: Noise, modes: int
) -> tuple[MixtureOperator, float]:
    """Return the operator of drawn maps and its law's total variation from uniform.

    With `modes` Fourier modes where the law is even enough for them, else with all that the noise lets through.
    """
    operator = mixture_operator(tuple(maps), weights, noise, modes)
    try:
        found = float(stationary_fourier_law(operator, bounded=False).total_variation())
    except ConvergenceError:
        found = 1.0
    if found <= EVEN or modes >= needed_modes(noise):
        return operator, found
    operator = mixture_operator(tuple(maps), weights, noise)
    return operator, float(stationary_fourier_law(operator, bounded=False).total_variation())


def _by_push(actions: Sequence[CycleAction]) -> dict[SidePush, list[tuple[int, CycleAction]]]:
    """Filled actions with their numbers, by their push."""
    found: dict[SidePush, list[tuple[int, CycleAction]]] = {}
    for index, action in enumerate(actions):
        assert action.push is not None
        found.setdefault(action.push, []).append((index, action))
    return found
