"""What a sweep has found so far, read from its store; as an xarray Dataset, NetCDF and CSV."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.arrays import Array
from cyclemap.errors import InvalidInput, unknown_name
from cyclemap.sweeps.point_sets import SweepAxis, key_unit
from cyclemap.sweeps.portrait_numbers import Quantity
from cyclemap.sweeps.sweep_plan import SweepPlan
from cyclemap.sweeps.sweep_store import Description, SweepStore
from cyclemap.text_files import write_whole

if TYPE_CHECKING:
    import pandas
    import xarray

REFUSAL = "refusal"
Wanted = float | str | tuple[float, float] | Sequence[object]


@dataclass(frozen=True, eq=False)
class Sweep:
    """What a sweep has found so far.

    Attributes
    ----------
    keys : tuple of str
        The swept keys.
    axes : tuple of SweepAxis
        Of a grid, those that are not selected away; () for a sample.
    quantities : tuple of Quantity
        What was asked.
    table : pandas.DataFrame
        A row a point, in the plan's order: its `number`, the swept keys, every quantity in SI
        units (nan where there is none, lists as arrays of any length), and `refusal`, empty where
        nothing was refused.
    description : mapping
        What the store tells of its plan.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> from cyclemap.sweeps import PortraitNumbers, SweepPlan, load_sweep, run_sweep
    >>> turns = PortraitNumbers(("turns",))
    >>> plan = SweepPlan.grid("isotropic", {"push_mm": (100, 150)}, numbers=turns)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     status = run_sweep(plan, f"{folder}/sweep.sqlite", workers=1)
    ...     sweep = load_sweep(f"{folder}/sweep.sqlite")
    >>> sweep.shape, np.degrees(sweep.select(push_mm=150).values("mean_turn")).round(2).tolist()
    ((2,), [8.0])
    """

    keys: tuple[str, ...]
    axes: tuple[SweepAxis, ...]
    quantities: tuple[Quantity, ...]
    table: pandas.DataFrame
    description: Description

    def __len__(self) -> int:
        return len(self.table)

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each axis has."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def refused(self) -> NDArray[np.bool_]:
        """Whether something was refused at each point, (n,)."""
        return np.asarray(self.table[REFUSAL] != "")

    def is_numeric(self, key: str) -> bool:
        """Whether the values of a swept key are numbers."""
        return all(isinstance(value, float) for value in self.table[key])

    def quantity(self, name: str) -> Quantity:
        """The quantity of that name; InvalidInput where it was not asked for."""
        known = {quantity.name: quantity for quantity in self.quantities}
        if name not in known:
            raise unknown_name("quantity of this sweep", name, known)
        return known[name]

    def values(self, name: str) -> Array:
        """A quantity (SI) or a numeric swept key (in its units), (n,)."""
        numbers = [quantity.name for quantity in self.quantities if not quantity.many]
        if name not in (*numbers, *self.keys):
            raise unknown_name("column", name, (*numbers, *self.keys))
        if name in self.keys and not self.is_numeric(name):
            raise InvalidInput(f"{name} is no number: name its values")
        return np.asarray(self.table[name], dtype=float)

    def on_grid(self, name: str) -> Array:
        """A quantity in the shape of the axes, nan where a point is refused, chosen away or not yet
        done.
        """
        if not self.axes:
            raise InvalidInput("a sample has no grid: use values")
        quantity = self.quantity(name)
        if quantity.many:
            raise InvalidInput(f"{name} has any number of values a point: it has no grid")
        return _spread(self, self.table[quantity.name].to_numpy(), np.nan)

    def places(self) -> tuple[NDArray[np.int64], ...]:
        """Where each point stands along each axis, (n,) an axis."""
        places = []
        for axis in self.axes:
            place_of = {value: place for place, value in enumerate(axis.values)}
            places.append(self.table[axis.key].map(place_of).to_numpy(dtype=np.int64))
        return tuple(places)

    def select(self, **wanted: Wanted) -> Sweep:
        """Return the points whose swept keys have a value, lie within a pair (low, high), or are in
        a list.

        Parameters
        ----------
        **wanted : object
            By key. One value takes its axis away, so that `on_grid` has one dimension less. A
            pair (a tuple of two numbers) is a range, ends included; a list is a choice.

        Returns
        -------
        Sweep
            The points that are left.

        Raises
        ------
        InvalidInput
            Where a key is not swept or no point has the value.
        """
        selected = self
        for key, value in wanted.items():
            if key not in self.keys:
                raise unknown_name("swept key", key, self.keys)
            matches, single = selected._match(key, value)
            selected = selected.where(
                np.array([matches(choice) for choice in selected.table[key]], dtype=bool)
            )
            axis = next((axis for axis in selected.axes if axis.key == key), None)
            if axis is None:
                if not len(selected):
                    raise InvalidInput(f"no point has {key}={value}")
                continue
            kept = tuple(choice for choice in axis.values if matches(choice))
            if not kept:
                listed = ", ".join(
                    f"{v:.6g}" if isinstance(v, float) else str(v) for v in axis.values[:12]
                )
                more = ", ..." if len(axis.values) > 12 else ""
                raise InvalidInput(f"{key} does not take {value}; its values are {listed}{more}")
            thinner = [] if single else [replace(axis, values=kept)]
            place = selected.axes.index(axis)
            selected = replace(
                selected, axes=(*selected.axes[:place], *thinner, *selected.axes[place + 1 :])
            )
        return selected

    def where(self, chosen: ArrayLike | Callable[[Sweep], ArrayLike]) -> Sweep:
        """The points for which `chosen` is true: n flags, or a function of the sweep that gives
        them.
        """
        flags = np.asarray(chosen(self) if callable(chosen) else chosen)
        if flags.shape != (len(self),) or flags.dtype != np.bool_:
            raise InvalidInput(
                f"where needs {len(self)} true or false, not {flags.dtype} of shape {flags.shape}"
            )
        return replace(self, table=self.table[flags].reset_index(drop=True))

    def _match(self, key: str, wanted: Wanted) -> tuple[Callable[[object], bool], bool]:
        """Whether a value is wanted, and whether only one value is."""
        if (
            isinstance(wanted, tuple)
            and len(wanted) == 2
            and all(isinstance(end, (int, float)) for end in wanted)
        ):
            self.values(key)  # refuses words
            low, high = wanted
            return lambda value: bool(low <= value <= high), False
        if isinstance(wanted, list):
            return lambda value: any(_same(value, choice) for choice in wanted), False
        return lambda value: _same(value, wanted), True


def _same(value: object, wanted: object) -> bool:
    """Whether a value is the wanted one, numbers to rounding."""
    if isinstance(value, float) and isinstance(wanted, (int, float)):
        return bool(np.isclose(value, wanted, rtol=1e-12, atol=1e-15))
    return json.dumps(value) == json.dumps(wanted)


def load_sweep(path: str | Path, plan: SweepPlan | None = None) -> Sweep:
    """Read what a store holds, finished or not.

    Parameters
    ----------
    path : str or Path
        The store, a file.
    plan : SweepPlan or None, optional
        With it, another plan's store is refused.

    Returns
    -------
    Sweep
        The points stored so far, in the plan's order.

    Raises
    ------
    DataFileError
        For a file that is absent, damaged or no store.
    InvalidInput
        For the store of another plan.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> from cyclemap.sweeps import PortraitNumbers, SweepPlan, load_sweep, run_sweep
    >>> turns = PortraitNumbers(("turns",))
    >>> plan = SweepPlan.grid("isotropic", {"push_mm": (100, 150)}, numbers=turns)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     status = run_sweep(plan, f"{folder}/sweep.sqlite", workers=1)
    ...     sweep = load_sweep(f"{folder}/sweep.sqlite")
    >>> np.degrees(sweep.values("mean_turn")).round(2).tolist()
    [2.77, 8.0]
    """
    import pandas

    with SweepStore(Path(path), plan) as store:
        description = store.description
        rows = list(store.rows())
    keys = tuple(description["keys"])
    quantities = tuple(Quantity(**column) for column in description["columns"])
    names = [quantity.name for quantity in quantities]
    table = pandas.DataFrame(rows, columns=["number", *keys, *names, REFUSAL])
    for quantity in quantities:
        values = table[quantity.name]
        if quantity.many:
            lists = [np.array(entries or (), dtype=float) for entries in values]
            table[quantity.name] = pandas.Series(lists, dtype=object)
        else:
            table[quantity.name] = values.astype(float)
    axes = description["plan"]["points"].get("axes", {})
    swept = tuple(SweepAxis(key, tuple(values)) for key, values in axes.items())
    return Sweep(keys, swept, quantities, table, description)


def write_csv(sweep: Sweep, path: str | Path) -> None:
    """Write a sweep as CSV, one line a point, in the plan's order.

    Parameters
    ----------
    sweep : Sweep
        What was found.
    path : str or Path
        The file to write, whole or not at all.

    Raises
    ------
    OSError
        Where it cannot be written.

    Notes
    -----
    Columns: the point's number, swept keys, quantities, lists spread out, refusal. The same points
    give the same bytes, however they were found.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from cyclemap.sweeps import PortraitNumbers, SweepPlan, load_sweep, run_sweep, write_csv
    >>> turns = PortraitNumbers(("turns",))
    >>> plan = SweepPlan.grid("isotropic", {"push_mm": (100, 150)}, numbers=turns)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     status = run_sweep(plan, f"{folder}/sweep.sqlite", workers=1)
    ...     write_csv(load_sweep(f"{folder}/sweep.sqlite"), f"{folder}/sweep.csv")
    ...     lines = Path(folder, "sweep.csv").read_text().splitlines()
    >>> len(lines), lines[0].split(",")[:2]
    (3, ['number', 'push_mm'])
    """
    import pandas

    columns: dict[str, object] = {"number": sweep.table["number"]}
    columns |= {key: sweep.table[key].map(_word) for key in sweep.keys}
    for quantity in sweep.quantities:
        if not quantity.many:
            columns[quantity.written_name] = quantity.written(sweep.table[quantity.name])
    for quantity in sweep.quantities:
        if quantity.many:
            for place, values in enumerate(_padded(sweep, quantity).T, 1):
                columns[f"{quantity.written_name}_{place}"] = values
    table = pandas.DataFrame({**columns, REFUSAL: sweep.table[REFUSAL]})
    text = table.to_csv(index=False, lineterminator="\n")
    write_whole(Path(path), text.encode())


def _word(value: object) -> str:
    return str(value) if isinstance(value, (float, str)) else json.dumps(value)


def _spread(sweep: Sweep, values: NDArray[Any], empty: object) -> NDArray[Any]:
    """What the points have, (n, ...), at their places on the grid; of a sample a copy."""
    if not sweep.axes:
        return values.copy()
    grid = np.full((*sweep.shape, *values.shape[1:]), empty, dtype=values.dtype)
    grid[sweep.places()] = values
    return grid


def _padded(sweep: Sweep, quantity: Quantity) -> Array:
    """The lists of the points as files have them, (n, longest), nan behind their ends."""
    lists = sweep.table[quantity.name]
    rows = np.full((len(lists), max(map(len, lists), default=0)), np.nan)
    for row, values in zip(rows, lists, strict=True):
        row[: len(values)] = values
    return quantity.written(rows)


def to_dataset(sweep: Sweep) -> xarray.Dataset:
    """Return a sweep as an xarray Dataset.

    Parameters
    ----------
    sweep : Sweep
        What was found.

    Returns
    -------
    xarray.Dataset
        A grid's dimensions are its swept keys, a sample's is `point`.

    Notes
    -----
    Each quantity is a variable with its unit and meaning as attributes; a list has one
    dimension more, as long as the longest, padded with nan, and a variable `NAME_count` of how
    many there are. `refusal` is text.

    Examples
    --------
    >>> import tempfile
    >>> from cyclemap.sweeps import PortraitNumbers, SweepPlan, load_sweep, run_sweep, to_dataset
    >>> turns = PortraitNumbers(("turns",))
    >>> plan = SweepPlan.grid("isotropic", {"push_mm": (100, 150)}, numbers=turns)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     status = run_sweep(plan, f"{folder}/sweep.sqlite", workers=1)
    ...     dataset = to_dataset(load_sweep(f"{folder}/sweep.sqlite"))
    >>> dict(dataset.sizes)
    {'push_mm': 2}
    """
    import xarray

    dimensions = tuple(axis.key for axis in sweep.axes) or ("point",)
    variables: dict[str, object] = {}
    for quantity in sweep.quantities:
        attributes = {"units": quantity.written_unit, "long_name": quantity.meaning}
        if not quantity.many:
            values = _spread(sweep, quantity.written(sweep.table[quantity.name]), np.nan)
            variables[quantity.written_name] = (dimensions, values, attributes)
            continue
        padded = _spread(sweep, _padded(sweep, quantity), np.nan)
        lengths = sweep.table[quantity.name].map(len).to_numpy(dtype=np.int64)
        count = _spread(sweep, lengths, 0)
        about = {
            "units": "1",
            "long_name": f"how many {quantity.many.replace('_', ' ')}s there are",
        }
        variables[quantity.written_name] = ((*dimensions, quantity.many), padded, attributes)
        variables[f"{quantity.many}_count"] = (dimensions, count, about)
    refusal = _spread(sweep, sweep.table[REFUSAL].to_numpy(dtype=object), "")
    variables[REFUSAL] = (dimensions, refusal, {"long_name": "why numbers are missing"})
    return xarray.Dataset(
        variables,
        _coordinates(sweep),
        {"title": "sweep", "plan": json.dumps(sweep.description["plan"])},
    )


def _coordinates(sweep: Sweep) -> dict[str, object]:
    listed = {axis.key: axis.values for axis in sweep.axes} or dict(sweep.table[[*sweep.keys]])
    coordinates: dict[str, object] = (
        {} if sweep.axes else {"point": (("point",), sweep.table["number"].to_numpy())}
    )
    for key, values in listed.items():
        numeric = all(isinstance(value, float) for value in values)
        array = (
            np.array(values, dtype=float)
            if numeric
            else np.array([_word(entry) for entry in values], dtype=object)
        )
        coordinates[key] = ((key if sweep.axes else "point",), array, {"units": key_unit(key)})
    return coordinates


def write_netcdf(sweep: Sweep, path: str | Path) -> None:
    """Write a sweep's `to_dataset` as a NetCDF-4 file.

    Parameters
    ----------
    sweep : Sweep
        What was found.
    path : str or Path
        The file to write, whole or not at all.

    Raises
    ------
    OSError
        Where it cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from cyclemap.sweeps import PortraitNumbers, SweepPlan, load_sweep, run_sweep, write_netcdf
    >>> turns = PortraitNumbers(("turns",))
    >>> plan = SweepPlan.grid("isotropic", {"push_mm": (100, 150)}, numbers=turns)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     status = run_sweep(plan, f"{folder}/sweep.sqlite", workers=1)
    ...     write_netcdf(load_sweep(f"{folder}/sweep.sqlite"), f"{folder}/sweep.nc")
    ...     Path(folder, "sweep.nc").is_file()
    True
    """
    with TemporaryDirectory() as folder:
        made = Path(folder) / "sweep.nc"
        to_dataset(sweep).to_netcdf(made, engine="h5netcdf")
        write_whole(Path(path), made.read_bytes())
