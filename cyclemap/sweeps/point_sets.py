"""Which points a sweep visits: every combination of listed values, or a seeded sample of ranges."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import cast

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import whole_number
from cyclemap.errors import InvalidInput
from cyclemap.sweeps.swept_keys import SweepAxis, SweepRange, SweptKey, check_distinct

# Points of a sample that are drawn together, so that the whole of a long one is never in memory.
_BLOCK = 1024
_SEQUENCES = ("sobol", "uniform")
# SciPy draws Sobol points of 30 bits.
_MOST_SOBOL = 2**30


@dataclass(frozen=True)
class Grid:
    """Every combination of the values of the axes, the last axis running fastest.

    >>> grid = Grid((SweepAxis("mu_a", (0.2, 0.3)), SweepAxis("side", (0, 1))))
    >>> grid.shape, len(grid), grid.settings(2)
    ((2, 2), 4, {'mu_a': 0.3, 'side': 0.0})
    """

    axes: tuple[SweepAxis, ...]

    def __post_init__(self) -> None:
        check_distinct(axis.key for axis in self.axes)
        ranged = next((axis.key for axis in self.axes if not isinstance(axis, SweepAxis)), None)
        if ranged is not None:
            raise InvalidInput(
                f"{ranged} is a range without a count: write {ranged}=start:stop:count, or ask for a sample"
            )

    @property
    def keys(self) -> tuple[str, ...]:
        """The swept keys, in order."""
        return tuple(axis.key for axis in self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each axis has."""
        return tuple(len(axis.values) for axis in self.axes)

    def __len__(self) -> int:
        return math.prod(self.shape)

    def settings(self, number: int) -> dict[str, object]:
        """The swept settings of point `number`, counted from 0."""
        chosen: dict[str, object] = {}
        for axis in reversed(self.axes):
            number, place = divmod(number, len(axis.values))
            chosen[axis.key] = axis.values[place]
        return {key: chosen[key] for key in self.keys}

    def described(self) -> dict[str, object]:
        """The grid as JSON takes it."""
        return {"kind": "grid", "axes": {axis.key: list(axis.values) for axis in self.axes}}


@dataclass(frozen=True)
class Sample:
    """A number of points spread over ranges (and listed values), the same for the same seed.

    sequence : "sobol", scrambled (Owen 1998), whose points fill the box evenly at any count, best at powers of two;
    or "uniform", independent points. A longer sample begins with the shorter one.

    >>> sample = Sample((SweepRange("mu_a", 0.2, 0.3),), 4)
    >>> len(sample), all(0.2 <= sample.settings(k)["mu_a"] < 0.3 for k in range(4))
    (4, True)
    """

    ranges: tuple[SweptKey, ...]
    count: int
    seed: int = 0
    sequence: str = "sobol"

    def __post_init__(self) -> None:
        check_distinct(one.key for one in self.ranges)
        whole_number("sample", self.count, least=1)
        whole_number("seed", self.seed, least=0)
        if self.sequence not in _SEQUENCES:
            raise InvalidInput(f"sequence is {self.sequence!r}: it must be one of {', '.join(_SEQUENCES)}")
        if self.sequence == "sobol" and self.count > _MOST_SOBOL:
            raise InvalidInput(f"sample is {self.count}: a Sobol sequence has {_MOST_SOBOL} points; use uniform ones")

    @property
    def keys(self) -> tuple[str, ...]:
        """The swept keys, in order."""
        return tuple(one.key for one in self.ranges)

    def __len__(self) -> int:
        return self.count

    def settings(self, number: int) -> dict[str, object]:
        """The swept settings of point `number`, counted from 0."""
        shares = _block(self.sequence, self.seed, len(self.ranges), number // _BLOCK)[number % _BLOCK]
        return {one.key: one.at(float(share)) for one, share in zip(self.ranges, shares, strict=True)}

    def described(self) -> dict[str, object]:
        """The sample as JSON takes it."""
        ranges = {
            one.key: {"low": one.low, "high": one.high} if isinstance(one, SweepRange) else list(one.values)
            for one in self.ranges
        }
        return {
            "kind": "sample",
            "ranges": ranges,
            "count": self.count,
            "seed": self.seed,
            "sequence": self.sequence,
        }


PointSet = Grid | Sample


@lru_cache(maxsize=4)
def _block(sequence: str, seed: int, dimensions: int, block: int) -> NDArray[np.float64]:
    """Points (1024, dimensions) of the unit box, each in [0, 1)."""
    if sequence == "uniform":
        return np.random.default_rng([seed, block]).random((_BLOCK, dimensions))
    from scipy.stats import qmc

    engine = qmc.Sobol(dimensions, scramble=True, rng=np.random.default_rng(seed))
    if block:
        engine.fast_forward(block * _BLOCK)
    return cast(NDArray[np.float64], np.minimum(engine.random(_BLOCK), np.nextafter(1.0, 0.0)))
