"""From the options of a command to the loop it is about, and the strategy of its cycles.

What is said later wins: MIT's defaults, then the material, then the protocol file, then each --set in order.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cyclemap.checks import positive_number
from cyclemap.cli.options import LoopOptions
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.settings import SETTING_KEYS
from cyclemap.errors import InvalidInput
from cyclemap.plain_text import json_value, plain_number
from cyclemap.suggestions import unknown_name

if TYPE_CHECKING:
    from cyclemap.resets import ResetStrategy

NOISE_KEY = "noise_deg"


@dataclass(frozen=True)
class ChosenCollection:
    """What the options ask for.

    loop : as the settings have it, what the strategy sets up left out. sigma : the noise of a cycle (rad), None where
    none is named. strategy : of the protocol file; None where it has none.
    """

    loop: CollectionLoop
    sigma: float | None
    strategy: ResetStrategy | None

    def simplified(self) -> ChosenCollection:
        """The same, a strategy that does the same in every cycle made part of the loop."""
        if self.strategy is None:
            return self
        from cyclemap.resets.design.strategy import one_loop

        fixed = one_loop(self.loop, self.strategy)
        return self if fixed is None else ChosenCollection(fixed, self.sigma, None)


def chosen_loop(options: LoopOptions) -> tuple[CollectionLoop, float | None]:
    """The loop that `options` ask for, and the noise of a cycle (rad) where they name one.

    A strategy that does the same in every cycle is part of the loop; InvalidInput for any other.
    """
    chosen = chosen_collection(options).simplified()
    if chosen.strategy is not None:
        why = "turns the object by a gripper" if len(chosen.strategy.actions) == 1 else "differs from cycle to cycle"
        raise InvalidInput(
            f"{options.protocol}: its strategy {why}, and this command is about one loop: give the protocol to "
            "cyclemap cycle, portrait, staircase or simulate, or take [strategy] out of it"
        )
    return chosen.loop, chosen.sigma


def chosen_collection(options: LoopOptions) -> ChosenCollection:
    """The loop, noise and strategy that `options` ask for; InvalidInput for a --set that the strategy overrules."""
    settings, strategy = protocol_of(options)
    own = set_settings(options.settings)
    settings.update(own)
    for key in settings:
        if key not in (*SETTING_KEYS, NOISE_KEY):
            raise unknown_name("setting", key, (*SETTING_KEYS, NOISE_KEY))
    noise_deg = settings.pop(NOISE_KEY, None)
    sigma = None if noise_deg is None else math.radians(positive_number(NOISE_KEY, noise_deg))
    base = CollectionLoop.mit(material=options.material or "isotropic")
    loop = CollectionLoop.from_settings(settings, base)
    if strategy is not None:
        _refuse_overruled(strategy, own)
    return ChosenCollection(loop, sigma, strategy)


def protocol_of(options: LoopOptions) -> tuple[dict[str, object], ResetStrategy | None]:
    """The settings and the strategy of the protocol file; none where `options` name no file."""
    if options.protocol is None:
        return {}, None
    # Strategies take a while to load, and only a protocol can name one.
    from cyclemap.resets.protocol.protocol_file import read_protocol

    return read_protocol(options.protocol)


def _refuse_overruled(strategy: ResetStrategy, own: Iterable[str]) -> None:
    from cyclemap.resets.design.strategy import overruled_settings

    lost = [key for key in own if key in overruled_settings(strategy)]
    if lost:
        raise InvalidInput(
            f"--set {lost[0]}: the protocol's strategy sets that in every cycle; change it in its table [strategy]"
        )


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


def _value(text: str) -> object:
    for read in (plain_number, json_value):
        try:
            return read(text)
        except ValueError:
            continue
    return text
