"""Where a plate rests on a floor when neither is flat."""

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, finite_number
from cyclemap.mechanics.engine.strokes import pressure_at, pressure_tables
from cyclemap.mechanics.foundation import PressedFootprint


def resting_pressure(footprint: PressedFootprint, theta: float, places: ArrayLike) -> Array:
    """Return the pressure under places of an object that rests on a floor.

    Parameters
    ----------
    footprint : PressedFootprint
        The shapes of plate and floor.
    theta : float
        Orientation of the object on the floor, rad.
    places : array_like, shape (..., 2)
        Places in the object's frame, m; they are not asked whether they lie under it.

    Returns
    -------
    ndarray, shape (...)
        Pressures in mean pressures, 0 where the object does not rest.

    Raises
    ------
    InvalidInput
        For what is not finite.

    Notes
    -----
    Good to 1e-10.

    Examples
    --------
    >>> import math
    >>> from cyclemap.mechanics import Polygon, PressedFootprint, SurfaceShape, resting_pressure
    >>> square = Polygon(((0.045, 0.045), (-0.045, 0.045), (-0.045, -0.045), (0.045, -0.045)))
    >>> trough = SurfaceShape(10.0, 10.0, math.pi / 2)
    >>> on_trough = PressedFootprint(square, floor=trough)
    >>> resting_pressure(on_trough, 0.0, [(0.0, 0.0), (0.0, 0.045)]).round(3).tolist()
    [0.0, 7.683]
    """
    at = finite_array("places", places, last=2)
    size, outline = footprint.extent, footprint.outline
    quadratic = pressure_at(pressure_tables(footprint), finite_number("theta", theta))
    level, slope_x, slope_y, xx, xy, yy = quadratic
    x, y = np.moveaxis((at - outline.centroid) / size, -1, 0)
    pressure = level + x * (slope_x + xx * x + 2.0 * xy * y) + y * (slope_y + yy * y)
    return np.asarray(np.maximum(pressure, 0.0) * outline.area / size**2)
