"""`cyclemap sweep` from outside: run, gone on with after Ctrl-C, exported, drawn, and refused where
it must be.
"""

import csv
from typing import ClassVar

import numpy as np
import pytest

from cyclemap.cli import run_sweep as module
from cyclemap.collection import CollectionLoop
from cyclemap.errors import UnsupportedContact
from cyclemap.protocol import write_protocol
from cyclemap.resets import ResetStrategy, legs
from cyclemap.sweeps import PointOutcome, PortraitNumbers
from cyclemap.sweeps.portrait_numbers import GROUPS

RING = "sweep plywood --over hitch_x_mm=-12:0:5 --workers 1"
PLANE = f"{RING} --over mu_a=0.2,0.3"


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
        values |= {"locked_winding": 0.0, "locked_period": 0.0}
        values |= {"fixed_points": 1.0, "stable_points": 1.0, "gathering_jump_theta": ()}
        values |= {"fixed_point_theta": (np.pi,), "fixed_point_multiplier": (0.5,)}
        return PointOutcome({**values, "fixed_point_stable": (1.0,)})


@pytest.fixture
def fake(monkeypatch):
    """Points that cost nothing; tells which were found."""
    monkeypatch.setattr(module, "PortraitNumbers", Numbers)
    monkeypatch.setattr(Numbers, "found", [])
    monkeypatch.setattr(Numbers, "interrupted_after", np.inf)
    return Numbers


@pytest.mark.slow
def test_a_plane_is_stored_drawn_exported_and_told_and_not_computed_again(here, said, fake) -> None:
    shown = said(f"{PLANE} --export csv")
    assert shown.err == ""
    told = ("plywood: ring x × friction μa", "10 points over", "1 refused")
    for words in (*told, "file: out/sweep_plywood.sqlite"):
        assert words in shown.out
    names = ["sweep_plywood.csv", "sweep_plywood.png", "sweep_plywood.sqlite"]
    assert sorted(path.name for path in (here / "out").iterdir()) == names
    assert (here / "out" / "sweep_plywood.png").read_bytes().startswith(b"\x89PNG")
    with (here / "out" / "sweep_plywood.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["rotation"]) for row in rows[:4]] == [-0.12, -0.12, -0.09, -0.09]
    assert fake.found == list(range(10))
    assert said(f"{PLANE} --export csv").out == shown.out and fake.found == list(range(10))


@pytest.mark.slow
def test_json_tells_every_point_and_nothing_else(here, report_of, fake) -> None:
    report = report_of(PLANE)
    assert [report[key] for key in ("points", "stored", "refused", "complete")] == [10, 10, 1, True]
    axes = {"hitch_x_mm": [-12.0, -9.0, -6.0, -3.0, 0.0], "mu_a": [0.2, 0.3]}
    assert report["over"]["axes"] == axes
    assert report["units"]["fixed_point_theta_deg"] == "degree"
    first, last = (report["results"][place].items() for place in (0, -1))
    told = {"hitch_x_mm": -12.0, "mu_a": 0.2, "rotation": -0.12, "refusal": None}
    assert told.items() <= first
    assert dict(first)["fixed_point_theta_deg"] == [pytest.approx(180.0)]
    none = {"rotation": None, "fixed_point_theta_deg": [], "refusal": "no such loop"}
    assert dict(last) | none == dict(last)


def test_ctrl_c_tells_what_is_kept_and_the_same_command_goes_on(
    here, said, report_of, fake, monkeypatch
) -> None:
    assert "0 of 5 points stored (0 %), 0 refused" in said(f"{RING} --status").out
    assert fake.found == list(here.iterdir()) == []
    monkeypatch.setattr(fake, "interrupted_after", 3)
    shown = said(RING, 130)
    kept = "of 5 points are stored in out/sweep_plywood.sqlite; the same command goes on"
    assert shown.out == "" and kept in shown.err
    status = report_of(f"{RING} --status")
    assert (status["points"], status["complete"]) == (5, False)
    assert 1 <= status["stored"] <= 3
    monkeypatch.setattr(fake, "interrupted_after", np.inf)
    fake.found.clear()
    said(RING)
    assert fake.found == list(range(status["stored"], 5))


def test_a_sample_over_materials_goes_by_its_seed(here, report_of, said, fake) -> None:
    line = "sweep --over material=abs,pu --over hitch_x_mm=-12:-4 --sample 8 --workers 1"
    results = report_of(f"{line} --seed 3")["results"]
    assert len(results) == 8
    assert {point["material"] for point in results} == {"abs", "pu"}
    assert all(-12.0 <= point["hitch_x_mm"] < -4.0 for point in results)
    assert [path.name for path in (here / "out").iterdir()] == ["sweep_abs_pu.sqlite"]
    told = "another sweep, which differs in points: choose another folder"
    assert told in said(f"{line} --seed 4", 2).err


@pytest.mark.slow
def test_a_real_sweep_of_noise_and_netcdf(here, report_of) -> None:
    """Isotropic friction: whatever the noise, the map turns by 8.002 degrees a cycle."""
    xarray = pytest.importorskip("xarray")
    line = "sweep isotropic --over noise_deg=20,40 --quantities rotation,stationary --workers 1"
    more = "--tolerance-deg 0.5 --export netcdf --draw tv_from_uniform"
    results = report_of(f"{line} {more}", silent=False)["results"]
    turns = [360 * point["rotation"] for point in results]
    assert turns == pytest.approx([74.52037 - 66.51814] * 2, abs=0.5)
    gap = 1.0 - np.exp(-0.5 * np.radians(20.0) ** 2)
    assert results[0]["spectral_gap"] == pytest.approx(gap, abs=1e-4)
    with xarray.open_dataset(here / "out" / "sweep_isotropic.nc", engine="h5netcdf") as back:
        assert back["rotation"].values.tolist() == [point["rotation"] for point in results]


def test_what_is_swept_overrules_the_protocol_file_which_may_name_no_strategy(
    here, report_of, refused, fake
) -> None:
    (here / "mine.toml").write_text("[ring]\nhitch_x_mm = -9\nhitch_y_mm = 9\n")
    report = report_of(f"{RING} --protocol mine.toml --set mu_a=0.26")
    assert report["settings"] == {"hitch_y_mm": 9.0, "mu_a": 0.26}
    assert report["over"]["axes"]["hitch_x_mm"][0] == -12.0
    write_protocol(here / "leg.toml", CollectionLoop.mit(), ResetStrategy(legs(0.05, 4)))
    words = "leg.toml: a sweep is about one push and one drag back"
    refused(f"{RING} --protocol leg.toml", words)


def test_of_an_own_object_nothing_is_said_that_is_swept_or_told(here, report_of, fake) -> None:
    own = "vertices_mm=[[100,2],[-100,2],[-100,-2],[100,-2]] mass_kg=1 hitch_x_mm=-5 hitch_y_mm=0"
    settings = f"{own} side=0 fraction=0.7 pusher_radius_mm=5".split(" ")
    given = " ".join(f"--set {setting}" for setting in settings)
    report_of(f"sweep isotropic {given} --over push_mm=40,45 --workers 1")
