"""A loop as the settings of a protocol file: the robot's side of it; the surface is named by itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal

import numpy as np

from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.settings import OWN_OUTLINE
from cyclemap.errors import InvalidInput
from cyclemap.file_text import DEGREES, MILLIMETRES, Unit
from cyclemap.mechanics import (
    Ellipse,
    PatchFootprint,
    PointFootprint,
    Polygon,
    Slider,
    parse_footprint,
)
from cyclemap.mechanics.slider import MIT_SHAPE_NAMES

Table = dict[str, object]

# A loop read back may differ by rounding: settings are doubles in millimetres and degrees.
_ROUNDING = 1e-12
_LARGEST_GRID = 64


def loop_tables(loop: CollectionLoop) -> dict[str, Table]:
    """Return the settings that make of `CollectionLoop.mit(loop.material)` this loop, in tables by their part.

    Object, push and rod are always told, and of an object that is not MIT's its mass, its ring and the rod's friction,
    too. What a material brings along (friction of rod and ring, the ring's lever, the pressure) is else told only where
    the loop has it otherwise, so that another material brings its own. Not told: the friction of the surface, the
    accuracy, and the moment of inertia of an outline that is not MIT's.

    Raises InvalidInput for what no setting can say: support points that are neither corners nor a grid.

    >>> tables = loop_tables(CollectionLoop.mit())
    >>> tables["push"]["side"], str(tables["push"]["push_mm"]), sorted(tables)
    (0, '150.0', ['object', 'push'])
    """
    base = CollectionLoop.mit(loop.material)
    shape = _shape(loop.slider, base.slider)
    own = "shape" not in shape
    # An own object's ring is told in any case: MIT's would lie beside it.
    ring = _ring(loop.slider, base.slider, own) if own else {}
    start = CollectionLoop.from_settings(_plain({**shape, **ring}), base)
    tables = {
        "object": {**shape, **_object(loop.slider, start.slider, own), **_footprint(loop, start)},
        "push": _push(loop, start, own),
        "reset": {**_ring(loop.slider, start.slider, own), **_reset(loop, start)},
    }
    settings = {key: value for table in tables.values() for key, value in table.items()}
    _refuse_what_is_lost(loop, CollectionLoop.from_settings(_plain(settings), base))
    return {name: table for name, table in tables.items() if table}


def _plain(settings: Table) -> Table:
    """The settings as a file gives them to a loop: doubles for decimals."""
    return {key: plain_numbers(value) for key, value in settings.items()}


def plain_numbers(value: object) -> object:
    """Return a value of a file with doubles in place of decimals."""
    if isinstance(value, list):
        return [plain_numbers(part) for part in value]
    return float(value) if isinstance(value, Decimal) else value


def _setting(unit: Unit, value: float) -> Decimal:
    """The double that, read as a setting, comes nearest to a value in SI units."""
    convert: Callable[[float], float] = math.radians if unit is DEGREES else lambda number: number * 1e-3
    middle = float(unit.written(value))
    tried = (middle, math.nextafter(middle, math.inf), math.nextafter(middle, -math.inf))
    return Decimal(repr(min(tried, key=lambda number: abs(convert(number) - value))))


def _shape(slider: Slider, base: Slider) -> Table:
    for shape in MIT_SHAPE_NAMES:
        if Slider.mit(shape).outline == slider.outline:
            return {"shape": shape}
    name: Table = {} if slider.name == OWN_OUTLINE else {"object_name": slider.name}
    if isinstance(slider.outline, Ellipse):
        semi_axes = {"semi_x_mm": slider.outline.semi_x, "semi_y_mm": slider.outline.semi_y}
        return {key: _setting(MILLIMETRES, value) for key, value in semi_axes.items()} | name
    assert isinstance(slider.outline, Polygon)
    vertices = [[_setting(MILLIMETRES, x) for x in vertex] for vertex in slider.outline.array.tolist()]
    return {"vertices_mm": vertices} | name


def _object(slider: Slider, start: Slider, own: bool) -> Table:
    told: Table = {"mass_kg": slider.mass} if own or slider.mass != start.mass else {}
    for key, value, before in zip(
        ("centre_x_mm", "centre_y_mm"), slider.centre_of_mass, start.centre_of_mass, strict=True
    ):
        if not _same(value, before):
            told[key] = _setting(MILLIMETRES, value)
    return told


def _ring(slider: Slider, start: Slider, own: bool) -> Table:
    if not own and _same(slider.hitch, start.hitch):
        return {}
    keys = ("hitch_x_mm", "hitch_y_mm")
    return {key: _setting(MILLIMETRES, value) for key, value in zip(keys, slider.hitch, strict=True)}


def _push(loop: CollectionLoop, start: CollectionLoop, own: bool) -> Table:
    push, rod = loop.push, loop.pusher
    told: Table = {
        "side": push.side,
        "fraction": push.fraction,
        "angle_deg": _setting(DEGREES, push.angle),
        "push_mm": _setting(MILLIMETRES, push.distance),
        "pusher_radius_mm": _setting(MILLIMETRES, rod.radius),
    }
    return {**told, "pusher_mu": rod.friction} if own or rod.friction != start.pusher.friction else told


def _reset(loop: CollectionLoop, start: CollectionLoop) -> Table:
    reset = loop.reset
    told: Table = {}
    if reset.way_points:
        told["way_points_mm"] = [[MILLIMETRES.written(part) for part in place] for place in reset.way_points]
    if reset.pin_friction_radius == start.reset.pin_friction_radius:
        return told
    return {**told, "pin_friction_mm": _setting(MILLIMETRES, reset.pin_friction_radius)}


_SHARES = ("inner_share", "rim_share", "corner_share")


def _footprint(loop: CollectionLoop, start: CollectionLoop) -> Table:
    found = loop.footprint
    if _same_footprint(found, start.footprint):
        return {}
    if found is None:
        return {"footprint": "exact"}
    if isinstance(found, PatchFootprint):
        return {"footprint": "exact", **{name: getattr(found, name) for name in _SHARES}}
    return {"footprint": _support_name(found, loop.slider)}


def _support_name(found: PointFootprint, slider: Slider) -> str:
    names = ["corners"] if isinstance(slider.outline, Polygon) else []
    for name in (*names, *(f"grid:{count}" for count in range(2, _LARGEST_GRID + 1))):
        if _same_footprint(found, parse_footprint(name, slider.outline)):
            return name
    raise InvalidInput(
        f"{len(found.positions)} support points are neither corners nor a grid: a protocol names them by their CSV "
        "file; write it without them, and add footprint = FILE.csv by hand"
    )


def _same_footprint(one: object, other: object) -> bool:
    if isinstance(one, PointFootprint) and isinstance(other, PointFootprint):
        return _same(one.positions, other.positions) and _same(one.weights, other.weights)
    if isinstance(one, PatchFootprint) and isinstance(other, PatchFootprint):
        alike = all(_same(getattr(one, name), getattr(other, name)) for name in _SHARES)
        return alike and bool(np.allclose(one.gradient, other.gradient, rtol=1e-9, atol=1e-9))
    return one is None and other is None


def _same(one: object, other: object) -> bool:
    a, b = np.asarray(one, dtype=float), np.asarray(other, dtype=float)
    return a.shape == b.shape and bool(np.all(np.abs(a - b) <= _ROUNDING))


def _refuse_what_is_lost(loop: CollectionLoop, found: CollectionLoop) -> None:
    """Raise InvalidInput where the settings, read back, do not give the loop."""
    pairs = {
        "outline": (_corners(loop.slider), _corners(found.slider)),
        "mass": (loop.slider.mass, found.slider.mass),
        "centre of mass": (loop.slider.centre_of_mass, found.slider.centre_of_mass),
        "ring": (loop.slider.hitch, found.slider.hitch),
        "rod": ((loop.pusher.radius, loop.pusher.friction), (found.pusher.radius, found.pusher.friction)),
        "push": (_numbers(loop), _numbers(found)),
        "way-points": (loop.reset.way_points, found.reset.way_points),
        "friction of the ring": (loop.reset.pin_friction_radius, found.reset.pin_friction_radius),
    }
    lost = [name for name, (given, read) in pairs.items() if not _same(given, read)]
    lost += [] if _same_footprint(_leaning(loop), _leaning(found)) else ["footprint"]
    if lost:
        raise InvalidInput(f"no setting of a protocol file can say the loop's {', '.join(lost)}: leave that as it was")


def _leaning(loop: CollectionLoop) -> object:
    """The footprint; one that is left to the centre of mass as what it comes to."""
    return loop.footprint or PatchFootprint(loop.slider.outline, centre=loop.slider.centre_of_mass)


def _corners(slider: Slider) -> object:
    return replace(slider, hitch=(0.0, 0.0)).outline_points(8)


def _numbers(loop: CollectionLoop) -> tuple[float, ...]:
    return float(loop.push.side), loop.push.fraction, loop.push.angle, loop.push.distance
