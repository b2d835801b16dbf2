"""A material as the text of a file that `load_material` reads back."""

from __future__ import annotations

import json
import math
import re
from dataclasses import fields

from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.mechanics.material import FoundWith, Material

# Fields of `FoundWith` that go by another name in a file, with the factor from SI units to it.
_FOUND_NAMES = {
    "pusher_friction": ("pusher_mu", 1.0),
    "pin_friction_radius": ("pin_friction_mm", 1e3),
}


def material_toml(material: Material) -> str:
    """Return a material as TOML; `load_material` gives it back, angles and lengths to rounding.

    >>> print(material_toml(Material("slate", EllipseFriction(0.3, 0.2), inferred=True)))
    name = "slate"
    inferred = true
    <BLANKLINE>
    [friction]
    mu_a = 0.3
    mu_b = 0.2
    m0 = 0.0
    n0 = 0.0
    phi_deg = 0.0
    <BLANKLINE>
    """
    words = {key: getattr(material, key) for key in ("name", "provenance", "misfit")}
    lines = [f"{key} = {_text(value)}" for key, value in words.items() if value]
    lines += ["inferred = true"] if material.inferred else []
    lines += _table("friction", _friction(material.friction))
    if material.wear is not None:
        lines += _table("worn", {"cycles": material.wear.cycles, **_friction(material.wear.friction)})
        lines += [f"course = {[list(pair) for pair in material.wear.course]!r}"] if material.wear.course else []
    found = _found_with(material.found_with)
    lines += _table("found_with", found) if found else []
    for one in material.plates:
        lines += _table(f"plates.{_key(one.plate)}", {key: value for key, value in one.shares.items() if value})
    for shift in material.frames:
        lines += _table(f"frames.{_key(shift.plate)}", {"shift_x_mm": 1e3 * shift.x, "shift_y_mm": 1e3 * shift.y})
    if material.noise is not None:
        lines += ["", "[cycle_noise]", f"log_sigma = {list(material.noise.log_sigma)!r}"]
        lines += [f"correlation = {material.noise.correlation!r}"]
    if material.posterior is not None:
        names = ", ".join(_text(name) for name in material.posterior.parameters)
        rows = [f"    [{', '.join(map(repr, row))}]," for row in material.posterior.samples]
        lines += ["", "[posterior]", f"parameters = [{names}]", "samples = [", *rows, "]"]
    return "\n".join(lines) + "\n"


def _friction(law: EllipseFriction) -> dict[str, float]:
    return {"mu_a": law.mu_a, "mu_b": law.mu_b, "m0": law.m0, "n0": law.n0, "phi_deg": math.degrees(law.phi)}


def _found_with(found: FoundWith) -> dict[str, float]:
    told = {}
    for field in fields(found):
        value = getattr(found, field.name)
        if value is not None:
            name, factor = _FOUND_NAMES.get(field.name, (field.name, 1.0))
            told[name] = factor * value
    return told


def _table(name: str, numbers: dict[str, float]) -> list[str]:
    return ["", f"[{name}]", *(f"{key} = {float(value)!r}" for key, value in numbers.items())]


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _text(name)


def _text(value: str) -> str:
    """A TOML basic string: that of JSON, which leaves one control character as it is."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
