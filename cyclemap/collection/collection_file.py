"""A collection as one TOML file: the object and its surface, push and reset; what a command writes every one reads.

The tables [object], [push], [reset] and [noise] hold settings by the names of `--set`. The surface stands beside them
as in a material file. What else is in it ([strategy], [predicted], [simulation]) belongs to those who wrote it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path

from cyclemap.checks import positive_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_settings import loop_tables, plain_numbers
from cyclemap.collection.setting_table import NOISE_KEY, Settings, setting_named, without_noise
from cyclemap.collection.settings import warn_of_defaults
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.file_text import Table, check_checksum, located, toml_text
from cyclemap.maps import WrappedNormal
from cyclemap.mechanics import load_material
from cyclemap.mechanics.material_text import FILE_KEYS, material_toml
from cyclemap.text_files import key_place, read_text, read_toml

STRATEGY, PREDICTED, SIMULATION = "strategy", "predicted", "simulation"
# Data folders keep the collection that they are of under this name.
FILE_NAME = "collection.toml"
_PASSED_OVER = {*FILE_KEYS, STRATEGY, PREDICTED, SIMULATION} - {"friction"}
_FOLDERS_UP = 4


def read_settings(path: str | Path) -> Settings:
    """Return the settings of a file, in its units, for `CollectionLoop.from_settings`; `noise_deg` among them.

    They stand in tables of any name. A surface's own keys and tables are passed over; a table [friction] is one where
    it has both mu_a and mu_b, and settings otherwise.

    Raises DataFileError, naming file, key and value, where the file cannot be read, nests deeper, gives a key twice,
    holds what is no setting, or is not what its checksum was made of.
    """
    text = read_text(Path(path), "TOML")
    check_checksum(path, text)
    settings: Settings = {}
    # Decimals, so that no number is rounded before its unit is known.
    for name, found in read_toml(path, Decimal).items():
        if name in _PASSED_OVER or _is_surface(name, found):
            continue
        table, entries = (name, found) if isinstance(found, dict) else ("", {name: found})
        for key, value in entries.items():
            with located(key_place(path, text, table, key), DataFileError):
                if key in settings:
                    raise InvalidInput(f"{key} is given twice; keep one")
                settings[key] = plain_numbers(value)
                if isinstance(value, bool) or not isinstance(value, (int, Decimal, str, list)):
                    raise InvalidInput(f"{key} is {settings[key]!r}; it must be a number, text or list of points")
                setting_named(key).checked(settings[key])
    return settings


def _is_surface(name: str, table: object) -> bool:
    return name == "friction" and isinstance(table, dict) and {"mu_a", "mu_b"} <= set(table)


def names_surface(path: str | Path) -> bool:
    """Whether a file tells a whole surface, as a material file does."""
    return any(_is_surface(*entry) for entry in read_toml(path).items())


def read_collection(path: str | Path, surface: str | Path | None = None) -> CollectionLoop:
    """Return the loop of a file; `surface`: a material, or a material file, in place of the file's own.

    What the file does not say is MIT's; where its object is not, a `DoubtfulInput` warning tells what that is.
    """
    settings, _ = without_noise(read_settings(path))
    material = load_material(surface or (path if names_surface(path) else "isotropic"))
    warn_of_defaults(settings)
    return CollectionLoop.from_settings(settings, CollectionLoop.mit(material))


def data_settings(data: str | Path) -> Settings:
    """Return what the folder of data, or one above it, says of object, push and reset; not the surface."""
    place = Path(data)
    for folder in [place, *place.absolute().parents[:_FOLDERS_UP]]:
        if (folder / FILE_NAME).is_file():
            return without_noise(read_settings(folder / FILE_NAME))[0]
    return {}


def collection_tables(loop: CollectionLoop, noise: WrappedNormal | float | None = None) -> dict[str, Table]:
    """Return the tables of a loop and of the noise of its cycles (rad); see `loop_tables`."""
    tables: dict[str, Table] = dict(loop_tables(loop))
    if noise is not None:
        sigma = noise.sigma if isinstance(noise, WrappedNormal) else noise
        tables["noise"] = {NOISE_KEY: math.degrees(positive_number("noise", sigma))}
    return tables


def collection_text(
    loop: CollectionLoop,
    *,
    noise: WrappedNormal | float | None = None,
    more: Mapping[str, Table] | None = None,
    comments: tuple[str, ...] = (),
    notes: Mapping[str, str] | None = None,
) -> str:
    """Return a loop with its surface as the text of a file.

    noise : of a cycle, a `WrappedNormal` or its standard deviation in rad. more : further tables. comments : lines
    before all else. notes : what is said of a setting, by its key. Raises InvalidInput for a loop no setting can say.
    """
    head = "".join(f"# {line}".rstrip() + "\n" for line in comments)
    tables = {**collection_tables(loop, noise), **(more or {})}
    return f"{head}{material_toml(loop.material)}\n{toml_text(tables, notes=notes or {})}"
