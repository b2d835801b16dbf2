"""From the options of a command to the loop it is about, and the strategy of its cycles.

What is said later wins: MIT's defaults, the folder of the data, the material (a file may tell of
object, push and reset, too), the protocol file, then each --set in order.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import InvalidInput
from cyclemap.protocol.collection_file import data_settings, names_surface, read_settings
from cyclemap.protocol.protocol_file import read_protocol
from cyclemap.protocol.setting_table import SETTINGS, Settings, setting_named, without_noise
from cyclemap.protocol.settings import layered, loop_from_settings, warn_of_defaults
from cyclemap.protocol.strategy import ResetStrategy, one_loop, overruled_settings


@dataclass(frozen=True)
class LoopOptions:
    """Which loop a command is about; material: None where none was named, which stands for
    isotropic friction.
    """

    material: str | None
    protocol: Path | None
    settings: tuple[str, ...]


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


def chosen_loop(options: LoopOptions, data: Path | None = None) -> ChosenCollection:
    """The one loop that `options` ask for, and its noise; data: see `chosen_collection`.

    A strategy that does the same in every cycle is part of the loop; InvalidInput for any other.
    """
    chosen = chosen_collection(options, data).simplified()
    if chosen.strategy is not None:
        why = (
            "turns the object by a gripper"
            if len(chosen.strategy.actions) == 1
            else "differs from cycle to cycle"
        )
        raise InvalidInput(
            f"{options.protocol}: its strategy {why}, and this command is about one loop: give the "
            "protocol to cyclemap cycle, portrait, staircase or simulate, or take [strategy] out "
            "of it"
        )
    return chosen


def loop_beside(data: Path) -> CollectionLoop | None:
    """The loop that a collection file in the folder of data tells, on isotropic friction; None
    without one.
    """
    settings = data_settings(data)
    return loop_from_settings(settings, CollectionLoop.mit("isotropic")) if settings else None


def chosen_collection(options: LoopOptions, data: Path | None = None) -> ChosenCollection:
    """The loop, noise and strategy that `options` ask for; InvalidInput for a --set that the
    strategy overrules.

    data : measured; what their folder says of object, push and reset holds where `options` do not
        say otherwise.
    """
    material, said, strategy = told_settings(options, data)
    own = set_settings(options.settings)
    for key in said:
        setting_named(key)
    settings, sigma = without_noise(said)
    base = CollectionLoop.mit(material=material or "isotropic")
    warn_of_defaults(settings)
    loop = loop_from_settings(settings, base)
    if strategy is not None:
        lost = [key for key in own if key in overruled_settings(strategy)]
        if lost:
            raise InvalidInput(
                f"--set {lost[0]}: the protocol's strategy sets that in every cycle; change it "
                "in its table [strategy]"
            )
    return ChosenCollection(loop, sigma, strategy, said)


def told_settings(
    options: LoopOptions, data: Path | None = None
) -> tuple[str | Path | None, dict[str, object], ResetStrategy | None]:
    """The material where one is named, the settings that are said anywhere, and the strategy.

    Of a file that is a material and a collection in one, both count; a surface in the protocol file
    only where no material is named.
    """
    layers = [] if data is None else [data_settings(data)]
    if options.material is not None and options.material.endswith(".toml"):
        layers.append(read_settings(options.material))
    given, strategy = protocol_of(options)
    material: str | Path | None = options.material
    if material is None and options.protocol is not None and names_surface(options.protocol):
        material = options.protocol
    return material, layered(*layers, given, set_settings(options.settings)), strategy


def protocol_of(options: LoopOptions) -> tuple[dict[str, object], ResetStrategy | None]:
    """The settings and the strategy of the protocol file, else of the material's; none where there
    is no file.
    """
    is_file = options.material is not None and options.material.endswith(".toml")
    path = options.protocol or (Path(str(options.material)) if is_file else None)
    if path is None:
        return {}, None
    settings, strategy = read_protocol(path)
    return (settings if path == options.protocol else {}), strategy


def set_settings(pairs: Iterable[str]) -> dict[str, object]:
    """The settings of `key=value` texts; a value that reads as a number or a list is one.

    >>> set_settings(["mu_a=.25", "footprint=grid:8", "way_points_mm=[[0, 50]]"])
    {'mu_a': 0.25, 'footprint': 'grid:8', 'way_points_mm': [[0, 50]]}
    """
    settings: dict[str, object] = {}
    for pair in pairs:
        key, equals, value = (word.strip() for word in pair.partition("="))
        if not (key and equals and value):
            raise InvalidInput(f"--set {pair!r} is not of the form key=value")
        settings[key] = SETTINGS[key].parsed(value) if key in SETTINGS else value
    return settings
