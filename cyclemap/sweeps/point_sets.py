"""Which points a sweep visits: the keys it varies, every combination of their values, or a sample
of their ranges.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import cast

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import whole_number
from cyclemap.errors import InvalidInput, unknown_name
from cyclemap.mechanics import Slider, load_material
from cyclemap.plain_text import json_value, key_and_value, plain_number, plain_whole
from cyclemap.protocol.settings import POINTS, SETTINGS, WORD, Setting

MATERIAL_KEY = "material"
FOOTPRINT_KEY = "footprint"
SWEPT = {
    **SETTINGS,
    MATERIAL_KEY: Setting(MATERIAL_KEY, "Floor", "material", "a built-in material or a file", WORD),
}
# By the ending of a key.
KEY_UNITS = {"deg": "degree", "mm": "mm", "kg": "kg"}
_MOST_VALUES = 1_000_000


@dataclass(frozen=True)
class SweepAxis:
    """The values that a key takes, in their order: numbers, words, or lists of points.

    Parameters
    ----------
    key : str
        The setting's name.
    values : tuple of object
        In degrees and millimetres as the key's ending says; at least one, none twice.

    Raises
    ------
    InvalidInput
        For an unknown key, a value that the key cannot have, or one that is given twice.

    Examples
    --------
    >>> from cyclemap.sweeps import SweepAxis
    >>> SweepAxis("mu_a", (0.2, 0.3)).values
    (0.2, 0.3)
    """

    key: str
    values: tuple[object, ...]

    def __post_init__(self) -> None:
        check_key(self.key)
        values = tuple(checked_value(self.key, value) for value in self.values)
        if not values:
            raise InvalidInput(f"{self.key} has no values to sweep: give at least one")
        seen: set[str] = set()
        for written in map(json.dumps, values):
            if written in seen:
                raise InvalidInput(f"{self.key} takes {written} twice: give each value once")
            seen.add(written)
        object.__setattr__(self, "values", values)

    @property
    def is_number(self) -> bool:
        """Whether the values are numbers."""
        return isinstance(self.values[0], float)

    @property
    def positions(self) -> Array:
        """Where the values stand, (n,): the numbers themselves, else 0, 1, 2, ..."""
        return np.array(self.values if self.is_number else range(len(self.values)), dtype=float)

    def at(self, share: float) -> object:
        """Return the value at a share of the list, 0 <= share < 1: how a sample draws from it."""
        return self.values[int(share * len(self.values))]


@dataclass(frozen=True)
class SweepRange:
    """The range of a numeric key that a sample draws from.

    Parameters
    ----------
    key : str
        The setting's name.
    low : float
        Where the range begins, in the key's units.
    high : float
        Where it ends, above `low`.

    Raises
    ------
    InvalidInput
        For a key that has no range, a value that it cannot have, and an end that is not the
        larger.

    Examples
    --------
    >>> from cyclemap.sweeps import SweepRange
    >>> round(SweepRange("mu_a", 0.2, 0.4).at(0.5), 12)
    0.3
    """

    key: str
    low: float
    high: float

    def __post_init__(self) -> None:
        check_key(self.key)
        if SWEPT[self.key].kind:
            raise InvalidInput(f"{self.key} has no range: list its values, {self.key}=A,B")
        for name in ("low", "high"):
            object.__setattr__(self, name, checked_value(self.key, getattr(self, name)))
        if not self.low < self.high:
            raise InvalidInput(
                f"{self.key} runs from {self.low:g} to {self.high:g}: the end must be the larger"
            )

    def at(self, share: float) -> object:
        """Return the value at a share of the range, 0 <= share < 1."""
        return self.low + share * (self.high - self.low)


SweptKey = SweepAxis | SweepRange


def parse_over(text: str) -> SweptKey:
    """Return what `key=start:stop:count`, `key=start:stop` (a range) or `key=a,b,c` says.

    >>> parse_over("mu_a=0.2:0.3:3").values
    (0.2, 0.25, 0.3)
    >>> parse_over("material=plywood,abs").values
    ('plywood', 'abs')
    """
    key, values = key_and_value("--over", text, "key=start:stop:count or key=a,b,c")
    check_key(key)
    kind = SWEPT[key].kind
    parts = values.split(":")
    if kind == WORD:
        return SweepAxis(key, tuple(word.strip() for word in values.split(",")))
    if len(parts) == 1:
        try:
            listed = (
                json_value(f"[{values}]")
                if kind == POINTS
                else list(map(plain_number, values.split(",")))
            )
        except ValueError as cause:
            form = "[[x, y], ...],[[x, y], ...]" if kind == POINTS else "numbers, by commas"
            raise InvalidInput(f"--over {key}={values}: give {form}") from cause
        return SweepAxis(key, tuple(listed))  # type: ignore[arg-type]
    try:
        numbers = [plain_number(word) for word in parts[:2]]
        count = plain_whole(parts[2]) if len(parts) == 3 else 0
    except ValueError:
        numbers = []
    if len(numbers) != 2 or len(parts) > 3 or not all(map(math.isfinite, numbers)):
        raise InvalidInput(
            f"--over {text!r}: write {key}=start:stop:count with finite numbers and a whole count"
        )
    if len(parts) == 2:
        return SweepRange(key, numbers[0], numbers[1])
    if not 1 <= count <= _MOST_VALUES:
        raise InvalidInput(
            f"--over {text!r}: the count is {count}; give 1 to {_MOST_VALUES} values"
        )
    return SweepAxis(key, tuple(np.linspace(numbers[0], numbers[1], count).tolist()))


def key_unit(key: str) -> str:
    """The unit that a key's ending tells, "1" where it tells none."""
    return KEY_UNITS.get(key.rpartition("_")[2], "1")


def check_key(key: str) -> None:
    """Raise InvalidInput, with the nearest known one, for a key that cannot be swept."""
    if key not in SWEPT:
        raise unknown_name("key to sweep", key, SWEPT)


def checked_value(key: str, value: object) -> object:
    """Return a value that `key` may have (see `Setting.checked`), names of materials and shapes
    looked up.
    """
    checked = SWEPT[key].checked(value)
    if key == MATERIAL_KEY:
        load_material(str(checked))
    if key == "shape":
        Slider.mit(str(checked))
    return checked


def check_distinct(keys: Iterable[str]) -> None:
    """Raise InvalidInput where a key is swept twice, or nothing is."""
    names = list(keys)
    if not names:
        raise InvalidInput("nothing is swept: give at least one key with its values")
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InvalidInput(f"{twice} is swept twice: give all of its values at once")


# Points of a sample that are drawn together, so that the whole of a long one is never in memory.
_BLOCK = 1024
_SEQUENCES = ("sobol", "uniform")
# SciPy draws Sobol points of 30 bits.
_MOST_SOBOL = 2**30


@dataclass(frozen=True)
class Grid:
    """Every combination of the values of the axes, the last axis running fastest.

    Parameters
    ----------
    axes : tuple of SweepAxis
        One or more keys with their values.

    Raises
    ------
    InvalidInput
        For a key that is given twice, and for a range without a count.

    Examples
    --------
    >>> from cyclemap.sweeps import Grid, SweepAxis
    >>> grid = Grid((SweepAxis("mu_a", (0.2, 0.3)), SweepAxis("side", (0, 1))))
    >>> len(grid), grid.settings(2)
    (4, {'mu_a': 0.3, 'side': 0.0})
    """

    axes: tuple[SweepAxis, ...]

    def __post_init__(self) -> None:
        check_distinct(axis.key for axis in self.axes)
        ranged = next((axis.key for axis in self.axes if not isinstance(axis, SweepAxis)), None)
        if ranged is not None:
            raise InvalidInput(
                f"{ranged} is a range without a count: write {ranged}=start:stop:count, or ask "
                "for a sample"
            )

    @property
    def keys(self) -> tuple[str, ...]:
        """The swept keys, in order."""
        return tuple(axis.key for axis in self.axes)

    def __len__(self) -> int:
        return math.prod(len(axis.values) for axis in self.axes)

    def settings(self, index: int) -> dict[str, object]:
        """The swept settings of point `index`, counted from 0."""
        chosen: dict[str, object] = {}
        for axis in reversed(self.axes):
            index, place = divmod(index, len(axis.values))
            chosen[axis.key] = axis.values[place]
        return {key: chosen[key] for key in self.keys}

    def described(self) -> dict[str, object]:
        """The grid as JSON takes it."""
        return {"kind": "grid", "axes": {axis.key: list(axis.values) for axis in self.axes}}


@dataclass(frozen=True)
class Sample:
    """A number of points spread over ranges (and listed values), the same for the same seed.

    Parameters
    ----------
    ranges : tuple of SweepRange or SweepAxis
        Ranges, and keys with listed values.
    count : int
        How many points, from 1.
    seed : int, default 0
        Of the points, from 0.
    sequence : str, default 'sobol'
        "sobol", scrambled (Owen 1998), whose points fill the box evenly at any count, best at
        powers of two; or "uniform", independent points. A longer sample begins with the shorter
        one.

    Raises
    ------
    InvalidInput
        For a key that is given twice, a count or seed out of range, another sequence, and more
        points than a Sobol sequence has.

    References
    ----------
    Owen, A. B. (1998), Scrambling Sobol' and Niederreiter-Xing points, Journal of Complexity 14(4).

    Examples
    --------
    >>> from cyclemap.sweeps import Sample, SweepRange
    >>> sample = Sample((SweepRange("mu_a", 0.2, 0.3),), 4)
    >>> len(sample), all(0.2 <= sample.settings(k)["mu_a"] < 0.3 for k in range(4))
    (4, True)
    """

    ranges: tuple[SweptKey, ...]
    count: int
    seed: int = 0
    sequence: str = "sobol"

    def __post_init__(self) -> None:
        check_distinct(axis.key for axis in self.ranges)
        whole_number("sample", self.count, least=1)
        whole_number("seed", self.seed, least=0)
        if self.sequence not in _SEQUENCES:
            raise InvalidInput(
                f"sequence is {self.sequence!r}: it must be one of {', '.join(_SEQUENCES)}"
            )
        if self.sequence == "sobol" and self.count > _MOST_SOBOL:
            raise InvalidInput(
                f"sample is {self.count}: a Sobol sequence has {_MOST_SOBOL} points; use uniform "
                "ones"
            )

    @property
    def keys(self) -> tuple[str, ...]:
        """The swept keys, in order."""
        return tuple(axis.key for axis in self.ranges)

    def __len__(self) -> int:
        return self.count

    def settings(self, index: int) -> dict[str, object]:
        """The swept settings of point `index`, counted from 0."""
        shares = _block(self.sequence, self.seed, len(self.ranges), index // _BLOCK)[index % _BLOCK]
        return {
            axis.key: axis.at(float(share)) for axis, share in zip(self.ranges, shares, strict=True)
        }

    def described(self) -> dict[str, object]:
        """The sample as JSON takes it."""
        ranges = {
            axis.key: {"low": axis.low, "high": axis.high}
            if isinstance(axis, SweepRange)
            else list(axis.values)
            for axis in self.ranges
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
def _block(sequence: str, seed: int, dimensions: int, block: int) -> Array:
    """Points (1024, dimensions) of the unit box, each in [0, 1)."""
    if sequence == "uniform":
        return np.random.default_rng([seed, block]).random((_BLOCK, dimensions))
    from scipy.stats import qmc

    engine = qmc.Sobol(dimensions, scramble=True, rng=np.random.default_rng(seed))
    if block:
        engine.fast_forward(block * _BLOCK)
    return cast(Array, np.minimum(engine.random(_BLOCK), np.nextafter(1.0, 0.0)))
