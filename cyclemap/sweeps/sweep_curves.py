"""What a picture of a sweep shows: planes over two keys, lines over one, every number of them
worked out here.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.errors import InvalidInput
from cyclemap.maps import RotationNumbers, RotationPlane
from cyclemap.sweeps.point_sets import SweepAxis
from cyclemap.sweeps.portrait_numbers import Quantity
from cyclemap.sweeps.sweep_results import Sweep


@dataclass(frozen=True, eq=False)
class SweptPlane:
    """A grid over two keys.

    Attributes
    ----------
    first, second : SweepAxis
        The axes of rows and columns.
    planes : tuple of tuple[Quantity, ndarray]
        Quantities with their values (m, n), angles in degrees, nan where there is none.
    rotation : RotationPlane or None
        The rotation numbers, where they were asked for.
    refused : ndarray of bool, shape (m, n)
        Where points were refused.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.sweeps import SweepAxis, SweptPlane
    >>> axes = SweepAxis("mu_a", (0.2, 0.3)), SweepAxis("mu_b", (0.2, 0.3))
    >>> plane = SweptPlane(*axes, (), None, np.zeros((2, 2), dtype=bool))
    >>> plane.first.values, plane.refused.tolist()
    ((0.2, 0.3), [[False, False], [False, False]])
    """

    first: SweepAxis
    second: SweepAxis
    planes: tuple[tuple[Quantity, Array], ...]
    rotation: RotationPlane | None
    refused: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class SweptLines:
    """Points over one key.

    Attributes
    ----------
    axis : SweepAxis
        The key with the values that are here, in order.
    parameter : ndarray, shape (n,)
        The values, or 0, 1, ... where they are no numbers.
    lines : tuple[tuple[Quantity, ndarray], ...]
        Quantities with their values (n,), angles in degrees.
    rotation_at : ndarray, shape (k,)
        Where on the axis the points are that have a rotation number.
    rotation : RotationNumbers or None
        The rotation numbers at `rotation_at`; None where there is none.
    points : tuple of three ndarrays, shape (p,), or None
        Of each fixed point, where on the axis, its direction in degrees, whether it is stable;
        None where they were not asked for.
    refused : ndarray, shape (r,)
        Where on the axis points were refused.

    Examples
    --------
    >>> import tempfile
    >>> from cyclemap.sweeps import PortraitNumbers, SweepPlan, load_sweep, run_sweep, sweep_curves
    >>> turns = PortraitNumbers(("turns",))
    >>> plan = SweepPlan.grid("isotropic", {"push_mm": (100, 150)}, numbers=turns)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     status = run_sweep(plan, f"{folder}/sweep.sqlite", workers=1)
    ...     lines = sweep_curves(load_sweep(f"{folder}/sweep.sqlite"), ("mean_turn",))
    >>> lines.parameter.tolist(), lines.lines[0][1].round(2).tolist()
    ([100.0, 150.0], [2.77, 8.0])
    """

    axis: SweepAxis
    parameter: Array
    lines: tuple[tuple[Quantity, Array], ...]
    rotation_at: Array
    rotation: RotationNumbers | None
    points: tuple[Array, Array, NDArray[np.bool_]] | None
    refused: Array


@dataclass(frozen=True, eq=False)
class SweptScatter:
    """A sample over two keys.

    Attributes
    ----------
    first : tuple[str, ndarray]
        Name of the first key, and its values (n,).
    second : tuple[str, ndarray]
        Name of the second key, and its values (n,).
    values : tuple of tuple[Quantity, ndarray]
        Quantities with their values (n,), angles in degrees.
    refused : ndarray of bool, shape (n,)
        Which points were refused.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.sweeps import SweptScatter
    >>> places = np.array([0.2, 0.3])
    >>> scatter = SweptScatter(("mu_a", places), ("mu_b", places), (), places > 1.0)
    >>> scatter.first[0], scatter.refused.tolist()
    ('mu_a', [False, False])
    """

    first: tuple[str, Array]
    second: tuple[str, Array]
    values: tuple[tuple[Quantity, Array], ...]
    refused: NDArray[np.bool_]


SweptCurves = SweptPlane | SweptLines | SweptScatter
_ROTATION = ("rotation", "rotation_lower", "rotation_upper", "locked_period", "locked_winding")


def sweep_curves(sweep: Sweep, names: tuple[str, ...] = ()) -> SweptCurves:
    """Return what can be drawn of a sweep over one key or two.

    Parameters
    ----------
    sweep : Sweep
        What was found.
    names : tuple of str, default ()
        Which quantities; (): those that are there.

    Returns
    -------
    SweptLines, SweptPlane or SweptScatter
        Of one key, of a grid over two, of a sample over two.

    Raises
    ------
    InvalidInput
        For more keys (select values of the others first), a sample of keys that are no numbers,
        a quantity that was not asked for, or a sweep without points.

    Examples
    --------
    >>> import tempfile
    >>> from cyclemap.sweeps import PortraitNumbers, SweepPlan, load_sweep, run_sweep, sweep_curves
    >>> over = {"push_mm": (100, 150), "pusher_mu": (0.1, 0.2)}
    >>> plan = SweepPlan.grid("isotropic", over, numbers=PortraitNumbers(("turns",)))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     status = run_sweep(plan, f"{folder}/sweep.sqlite", workers=1)
    ...     plane = sweep_curves(load_sweep(f"{folder}/sweep.sqlite"), ("mean_turn",))
    >>> plane.first.key, plane.planes[0][1].round(1).tolist()
    ('push_mm', [[2.3, 3.1], [7.6, 8.2]])
    """
    if not len(sweep):
        raise InvalidInput("no point of this sweep is stored: there is nothing to draw")
    keys = tuple(axis.key for axis in sweep.axes) or sweep.keys
    if len(keys) == 1:
        return _lines(sweep, keys[0], names)
    if len(keys) == 2 and sweep.axes:
        return _plane(sweep, names)
    if len(keys) == 2:
        first, second = ((key, sweep.values(key)) for key in keys)
        return SweptScatter(first, second, _chosen(sweep, names), sweep.refused)
    raise InvalidInput(
        f"{len(keys)} keys are swept ({', '.join(keys)}): select values of all but two to draw them"
    )


def _chosen(sweep: Sweep, names: tuple[str, ...]) -> tuple[tuple[Quantity, Array], ...]:
    """Quantities with their values as they are written; by default the rotation number and the
    stable points.
    """
    told = names or tuple(name for name in ("rotation", "stable_points") if name in sweep.columns)
    chosen = [sweep.quantity(name) for name in told or tuple(sweep.columns)[:2]]
    listed = next((quantity.name for quantity in chosen if quantity.many), None)
    if listed is not None:
        raise InvalidInput(f"{listed} is a list at each point: draw a quantity that is one number")
    return tuple((quantity, quantity.written(sweep.columns[quantity.name])) for quantity in chosen)


def _plane(sweep: Sweep, names: tuple[str, ...]) -> SweptPlane:
    planes = tuple(
        (quantity, quantity.written(sweep.on_grid(quantity.name)))
        for quantity, _ in _chosen(sweep, names)
    )
    refused = np.zeros(sweep.shape, dtype=bool)
    refused[sweep.places()] = sweep.refused
    rotation = None
    if "rotation" in sweep.columns:
        value, lower, upper, periods, windings = (sweep.on_grid(name) for name in _ROTATION)
        period, winding = (np.nan_to_num(found).astype(int) for found in (periods, windings))
        # Whether a map folds is told by its least slope, where that was asked for.
        folded = (
            sweep.on_grid("min_slope") < 0.0
            if "min_slope" in sweep.columns
            else np.zeros(sweep.shape, dtype=bool)
        )
        first, second = (axis_places(axis) for axis in sweep.axes)
        rotation = RotationPlane(first, second, value, lower, upper, period, winding, folded, 0.0)
    return SweptPlane(sweep.axes[0], sweep.axes[1], planes, rotation, refused)


def axis_places(axis: SweepAxis) -> Array:
    """Where the values of an axis stand: the numbers themselves, or 0, 1, 2, ...
    for anything else."""
    return (
        np.array(axis.values, dtype=float) if axis.is_number else np.arange(float(len(axis.values)))
    )


def _lines(sweep: Sweep, key: str, names: tuple[str, ...]) -> SweptLines:
    """Points in the order of the axis; a sample's are put in the order of their values."""
    # Numbers by size, then words.
    values = sorted(
        set(sweep.swept[key]),
        key=lambda one: (0, one, "") if isinstance(one, float) else (1, 0.0, str(one)),
    )
    axis = sweep.axes[0] if sweep.axes else SweepAxis(key, tuple(values))
    (place,) = replace(sweep, axes=(axis,)).places()
    parameter = axis_places(axis)[place]
    order = np.argsort(parameter, kind="stable")
    lines = tuple((one, values[order]) for one, values in _chosen(sweep, names))
    refused = parameter[sweep.refused]
    rotation_at, rotation, points = np.empty(0), None, None
    told = (
        order[np.isfinite(sweep.columns["rotation"][order])]
        if "rotation" in sweep.columns
        else order[:0]
    )
    if told.size:
        value, lower, upper, period, winding = (sweep.columns[name][told] for name in _ROTATION)
        rotation_at = parameter[told]
        rotation = RotationNumbers(
            value, lower, upper, period.astype(int), winding.astype(int), 0.0
        )
    if "fixed_point_theta" in sweep.lists:
        theta, stable = sweep.lists["fixed_point_theta"], sweep.lists["fixed_point_stable"]
        at = np.repeat(parameter, [values.size for values in theta])
        points = at, np.degrees(np.concatenate(theta)), np.concatenate(stable) == 1.0
    return SweptLines(axis, parameter[order], lines, rotation_at, rotation, points, refused)
