"""Materials: a surface's point friction, with its name, where its numbers come from, and what was found with them."""

import math
import re
import tomllib
import warnings
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from cyclemap.checks import finite_number, positive_number
from cyclemap.errors import DataFileError, DoubtfulInput, InvalidInput
from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.mechanics.friction_wear import worn_friction
from cyclemap.plain_text import printable
from cyclemap.suggestions import unknown_name
from cyclemap.text_files import read_toml

# Friction coefficients of dry surfaces are below the one; none is known above the other.
_USUAL_FRICTION, _LARGEST_FRICTION = 2.0, 10.0
FRICTION_KEYS = ("mu_a", "mu_b", "m0", "n0", "phi_deg")
FILE_KEYS = ("name", "provenance", "misfit", "inferred", "friction", "worn", "found_with")
# What a file may hold beside a surface: the object on it, and what is done to it (`cyclemap.collection`).
_OTHER_TABLES = ("object", "push", "reset", "noise", "strategy", "predicted", "simulation")
_FOUND_KEYS = {
    "pusher_mu": "pusher_friction",
    "inner_share": "inner_share",
    "rim_share": "rim_share",
    "corner_share": "corner_share",
    "hitch_scale": "hitch_scale",
    "hitch_turn_deg": "hitch_turn",
    "pin_friction_mm": "pin_friction_radius",
}


@dataclass(frozen=True)
class FoundWith:
    """What was identified together with a surface's friction; None where it was not: the loop's own value holds.

    pusher_friction : coefficient of rod and object. inner_share, rim_share, corner_share : how the object's weight
    rests on its underside, which belong to that object. hitch_scale, hitch_turn : the effective hitch is the nominal
    one times the scale, turned by the angle (rad). pin_friction_radius : m, of the rod in the ring.
    """

    pusher_friction: float | None = None
    inner_share: float | None = None
    rim_share: float | None = None
    corner_share: float | None = None
    hitch_scale: float | None = None
    hitch_turn: float | None = None
    pin_friction_radius: float | None = None


@dataclass(frozen=True)
class Wear:
    """How a surface changes: after `cycles` cycles its friction is `friction`, on a straight way (`worn_friction`)."""

    friction: EllipseFriction
    cycles: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "cycles", positive_number("cycles of wear", self.cycles))


@dataclass(frozen=True)
class Material:
    """A surface: its name, its point friction against the slider, and the source of the numbers.

    misfit : how far the data lie from what the numbers predict, in words. inferred : whether the numbers were inferred
    from how objects moved rather than measured as forces. found_with : what was identified along with the friction.
    wear : the friction at the end of the data; None where it is taken not to change.
    """

    name: str
    friction: EllipseFriction
    provenance: str = ""
    misfit: str = ""
    inferred: bool = False
    found_with: FoundWith = FoundWith()
    wear: Wear | None = None

    def __post_init__(self) -> None:
        if not re.search(r"[^\W_]", self.name) or printable(self.name) != self.name or "\n" in self.name:
            raise InvalidInput(
                f"a material's name is {self.name!r}: it names files and is printed, so it needs a letter or a "
                "digit, and no control characters"
            )
        for friction in (self.friction, *([self.wear.friction] if self.wear else [])):
            largest = max(friction.mu_a, friction.mu_b)
            if largest > _LARGEST_FRICTION:
                raise InvalidInput(f"friction of {largest:g} is that of no surface: give a coefficient, not per cent")
            if largest > _USUAL_FRICTION:
                warnings.warn(
                    f"friction of {largest:g} is more than rubber's: is that the coefficient?",
                    DoubtfulInput,
                    stacklevel=3,
                )

    def friction_after(self, cycles: float) -> EllipseFriction:
        """Return the friction after a number of cycles, 0 or more; beyond those of `wear` it stays the worn one.

        >>> load_material("plywood").friction_after(500.0) == load_material("plywood").friction
        True
        """
        if self.wear is None:
            return self.friction
        share = finite_number("cycles", cycles) / self.wear.cycles
        return worn_friction(self.friction, self.wear.friction, min(max(share, 0.0), 1.0))


def material_names() -> tuple[str, ...]:
    """Names of the built-in materials.

    >>> "plywood" in material_names()
    True
    """
    folder = resources.files("cyclemap.mechanics") / "materials"
    return tuple(sorted(f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml")))


def load_material(name: str | Path) -> Material:
    """Return a built-in material by name, or one from a TOML file (a path that ends in .toml).

    The file holds a table [friction] with mu_a, mu_b and, where not zero, m0, n0, phi_deg, and it may hold `name`,
    `provenance`, `misfit`, `inferred` (true or false), a table [worn] with `cycles` and the friction after them, and a
    table [found_with] of what was identified along with it: pusher_mu, inner_share, rim_share, corner_share,
    hitch_scale, hitch_turn_deg, pin_friction_mm.
    Tables of object, push, reset, noise and strategy are passed over: `CollectionLoop.from_file` reads those.
    Raises InvalidInput for an unknown name, DataFileError for a file that is missing or is not such a table.

    >>> load_material("plywood").friction.mu_a
    0.2545
    """
    if str(name).endswith(".toml"):
        return _material_from_file(Path(name))
    if str(name) not in material_names():
        raise unknown_name("material", str(name), material_names())
    text = (resources.files("cyclemap.mechanics") / "materials" / f"{name}.toml").read_text(encoding="utf-8")
    return _material_from_table(tomllib.loads(text), str(name))


def friction_from_degrees(values: dict[str, object]) -> EllipseFriction:
    """Return the friction law of a table whose angle is `phi_deg`; m0, n0 and phi_deg, left out, are zero."""
    for key in values:
        if key not in FRICTION_KEYS:
            raise unknown_name("friction key", key, FRICTION_KEYS)
    for key in ("mu_a", "mu_b"):
        if key not in values:
            raise InvalidInput(
                f"a friction table needs {key}: friction coefficients along the material's axes are mu_a and mu_b, the "
                "same number twice where it is the same in every direction"
            )
    checked = {key: finite_number(f"friction key {key}", value) for key, value in values.items()}
    return EllipseFriction(phi=math.radians(checked.pop("phi_deg", 0.0)), **checked)


def _material_from_file(path: Path) -> Material:
    table = read_toml(path)
    try:
        return _material_from_table(table, path.stem)
    except InvalidInput as cause:
        raise DataFileError(f"{path}: {cause}") from cause


def _material_from_table(table: dict[str, object], name: str) -> Material:
    for key in table:
        if key not in (*FILE_KEYS, *_OTHER_TABLES):
            raise unknown_name("key in a material file", key, (*FILE_KEYS, *_OTHER_TABLES))
    friction = table.get("friction")
    if not isinstance(friction, dict):
        raise InvalidInput("a material file needs a table [friction] with mu_a and mu_b")
    inferred = table.get("inferred", False)
    if not isinstance(inferred, bool):
        raise InvalidInput(f"inferred is {inferred!r}: it must be true or false")
    words = {key: str(table.get(key, "")) for key in ("provenance", "misfit")}
    law, found, wear = friction_from_degrees(friction), _found_with(table), _wear(table)
    return Material(str(table.get("name", name)), law, **words, inferred=inferred, found_with=found, wear=wear)


def _found_with(table: dict[str, object]) -> FoundWith:
    found = _table(table, "found_with")
    for key in found:
        if key not in _FOUND_KEYS:
            raise unknown_name("key of [found_with]", key, tuple(_FOUND_KEYS))
    unit = {"pin_friction_mm": 1e-3, "hitch_turn_deg": math.pi / 180.0}
    numbers = {key: unit.get(key, 1.0) * finite_number(key, value) for key, value in found.items()}
    return FoundWith(**{_FOUND_KEYS[key]: value for key, value in numbers.items()})


def _wear(table: dict[str, object]) -> Wear | None:
    worn = _table(table, "worn")
    if not worn:
        return None
    if "cycles" not in worn:
        raise InvalidInput(
            "a table [worn] needs cycles, the number of cycles after which the friction is the one it has"
        )
    cycles = finite_number("cycles", worn.pop("cycles"))
    return Wear(friction_from_degrees(worn), cycles)


def _table(table: dict[str, object], name: str) -> dict[str, object]:
    found = table.get(name, {})
    if not isinstance(found, dict):
        raise InvalidInput(f"{name} is {found!r}: it must be a table, [{name}]")
    return dict(found)
