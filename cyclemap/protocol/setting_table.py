"""Every fact of an experiment that can be set, told once: key, unit, usual range, meaning, and
where a loop has it.

From this table come --set, the files' tables and their checks, sweeps, the explorer's sliders, what
`cyclemap check` doubts, the comments that `cyclemap init` writes, and the table of the guide.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from cyclemap.checks import finite_array, finite_number, positive_number
from cyclemap.errors import InvalidInput, unknown_name
from cyclemap.file_text import DEGREES, MILLIMETRES, NUMBER, FileUnit
from cyclemap.plain_text import json_value, plain_number

if TYPE_CHECKING:
    from cyclemap.collection.loop import CollectionLoop

Settings = dict[str, object]

NOISE_KEY = "noise_deg"
WORD = "word"
POINTS = "points"
ALWAYS = "always"
OWN = "own"
CHANGED = "changed"


@dataclass(frozen=True)
class Setting:
    """One fact of an experiment, by the key of `--set`, whose ending tells its unit.

    group : of sliders, and of a file's tables.
    place : the attribute of a loop, by dots, in SI units.
    kind : what its values are, a number, WORD or POINTS.
    default : words for MIT's, where it is no number of the loop.
    told : when a file says it: ALWAYS, of an object of one's OWN, or where it is CHANGED.
    label, low, high, step : of its slider; the range is the usual one, in the key's unit, and holds
        nobody to it.
    """

    key: str
    group: str
    place: str
    meaning: str
    kind: str = ""
    default: str = ""
    told: str = CHANGED
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
            return tuple(map(tuple, finite_array(self.key, value, last=2, ndim=2).tolist()))  # type: ignore[arg-type]
        return (positive_number if self.key == NOISE_KEY else finite_number)(self.key, value)


_TABLE = (
    Setting(
        "shape",
        "Object",
        "slider.outline",
        "the object, by its name in the MIT push dataset",
        WORD,
        "`rect1`",
    ),
    Setting(
        "vertices_mm",
        "Object",
        "slider.outline",
        "or its corners `[[x, y], ...]` in the frame of its drawing, counter-clockwise; side i "
        "runs from corner i (from 0) to the next",
        POINTS,
        "-",
    ),
    Setting(
        "semi_x_mm", "Object", "slider.outline", "or an ellipse: its half axis along x", default="-"
    ),
    Setting("semi_y_mm", "Object", "slider.outline", "and along y", default="-"),
    Setting("object_name", "Object", "slider.name", "what the data call it", WORD, "the shape's"),
    Setting(
        "mass_kg",
        "Object",
        "slider.mass",
        "its mass; it scales forces, and the motion only where the surface or the object has a "
        "shape: a heavier one rests more evenly",
        told=OWN,
    ),
    Setting(
        "centre_x_mm",
        "Object",
        "slider.centre_of_mass.0",
        "its centre of mass",
        default="the centroid",
    ),
    Setting(
        "centre_y_mm",
        "Object",
        "slider.centre_of_mass.1",
        "its centre of mass",
        default="the centroid",
    ),
    Setting(
        "hitch_x_mm",
        "Ring",
        "slider.hitch.0",
        "the ring that drags the object back, in the object's frame: measure where yours is",
        told=OWN,
        label="ring x",
        low=-60.0,
        high=60.0,
        step=0.1,
    ),
    Setting(
        "hitch_y_mm",
        "Ring",
        "slider.hitch.1",
        "the ring, in the object's frame",
        told=OWN,
        label="ring y",
        low=-60.0,
        high=60.0,
        step=0.1,
    ),
    Setting(
        "way_points_mm",
        "Ring",
        "reset.way_points",
        "places `[[x, y], ...]`, from the target, through which the rod drags on its way back",
        POINTS,
        "none",
    ),
    Setting(
        "pin_friction_mm",
        "Ring",
        "reset.pin_friction_radius",
        "friction of the rod in the ring: the radius of its friction circle",
    ),
    Setting(
        "mu_a",
        "Floor",
        "material.friction.mu_a",
        "friction of the surface along the first axis of its ellipse",
        default="the material's",
        label="friction μa",
        low=0.05,
        high=1.2,
        step=0.001,
    ),
    Setting(
        "mu_b",
        "Floor",
        "material.friction.mu_b",
        "and along the second axis",
        default="the material's",
        label="friction μb",
        low=0.05,
        high=1.2,
        step=0.001,
    ),
    Setting(
        "phi_deg",
        "Floor",
        "material.friction.phi",
        "direction of the first axis in the robot's frame",
        default="the material's",
        label="friction axis φ",
        low=0.0,
        high=180.0,
        step=0.5,
    ),
    Setting(
        "m0",
        "Floor",
        "material.friction.m0",
        "offset of the ellipse's centre along the first axis",
        default="the material's",
        label="offset m0",
        low=-0.1,
        high=0.1,
        step=0.0005,
    ),
    Setting(
        "n0",
        "Floor",
        "material.friction.n0",
        "and along the second axis",
        default="the material's",
        label="offset n0",
        low=-0.1,
        high=0.1,
        step=0.0005,
    ),
    Setting(
        "footprint",
        "Pressure",
        "footprint",
        "pressure under the object: `exact` (uniform), `grid:8` (8 x 8 points), `corners`, or a "
        "CSV file",
        WORD,
        "`exact`",
    ),
    Setting(
        "inner_share",
        "Pressure",
        "footprint.inner_share",
        "share of the weight on the inner part; what no share tells is uniform",
        default="0",
        label="load inside",
        low=0.0,
        high=1.0,
        step=0.01,
    ),
    Setting(
        "rim_share",
        "Pressure",
        "footprint.rim_share",
        "share of the weight on the rim",
        default="0",
        label="load on the rim",
        low=0.0,
        high=1.0,
        step=0.01,
    ),
    Setting(
        "corner_share",
        "Pressure",
        "footprint.corner_share",
        "share of the weight on the corners",
        default="0",
        label="load on corners",
        low=0.0,
        high=1.0,
        step=0.01,
    ),
    Setting(
        "floor_dome",
        "Shape",
        "footprint.floor.dome",
        "how far the floor is from flat, in mean pressures at 50 mm from the object's centre: "
        "alike in all directions, positive: high around the object",
        default="the material's",
        label="floor dome",
        low=-20.0,
        high=20.0,
        step=0.1,
    ),
    Setting(
        "floor_bow",
        "Shape",
        "footprint.floor.bow",
        "and one way along its axis, the other across: a trough is dome and bow alike",
        default="the material's",
        label="floor bow",
        low=0.0,
        high=20.0,
        step=0.1,
    ),
    Setting(
        "floor_bow_deg",
        "Shape",
        "footprint.floor.axis",
        "direction of the floor's bow in the robot's frame",
        default="the material's",
        label="bow's axis",
        low=0.0,
        high=180.0,
        step=1.0,
    ),
    Setting(
        "plate_dome",
        "Shape",
        "footprint.plate.dome",
        "the same of the object's underside, positive: rests on its rim",
        default="the material's",
        label="plate dome",
        low=-20.0,
        high=20.0,
        step=0.1,
    ),
    Setting(
        "plate_warp",
        "Shape",
        "footprint.plate.bow",
        "how the object is warped, one way along an axis, the other across",
        default="the material's",
        label="plate warp",
        low=0.0,
        high=20.0,
        step=0.1,
    ),
    Setting(
        "plate_warp_deg",
        "Shape",
        "footprint.plate.axis",
        "direction of the warp in the object's frame",
        default="the material's",
        label="warp's axis",
        low=0.0,
        high=180.0,
        step=1.0,
    ),
    Setting(
        "side",
        "Push",
        "push.side",
        "side that is pushed, counter-clockwise from 0",
        told=ALWAYS,
        label="side",
        low=0.0,
        high=0.0,
        step=1.0,
    ),
    Setting(
        "fraction",
        "Push",
        "push.fraction",
        "where on it, from its first corner (0) to its second (1)",
        told=ALWAYS,
        label="place on the side",
        low=0.02,
        high=0.98,
        step=0.005,
    ),
    Setting(
        "angle_deg",
        "Push",
        "push.angle",
        "direction of the push from the side's inward normal, counter-clockwise",
        told=ALWAYS,
        label="push slant",
        low=-60.0,
        high=60.0,
        step=0.5,
    ),
    Setting(
        "push_mm",
        "Push",
        "push.distance",
        "how far the rod goes from its first touch",
        told=ALWAYS,
        label="push length",
        low=10.0,
        high=300.0,
        step=1.0,
    ),
    Setting(
        "pusher_radius_mm",
        "Rod",
        "pusher.radius",
        "radius of the rod",
        told=ALWAYS,
        label="rod radius",
        low=0.0,
        high=20.0,
        step=0.05,
    ),
    Setting(
        "pusher_mu",
        "Rod",
        "pusher.friction",
        "friction of rod and object; 0.15 is steel on steel",
        told=OWN,
        label="rod friction",
        low=0.0,
        high=0.8,
        step=0.005,
    ),
    Setting(
        NOISE_KEY,
        "Noise",
        "",
        "scatter of the orientation from cycle to cycle, a standard deviation",
        default="1.1, measured on plywood",
        label="noise of a cycle",
        low=0.3,
        high=15.0,
        step=0.1,
    ),
)

SETTINGS: Mapping[str, Setting] = {setting.key: setting for setting in _TABLE}
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
