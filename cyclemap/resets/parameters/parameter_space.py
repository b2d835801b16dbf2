"""Families of strategies with continuous parameters, and how the law of a strategy moves with them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import finite_array, read_only
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import SidePush
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.strategy import DEFAULT_NODES, ActionLaw, ResetStrategy
from cyclemap.resets.strategies.strategy_maps import checked_strategy

Array = NDArray[np.float64]

# What an action is made of, besides its way-points: the gripper's turn, the push, and the ring of its loop.
NUMBERS = ("turn", "fraction", "angle", "distance", "hitch_x", "hitch_y")
# Share of a parameter's range by which the strategy's own algebra is differentiated; no mechanics is run for it.
_STEP = 1e-5


@dataclass(frozen=True, eq=False)
class StrategyFamily:
    """Strategies that differ in a few continuous parameters.

    title : for people. names : of the parameters, (k,). lower, upper : (k,), their bounds, SI and radians.
    build : makes the strategy of parameters (k,) within the bounds.

    Raises InvalidInput for names and bounds that do not fit each other.

    >>> from cyclemap.resets.strategies.drag_strategies import RingPlace
    >>> rings = StrategyFamily("ring", ("x", "y"), (-0.02, -0.02), (0.02, 0.02), lambda v: RingPlace(tuple(v)))
    >>> rings.strategy((0.0, 0.01))
    RingPlace(hitch=(0.0, 0.01))
    """

    title: str
    names: tuple[str, ...]
    lower: ArrayLike
    upper: ArrayLike
    build: Callable[[Array], ResetStrategy]

    def __post_init__(self) -> None:
        names = tuple(self.names)
        low, high = finite_array("lower", self.lower, ndim=1), finite_array("upper", self.upper, ndim=1)
        if not names or len(set(names)) != len(names):
            raise InvalidInput(f"a family needs one parameter or more, each with a name of its own, not {names}")
        if not low.size == high.size == len(names) or np.any(low >= high):
            raise InvalidInput(f"{len(names)} parameters need as many bounds, the lower below the upper")
        for field, value in (("names", names), ("lower", read_only(low)), ("upper", read_only(high))):
            object.__setattr__(self, field, value)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """The lower and the upper bounds, (k,) each."""
        return np.asarray(self.lower), np.asarray(self.upper)

    def checked(self, values: ArrayLike) -> Array:
        """Return parameters (k,), or raise InvalidInput where they are not within the bounds."""
        given, (low, high) = finite_array("parameters", values, ndim=1), self.bounds
        if given.size != len(self.names):
            raise InvalidInput(f"{self.title} has the {len(self.names)} parameters {self.names}, not {given.size}")
        for name, value, least, most in zip(self.names, given.tolist(), low.tolist(), high.tolist(), strict=True):
            if not least <= value <= most:
                raise InvalidInput(f"{name} is {value:g}: {self.title} keeps it between {least:g} and {most:g}")
        return given

    def strategy(self, values: ArrayLike) -> ResetStrategy:
        """Return the strategy with parameters (k,)."""
        return checked_strategy(self.build(self.checked(values)))

    def from_unit(self, shares: ArrayLike) -> Array:
        """Return the parameters (..., k) at shares (..., k), 0 to 1, of the way between the bounds."""
        low, high = self.bounds
        return np.asarray(np.clip(low + np.asarray(shares) * (high - low), low, high))

    def to_unit(self, values: ArrayLike) -> Array:
        """Return the shares (..., k) of the way between the bounds at which parameters (..., k) lie."""
        low, high = self.bounds
        return np.asarray((np.asarray(values) - low) / (high - low))

    def beside(self, values: Array, index: int, share: float) -> tuple[Array, Array]:
        """Return parameters (k,) with one less and more by a share of its range, no further than its bounds."""
        low, high = self.bounds
        step, less, more = share * (high[index] - low[index]), values.copy(), values.copy()
        less[index], more[index] = max(low[index], values[index] - step), min(high[index], values[index] + step)
        return less, more


@dataclass(frozen=True, eq=False)
class LawNumbers:
    """The law of a strategy as numbers: of its loop, its weights (k,), and each action by its `names`.

    actions : filled, so that each says push and way-points. numbers : of each action, in the order of its names.
    """

    loop: CollectionLoop
    law: ActionLaw
    actions: tuple[CycleAction, ...]
    names: tuple[tuple[str, ...], ...]
    numbers: tuple[Array, ...]

    @property
    def fixed(self) -> tuple[object, ...]:
        """What must not change with a parameter if the law is to be differentiated by it."""
        rest = replace(without_action(self.loop), slider=replace(self.loop.slider, hitch=(0.0, 0.0)))
        return (rest, self.law.kind, self.names, tuple(a.push.side for a in self.actions if a.push is not None))


def without_action(loop: CollectionLoop) -> CollectionLoop:
    """Return the loop with the default push and a straight drag: the same for all filled actions on it."""
    return replace(loop, push=SidePush(), reset=replace(loop.reset, way_points=()))


def law_numbers(loop: CollectionLoop, strategy: ResetStrategy, nodes: int = DEFAULT_NODES) -> LawNumbers:
    """Return the law of a strategy on a loop as numbers."""
    law, prepared = strategy.law(nodes), strategy.prepared(loop)
    actions = tuple(action.filled(prepared) for action in law.actions)
    pairs = [_numbers(action, prepared) for action in actions]
    return LawNumbers(prepared, law, actions, tuple(p[0] for p in pairs), tuple(p[1] for p in pairs))


def _numbers(action: CycleAction, loop: CollectionLoop) -> tuple[tuple[str, ...], Array]:
    push, points = action.push, action.way_points
    assert push is not None and points is not None
    ways = way_point_names(len(points))
    values = (action.turn, push.fraction, push.angle, push.distance, *loop.slider.hitch, *np.ravel(points).tolist())
    return (*NUMBERS, *ways), np.array(values)


def way_point_names(count: int) -> tuple[str, ...]:
    """Return the names of the coordinates of `count` way-points.

    >>> way_point_names(1)
    ('way_1_x', 'way_1_y')
    """
    return tuple(f"way_{number + 1}_{axis}" for number in range(count) for axis in "xy")


@dataclass(frozen=True, eq=False)
class LawTangent:
    """How the law of a family's strategy moves with its k parameters.

    at : the law there. weights : (actions, k), derivatives of the weights. numbers : of each action (r, k), derivatives
    of its numbers. smooth : (k,), where it can be differentiated at all; where not, its columns are zero.
    """

    at: LawNumbers
    weights: Array
    numbers: tuple[Array, ...]
    smooth: NDArray[np.bool_]

    @property
    def moving(self) -> tuple[str, ...]:
        """The names of the numbers that move with any parameter in any action, each once."""
        moved = [
            name
            for names, rows in zip(self.at.names, self.numbers, strict=True)
            for name, row in zip(names, rows, strict=True)
            if np.any(row)
        ]
        return tuple(dict.fromkeys(moved))


def law_tangent(
    family: StrategyFamily, values: ArrayLike, loop: CollectionLoop, nodes: int = DEFAULT_NODES
) -> LawTangent:
    """Return the law of the family's strategy at parameters (k,), and how it moves with them.

    By central differences of the strategy's own algebra, from parameters to pushes and way-points (1e-10 of it); at a
    bound one-sided (1e-5). Where a parameter changes what a law is made of (the number of its way-points, the side of
    a push, the loop besides its ring) there is no such derivative, and `smooth` says so.
    """
    given = family.checked(values)
    at = law_numbers(loop, family.strategy(given), nodes)
    weights = np.zeros((len(at.actions), given.size))
    numbers = tuple(np.zeros((len(names), given.size)) for names in at.names)
    smooth = np.zeros(given.size, dtype=bool)
    for index in range(given.size):
        ends = family.beside(given, index, _STEP)
        below, above = (law_numbers(loop, family.strategy(end), nodes) for end in ends)
        smooth[index] = below.fixed == above.fixed == at.fixed
        if smooth[index]:
            apart = ends[1][index] - ends[0][index]
            weights[:, index] = (above.law.weights - below.law.weights) / apart
            for rows, less, more in zip(numbers, below.numbers, above.numbers, strict=True):
                rows[:, index] = (more - less) / apart
    return LawTangent(at, weights, numbers, smooth)
