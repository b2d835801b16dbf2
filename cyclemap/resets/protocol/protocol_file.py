"""A data collection as a TOML protocol file: the settings of its loop, its strategy, and what was predicted of it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from decimal import Decimal
from pathlib import Path

from cyclemap.checks import positive_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.settings import SETTING_KEYS
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.maps import WrappedNormal
from cyclemap.resets.protocol.located import located
from cyclemap.resets.protocol.loop_settings import loop_tables, plain_numbers
from cyclemap.resets.protocol.strategy_table import strategy_from_table, strategy_table
from cyclemap.resets.protocol.toml_text import toml_text
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.suggestions import unknown_name
from cyclemap.text_files import read_toml
from cyclemap.whole_files import write_whole

NOISE_KEY = "noise_deg"
STRATEGY, PREDICTED = "strategy", "predicted"
Settings = dict[str, object]
Prediction = Mapping[str, object]

_COMMENTS = (
    "Protocol of a data collection: how the robot pushes the object and drags it back, cycle after cycle.",
    "Lengths in mm; angles in degrees, counter-clockwise; way-points and directions from the target.",
    "In Python: cyclemap.read_protocol(FILE). Commands take it as: cyclemap portrait MATERIAL --protocol FILE",
)


def write_protocol(
    path: str | Path,
    loop: CollectionLoop,
    strategy: ResetStrategy | None,
    *,
    noise: WrappedNormal | float | None = None,
    predicted: Prediction | None = None,
) -> None:
    """Write the protocol of a collection with `strategy` on `loop` as TOML; whole, or not at all.

    The file holds the robot's side of the loop as --set keys (see `loop_tables`; the surface is named in a comment
    only), and the strategy in a table [strategy], from which `read_protocol` makes the equal one. None: no strategy.
    noise : of one cycle: a `WrappedNormal`, or its standard deviation in rad. predicted : scores by name (numbers,
    texts, booleans, lists of them; None is left out), a table that readers pass over.

    Raises InvalidInput for a strategy of the user's own or a loop that settings cannot say, OSError where the file
    cannot be written.

    >>> import tempfile
    >>> from cyclemap.resets.strategies.drag_strategies import TrailingLeg
    >>> with tempfile.TemporaryDirectory() as place:
    ...     write_protocol(f"{place}/leg.toml", CollectionLoop.mit(), TrailingLeg(0.05), predicted={"tv": 0.04})
    ...     settings, strategy = read_protocol(f"{place}/leg.toml")
    >>> strategy == TrailingLeg(0.05), settings["push_mm"]
    (True, 150)
    """
    write_whole(Path(path), protocol_text(loop, strategy, noise=noise, predicted=predicted).encode())


def protocol_text(
    loop: CollectionLoop,
    strategy: ResetStrategy | None,
    *,
    noise: WrappedNormal | float | None = None,
    predicted: Prediction | None = None,
) -> str:
    """Return the text that `write_protocol` writes."""
    tables = loop_tables(loop)
    if noise is not None:
        sigma = noise.sigma if isinstance(noise, WrappedNormal) else noise
        tables["noise"] = {NOISE_KEY: math.degrees(positive_number("noise", sigma))}
    if strategy is not None:
        tables[STRATEGY] = strategy_table(strategy)
    if predicted is not None:
        _check_prediction(predicted)
        tables[PREDICTED] = {key: value for key, value in predicted.items() if value is not None}
    return toml_text(tables, _comments(loop, strategy))


def _comments(loop: CollectionLoop, strategy: ResetStrategy | None) -> tuple[str, ...]:
    x, y = (1e3 * part for part in loop.slider.hitch)
    told = [*_COMMENTS, f"Written for {loop.material.name}, with the ring at ({x:.4f}, {y:.4f}) mm of the object."]
    if strategy is not None:
        needs = f"; needs: {', '.join(strategy.needs)}" if strategy.needs else ""
        told.append(f"Strategy: {strategy.name}{needs}")
    return tuple(told)


def read_protocol(path: str | Path) -> tuple[Settings, ResetStrategy | None]:
    """Return the settings of a protocol file, in its units (for `CollectionLoop.from_settings`), and its strategy.

    Settings are the --set keys, grouped in tables of any name but [strategy] and [predicted]; `noise_deg` is among
    them where the file names one. Without a table [strategy] the strategy is None.

    Raises DataFileError, naming file, key and value, where the file cannot be read, nests deeper, gives a key twice, or
    holds what is no setting or no strategy.
    """
    # Decimals, so that no number is rounded before its unit is known.
    tables = read_toml(path, Decimal)
    settings: Settings = {}
    for key, value in _entries(tables):
        if key in settings:
            raise DataFileError(f"{path}: {key} is given twice; keep one")
        if isinstance(value, bool) or not isinstance(value, (int, Decimal, str, list)):
            raise DataFileError(
                f"{path}: {key} is {_plain_tables(value)!r}; it must be a number, text or list of points"
            )
        settings[key] = plain_numbers(value)
    with located(str(path), DataFileError):
        for key in settings:
            if key not in (*SETTING_KEYS, NOISE_KEY):
                raise unknown_name("setting", key, (*SETTING_KEYS, NOISE_KEY))
        _check_prediction(tables.get(PREDICTED, {}))
        strategy = strategy_from_table(tables[STRATEGY]) if STRATEGY in tables else None
    return settings, strategy


def _entries(tables: Mapping[str, object]) -> Iterator[tuple[str, object]]:
    for name, table in tables.items():
        if name not in (STRATEGY, PREDICTED):
            yield from table.items() if isinstance(table, dict) else [(name, table)]


def _plain_tables(value: object) -> object:
    """Return a value of a file as people wrote it."""
    if isinstance(value, dict):
        return {key: _plain_tables(part) for key, part in value.items()}
    return plain_numbers(value)


def _check_prediction(table: object) -> None:
    if not isinstance(table, Mapping):
        raise InvalidInput(f"{PREDICTED} must be a table of scores, not {table!r}")
    for key, value in table.items():
        if not isinstance(key, str):
            raise InvalidInput(f"[{PREDICTED}] names its scores by texts, not {key!r}")
        parts = value if isinstance(value, list) else [value]
        if value is not None and not all(isinstance(part, (bool, int, float, Decimal, str)) for part in parts):
            raise InvalidInput(f"[{PREDICTED}] {key} must be a number, text or list of them, not {value!r}")
