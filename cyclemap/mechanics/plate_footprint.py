"""How an object rests on a material: its plate's pressure, the shape of the floor, and where one
rests on the other.
"""

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, finite_number, require_kind
from cyclemap.mechanics.engine.strokes import pressure_at, pressure_tables
from cyclemap.mechanics.footprint import Footprint, PatchFootprint
from cyclemap.mechanics.foundation import (
    FLAT,
    FloorField,
    PressedFootprint,
    SurfaceShape,
    quadratic_at,
)
from cyclemap.mechanics.material import ANY_PLATE, Material, PlatePressure, stays_flat
from cyclemap.mechanics.material_text import built_in_plates
from cyclemap.mechanics.slider import Slider


def plate_footprint(material: Material, slider: Slider) -> Footprint | None:
    """Return how an object rests on a material: by its plate and the floor's shape.

    The plate goes by the object's name. One that the material does not know has the built-in shape
    on a floor that has one. None where neither is known.
    """
    known = known_plate(material, slider)
    shape = FLAT if known is None else known.shape
    if not (shape.is_flat and material.has_flat_floor):
        factor = 1.0 / mean_pressure(slider)
        return pressed_footprint(slider, shape, material.floor, material.field, factor)
    if known is None:
        return None
    return PatchFootprint(slider.outline, **known.shares, centre=slider.centre_of_mass)


def known_plate(material: Material, slider: Slider) -> PlatePressure | None:
    """Return what is known of an object's plate: by the material, else built in.

    Built-in plates are asked only where the material's floor has a shape, or wears to one.
    """
    built_in = () if stays_flat(material) else built_in_plates()
    for plate in (*material.plates, *built_in):
        if plate.plate == slider.name:
            return plate
    return material.pressure_of(ANY_PLATE)


def plate_note(material: Material, slider: Slider) -> str:
    """Return a sentence on an object that the material does not know.

    Empty where it does, or knows of no object.

    >>> from dataclasses import replace
    >>> from cyclemap.mechanics import PlatePressure, Slider, load_material
    >>> slate = replace(load_material("plywood"), name="slate", plates=(PlatePressure("hex"),))
    >>> plate_note(slate, Slider.mit("rect1"))
    'rect1 was never seen on slate: a flat plate is taken'
    """
    known = known_plate(material, slider)
    knows_shapes = material.plates or known is not None or not material.has_flat_floor
    if material.pressure_of(slider.name) is not None or not knows_shapes:
        return ""
    taken = "a flat plate is taken"
    if known is not None:
        taken = "its built-in shape, found on other floors, is taken"
    return f"{slider.name} was never seen on {material.name}: {taken}"


def mean_pressure(slider: Slider) -> float:
    """Return an object's weight over the area of its outline, kPa."""
    return 1e-3 * slider.weight / slider.outline.area


def pressed_footprint(
    slider: Slider,
    plate: SurfaceShape,
    floor: SurfaceShape,
    field: FloorField | None,
    factor: float,
) -> PressedFootprint:
    """Return how an object rests on shapes.

    factor : from the unit that the shapes are told in to the object's own mean pressures.
    """
    varying = None if field is None else field.scaled(factor)
    plate, floor = plate.scaled(factor), floor.scaled(factor)
    return PressedFootprint(slider.outline, plate, floor, slider.centre_of_mass, varying)


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
        For another footprint, and for what is not finite.

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
    require_kind("footprint", footprint, PressedFootprint)
    at = finite_array("places", places, last=2)
    size, outline = footprint.extent, footprint.outline
    quadratic = pressure_at(pressure_tables(footprint), finite_number("theta", theta))
    x, y = np.moveaxis((at - outline.centroid) / size, -1, 0)
    pressure = quadratic_at(quadratic, x, y)
    return np.asarray(np.maximum(pressure, 0.0) * outline.area / size**2)
