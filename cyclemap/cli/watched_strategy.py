"""The strategy that a watched collection follows, from its protocol file."""

from __future__ import annotations

from pathlib import Path

from cyclemap.cli.options import LoopOptions
from cyclemap.cli.output import progress_bar
from cyclemap.cli.settings import chosen_collection
from cyclemap.errors import InvalidInput
from cyclemap.resets.strategies.strategy_maps import StrategyMaps, strategy_maps

# Radians: a twentieth of a degree, far below what recorded directions are told apart by.
_TOLERANCE = 1e-3
# Actions of a full turn: a direction every 15 degrees.
_NODES = 24


def strategy_to_follow(protocol: Path | None, material: str | None) -> StrategyMaps | None:
    """The maps of the protocol's strategy on the material; None where neither is given.

    InvalidInput where the protocol leaves nothing to choose, or a material is given alone.
    """
    if protocol is None:
        if material is not None:
            raise InvalidInput(f"--material {material} is for --protocol: give the protocol, too, or leave both out")
        return None
    chosen = chosen_collection(LoopOptions(material, protocol, ()))
    if chosen.strategy is None or len(chosen.strategy.law(_NODES).actions) == 1:
        raise InvalidInput(
            f"{protocol}: there is no action to choose: it needs a [strategy] whose cycles differ, such as drawn-pushes"
        )
    with progress_bar(f"maps of {chosen.strategy.name} on {chosen.loop.material.name}") as report:
        return strategy_maps(chosen.loop, chosen.strategy, nodes=_NODES, tolerance=_TOLERANCE, progress=report)
