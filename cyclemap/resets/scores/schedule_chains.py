"""Cycles whose actions know of each other, as laws of the orientation together with the schedule's own state."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, pairwise
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import Array

Order = npt.NDArray[np.int64]
MOST_BLOCK = 12  # actions of a block whose orders are all followed: 2¹² sets


class JointLaw(NamedTuple):
    """Laws of the orientation and the schedule's state before push ``push`` + 1.

    rows : (states, c, n), Fourier coefficients (1, E cos mθ, E sin mθ) of c laws, each state's times its chance.
    """

    push: int
    rows: Array

    @property
    def marginal(self) -> Array:
        """(c, n): of the orientation alone."""
        return np.asarray(self.rows.sum(axis=0))


class ScheduleChain(Protocol):
    """What carries laws through a schedule, push by push, from the schedule's own beginning.

    period : pushes after which the schedule's state is that of its beginning, whatever was drawn; None: never.
    """

    @property
    def size(self) -> int:
        """n, Fourier coefficients of a law."""

    @property
    def period(self) -> int | None:
        """Pushes after which the schedule's state is that of its beginning."""

    def begin(self, rows: Array) -> JointLaw:
        """Before the first push, for laws (c, n) of the first orientation."""

    def begin_after(self, images: Array) -> JointLaw:
        """Before the second push; images (operators, c, n): what each operator makes of c first orientations."""

    def advance(self, law: JointLaw) -> JointLaw:
        """One push later."""


@dataclass(frozen=True, eq=False)
class OrderChain:
    """Orders of the operators that are followed one by one, each with its chance.

    matrices : (operators, n, n). orders : (orders, pushes), the operator of each push; they are repeated after that.
    chances : (orders,), that sum to 1. period : as in ``ScheduleChain``. turns : (orders, pushes), rad, by which the
    object is turned after each push besides; None: by none.

    >>> half = np.diag([1.0, 0.5, 0.5])
    >>> chain = OrderChain(np.stack([np.eye(3), half]), np.array([[0, 1]]), np.ones(1), 2)
    >>> law = chain.begin(np.ones((1, 3)))
    >>> [float((law := chain.advance(law)).marginal[0, 1]) for _ in range(4)]
    [1.0, 0.5, 0.5, 0.25]
    """

    matrices: Array
    orders: Order
    chances: Array
    period: int | None = None
    turns: Array | None = None

    @property
    def size(self) -> int:
        """n."""
        return int(self.matrices.shape[1])

    def begin(self, rows: Array) -> JointLaw:
        """Before the first push, for laws (c, n) of the first orientation."""
        return JointLaw(0, np.asarray(rows * self.chances[:, None, None]))

    def begin_after(self, images: Array) -> JointLaw:
        """Before the second push; images (operators, c, n)."""
        return JointLaw(1, self._turned(0, images[self.orders[:, 0]] * self.chances[:, None, None]))

    def advance(self, law: JointLaw) -> JointLaw:
        """One push later."""
        after, now = np.empty_like(law.rows), self.orders[:, law.push % self.orders.shape[1]]
        for operator in np.unique(now):
            use = np.flatnonzero(now == operator)
            after[use] = _applied(self.matrices[operator], law.rows[use])
        return JointLaw(law.push + 1, self._turned(law.push, after))

    def _turned(self, push: int, rows: Array) -> Array:
        """The laws (orders, c, n) turned by what each order turns the object by: moments times e^{imτ}."""
        if self.turns is None:
            return rows
        modes = self.size // 2
        wave = np.exp(1j * np.outer(self.turns[:, push % self.orders.shape[1]], np.arange(1, modes + 1)))[:, None]
        moved = (rows[..., 1 : modes + 1] + 1j * rows[..., modes + 1 :]) * wave
        return np.concatenate([rows[..., :1], moved.real, moved.imag], axis=2)


@dataclass(frozen=True, eq=False)
class BlockChain:
    """Blocks of k pushes: each operator once in a block, all orders alike, exactly.

    The state is the set of operators that the block has had, of which all of one size are alike likely: the law given
    a set is the mean, over its members as the last, of that member's operator on the law given the others.

    matrices : (k, n, n), k up to 12.

    >>> turns = np.stack([np.diag([1.0, 0.5, 0.5]), np.diag([1.0, 0.3, 0.3])])
    >>> chain = BlockChain(turns)
    >>> law = chain.begin(np.ones((1, 3)))
    >>> [round(float((law := chain.advance(law)).marginal[0, 1]), 12) for _ in range(3)]
    [0.4, 0.15, 0.06]
    """

    matrices: Array

    def __post_init__(self) -> None:
        if len(self.matrices) > MOST_BLOCK:
            raise InvalidInput(f"a block of {len(self.matrices)} actions: at most {MOST_BLOCK} in all orders")

    @property
    def size(self) -> int:
        """n."""
        return int(self.matrices.shape[1])

    @property
    def period(self) -> int:
        """k."""
        return len(self.matrices)

    @cached_property
    def _steps(self) -> list[list[tuple[Any, Any]]]:
        """For every number of operators had, and every operator: the sets without it, and the same with it."""
        levels = [list(combinations(range(self.period), size)) for size in range(self.period + 1)]
        steps = []
        for known, later in pairwise(levels):
            place = {chosen: at for at, chosen in enumerate(later)}
            rows = []
            for i in range(self.period):
                free = [at for at, chosen in enumerate(known) if i not in chosen]
                rows.append((np.array(free), np.array([place[tuple(sorted((*known[at], i)))] for at in free])))
            steps.append(rows)
        return steps

    def begin(self, rows: Array) -> JointLaw:
        """Before the first push, for laws (c, n) of the first orientation."""
        return JointLaw(0, rows[None])

    def begin_after(self, images: Array) -> JointLaw:
        """Before the second push; images (k, c, n)."""
        return JointLaw(1, images / self.period)

    def advance(self, law: JointLaw) -> JointLaw:
        """One push later."""
        had = law.push % self.period
        after = np.zeros((math.comb(self.period, had + 1), *law.rows.shape[1:]))
        for matrix, (free, later) in zip(self.matrices, self._steps[had], strict=True):
            after[later] += _applied(matrix, law.rows[free])
        return JointLaw(law.push + 1, after / (self.period - had))


def _applied(matrix: Array, rows: Array) -> Array:
    """The matrix (n, n) on laws (states, c, n)."""
    return np.asarray((rows.reshape(-1, len(matrix)) @ matrix.T).reshape(rows.shape))
