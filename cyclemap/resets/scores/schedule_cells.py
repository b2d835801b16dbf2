"""What a schedule draws, cut into cells, each with the mean operator of its actions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import Any

import numpy as np
import numpy.typing as npt

from cyclemap.errors import InvalidInput
from cyclemap.maps import Noise
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.mixtures.random_map import RandomMap
from cyclemap.maps.operator.fourier_discretisation import waves
from cyclemap.maps.quadrature import arc_rule
from cyclemap.resets.strategies.combined import Combined
from cyclemap.resets.strategies.drag_strategies import GripperTurn
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, PushChoice
from cyclemap.resets.strategies.schedules import INDEPENDENT, SEQUENCE, GoldenAngle, LatinBlocks
from cyclemap.resets.strategies.spread import Spread
from cyclemap.resets.strategies.strategy import DrawnStrategy, products_of_rows
from cyclemap.resets.strategies.strategy_maps import StrategyMaps

_CELLS = 144  # about as many where the schedule does not say how many
_INSIDE = 2  # Gauss nodes across a cell
_INSIDE_SECTOR = 8  # and across a sector of a Latin block, which is wider
_STEEPNESS = 512  # angles at which slopes are compared
_POINTS = 200_000


@dataclass(frozen=True, eq=False)
class DrawnAxis:
    """One drawn number between 0 and 1, cut into cells; nodes inside each, for the mean over it.

    ends : (cells - 1,), where a cell ends and the next begins. places, weights : (cells, nodes), the weights sum to 1
    in each cell. known : whether pushes know of each other by it; else it is drawn anew, one cell.
    """

    ends: Array
    places: Array
    weights: Array
    known: bool

    @property
    def cells(self) -> int:
        """How many."""
        return len(self.places)


@dataclass(frozen=True, eq=False)
class ScheduleCells:
    """The cells of a strategy's schedule: actions in one cell are drawn from it anew whenever it comes.

    For continuous numbers that is an approximation, which forgets where in the cell a push was: a change of the action
    by less than a cell, of mean 0. ``size`` cells in all, about 144 where the
    schedule does not say how many. Of a golden angle a cell stands for its middle: rounding it is forgotten soon.
    Raises InvalidInput for a strategy that does not say what it draws.

    >>> from cyclemap.resets.strategies.drag_strategies import TrailingLeg
    >>> from cyclemap.resets.strategies.schedules import GoldenAngle
    >>> cells = ScheduleCells(TrailingLeg(0.1, schedule=GoldenAngle()), nodes=32)
    >>> cells.size, cells.of(np.array([[0.0], [0.999]])).tolist()
    (144, [0, 143])
    """

    strategy: Any
    nodes: int

    def __post_init__(self) -> None:
        for part in _parts(self.strategy):
            if not isinstance(part, DrawnStrategy):
                name = getattr(part, "name", repr(part))
                raise InvalidInput(f"{name} does not say what it draws: derive it from DrawnStrategy to score it")

    @cached_property
    def axes(self) -> tuple[DrawnAxis, ...]:
        """Of all drawn numbers, in the order of ``draws``."""
        parts = _parts(self.strategy)
        smooth = sum(part.dimensions for part in parts if _is_known(part) and _cells_of(part) is None)
        across = max(2, round(_CELLS ** (1.0 / max(1, smooth))))
        inside = _INSIDE if self.golden_axis is None else 1
        rows = [_turn_axes(part) if part in self.turned else _axes(part, across, inside, self.nodes) for part in parts]
        return tuple(axis for row in rows for axis in row)

    @cached_property
    def turned(self) -> tuple[Any, ...]:
        """The gripper's turns by a fixed sequence: followed as they are, not on cells, since turns add up."""
        parts = [part for part in _parts(self.strategy) if part.dimensions and type(part) is GripperTurn]
        return tuple(part for part in parts if _plainly_drawn(part) and part.schedule.kind == SEQUENCE)

    @cached_property
    def golden_axis(self) -> int | None:
        """Which number goes on by the golden angle, where that alone and alternating pushes are known; else None."""
        parts = [part for part in _parts(self.strategy) if part.dimensions]
        known = [part for part in parts if _is_known(part) and not isinstance(part, AlternatingPushes)]
        if len(known) != 1 or known[0].dimensions != 1 or not isinstance(known[0].schedule, GoldenAngle):
            return None
        before = parts[: parts.index(known[0])]
        return sum(part.dimensions for part in before) if _plainly_drawn(known[0]) else None

    @property
    def size(self) -> int:
        """Number of cells."""
        return math.prod(axis.cells for axis in self.axes)

    @property
    def block(self) -> int | None:
        """Size of the Latin blocks, where all that is known of other pushes is one order of so many cells; else None.

        Pushes that are chosen by blocks share cells, so that theirs is the number of equal sectors, not of pushes.
        """
        known = [part for part in _parts(self.strategy) if part.dimensions and _is_known(part)]
        if len(known) != 1 or known[0].dimensions != 1 or not isinstance(known[0].schedule, LatinBlocks):
            return None
        return known[0].schedule.size if _plainly_drawn(known[0]) else None

    def of(self, shares: Array) -> npt.NDArray[np.int64]:
        """The cells (...,) of drawn points (..., dimensions)."""
        found = np.zeros(np.shape(shares)[:-1], dtype=np.int64)
        for number, axis in enumerate(self.axes):
            found = found * axis.cells + np.searchsorted(axis.ends, shares[..., number], side="right")
        return np.asarray(found)

    def points(self, cell: int) -> tuple[Array, Array]:
        """The nodes (m, dimensions) of a cell and their weights (m,)."""
        places, weights = np.empty((1, 0)), np.ones((1, 1))
        for axis, at in zip(self.axes, np.unravel_index(cell, [a.cells for a in self.axes]), strict=True):
            row = axis.places[at]
            places = np.hstack([np.repeat(places, row.size, axis=0), np.tile(row, len(places))[:, None]])
            weights = products_of_rows(weights, axis.weights[at][None, :])
        return places, weights[0]


@dataclass(frozen=True, eq=False)
class CellOperators:
    """The mean operator of each cell's actions, on ``modes`` Fourier modes, maps interpolated as in sampling.

    The operator of an action between those of the law is that of the interpolated map.
    """

    maps: StrategyMaps
    cells: ScheduleCells
    noise: Noise
    modes: int

    @cached_property
    def matrices(self) -> Array:
        """(cells, n, n)."""
        theta, weight = self._rule
        scale = np.where(self._orders == 0.0, 1.0, 2.0) / TWO_PI
        before = (waves(theta, self.modes) * weight).T * scale
        found = self._after(theta) @ before
        found[:, 0] = 0.0
        found[:, 0, 0] = 1.0
        return np.asarray(found)

    def images(self, theta: Array) -> Array:
        """(cells, m, n): laws after one push with a cell's actions from angles (m,)."""
        return np.swapaxes(self._after(theta), 1, 2)

    @cached_property
    def _orders(self) -> Array:
        rising = np.arange(1.0, self.modes + 1.0)
        return np.concatenate([[0.0], rising, rising])

    @cached_property
    def _drawn(self) -> list[tuple[Array, Array, Array]]:
        """For every cell: weights of the maps (m, maps), turns (m,) of the gripper and weights of the nodes (m,)."""
        strategy: Any = self.maps.strategy
        place = {one: k for k, one in enumerate(self._distinct)}
        together = np.eye(len(place))[[place[one] for one in self.maps.without_turn]]
        found = []
        for cell in range(self.cells.size):
            points, weights = self.cells.points(cell)
            rows = strategy.interpolation(points, self.maps.nodes) @ together
            others = tuple(part for part in _parts(strategy) if part not in self.cells.turned)
            found.append((rows, gripper_turns(strategy, points, others), weights))
        if sum(len(weights) for _, _, weights in found) > _POINTS:
            raise InvalidInput(f"the schedule has {self.cells.size} cells with too many nodes: ask for fewer of them")
        return found

    @cached_property
    def _distinct(self) -> tuple[Any, ...]:
        return tuple(dict.fromkeys(self.maps.without_turn))

    @cached_property
    def _rule(self) -> tuple[Array, Array]:
        """Nodes and weights over one turn, fine enough for the steepest of the maps."""
        mean = RandomMap(self._distinct, None, self.noise).mean_map
        grid = TWO_PI * np.arange(_STEEPNESS) / _STEEPNESS
        steepest = max(np.hypot(1.0, np.max(np.abs(one.derivative(grid)))) for one in self._distinct)
        bandwidth = self.modes * float(steepest / np.hypot(1.0, np.max(np.abs(mean.derivative(grid)))))
        return arc_rule(mean, 0.0, TWO_PI, bandwidth, every_sample=False)

    def _after(self, theta: Array) -> Array:
        """κ_m E (1, cos mF, sin mF) over each cell's actions, at angles (m,): (cells, n, m)."""
        table, kappa = np.stack([one(theta) for one in self._distinct]), self.noise.coefficients(self._orders)
        found = np.zeros((self.cells.size, kappa.size, theta.size))
        for cell, (rows, turns, weights) in enumerate(self._drawn):
            for row, turn, weight in zip(rows @ table, turns, weights, strict=True):
                found[cell] += (weight * kappa)[:, None] * waves(row + turn, self.modes)
        return found


def gripper_turns(strategy: Any, shares: Array, parts: tuple[Any, ...] | None = None) -> Array:
    """The gripper's turns (n,), rad, of the actions at drawn points (n, dimensions); by some parts alone, if given."""
    turns, at = np.zeros(len(shares)), 0
    for part in _parts(strategy):
        if (parts is None or part in parts) and any(action.turn for action in part.law(2).actions):
            drawn = part.actions_at(shares[:, at : at + part.dimensions])
            turns += [action.turn for action in drawn]
        at += part.dimensions
    return turns


# -- inside ----------------------------------------------------------------------------------------------------


def _parts(strategy: Any) -> tuple[Any, ...]:
    return strategy.parts if isinstance(strategy, Combined) else (strategy,)


def _plainly_drawn(part: DrawnStrategy) -> bool:
    """Whether its schedule alone says what it draws."""
    return type(part).draws is DrawnStrategy.draws


def _is_known(part: DrawnStrategy) -> bool:
    return not _plainly_drawn(part) or part.schedule.kind != INDEPENDENT


def _cells_of(part: DrawnStrategy) -> int | None:
    """How many cells its own schedule has along a number; None where any will do."""
    return part.schedule.size if isinstance(part.schedule, LatinBlocks) else part.schedule.sectors


def _axes(part: DrawnStrategy, across: int, inside: int, nodes: int) -> list[DrawnAxis]:
    known, own = _is_known(part), _cells_of(part)
    spreads = [number for number in part.drawn() if isinstance(number, Spread)]
    if isinstance(part, PushChoice):
        return [_choice(part, own, known)]
    if not known:
        return [_one_cell(spread, nodes) for spread in spreads]
    if own is not None:
        inside = 1 if part.schedule.sectors is not None else _INSIDE_SECTOR
    return [_even_cells(own or across, inside) for _ in spreads]


def _turn_axes(part: DrawnStrategy) -> list[DrawnAxis]:
    return [DrawnAxis(np.empty(0), np.full((1, 1), 0.5), np.ones((1, 1)), True) for _ in range(part.dimensions)]


def _even_cells(count: int, inside: int) -> DrawnAxis:
    x, w = np.polynomial.legendre.leggauss(inside)
    places = (np.arange(count)[:, None] + 0.5 * (1.0 + x)) / count
    return DrawnAxis(np.arange(1, count) / count, places, np.tile(0.5 * w, (count, 1)), True)


def _one_cell(spread: Spread, nodes: int) -> DrawnAxis:
    values, weights = spread.nodes(nodes)
    return DrawnAxis(np.empty(0), ((values - spread.low) / (spread.high - spread.low))[None], weights[None], False)


def _choice(part: PushChoice, sectors: int | None, known: bool) -> DrawnAxis:
    """A push is a cell; drawn anew, one cell for all; by blocks, as the equal sectors of the block have it."""
    chances, ends = part.chances, np.cumsum(part.chances)
    middles = ends - 0.5 * chances
    if not known:
        return DrawnAxis(np.empty(0), middles[None], chances[None], False)
    if sectors is None:
        return DrawnAxis(ends[:-1], middles[:, None], np.ones((len(chances), 1)), True)
    own = np.arange(1, sectors) / sectors
    edges = reduce(np.union1d, (ends[:-1], own, np.array([0.0, 1.0])))
    return _pieces(edges, sectors)


def _pieces(edges: Array, sectors: int) -> DrawnAxis:
    """Equal sectors, each with a node in every piece between the edges that lies in it, weighted by its length."""
    middles, lengths = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)
    owner = np.minimum((middles * sectors).astype(int), sectors - 1)
    most = int(np.bincount(owner, minlength=sectors).max())
    places, weights = np.zeros((sectors, most)), np.zeros((sectors, most))
    for sector in range(sectors):
        held = np.flatnonzero(owner == sector)
        places[sector, : held.size], weights[sector, : held.size] = middles[held], lengths[held] * sectors
        places[sector, held.size :] = middles[held[0]]
    return DrawnAxis(np.arange(1, sectors) / sectors, places, weights, True)
