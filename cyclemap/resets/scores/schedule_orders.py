"""Runs of a schedule as orders of its cells, spread evenly over the schedule's random beginnings."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from cyclemap.checks import whole_number
from cyclemap.maps.arcs import Array
from cyclemap.resets.scores.schedule_cells import ScheduleCells, gripper_turns
from cyclemap.resets.scores.schedule_chains import Order

_CANDIDATES = 6  # runs drawn for each that is kept
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)


class ScheduleOrders(NamedTuple):
    """The cells (runs, pushes) of runs of a schedule, their chances (runs,), and the turns that cells leave out.

    turns : (runs, pushes), rad, by the gripper; None where there are none.
    """

    cells: Order
    chances: Array
    turns: Array | None


def schedule_orders(cells: ScheduleCells, runs: int, pushes: int, seed: int = 0) -> ScheduleOrders:
    """Different runs of a schedule among ``runs``, evenly spread over its random beginnings.

    By the golden angle runs begin at the middles of as many equal parts. Else, of six times as many runs that are
    drawn, those are kept whose first point is nearest to those middles. Averages over a random shift then converge
    like a quadrature.

    >>> from cyclemap.mechanics import SidePush
    >>> from cyclemap.resets.strategies.push_strategies import AlternatingPushes, side_pushes
    >>> alternating = ScheduleCells(AlternatingPushes(side_pushes(SidePush(), (0, 2))), 1)
    >>> found = schedule_orders(alternating, 8, 4)
    >>> found.cells.tolist(), found.chances.tolist(), found.turns
    ([[0, 1, 0, 1]], [1.0], None)
    """
    count, length = whole_number("schedule runs", runs, least=1), whole_number("pushes", pushes, least=1)
    begun = whole_number("seed", seed, least=0)
    shares = _drawn(cells, count, length, begun) if cells.golden_axis is None else _golden(cells, count, length, begun)
    orders = cells.of(shares)
    if cells.turned:
        flat = shares.reshape(count * length, shares.shape[2])
        turns = gripper_turns(cells.strategy, flat, cells.turned).reshape(count, length)
        return ScheduleOrders(orders, np.full(count, 1.0 / count), turns)
    different, often = np.unique(orders, axis=0, return_counts=True)
    return ScheduleOrders(np.asarray(different), np.asarray(often / count), None)


def _golden(cells: ScheduleCells, runs: int, pushes: int, seed: int) -> Array:
    """Drawn points (runs, pushes, dimensions), those by the golden angle begun evenly."""
    one = cells.strategy.draws(pushes, seed)
    shares = np.tile(one, (runs, 1, 1))
    begins = (np.arange(runs)[:, None] + 0.5) / runs
    shares[:, :, cells.golden_axis] = (begins + _GOLDEN * np.arange(pushes)) % 1.0
    return np.asarray(shares)


def _drawn(cells: ScheduleCells, runs: int, pushes: int, seed: int) -> Array:
    """Drawn points (runs, pushes, dimensions) of runs stratified by their first."""
    seeds = [np.random.SeedSequence([seed, n]) for n in range(_CANDIDATES * runs)]
    first = np.array([cells.strategy.draws(1, own)[0] for own in seeds])
    kept = _stratified(_sorting_number(cells, first), runs)
    return np.array([cells.strategy.draws(pushes, seeds[at]) for at in kept])


def _sorting_number(cells: ScheduleCells, first: Array) -> Array:
    """The first known number of each run (runs,) that differs between runs; zeros where none does."""
    for number, axis in enumerate(cells.axes):
        if axis.known and np.ptp(first[:, number]) > 0.0:
            return first[:, number]
    return np.zeros(len(first))


def _stratified(numbers: Array, count: int) -> Any:
    """Which (count,) of the numbers are nearest to the middles of equal strata, each taken once."""
    order = np.argsort(numbers, kind="stable").reshape(count, -1)
    middles = (np.arange(count)[:, None] + 0.5) / count
    nearest = np.argmin(np.abs(numbers[order] - middles), axis=1)
    return order[np.arange(count), nearest]
