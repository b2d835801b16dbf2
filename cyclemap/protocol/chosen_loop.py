"""From the options of a command to the loop it is about, and the strategy of its cycles.

What is said later wins: MIT's defaults, the folder of the data, the material (a file may tell of
object, push and reset, too), the protocol file, then each --set in order.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import DoubtfulInput, InvalidInput
from cyclemap.mechanics import Material
from cyclemap.plain_text import key_and_value
from cyclemap.protocol.collection_file import data_settings, names_surface
from cyclemap.protocol.protocol_file import read_protocol
from cyclemap.protocol.settings import (
    SETTINGS,
    Settings,
    layered,
    loop_from_settings,
    setting_named,
    warn_of_defaults,
    without_noise,
)
from cyclemap.protocol.strategy import ResetStrategy, one_loop, overruled_settings


@dataclass(frozen=True)
class ChosenCollection:
    """What the options ask for.

    loop : as the settings have it, what the strategy sets up left out.
    sigma : the noise of a cycle (rad), None where none is named.
    strategy : of the protocol file; None where it has none.
    settings : all that were said anywhere, by their keys.
    """

    loop: CollectionLoop
    sigma: float | None
    strategy: ResetStrategy | None
    settings: Settings

    @property
    def noise(self) -> float:
        """The noise of a cycle (rad) that is named, else that of measured plywood."""
        return DEFAULT_SIGMA if self.sigma is None else self.sigma

    def simplified(self) -> ChosenCollection:
        """The same, a strategy that does the same in every cycle made part of the loop."""
        if self.strategy is None:
            return self
        fixed = one_loop(self.loop, self.strategy)
        return self if fixed is None else replace(self, loop=fixed, strategy=None)


def chosen_loop(
    material: str | None,
    protocol: Path | None = None,
    settings: Sequence[str] = (),
    data: Path | None = None,
) -> ChosenCollection:
    """The one loop that is asked for, and its noise; see `chosen_collection`.

    A strategy that does the same in every cycle is part of the loop; InvalidInput for any other.
    """
    chosen = chosen_collection(material, protocol, settings, data).simplified()
    if chosen.strategy is not None:
        why = (
            "turns the object by a gripper"
            if len(chosen.strategy.actions) == 1
            else "differs from cycle to cycle"
        )
        raise InvalidInput(
            f"{strategy_file(material, protocol)}: its strategy {why}, and this command is about "
            "one loop: give the file to cyclemap cycle, portrait, staircase or simulate, or take "
            "[strategy] out of it"
        )
    return chosen


def loop_beside(data: Path) -> CollectionLoop | None:
    """The loop that a collection file in the folder of data tells, on isotropic friction; None
    without one.
    """
    settings = data_settings(data)
    return loop_from_settings(settings, CollectionLoop.mit("isotropic")) if settings else None


def chosen_collection(
    material: str | None,
    protocol: Path | None = None,
    settings: Sequence[str] = (),
    data: Path | None = None,
) -> ChosenCollection:
    """The loop, noise and strategy that are asked for; InvalidInput for a --set that the strategy
    overrules.

    material : a name or a file; None stands for isotropic friction.
    settings : `key=value` texts.
    data : measured; what their folder says of object, push and reset holds where nothing else
        says otherwise.
    """
    surface, said, strategy = said_settings(material, protocol, settings, data)
    for key in said:
        setting_named(key)
    of_loop, sigma = without_noise(said)
    warn_of_defaults(of_loop)
    stated = CollectionLoop.mit(material=surface or "isotropic")
    loop = loop_from_settings(of_loop, stated)
    _warn_of_what_no_longer_holds(stated.material, loop.material)
    overruled = () if strategy is None else overruled_settings(strategy)
    lost = [key for key in set_settings(settings) if key in overruled]
    if lost:
        raise InvalidInput(
            f"--set {lost[0]}: the strategy of {strategy_file(material, protocol)} sets that in "
            "every cycle; change it in its table [strategy]"
        )
    return ChosenCollection(loop, sigma, strategy, said)


def _warn_of_what_no_longer_holds(stated: Material, used: Material) -> None:
    """Warn (`DoubtfulInput`) of what was found with a friction that is set to another."""
    lost = {
        "its wear": stated.wear is not None and used.wear is None,
        "the samples of what is believed of it": (
            stated.posterior is not None and used.posterior is None
        ),
    }
    named = [words for words, is_lost in lost.items() if is_lost]
    if named:
        doubt = (
            f"the friction of {stated.name} is set to another: what was found with its own is left "
            f"out, {' and '.join(named)}"
        )
        warnings.warn(doubt, DoubtfulInput, stacklevel=3)


def said_settings(
    material: str | None,
    protocol: Path | None,
    settings: Sequence[str],
    data: Path | None = None,
) -> tuple[str | Path | None, Settings, ResetStrategy | None]:
    """The material where one is named, the settings that are said anywhere, and the strategy: that
    of the protocol file, else of the material's.

    Of a file that is a material and a collection in one, both count; a surface in the protocol file
    only where no material is named.
    """
    layers = [] if data is None else [data_settings(data)]
    strategy = None
    surface: str | Path | None = material
    if material is not None and material.endswith(".toml"):
        of_file, strategy = read_protocol(material)
        layers.append(of_file)
    if protocol is not None:
        of_protocol, own = read_protocol(protocol)
        strategy = own or strategy
        layers.append(of_protocol)
        if material is None and names_surface(protocol):
            surface = protocol
    return surface, layered(*layers, set_settings(settings)), strategy


def strategy_file(material: str | None, protocol: Path | None) -> str | Path | None:
    """The file whose strategy `said_settings` returns: the protocol where it has one."""
    if protocol is not None and read_protocol(protocol)[1] is not None:
        return protocol
    return material


def set_settings(pairs: Iterable[str]) -> dict[str, object]:
    """The settings of `key=value` texts; a value that reads as a number or a list is one.

    >>> set_settings(["mu_a=.25", "footprint=grid:8", "way_points_mm=[[0, 50]]"])
    {'mu_a': 0.25, 'footprint': 'grid:8', 'way_points_mm': [[0, 50]]}
    """
    settings: dict[str, object] = {}
    for pair in pairs:
        key, value = key_and_value("--set", pair)
        settings[key] = SETTINGS[key].parsed(value) if key in SETTINGS else value
    return settings
