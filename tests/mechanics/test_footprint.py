"""Support points: where the load is, how files and words name it, what is refused."""

import numpy as np
import pytest

from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.mechanics import (
    Ellipse,
    PatchFootprint,
    PointFootprint,
    Slider,
    corner_footprint,
    grid_footprint,
    load_footprint,
    parse_footprint,
)

SQUARE = Slider.mit("rect1").outline


def test_the_grid_is_the_papers_eight_by_eight():
    grid = grid_footprint(SQUARE, 8)
    places = np.array(grid.positions)
    assert len(places) == 64
    assert np.allclose(np.unique(places[:, 0].round(9)), 0.09 * ((np.arange(8) + 0.5) / 8 - 0.5))
    assert np.allclose(grid.weights, 1 / 64)
    assert np.allclose(grid.centre, 0.0, atol=1e-17)


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


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("x_mm,y_mm\n1,2\n", "column weight is missing"),
        ("", "the file is empty"),
        ("x_mm,y_mm,weight\n1,2,3\n4,5\n", "line 3"),
        ("x_mm,y_mm,weight\n1,2,3\n4,five,6\n", "line 3"),
        ("x_mm,y_mm,weight\n", "a header but no rows"),
        ("x_mm,y_mm,weight\n1,2,nan\n3,4,1\n", "finite"),
        ("x_mm,y_mm,weight\n1,2,-1\n3,4,2\n", "negative"),
        ("x_mm,y_mm,weight\n1,2,1\n1,2,1\n", "two support points"),
    ],
)
def test_a_bad_csv_file_is_told_by_name_in_one_line(tmp_path, text, told):
    path = tmp_path / "feet.csv"
    path.write_text(text)
    with pytest.raises(DataFileError, match=told) as refused:
        load_footprint(path)
    assert "feet.csv" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_missing_folders_and_binary_files_are_told_too(tmp_path):
    binary = tmp_path / "feet.csv"
    binary.write_bytes(bytes(range(128, 256)))
    for path, told in ((tmp_path / "absent.csv", "no such file"), (tmp_path, "cannot be read"), (binary, "not UTF-8")):
        with pytest.raises(DataFileError, match=told):
            load_footprint(path)


def test_words_name_footprints_and_others_are_refused():
    assert parse_footprint("exact", SQUARE) == PatchFootprint(SQUARE)
    assert parse_footprint("corners", SQUARE) == corner_footprint(SQUARE)
    assert parse_footprint("grid:8", SQUARE) == grid_footprint(SQUARE, 8)
    for word in ("exct", "grid:", "grid:-1", "grid:1", "grid:x"):
        with pytest.raises(InvalidInput):
            parse_footprint(word, SQUARE)
    with pytest.raises(InvalidInput, match="polygons"):
        parse_footprint("corners", Ellipse(1.0, 1.0))


@pytest.mark.parametrize(
    ("positions", "weights"),
    [
        (((0, 0),), (1,)),
        (((0, 0), (0, 0)), (1, 1)),
        (((0, 0), (1, 0)), (1,)),
        (((0, 0), (1, 0)), (1, -1)),
        (((0, 0), (1, 0)), (0, 0)),
        (((0, 0), (1, float("nan"))), (1, 1)),
        (((0, 0, 0), (1, 0, 0)), (1, 1)),
        ((), ()),
    ],
)
def test_points_that_carry_no_object_are_refused(positions, weights):
    with pytest.raises(InvalidInput):
        PointFootprint(positions, weights)


def test_a_grid_takes_any_whole_number_of_points_a_side_and_no_other():
    square = Slider.mit("rect1").outline
    assert grid_footprint(square, np.int64(8)) == grid_footprint(square, 8)
    for count in (1, 0, -3, 2.5, True):
        with pytest.raises(InvalidInput, match="points a side of a grid footprint"):
            grid_footprint(square, count)
