"""Outlines from drawings and models: SVG, DXF, STL (and what else trimesh reads), URDF, and CSV
vertices.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import require_room
from cyclemap.errors import CycleMapError, DataFileError, InvalidInput
from cyclemap.mechanics import Polygon
from cyclemap.plain_text import install_words, number_or_nan, plain_number
from cyclemap.text_files import read_bytes, read_text

UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "inch": 0.0254}
# What headers call them, and a name of x or y with its unit, such as pos_x_mm or "Y [mm]".
_UNIT_WORDS = {**UNITS, "in": 0.0254, "inches": 0.0254, "metres": 1.0, "meters": 1.0}
_AXIS = re.compile(r"(?:pos(?:ition)?_?)?([xy])(?:[\s_\-\[(]+([a-z]+)[\])]*)?")
MESHES = (".stl", ".obj", ".ply", ".off", ".glb", ".dae")
# DXF's own numbers of units, and CSS's names of them; a pixel is 1/96 inch there.
_DXF_UNITS = {1: 0.0254, 4: 1e-3, 5: 1e-2, 6: 1.0}
_SVG_UNITS = {
    "mm": 1e-3,
    "cm": 1e-2,
    "in": 0.0254,
    "pt": 0.0254 / 72,
    "pc": 0.0254 / 6,
    "px": 0.0254 / 96,
    "": 0.0254 / 96,
}
# A curve is cut into so many pieces before those that the tolerance allows are left out.
_PIECES = 64
# Of the curves of a drawing, and of the pieces that all of them are cut into.
_MOST_CURVES = 30_000
_MOST_VERTICES = 400
# Of what is that small nobody would make a drawing in metres, and of what is that large none in
# millimetres.
_METRES_BELOW = 1.5
# Triangles that lie this near to the lowest place, as a share of the height, are the underside.
_UNDERSIDE = 1e-3


@dataclass(frozen=True)
class OutlineFile:
    """The outline of a file.

    Attributes
    ----------
    outline : Polygon
        In m, about its centroid, vertex 0 the one farthest up and right.
    words : tuple of str
        What was assumed, and what was left out.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from cyclemap.protocol import read_outline
    >>> with tempfile.TemporaryDirectory() as place:
    ...     count = Path(place, "plate.csv").write_text("x_mm,y_mm\\n0,0\\n60,0\\n60,40\\n0,40\\n")
    ...     drawn = read_outline(f"{place}/plate.csv")
    >>> [round(1e3 * coordinate) for coordinate in drawn.outline.vertices[0]]
    [30, 20]
    """

    outline: Polygon
    words: tuple[str, ...]


def read_outline(
    path: str | Path, unit: str | None = None, tolerance: float = 1e-4, underside: bool = False
) -> OutlineFile:
    """Read the outline of an object from a file: the largest closed line of it, holes left out.

    Parameters
    ----------
    path : str or Path
        The file; its ending tells what it is.
    unit : {"mm", "cm", "m", "inch"}, optional
        None: the file's own, or guessed by the size, which `words` say.
    tolerance : float, default 1e-4
        By which the outline may be simplified, m.
    underside : bool, default False
        Of a mesh, take the foot print in place of the silhouette from above.

    Returns
    -------
    OutlineFile
        The outline, and what was assumed.

    Raises
    ------
    DataFileError
        Where the file has no closed outline.
    InvalidInput
        Where a library is missing: all but CSV needs those of the extra ``cyclemap[outlines]``.

    Notes
    -----
    - ``.svg``: paths and shapes, drawn with y down, in the unit of the drawing's width.
    - ``.dxf``: closed polylines, lines that meet, circles, splines, in the drawing's unit.
    - ``.stl`` and other meshes, ``.urdf``: the silhouette from above (along z); `underside`:
      the foot print.
    - ``.csv``: columns x and y by the names and units of a header (x_mm,y_mm), else the two
      that there are.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from cyclemap.protocol import read_outline
    >>> with tempfile.TemporaryDirectory() as place:
    ...     count = Path(place, "plate.csv").write_text("x_mm,y_mm\\n0,0\\n60,0\\n60,40\\n0,40\\n")
    ...     outline = read_outline(f"{place}/plate.csv").outline
    >>> round(1e6 * outline.area)
    2400
    """
    path = Path(path)
    drawing = _drawing(path, underside)
    if not drawing.lines:
        raise DataFileError(
            f"{path}: no closed line: close the path of the outline, or join its lines"
        )
    line = max(drawing.lines, key=lambda line: abs(_twice_area(line)))
    known = drawing.known
    if unit is not None:
        metres = UNITS[unit]
        known = f"as told, in {unit}"
    elif drawing.metres is not None:
        metres = drawing.metres
    else:
        guess = "m" if float(np.ptp(line, axis=0).max()) < _METRES_BELOW else "mm"
        metres = UNITS[guess]
        known = f"in {guess}, guessed by its size: give --unit where that is wrong"
    if len(drawing.lines) > 1:
        known += (
            f"; the largest of {len(drawing.lines)} closed lines, the others left out, as holes are"
        )
    return _finished(path, metres * line, known, tolerance)


@dataclass(frozen=True)
class _Drawing:
    """The closed lines of a file.

    metres : one unit of it; None where it does not tell.
    known : what is said of the unit where it is told.
    """

    lines: list[Array]
    metres: float | None
    known: str = "in the file's own unit"


def _drawing(path: Path, underside: bool) -> _Drawing:
    kind = path.suffix.lower()
    if kind != ".csv":
        read_bytes(path, 2**26)
    readers = {".csv": _csv_drawing, ".svg": _svg_drawing, ".dxf": _dxf_drawing}
    if kind in readers:
        return readers[kind](path)
    if kind in MESHES:
        return _Drawing(_mesh_outlines(_loaded_mesh(path), underside, path), None)
    if kind == ".urdf":
        return _Drawing(_mesh_outlines(_urdf_mesh(path), underside, path), 1.0)
    listed = ", ".join((".svg", ".dxf", ".urdf", ".csv", *MESHES))
    raise InvalidInput(
        f"{path}: an outline is read from {listed}, not from {kind or 'a file without an ending'}"
    )


def _finished(path: Path, points: Array, known: str, tolerance: float) -> OutlineFile:
    """The outline of a closed line, m, about its centroid; `known`: what is said of its unit."""
    # A point that stands twice in a row, or closes the line, is one.
    points = points[np.abs(points - np.roll(points, -1, axis=0)).max(axis=1) > 1e-9]
    drawn = len(points)
    if path.suffix.lower() != ".csv":
        shape = _library("shapely").Polygon(points).buffer(0).simplify(tolerance)
        if shape.geom_type != "Polygon" or shape.is_empty:
            raise DataFileError(f"{path}: the outline crosses itself: draw it as one closed line")
        points = np.array(shape.exterior.coords)[:-1]
    if len(points) > _MOST_VERTICES:
        raise DataFileError(
            f"{path}: {len(points)} vertices: take a larger --tolerance-mm, {_MOST_VERTICES} are "
            "enough"
        )
    if _twice_area(points) < 0.0:
        points = points[::-1]
    points = points - Polygon(tuple(map(tuple, points.tolist()))).centroid
    points = np.roll(points, -int(np.argmax(points.sum(axis=1).round(9))), axis=0)
    outline = Polygon(tuple(map(tuple, points.round(9).tolist())))
    width, height = 1e3 * np.ptp(points, axis=0)
    words = (
        f"{path.name}: {width:.4g} x {height:.4g} mm, {known}; {outline.sides} sides of {drawn} "
        f"points, simplified within {1e3 * tolerance:g} mm; the frame's origin is its centroid"
    )
    return OutlineFile(outline, (words,))


def _twice_area(line: Array) -> float:
    """Twice the area in a closed line, positive where it runs counter-clockwise."""
    x, y = (line - line[0]).T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def _csv_drawing(path: Path) -> _Drawing:
    """The vertices; columns are told by their names, else they are x and y."""
    lines = enumerate(read_text(path, "CSV").splitlines(), 1)
    kept = [(row, line) for row, line in lines if line.strip(" ,;\t") and line[0] != "#"]
    if not kept:
        raise _too_few(path, 0)
    separator = next((sign for sign in ";\t" if sign in kept[0][1]), ",")
    columns = (0, 1)
    metres = None
    header = _fields(kept[0][1], separator)
    named = [field for field in header if field]
    if any(math.isnan(number_or_nan(field)) for field in named):
        columns, metres = _named_columns(path, header)
        kept = kept[1:]
    elif len(named) != 2:
        problem = f"{len(header)} columns without names: which are x and y?"
        raise DataFileError(f"{path}: {problem} Give a header line, such as x_mm,y_mm")
    points = []
    for row, line in kept:
        fields = _fields(line, separator)
        try:
            points.append([plain_number(fields[column]) for column in columns])
        except (ValueError, IndexError) as error:
            raise DataFileError(
                f"{path}, line {row}: two numbers x,y are wanted, not {line[:60]!r}"
            ) from error
    if len(points) < 3:
        raise _too_few(path, len(points))
    return _Drawing([np.array(points)], metres)


def _too_few(path: Path, count: int) -> DataFileError:
    return DataFileError(f"{path}: {count} vertices; an outline has three or more, one x,y a line")


def _fields(line: str, separator: str) -> list[str]:
    """The fields of a line; where another sign divides them a comma is a decimal one."""
    fields = [field.strip().strip('"\ufeff') for field in line.split(separator)]
    return fields if separator == "," else [field.replace(",", ".") for field in fields]


def _named_columns(path: Path, header: Sequence[str]) -> tuple[tuple[int, int], float | None]:
    """Where a header has x and y, and the unit (m) that it names."""
    axes: dict[str, tuple[int, str]] = {}
    for index, name in enumerate(header):
        match = _AXIS.fullmatch(name.strip().lower())
        if match is None:
            continue
        axis, unit = match.groups("")
        if axis in axes:
            raise DataFileError(
                f"{path}: {header[axes[axis][0]]} and {name} may both be {axis}: keep one"
            )
        axes[axis] = index, unit
    if set(axes) != {"x", "y"}:
        raise DataFileError(
            f"{path}: the header is {','.join(header)[:80]}: name the columns x and y, such as "
            "x_mm,y_mm"
        )
    (x, unit), (y, other) = axes["x"], axes["y"]
    if unit != other:
        raise DataFileError(
            f"{path}: x and y in different units ({unit}, {other}): write them in one"
        )
    if unit and unit not in _UNIT_WORDS:
        raise DataFileError(f"{path}: {unit} is no unit that is known: give {', '.join(UNITS)}")
    return (x, y), _UNIT_WORDS.get(unit)


def _svg_drawing(path: Path) -> _Drawing:
    svg = _library("svgpathtools")
    try:
        root = ElementTree.fromstring(read_bytes(path))
        paths = svg.Document(str(path)).paths()
    except Exception as error:
        raise DataFileError(f"{path}: not an SVG drawing that can be read ({error})") from error
    curves = sum(len(drawn) for drawn in paths)
    require_room(f"{path}: its {curves} curves", curves, "simplify the drawing", _MOST_CURVES)
    most_pieces = max(1, min(_PIECES, _MOST_CURVES // max(curves, 1)))
    lines = []
    for line in (line for drawn in paths for line in drawn.continuous_subpaths()):
        ends = [line.start]
        for segment in line:
            pieces = 1 if type(segment).__name__ == "Line" else most_pieces
            ends += [segment.point(step / pieces) for step in range(1, pieces + 1)]
        away = np.array(ends) - ends[0]
        if len(ends) > 3 and abs(away[-1]) <= 1e-3 * np.abs(away).max():
            lines.append(np.array([[end.real, -end.imag] for end in ends]))
    # One unit of the drawing, m: its width in the world over its width in the drawing's own units.
    width = re.fullmatch(r"([^a-z%]*)([a-z%]*)", (root.get("width") or "").strip())
    box = (root.get("viewBox") or "").replace(",", " ").split()
    try:
        digits, name = width.groups() if width else ("", "")
        across = plain_number(digits)
        unit = _SVG_UNITS[name] * (across / plain_number(box[2]) if len(box) == 4 else 1.0)
    except (ValueError, KeyError):
        name = ""
        unit = _SVG_UNITS["px"]
    if name not in ("", "px"):
        return _Drawing(lines, unit)
    return _Drawing(lines, unit, "in pixels of 1/96 inch: give --unit where they are none")


def _dxf_drawing(path: Path) -> _Drawing:
    ezdxf = _library("ezdxf")
    shapely = _library("shapely")
    drawing_paths = import_module("ezdxf.path")
    try:
        drawing = ezdxf.readfile(path)
    except Exception as error:
        raise DataFileError(f"{path}: not a DXF drawing that can be read ({error})") from error
    pieces = []
    for entity in drawing.modelspace():
        try:
            made = drawing_paths.make_path(entity)
        except (TypeError, ValueError):
            continue
        ends = np.array([[point.x, point.y] for point in made.control_vertices()])
        finest = 1e-4 * max(float(np.ptp(ends, axis=0).max()), 1e-9)
        piece = np.array([[point.x, point.y] for point in made.flattening(finest)])
        if len(piece) > 1:
            pieces.append(shapely.LineString(piece.round(6)))
    # Closed lines, and open ones whose ends meet.
    lines = [np.array(polygon.exterior.coords) for polygon in shapely.polygonize(pieces).geoms]
    # Where a drawing tells no unit the library has one of its own.
    is_told = b"$INSUNITS" in read_bytes(path)
    return _Drawing(lines, _DXF_UNITS.get(drawing.header.get("$INSUNITS", 0)) if is_told else None)


def _loaded_mesh(path: Path) -> Array:
    """The triangles (n, 3, 3) of a mesh file, in its unit."""
    try:
        return np.asarray(_library("trimesh").load_mesh(str(path)).triangles, dtype=float)
    except InvalidInput:
        raise
    except Exception as error:
        raise DataFileError(f"{path}: not a mesh that can be read ({error})") from error


def _mesh_outlines(triangles: Array, underside: bool, path: Path) -> list[Array]:
    shapely = _library("shapely")
    if not len(triangles):
        raise DataFileError(f"{path}: the mesh has no triangles")
    if underside:
        low = triangles[..., 2].min()
        high = triangles[..., 2].max()
        triangles = triangles[(triangles[..., 2] <= low + _UNDERSIDE * (high - low)).all(axis=1)]
    flat = shapely.polygons(triangles[..., :2])
    size = float(np.ptp(triangles[..., :2], axis=(0, 1)).max()) if len(triangles) else 0.0
    # Triangles meet within rounding of the file only: a hair's breadth closes the seams.
    hair = 1e-6 * size
    shadows = shapely.buffer(
        flat[shapely.area(flat) > 1e-12 * size * size], hair, join_style="mitre"
    )
    union = shapely.buffer(shapely.union_all(shadows), -hair, join_style="mitre")
    polygons = shapely.get_parts(union)
    return [np.array(polygon.exterior.coords) for polygon in polygons if not polygon.is_empty]


def _urdf_mesh(path: Path) -> Array:
    """The triangles of a URDF's one link, m: its collision shapes, else its visual ones."""
    try:
        root = ElementTree.fromstring(read_bytes(path))
    except ElementTree.ParseError as error:
        raise DataFileError(f"{path}: not XML: {error}") from error
    links = {
        link.get("name"): link for link in root.iter("link") if link.find(".//geometry") is not None
    }
    if len(links) != 1:
        raise DataFileError(
            f"{path}: {len(links)} links with a geometry ({', '.join(map(str, links))}): keep "
            "the object's alone"
        )
    link = next(iter(links.values()))
    elements = link.findall("collision") or link.findall("visual")
    try:
        placed = []
        for element in elements:
            triangles = _geometry(element.find("geometry"), path)
            origin = element.find("origin")
            if origin is not None:
                angles = _numbers(origin.get("rpy") or "0 0 0")
                turn = _library("trimesh").transformations.euler_matrix(*angles, "sxyz")[:3, :3]
                triangles = triangles @ turn.T + np.array(_numbers(origin.get("xyz") or "0 0 0"))
            placed.append(triangles)
        return np.concatenate(placed)
    except CycleMapError:
        raise
    except Exception as error:  # what is missing, or is no number, in an element's text
        raise DataFileError(
            f"{path}: a geometry or origin of {link.get('name')} cannot be read ({error})"
        ) from error


def _geometry(geometry: Any, path: Path) -> Array:
    trimesh = _library("trimesh")
    shape = geometry[0]
    if shape.tag == "box":
        return np.asarray(trimesh.creation.box(_numbers(shape.get("size"))).triangles)
    if shape.tag == "cylinder":
        radius = float(shape.get("radius"))
        length = float(shape.get("length"))
        return np.asarray(trimesh.creation.cylinder(radius, length, sections=_PIECES).triangles)
    if shape.tag == "mesh":
        name = str(shape.get("filename")).rpartition("://")[2]
        places = [path.parent / name, *(parent / name for parent in path.absolute().parents)]
        file = next((place for place in places if place.is_file()), None)
        if file is None:
            raise DataFileError(f"{path}: its mesh {name} is not there: put it beside the URDF")
        return np.asarray(_loaded_mesh(file) * np.array(_numbers(shape.get("scale") or "1 1 1")))
    raise DataFileError(
        f"{path}: a {shape.tag} has no flat underside: give a box, cylinder or mesh"
    )


def _numbers(text: str | None) -> list[float]:
    return [plain_number(word) for word in (text or "").split()]


def _library(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError as error:
        raise InvalidInput(
            f"this kind of file needs {name}: {install_words('outlines')}"
        ) from error
