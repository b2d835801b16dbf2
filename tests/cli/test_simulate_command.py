"""`cyclemap simulate` from outside: its JSON, its files, and what it refuses."""

import math

import pytest

import cyclemap as cm
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.evidence.pushes.push_table import load_pushes
from cyclemap.text_files import read_toml

SIMULATE = "simulate plywood --cycles 3 --out made"


def recorded() -> dict:
    """What the collection's file tells of its simulation."""
    return read_toml("made/collection.toml")["simulation"]


def test_json_tells_what_was_written_and_found_and_nothing_else(here, report_of) -> None:
    first, second = (report_of(SIMULATE) for _ in range(2))
    assert " ".join(first) == "folder cycles written resumed theta0_deg_last bytes"
    assert (first["cycles"], first["written"], first["resumed"]) == (3, 3, 0)
    assert second == first | {"written": 0, "resumed": 3}
    files = list(here.rglob("*.h5"))
    assert len(files) == 3 and first["bytes"] == sum(file.stat().st_size for file in files)
    last = load_pushes("made").table["theta0"].iloc[-1]
    assert math.radians(first["theta0_deg_last"]) == pytest.approx(last, abs=1e-12)


def test_options_reach_the_collection_in_si_units(here, said) -> None:
    poses = "--start-deg 90 --seed 5 --pose-noise-mm 0.2 --pose-noise-deg 0.5"
    others = "--force-noise-n 0.03 --speed-mm-s 50 --noise-deg 2 --wear-to isotropic"
    said(f"{SIMULATE} {poses} {others} --format json --set push_mm=40 --set noise_deg=3")
    found = recorded()
    expected = {
        "start_rad": math.pi / 2.0,
        "seed": 5,
        "speed_m_s": 0.05,
        "noise_turn_rad": math.radians(2.0),
        "noise_position_m": 2e-4,
        "noise_angle_rad": math.radians(0.5),
        "noise_force_n": 0.03,
    }
    assert {name: found[name] for name in expected} == pytest.approx(expected)
    assert (found["accuracy"], found["suffix"], found["scans"]) == ("1e-06", ".json", False)
    assert len(list(here.rglob("*.json"))) == 3
    assert "distance=0.04" in str(found["push"]) and "EllipseFriction" in str(found["wear_to"])
    table = load_pushes("made").table
    assert table["speed"].tolist() == [0.05] * 3
    assert table["theta0"].iloc[0] == pytest.approx(math.pi / 2.0, abs=0.05)


@pytest.mark.parametrize(
    ("options", "sigma"),
    [("", DEFAULT_SIGMA), ("--set noise_deg=3", math.radians(3.0)), ("--noise-deg 0", 0.0)],
)
def test_the_scatter_is_the_options_else_the_settings_else_the_packages(
    here, said, options, sigma
) -> None:
    said(f"{SIMULATE} {options}")
    assert recorded()["noise_turn_rad"] == pytest.approx(sigma)


def test_a_folder_that_cannot_be_used_is_refused_by_name(here, said, refused) -> None:
    said(SIMULATE)
    refused(f"{SIMULATE} --seed 7", "seed is 0 there and 7 here")
    (here / "file").write_text("in the way")
    told = "file/made cannot be used (Not a directory)"
    refused("simulate plywood --out file/made", told, 1)


def test_a_material_that_knows_its_noise_scatters_by_it_unless_told_otherwise(here, said) -> None:
    line = "simulate plywood-measured --cycles 2 --out made"
    said(line)
    again = cm.protocol.loop_from_file("made/collection.toml")
    assert again.material.noise == cm.load_material("plywood-measured").noise
    assert "LocalNoise" in recorded()["cycle_noise"]
    (here / "made").rename(here / "own")
    said(f"{line} --noise-deg 2")
    assert "cycle_noise" not in recorded()
