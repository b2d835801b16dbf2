"""The keys that a sweep varies: the listed values of a key, or its range, and how both are written and checked."""

import json
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from cyclemap.collection.setting_table import POINTS, SETTINGS, WORD, Setting
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import Slider, load_material
from cyclemap.plain_text import json_value, plain_number, plain_whole
from cyclemap.suggestions import unknown_name

MATERIAL_KEY, FOOTPRINT_KEY = "material", "footprint"
SWEPT = {**SETTINGS, MATERIAL_KEY: Setting(MATERIAL_KEY, "Floor", "material", "a built-in material or a file", WORD)}
_MOST_VALUES = 1_000_000


@dataclass(frozen=True)
class SweepAxis:
    """The values that a key takes, in their order: numbers, words, or lists of points.

    Degrees and millimetres as the key's ending says. Raises InvalidInput for an unknown key, a value that the key
    cannot have, or one that is given twice.

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

    def at(self, share: float) -> object:
        """Return the value at a share of the list, 0 <= share < 1: how a sample draws from it."""
        return self.values[int(share * len(self.values))]


@dataclass(frozen=True)
class SweepRange:
    """The range of a numeric key that a sample draws from, in the key's units.

    >>> SweepRange("mu_a", 0.2, 0.4).at(0.5)
    0.30000000000000004
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
            raise InvalidInput(f"{self.key} runs from {self.low:g} to {self.high:g}: the end must be the larger")

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
    key, equals, values = (part.strip() for part in text.partition("="))
    if not (key and equals and values):
        raise InvalidInput(f"--over {text!r} is not of the form key=start:stop:count or key=a,b,c")
    check_key(key)
    if ":" in values and SWEPT[key].kind != WORD:
        return _stretch(key, text, values.split(":"))
    return SweepAxis(key, _listed(key, values))


def _stretch(key: str, text: str, parts: list[str]) -> SweptKey:
    try:
        numbers = [plain_number(part) for part in parts[:2]]
        count = plain_whole(parts[2]) if len(parts) == 3 else 0
    except ValueError:
        numbers = []
    if len(numbers) != 2 or len(parts) > 3 or not all(map(math.isfinite, numbers)):
        raise InvalidInput(f"--over {text!r}: write {key}=start:stop:count with finite numbers and a whole count")
    if len(parts) == 2:
        return SweepRange(key, numbers[0], numbers[1])
    if not 1 <= count <= _MOST_VALUES:
        raise InvalidInput(f"--over {text!r}: the count is {count}; give 1 to {_MOST_VALUES} values")
    return SweepAxis(key, tuple(np.linspace(numbers[0], numbers[1], count).tolist()))


def _listed(key: str, text: str) -> tuple[object, ...]:
    words, kind = tuple(part.strip() for part in text.split(",")), SWEPT[key].kind
    if kind == WORD:
        return words
    try:
        return tuple(json_value(f"[{text}]")) if kind == POINTS else tuple(map(plain_number, words))  # type: ignore[arg-type]
    except ValueError as cause:
        form = "[[x, y], ...],[[x, y], ...]" if kind == POINTS else "numbers, by commas"
        raise InvalidInput(f"--over {key}={text}: give {form}") from cause


def check_key(key: str) -> None:
    """Raise InvalidInput, with the nearest known one, for a key that cannot be swept."""
    if key not in SWEPT:
        raise unknown_name("key to sweep", key, SWEPT)


def checked_value(key: str, value: object) -> object:
    """Return a value that `key` may have (see `Setting.checked`), names of materials and shapes looked up."""
    found = SWEPT[key].checked(value)
    if key == MATERIAL_KEY:
        load_material(str(found))
    if key == "shape":
        Slider.mit(str(found))
    return found


def check_distinct(keys: Iterable[str]) -> None:
    """Raise InvalidInput where a key is swept twice, or nothing is."""
    names = list(keys)
    if not names:
        raise InvalidInput("nothing is swept: give at least one key with its values")
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InvalidInput(f"{twice} is swept twice: give all of its values at once")
