"""A collection as one TOML file: the object and its surface, push and reset; what a command writes
every one reads.

The tables [object], [push], [reset] and [noise] hold settings by the names of `--set`. The surface
stands beside them as in a material file. The table [data] says how data beside it count angles and
lay their axes. What else is in it ([strategy], [predicted], [simulation]) belongs to those who
wrote it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from decimal import Decimal
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from cyclemap.checks import positive_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import DataFileError, InvalidInput, located
from cyclemap.mechanics import (
    Ellipse,
    PatchFootprint,
    PointFootprint,
    Polygon,
    PressedFootprint,
    Slider,
    load_material,
    parse_footprint,
)
from cyclemap.mechanics.material_text import FILE_KEYS, material_toml
from cyclemap.mechanics.slider import MIT_SHAPE_NAMES
from cyclemap.protocol.settings import (
    ALWAYS,
    NOISE_KEY,
    OWN,
    OWN_OUTLINE,
    SETTINGS,
    SHAPES,
    SHARES,
    WORD,
    Settings,
    loop_from_settings,
    setting_named,
    warn_of_defaults,
    without_noise,
)
from cyclemap.text_files import key_place, read_text, read_toml
from cyclemap.written import (
    MILLIMETRES,
    NUMBER,
    FileUnit,
    Table,
    check_checksum,
    toml_text,
)

# A loop read back may differ by rounding: settings are doubles in millimetres and degrees.
_ROUNDING = 1e-12
_LARGEST_GRID = 64
# The tables of a file, and the groups of settings that stand in each.
_TABLES = {"object": ("Object", "Pressure", "Shape"), "push": ("Push", "Rod"), "reset": ("Ring",)}
# Settings that are read off a loop one by one; its outline, name, pressure and surface are not.
_READ_OFF = [
    setting
    for setting in SETTINGS.values()
    if setting.group in ("Object", "Ring", "Push", "Rod")
    and setting.kind != WORD
    and setting.place != "slider.outline"
]


def collection_tables(loop: CollectionLoop, noise: float | None = None) -> dict[str, Table]:
    """Return the settings that make of `CollectionLoop.mit(loop.material)` this loop, in tables by
    their part.

    noise : of a cycle, standard deviation in rad, told in a table of its own.

    Object, push and rod are always told, and of an object that is not MIT's its mass, its ring and
    the rod's friction. What a material brings along is else told only where the loop has it
    otherwise, so that another material brings its own. Not told: the friction of the surface, the
    accuracy, and the inertia of an outline that is not MIT's. Raises InvalidInput for what no
    setting can say: support points that are neither corners nor a grid.
    """
    base = CollectionLoop.mit(loop.material)
    shape = _shape(loop.slider)
    own = "shape" not in shape
    # An own object's ring is told in any case: MIT's would lie beside it.
    hitch = zip(("hitch_x_mm", "hitch_y_mm"), loop.slider.hitch, strict=True)
    ring = {key: _written(MILLIMETRES, value) for key, value in hitch} if own else {}
    start = loop_from_settings(plain_numbers({**shape, **ring}), base)
    settings = {**shape, **_footprint(loop, start)}
    for setting in _READ_OFF:
        always = setting.written == ALWAYS or (own and setting.written == OWN)
        # A coordinate says a place only beside the other.
        place = setting.place.removesuffix(".0").removesuffix(".1")
        if always or not _same(attrgetter(place)(loop), attrgetter(place)(start)):
            settings[setting.key] = _written(setting.unit, setting.of(loop))
    tables: dict[str, Table] = {
        name: {
            key: settings[key]
            for key, setting in SETTINGS.items()
            if key in settings and setting.group in groups
        }
        for name, groups in _TABLES.items()
    }
    lost = _unlike(loop, loop_from_settings(plain_numbers(settings), base))
    if lost:
        raise InvalidInput(
            f"no setting of a protocol file can say the loop's {', '.join(lost)}: leave that as "
            "it was"
        )
    if noise is not None:
        tables["noise"] = {NOISE_KEY: math.degrees(positive_number("noise", noise))}
    return {name: table for name, table in tables.items() if table}


def _unlike(loop: CollectionLoop, other: CollectionLoop) -> list[str]:
    """The settings by which two loops differ."""
    keys = [setting.key for setting in _READ_OFF if not _same(setting.of(loop), setting.of(other))]
    if not _same(loop.slider.outline_points(8), other.slider.outline_points(8)):
        keys.insert(0, "outline")
    # A footprint that is left to the centre of mass is compared as what it comes to.
    pressures = [
        each.footprint or PatchFootprint(each.slider.outline, centre=each.slider.centre_of_mass)
        for each in (loop, other)
    ]
    return keys if _same_footprint(*pressures) else [*keys, "footprint"]


def plain_numbers(value: Any) -> Any:
    """Return a value of a file with doubles in place of decimals, in lists and tables too."""
    if isinstance(value, dict):
        return {key: plain_numbers(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [plain_numbers(entry) for entry in value]
    return float(value) if isinstance(value, Decimal) else value


def _written(unit: FileUnit, value: Any) -> object:
    """What a file says of a value, or of the values of a list, in SI units: the double that, read,
    comes nearest.
    """
    if isinstance(value, (tuple, list)):
        return [_written(unit, entry) for entry in value]
    return value if unit is NUMBER else Decimal(repr(float(unit.written(value))))


def _shape(slider: Slider) -> Settings:
    for shape in MIT_SHAPE_NAMES:
        if Slider.mit(shape).outline == slider.outline:
            return {"shape": shape}
    name: Settings = {} if slider.name == OWN_OUTLINE else {"object_name": slider.name}
    if isinstance(slider.outline, Ellipse):
        semi_x = _written(MILLIMETRES, slider.outline.semi_x)
        semi_y = _written(MILLIMETRES, slider.outline.semi_y)
        return {"semi_x_mm": semi_x, "semi_y_mm": semi_y, **name}
    assert isinstance(slider.outline, Polygon)
    return {"vertices_mm": _written(MILLIMETRES, slider.outline.array.tolist()), **name}


def _footprint(loop: CollectionLoop, start: CollectionLoop) -> Settings:
    footprint = loop.footprint
    if _same_footprint(footprint, start.footprint):
        return {}
    if footprint is None:
        return {"footprint": "exact"}
    if isinstance(footprint, PressedFootprint):
        shapes = {key: SETTINGS[key] for key in SHAPES}
        return {key: _written(setting.unit, setting.of(loop)) for key, setting in shapes.items()}
    if isinstance(footprint, PatchFootprint):
        return {"footprint": "exact", **{name: getattr(footprint, name) for name in SHARES}}
    names = ["corners"] if isinstance(loop.slider.outline, Polygon) else []
    for name in (*names, *(f"grid:{count}" for count in range(2, _LARGEST_GRID + 1))):
        if _same_footprint(footprint, parse_footprint(name, loop.slider.outline)):
            return {"footprint": name}
    raise InvalidInput(
        f"{len(footprint.positions)} support points are neither corners nor a grid: a protocol "
        "names them by their CSV file; write it without them, and add footprint = FILE.csv by hand"
    )


def _same_footprint(first: object, other: object) -> bool:
    if isinstance(first, PointFootprint) and isinstance(other, PointFootprint):
        return _same(first.positions, other.positions) and _same(first.weights, other.weights)
    if isinstance(first, PressedFootprint) and isinstance(other, PressedFootprint):
        return first.is_near(other)
    if isinstance(first, PatchFootprint) and isinstance(other, PatchFootprint):
        alike = all(_same(getattr(first, name), getattr(other, name)) for name in SHARES)
        return alike and bool(np.allclose(first.gradient, other.gradient, rtol=1e-9, atol=1e-9))
    return first == other


def _same(first: object, other: object) -> bool:
    a = np.asarray(first, dtype=float)
    b = np.asarray(other, dtype=float)
    return a.shape == b.shape and bool(np.all(np.abs(a - b) <= _ROUNDING))


STRATEGY = "strategy"
PREDICTED = "predicted"
SIMULATION = "simulation"
DATA = "data"
# Data folders keep the collection that they are of under this name.
FILE_NAME = "collection.toml"
_PASSED_OVER = {*FILE_KEYS, STRATEGY, PREDICTED, SIMULATION, DATA} - {"friction"}
_FOLDERS_UP = 4


def read_settings(path: str | Path) -> Settings:
    """Return the settings of a file, in its units, for `loop_from_settings`; `noise_deg` among
    them.

    They stand in tables of any name. A surface's own keys and tables are passed over; a table
    [friction] is one where it has both mu_a and mu_b, and settings otherwise.

    Raises DataFileError, naming file, key and value, where the file cannot be read, nests deeper,
    gives a key twice, holds what is no setting, or is not what its checksum was made of.
    """
    text = read_text(Path(path), "TOML")
    check_checksum(path, text)
    settings: Settings = {}
    # Decimals, so that no number is rounded before its unit is known.
    for name, given in read_toml(path, Decimal).items():
        if name in _PASSED_OVER or _is_surface(name, given):
            continue
        table, entries = (name, given) if isinstance(given, dict) else ("", {name: given})
        for key, value in entries.items():
            with located(key_place(path, text, table, key), DataFileError):
                if key in settings:
                    raise InvalidInput(f"{key} is given twice; keep one")
                settings[key] = plain_numbers(value)
                if isinstance(value, bool) or not isinstance(value, (int, Decimal, str, list)):
                    raise InvalidInput(
                        f"{key} is {settings[key]!r}; it must be a number, text or list of points"
                    )
                setting_named(key).checked(settings[key])
    return settings


def _is_surface(name: str, table: object) -> bool:
    return name == "friction" and isinstance(table, dict) and {"mu_a", "mu_b"} <= set(table)


def names_surface(path: str | Path) -> bool:
    """Whether a file tells a whole surface, as a material file does."""
    return any(_is_surface(*entry) for entry in read_toml(path).items())


def loop_from_file(path: str | Path, surface: str | Path | None = None) -> CollectionLoop:
    """Return the loop of a collection file, such as `cyclemap init` writes.

    Parameters
    ----------
    path : str or Path
        The file. What it does not say is MIT's; where its object is not, a `DoubtfulInput`
        warning tells what that is.
    surface : str or Path or None, optional
        A material, or a material file, in place of the file's own; without either, isotropic
        friction.

    Returns
    -------
    CollectionLoop
        The loop, checked.

    Raises
    ------
    DataFileError
        For a file that is no collection.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from cyclemap.protocol import loop_from_file
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     text = '[object]\\nshape = "rect1"\\n\\n[push]\\npush_mm = 80\\n'
    ...     count = Path(folder, "mine.toml").write_text(text)
    ...     loop = loop_from_file(f"{folder}/mine.toml")
    >>> loop.push.distance, loop.material.name
    (0.08, 'isotropic')
    """
    settings = read_settings(path)
    material = load_material(surface or (path if names_surface(path) else "isotropic"))
    warn_of_defaults(settings)
    return loop_from_settings(settings, CollectionLoop.mit(material))


def data_settings(data: str | Path) -> Settings:
    """Return what the folder of data, or one above it, says of object, push and reset; not the
    surface.
    """
    file = _collection_of(data)
    return {} if file is None else without_noise(read_settings(file))[0]


def data_table(data: str | Path) -> Settings:
    """Return the table [data] of the collection file in the folder of data, or in one above it;
    empty without one.
    """
    file = _collection_of(data)
    table = {} if file is None else read_toml(file).get(DATA, {})
    if not isinstance(table, dict):
        raise DataFileError(f"{file}: {DATA} must be a table, [data], not {table!r}")
    return table


def _collection_of(data: str | Path) -> Path | None:
    place = Path(data)
    files = (folder / FILE_NAME for folder in [place, *place.absolute().parents[:_FOLDERS_UP]])
    return next((file for file in files if file.is_file()), None)


def collection_text(
    loop: CollectionLoop,
    *,
    noise: float | None = None,
    more: Mapping[str, Table] | None = None,
    comments: tuple[str, ...] = (),
    notes: Mapping[str, str] | None = None,
) -> str:
    """Return a loop with its surface as the text of a file.

    noise : of a cycle, standard deviation in rad.
    more : further tables.
    comments : lines before all else.
    notes : what is said of a setting, by its key.

    Raises InvalidInput for a loop no setting can say.
    """
    head = "".join(f"# {line}".rstrip() + "\n" for line in comments)
    tables = {**collection_tables(loop, noise), **(more or {})}
    return f"{head}{material_toml(loop.material)}\n{toml_text(tables, notes=notes or {})}"
