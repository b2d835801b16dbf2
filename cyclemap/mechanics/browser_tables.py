"""What the engine reads of a loop, written for a browser: its WebAssembly has addresses of four
bytes.

What sliders move is told apart from what they leave: the page fills in the rest of a loop's record,
as `QuasiStaticModel.cycle_strokes` does.
"""

import base64
from importlib import resources
from typing import Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.errors import CycleMapError
from cyclemap.mechanics.contact_curve import SidePiece
from cyclemap.mechanics.engine.columns import places_in
from cyclemap.mechanics.engine.parts import PARTS
from cyclemap.mechanics.engine.schema import (
    BALANCE,
    LOOP,
    PIECE,
    RECORD,
    RESULT,
    TASK,
    Status,
)
from cyclemap.mechanics.engine.strokes import (
    BALANCE_ROWS,
    PressureTables,
    piece_table,
    pressure_tables,
)
from cyclemap.mechanics.footprint import Footprint, PatchFootprint, PointFootprint
from cyclemap.mechanics.foundation import FLAT, PressedFootprint, SurfaceShape
from cyclemap.mechanics.outline import Ellipse, Outline
from cyclemap.mechanics.quasi_static import STEP_SHARE, QuasiStaticModel
from cyclemap.mechanics.slider import DragBack

_ADDRESS = np.dtype("u4")
# Orientations at which the least pressure of a patch is looked for.
_AROUND = 720
# Of a pressure's record, the addresses of its tables.
_TABLES = ("rows", "nodes", "outline", "table")


def wasm_engine() -> bytes:
    """The engine as WebAssembly, gzipped, made from its sources by `run.py wheels browser`."""
    return resources.files("cyclemap.mechanics.engine").joinpath("engine.wasm.gz").read_bytes()


def browser_tables(model: QuasiStaticModel, reset: DragBack) -> dict[str, Any]:
    """Return a loop's tables as JSON can hold them, and how C lays out what is passed.

    Numbers that may be infinite are packed (`packed_numbers`). Of them:

    layout : of a loop's record, byte and kind of each field; size.
    columns : places in rows of results, records, tasks and pieces.
    pieces : of the contact curve; sides : of each side that a rod may touch, piece, range and
        normal; lengths : of all sides, in extents; semi_axes : of an ellipse.
    parts, pressed : the pressure as shares of the load, and as shapes of plate and floor, None
        where the footprint cannot have them.
    """
    outline, unit, layout = model.slider.outline, model.unit, LOOP.laid_out(_ADDRESS)
    hitch_x, hitch_y = model.slider.hitch
    sides = [
        {
            "side": piece.side,
            "piece": index,
            "low": piece.low,
            "high": piece.high,
            "normal": piece.normal,
        }
        for index, piece in enumerate(model.curve.pieces)
        if isinstance(piece, SidePiece)
    ]
    goals = np.ravel((*reset.way_points, (0.0, 0.0))) / unit
    return {
        "layout": {"fields": places_in(layout), "size": layout.itemsize},
        "columns": {
            name: {"size": columns.size, **{key: columns.at(key) for key in columns.names}}
            for name, columns in (
                ("result", RESULT),
                ("record", RECORD),
                ("task", TASK),
                ("piece", PIECE),
            )
        },
        "status": {status.name: status.value for status in Status},
        "step_share": STEP_SHARE,
        "unit": unit,
        "centre": [coordinate / unit for coordinate in model.pressure.centre],
        "pieces": packed_numbers(piece_table(model.curve, (hitch_x / unit, hitch_y / unit))),
        "sides": sides,
        **_outline(outline, unit),
        "goals": packed_numbers(goals),
        "pin_friction": reset.pin_friction_radius / unit,
        "parts": _parts(model),
        "pressed": _pressed(model),
    }


def packed_numbers(table: Array) -> str:
    """Numbers as base64 of eight bytes each, the low ones first: JSON has no infinity."""
    return base64.b64encode(np.ascontiguousarray(table, dtype="<f8").tobytes()).decode()


def _outline(outline: Outline, unit: float) -> dict[str, Any]:
    """Lengths of sides, or half axes, in extents."""
    if isinstance(outline, Ellipse):
        semi_axes = [outline.semi_x / unit, outline.semi_y / unit]
        return {"lengths": None, "semi_axes": semi_axes, "is_convex": True}
    along = np.roll(outline.array, -1, axis=0) - outline.array
    lengths = (np.hypot(*along.T) / unit).tolist()
    return {"lengths": lengths, "semi_axes": None, "is_convex": outline.is_convex}


def _parts(model: QuasiStaticModel) -> dict[str, Any]:
    """The pressure by shares; what leans asks for a least even share, by which they are refused."""
    footprint = model.pressure
    if isinstance(footprint, PressedFootprint):
        footprint = PatchFootprint(footprint.outline, centre=footprint.centre)
    table = _record(pressure_tables(footprint)) | {"shares": [part.share for part in PARTS]}
    if isinstance(footprint, PointFootprint):
        return table | {"can_share": False}
    lean = (footprint.outline.points(_AROUND) - footprint.outline.centroid) @ np.array(
        footprint.gradient
    )
    return table | {
        "can_share": True,
        "can_frame": footprint.has_frame,
        "can_corner": not isinstance(footprint.outline, Ellipse) and not np.any(footprint.balance),
        "least_even": float(max(0.0, -lean.min())),
    }


def _pressed(model: QuasiStaticModel) -> dict[str, Any] | None:
    """The pressure by shapes, its table of balance left to the page."""
    footprint: Footprint = model.pressure
    if isinstance(footprint, PointFootprint):
        return None
    if isinstance(footprint, PatchFootprint):
        try:
            footprint = PressedFootprint(
                footprint.outline, FLAT, SurfaceShape(dome=1e-3), footprint.centre
            )
        except CycleMapError:
            return None
    table = _record(pressure_tables(footprint))
    return table | {
        "bend_unit": footprint.bend_unit,
        "table_count": BALANCE_ROWS,
        "balance_size": BALANCE_ROWS * BALANCE.size,
        "has_field": footprint.field is not None,
    }


def _record(tables: PressureTables) -> dict[str, Any]:
    """The numbers of a pressure's record that are no addresses, and its tables."""
    names = tables.record.dtype.names or ()
    record = {name: packed_numbers(tables.record[name]) for name in names if name not in _TABLES}
    return {
        "record": record,
        "tables": {
            name: packed_numbers(getattr(tables, name)) for name in ("rows", "nodes", "outline")
        },
    }
