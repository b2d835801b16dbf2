"""Every fact of an experiment that can be set, told once, in `settings.toml`: key, unit, usual
range, meaning, and where a loop has it.

From this table come --set, the files' tables and their checks, sweeps, the explorer's sliders, what
`cyclemap check` doubts, the comments that `cyclemap init` writes, and the table of the guide.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from typing import TYPE_CHECKING, Any

from cyclemap.checks import finite_array, finite_number, positive_number
from cyclemap.errors import InvalidInput, unknown_name
from cyclemap.plain_text import json_value, plain_number
from cyclemap.written import DEGREES, MILLIMETRES, NUMBER, FileUnit

if TYPE_CHECKING:
    from cyclemap.collection.loop import CollectionLoop

Settings = dict[str, object]

NOISE_KEY = "noise_deg"
WORD = "word"
POINTS = "points"
ALWAYS = "always"
OWN = "own"


@dataclass(frozen=True)
class Setting:
    """One fact of an experiment, by the key of `--set`, whose ending tells its unit.

    group : of sliders, and of a file's tables.
    place : the attribute of a loop, by dots, in SI units.
    kind : what its values are, a number, WORD or POINTS.
    default : words for MIT's, where it is no number of the loop.
    written : when a file says it: ALWAYS, of an object of one's OWN; else where it is changed.
    label, low, high, step : of its slider; the range is the usual one, in the key's unit, and holds
        nobody to it.
    """

    key: str
    group: str
    place: str
    meaning: str
    kind: str = ""
    default: str = ""
    written: str = ""
    label: str = ""
    low: float = -math.inf
    high: float = math.inf
    step: float = 0.0

    @property
    def unit(self) -> FileUnit:
        """The unit that the key's ending tells."""
        return {"deg": DEGREES, "mm": MILLIMETRES}.get(self.key.rpartition("_")[2], NUMBER)

    def of(self, loop: CollectionLoop) -> Any:
        """Return the value that a loop has, in SI units; None where it has none."""
        value: Any = loop
        for name in self.place.split("."):
            value = value[int(name)] if name.isdigit() else getattr(value, name, None)
        return value

    def parsed(self, text: str) -> object:
        """Return the value that people mean by a text; the text itself, for `checked` to refuse,
        where it is none.
        """
        if self.kind == WORD:
            return text
        try:
            return json_value(text) if self.kind == POINTS else plain_number(text)
        except ValueError:
            return text

    def checked(self, value: object) -> object:
        """Return a value that the key may have, numbers as float, points as tuples; InvalidInput
        otherwise.

        Whether the values of several keys go together only the loop can tell.
        """
        if self.kind == WORD:
            if not isinstance(value, str) or not value:
                raise InvalidInput(f"{self.key} must be a word, not {value!r}")
            return value
        if self.kind == POINTS:
            pairs = finite_array(self.key, value, last=2, ndim=2)  # type: ignore[arg-type]
            return tuple(map(tuple, pairs.tolist()))
        return (positive_number if self.key == NOISE_KEY else finite_number)(self.key, value)


_TEXT = (resources.files("cyclemap.protocol") / "settings.toml").read_text(encoding="utf-8")
SETTINGS = {key: Setting(key, **facts) for key, facts in tomllib.loads(_TEXT).items()}
SHARES = tuple(
    key
    for key, setting in SETTINGS.items()
    if setting.place.startswith("footprint.") and setting.group == "Pressure"
)
SHAPES = tuple(key for key, setting in SETTINGS.items() if setting.group == "Shape")


def setting_named(key: str) -> Setting:
    """Return the setting of a key; InvalidInput, with the nearest one, where there is none.

    >>> setting_named("push_mm").group
    'Push'
    """
    if key not in SETTINGS:
        raise unknown_name("setting", key, SETTINGS)
    return SETTINGS[key]


def without_noise(settings: Mapping[str, object]) -> tuple[Settings, float | None]:
    """Return the settings of a loop, and the noise of a cycle (standard deviation, rad) where they
    name one.

    >>> without_noise({"mu_a": 0.3, "noise_deg": 180})
    ({'mu_a': 0.3}, 3.141592653589793)
    """
    noise = settings.get(NOISE_KEY)
    sigma = None if noise is None else math.radians(positive_number(NOISE_KEY, noise))
    return {key: value for key, value in settings.items() if key != NOISE_KEY}, sigma
