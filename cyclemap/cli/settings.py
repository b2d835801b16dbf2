"""From the options of a command to the loop it is about.

What is said later wins: MIT's defaults, then the material, then the protocol file, then each --set in order.
"""

import json
import math
from collections.abc import Iterable
from pathlib import Path

from cyclemap.checks import positive_number
from cyclemap.cli.options import LoopOptions
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.settings import SETTING_KEYS
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.suggestions import unknown_name
from cyclemap.text_files import read_toml

NOISE_KEY = "noise_deg"


def chosen_loop(options: LoopOptions) -> tuple[CollectionLoop, float | None]:
    """The loop that `options` ask for, and the noise of a cycle (rad) where they name one."""
    settings = protocol_settings(options.protocol) if options.protocol else {}
    settings.update(set_settings(options.settings))
    for key in settings:
        if key not in (*SETTING_KEYS, NOISE_KEY):
            raise unknown_name("setting", key, (*SETTING_KEYS, NOISE_KEY))
    noise_deg = settings.pop(NOISE_KEY, None)
    sigma = None if noise_deg is None else math.radians(positive_number(NOISE_KEY, noise_deg))
    base = CollectionLoop.mit(material=options.material or "isotropic")
    return CollectionLoop.from_settings(settings, base), sigma


def set_settings(pairs: Iterable[str]) -> dict[str, object]:
    """The settings of `key=value` texts; a value that reads as a number or a list is one.

    >>> set_settings(["mu_a=.25", "footprint=grid:8", "way_points_mm=[[0, 50]]"])
    {'mu_a': 0.25, 'footprint': 'grid:8', 'way_points_mm': [[0, 50]]}
    """
    settings: dict[str, object] = {}
    for pair in pairs:
        key, equals, value = (part.strip() for part in pair.partition("="))
        if not (key and equals and value):
            raise InvalidInput(f"--set {pair!r} is not of the form key=value")
        settings[key] = _value(value)
    return settings


def protocol_settings(path: Path) -> dict[str, object]:
    """The settings of a TOML protocol file: the --set keys, grouped in tables of any name.

    DataFileError where the file cannot be read, nests deeper, or gives a key twice.
    """
    settings: dict[str, object] = {}
    for key, value in _entries(path, read_toml(path)):
        if key in settings:
            raise DataFileError(f"{path}: {key} is given twice; keep one")
        if isinstance(value, bool) or not isinstance(value, (int, float, str, list)):
            raise DataFileError(f"{path}: {key} is {value!r}; it must be a number, text or list of points")
        settings[key] = value
    return settings


def _entries(path: Path, table: dict[str, object]) -> Iterable[tuple[str, object]]:
    for name, value in table.items():
        yield from value.items() if isinstance(value, dict) else [(name, value)]


def _value(text: str) -> object:
    for read in (float, json.loads):
        try:
            return read(text)
        except ValueError:
            continue
    return text
