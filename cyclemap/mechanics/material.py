"""Materials: a surface's point friction with its name and where its numbers come from."""

import math
import tomllib
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.suggestions import unknown_name
from cyclemap.text_files import read_toml

FRICTION_KEYS = ("mu_a", "mu_b", "m0", "n0", "phi_deg")


@dataclass(frozen=True)
class Material:
    """A surface: its name, its point friction against the slider, and the source of the numbers."""

    name: str
    friction: EllipseFriction
    provenance: str = ""


def material_names() -> tuple[str, ...]:
    """Names of the built-in materials.

    >>> "plywood" in material_names()
    True
    """
    folder = resources.files("cyclemap.mechanics") / "materials"
    return tuple(sorted(f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml")))


def load_material(name: str | Path) -> Material:
    """Return a built-in material by name, or one from a TOML file (a path that ends in .toml).

    The file holds `name`, `provenance` and a table [friction] with mu_a, mu_b and, where not zero, m0, n0, phi_deg.
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
    """Return the friction law of a table whose angle is `phi_deg`; mu_b, left out, equals mu_a."""
    for key in values:
        if key not in FRICTION_KEYS:
            raise unknown_name("friction key", key, FRICTION_KEYS)
    if "mu_a" not in values:
        raise InvalidInput("a friction table needs mu_a, the friction coefficient along the material's first axis")
    numbers = {"mu_b": values["mu_a"], **values}
    for key, value in numbers.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InvalidInput(f"friction key {key} must be a number, not {value!r}")
    phi = math.radians(numbers.pop("phi_deg", 0.0))  # type: ignore[arg-type]
    return EllipseFriction(**numbers, phi=phi)  # type: ignore[arg-type]


def _material_from_file(path: Path) -> Material:
    table = read_toml(path)
    try:
        return _material_from_table(table, path.stem)
    except InvalidInput as cause:
        raise DataFileError(f"{path}: {cause}") from cause


def _material_from_table(table: dict[str, object], name: str) -> Material:
    for key in table:
        if key not in ("name", "provenance", "friction"):
            raise unknown_name("key in a material file", key, ("name", "provenance", "friction"))
    friction = table.get("friction")
    if not isinstance(friction, dict):
        raise InvalidInput("a material file needs a table [friction] with mu_a and mu_b")
    law = friction_from_degrees(friction)
    return Material(str(table.get("name", name)), law, str(table.get("provenance", "")))
