"""`cyclemap simulate` from outside: its JSON, its words, its files, and what it refuses."""

import math

import pytest

import cyclemap as cm
from cyclemap.cli.main import run
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.evidence.pushes.push_table import load_pushes
from cyclemap.text_files import read_toml

KEYS = ["folder", "cycles", "written", "resumed", "theta0_deg_last", "bytes"]


def simulate(folder, *more: str) -> int:
    return run(["simulate", "plywood", "--cycles", "3", "--out", str(folder), *more])


def test_json_tells_what_was_written_and_found_and_nothing_else(tmp_path, report_of) -> None:
    folder = tmp_path / "made"
    first, second = (
        report_of("simulate", "plywood", "--cycles", "3", "--out", str(folder)) for _ in range(2)
    )
    assert list(first) == KEYS
    assert (first["cycles"], first["written"], first["resumed"]) == (3, 3, 0)
    assert second == first | {"written": 0, "resumed": 3}
    files = list(folder.rglob("*.h5"))
    assert len(files) == 3 and first["bytes"] == sum(file.stat().st_size for file in files)
    last = load_pushes(folder).table["theta0"].iloc[-1]
    assert math.radians(first["theta0_deg_last"]) == pytest.approx(last, abs=1e-12)


def test_options_reach_the_collection_in_si_units(tmp_path) -> None:
    options = [
        "--start-deg",
        "90",
        "--seed",
        "5",
        "--pose-noise-mm",
        "0.2",
        "--pose-noise-deg",
        "0.5",
    ]
    options += [
        "--force-noise-n",
        "0.03",
        "--speed-mm-s",
        "50",
        "--noise-deg",
        "2",
        "--wear-to",
        "isotropic",
    ]
    assert (
        simulate(
            tmp_path, *options, "--format", "json", "--set", "push_mm=40", "--set", "noise_deg=3"
        )
        == 0
    )
    found = read_toml(tmp_path / "collection.toml")["simulation"]
    expected = {
        "start_rad": math.pi / 2.0,
        "seed": 5,
        "speed_m_s": 0.05,
        "noise_turn_rad": math.radians(2.0),
    }
    expected |= {
        "noise_position_m": 2e-4,
        "noise_angle_rad": math.radians(0.5),
        "noise_force_n": 0.03,
    }
    assert {name: found[name] for name in expected} == pytest.approx(expected)
    assert (found["accuracy"], found["suffix"], found["scans"]) == ("1e-06", ".json", False)
    assert len(list(tmp_path.rglob("*.json"))) == 3
    assert "distance=0.04" in str(found["push"]) and "EllipseFriction" in str(found["wear_to"])
    table = load_pushes(tmp_path).table
    assert table["speed"].tolist() == [0.05] * 3
    assert table["theta0"].iloc[0] == pytest.approx(math.pi / 2.0, abs=0.05)


@pytest.mark.parametrize(
    ("options", "sigma"),
    [
        ([], DEFAULT_SIGMA),
        (["--set", "noise_deg=3"], math.radians(3.0)),
        (["--noise-deg", "0"], 0.0),
    ],
)
def test_the_scatter_is_the_options_else_the_settings_else_the_packages(
    tmp_path, options, sigma
) -> None:
    assert simulate(tmp_path, *options) == 0
    assert read_toml(tmp_path / "collection.toml")["simulation"]["noise_turn_rad"] == pytest.approx(
        sigma
    )


def test_a_folder_that_cannot_be_used_is_refused_by_name(here, refused) -> None:
    assert simulate(here / "made") == 0
    refused(
        ["simulate", "plywood", "--cycles", "3", "--out", "made", "--seed", "7"],
        "seed is 0 there and 7 here",
    )
    (here / "file").write_text("in the way")
    refused(
        ["simulate", "plywood", "--out", "file/made"],
        "file/made cannot be used (Not a directory)",
        1,
    )


def test_a_material_that_knows_its_noise_scatters_by_it_unless_told_otherwise(
    tmp_path, capsys
) -> None:
    asked = ["simulate", "plywood-measured", "--cycles", "2", "--out"]
    assert run([*asked, str(tmp_path / "own")]) == 0
    assert run([*asked, str(tmp_path / "told"), "--noise-deg", "2"]) == 0
    own, told = (read_toml(tmp_path / name / "collection.toml") for name in ("own", "told"))
    assert (
        "LocalNoise" in own["simulation"]["cycle_noise"] and "cycle_noise" not in told["simulation"]
    )
    again = cm.protocol.loop_from_file(tmp_path / "own" / "collection.toml")
    assert again.material.noise == cm.load_material("plywood-measured").noise
