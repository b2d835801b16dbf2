"""From a strategy's maps to the laws of its schedule: which chain follows a periodic, a block or a fixed sequence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cyclemap.errors import InvalidInput
from cyclemap.maps import Noise
from cyclemap.maps.arcs import Array
from cyclemap.maps.mixtures.law_evolution import (
    CycleOperator,
    fourier_basis,
    images_law,
    real_coefficients,
    stationary_fourier_law,
)
from cyclemap.maps.operator.fourier_discretisation import needed_modes
from cyclemap.resets.scores.schedule_cells import CellOperators, ScheduleCells
from cyclemap.resets.scores.schedule_chains import MOST_BLOCK, BlockChain, OrderChain, ScheduleChain
from cyclemap.resets.scores.schedule_laws import HORIZON, ScheduleLaws
from cyclemap.resets.scores.schedule_orders import schedule_orders
from cyclemap.resets.scores.strategy_operators import action_operators, independent_operator
from cyclemap.resets.strategies.strategy import PERIODIC
from cyclemap.resets.strategies.strategy_maps import StrategyMaps

FOLLOWED_RUNS = 64
_LEAST_FOLLOWED = 384  # pushes of a run
_BLOCK_STARTS = 24  # starts compared for blocks whose orders are many
_MANY = 9  # actions of a block from which on that is so


@dataclass(frozen=True, eq=False)
class OperatorImages:
    """The laws one push after angles under each of several operators."""

    operators: Sequence[CycleOperator]

    def images(self, theta: Array) -> Array:
        """(operators, m, n)."""
        return np.stack([images_law(fourier_basis(operator), theta).T for operator in self.operators])


def schedule_laws(
    maps: StrategyMaps, noise: Noise, *, modes: int | None, starts: int, pushes: int, runs: int, seed: int
) -> ScheduleLaws:
    """The laws of a strategy whose pushes know of each other.

    Periodic: the operators of the actions in turn. Latin blocks of one number, up to 12 sectors: all orders, exactly.
    Anything else: ``runs`` runs of the very schedule, followed on cells of what it draws.

    modes : Fourier modes kept; None: all that the noise lets through.
    Raises InvalidInput for a strategy that does not say what it draws, unless it is periodic.
    """
    guess = independent_operator(maps, noise, modes)
    law = stationary_fourier_law(guess, bounded=False)
    if maps.law.kind == PERIODIC:
        operators = action_operators(maps, noise, modes)
        chain: ScheduleChain = periodic_chain(operators)
        first = real_coefficients(law.moments, chain.size // 2)
        return ScheduleLaws(chain, OperatorImages(operators), first, starts, pushes)
    kept = needed_modes(noise) if modes is None else modes
    first, options = real_coefficients(law.moments, kept), (starts, pushes)
    images = CellOperators(maps, ScheduleCells(maps.strategy, maps.nodes), noise, kept)
    chain = _chain(images, runs, max(_LEAST_FOLLOWED, HORIZON * pushes), seed)
    if isinstance(chain, BlockChain) and chain.period >= _MANY:
        options = min(starts, _BLOCK_STARTS), pushes
    return ScheduleLaws(chain, images, first, *options)


def periodic_chain(operators: Sequence[CycleOperator]) -> OrderChain:
    """The operators in turn, again and again; all on as many Fourier modes."""
    matrices = [np.asarray(fourier_basis(operator).matrix) for operator in operators]
    if len({matrix.shape for matrix in matrices}) != 1:
        raise InvalidInput("the operators of a period keep different numbers of modes: give them the same noise")
    return OrderChain(np.stack(matrices), np.arange(len(matrices))[None], np.ones(1), len(matrices))


def _chain(images: CellOperators, runs: int, pushes: int, seed: int) -> ScheduleChain:
    block = images.cells.block
    if block is not None and block <= MOST_BLOCK:
        return BlockChain(images.matrices)
    orders = schedule_orders(images.cells, runs, pushes, seed)
    return OrderChain(images.matrices, orders.cells, orders.chances, turns=orders.turns)
