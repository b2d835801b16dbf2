"""`cyclemap sweep` from outside: run, gone on with after Ctrl-C, exported, drawn, and refused where
it must be.
"""

import csv
import json
from typing import ClassVar

import numpy as np
import pytest
from refusals import refused

from cyclemap.cli import run_sweep as module
from cyclemap.cli.commands import cli
from cyclemap.collection import CollectionLoop
from cyclemap.errors import UnsupportedContact
from cyclemap.protocol import write_protocol
from cyclemap.resets import ResetStrategy, legs
from cyclemap.sweeps import PointOutcome, PortraitNumbers
from cyclemap.sweeps.portrait_numbers import GROUPS

RING = ("--over", "hitch_x_mm=-12:0:5", "--workers", "1")
PLANE = (*RING, "--over", "mu_a=0.2,0.3")


class Numbers(PortraitNumbers):
    """The rotation number is a hundredth of hitch_x_mm; mu_a of 0.3 is refused at 0; Ctrl-C after
    some points.
    """

    found: ClassVar[list[int]] = []
    interrupted_after: ClassVar[float] = np.inf

    @property
    def quantities(self):
        return (*GROUPS["rotation"], *GROUPS["fixed_points"])

    def __call__(self, point):
        if len(self.found) >= self.interrupted_after:
            raise KeyboardInterrupt
        self.found.append(point.number)
        x = point.settings["hitch_x_mm"]
        if x == 0.0 and point.settings.get("mu_a") == 0.3:
            return PointOutcome({}, str(UnsupportedContact("no such loop")))
        values = dict.fromkeys(("rotation", "rotation_lower", "rotation_upper"), x / 100)
        counts = {
            "locked_winding": 0.0,
            "locked_period": 0.0,
            "fixed_points": 1.0,
            "stable_points": 1.0,
        }
        lists = {
            "fixed_point_theta": (np.pi,),
            "fixed_point_multiplier": (0.5,),
            "fixed_point_stable": (1.0,),
        }
        return PointOutcome({**values, **counts, **lists, "gathering_jump_theta": ()})


@pytest.fixture
def fake(monkeypatch):
    """Points that cost nothing; tells which were found."""
    monkeypatch.setattr(module, "PortraitNumbers", Numbers)
    monkeypatch.setattr(Numbers, "found", [])
    monkeypatch.setattr(Numbers, "interrupted_after", np.inf)
    return Numbers


def sweep(*arguments: str) -> None:
    with cli.commands["sweep"].make_context("sweep", list(arguments)) as context:
        cli.commands["sweep"].invoke(context)


@pytest.mark.slow
def test_a_plane_is_stored_drawn_exported_and_told_and_not_computed_again(
    here, capsys, fake
) -> None:
    sweep("plywood", *PLANE, "--export", "csv")
    shown = capsys.readouterr()
    assert shown.err == ""
    for part in (
        "plywood: ring x × friction μa",
        "10 points over",
        "1 refused",
        "file: out/sweep_plywood.sqlite",
    ):
        assert part in shown.out
    names = ["sweep_plywood.csv", "sweep_plywood.png", "sweep_plywood.sqlite"]
    assert sorted(path.name for path in (here / "out").iterdir()) == names
    assert (here / "out" / "sweep_plywood.png").read_bytes().startswith(b"\x89PNG")
    with (here / "out" / "sweep_plywood.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["rotation"]) for row in rows[:4]] == [-0.12, -0.12, -0.09, -0.09]
    assert fake.found == list(range(10))
    sweep("plywood", *PLANE, "--export", "csv")
    assert capsys.readouterr().out == shown.out and fake.found == list(range(10))


@pytest.mark.slow
def test_json_tells_every_point_and_nothing_else(here, printed, fake) -> None:
    sweep("plywood", *PLANE, "--json", "-")
    report, _ = printed()
    assert [report[key] for key in ("points", "stored", "refused", "complete")] == [10, 10, 1, True]
    assert report["over"]["axes"] == {
        "hitch_x_mm": [-12.0, -9.0, -6.0, -3.0, 0.0],
        "mu_a": [0.2, 0.3],
    }
    assert report["units"]["fixed_point_theta_deg"] == "degree"
    first, last = report["results"][0], report["results"][-1]
    assert (first["hitch_x_mm"], first["mu_a"], first["rotation"], first["refusal"]) == (
        -12.0,
        0.2,
        -0.12,
        None,
    )
    assert first["fixed_point_theta_deg"] == [pytest.approx(180.0)]
    assert (last["rotation"], last["fixed_point_theta_deg"], last["refusal"]) == (
        None,
        [],
        "no such loop",
    )


def test_ctrl_c_tells_what_is_kept_and_the_same_command_goes_on(
    here, capsys, fake, monkeypatch
) -> None:
    sweep("plywood", *RING, "--status")
    assert "0 of 5 points stored (0 %), 0 refused" in capsys.readouterr().out
    assert fake.found == list(here.iterdir()) == []
    monkeypatch.setattr(fake, "interrupted_after", 3)
    with pytest.raises(KeyboardInterrupt):
        sweep("plywood", *RING)
    shown = capsys.readouterr()
    assert shown.out == ""
    assert (
        "of 5 points are stored in out/sweep_plywood.sqlite; the same command goes on" in shown.err
    )
    sweep("plywood", *RING, "--status", "--json", "-")
    status = json.loads(capsys.readouterr().out)
    assert (status["points"], status["complete"]) == (5, False)
    assert 1 <= status["stored"] <= 3
    monkeypatch.setattr(fake, "interrupted_after", np.inf)
    fake.found.clear()
    sweep("plywood", *RING)
    assert fake.found == list(range(status["stored"], 5))


def test_a_sample_over_materials_goes_by_its_seed(here, capsys, fake) -> None:
    arguments = (
        "--over",
        "material=abs,pu",
        "--over",
        "hitch_x_mm=-12:-4",
        "--sample",
        "8",
        "--workers",
        "1",
    )
    sweep(*arguments, "--seed", "3", "--json", "-")
    results = json.loads(capsys.readouterr().out)["results"]
    assert len(results) == 8
    assert {point["material"] for point in results} == {"abs", "pu"}
    assert all(-12.0 <= point["hitch_x_mm"] < -4.0 for point in results)
    assert [path.name for path in (here / "out").iterdir()] == ["sweep_abs_pu.sqlite"]
    refused(
        sweep,
        *arguments,
        "--seed",
        "4",
        told="another sweep, which differs in points: choose another folder",
    )


@pytest.mark.slow
def test_a_real_sweep_of_noise_and_netcdf(here, capsys) -> None:
    """Isotropic friction: whatever the noise, the map turns by 8.002 degrees a cycle."""
    xarray = pytest.importorskip("xarray")
    over = (
        "--over",
        "noise_deg=20,40",
        "--quantities",
        "rotation,stationary",
        "--tolerance-deg",
        "0.5",
    )
    sweep(
        "isotropic",
        *over,
        "--workers",
        "1",
        "--export",
        "netcdf",
        "--draw",
        "tv_from_uniform",
        "--json",
        "-",
    )
    results = json.loads(capsys.readouterr().out)["results"]
    assert [360 * point["rotation"] for point in results] == pytest.approx(
        [74.52037 - 66.51814] * 2, abs=0.5
    )
    assert results[0]["spectral_gap"] == pytest.approx(
        1.0 - np.exp(-0.5 * np.radians(20.0) ** 2), abs=1e-4
    )
    with xarray.open_dataset(here / "out" / "sweep_isotropic.nc", engine="h5netcdf") as back:
        assert back["rotation"].values.tolist() == [point["rotation"] for point in results]


def test_what_is_swept_overrules_the_protocol_file_which_may_name_no_strategy(
    here, capsys, fake
) -> None:
    (here / "mine.toml").write_text("[ring]\nhitch_x_mm = -9\nhitch_y_mm = 9\n")
    sweep("plywood", *RING, "--protocol", "mine.toml", "--set", "mu_a=0.26", "--json", "-")
    report = json.loads(capsys.readouterr().out)
    assert report["settings"] == {"hitch_y_mm": 9.0, "mu_a": 0.26}
    assert report["over"]["axes"]["hitch_x_mm"][0] == -12.0
    write_protocol(here / "leg.toml", CollectionLoop.mit(), ResetStrategy(legs(0.05, 4)))
    told = "leg.toml: a sweep is about one push and one drag back"
    refused(sweep, "plywood", *RING, "--protocol", "leg.toml", told=told)


def test_of_an_own_object_nothing_is_said_that_is_swept_or_told(here, capsys, fake) -> None:
    own = ("vertices_mm=[[100,2],[-100,2],[-100,-2],[100,-2]]", "mass_kg=1", "hitch_x_mm=-5")
    own = (*own, "hitch_y_mm=0", "side=0", "fraction=0.7", "pusher_radius_mm=5")
    given = [word for setting in own for word in ("--set", setting)]
    sweep("isotropic", *given, "--over", "push_mm=40,45", "--json", "-")
    assert "warning" not in capsys.readouterr().err
