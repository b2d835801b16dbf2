"""The sliders of the explorer: which settings they move, in which units and range, and what is made of their values."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, replace
from decimal import Decimal

from cyclemap.checks import finite_number, positive_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import InvalidInput
from cyclemap.file_text import toml_text
from cyclemap.mechanics import PatchFootprint
from cyclemap.suggestions import unknown_name

Settings = dict[str, object]

NOISE_KEY = "noise_deg"


@dataclass(frozen=True)
class Control:
    """A slider: the key of `--set` that it moves, its words, unit and range."""

    key: str
    label: str
    unit: str
    low: float
    high: float
    step: float
    group: str


CONTROLS = (
    Control("hitch_x_mm", "ring x", "mm", -60.0, 60.0, 0.1, "Ring"),
    Control("hitch_y_mm", "ring y", "mm", -60.0, 60.0, 0.1, "Ring"),
    Control("mu_a", "friction μa", "", 0.05, 0.6, 0.001, "Floor"),
    Control("mu_b", "friction μb", "", 0.05, 0.6, 0.001, "Floor"),
    Control("phi_deg", "axis φ", "°", 0.0, 180.0, 0.5, "Floor"),
    Control("m0", "offset m0", "", -0.1, 0.1, 0.0005, "Floor"),
    Control("n0", "offset n0", "", -0.1, 0.1, 0.0005, "Floor"),
    Control("inner_share", "load inside", "", 0.0, 1.0, 0.01, "Pressure"),
    Control("rim_share", "load on the rim", "", 0.0, 1.0, 0.01, "Pressure"),
    Control("corner_share", "load on corners", "", 0.0, 1.0, 0.01, "Pressure"),
    Control("side", "side", "", 0.0, 0.0, 1.0, "Push"),
    Control("fraction", "place on the side", "", 0.02, 0.98, 0.005, "Push"),
    Control("angle_deg", "slant", "°", -60.0, 60.0, 0.5, "Push"),
    Control("push_mm", "length", "mm", 10.0, 300.0, 1.0, "Push"),
    Control("pusher_radius_mm", "rod radius", "mm", 0.0, 20.0, 0.05, "Rod"),
    Control("pusher_mu", "rod friction", "", 0.0, 0.8, 0.005, "Rod"),
    Control("noise_deg", "noise of a cycle", "°", 0.3, 15.0, 0.1, "Noise"),
)


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
                shown.append({**vars(one), "low": min(one.low, value), "high": high, "value": value})
        return shown

    def values(self) -> dict[str, float]:
        """Where every slider stands that the loop has a value for."""
        loop, law = self.loop, self.loop.material.friction
        patch = PatchFootprint(loop.slider.outline) if loop.footprint is None else loop.footprint
        found = {
            "hitch_x_mm": 1e3 * loop.slider.hitch[0],
            "hitch_y_mm": 1e3 * loop.slider.hitch[1],
            "mu_a": law.mu_a,
            "mu_b": law.mu_b,
            "phi_deg": math.degrees(law.phi) % 180.0,
            "m0": law.m0,
            "n0": law.n0,
            "side": float(loop.push.side),
            "fraction": loop.push.fraction,
            "angle_deg": math.degrees(loop.push.angle),
            "push_mm": 1e3 * loop.push.distance,
            "pusher_radius_mm": 1e3 * loop.pusher.radius,
            "pusher_mu": loop.pusher.friction,
            "noise_deg": math.degrees(DEFAULT_SIGMA if self.sigma is None else self.sigma),
        }
        if isinstance(patch, PatchFootprint):
            found |= {key: getattr(patch, key) for key in ("inner_share", "rim_share", "corner_share")}
        return {key: float(f"{value:.10g}") for key, value in found.items()}

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
    mechanical = {key: value for key, value in settings.items() if key != NOISE_KEY}
    noise = settings.get(NOISE_KEY)
    sigma = found.sigma if noise is None else math.radians(positive_number(NOISE_KEY, noise))
    loop = CollectionLoop.from_settings(mechanical, found.loop)
    return replace(found, settings={**found.settings, **settings}, loop=loop, sigma=sigma)


def _text(value: object) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value).replace("'", '"')
