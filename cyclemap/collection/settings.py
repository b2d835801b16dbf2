"""Settings in degrees and millimetres, by name: what the command line and protocol files change of a loop."""

import math
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from cyclemap.checks import finite_array, finite_number
from cyclemap.collection.found_with import plate_footprint
from cyclemap.errors import DoubtfulInput, InvalidInput
from cyclemap.mechanics import (
    DragBack,
    Ellipse,
    Footprint,
    Material,
    PatchFootprint,
    PointFootprint,
    Polygon,
    Slider,
    parse_footprint,
)
from cyclemap.mechanics.outline import Outline
from cyclemap.suggestions import unknown_name
from cyclemap.whole_files import file_stem

if TYPE_CHECKING:
    from cyclemap.collection.loop import CollectionLoop

Settings = dict[str, object]

# What an outline that is not MIT's is called until it is given a name.
OWN_OUTLINE = "own outline"
_FRICTION = {"mu_a": "mu_a", "mu_b": "mu_b", "m0": "m0", "n0": "n0", "phi_deg": "phi"}
_PUSHER = {"pusher_mu": "friction", "pusher_radius_mm": "radius"}
_PUSH = {"side": "side", "fraction": "fraction", "angle_deg": "angle", "push_mm": "distance"}
_OUTLINE = ("shape", "vertices_mm", "semi_x_mm", "semi_y_mm")
_OTHER = ("object_name", "hitch_x_mm", "hitch_y_mm", "centre_x_mm", "centre_y_mm", "mass_kg")
_RESET = ("way_points_mm", "pin_friction_mm")
_SHARES = ("inner_share", "rim_share", "corner_share")
_PRESSURE = ("footprint", *_SHARES)


SETTING_KEYS = (*_FRICTION, *_PUSHER, *_PUSH, *_OUTLINE, *_OTHER, *_RESET, *_PRESSURE)


# What an experiment with an own object would else take over from MIT's without a word: keys, and words for them.
_TO_BE_TOLD = {
    "the ring": ("hitch_x_mm", "hitch_y_mm"),
    "the mass": ("mass_kg",),
    "the pushed side": ("side",),
    "the place on it": ("fraction",),
    "the length of the push": ("push_mm",),
    "the rod": ("pusher_radius_mm",),
}


def layered(*layers: Settings) -> Settings:
    """Return settings of which later ones win; an outline takes the place of one that was said in another way.

    >>> layered({"shape": "hex", "side": 1}, {"semi_x_mm": 40, "semi_y_mm": 50})
    {'side': 1, 'semi_x_mm': 40, 'semi_y_mm': 50}
    """
    found: Settings = {}
    for layer in layers:
        if any(key in layer for key in _OUTLINE):
            found = {key: value for key, value in found.items() if key not in (*_OUTLINE, "object_name")}
        found |= layer
    return found


def inherited_defaults(settings: Settings) -> dict[str, tuple[str, ...]]:
    """Return what the settings of an object that is not MIT's leave to MIT's experiment: words, and the keys.

    >>> inherited_defaults({"semi_x_mm": 40, "semi_y_mm": 50, "side": 0, "fraction": 0.2, "push_mm": 80, "mass_kg": 1})
    {'the ring': ('hitch_x_mm', 'hitch_y_mm'), 'the rod': ('pusher_radius_mm',)}
    """
    if not {"vertices_mm", "semi_x_mm"} & set(settings):
        return {}
    return {words: keys for words, keys in _TO_BE_TOLD.items() if not set(keys) & set(settings)}


def warn_of_defaults(settings: Settings) -> None:
    """Warn (`DoubtfulInput`), once, of what an own object takes over from MIT's experiment."""
    left = inherited_defaults(settings)
    if left:
        keys = ", ".join(key for group in left.values() for key in group)
        told = f"the object is not MIT's, but {', '.join(left)} still are: give {keys}, or begin with cyclemap init"
        warnings.warn(told, DoubtfulInput, stacklevel=3)


def apply_settings(loop: "CollectionLoop", settings: Settings) -> "CollectionLoop":
    """Return the loop with settings replaced; a key that is not in SETTING_KEYS, or a bad value, raises InvalidInput.

    A new outline (`shape`: an MIT shape's name; `vertices_mm`: [[x, y], ...]; `semi_x_mm` with `semi_y_mm`) keeps the
    ring unless `hitch_x_mm`, `hitch_y_mm` move it.
    """
    for key in settings:
        if key not in SETTING_KEYS:
            raise unknown_name("setting", key, SETTING_KEYS)
    with _blaming(settings, (*_OUTLINE, *_OTHER)):
        slider = _slider(loop.slider, settings)
    with _blaming(settings, _FRICTION):
        friction = replace(loop.material.friction, **_numbers(settings, _FRICTION))
    changed = friction != loop.material.friction
    name = f"{loop.material.name} (changed)" if changed else loop.material.name
    plates = loop.material.plates
    material = Material(name, friction, loop.material.provenance, plates=plates) if changed else loop.material
    with _blaming(settings, _PUSHER):
        pusher = replace(loop.pusher, **_numbers(settings, _PUSHER))
    with _blaming(settings, _PUSH):
        push = replace(loop.push, **_numbers(settings, _PUSH))  # type: ignore[arg-type]
    with _blaming(settings, _RESET):
        way_points = _points(settings, "way_points_mm") if "way_points_mm" in settings else loop.reset.way_points
        reset = DragBack(way_points, _number(settings, "pin_friction_mm", loop.reset.pin_friction_radius))
    with _blaming(settings, _PRESSURE):
        footprint = _footprint(loop, slider, settings)
    return replace(loop, slider=slider, material=material, pusher=pusher, push=push, reset=reset, footprint=footprint)


def _footprint(loop: "CollectionLoop", slider: Slider, settings: Settings) -> Footprint | None:
    """Return what is set; `exact` leans as the centre of mass asks; a new outline has the pressure its plate has."""
    same = slider.outline == loop.slider.outline
    found = loop.footprint if same else plate_footprint(loop.material, slider)
    if "footprint" in settings:
        word = str(settings["footprint"])
        found = None if word == "exact" else parse_footprint(word, slider.outline)
    given = [key for key in _SHARES if key in settings]
    if not given:
        return found
    if isinstance(found, PointFootprint):
        raise InvalidInput(f"{given[0]} belongs to the exact footprint: set footprint=exact, or leave {given[0]} out")
    before = PatchFootprint(slider.outline, centre=slider.centre_of_mass) if found is None else found
    shares = {key: _number(settings, key, getattr(before, key)) for key in _SHARES}
    return replace(before, **shares, centre=slider.centre_of_mass)  # type: ignore[arg-type]


def _slider(slider: Slider, settings: Settings) -> Slider:
    hitch = (
        _number(settings, "hitch_x_mm", slider.hitch[0]),
        _number(settings, "hitch_y_mm", slider.hitch[1]),
    )
    outline = _outline(settings)
    if "shape" in settings:
        slider = Slider.mit(str(settings["shape"]), hitch)
    elif outline is not None:
        slider = Slider(outline, slider.mass, hitch=hitch, name=OWN_OUTLINE)
    centre = (
        _number(settings, "centre_x_mm", slider.centre_of_mass[0]),
        _number(settings, "centre_y_mm", slider.centre_of_mass[1]),
    )
    mass, name = _number(settings, "mass_kg", slider.mass), str(settings.get("object_name", slider.name))
    file_stem(name)
    return replace(slider, hitch=hitch, centre_of_mass=centre, mass=mass, name=name)


def _outline(settings: Settings) -> Outline | None:
    given = [key for key in ("shape", "vertices_mm", "semi_x_mm") if key in settings]
    if len(given) > 1:
        raise InvalidInput(f"{given[0]} and {given[1]} both name the outline: give one of them")
    if ("semi_x_mm" in settings) != ("semi_y_mm" in settings):
        raise InvalidInput("an ellipse needs both semi_x_mm and semi_y_mm")
    if "vertices_mm" in settings:
        return Polygon(_points(settings, "vertices_mm"))
    if "semi_x_mm" in settings:
        return Ellipse(_number(settings, "semi_x_mm", 0.0), _number(settings, "semi_y_mm", 0.0))
    return None


@contextmanager
def _blaming(settings: Settings, keys: Iterable[str]) -> Iterator[None]:
    """Add to an error what was set, in the units it was set in."""
    try:
        yield
    except InvalidInput as cause:
        given = ", ".join(f"{key}={settings[key]}" for key in keys if key in settings)
        if not given or given.partition("=")[0] in str(cause):
            raise
        raise InvalidInput(f"{cause} (set: {given})") from cause


def _numbers(settings: Settings, fields: dict[str, str]) -> dict[str, float]:
    return {field: _number(settings, key, 0.0) for key, field in fields.items() if key in settings}


def _number(settings: Settings, key: str, default: float) -> float:
    """Return a setting in SI units: keys tell theirs by their ending."""
    if key not in settings:
        return default
    return _to_si(key)(finite_number(key, settings[key]))


def _to_si(key: str) -> Callable[[float], float]:
    if key.endswith("_deg"):
        return math.radians
    if key.endswith("_mm"):
        return lambda value: value * 1e-3
    return lambda value: value


def _points(settings: Settings, key: str) -> tuple[tuple[float, float], ...]:
    array = finite_array(key, settings[key], last=2)  # type: ignore[arg-type]
    if array.ndim != 2:
        raise InvalidInput(f"{key} must be a list of points [[x, y], ...], not shape {array.shape}")
    return tuple(map(tuple, (array * 1e-3).tolist()))
