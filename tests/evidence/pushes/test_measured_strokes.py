"""Reading measured pushes and drags with known rod paths."""

import math
from pathlib import Path

import pytest
from refusals import refused

from cyclemap.errors import DataFileError
from cyclemap.evidence.pushes.measured_strokes import (
    MeasuredPush,
    RowSelection,
    measured_drags,
    measured_pushes,
    selected,
)
from cyclemap.evidence.tables.columns import DRAG_ENDS, ENDS, RODS, known_columns
from cyclemap.mechanics import Pose
from cyclemap.text_files import read_csv_table

HEADER = "surface,shape,i,s,x0,y0,th0,x1,y1,th1,tip_x0,tip_y0,tip_x1,tip_y1,tip_err_mm"
ROWS = (
    "abs,rect1,0,0.5,0,0,3.1,0.01,0,-3.1,0.1,0,0.05,0,0.1",
    "abs,rect1,0,0.5,0,0,0.1,0.01,0,0.2,0.1,0,0.05,0,6.0",
    "abs,rect1,1,0.5,0,0,0.1,0.01,0,0.2,0.1,0,0.05,0,0.2",
    "abs,hex,1,0.5,0,0,0.1,0.01,0,0.2,0.1,0,0.05,0,0.2",
)


def written(folder: Path, *rows: str, header: str = HEADER) -> Path:
    path = folder / "pushes.csv"
    path.write_text("\n".join((header, *rows)) + "\n")
    return path


def pushes_in(path: Path, **chosen: str) -> tuple[MeasuredPush, ...]:
    """The pushes of the rows whose facts are these."""
    rows = known_columns(read_csv_table(path), (*ENDS, *RODS))
    objects = (chosen["object"],) if "object" in chosen else ()
    return measured_pushes(selected(rows, RowSelection(objects, chosen))[0])


def test_rows_of_other_objects_and_of_missed_pushes_are_left_out(tmp_path: Path) -> None:
    pushes = pushes_in(written(tmp_path, *ROWS), surface="abs", object="rect1")
    assert [push.contact for push in pushes] == [0, 1]
    # The last orientation is the one nearest to the first.
    assert pushes[0].end.theta == pytest.approx(2.0 * math.pi - 3.1)
    assert (pushes[0].direction, pushes[0].length) == (math.pi, pytest.approx(0.05))
    repeated = pushes_in(written(tmp_path, ROWS[0], *ROWS), object="rect1")
    assert [push.contact for push in repeated] == [0, 0, 1]
    assert pushes_in(written(tmp_path, *ROWS), surface="felt") == ()


def test_drags_are_read_with_a_group_each(tmp_path: Path) -> None:
    header = "surface,x1,y1,th1,x0n,y0n,th0n"
    rows = ("abs,0.3,0,-3.1,0.35,0,3.1", "abs,0.3,0,1.0,0.35,0,1.2")
    table = read_csv_table(written(tmp_path, *rows, header=header))
    drags = measured_drags(known_columns(table, DRAG_ENDS))
    assert [drag.contact for drag in drags] == [0, 1]
    assert drags[0].end.theta == pytest.approx(3.1 - 2.0 * math.pi)


def test_what_cannot_be_read_is_named_with_its_line(tmp_path: Path) -> None:
    refused(pushes_in, written(tmp_path, "1,2", header="x0,y0"), told="tip_x0", kind=DataFileError)
    still = written(tmp_path, ROWS[2], "abs,rect1,0,0.5,0,0,0.1,0.01,0,0.2,0.1,0,0.1,0,0.2")
    refused(pushes_in, still, told=r"line 3.*rod stays", kind=DataFileError)
    refused(MeasuredPush, Pose(), Pose(), (0.1, 0.0), (0.1, 0.0), told="moves nothing")


def test_a_name_is_the_same_as_people_and_as_files_write_it() -> None:
    selection = RowSelection(("my_plate",))
    assert selection.refusal({"object": "my plate"}) == ""
    assert selection.refusal({"object": "my_plate"}) == ""
    assert selection.refusal({"object": "your plate"}) == "of your plate, not my_plate"
