"""Results are found again by what was swept and by what was found, on their grid."""

import csv

import numpy as np
import pytest
import xarray
from fake_numbers import FakeNumbers, fake_plan, fake_sample, fake_values, swept
from refusals import refused

from cyclemap.sweeps import SweepPlan, to_dataset, write_csv, write_netcdf


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    """Three materials by five mu_a by four hitch_x_mm."""
    grid = fake_plan().points.axes
    over = {"material": ("abs", "pu", "delrin"), **{axis.key: axis.values for axis in grid}}
    plan = SweepPlan.grid(None, over, numbers=FakeNumbers(refused_above=0.28))
    return swept(tmp_path_factory.mktemp("sweep") / "sweep.sqlite", plan)


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    return swept(tmp_path_factory.mktemp("small") / "sweep.sqlite", fake_plan(refused_above=0.28))


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    return swept(tmp_path_factory.mktemp("sample") / "sweep.sqlite", fake_sample(64))


def test_the_grid_has_each_number_at_its_place(sweep) -> None:
    plane = sweep.on_grid("rotation")
    assert plane.shape == sweep.shape == (3, 5, 4)
    for i, mu in enumerate(sweep.axes[1].values):
        for j, x in enumerate(sweep.axes[2].values):
            wanted = fake_values(mu, x)["rotation"] if mu <= 0.28 else np.nan
            assert np.array_equal(plane[:, i, j], np.full(3, wanted), equal_nan=True)


def test_one_value_takes_its_axis_away_a_range_and_a_list_keep_theirs(sweep) -> None:
    """Both ends belong to the range."""
    values, rotation = sweep.axes[1].values, sweep.on_grid("rotation")
    one = sweep.select(material="pu", mu_a=0.225)
    assert [axis.key for axis in one.axes] == ["hitch_x_mm"] and len(one) == 4
    assert one.on_grid("rotation").tolist() == rotation[1, 1].tolist()
    assert set(one.table["material"]) == {"pu"}
    found = sweep.select(mu_a=values[1:3], material=["delrin", "abs"])
    assert found.shape == (2, 2, 4) and found.axes[0].values == ("abs", "delrin")
    assert found.axes[1].values == values[1:3]
    assert np.array_equal(found.on_grid("rotation"), rotation[[0, 2], 1:3])


def test_where_keeps_the_points_that_a_condition_chooses(sweep) -> None:
    found = sweep.where(lambda one: one.values("locked_period") == 1)
    assert len(found) == 3 * 4 * 3
    assert max(found.table["hitch_x_mm"]) < -5.0
    assert {values.size for values in found.table["fixed_point_theta"]} == {2}
    assert np.isnan(found.on_grid("rotation")).sum() == 60 - 36


def test_a_bad_question_is_refused_by_name(sweep, sample) -> None:
    refused(sweep.select, mu_b=1.0, told="unknown swept key 'mu_b'")
    refused(sweep.select, mu_a=0.21, told="mu_a does not take 0.21; its values are 0.2, 0.225")
    refused(sweep.select, material=(1.0, 2.0), told="material is no number")
    refused(sweep.values, "tv_from_uniform", told="unknown column 'tv_from_uniform'")
    told = "unknown quantity of this sweep 'rotations': did you mean 'rotation'"
    refused(sweep.on_grid, "rotations", told=told)
    refused(sweep.where, [True], told="where needs 60 true or false")
    refused(sweep.where, np.ones(60), told="not float64")
    refused(sample.on_grid, "rotation", told="a sample has no grid")
    refused(sample.select, mu_a=0.9, told=r"no point has mu_a=0\.9")


def read(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_csv_reads_back_every_number_exactly(tmp_path, small) -> None:
    write_csv(small, tmp_path / "sweep.csv")
    rows = read(tmp_path / "sweep.csv")
    assert len(rows) == 20
    for place, row in enumerate(rows):
        assert int(row["number"]) == small.table["number"][place]
        assert float(row["mu_a"]) == small.table["mu_a"][place]
        for name in ("rotation", "locked_period", "stable_points"):
            value = small.table[name][place]
            assert (row[name] == "") if np.isnan(value) else (float(row[name]) == value)
        theta = np.degrees(small.table["fixed_point_theta"][place])
        written = [row[f"fixed_point_theta_deg_{k}"] for k in (1, 2)]
        assert written == ([*map(repr, theta.tolist())] or ["", ""])
        assert row["refusal"] == small.table["refusal"][place]


def test_words_and_points_are_written_as_such(tmp_path) -> None:
    ways = ((0.0, 50.0),), ((0.0, 60.0), (10.0, 60.0))
    over = {"material": ("abs", "pu"), "way_points_mm": ways}
    found = swept(tmp_path / "sweep.sqlite", SweepPlan.grid(None, over, numbers=FakeNumbers()))
    write_csv(found, tmp_path / "sweep.csv")
    rows = read(tmp_path / "sweep.csv")
    assert [row["material"] for row in rows] == ["abs", "abs", "pu", "pu"]
    said = ["[[0.0, 50.0]]", "[[0.0, 60.0], [10.0, 60.0]]"]
    assert [row["way_points_mm"] for row in rows[:2]] == said
    assert found.table["way_points_mm"][1] == ways[1]
    assert found.select(way_points_mm=ways[0]).shape == (2,)


def test_a_grid_becomes_a_dataset_over_its_keys_with_units(small) -> None:
    found = to_dataset(small)
    assert dict(found.sizes) == {"mu_a": 5, "hitch_x_mm": 4, "fixed_point": 2, "gathering_jump": 0}
    assert found["hitch_x_mm"].attrs == {"units": "mm"}
    assert found["fixed_point_theta_deg"].attrs["units"] == "degree"
    assert found["rotation"].attrs == {"units": "turns/cycle", "long_name": "rotation number"}
    assert np.array_equal(found["rotation"].values, small.on_grid("rotation"), equal_nan=True)
    assert found["fixed_point_count"].sel(mu_a=0.2).values.tolist() == [2, 2, 2, 0]
    padded = found["fixed_point_theta_deg"].sel(mu_a=0.2, hitch_x_mm=[-20.0, 0.0]).values
    assert padded[0].tolist() == np.degrees(small.table["fixed_point_theta"][0]).tolist()
    assert np.isnan(padded[1]).all()
    assert found["refusal"].sel(mu_a=0.3).values.tolist() == ["mu_a is 0.3"] * 4


def test_netcdf_reads_back_the_same_dataset(tmp_path, sample, sweep) -> None:
    for found in (sample, sweep):
        write_netcdf(found, tmp_path / "sweep.nc")
        with xarray.open_dataset(tmp_path / "sweep.nc", engine="h5netcdf") as back:
            assert back.load().identical(to_dataset(found))
        assert [path.name for path in tmp_path.iterdir()] == ["sweep.nc"]


def test_a_sample_becomes_a_dataset_over_its_points_and_words_are_coordinates(
    sample, sweep
) -> None:
    chosen = sample.select(mu_a=(0.2, 0.25))
    assert len(chosen) == 32 and chosen.values("mu_a").max() <= 0.25
    found, words = to_dataset(sample), to_dataset(sweep)
    assert found["point"].values.tolist() == list(range(64))
    assert found["mu_a"].values.tolist() == list(sample.table["mu_a"])
    assert found["rotation"].values.tolist() == sample.values("rotation").tolist()
    place = {"material": "pu", "mu_a": 0.225, "hitch_x_mm": 0.0}
    assert words["rotation"].sel(place).item() == sweep.on_grid("rotation")[1, 1, 3]
