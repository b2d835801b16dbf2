"""Every fact of an experiment that can be set, told once, in `settings.toml`: key, unit, usual
range, meaning, and where a loop has it; a loop from settings by name, and what they leave to MIT.

From this table come --set, the files' tables and their checks, sweeps, the explorer's sliders, what
`cyclemap check` doubts, the comments that `cyclemap init` writes, and the table of the guide.
"""

from __future__ import annotations

import math
import tomllib
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import resources
from typing import Any

from cyclemap.arrays import Place
from cyclemap.checks import finite_array, finite_number, positive_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import DoubtfulInput, InvalidInput, unknown_name
from cyclemap.mechanics import (
    Ellipse,
    Footprint,
    Material,
    PatchFootprint,
    PointFootprint,
    Polygon,
    PressedFootprint,
    Slider,
    parse_footprint,
)
from cyclemap.mechanics.foundation import FLAT
from cyclemap.mechanics.outline import Outline
from cyclemap.mechanics.plate_footprint import mean_pressure, plate_footprint, pressed_footprint
from cyclemap.plain_text import json_value, plain_number
from cyclemap.text_files import file_stem
from cyclemap.written import DEGREES, MILLIMETRES, NUMBER, FileUnit

Settings = dict[str, object]

NOISE_KEY = "noise_deg"
WORD = "word"
POINTS = "points"
ALWAYS = "always"
OWN = "own"


@dataclass(frozen=True)
class Setting:
    """One fact of an experiment, by the key of `--set`, whose ending tells its unit.

    group : of sliders, and of a file's tables.
    place : the attribute of a loop, by dots, in SI units; the class that has it, or what that is made
        of, refuses what cannot be, and says what may.
    kind : what its values are, a number, WORD or POINTS.
    default : words for MIT's, where it is no number of the loop.
    written : when a file says it: ALWAYS, of an object of one's OWN; else where it is changed.
    label, low, high, step : of its slider; the range is the usual one, in the key's unit, and holds
        nobody to it.
    """

    key: str
    group: str
    place: str
    meaning: str
    kind: str = ""
    default: str = ""
    written: str = ""
    label: str = ""
    low: float = -math.inf
    high: float = math.inf
    step: float = 0.0

    @property
    def unit(self) -> FileUnit:
        """The unit that the key's ending tells."""
        return {"deg": DEGREES, "mm": MILLIMETRES}.get(self.key.rpartition("_")[2], NUMBER)

    def of(self, loop: CollectionLoop) -> Any:
        """Return the value that a loop has, in SI units; None where it has none."""
        value: Any = loop
        for name in self.place.split("."):
            value = value[int(name)] if name.isdigit() else getattr(value, name, None)
        return value

    def parsed(self, text: str) -> object:
        """Return the value that people mean by a text; the text itself, for `checked` to refuse,
        where it is none.
        """
        if self.kind == WORD:
            return text
        try:
            return json_value(text) if self.kind == POINTS else plain_number(text)
        except ValueError:
            return text

    def checked(self, value: object) -> object:
        """Return a value that the key may have, numbers as float, points as tuples; InvalidInput
        otherwise.

        Whether the values of several keys go together only the loop can tell.
        """
        if self.kind == WORD:
            if not isinstance(value, str) or not value:
                raise InvalidInput(f"{self.key} must be a word, not {value!r}")
            return value
        if self.kind == POINTS:
            pairs = finite_array(self.key, value, last=2, ndim=2)  # type: ignore[arg-type]
            return tuple(map(tuple, pairs.tolist()))
        return (positive_number if self.key == NOISE_KEY else finite_number)(self.key, value)


_TEXT = (resources.files("cyclemap.protocol") / "settings.toml").read_text(encoding="utf-8")
SETTINGS = {key: Setting(key, **facts) for key, facts in tomllib.loads(_TEXT).items()}
SHARES = tuple(
    key
    for key, setting in SETTINGS.items()
    if setting.place.startswith("footprint.") and setting.group == "Pressure"
)
SHAPES = tuple(key for key, setting in SETTINGS.items() if setting.group == "Shape")


def setting_named(key: str) -> Setting:
    """Return the setting of a key; InvalidInput, with the nearest one, where there is none.

    >>> setting_named("push_mm").group
    'Push'
    """
    if key not in SETTINGS:
        raise unknown_name("setting", key, SETTINGS)
    return SETTINGS[key]


def without_noise(settings: Mapping[str, object]) -> tuple[Settings, float | None]:
    """Return the settings of a loop, and the noise of a cycle (standard deviation, rad) where they
    name one.

    >>> without_noise({"mu_a": 0.3, "noise_deg": 180})
    ({'mu_a': 0.3}, 3.141592653589793)
    """
    noise = settings.get(NOISE_KEY)
    sigma = None if noise is None else math.radians(positive_number(NOISE_KEY, noise))
    return {key: value for key, value in settings.items() if key != NOISE_KEY}, sigma


# Centres as near, in extents of the outline, are one: cells of a coarse grid have no nearer one.
_SAME_CENTRE = 0.02
# What an outline that is not MIT's is called until it is given a name.
OWN_OUTLINE = "own outline"
_OUTLINE = ("shape", "vertices_mm", "semi_x_mm", "semi_y_mm")

# What an experiment with an own object would else take over from MIT's without a word: keys, and
# words for them.
_TO_BE_TOLD = {
    "the ring": ("hitch_x_mm", "hitch_y_mm"),
    "the mass": ("mass_kg",),
    "the pushed side": ("side",),
    "the place on it": ("fraction",),
    "the length of the push": ("push_mm",),
    "the rod": ("pusher_radius_mm",),
}


def layered(*layers: Settings) -> Settings:
    """Return settings of which later ones win; an outline takes the place of one that was said in
    another way.
    """
    settings: Settings = {}
    for layer in layers:
        if any(key in layer for key in _OUTLINE):
            settings = {
                key: value
                for key, value in settings.items()
                if key not in (*_OUTLINE, "object_name")
            }
        settings |= layer
    return settings


def inherited_defaults(settings: Settings) -> dict[str, tuple[str, ...]]:
    """Return what the settings of an object that is not MIT's leave to MIT's experiment: words, and
    the keys.

    >>> outline, push = {"semi_x_mm": 40, "semi_y_mm": 50}, {"side": 0, "fraction": 0.2}
    >>> inherited_defaults({**outline, **push, "push_mm": 80, "mass_kg": 1})
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
        doubt = (
            f"the object is not MIT's, but of MIT's experiment still: {', '.join(left)}; give "
            f"{keys}, or begin with cyclemap init"
        )
        warnings.warn(doubt, DoubtfulInput, stacklevel=3)


def loop_from_settings(settings: Settings, base: CollectionLoop | None = None) -> CollectionLoop:
    """Return a loop with settings in degrees and millimetres, as on the command line.

    Parameters
    ----------
    settings : mapping of str to object
        By the keys of `--set`. A new outline (`shape`: an MIT shape's name; `vertices_mm`:
        [[x, y], ...]; `semi_x_mm` with `semi_y_mm`) keeps the ring unless `hitch_x_mm`,
        `hitch_y_mm` move it. What files say of the noise of a cycle, `noise_deg`, is checked
        and left aside: a loop has none.
    base : CollectionLoop or None, optional
        What is not set is taken from it; None: MIT's loop on plywood.

    Returns
    -------
    CollectionLoop
        The base with the settings.

    Raises
    ------
    InvalidInput
        For a key that is no setting, and for a bad value.

    Warns
    -----
    DoubtfulInput
        Where a centre of mass is set that support points do not have.

    Examples
    --------
    >>> from cyclemap.protocol import loop_from_settings
    >>> loop_from_settings({"push_mm": 80, "noise_deg": 2}).push.distance
    0.08
    """
    settings, _ = without_noise(settings)
    loop = base or CollectionLoop.mit()
    for key in settings:
        if key not in SETTINGS:
            raise unknown_name(
                "setting", str(key), [known for known in SETTINGS if known != NOISE_KEY]
            )
    with _blaming(settings, "slider"):
        slider = _slider(loop.slider, settings)
    with _blaming(settings, "material"):
        friction = replace(loop.material.friction, **_numbers(settings, "material.friction"))
    material = stated = loop.material
    if friction != stated.friction:
        material = Material(
            f"{stated.name} (changed)",
            friction,
            stated.provenance,
            plates=stated.plates,
            floor=stated.floor,
            noise=stated.noise,
        )
    changes: dict[str, Any] = {"slider": slider, "material": material}
    for name in ("pusher", "push", "reset"):
        with _blaming(settings, name):
            set_here: dict[str, Any] = dict(_numbers(settings, name))
            if name == "reset" and "way_points_mm" in settings:
                set_here["way_points"] = _points(settings, "way_points_mm")
            changes[name] = replace(getattr(loop, name), **set_here)
    with _blaming(settings, "footprint"):
        footprint = _footprint(loop, slider, settings)
        if isinstance(footprint, PointFootprint) and {"centre_x_mm", "centre_y_mm"} & {*settings}:
            _warn_of_two_centres(footprint, slider)
        return replace(loop, **changes, footprint=footprint)


def _warn_of_two_centres(points: PointFootprint, slider: Slider) -> None:
    """Warn (`DoubtfulInput`) of a centre of mass that is set, and that support points do not have."""
    if math.dist(points.centre, slider.centre_of_mass) > _SAME_CENTRE * slider.outline.extent:
        borne, set_to = (
            f"({MILLIMETRES.of_si(x):.1f}, {MILLIMETRES.of_si(y):.1f}) mm"
            for x, y in (points.centre, slider.centre_of_mass)
        )
        doubt = (
            f"support points carry the object about {borne}, its centre of mass is set to {set_to}: "
            "strokes go by the points; give weights that have that centre, or footprint=exact"
        )
        warnings.warn(doubt, DoubtfulInput, stacklevel=4)


def _footprint(loop: CollectionLoop, slider: Slider, settings: Settings) -> Footprint | None:
    """Return what is set; `exact` leans as the centre of mass asks; a new outline has the pressure
    its plate has.
    """
    same = slider.outline == loop.slider.outline
    footprint = loop.footprint if same else plate_footprint(loop.material, slider)
    if same and isinstance(footprint, PressedFootprint):
        # Shapes are the surface's and the object's pressures: a heavier object has less of them in
        # mean pressures.
        lighter = mean_pressure(loop.slider) / mean_pressure(slider)
        footprint = pressed_footprint(
            slider, footprint.plate, footprint.floor, footprint.field, lighter
        )
    if "footprint" in settings:
        word = str(settings["footprint"])
        footprint = None if word == "exact" else parse_footprint(word, slider.outline)
    given = [key for key in (*SHAPES, *SHARES) if key in settings]
    if not given:
        return footprint
    if isinstance(footprint, PointFootprint):
        raise InvalidInput(
            f"{given[0]} belongs to the exact footprint: set footprint=exact, or leave "
            f"{given[0]} out"
        )
    return _shaped(slider, footprint, settings)


def _shaped(
    slider: Slider, footprint: PatchFootprint | PressedFootprint | None, settings: Settings
) -> Footprint | None:
    """Return an exact footprint with the shapes and shares that are set."""
    plate = floor = FLAT
    field = None
    if isinstance(footprint, PressedFootprint):
        plate, floor, field = footprint.plate, footprint.floor, footprint.field
    plate = replace(plate, **_numbers(settings, "footprint.plate"))
    floor = replace(floor, **_numbers(settings, "footprint.floor"))
    has_shares = isinstance(footprint, PatchFootprint)
    patch = footprint if isinstance(footprint, PatchFootprint) else PatchFootprint(slider.outline)
    numbers: dict[str, Any] = _numbers(settings, "footprint")
    patch = replace(patch, **numbers, centre=slider.centre_of_mass)
    if plate.is_flat and floor.is_flat and field is None:
        return patch if numbers or has_shares else None
    shared = [key for key in SHARES if getattr(patch, key) != 0.0]
    if shared:
        share = f"{shared[0]}={getattr(patch, shared[0]):g}"
        raise InvalidInput(
            f"{share} beside shapes of floor or object: both tell how it rests; set one of "
            "them to 0"
        )
    return PressedFootprint(slider.outline, plate, floor, slider.centre_of_mass, field)


def _slider(slider: Slider, settings: Settings) -> Slider:
    given = [key for key in ("shape", "vertices_mm", "semi_x_mm") if key in settings]
    if len(given) > 1:
        raise InvalidInput(f"{given[0]} and {given[1]} both name the outline: give one of them")
    if ("semi_x_mm" in settings) != ("semi_y_mm" in settings):
        raise InvalidInput("an ellipse needs both semi_x_mm and semi_y_mm")
    hitch = _place(settings, "slider.hitch", slider.hitch)
    if "shape" in settings:
        slider = Slider.mit(str(settings["shape"]), hitch)
    elif given:
        outline: Outline = (
            Polygon(_points(settings, "vertices_mm"))
            if "vertices_mm" in settings
            else Ellipse(*(_si(key, settings[key]) for key in ("semi_x_mm", "semi_y_mm")))
        )
        slider = Slider(outline, slider.mass, hitch=hitch, name=OWN_OUTLINE)
    centre = _place(settings, "slider.centre_of_mass", slider.centre_of_mass)
    name = str(settings.get("object_name", slider.name))
    file_stem(name)
    numbers: dict[str, Any] = _numbers(settings, "slider")
    return replace(slider, hitch=hitch, centre_of_mass=centre, name=name, **numbers)


@contextmanager
def _blaming(settings: Settings, place: str) -> Iterator[None]:
    """Add to an error what was set of a part of the loop, in the units it was set in."""
    try:
        yield
    except InvalidInput as cause:
        keys = [
            key
            for key, setting in SETTINGS.items()
            if key in settings and setting.place.split(".")[0] == place
        ]
        given = ", ".join(f"{key}={settings[key]}" for key in keys)
        if not given or given.partition("=")[0] in str(cause):
            raise
        raise InvalidInput(f"{cause} (set: {given})") from cause


def _numbers(settings: Settings, owner: str) -> dict[str, float]:
    """The numbers that are set of a part of the loop, in SI units, by its attributes."""
    numbers = {}
    for key, value in settings.items():
        place, _, name = SETTINGS[key].place.rpartition(".")
        if place == owner and not SETTINGS[key].kind and name != "outline":
            numbers[name] = _si(key, value)
    return numbers


def _place(settings: Settings, owner: str, unset: Place) -> Place:
    """A place whose coordinates may be set, each for itself."""
    coordinates = _numbers(settings, owner)
    return coordinates.get("0", unset[0]), coordinates.get("1", unset[1])


def _si(key: str, value: object) -> float:
    return SETTINGS[key].unit.read(finite_number(key, value))


def _points(settings: Settings, key: str) -> tuple[tuple[float, float], ...]:
    points = SETTINGS[key].checked(settings[key])
    return tuple((_si(key, x), _si(key, y)) for x, y in points)  # type: ignore[attr-defined]
