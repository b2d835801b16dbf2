"""A sweep's pages, its words, and the planes without specks."""

from dataclasses import replace

import numpy as np
import pytest
from fake_numbers import FakeNumbers, fake_plan, fake_sample, fake_values, swept as fake_swept
from refusals import refused

from cyclemap.maps import RotationPlane
from cyclemap.sweeps import (
    PortraitNumbers,
    SweepPlan,
)
from cyclemap.views.panels.layout import render
from cyclemap.views.panels.rotation import cell_edges
from cyclemap.views.sweep_page import rotation_plane, sweep_page, sweep_sentences, without_specks

WIDE = np.s_[3:20, 5:9]
NARROW = ((30, 31, 32), (10, 11, 12))


@pytest.fixture
def swept(tmp_path):
    """What a sweep in this process found."""
    return lambda plan: fake_swept(tmp_path / "sweep.sqlite", plan)


def page_of(sweep, names=()):
    figure = sweep_page(sweep, names)
    assert render(figure).startswith(b"\x89PNG")
    return figure


def words(figure) -> str:
    return " ".join(" ".join(text.get_text() for text in figure.texts).split())


def panels(figure):
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]


@pytest.mark.slow
def test_a_sweep_of_refusals_alone_can_still_be_drawn(swept) -> None:
    over = {"fraction": (1.5, 2.0), "push_mm": (100.0, 150.0)}
    numbers = PortraitNumbers(("rotation", "fixed_points"))
    sweep = swept(SweepPlan.grid("plywood", over, numbers=numbers))
    assert all("contact fraction" in text for text in sweep.table["refusal"])
    assert "4 refused" in words(page_of(sweep))
    assert "2 refused" in words(page_of(sweep.select(push_mm=100.0)))


@pytest.mark.slow
def test_a_plane_has_the_rotation_numbers_the_counts_and_the_refusals(swept) -> None:
    sweep = swept(fake_plan(refused_above=0.28))
    assert rotation_plane(sweep).period.sum() == 4 * 3
    figure = page_of(sweep)
    rotation, stable = panels(figure)
    titles = [axes.get_title(loc="left") for axes in (rotation, stable)]
    assert titles == ["Rotation number", "Number of stable fixed points"]
    assert (rotation.get_xlabel(), rotation.get_ylabel()) == ("friction μa", "ring x (mm)")
    mesh = stable.collections[0]
    drawn = np.ma.filled(mesh.get_array().astype(float), np.nan)
    assert np.array_equal(drawn, sweep.on_grid("stable_points").T, equal_nan=True)
    crossed = [bars for bars in stable.collections[1:] if bars.get_hatch() == "xxx"]
    assert sum(len(bars.get_paths()) for bars in crossed) == 4, "half of the cells of four rows"
    # In grey, a darker cell has more stable directions.
    colours = np.array([mesh.cmap(mesh.norm(count))[:3] for count in (0.0, 1.0)])
    none, some = colours @ (0.299, 0.587, 0.114)
    assert none - some > 0.4
    told = ("plywood: friction μa × ring x", "20 points over friction μa 0.2 to 0.3 (5 values)")
    for part in (*told, "12 lock (12 at 0/1)", "4 refused; all of them so: mu_a is 0.3"):
        assert part in words(figure)


def test_angles_are_drawn_in_degrees(swept) -> None:
    """The fake numbers have no turns; a real map of isotropic friction turns by its rotation number
    each cycle.
    """
    over = {"hitch_x_mm": (-10.607,), "hitch_y_mm": (10.607,)}
    numbers = PortraitNumbers(("rotation", "turns"), tolerance=1e-3)
    plan = SweepPlan.grid("isotropic", over, numbers=numbers)
    figure = page_of(swept(plan), ("mean_turn", "rotation"))
    turn, rotation = (float(axes.collections[0].get_array()[0, 0]) for axes in panels(figure))
    assert turn == pytest.approx(74.52037 - 66.51814, abs=0.06)
    assert 360.0 * rotation == pytest.approx(turn, abs=0.06)


def test_lines_run_along_the_key_with_every_fixed_point(swept) -> None:
    over = {"hitch_x_mm": (0.0, -8.0, -4.0, -12.0)}
    points, rotation = panels(
        page_of(swept(SweepPlan.grid("plywood", over, numbers=FakeNumbers())))
    )
    line = rotation.lines[0]
    places = [-12.0, -8.0, -4.0, 0.0]
    assert line.get_xdata().tolist() == places
    assert line.get_ydata().tolist() == [fake_values(0.25, x)["rotation"] for x in places]
    stable, unstable = points.lines[:2]
    assert sorted(stable.get_xdata().tolist()) == sorted(unstable.get_xdata()) == [-12.0, -8.0]
    assert np.degrees(0.1 + 8.0 / 7.0) in stable.get_ydata()


def test_of_a_plane_a_line_can_be_drawn_with_its_refusals_and_some_points_told(swept) -> None:
    sweep = swept(fake_plan(refused_above=0.28))
    points, _ = panels(page_of(sweep.select(hitch_x_mm=-20.0)))
    stable, unstable, refused_points = (len(line.get_xdata()) for line in points.lines[:3])
    assert (stable, unstable, refused_points) == (4, 4, 1)
    said = sweep_sentences(sweep.where(sweep.table["number"] < 4))[0]
    assert said.startswith("4 of 20 points over friction μa")


def test_of_materials_the_ticks_are_names(swept) -> None:
    names = ("abs", "delrin", "plywood", "pu")
    plan = SweepPlan.grid(None, {"material": names}, numbers=FakeNumbers())
    points, _ = panels(page_of(swept(plan)))
    assert tuple(label.get_text() for label in points.get_xticklabels()) == names


@pytest.mark.slow
def test_a_sample_over_two_keys_is_scattered_and_over_one_is_a_line(swept, tmp_path) -> None:
    figure = page_of(swept(fake_sample(32, refused_above=0.25)), ("fixed_points", "rotation"))
    assert "sobol sample, seed 0" in words(figure)
    for axes in panels(figure):
        dots, crosses = axes.collections[0].get_offsets(), axes.lines[0].get_xdata()
        assert (len(dots), len(crosses)) == (16, 16)
    plan = SweepPlan.sample("plywood", {"mu_a": (0.2, 0.3)}, 32, numbers=FakeNumbers())
    _, rotation = panels(page_of(fake_swept(tmp_path / "one.sqlite", plan)))
    places = rotation.lines[0].get_xdata()
    assert len(places) == 32 and np.all(np.diff(places) > 0.0)


def test_what_is_infinite_is_marked_as_without_end(swept, tmp_path) -> None:
    """Of a plane, a line and a sample: each infinite number has its mark, no other has one."""
    plane = swept(fake_plan())
    sample = fake_swept(tmp_path / "sample.sqlite", fake_sample(16))
    for sweep, keys in ((plane, 2), (plane.select(mu_a=0.2), 1), (sample, 2)):
        locked = sweep.table["stable_points"] == 1.0
        table = sweep.table.assign(fixed_points=np.where(locked, np.inf, 1.0))
        axes = panels(page_of(replace(sweep, table=table), ("fixed_points",)))[-1]
        (marks,) = [line for line in axes.lines if line.get_label() == "without end"]
        assert 0 < locked.sum() < len(locked)
        expected = sweep.table[["mu_a", "hitch_x_mm"][-keys:]][locked].to_numpy()
        placed = marks.get_xydata()[:, :keys]
        assert sorted(map(tuple, placed)) == sorted(map(tuple, expected))


@pytest.mark.parametrize("keys", [1, 2])
@pytest.mark.parametrize(("largest", "scale"), [(1e244, "log"), (900.0, "linear")])
def test_values_of_many_decades_are_drawn_by_their_logarithms(swept, keys, largest, scale) -> None:
    over = dict(list({"hitch_x_mm": (-8.0, -4.0, 0.0), "mu_a": (0.2, 0.25, 0.3)}.items())[:keys])
    sweep = swept(SweepPlan.grid("plywood", over, numbers=FakeNumbers()))
    table = sweep.table.assign(fixed_points=np.geomspace(1.5, largest, len(sweep)))
    axes = panels(page_of(replace(sweep, table=table), ("fixed_points",)))[-1]
    shades = [type(mesh.norm).__name__ == "LogNorm" for mesh in axes.collections if mesh.norm]
    assert (axes.get_yscale() == "log" if keys == 1 else any(shades)) == (scale == "log")


def test_what_cannot_be_drawn_is_refused(swept) -> None:
    over = {"mu_a": (0.2, 0.3), "mu_b": (0.2, 0.3), "hitch_x_mm": (-8.0, 0.0)}
    plan = SweepPlan.grid("plywood", over, numbers=FakeNumbers())
    sweep = swept(plan)
    refused(sweep_page, sweep, told="3 keys are swept")
    plane = sweep.select(mu_b=0.2)
    refused(sweep_page, plane, ("fixed_point_theta",), told="fixed_point_theta is a list")
    refused(sweep_page, plane, ("tv",), told="unknown quantity of this sweep 'tv'")
    refused(sweep_page, sweep.where(np.zeros(8, dtype=bool)), told="nothing to draw")


def test_cells_meet_half_way() -> None:
    assert cell_edges(np.array([0.0, 1.0, 3.0])).tolist() == [-0.5, 0.5, 2.0, 4.0]
    assert cell_edges(np.array([3.0])).tolist() == [2.5, 3.5]


def plane(size, locked) -> RotationPlane:
    """A plane that locks at 1/q in the cells of `locked`, by q."""
    period = np.zeros((size, size), dtype=np.int64)
    for q, cells in locked.items():
        period[cells] = q
    flat, axis = np.zeros((size, size)), np.arange(float(size))
    return RotationPlane(axis, axis, flat, flat, flat, period, np.sign(period), period < 0, 1e-4)


def test_wide_tongues_stay_whole_and_lone_cells_go() -> None:
    given = plane(60, {3: WIDE, 4: NARROW, 5: np.s_[40:60, 50:51]})
    found = without_specks(given)
    assert np.array_equal(found.period, plane(60, {3: WIDE}).period)
    assert np.array_equal(found.winding, np.sign(found.period))
    assert np.count_nonzero(given.period) == 17 * 4 + 3 + 20, "what is given stays as it is"
    # A column each of 1/2 and 1/3: neither is two cells wide. A coarse plane keeps every cell.
    assert not without_specks(plane(60, {2: np.s_[10:40, 20], 3: np.s_[10:40, 21]})).period.any()
    coarse = plane(10, {3: np.s_[4, 4]})
    assert without_specks(coarse) is coarse


def test_a_tongue_that_is_one_cell_wide_at_a_place_is_not_cut_in_two() -> None:
    given = plane(60, {3: np.s_[10:20, 5:9]})
    for cells in (np.s_[20, 7], np.s_[21, 8], np.s_[22:30, 8:12], np.s_[30:34, 8]):
        given.period[cells] = given.winding[cells] = 1
    given.period[given.period > 0] = 3
    found = without_specks(given)
    assert found.period[20, 7] == found.period[21, 8] == 3
    assert found.period[30:34, 8].tolist() == [3, 0, 0, 0], "what trails off is cut short"


@pytest.mark.parametrize("corner", [np.s_[:2, :2], np.s_[:2, -2:], np.s_[-2:, :2], np.s_[-2:, -2:]])
def test_a_tongue_in_a_corner_stays(corner) -> None:
    assert np.count_nonzero(without_specks(plane(60, {2: corner})).period) == 4
