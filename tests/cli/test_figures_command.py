"""`cyclemap figures` from outside: the list, the files, the index, what people are told, and what
it refuses.
"""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from cyclemap.cli import run_figures as command
from cyclemap.cli.main import run
from cyclemap.errors import ConvergenceError
from cyclemap.figures.catalogue import CATALOGUE, NO_DATA, Exhibit, Frame, entries
from cyclemap.views.panels.layout import new_figure

KEYS = ["name", "title", "source", "caption", "file", "measured"]


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch) -> Path:
    """An empty current folder, and quick exhibits in place of four slow ones."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("CYCLEMAP_DATA", raising=False)
    quick = {"staircases": _figure(), "table-friction": _table(), "locking-in": _animation()}
    quick["fingerprint"] = _figure(fails=True)
    monkeypatch.setattr(command, "load_exhibit", quick.__getitem__)
    return tmp_path


def _figure(fails: bool = False) -> Exhibit:
    """It asks for a data file and counts its lines, or fails."""

    def compute(measured):
        if fails:
            raise ConvergenceError("it does not converge; try again")
        file = measured.find("given.csv")
        return 0 if file is None else len(file.read_text().splitlines())

    return Exhibit(
        compute=compute, draw=lambda _: new_figure(2, 1), caption=lambda n: f"{n} lines."
    )


def _table() -> Exhibit:
    rows = [
        ("plywood, table I", "0.2545"),
        ("a surface whose name is longer than a narrow terminal is wide", "0.25"),
    ]
    return Exhibit(
        compute=lambda _: rows,
        header=("surface", "μa"),
        rows=lambda found: found,
        caption=lambda _: "Friction.",
    )


def _animation() -> Exhibit:
    def frames(result):
        for place in range(result):
            pixels = np.full((6, 6, 3), 255, dtype=np.uint8)
            pixels[place] = 0
            yield Frame(pixels, 0.1)

    return Exhibit(compute=lambda _: 3, frames=frames, caption=lambda _: "It moves.")


def test_without_a_name_all_are_listed_with_source_and_title(capsys) -> None:
    assert run(["figures"]) == 0
    shown = capsys.readouterr().out
    for entry in entries():
        (line,) = [line for line in shown.splitlines() if line.startswith(f"{entry.name} ")]
        assert entry.title in line and entry.source in line
    assert run(["figures", "--json", "-"]) == 0
    listed = json.loads(capsys.readouterr().out)["figures"]
    assert [one["name"] for one in listed] == [entry.name for entry in CATALOGUE]


def test_figures_tables_and_animations_are_written_with_an_index_of_their_captions(
    here, printed
) -> None:
    assert (
        run(
            [
                "figures",
                "locking-in",
                "table-friction",
                "staircases",
                "--out",
                "gallery",
                "--json",
                "-",
            ]
        )
        == 0
    )
    report, _ = printed()
    made, folder = report["figures"], here / "gallery"
    assert report["failed"] == [] and all(list(one) == KEYS for one in made)
    assert [one["name"] for one in made] == ["staircases", "table-friction", "locking-in"]
    files = ["figures.json", "locking-in.gif", "staircases.png", "table-friction.csv"]
    assert sorted(path.name for path in folder.iterdir()) == files
    assert json.loads((folder / "figures.json").read_text())["figures"] == made
    assert (folder / "staircases.png").read_bytes().startswith(b"\x89PNG")
    rows = list(csv.reader(io.StringIO((folder / "table-friction.csv").read_text())))
    assert rows[:2] == [["surface", "μa"], ["plywood, table I", "0.2545"]]
    with Image.open(folder / "locking-in.gif") as picture:
        assert picture.n_frames == 3


def test_an_earlier_index_is_kept_replaced_by_name_and_put_in_order(here) -> None:
    for arguments in (
        ["locking-in"],
        ["staircases", "--format", "svg"],
        ["staircases", "--format", "png"],
    ):
        assert run(["figures", *arguments]) == 0
    lines = json.loads((here / "out" / "figures.json").read_text())["figures"]
    expected = [("staircases", "staircases.png"), ("locking-in", "locking-in.gif")]
    assert [(one["name"], one["file"]) for one in lines] == expected


def test_people_are_told_caption_file_whole_tables_and_which_measured_data_were_found(
    here, capsys, monkeypatch
) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    (here / "data").mkdir()
    assert run(["figures", "staircases", "table-friction", "--data", "data"]) == 0
    shown = capsys.readouterr().out
    assert shown.count(NO_DATA) == 1 and "0 lines." in shown
    for part in (
        "Friction ellipses of the materials",
        "Friction.",
        "table-friction.csv",
        "plywood, table I",
        "0.2545",
    ):
        assert part in shown
    assert "longer than a narrow terminal is wide" in shown
    (here / "data" / "given.csv").write_text("a\nb\n")
    assert run(["figures", "staircases", "--data", "data"]) == 0
    shown = capsys.readouterr().out
    assert "2 lines." in shown and "measured data: given.csv" in shown
    line, other = json.loads((here / "out" / "figures.json").read_text())["figures"]
    assert (line["measured"], other["measured"]) == ("given.csv", None)


def test_one_that_fails_loses_none_of_the_others_and_is_told_with_exit_1(here, capsys) -> None:
    assert run(["figures", "staircases", "fingerprint", "locking-in", "--json", "-"]) == 1
    shown = capsys.readouterr()
    report = json.loads(shown.out)
    assert [one["name"] for one in report["figures"]] == ["staircases", "locking-in"]
    assert report["failed"] == [{"name": "fingerprint", "error": "it does not converge; try again"}]
    assert "1 of 3 could not be made: fingerprint: it does not converge" in shown.err
    lines = json.loads((here / "out" / "figures.json").read_text())["figures"]
    assert [one["name"] for one in lines] == ["staircases", "locking-in"]


@pytest.mark.parametrize("text", ["{", '{"figures": [1]}', '{"figures": [{"name": "x"}]}', "[]"])
def test_a_folder_with_another_kind_of_figures_json_is_left_alone(here, refused, text) -> None:
    (here / "out").mkdir()
    (here / "out" / "figures.json").write_text(text)
    refused(["figures", "staircases"], "not an index of figures")
    assert (here / "out" / "figures.json").read_text() == text
