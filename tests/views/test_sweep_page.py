"""A sweep's pages, its words, and the planes without specks."""

import numpy as np
import pytest
from fake_numbers import FakeNumbers, fake_plan, fake_sample, fake_values, swept as fake_swept
from refusals import refused

from cyclemap.maps import RotationPlane
from cyclemap.sweeps import (
    PointOutcome,
    PortraitNumbers,
    SweepPlan,
    SweepStore,
    load_sweep,
    run_sweep,
)
from cyclemap.views.panels.layout import render
from cyclemap.views.panels.rotation import cell_edges
from cyclemap.views.sweep_page import rotation_plane, sweep_page, sweep_sentences, without_specks

NUMBERS = PortraitNumbers(("rotation", "fixed_points"))
WIDE = np.s_[3:20, 5:9]
NARROW = ((30, 31, 32), (10, 11, 12))


def outcome(place: float) -> PointOutcome:
    """Locked with two fixed points below one half, winding above, refused at the end."""
    if place > 0.9:
        return PointOutcome({}, "no such loop")
    locked = place < 0.5
    rotation = 0.0 if locked else 0.1 * place
    found = {"rotation": rotation, "rotation_lower": rotation}
    found |= {"rotation_upper": rotation + 1e-5 * (not locked), "locked_winding": 0.0}
    found |= {"locked_period": float(locked), "stable_points": float(locked)}
    found |= {"fixed_points": 2.0 * locked}
    if locked:
        found |= {"fixed_point_theta": (1.0, 2.0 + place), "fixed_point_stable": (1.0, 0.0)}
    return PointOutcome(found)


@pytest.fixture
def swept(tmp_path):
    """A sweep whose outcomes depend on the place of a point in the plan."""

    def sweep(plan):
        path = tmp_path / f"{len(plan)}.sqlite"
        with SweepStore(path, plan) as store:
            store.add([(plan.point(k), outcome(k / (len(plan) - 1))) for k in range(len(plan))])
        return load_sweep(path)

    return sweep


def page_of(sweep, names=()):
    figure = sweep_page(sweep, names)
    assert render(figure).startswith(b"\x89PNG")
    return figure


def words(figure) -> str:
    return " ".join(text.get_text() for text in figure.texts)


def panels(figure):
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]


@pytest.mark.slow
def test_a_plane_is_coloured_outlined_and_crossed_out(swept) -> None:
    over = {"mu_a": (0.2, 0.25, 0.3), "hitch_x_mm": (-12.0, -8.0, -4.0)}
    figure = page_of(swept(SweepPlan.grid("plywood", over, numbers=NUMBERS)))
    rotation, stable = panels(figure)
    assert (rotation.get_xlabel(), rotation.get_ylabel()) == ("friction μa", "ring x (mm)")
    mesh = stable.collections[0]
    assert np.ma.filled(mesh.get_array(), -1.0).ravel().tolist() == [1, 1, 0, 1, 0, 0, 1, 0, -1]
    told = ("plywood: friction μa × ring x", "9 points over friction μa 0.2 to 0.3 (3 values)")
    for part in (*told, "4 lock (4 at 0/1)", "1 refused; it so: no such loop."):
        assert part in words(figure)
    # In grey, a darker cell has more stable directions.
    colours = np.array([mesh.cmap(mesh.norm(count))[:3] for count in (0.0, 1.0)])
    none, some = colours @ (0.299, 0.587, 0.114)
    assert none - some > 0.4


def test_a_line_has_the_bifurcation_diagram_beside_the_rotation_number(swept) -> None:
    over = {"mu_a": np.linspace(0.2, 0.3, 11).tolist()}
    sweep = swept(SweepPlan.grid("plywood", over, numbers=NUMBERS))
    points, _ = panels(page_of(sweep))
    unstable, stable, refused_points = (len(line.get_xdata()) for line in points.lines[:3])
    assert (unstable, stable, refused_points) == (5, 5, 1)
    said = sweep_sentences(sweep.where(sweep.table["number"] < 4))[0]
    assert said.startswith("4 of 11 points over friction μa")


def test_a_sample_is_dots_and_any_quantity_can_be_drawn(swept) -> None:
    ranges = {"mu_a": (0.2, 0.3), "hitch_x_mm": (-20.0, 0.0)}
    plan = SweepPlan.sample("plywood", ranges, 21, numbers=NUMBERS)
    figure = page_of(swept(plan), ("fixed_points",))
    (axes,) = panels(figure)
    assert (len(axes.collections[0].get_offsets()), len(axes.lines[0].get_xdata())) == (19, 2)
    assert "sobol sample, seed 0" in words(figure)
    names = ("abs", "delrin", "plywood", "pu")
    points, _ = panels(page_of(swept(SweepPlan.grid(None, {"material": names}, numbers=NUMBERS))))
    assert tuple(label.get_text() for label in points.get_xticklabels()) == names


@pytest.mark.slow
def test_a_sweep_of_refusals_alone_can_still_be_drawn(tmp_path) -> None:
    over = {"fraction": (1.5, 2.0), "push_mm": (100.0, 150.0)}
    plan = SweepPlan.grid("plywood", over, numbers=NUMBERS)
    run_sweep(plan, tmp_path / "sweep.sqlite", workers=1)
    sweep = load_sweep(tmp_path / "sweep.sqlite")
    assert all("contact fraction" in text for text in sweep.table["refusal"])
    assert "4 refused" in words(page_of(sweep))
    assert "2 refused" in words(page_of(sweep.select(push_mm=100.0)))


def test_a_plane_has_the_rotation_numbers_the_counts_and_the_refusals(tmp_path) -> None:
    sweep = fake_swept(tmp_path / "sweep.sqlite", fake_plan(refused_above=0.28))
    assert rotation_plane(sweep).period.sum() == 4 * 3
    rotation, stable = panels(page_of(sweep))
    titles = [axes.get_title(loc="left") for axes in (rotation, stable)]
    assert titles == ["Rotation number", "Number of stable fixed points"]
    drawn = np.ma.filled(stable.collections[0].get_array().astype(float), np.nan)
    assert np.array_equal(drawn, sweep.on_grid("stable_points").T, equal_nan=True)
    crossed = [bars for bars in stable.collections[1:] if bars.get_hatch() == "xxx"]
    assert sum(len(bars.get_paths()) for bars in crossed) == 4, "half of the cells of four rows"


def test_angles_are_drawn_in_degrees(tmp_path) -> None:
    """The fake numbers have no turns; a real map of isotropic friction turns by its rotation number
    each cycle.
    """
    over = {"hitch_x_mm": (-10.607,), "hitch_y_mm": (10.607,)}
    numbers = PortraitNumbers(("rotation", "turns"), tolerance=1e-3)
    plan = SweepPlan.grid("isotropic", over, numbers=numbers)
    figure = page_of(fake_swept(tmp_path / "sweep.sqlite", plan), ("mean_turn", "rotation"))
    turn, rotation = (float(axes.collections[0].get_array()[0, 0]) for axes in panels(figure))
    assert turn == pytest.approx(74.52037 - 66.51814, abs=0.06)
    assert 360.0 * rotation == pytest.approx(turn, abs=0.06)


def test_lines_run_along_the_key_with_every_fixed_point(tmp_path) -> None:
    over = {"hitch_x_mm": (0.0, -8.0, -4.0, -12.0)}
    plan = SweepPlan.grid("plywood", over, numbers=FakeNumbers())
    points, rotation = panels(page_of(fake_swept(tmp_path / "sweep.sqlite", plan)))
    line = rotation.lines[0]
    places = [-12.0, -8.0, -4.0, 0.0]
    assert line.get_xdata().tolist() == places
    assert line.get_ydata().tolist() == [fake_values(0.25, x)["rotation"] for x in places]
    stable, unstable = points.lines[:2]
    assert sorted(stable.get_xdata().tolist()) == sorted(unstable.get_xdata()) == [-12.0, -8.0]
    assert np.degrees(0.1 + 8.0 / 7.0) in stable.get_ydata()


@pytest.mark.slow
def test_a_sample_over_two_keys_is_scattered_and_over_one_is_a_line(tmp_path) -> None:
    sample = fake_sample(32, refused_above=0.25)
    scattered = panels(page_of(fake_swept(tmp_path / "sweep.sqlite", sample)))
    for axes in scattered:
        dots, crosses = axes.collections[0].get_offsets(), axes.lines[0].get_xdata()
        assert (len(dots), len(crosses)) == (16, 16)
    plan = SweepPlan.sample("plywood", {"mu_a": (0.2, 0.3)}, 32, numbers=FakeNumbers())
    _, rotation = panels(page_of(fake_swept(tmp_path / "one.sqlite", plan)))
    places = rotation.lines[0].get_xdata()
    assert len(places) == 32 and np.all(np.diff(places) > 0.0)


def test_what_cannot_be_drawn_is_refused(tmp_path) -> None:
    over = {"mu_a": (0.2, 0.3), "mu_b": (0.2, 0.3), "hitch_x_mm": (-8.0, 0.0)}
    plan = SweepPlan.grid("plywood", over, numbers=FakeNumbers())
    sweep = fake_swept(tmp_path / "sweep.sqlite", plan)
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
