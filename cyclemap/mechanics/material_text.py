"""A material as the text of a file: read by `load_material`, written by `material_toml`."""

import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from functools import lru_cache
from importlib import resources
from pathlib import Path

from cyclemap.checks import finite_array, finite_number, non_negative_number
from cyclemap.errors import DataFileError, InvalidInput, unknown_name
from cyclemap.mechanics.foundation import FloorField
from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.mechanics.material import (
    FIELD_KEYS,
    FLOOR_SHAPE_KEYS,
    FOUND_KEYS,
    FRICTION_KEYS,
    PLATE_KEYS,
    SPREAD_KEYS,
    CycleNoise,
    FloorSession,
    FoundWith,
    FrameShift,
    Material,
    MaterialPosterior,
    PlatePressure,
    Wear,
    friction_numbers,
    shape_numbers,
    shape_of_numbers,
)
from cyclemap.text_files import read_toml
from cyclemap.written import toml_key, toml_value

FILE_KEYS = (
    "name",
    "provenance",
    "misfit",
    "inferred",
    "friction",
    "worn",
    "found_with",
    "plates",
    "posterior",
    "cycle_noise",
    "frames",
    "floor_shape",
    "sessions",
    "session_spread",
    "floor_field",
)
SHIFT_KEYS = ("shift_x_mm", "shift_y_mm")
# What a file may hold beside a surface: the object on it, and what is done to it
# (`cyclemap.collection`).
_OTHER_TABLES = ("object", "push", "reset", "noise", "strategy", "predicted", "simulation", "data")


def material_names() -> tuple[str, ...]:
    """Return the names of the built-in materials.

    Returns
    -------
    tuple of str
        What `load_material` takes.

    Examples
    --------
    >>> from cyclemap import material_names
    >>> "plywood" in material_names()
    True
    """
    folder = resources.files("cyclemap.mechanics") / "materials"
    return tuple(
        sorted(f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml"))
    )


def load_material(name: str | Path) -> Material:
    """Return a built-in material by name, or one from a TOML file (a path that ends in .toml).

    Parameters
    ----------
    name : str or Path
        Name of a built-in material (`material_names`), or the path of a TOML file.

    Returns
    -------
    Material
        The surface, checked.

    Raises
    ------
    InvalidInput
        For an unknown name.
    DataFileError
        For a file that is missing or is not such a table.

    Notes
    -----
    The file holds a table [friction] with mu_a, mu_b and, where not zero, m0, n0, phi_deg, and it
    may hold `name`, `provenance`, `misfit`, `inferred` (true or false), and tables: [worn] with
    `cycles`, the friction after them and a `course` of pairs [cycles, share] (`Wear`); [found_with]
    with pusher_mu, pin_friction_mm (`FoundWith`); [plates.NAME] with inner_share, rim_share,
    corner_share, or plate_dome_kpa, plate_warp_kpa, plate_warp_deg (`PlatePressure`); [floor_shape]
    with floor_dome_kpa, floor_bow_kpa, floor_bow_deg, and [sessions.NAME] with the same
    (`FloorSession`); [session_spread] with dome_kpa, bow_x_kpa, bow_y_kpa; [floor_field]
    (`FloorField`); [frames.NAME] with shift_x_mm, shift_y_mm (`FrameShift`); [posterior] with
    `parameters` and `samples` (`MaterialPosterior`); [cycle_noise] with `log_sigma` and
    `correlation` (`CycleNoise`). Tables of object, push, reset, noise, strategy, predicted,
    simulation and data are passed over: `loop_from_file` reads the first five.

    Examples
    --------
    >>> from cyclemap import load_material
    >>> load_material("plywood").friction.mu_a
    0.2545
    """
    if str(name).endswith(".toml"):
        path = Path(name)
        table = read_toml(path)
        try:
            return _material_of(table, path.stem)
        except InvalidInput as cause:
            raise DataFileError(f"{path}: {cause}") from cause
    if str(name) not in material_names():
        raise unknown_name("material", str(name), material_names())
    text = (resources.files("cyclemap.mechanics") / "materials" / f"{name}.toml").read_text(
        encoding="utf-8"
    )
    return _material_of(tomllib.loads(text), str(name))


def load_plates(name: str | Path) -> tuple[PlatePressure, ...]:
    """Return shapes of plates: of a built-in one by its name, or of all in a TOML file (a path that
    ends in .toml) with tables [plates.NAME].

    Built-in shapes were found on plywood and abs at once (`tests.inference.measured_floors`).
    Raises InvalidInput for an unknown name, DataFileError for a file that is missing or tells no
    shape.
    """
    if not str(name).endswith(".toml"):
        known = {pressure.plate: pressure for pressure in built_in_plates()}
        if str(name) not in known:
            raise unknown_name("plate", str(name), known)
        return (known[str(name)],)
    pressures = _plates_of(read_toml(Path(name)))
    shapes = tuple(pressure for pressure in pressures if not any(pressure.shares.values()))
    if not shapes:
        raise DataFileError(f"{name}: no table [plates.NAME] with a shape: plate_dome_kpa, ...")
    return shapes


@lru_cache
def built_in_plates() -> tuple[PlatePressure, ...]:
    """Return the shapes of the plates of the MIT dataset that are known."""
    text = (resources.files("cyclemap.mechanics") / "plates.toml").read_text(encoding="utf-8")
    return _plates_of(tomllib.loads(text))


def _plates_of(table: dict[str, object]) -> tuple[PlatePressure, ...]:
    plates = _tables(table, "plates", PLATE_KEYS)
    return tuple(PlatePressure.of_numbers(plate, numbers) for plate, numbers in plates)


def _material_of(table: dict[str, object], name: str) -> Material:
    _refuse_unknown("key in a material file", table, (*FILE_KEYS, *_OTHER_TABLES))
    if not isinstance(table.get("friction"), dict):
        raise InvalidInput("a material file needs a table [friction] with mu_a and mu_b")
    inferred = table.get("inferred", False)
    if not isinstance(inferred, bool):
        raise InvalidInput(f"inferred is {inferred!r}: it must be true or false")
    dome, bow_x, bow_y = _numbers_of(_table(table, "session_spread", SPREAD_KEYS), SPREAD_KEYS)
    frames = []
    for plate, shift in _tables(table, "frames", SHIFT_KEYS):
        x_mm, y_mm = _numbers_of(shift, SHIFT_KEYS)
        frames.append(FrameShift(plate, 1e-3 * x_mm, 1e-3 * y_mm))
    noise = _table(table, "cycle_noise", ("log_sigma", "correlation"))
    if noise:
        why = ", the logarithm of its standard deviation in radians"
        _require("table [cycle_noise]", noise, ("log_sigma",), why)
    return Material(
        str(table.get("name", name)),
        _friction_of(_table(table, "friction")),
        provenance=str(table.get("provenance", "")),
        misfit=str(table.get("misfit", "")),
        inferred=inferred,
        found_with=_found_with_of(table),
        wear=_wear_of(_table(table, "worn")),
        plates=_plates_of(table),
        posterior=_posterior_of(_table(table, "posterior", ("parameters", "samples"))),
        noise=CycleNoise(**noise) if noise else None,  # type: ignore[arg-type]
        frames=tuple(frames),
        floor=shape_of_numbers(_table(table, "floor_shape", FLOOR_SHAPE_KEYS), FLOOR_SHAPE_KEYS),
        sessions=tuple(
            FloorSession(session, shape_of_numbers(shape, FLOOR_SHAPE_KEYS))
            for session, shape in _tables(table, "sessions", FLOOR_SHAPE_KEYS)
        ),
        session_spread=(dome, bow_x, bow_y),
        field=_field_of(_table(table, "floor_field", FIELD_KEYS)),
    )


def _found_with_of(table: dict[str, object]) -> FoundWith:
    for key in _table(table, "found_with"):
        if key in PLATE_KEYS:
            raise InvalidInput(
                f"{key} belongs to a plate: move it to a table [plates.NAME], such as "
                "[plates.rect1]"
            )
    together = {}
    for key, value in _table(table, "found_with", tuple(FOUND_KEYS)).items():
        field, unit = FOUND_KEYS[key]
        together[field] = unit * non_negative_number(key, value)
    return FoundWith(**together)


def _posterior_of(table: dict[str, object]) -> MaterialPosterior | None:
    """What it is made of is checked where it is made."""
    names, samples = table.get("parameters"), table.get("samples")
    if not table:
        return None
    if (
        isinstance(names, list)
        and isinstance(samples, list)
        and all(isinstance(name, str) for name in names)
    ):
        return MaterialPosterior(tuple(names), tuple(samples))
    raise InvalidInput(
        "a table [posterior] needs parameters, a list of names, and samples, a list of rows"
    )


def _numbers_of(table: dict[str, object], keys: tuple[str, ...]) -> list[float]:
    """The numbers under some keys, zero where there is none."""
    return [finite_number(key, table.get(key, 0.0)) for key in keys]


def _require(what: str, table: dict[str, object], keys: tuple[str, ...], why: str) -> None:
    for key in keys:
        if key not in table:
            raise InvalidInput(f"a {what} needs {key}{why}")


def _refuse_unknown(what: str, keys: Iterable[str], known: tuple[str, ...]) -> None:
    for key in keys:
        if key not in known:
            raise unknown_name(what, key, known)


def _table(
    table: dict[str, object], name: str, known: tuple[str, ...] = (), title: str = ""
) -> dict[str, object]:
    """A table in a table, empty where there is none; where some keys are `known`, others are
    refused.
    """
    inner = table.get(name, {})
    if not isinstance(inner, dict):
        raise InvalidInput(f"{name} is {inner!r}: it must be a table, [{name}]")
    if known:
        _refuse_unknown(f"key of [{title or name}]", inner, known)
    return dict(inner)


def _tables(
    table: dict[str, object], name: str, known: tuple[str, ...]
) -> list[tuple[str, dict[str, object]]]:
    """The tables [name.KEY], each with its key."""
    inner = _table(table, name)
    return [(key, _table(inner, key, known, f"{name}.{key}")) for key in inner]


def _friction_of(values: dict[str, object]) -> EllipseFriction:
    """The friction law of a table whose angle is `phi_deg`; m0, n0, phi_deg, left out, are zero."""
    _refuse_unknown("friction key", values, FRICTION_KEYS)
    why = (
        ": friction coefficients along the material's axes are mu_a and mu_b, the same number "
        "twice where it is the same in every direction"
    )
    _require("friction table", values, ("mu_a", "mu_b"), why)
    checked = {key: finite_number(f"friction key {key}", value) for key, value in values.items()}
    return EllipseFriction(phi=math.radians(checked.pop("phi_deg", 0.0)), **checked)


def _field_of(numbers: dict[str, object]) -> FloorField | None:
    if not numbers:
        return None
    why = (
        ": dome_kpa, bow_x_kpa and bow_y_kpa, each a list of factors of X, Y, X^2, X Y, Y^2 in "
        "50 mm from the target, and reach_mm"
    )
    _require("table [floor_field]", numbers, FIELD_KEYS, why)
    rows = []
    for key in SPREAD_KEYS:
        rows.append(finite_array(key, numbers[key], last=5, ndim=1))  # type: ignore[arg-type]
    reach = 1e-3 * finite_number("reach_mm", numbers["reach_mm"])
    return FloorField(tuple(tuple(row.tolist()) for row in rows), reach)


def _wear_of(worn: dict[str, object]) -> Wear | None:
    if not worn:
        return None
    why = ", the number of cycles after which the friction is the one it has"
    _require("table [worn]", worn, ("cycles",), why)
    cycles, course = finite_number("cycles", worn.pop("cycles")), worn.pop("course", [])
    shape = {key: worn.pop(key) for key in FLOOR_SHAPE_KEYS if key in worn}
    floor = shape_of_numbers(shape, FLOOR_SHAPE_KEYS) if shape else None
    return Wear(_friction_of(worn), cycles, course, floor)  # type: ignore[arg-type]


def material_toml(material: Material) -> str:
    """Return a material as TOML; `load_material` gives it back, angles and lengths to rounding.

    Parameters
    ----------
    material : Material
        What to write.

    Returns
    -------
    str
        The text of a TOML file.

    Examples
    --------
    >>> from cyclemap.mechanics import EllipseFriction, Material, material_toml
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
    tables: dict[str, Mapping[str, object]] = {"friction": friction_numbers(material.friction)}
    if material.wear is not None:
        worn: dict[str, object] = {
            "cycles": material.wear.cycles,
            **friction_numbers(material.wear.friction),
        }
        if material.wear.course:
            worn["course"] = material.wear.course
        if material.wear.floor is not None:
            worn |= shape_numbers(material.wear.floor, FLOOR_SHAPE_KEYS)
        tables["worn"] = worn
    if not material.floor.is_flat:
        tables["floor_shape"] = shape_numbers(material.floor, FLOOR_SHAPE_KEYS)
    for session in material.sessions:
        key = toml_key(session.name)
        tables[f"sessions.{key}"] = shape_numbers(session.shape, FLOOR_SHAPE_KEYS)
    if material.field is not None:
        rows = zip(SPREAD_KEYS, material.field.coefficients, strict=True)
        tables["floor_field"] = {**dict(rows), "reach_mm": 1e3 * material.field.reach}
    if any(material.session_spread):
        tables["session_spread"] = dict(zip(SPREAD_KEYS, material.session_spread, strict=True))
    known = {}
    for key, (field, unit) in FOUND_KEYS.items():
        value = getattr(material.found_with, field)
        if value is not None:
            known[key] = round(1.0 / unit) * value
    if known:
        tables["found_with"] = known
    for pressure in material.plates:
        tables[f"plates.{toml_key(pressure.plate)}"] = pressure.numbers
    for shift in material.frames:
        places = 1e3 * shift.x, 1e3 * shift.y
        tables[f"frames.{toml_key(shift.plate)}"] = dict(zip(SHIFT_KEYS, places, strict=True))
    if material.noise is not None:
        tables["cycle_noise"] = asdict(material.noise)
    if material.posterior is not None:
        tables["posterior"] = {"parameters": material.posterior.parameters}
    words = {key: getattr(material, key) for key in ("name", "provenance", "misfit", "inferred")}
    lines = [f"{key} = {toml_value(value)}" for key, value in words.items() if value]
    for name, table in tables.items():
        lines += [
            "",
            f"[{name}]",
            *(f"{key} = {toml_value(value)}" for key, value in table.items()),
        ]
    if material.posterior is not None:
        lines += [
            "samples = [",
            *(f"    {toml_value(row)}," for row in material.posterior.samples),
            "]",
        ]
    return "\n".join(lines) + "\n"
