"""Support points: where the load is, how files and words name it; those for a patch carry its load
and friction.
"""

import math

import numpy as np
import pytest
from refusals import refused

from cyclemap.errors import DataFileError
from cyclemap.mechanics import (
    Ellipse,
    EllipseFriction,
    LimitSurface,
    PatchFootprint,
    PointFootprint,
    Polygon,
    Slider,
    corner_footprint,
    grid_footprint,
    load_footprint,
    load_material,
    parse_footprint,
)
from cyclemap.mechanics.footprint import pressure_points

SQUARE = Slider.mit("rect1").outline
OUTLINES = {name: Slider.mit(name).outline for name in ("rect1", "rect3", "tri2", "hex", "ellip2")}
PRESSURES = {
    "lean": {"lean": 0.04},
    "inner": {"inner_share": 0.5},
    "rim": {"rim_share": 0.4},
    "rim alone": {"rim_share": 1.0},
    "corners": {"corner_share": 0.3},
    "lean and rim": {"rim_share": 0.3, "lean": 0.03},
    "all": {"inner_share": 0.2, "rim_share": 0.2, "corner_share": 0.1, "lean": 0.02},
}
TWISTS = np.array([[1.0, 0.3, 0.5], [-0.2, 1.0, 2.0], [0.1, 0.1, 1.0], [0.5, -1.0, 0.1]])


def test_points_keep_their_shares_scaled_to_one_and_drop_what_carries_nothing():
    footprint = PointFootprint(((0, 0), (1, 0), (0, 1)), (2, 0, 6))
    assert footprint.positions == ((0.0, 0.0), (0.0, 1.0))
    assert footprint.weights == (0.25, 0.75)
    assert footprint.centre == (0.0, 0.75)
    assert footprint.extent == 0.75


def test_a_csv_file_is_read_in_millimetres(tmp_path):
    path = tmp_path / "feet.csv"
    path.write_text("weight,x_mm,y_mm,note\n1,-40,0,a\n3,40,20,b\n")
    footprint = load_footprint(path)
    assert np.allclose(footprint.positions, ((-0.04, 0.0), (0.04, 0.02)))
    assert footprint.weights == (0.25, 0.75)
    assert parse_footprint(str(path), SQUARE) == footprint


def test_words_name_footprints():
    assert parse_footprint("exact", SQUARE) == PatchFootprint(SQUARE)
    assert parse_footprint("corners", SQUARE) == corner_footprint(SQUARE)
    assert (
        parse_footprint("grid:8", SQUARE)
        == grid_footprint(SQUARE, 8)
        == grid_footprint(SQUARE, np.int64(8))
    )


def test_files_words_points_and_grids_that_carry_no_object_are_refused(tmp_path):
    path = tmp_path / "feet.csv"
    for text, told in (
        ("x_mm,y_mm\n1,2\n", "column weight is missing"),
        ("", "the file is empty"),
        ("x_mm,y_mm,weight\n1,2,3\n4,5\n", "line 3"),
        ("x_mm,y_mm,weight\n1,2,3\n4,five,6\n", "line 3"),
        ("x_mm,y_mm,weight\n", "a header but no rows"),
        ("x_mm,y_mm,weight\n1,2,nan\n3,4,1\n", "finite"),
        ("x_mm,y_mm,weight\n1,2,1\n1,2,1\n", "two support points"),
    ):
        path.write_text(text)
        refused(load_footprint, path, told=rf"feet\.csv.*{told}", kind=DataFileError)
    for word in ("exct", "grid:", "grid:-1", "grid:1", "grid:x"):
        refused(parse_footprint, word, SQUARE)
    refused(parse_footprint, "corners", Ellipse(1.0, 1.0), told="polygons")
    pair = ((0, 0), (1, 0))
    for weights in ((1,), (1, -1), (0, 0)):
        refused(PointFootprint, pair, weights)
    refused(PointFootprint, pair[:1], (1,))
    for positions in (((0, 0), (0, 0)), ((0, 0, 0), (1, 0, 0))):
        refused(PointFootprint, positions, (1, 1))
    disc = Ellipse(1.0, 1.0)
    for make, values, told in (
        (PatchFootprint, ("x",), "outline of a footprint must be a Polygon or an Ellipse, not 'x'"),
        (grid_footprint, ("a", 8), "outline of a footprint must be a Polygon"),
        (corner_footprint, (disc,), "on corners must be a Polygon, not Ellipse"),
        (parse_footprint, (5, SQUARE), "word for a footprint must be a str, not 5"),
        (parse_footprint, ("exact", 5), "outline of a footprint must be a Polygon"),
    ):
        refused(make, *values, told=told)
    for count in (1, 0, -3, 2.5, True):
        refused(grid_footprint, SQUARE, count, told="points a side of a grid footprint")


@pytest.mark.parametrize("count", [4, 7, 16])
@pytest.mark.parametrize("move", [(0.0, 0.0), (0.0123, -0.0041), (0.0333, 0.1)])
def test_centres_on_a_side_carry_half_wherever_the_outline_lies(count, move):
    """Of a right triangle as many cells as half the square's, whose hypotenuse halves n of them: with
    all or none of these, as rounding has it, its centre of pressure and its drags are off.
    """
    corners = ((0.0, 0.0), (0.1, 0.0), (0.0, 0.1))
    triangle = Polygon(tuple((x + move[0], y + move[1]) for x, y in corners))
    footprint = grid_footprint(triangle, count)
    loads = np.array(footprint.weights) / max(footprint.weights)
    assert np.sum(np.isclose(loads, 1.0)) == count * (count - 1) / 2
    assert sorted(set(loads.round(9))) == [0.5, 1.0] and loads.sum() == pytest.approx(count**2 / 2)
    (x, y), (mean_x, mean_y) = footprint.centre, triangle.centroid
    assert math.hypot(x - mean_x, y - mean_y) < 0.02 / count


def patch_of(outline, name: str) -> PatchFootprint:
    """The pressure of a name; ellipses have no corners, leans are shares of the extent."""
    shares = dict(PRESSURES[name])
    away = outline.extent * shares.pop("lean", 0.0)
    if not hasattr(outline, "vertices"):
        shares.pop("corner_share", None)
    x, y = outline.centroid
    return PatchFootprint(outline, **shares, centre=(x + 0.8 * away, y - 0.6 * away))


def wrench_error(patch: PatchFootprint, count: int) -> float:
    """Root mean square, over twists, of the wrenches on points less those on the patch: weights,
    extents.
    """
    law = load_material("plywood").friction
    length = patch.extent
    twists = TWISTS * np.array([length, length, 1.0])
    surfaces = (LimitSurface(pressure_points(patch, count), law), LimitSurface(patch, law))
    one, other = (
        np.array([surface.wrench(twist, frame=0.4) for twist in twists]) for surface in surfaces
    )
    return float(np.sqrt(np.mean(((one - other) / np.array([1.0, 1.0, length])) ** 2)))


@pytest.mark.parametrize("name", OUTLINES)
def test_even_pressure_becomes_the_papers_grid_exactly_and_points_stay_as_they_are(name):
    assert pressure_points(PatchFootprint(OUTLINES[name]), 8) == grid_footprint(OUTLINES[name], 8)
    corners = corner_footprint(SQUARE)
    assert pressure_points(corners, 8) is corners


@pytest.mark.parametrize("name", OUTLINES)
@pytest.mark.parametrize("pressure", PRESSURES)
def test_load_is_one_and_the_centre_of_pressure_is_the_patchs_to_rounding(name, pressure):
    patch = patch_of(OUTLINES[name], pressure)
    points = pressure_points(patch, 8)
    assert min(points.weights) > 0.0 and math.fsum(points.weights) == pytest.approx(1.0, abs=1e-12)
    assert points.centre == pytest.approx(patch.centre, abs=1e-15)
    # Those of the rim lie on the outline itself.
    inwards = np.array(OUTLINES[name].centroid) * 1e-9 + (1.0 - 1e-9) * np.array(points.positions)
    assert bool(np.all(OUTLINES[name].contains(inwards)))


def test_each_part_carries_its_share_where_it_is():
    even, inner, rim, corner = 0.4, 0.3, 0.2, 0.1
    points, weights = pressure_points(PatchFootprint(SQUARE, inner, rim, corner), 10).quadrature
    assert weights[np.abs(points).max(axis=1) > 0.0449].sum() == pytest.approx(
        rim + corner, abs=1e-12
    )
    assert weights[np.abs(points).min(axis=1) > 0.0449].sum() == pytest.approx(corner, abs=1e-12)
    # Of the 10 x 10 cells of the plate 6 x 6 lie within .6 of it.
    assert weights[np.abs(points).max(axis=1) < 0.55 * 0.045].sum() == pytest.approx(
        0.36 * even + inner, abs=1e-12
    )


@pytest.mark.parametrize("pressure", PRESSURES)
def test_their_friction_is_as_near_the_patchs_as_the_even_grids_and_nearer_on_finer_grids(pressure):
    patch = patch_of(SQUARE, pressure)
    errors = [wrench_error(patch, count) for count in (8, 32)]
    assert errors[0] < 1.5 * wrench_error(PatchFootprint(SQUARE), 8) < 0.01
    # What is left on the finest: the frame is one row of points however fine.
    assert errors[1] < max(errors[0] / 4.0, 6e-4)


def test_points_that_cannot_carry_a_pressure_are_refused_with_what_to_set():
    """A steep lean on a triangle, whose coarse grid has its centre far from the patch's."""
    triangle = Polygon(((0.0, 0.0), (1.0, 0.0), (0.3, 0.9)))
    steep = PatchFootprint(triangle, centre=(1.3 / 3.0 - 0.0317, 0.3 + 0.1106))
    refused(pressure_points, steep, 3, told="set the footprint")
    assert pressure_points(steep, 8).centre == pytest.approx(steep.centre, abs=1e-12)


@pytest.mark.parametrize("twist", [(1.0, 0.3, 3.0), (0.02, 0.01, 1.0), (0.0, 0.0, 1.0)])
def test_fine_grids_approach_the_patch_at_second_order(twist):
    """Midpoints of equal cells, a dissipation that is convex: far from the centre of rotation,
    beside it and on it.
    """
    law = EllipseFriction(0.30, 0.24, 0.01, 0.005, 0.4)
    exact = float(LimitSurface(PatchFootprint(SQUARE), law).dissipation(twist))
    off = [
        abs(float(LimitSurface(grid_footprint(SQUARE, n), law).dissipation(twist)) - exact)
        for n in (10, 20, 40, 80)
    ]
    assert np.log2(np.divide(off[:-1], off[1:])) == pytest.approx(2.0, abs=0.1)
