"""Foundations that are pressed: plates and floors that are not flat, one resting on the other."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field as made
from types import NoneType
from typing import Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import (
    finite_array,
    finite_number,
    positive_number,
    read_only,
    require_kind,
)
from cyclemap.errors import InvalidInput
from cyclemap.mechanics.outline import Ellipse, Outline, Polygon, resting_centre

# Shapes are told in mean pressures at this distance from the centroid, m.
SHAPE_RADIUS = 0.05
# A foundation that is this stiff is rigid: three points or more carry all.
_STIFFEST = 1000.0
# Outlines of more corners are curves that want an ellipse, or fewer corners.
_MOST_SIDES = 200


@dataclass(frozen=True)
class SurfaceShape:
    """How far the underside of a plate, or a floor, is from flat, as the pressure that it adds.

    q = dome r^2 + bow r^2 cos 2(angle - axis), r and angle those of a place seen from the object's
    centroid, r in 50 mm, q in mean pressures: where the plate presses harder, or the floor is
    higher. A trough along x, high along y, q = 20 y^2, is dome 10, bow 10, axis 90 degrees.

    Parameters
    ----------
    dome : float, default 0.0
        Bends alike in all directions; positive: rests on the rim.
    bow : float, default 0.0
        Bends one way along the axis and the other across it.
    axis : float, default 0.0
        Direction of the bow, rad: of a plate in its own frame, of a floor in the world's.
        Shapes whose axis differs by half a turn are the same.

    Raises
    ------
    InvalidInput
        For what is not finite, or a dome or bow beyond 1000, where a foundation is rigid.

    Examples
    --------
    >>> import math
    >>> from cyclemap.mechanics import SurfaceShape
    >>> SurfaceShape(dome=10.0, bow=10.0, axis=math.pi / 2).bend.round(9).tolist()
    [10.0, -10.0, 0.0]
    """

    dome: float = 0.0
    bow: float = 0.0
    axis: float = 0.0

    def __post_init__(self) -> None:
        for name in ("dome", "bow", "axis"):
            vars(self)[name] = finite_number(name, getattr(self, name))
        if max(abs(self.dome), abs(self.bow)) > _STIFFEST:
            raise InvalidInput(
                f"a dome of {self.dome:g} and a bow of {self.bow:g} at 50 mm: beyond {_STIFFEST:g} "
                "a foundation is rigid; choose less"
            )

    @classmethod
    def of_bend(cls, dome: float, bow_x: float, bow_y: float) -> "SurfaceShape":
        """Return the shape q = dome r^2 + bow_x (x^2 - y^2) + 2 bow_y x y, its axis in [0, pi).

        >>> import math
        >>> from cyclemap.mechanics import SurfaceShape
        >>> shape = SurfaceShape.of_bend(0.0, 0.0, 2.0)
        >>> shape.bow, round(math.degrees(shape.axis), 9)
        (2.0, 45.0)
        """
        return cls(dome, math.hypot(bow_x, bow_y), 0.5 * math.atan2(bow_y, bow_x) % math.pi)

    @property
    def bend(self) -> Array:
        """dome, bow cos 2 axis and bow sin 2 axis, (3,)."""
        c, s = math.cos(2.0 * self.axis), math.sin(2.0 * self.axis)
        return np.array((self.dome, self.bow * c, self.bow * s))

    @property
    def is_flat(self) -> bool:
        """Whether there is no shape at all."""
        return self.dome == 0.0 and self.bow == 0.0

    def scaled(self, factor: float) -> "SurfaceShape":
        """Return the shape in units that are smaller by a factor."""
        return SurfaceShape(factor * self.dome, factor * self.bow, self.axis)


FLAT = SurfaceShape()


@dataclass(frozen=True)
class FloorField:
    """How a floor's shape varies with the place of the object's centroid.

    Parameters
    ----------
    coefficients : array_like, shape (3, 5)
        Of dome, bow cos 2 axis and bow sin 2 axis by X, Y, X^2, X Y, Y^2, with X, Y from the
        world's origin (the reset's target) in 50 mm, in the units of the shape.
    reach : float
        m, positive; beyond it the shape stays what it is at that distance.

    Raises
    ------
    InvalidInput
        For another shape of the coefficients, values that are not finite, and a reach that is
        not positive.

    Notes
    -----
    The shape is taken once a stroke: a quarter of the rod's way ahead of where a push begins,
    since an object goes about half as far as the rod, and midway of each leg of a drag.

    Examples
    --------
    >>> from cyclemap.mechanics import FloorField
    >>> field = FloorField(((1.0, 0, 0, 0, 0), (0, 0, 0, 0, 2.0), (0, 0, 0, 0, 0)), reach=0.2)
    >>> field.bend_at((0.05, 0.1)).tolist()
    [1.0, 8.0, 0.0]
    """

    coefficients: tuple[tuple[float, ...], ...]
    reach: float

    def __post_init__(self) -> None:
        array = finite_array("coefficients of a floor's field", self.coefficients, last=5, ndim=2)
        if len(array) != 3:
            raise InvalidInput(
                f"coefficients of a floor's field have {len(array)} rows: give three, of its dome "
                "and both components of its bow"
            )
        reach = positive_number("reach of a floor's field", self.reach)
        vars(self).update(coefficients=tuple(map(tuple, array.tolist())), reach=reach)

    def terms_at(self, place: tuple[float, float]) -> Array:
        """Return X, Y, X^2, X Y, Y^2 (5,) at a place (x, y), m."""
        away = math.hypot(*place)
        share = self.reach / away if away > self.reach else 1.0
        x, y = (share * value / SHAPE_RADIUS for value in place)
        return np.array((x, y, x * x, x * y, y * y))

    def bend_at(self, place: tuple[float, float]) -> Array:
        """Return what is added to dome, bow cos 2 axis and bow sin 2 axis at a place (x, y), m."""
        return np.asarray(np.array(self.coefficients) @ self.terms_at(place))

    def scaled(self, factor: float) -> "FloorField":
        """Return the field in units that are smaller by a factor."""
        scaled = factor * np.array(self.coefficients)
        return FloorField(tuple(map(tuple, scaled.tolist())), self.reach)


def quadratic_at(numbers: Iterable[Any], x: Any, y: Any) -> Any:
    """Return a quadratic of the plane, of numbers level, slopes, xx, xy and yy, at places: in NumPy
    or CasADi.
    """
    level, slope_x, slope_y, xx, xy, yy = numbers
    return level + x * (slope_x + xx * x + 2.0 * xy * y) + y * (slope_y + yy * y)


@dataclass(frozen=True)
class PressedFootprint:
    """Pressure of a plate that is not flat on a floor that is not flat, which give way alike.

    The weight rests where both come nearest: p = max(0, c + l . x + q_plate + q_floor), x off the
    outline's centroid, q_plate fixed to the plate, q_floor to the world, against which the plate
    turns; c and l by the balance of load and moment (a foundation that is pressed; Winkler 1867).

    Parameters
    ----------
    outline : Polygon or Ellipse
        What may touch the ground.
    plate : SurfaceShape, optional
        Shape of the plate, in mean pressures.
    floor : SurfaceShape, optional
        Shape of the floor, in mean pressures.
    centre : tuple[float, float], optional
        Centre of mass, (x, y), m; None: the centroid.
    field : FloorField or None, optional
        How the floor's shape varies with the place, `floor` being that at the world's origin;
        None: not.

    Attributes
    ----------
    extent : float
        Largest distance of the outline from its centroid, m.
    bend_unit : float
        What turns numbers of a shape into the engine's units: per unit load, lengths in
        extents.
    plate_bend : ndarray, shape (3,)
        The plate's shape as the engine has it.
    floor_bend : ndarray, shape (3,)
        The floor's shape as the engine has it.
    field_bend : ndarray, shape (3, 5)
        The field as the engine has it.

    Raises
    ------
    InvalidInput
        For support points, which have no area, shapes that are none, a centre outside the
        outline's convex hull, where the object would tip, and an outline of too many corners; on
        first use where no balance is found.

    Notes
    -----
    Load and moments balance to 1e-11 of the load, plus 2e-12 times the shapes' numbers.

    References
    ----------
    Winkler, E. (1867), Die Lehre von der Elasticitaet und Festigkeit, Prague.

    Examples
    --------
    >>> import math
    >>> from cyclemap.mechanics import Polygon, PressedFootprint, SurfaceShape
    >>> square = Polygon(((0.045, 0.045), (-0.045, 0.045), (-0.045, -0.045), (0.045, -0.045)))
    >>> footprint = PressedFootprint(square, floor=SurfaceShape(10.0, 10.0, math.pi / 2))
    >>> footprint.extent  # doctest: +ELLIPSIS
    0.0636...
    """

    outline: Outline
    plate: SurfaceShape = FLAT
    floor: SurfaceShape = FLAT
    centre: tuple[float, float] = None  # type: ignore[assignment]  # filled in below
    field: FloorField | None = None
    extent: float = made(init=False, repr=False, compare=False)
    bend_unit: float = made(init=False, repr=False, compare=False)
    plate_bend: Array = made(init=False, repr=False, compare=False)
    floor_bend: Array = made(init=False, repr=False, compare=False)
    field_bend: Array = made(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        outline = self.outline
        if not isinstance(outline, (Polygon, Ellipse)):
            raise InvalidInput(
                "shapes of plate and floor press an outline, not support points: leave out the "
                "points, or the shapes"
            )
        require_kind("shape of the plate", self.plate, SurfaceShape)
        require_kind("shape of the floor", self.floor, SurfaceShape)
        require_kind("field of the floor", self.field, FloorField, NoneType)
        centre = resting_centre(outline, self.centre)
        if isinstance(outline, Polygon) and outline.sides > _MOST_SIDES:
            raise InvalidInput(
                f"an outline of {outline.sides} corners: shapes of plate and floor take "
                f"{_MOST_SIDES} at most; simplify it, or leave plate and floor flat"
            )
        size = outline.extent
        unit = (size / SHAPE_RADIUS) ** 2 * size**2 / outline.area
        coefficients = np.zeros((3, 5)) if self.field is None else np.array(self.field.coefficients)
        powers = np.array((1, 1, 2, 2, 2))
        vars(self).update(
            centre=centre,
            extent=size,
            bend_unit=unit,
            plate_bend=read_only(unit * self.plate.bend),
            floor_bend=read_only(unit * self.floor.bend),
            field_bend=read_only(unit * coefficients * (size / SHAPE_RADIUS) ** powers),
        )

    def is_near(self, other: "PressedFootprint") -> bool:
        """Whether shapes, field and centre of another footprint are the same, but for rounding."""
        mine, theirs = (
            np.concatenate([each.plate_bend, each.floor_bend, each.field_bend.ravel(), each.centre])
            for each in (self, other)
        )
        reaches = {each.field and each.field.reach for each in (self, other)}
        return len(reaches) == 1 and bool(np.allclose(mine, theirs, rtol=1e-12, atol=1e-12))
