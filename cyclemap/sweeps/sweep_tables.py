"""A sweep as CSV and as an xarray Dataset or NetCDF file: degrees where names tell so, what is missing left empty."""

import csv
import io
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cyclemap.sweeps.quantities import Quantity
from cyclemap.sweeps.sweep_results import Sweep
from cyclemap.whole_files import write_whole

if TYPE_CHECKING:
    import xarray

_KEY_UNITS = {"_deg": "degree", "_mm": "mm", "_kg": "kg"}
REFUSAL = "refusal"


def write_csv(sweep: Sweep, path: str | Path) -> None:
    """Write one line a point, in the plan's order: its number, swept keys, quantities, lists spread out, refusal.

    The file appears whole or not at all (OSError). The same points give the same bytes, however they were found.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    longest = {one.name: _longest(sweep, one) for one in sweep.quantities if one.listed}
    writer.writerow(_header(sweep, longest))
    for place in range(len(sweep)):
        writer.writerow(_line(sweep, place, longest))
    write_whole(Path(path), text.getvalue().encode())


def _header(sweep: Sweep, longest: dict[str, int]) -> list[str]:
    names = ["number", *sweep.keys]
    names += [one.written_name for one in sweep.quantities if not one.listed]
    for one in sweep.quantities:
        names += [f"{one.written_name}_{k + 1}" for k in range(longest.get(one.name, 0))]
    return [*names, REFUSAL]


def _line(sweep: Sweep, place: int, longest: dict[str, int]) -> list[str]:
    line = [str(sweep.number[place]), *(_word(sweep.swept[key][place]) for key in sweep.keys)]
    line += [_number(one, sweep.columns[one.name][place]) for one in sweep.quantities if not one.listed]
    for one in sweep.quantities:
        if one.listed:
            values = [_number(one, value) for value in sweep.lists[one.name][place]]
            line += values + [""] * (longest[one.name] - len(values))
    return [*line, sweep.refusals[place]]


def _word(value: object) -> str:
    if isinstance(value, (float, str)):
        return str(value)
    return json.dumps(value)


def _number(quantity: Quantity, value: float) -> str:
    return "" if np.isnan(value) else repr(quantity.written(float(value)))


def _longest(sweep: Sweep, quantity: Quantity) -> int:
    return max((values.size for values in sweep.lists[quantity.name]), default=0)


def to_dataset(sweep: Sweep) -> "xarray.Dataset":
    """Return the sweep as an xarray Dataset: a grid's dimensions are its swept keys, a sample's is `point`.

    Each quantity is a variable with its unit and meaning as attributes; a list has one dimension more, as long as the
    longest, padded with nan, and a variable `NAME_count` of how many there are. `refusal` is text.
    """
    import xarray

    dimensions = tuple(axis.key for axis in sweep.axes) or ("point",)
    shape = sweep.shape if sweep.axes else (len(sweep),)
    at = sweep.places() if sweep.axes else (np.arange(len(sweep)),)
    variables: dict[str, Any] = {}
    for one in sweep.quantities:
        if one.listed:
            variables.update(_listed_variables(sweep, one, dimensions, shape, at))
        else:
            values = np.full(shape, np.nan)
            values[at] = one.written_array(sweep.columns[one.name])
            variables[one.written_name] = (dimensions, values, _attributes(one))
    refusal = np.full(shape, "", dtype=object)
    refusal[at] = np.array(sweep.refusals, dtype=object)
    variables[REFUSAL] = (dimensions, refusal, {"long_name": "why numbers are missing"})
    return xarray.Dataset(
        variables, _coordinates(sweep), {"title": "sweep", "plan": json.dumps(sweep.description["plan"])}
    )


def _listed_variables(
    sweep: Sweep, one: Quantity, dimensions: tuple[str, ...], shape: tuple[int, ...], at: tuple[Any, ...]
) -> dict[str, Any]:
    lists = sweep.lists[one.name]
    padded, count = np.full((*shape, _longest(sweep, one)), np.nan), np.zeros(shape, dtype=np.int64)
    sizes = np.array([values.size for values in lists], dtype=np.int64)
    rows = np.full((len(lists), padded.shape[-1]), np.nan)
    for row, values in zip(rows, lists, strict=True):
        row[: values.size] = values
    padded[at], count[at] = one.written_array(rows), sizes
    about = {"units": "1", "long_name": f"how many {one.many.replace('_', ' ')}s there are"}
    return {
        one.written_name: ((*dimensions, one.many), padded, _attributes(one)),
        f"{one.many}_count": (dimensions, count, about),
    }


def _attributes(quantity: Quantity) -> dict[str, str]:
    return {"units": quantity.written_unit, "long_name": quantity.meaning}


def _coordinates(sweep: Sweep) -> dict[str, Any]:
    if not sweep.axes:
        points = {"point": (("point",), sweep.number)}
        return points | {
            key: (("point",), _coordinate(values), _key_attributes(key)) for key, values in sweep.swept.items()
        }
    return {axis.key: ((axis.key,), _coordinate(axis.values), _key_attributes(axis.key)) for axis in sweep.axes}


def _coordinate(values: tuple[object, ...]) -> Any:
    numeric = all(isinstance(value, float) for value in values)
    return np.array(values, dtype=float) if numeric else np.array([_word(value) for value in values], dtype=object)


def _key_attributes(key: str) -> dict[str, str]:
    unit = next((unit for ending, unit in _KEY_UNITS.items() if key.endswith(ending)), "1")
    return {"units": unit}


def write_netcdf(sweep: Sweep, path: str | Path) -> None:
    """Write `to_dataset` as a NetCDF-4 file, whole or not at all (OSError)."""
    dataset = to_dataset(sweep)
    write_whole(Path(path), bytes(dataset.to_netcdf(engine="h5netcdf")))
