"""Schedules: in which order numbers between 0 and 1 are drawn, cycle by cycle; every one spreads evenly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import whole_number
from cyclemap.errors import InvalidInput

Array = NDArray[np.float64]

# How cycles depend on each other: drawn anew; in random order within blocks; a fixed sequence with a random start.
INDEPENDENT, BLOCKS, SEQUENCE = "independent", "blocks", "sequence"


@runtime_checkable
class Schedule(Protocol):
    """How the numbers of a strategy are drawn: points of the unit cube, one a cycle, evenly spread in the long run.

    A schedule is a frozen value: strategies with equal schedules can draw together.

    kind : `independent`, `blocks` or `sequence` (see above). Only independent draws make the orientations a Markov
    chain whose kernel is the mean over the law. The others share its one-cycle law and are more even in what is drawn,
    but a low-discrepancy sequence is not an independent draw: its cycles know of each other. That need not help: where
    the orientation forgets slowly, chance turns must add up to spread it, and turns of an even sequence cancel.
    sectors : number of values that a coordinate can take, the middles of as many equal sectors; None: any.
    """

    @property
    def kind(self) -> str:
        """`independent`, `blocks` or `sequence`."""

    @property
    def sectors(self) -> int | None:
        """Number of values of a coordinate, or None where it takes any."""

    def draws(self, cycles: int, dimensions: int, seed: int | np.random.SeedSequence) -> Array:
        """Return the points (cycles, dimensions), each coordinate in [0, 1)."""


@dataclass(frozen=True)
class Independent:
    """Every cycle draws anew, uniformly.

    >>> Independent().draws(3, 2, seed=1).shape
    (3, 2)
    """

    kind: ClassVar[str] = INDEPENDENT
    sectors: ClassVar[int | None] = None

    def draws(self, cycles: int, dimensions: int, seed: int | np.random.SeedSequence) -> Array:
        """Return uniform points (cycles, dimensions)."""
        size = _checked(cycles, dimensions)
        return np.random.default_rng(seed).random(size)


@dataclass(frozen=True)
class GoldenAngle:
    """Every cycle goes on by the golden angle, 137.5 degrees of a full turn, from a random start (Weyl 1916).

    For d coordinates the steps are the powers of 1/g, g the root of g^(d+1) = g + 1, of which the golden ratio is the
    first (Roberts 2018). The first n points of one coordinate leave gaps of at most three lengths.

    >>> steps = np.diff(GoldenAngle().draws(4, 1, seed=0)[:, 0]) % 1.0
    >>> (360.0 - 360.0 * steps).round(3)
    array([137.508, 137.508, 137.508])
    """

    kind: ClassVar[str] = SEQUENCE
    sectors: ClassVar[int | None] = None

    def draws(self, cycles: int, dimensions: int, seed: int | np.random.SeedSequence) -> Array:
        """Return the points (cycles, dimensions) of the additive recurrence."""
        count, size = _checked(cycles, dimensions)
        ratio = 2.0
        for _ in range(64):
            ratio = (1.0 + ratio) ** (1.0 / (size + 1))
        step = ratio ** -np.arange(1.0, size + 1.0)
        start = np.random.default_rng(seed).random(size)
        return np.asarray((start + np.outer(np.arange(count), step)) % 1.0)


@dataclass(frozen=True)
class VanDerCorput:
    """The scrambled van der Corput sequence in base 2; with more coordinates Halton's, in the bases of the primes.

    >>> np.sort(np.floor(8 * VanDerCorput().draws(8, 1, seed=3)[:, 0])).astype(int).tolist()
    [0, 1, 2, 3, 4, 5, 6, 7]
    """

    kind: ClassVar[str] = SEQUENCE
    sectors: ClassVar[int | None] = None

    def draws(self, cycles: int, dimensions: int, seed: int | np.random.SeedSequence) -> Array:
        """Return the points (cycles, dimensions)."""
        from scipy.stats import qmc

        count, size = _checked(cycles, dimensions)
        return np.asarray(qmc.Halton(size, scramble=True, rng=np.random.default_rng(seed)).random(count))


@dataclass(frozen=True)
class Sobol:
    """Sobol's sequence, scrambled (Owen 1998): of each 2^m cycles in a row one falls in each of 2^m equal sectors.

    >>> np.sort(np.floor(4 * Sobol().draws(4, 2, seed=3)), axis=0)[:, 1].tolist()
    [0.0, 1.0, 2.0, 3.0]
    """

    kind: ClassVar[str] = SEQUENCE
    sectors: ClassVar[int | None] = None

    def draws(self, cycles: int, dimensions: int, seed: int | np.random.SeedSequence) -> Array:
        """Return the points (cycles, dimensions)."""
        from scipy.stats import qmc

        count, size = _checked(cycles, dimensions)
        engine = qmc.Sobol(size, scramble=True, rng=np.random.default_rng(seed))
        return np.asarray(engine.random_base2(max(count - 1, 1).bit_length())[:count])


@dataclass(frozen=True)
class LatinBlocks:
    """Each block of `size` cycles visits every one of as many equal sectors once, in random order.

    jitter : whether a cycle draws its place within the sector; else it takes the middle, so that there are only
    `size` values. With several coordinates each has an order of its own (a Latin hypercube; McKay et al. 1979).

    >>> np.sort(LatinBlocks(4, jitter=False).draws(4, 1, seed=0)[:, 0]).tolist()
    [0.125, 0.375, 0.625, 0.875]
    """

    size: int = 12
    jitter: bool = True
    kind: ClassVar[str] = BLOCKS

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", whole_number("block size", self.size, least=1))
        if not isinstance(self.jitter, bool):
            raise InvalidInput(f"jitter must be True or False, not {self.jitter!r}")

    @property
    def sectors(self) -> int | None:
        """The number of values of a coordinate; None with jitter."""
        return None if self.jitter else self.size

    def draws(self, cycles: int, dimensions: int, seed: int | np.random.SeedSequence) -> Array:
        """Return the points (cycles, dimensions); the last block may be cut short."""
        count, width = _checked(cycles, dimensions)
        rng = np.random.default_rng(seed)
        blocks = -(-count // self.size)
        order = rng.permuted(np.tile(np.arange(float(self.size)), (blocks, width, 1)), axis=-1)
        place = rng.random(order.shape) if self.jitter else 0.5
        points = (order + place) / self.size
        return np.asarray(np.swapaxes(points, 1, 2).reshape(blocks * self.size, width)[:count])


def _checked(cycles: int, dimensions: int) -> tuple[int, int]:
    return whole_number("cycles", cycles, least=0), whole_number("dimensions", dimensions, least=1)
