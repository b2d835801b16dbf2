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
from cyclemap.plain_text import install_words, plain_number
from cyclemap.text_files import read_bytes, read_text

UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "inch": 0.0254}
# What headers call them.
_UNIT_WORDS = {
    **{name: name for name in UNITS},
    "in": "inch",
    "inches": "inch",
    "metres": "m",
    "meters": "m",
}
MESHES = (".stl", ".obj", ".ply", ".off", ".glb", ".dae")
# DXF's own numbers of units, and CSS's names of them; a pixel is 1/96 inch there.
_DXF_UNITS = {1: "inch", 4: "mm", 5: "cm", 6: "m"}
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
    kind = path.suffix.lower()
    known = "in the file's own unit"
    own: float | None
    if kind == ".csv":
        line, named = _csv_vertices(path)
        lines = [line]
        own = None if named is None else UNITS[named]
    else:
        read_bytes(path, 2**26)
        if kind == ".svg":
            lines, own, is_told = _svg_lines(path)
            known = known if is_told else "in pixels of 1/96 inch: give --unit where they are none"
        elif kind == ".dxf":
            lines, own = _dxf_lines(path)
        elif kind in MESHES:
            lines = _mesh_outlines(_loaded_mesh(path), underside, path)
            own = None
        elif kind == ".urdf":
            lines = _mesh_outlines(_urdf_mesh(path), underside, path)
            own = 1.0
        else:
            listed = ", ".join((".svg", ".dxf", ".urdf", ".csv", *MESHES))
            raise InvalidInput(
                f"{path}: an outline is read from {listed}, not from "
                f"{kind or 'a file without an ending'}"
            )
    line = _largest(path, lines)
    if unit is not None:
        metres = UNITS[unit]
        known = f"as told, in {unit}"
    elif own is not None:
        metres = own
    else:
        guess = "m" if float(np.ptp(line, axis=0).max()) < _METRES_BELOW else "mm"
        metres = UNITS[guess]
        known = f"in {guess}, guessed by its size: give --unit where that is wrong"
    if len(lines) > 1:
        known += f"; the largest of {len(lines)} closed lines, the others left out, as holes are"
    return _finished(path, metres * line, known, tolerance)


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
    around = np.roll(points, -1, axis=0)
    if float((points[:, 0] * around[:, 1] - points[:, 1] * around[:, 0]).sum()) < 0.0:
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


def _largest(path: Path, lines: Sequence[Array]) -> Array:
    """The closed line around the largest area."""
    if not lines:
        raise DataFileError(
            f"{path}: no closed line: close the path of the outline, or join its lines"
        )
    areas = []
    for line in lines:
        x, y = (line - line[0]).T
        areas.append(abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))))
    return lines[int(np.argmax(areas))]


def _csv_vertices(path: Path) -> tuple[Array, str | None]:
    """The vertices, and their unit where a header names it; columns are told by their names, else
    they are x and y.
    """
    text = enumerate(read_text(path, "CSV").splitlines(), 1)
    kept = [(place, line) for place, line in text if line.strip(" ,;\t") and line[0] != "#"]
    numbers = [place for place, _ in kept]
    lines = [line for _, line in kept]
    separator = next((sign for sign in ";\t" if lines and sign in lines[0]), ",")
    # Where another sign divides the columns a comma is a decimal one.
    rows = [[field.strip().strip('"\ufeff') for field in line.split(separator)] for line in lines]
    if separator != ",":
        rows = [[field.replace(",", ".") for field in row] for row in rows]
    columns = (0, 1)
    unit = None
    if rows and not all(_is_number(field) for field in rows[0] if field):
        columns, unit = _named_columns(path, rows[0])
        rows = rows[1:]
        lines = lines[1:]
        numbers = numbers[1:]
    elif rows and len([field for field in rows[0] if field]) != 2:
        problem = f"{len(rows[0])} columns without names: which are x and y?"
        raise DataFileError(f"{path}: {problem} Give a header line, such as x_mm,y_mm")
    points = []
    for row, line, place in zip(rows, lines, numbers, strict=True):
        try:
            points.append([plain_number(row[column]) for column in columns])
        except (ValueError, IndexError) as error:
            raise DataFileError(
                f"{path}, line {place}: two numbers x,y are wanted, not {line[:60]!r}"
            ) from error
    if len(points) < 3:
        raise DataFileError(
            f"{path}: {len(points)} vertices; an outline has three or more, one x,y a line"
        )
    return np.array(points), unit


def _is_number(text: str) -> bool:
    try:
        plain_number(text)
    except ValueError:
        return False
    return True


def _named_columns(path: Path, header: Sequence[str]) -> tuple[tuple[int, int], str | None]:
    """Where a header has x and y, and the unit that it names."""
    axes: dict[str, tuple[int, str]] = {}
    for index, name in enumerate(header):
        match = re.fullmatch(
            r"(?:pos(?:ition)?_?)?([xy])(?:[\s_\-\[(]+([a-z]+)[\])]*)?", name.strip().lower()
        )
        if match and match[1] in axes:
            raise DataFileError(
                f"{path}: {header[axes[match[1]][0]]} and {name} may both be {match[1]}: keep one"
            )
        if match:
            axes[match[1]] = index, match[2] or ""
    if set(axes) != {"x", "y"}:
        raise DataFileError(
            f"{path}: the header is {','.join(header)[:80]}: name the columns x and y, such as "
            "x_mm,y_mm"
        )
    named = {unit for _, unit in axes.values()}
    if len(named) > 1:
        raise DataFileError(
            f"{path}: x and y in different units ({', '.join(sorted(named))}): write them in one"
        )
    (word,) = named
    if word and word not in _UNIT_WORDS:
        raise DataFileError(f"{path}: {word} is no unit that is known: give {', '.join(UNITS)}")
    return (axes["x"][0], axes["y"][0]), _UNIT_WORDS.get(word)


def _svg_lines(path: Path) -> tuple[list[Array], float, bool]:
    """The closed lines, one unit of the drawing (m), and whether the drawing tells that."""
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
    for drawn in paths:
        for line in drawn.continuous_subpaths():
            ends = [line.start]
            for segment in line:
                pieces = 1 if type(segment).__name__ == "Line" else most_pieces
                ends += [segment.point(step / pieces) for step in range(1, pieces + 1)]
            if len(ends) > 3 and abs(ends[-1] - ends[0]) <= 1e-3 * max(
                abs(end - ends[0]) for end in ends
            ):
                lines.append(np.array([[end.real, -end.imag] for end in ends]))
    # One unit of the drawing, m: its width in the world over its width in the drawing's own units.
    width = (root.get("width") or "").strip()
    box = (root.get("viewBox") or "").replace(",", " ").split()
    digits = width.rstrip("abcdefghijklmnopqrstuvwxyz%")
    try:
        name = width[len(digits) :]
        across = plain_number(digits)
        unit = _SVG_UNITS[name] * (across / plain_number(box[2]) if len(box) == 4 else 1.0)
    except (ValueError, KeyError):
        name = ""
        unit = _SVG_UNITS["px"]
    return lines, unit, name not in ("", "px")


def _dxf_lines(path: Path) -> tuple[list[Array], float | None]:
    ezdxf = _library("ezdxf")
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
        pieces.append(np.array([[point.x, point.y] for point in made.flattening(finest)]))
    # Where a drawing tells no unit the library has one of its own.
    is_told = b"$INSUNITS" in read_bytes(path)
    unit = _DXF_UNITS.get(drawing.header.get("$INSUNITS", 0)) if is_told else None
    pieces = [piece for piece in pieces if len(piece) > 1]
    closed = [
        piece
        for piece in pieces
        if len(piece) > 3 and math.dist(piece[0], piece[-1]) <= 1e-6 * np.ptp(piece)
    ]
    # Open lines make closed ones where their ends meet.
    shapely = _library("shapely")
    rest = [
        shapely.LineString(piece.round(6))
        for piece in pieces
        if not any(piece is ring for ring in closed)
    ]
    if rest:
        closed += [np.array(polygon.exterior.coords) for polygon in shapely.polygonize(rest).geoms]
    return closed, None if unit is None else UNITS[unit]


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
    flat = [shapely.Polygon(corners) for corners in triangles[..., :2]]
    size = float(np.ptp(triangles[..., :2], axis=(0, 1)).max()) if len(triangles) else 0.0
    # Triangles meet within rounding of the file only: a hair's breadth closes the seams.
    hair = 1e-6 * size
    shadows = [
        triangle.buffer(hair, join_style="mitre")
        for triangle in flat
        if triangle.area > 1e-12 * size * size
    ]
    union = shapely.union_all(shadows).buffer(-hair, join_style="mitre")
    return [
        np.array(polygon.exterior.coords)
        for polygon in getattr(union, "geoms", [union])
        if not polygon.is_empty
    ]


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
