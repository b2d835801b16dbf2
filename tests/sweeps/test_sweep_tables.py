"""CSV, xarray and NetCDF hold the same numbers as the store, with units, and read back as they were written."""

import csv

import numpy as np
import pytest
import xarray
from fake_numbers import FakeNumbers, fake_plan

from cyclemap.sweeps import SweepPlan, load_sweep, run_sweep, to_dataset, write_csv, write_netcdf


def swept(folder, plan):
    run_sweep(plan, folder / "sweep.sqlite", workers=1)
    return load_sweep(folder / "sweep.sqlite")


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    return swept(tmp_path_factory.mktemp("sweep"), fake_plan(refused_above=0.28))


def read(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_csv_reads_back_every_number_exactly(tmp_path, sweep) -> None:
    write_csv(sweep, tmp_path / "sweep.csv")
    rows = read(tmp_path / "sweep.csv")
    assert len(rows) == 20
    for place, row in enumerate(rows):
        assert int(row["number"]) == sweep.number[place]
        assert float(row["mu_a"]) == sweep.swept["mu_a"][place]
        for name in ("rotation", "locked_period", "stable_points"):
            value = sweep.columns[name][place]
            assert (row[name] == "") if np.isnan(value) else (float(row[name]) == value)
        theta = np.degrees(sweep.lists["fixed_point_theta"][place])
        assert [row[f"fixed_point_theta_deg_{k}"] for k in (1, 2)] == [*map(repr, theta.tolist()), "", ""][:2]
        assert row["refusal"] == sweep.refusals[place]


def test_words_and_points_are_written_as_such(tmp_path) -> None:
    over = {"material": ("abs", "pu"), "way_points_mm": (((0.0, 50.0),), ((0.0, 60.0), (10.0, 60.0)))}
    found = swept(tmp_path, SweepPlan.grid(None, over, numbers=FakeNumbers()))
    write_csv(found, tmp_path / "sweep.csv")
    rows = read(tmp_path / "sweep.csv")
    assert [row["material"] for row in rows] == ["abs", "abs", "pu", "pu"]
    assert [row["way_points_mm"] for row in rows[:2]] == ["[[0.0, 50.0]]", "[[0.0, 60.0], [10.0, 60.0]]"]
    assert found.swept["way_points_mm"][1] == ((0.0, 60.0), (10.0, 60.0))
    assert found.select(way_points_mm=((0.0, 50.0),)).shape == (2,)


def test_a_grid_becomes_a_dataset_over_its_keys_with_units(sweep) -> None:
    found = to_dataset(sweep)
    assert dict(found.sizes) == {"mu_a": 5, "hitch_x_mm": 4, "fixed_point": 2, "gathering_jump": 0}
    assert found["hitch_x_mm"].attrs == {"units": "mm"}
    assert found["fixed_point_theta_deg"].attrs["units"] == "degree"
    assert found["rotation"].attrs == {"units": "turns/cycle", "long_name": "rotation number"}
    assert np.array_equal(found["rotation"].values, sweep.on_grid("rotation"), equal_nan=True)
    assert found["fixed_point_count"].sel(mu_a=0.2).values.tolist() == [2, 2, 2, 0]
    padded = found["fixed_point_theta_deg"].sel(mu_a=0.2, hitch_x_mm=[-20.0, 0.0]).values
    assert padded[0].tolist() == np.degrees(sweep.lists["fixed_point_theta"][0]).tolist()
    assert np.isnan(padded[1]).all()
    assert found["refusal"].sel(mu_a=0.3).values.tolist() == ["mu_a is 0.3"] * 4


def test_netcdf_reads_back_the_same_dataset(tmp_path, sweep) -> None:
    write_netcdf(sweep, tmp_path / "sweep.nc")
    with xarray.open_dataset(tmp_path / "sweep.nc", engine="h5netcdf") as back:
        assert back.load().identical(to_dataset(sweep))
    assert [path.name for path in tmp_path.iterdir()] == ["sweep.nc"]


def test_a_sample_becomes_a_dataset_over_its_points(tmp_path) -> None:
    ranges = {"mu_a": (0.2, 0.3), "hitch_x_mm": (-20.0, 0.0)}
    found = swept(tmp_path, SweepPlan.sample("plywood", ranges, 16, numbers=FakeNumbers()))
    write_netcdf(found, tmp_path / "sample.nc")
    with xarray.open_dataset(tmp_path / "sample.nc", engine="h5netcdf") as back:
        assert back["point"].values.tolist() == list(range(16))
        assert back["mu_a"].values.tolist() == list(found.swept["mu_a"])
        assert back["rotation"].values.tolist() == found.columns["rotation"].tolist()


def test_words_are_coordinates(tmp_path) -> None:
    over = {"material": ("abs", "plywood"), "mu_a": (0.2, 0.3)}
    found = swept(tmp_path, SweepPlan.grid(None, over, numbers=FakeNumbers()))
    write_netcdf(found, tmp_path / "words.nc")
    with xarray.open_dataset(tmp_path / "words.nc", engine="h5netcdf") as back:
        assert back["rotation"].sel(material="plywood", mu_a=0.3).item() == found.on_grid("rotation")[1, 1]
