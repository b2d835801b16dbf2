"""The sliders of the explorer: which settings they move, in which units and range, and what is made of their values."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, replace
from decimal import Decimal

from cyclemap.checks import finite_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.collection.setting_table import NOISE_KEY, SETTINGS, Settings, without_noise
from cyclemap.errors import InvalidInput
from cyclemap.file_text import DEGREES, MILLIMETRES, NUMBER, toml_text
from cyclemap.mechanics import PatchFootprint
from cyclemap.suggestions import unknown_name

CONTROLS = tuple(one for one in SETTINGS.values() if one.label)
_UNITS = {MILLIMETRES: "mm", DEGREES: "°", NUMBER: ""}


@dataclass(frozen=True, eq=False)
class Explored:
    """What the explorer was started with.

    words : of the command line that name the material. settings : of protocol file and --set. loop, sigma (rad) : what
    they come to; None: the noise of the material, where it has one.
    """

    words: tuple[str, ...]
    settings: Settings
    loop: CollectionLoop
    sigma: float | None = None

    def controls(self) -> list[dict[str, object]]:
        """The sliders that suit the object, each with where it stands; a range reaches as far as the value does."""
        outline, found = self.loop.slider.outline, self.values()
        shown = []
        for one in CONTROLS:
            value = found.get(one.key)
            if value is None or (one.key == "corner_share" and not hasattr(outline, "vertices")):
                continue
            high = max(float(outline.sides - 1) if one.key == "side" else one.high, value)
            if high > one.low:
                told = {name: getattr(one, name) for name in ("key", "label", "step", "group")}
                reach = {"unit": _UNITS[one.unit], "low": min(one.low, value), "high": high, "value": value}
                shown.append({**told, **reach})
        return shown

    def values(self) -> dict[str, float]:
        """Where every slider stands that the loop has a value for."""
        # A footprint that is left to the object is the uniform one, whose shares are nought.
        loop = replace(self.loop, footprint=self.loop.footprint or PatchFootprint(self.loop.slider.outline))
        sigma = DEFAULT_SIGMA if self.sigma is None else self.sigma
        found = {}
        for one in CONTROLS:
            value = sigma if one.key == NOISE_KEY else one.of(loop)
            if value is not None:
                told = value / float(one.unit.in_si)
                found[one.key] = float(f"{told % 180.0 if one.key == 'phi_deg' else told:.10g}")
        return found

    def moved(self, moved: Mapping[str, object]) -> Explored:
        """The same with sliders moved, by key.

        Raises InvalidInput for a key that is no slider's, a value that is no number, or a loop that cannot be.
        """
        known = tuple(one.key for one in CONTROLS)
        for key, value in moved.items():
            if key not in known:
                raise unknown_name("slider", key, known)
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise InvalidInput(f"{key} is {value!r}; a slider's value is a number")
        return _with_settings(self, {key: finite_number(key, value) for key, value in moved.items()})

    def command(self) -> str:
        """The command line that gives the same portrait."""
        told = [f"{key}={_text(value)}" for key, value in self.settings.items()]
        return shlex.join(["cyclemap", "portrait", *self.words, *(word for one in told for word in ("--set", one))])

    def protocol(self) -> str:
        """The text of a protocol file that, with the same material, gives the same loop."""
        settings: Settings = {
            key: Decimal(repr(value)) if isinstance(value, float) else value for key, value in self.settings.items()
        }
        comments = (f"cyclemap portrait {shlex.join(self.words)} --protocol FILE",)
        return toml_text({"explored": settings}, comments)


def explored(words: tuple[str, ...], material: str, settings: Settings) -> Explored:
    """What the explorer starts with: a material, and settings as on the command line."""
    return _with_settings(Explored(words, {}, CollectionLoop.mit(material=material)), settings)


def _with_settings(found: Explored, settings: Mapping[str, object]) -> Explored:
    mechanical, sigma = without_noise(settings)
    sigma = found.sigma if sigma is None else sigma
    loop = CollectionLoop.from_settings(mechanical, found.loop)
    return replace(found, settings={**found.settings, **settings}, loop=loop, sigma=sigma)


def _text(value: object) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value).replace("'", '"')
