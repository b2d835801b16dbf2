"""From one's own object to a judgement: what each command writes the next one reads, nothing edited by hand."""

import json
import math
import sys

import pytest

from cyclemap.cli.main import run
from cyclemap.collection import CollectionLoop


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def report(capsys, *arguments: str) -> dict:
    capsys.readouterr()
    assert run([*arguments, "--json", "-"]) == 0, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)


TEE = "M0 60H30V0H50V60H80V80H0Z"


def tee_svg(path) -> None:
    frame = 'width="80mm" height="80mm" viewBox="0 0 80 80"'
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {frame}><path d="{TEE}"/></svg>')


def tee_stl(path) -> None:
    trimesh = pytest.importorskip("trimesh")
    bar = trimesh.creation.box((80.0, 20.0, 15.0))
    stem = trimesh.creation.box((20.0, 60.0, 15.0)).apply_translation((0.0, 40.0, 0.0))
    trimesh.util.concatenate([bar, stem]).export(path)


@pytest.mark.slow
def test_a_tee_goes_all_the_way_from_its_file_to_comparison_and_replay(here, capsys) -> None:
    """From a mesh as from a drawing comes a file that all commands after it understand."""
    pytest.importorskip("shapely")
    tee_svg(here / "tee.svg")
    tee_stl(here / "tee.stl")
    settings = ["--surface", "felt", "--set", "mu_a=0.4", "--set", "mu_b=0.3"]
    mesh = report(capsys, "init", "mesh.toml", "--outline", "tee.stl", *settings)
    assert mesh["wrong"] == [] and mesh["doubts"] == [] and "80 x 80 mm" in mesh["said"][0]
    made = report(capsys, "init", "tee.toml", "--outline", "tee.svg", *settings)
    assert made["wrong"] == [] and made["doubts"] == [] and "80 x 80 mm" in made["said"][0]
    assert report(capsys, "check", "tee.toml")["doubts"] == []
    assert (here / "tee.png").stat().st_size > 10_000
    assert run(["simulate", "tee.toml", "--cycles", "12", "--noise-deg", "0.5", "--out", "data"]) == 0
    compared = report(capsys, "compare", "tee.toml", "--data", "data", "--runs", "19")
    assert "warnings" not in compared
    replayed = report(capsys, "replay", "tee.toml", "--data", "data")
    assert sum(row["count"] for row in replayed["by_object"]) == 12
    assert CollectionLoop.from_file("data/collection.toml").slider == CollectionLoop.from_file("tee.toml").slider
    # Another surface on the same data: object, push and ring are those that the data's own folder tells.
    assert run(["replay", "plywood", "--data", "data"]) == 0
    assert report(capsys, "audit", "data")["pushes"] == 12


@pytest.mark.slow
def test_data_whose_object_nobody_tells_are_refused_with_what_to_do(here, capsys) -> None:
    assert run(["init", "box.toml", "--rectangle-mm", "120,60"]) == 0
    assert run(["simulate", "box.toml", "--cycles", "4", "--out", "data"]) == 0
    (here / "data" / "collection.toml").unlink()
    capsys.readouterr()
    assert run(["compare", "isotropic", "--data", "data"]) == 2
    assert "put it with the data as collection.toml" in capsys.readouterr().err
    assert run(["replay", "plywood", "--data", "data"]) == 1
    assert "object 'box' has no outline" in capsys.readouterr().err


def test_an_own_outline_by_set_alone_is_told_what_it_takes_over_from_mit(here, capsys) -> None:
    outline = "vertices_mm=[[60,30],[-60,30],[-60,-30],[60,-30]]"
    told = report(capsys, "cycle", "plywood", "--set", outline, "--theta0-deg", "0")
    assert len(told["warnings"]) == 1 and "the ring, the mass" in told["warnings"][0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["box.txt", "--rectangle-mm", "1,2"], "must end in .toml"),
        (["box.toml"], "say what the object is"),
        (["box.toml", "--rectangle-mm", "120"], "give two lengths in mm"),
        (["box.toml", "--rectangle-mm", "120,-60"], "give two lengths in mm"),
        (["box.toml", "--rectangle-mm", "120,60", "--shape", "hex"], "both say the outline"),
        (["box.toml", "--shape", "hexx"], "did you mean 'hex'"),
        (["box.toml", "--outline", "gone.svg"], "there is no such file"),
        (["box.toml", "--rectangle-mm", "120,60", "--set", "hitch_x_mm=5000"], "same unit"),
    ],
)
def test_what_init_cannot_use_is_one_clear_line(here, capsys, monkeypatch, arguments, message) -> None:
    monkeypatch.setattr(sys.stdin, "isatty", lambda: False, raising=False)
    assert run(["init", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("error:") == 1
    assert not (here / "box.toml").exists()


@pytest.mark.slow
def test_init_asks_back_and_writes_over_nothing(here, capsys, monkeypatch) -> None:
    from click.testing import CliRunner

    from cyclemap.cli import command_init
    from cyclemap.cli.main import cli

    monkeypatch.setattr(command_init, "_is_asked", lambda: True)
    answers = "ellipse\n100,60\npuck\nglass\n"
    done = CliRunner().invoke(cli, ["init", "puck.toml"], input=answers)
    assert done.exit_code == 0, done.output
    loop = CollectionLoop.from_file("puck.toml")
    assert (loop.slider.name, loop.material.name) == ("puck", "glass")
    assert (loop.slider.outline.semi_x, loop.slider.outline.semi_y) == pytest.approx((0.05, 0.03))
    assert run(["init", "puck.toml", "--shape", "hex"]) == 2
    assert "is there already" in capsys.readouterr().err
    assert run(["init", "puck.toml", "--shape", "hex", "--force"]) == 0


def test_check_of_a_file_with_which_nothing_runs_ends_with_2_and_says_why(here, capsys) -> None:
    assert run(["init", "box.toml", "--rectangle-mm", "120,60"]) == 0
    path = here / "box.toml"
    path.write_text(path.read_text().replace("side = 0", "side = 7"))
    capsys.readouterr()
    assert run(["check", "box.toml"]) == 2
    assert "side" in capsys.readouterr().err
    assert (here / "out" / "check_box.png").is_file()


@pytest.mark.slow
def test_probe_of_a_function_a_program_and_data(here, capsys, monkeypatch) -> None:
    (here / "alike.py").write_text("def push(theta):\n    return 0.04, -0.07, 1.3\n")
    monkeypatch.syspath_prepend(str(here))
    assert report(capsys, "probe", "--python", "alike:push", "--count", "24")["found"] is False
    assert run(["init", "box.toml", "--rectangle-mm", "120,60", "--set", "mu_a=0.35", "--set", "mu_b=0.3"]) == 0
    assert run(["simulate", "box.toml", "--cycles", "40", "--noise-deg", "40", "--out", "data"]) == 0
    found = report(capsys, "probe", "box.toml", "--data", "data")
    assert found["found"] and found["axis_ratio"]["value"] == pytest.approx(0.35 / 0.3, abs=2e-3)
    assert math.isclose(found["offset"]["value"], 0.0, abs_tol=2e-3)
    assert run(["probe", "box.toml"]) == 2
    assert "say what is probed" in capsys.readouterr().err
    assert run(["probe", "--python", "gone:push"]) == 2


@pytest.mark.slow
def test_own_tables_are_read_by_fit_and_audit_and_told_on_stderr(here, capsys) -> None:
    rows = [f"{n};{(n * 27.3) % 360.0:.2f}".replace(".", ",") for n in range(30)]
    (here / "log.csv").write_text("\n".join(["Nr;Winkel vorher [°]", *rows]) + "\n")
    assert run(["fit", "log.csv"]) == 0
    shown = capsys.readouterr()
    assert "29 pairs" in shown.out and "read as theta0 in deg, by its name" in shown.err
    assert report(capsys, "audit", "log.csv")["pushes"] == 30
    (here / "bad.csv").write_text("speed;force\n1;2\n3;4\n")
    assert run(["fit", "bad.csv"]) == 2
    assert "say which, --columns theta0=NAME; it has speed, force" in capsys.readouterr().err
