"""`cyclemap figures` from outside: the list, the files, the index, what people are told, and what
it refuses.
"""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from cyclemap.cli import run_figures as command
from cyclemap.errors import ConvergenceError
from cyclemap.figures import CATALOGUE, NO_DATA, Exhibit, Frame, entries
from cyclemap.views.panels.layout import new_figure

KEYS = ["name", "title", "source", "caption", "file", "measured"]


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch) -> Path:
    """An empty current folder, and quick exhibits in place of four slow ones."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("CYCLEMAP_DATA", raising=False)
    rows = [("plywood, table I", "0.2545"), ("a name longer than a narrow terminal is wide", ".25")]
    quick = {
        "staircases": Exhibit(
            compute=lines_given,
            draw=lambda _: new_figure(2, 1),
            caption=lambda count: f"{count} lines.",
        ),
        "table-friction": Exhibit(
            compute=lambda _: rows,
            header=("surface", "μa"),
            rows=lambda found: found,
            caption=lambda _: "Friction.",
        ),
        "locking-in": Exhibit(
            compute=lambda _: 3, frames=moving_line, caption=lambda _: "It moves."
        ),
        "fingerprint": Exhibit(compute=failing, draw=new_figure, caption=str),
    }
    monkeypatch.setattr(command, "load_exhibit", quick.__getitem__)
    return tmp_path


def lines_given(measured) -> int:
    """Ask for a data file, and count its lines."""
    file = measured.find("given.csv")
    return 0 if file is None else len(file.read_text().splitlines())


def moving_line(count):
    for place in range(count):
        pixels = np.full((6, 6, 3), 255, dtype=np.uint8)
        pixels[place] = 0
        yield Frame(pixels, 0.1)


def failing(measured):
    raise ConvergenceError("it does not converge; try again")


def index(folder: Path) -> list[dict]:
    return json.loads((folder / "figures.json").read_text())["figures"]


def test_without_a_name_all_are_listed_with_source_and_title(said, report_of) -> None:
    shown = said("figures").out
    for entry in entries():
        (line,) = [line for line in shown.splitlines() if line.startswith(f"{entry.name} ")]
        assert entry.title in line and entry.source in line
    listed = report_of("figures")["figures"]
    assert [row["name"] for row in listed] == [entry.name for entry in CATALOGUE]


def test_figures_tables_and_animations_are_written_with_an_index_of_their_captions(
    here, report_of
) -> None:
    report = report_of("figures locking-in table-friction staircases --out gallery")
    made, folder = report["figures"], here / "gallery"
    assert report["failed"] == [] and all(list(row) == KEYS for row in made)
    assert [row["name"] for row in made] == ["staircases", "table-friction", "locking-in"]
    files = ["figures.json", "locking-in.gif", "staircases.png", "table-friction.csv"]
    assert sorted(path.name for path in folder.iterdir()) == files
    assert index(folder) == made
    assert (folder / "staircases.png").read_bytes().startswith(b"\x89PNG")
    rows = list(csv.reader((folder / "table-friction.csv").read_text().splitlines()))
    assert rows[:2] == [["surface", "μa"], ["plywood, table I", "0.2545"]]
    with Image.open(folder / "locking-in.gif") as picture:
        assert picture.n_frames == 3


def test_an_earlier_index_is_kept_replaced_by_name_and_put_in_order(here, said) -> None:
    for words in ("locking-in", "staircases --format svg", "staircases --format png"):
        said(f"figures {words}")
    expected = [("staircases", "staircases.png"), ("locking-in", "locking-in.gif")]
    assert [(row["name"], row["file"]) for row in index(here / "out")] == expected


def test_people_are_told_caption_file_whole_tables_and_which_measured_data_were_found(
    here, said, monkeypatch
) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    (here / "data").mkdir()
    shown = said("figures staircases table-friction --data data").out
    assert shown.count(NO_DATA) == 1
    told = ("0 lines.", "Friction ellipses of the materials", "Friction.", "table-friction.csv")
    table = ("plywood, table I", "0.2545", "longer than a narrow terminal is wide")
    for words in (*told, *table):
        assert words in shown
    (here / "data" / "given.csv").write_text("a\nb\n")
    shown = said("figures staircases --data data").out
    assert "2 lines." in shown and "measured data: given.csv" in shown
    assert [row["measured"] for row in index(here / "out")] == ["given.csv", None]


def test_a_figure_that_fails_loses_none_of_the_others_and_is_told_with_exit_1(here, said) -> None:
    shown = said("figures staircases fingerprint locking-in --json -", 1)
    report = json.loads(shown.out)
    assert report["failed"] == [{"name": "fingerprint", "error": "it does not converge; try again"}]
    assert "1 of 3 could not be made: fingerprint: it does not converge" in shown.err
    for made in (report["figures"], index(here / "out")):
        assert [row["name"] for row in made] == ["staircases", "locking-in"]


@pytest.mark.parametrize("text", ["{", '{"figures": [1]}', '{"figures": [{"name": "x"}]}', "[]"])
def test_a_folder_with_another_kind_of_figures_json_is_left_alone(here, refused, text) -> None:
    (here / "out").mkdir()
    (here / "out" / "figures.json").write_text(text)
    refused("figures staircases", "not an index of figures")
    assert (here / "out" / "figures.json").read_text() == text
