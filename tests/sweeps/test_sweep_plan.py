"""What is to be swept, in words and in Python: checked first, and told apart point by point."""

from dataclasses import replace

import numpy as np
import pytest
from fake_numbers import FakeNumbers, fake_plan
from refusals import refused

from cyclemap.mechanics import load_material
from cyclemap.protocol.settings import SETTINGS
from cyclemap.sweeps import Grid, PortraitNumbers, Sample, SweepAxis, SweepPlan, SweepRange
from cyclemap.sweeps.point_sets import SWEPT, parse_over
from cyclemap.sweeps.portrait_numbers import code_version


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("side=0,1,2,3", SweepAxis("side", (0.0, 1.0, 2.0, 3.0))),
        ("material=plywood, abs", SweepAxis("material", ("plywood", "abs"))),
        ("footprint=exact,grid:8", SweepAxis("footprint", ("exact", "grid:8"))),
        ("way_points_mm=[[0,50]],[[0,60]]", SweepAxis("way_points_mm", (((0, 50),), ((0, 60),)))),
        ("phi_deg=30:-30:3", SweepAxis("phi_deg", (30.0, 0.0, -30.0))),
        ("mu_a=0.2:0.3:1", SweepAxis("mu_a", (0.2,))),
        (" mu_a = 0.2:0.3:21 ", SweepAxis("mu_a", tuple(np.linspace(0.2, 0.3, 21).tolist()))),
        ("mu_a=0.2:0.4", SweepRange("mu_a", 0.2, 0.4)),
    ],
)
def test_lists_keep_their_order_and_kind_three_parts_are_even_values_and_two_a_range(
    text, wanted
) -> None:
    assert parse_over(text) == wanted


def test_bad_words_grids_and_samples_are_refused_by_name() -> None:
    for text, told in (
        ("mu_a", "not of the form"),
        ("=1,2", "not of the form"),
        ("mu_aa=1,2", "unknown key to sweep 'mu_aa': did you mean 'mu_a'"),
        ("mu_a=0.2:x:3", "finite numbers"),
        ("mu_a=0.2:inf:3", "finite numbers"),
        ("mu_a=0.2:0.3:0", "count is 0"),
        ("mu_a=0.2:0.3:2.5", "whole count"),
        ("mu_a=0.2:0.3:4:5", "finite numbers"),
        ("mu_a=0.2,nan", "mu_a must be a finite number"),
        ("mu_a=0.2,0.3,0.2", "mu_a takes 0.2 twice"),
        ("mu_a=0.2,,0.3", "numbers, by commas"),
        ("noise_deg=0,1", "noise_deg must be positive"),
        ("material=plywod", "unknown material 'plywod': did you mean 'plywood'"),
        ("shape=rect9", "unknown slider shape 'rect9'"),
        ("way_points_mm=[[0]]", "way_points_mm must have shape"),
        ("mu_a=0.3:0.2", "the end must be the larger"),
    ):
        refused(parse_over, text, told=told)
    refused(SweepRange, "footprint", 0.0, 1.0, told="footprint has no range")
    ranged = parse_over("mu_a=0.2:0.3")
    refused(Grid, (ranged,), told="mu_a is a range without a count")
    refused(Grid, (parse_over("mu_a=1,2"), parse_over("mu_a=3,4")), told="mu_a is swept twice")
    refused(Grid, (), told="nothing is swept")
    refused(Sample, (ranged,), 0, told="sample must be at least 1")
    refused(Sample, (ranged,), 4, sequence="latin", told="sequence")
    refused(Sample, (ranged,), 4, seed=-1, told="seed")


def test_a_grid_runs_through_every_combination_once_the_last_axis_fastest() -> None:
    """Every setting, noise and material can be swept."""
    assert set(SWEPT) == {*SETTINGS, "material"}
    grid = Grid(tuple(map(parse_over, ("mu_a=0.2,0.3", "side=0,1,2", "material=abs,pu"))))
    found = [tuple(grid.settings(number).values()) for number in range(len(grid))]
    assert len(found) == len(set(found)) == 12
    assert found[:3] == [(0.2, 0.0, "abs"), (0.2, 0.0, "pu"), (0.2, 1.0, "abs")]
    assert list(grid.settings(0)) == ["mu_a", "side", "material"]


def box(sample: Sample):
    return np.array([list(sample.settings(number).values()) for number in range(len(sample))])


@pytest.mark.parametrize("sequence", ["sobol", "uniform"])
def test_a_sample_is_the_same_for_a_seed_and_begins_with_the_shorter_one(sequence) -> None:
    """Points are drawn in blocks: the same in whatever order, beyond one block too."""
    ranges = (SweepRange("mu_a", 0.2, 0.3), SweepRange("hitch_x_mm", -12.0, 4.0))
    long, short = Sample(ranges, 2100, 3, sequence), Sample(ranges, 10, 3, sequence)
    points = box(long)
    assert points[:10].tolist() == box(short).tolist()
    assert list(long.settings(2050).values()) == points[2050].tolist()
    assert np.unique(points, axis=0).shape == (2100, 2)
    assert np.all(points >= [0.2, -12.0]) and np.all(points < [0.3, 4.0])
    assert not np.allclose(points[:10], box(Sample(ranges, 10, 4, sequence)))


def test_a_sobol_sample_fills_the_box_more_evenly_than_a_uniform_one() -> None:
    """Each of the 64 cells of an 8 by 8 grid holds 32 of 2048 Sobol points, exactly (Sobol 1967)."""
    ranges = (SweepRange("mu_a", 0.0, 8.0), SweepRange("mu_b", 0.0, 8.0))
    counts = {}
    for sequence in ("sobol", "uniform"):
        cells = np.floor(box(Sample(ranges, 2048, 1, sequence))).astype(int)
        counts[sequence] = np.bincount(8 * cells[:, 0] + cells[:, 1], minlength=64)
    assert counts["sobol"].tolist() == [32] * 64
    assert np.ptp(counts["uniform"]) > 4


def test_a_sample_draws_listed_values_too() -> None:
    sample = Sample((parse_over("material=abs,pu,delrin"), parse_over("mu_a=0.2:0.3")), 300)
    drawn = [sample.settings(number)["material"] for number in range(300)]
    counts = [drawn.count(name) for name in ("abs", "pu", "delrin")]
    assert sum(counts) == 300 and counts == pytest.approx([100, 100, 100], abs=5)


OVER = {"mu_a": (0.2, 0.3)}


def test_points_carry_what_is_set_and_what_is_swept() -> None:
    """The same plan, whether values are Python's or NumPy's, whole or not."""
    plan = SweepPlan.grid("plywood", OVER, {"side": 1, "push_mm": 100})
    point = plan.point(1)
    assert (point.number, dict(point.swept)) == (1, {"mu_a": 0.3})
    assert dict(point.settings) == {"side": 1.0, "push_mm": 100.0, "mu_a": 0.3}
    assert point.material == load_material("plywood")
    settings = {"side": np.int64(1), "push_mm": 100.0}
    arrays = SweepPlan.grid("plywood", {"mu_a": np.array([0.2, 0.3])}, settings)
    assert arrays.described() == plan.described()
    assert arrays.point(1).digest == point.digest


def test_every_point_has_its_own_digest_and_the_same_in_another_plan() -> None:
    plan = fake_plan()
    digests = [plan.point(number).digest for number in range(len(plan))]
    assert len(set(digests)) == 20
    turned = SweepPlan(Grid(plan.points.axes[::-1]), "plywood", {}, plan.numbers)
    assert turned.point(0).digest == digests[0] and turned.point(1).digest == digests[4]


def test_a_digest_tells_apart_all_that_numbers_depend_on() -> None:
    """The version of the code, too."""
    for other in (
        SweepPlan.grid("abs", OVER),
        SweepPlan.grid("plywood", OVER, {"mu_b": 0.2}),
        SweepPlan.grid("plywood", OVER, numbers=PortraitNumbers(tolerance=1e-6)),
        SweepPlan.grid("plywood", OVER, numbers=PortraitNumbers(("turns",))),
        SweepPlan.grid("plywood", OVER, numbers=PortraitNumbers(rotation_tolerance=1e-3)),
        SweepPlan.grid(replace(load_material("plywood"), misfit="other"), OVER),
        SweepPlan.grid("plywood", OVER, numbers=FakeNumbers()),
    ):
        assert other.point(0).digest != SweepPlan.grid("plywood", OVER).point(0).digest
    one, other = fake_plan(version="1").point(0), fake_plan(version="2").point(0)
    assert one.digest != other.digest
    assert PortraitNumbers().version == code_version()


def test_a_bad_plan_is_refused_before_anything_runs() -> None:
    for material, over, settings, told in (
        ("plywood", {"mu_c": (1.0,)}, {}, "unknown key to sweep 'mu_c'"),
        ("plywood", OVER, {"mu_c": 1.0}, "unknown key to sweep 'mu_c'"),
        ("plywood", OVER, {"mu_a": 0.2}, "mu_a is both set and swept"),
        ("plywood", {"mu_a": (0.2, float("nan"))}, {}, "mu_a must be a finite number"),
        ("plywood", {"mu_a": ()}, {}, "mu_a has no values"),
        ("plywood", {"material": ("abs",)}, {}, "material is both given and swept"),
        (None, OVER, {}, "give a material"),
        ("plywod", OVER, {}, "unknown material"),
        ("plywood", OVER, {"material": "abs"}, "material is no setting"),
        ("plywood", OVER, {"push_mm": -150.0}, "push distance must be positive"),
        ("plywood", OVER, {"noise_deg": -1.0}, "noise_deg must be positive"),
        ("abs", [1], {}, "over must tell the values"),
        ("abs", "mu_a", {}, "over must tell the values"),
        ("abs", {"mu_a": 0.2}, {}, "mu_a is .*as a list"),
        ("abs", {"shape": "rect1"}, {}, "shape is .*as a list"),
    ):
        refused(SweepPlan.grid, material, over, settings, told=told)
    for ends in ((0.2,), (0.2, 0.3, 0.4)):
        refused(SweepPlan.sample, "abs", {"mu_a": ends}, 4, told="two ends")
    for number in (-1, 20, 0.5):
        refused(fake_plan().point, number, told="point")
    # Half an ellipse is no loop, but the swept key may bring the other half.
    assert len(SweepPlan.grid("plywood", {"semi_y_mm": (30.0, 40.0)}, {"semi_x_mm": 50.0})) == 2


def test_unknown_groups_of_quantities_are_refused_and_map_is_always_there() -> None:
    assert PortraitNumbers(("turns", "rotation")).groups == ("map", "rotation", "turns")
    assert PortraitNumbers(("all",)).groups[-1] == "staircase"
    told = "unknown group of quantities 'turn': did you mean 'turns'"
    refused(PortraitNumbers, ("turn",), told=told)
    refused(PortraitNumbers, (), told="no quantities")
    refused(PortraitNumbers, tolerance=0.0, told="tolerance must be positive")


FEET = "x_mm,y_mm,weight\n-30,-30,1\n30,-30,1\n0,30,{weight}\n"


@pytest.mark.parametrize("swept", [True, False])
def test_a_footprint_file_counts_by_what_it_holds(tmp_path, swept) -> None:
    """Edited support points make other points and another plan; the same ones again the same."""
    feet, plans = tmp_path / "feet.csv", []
    for weight in (1, 2, 1):
        feet.write_text(FEET.format(weight=weight))
        over = {"footprint": ["exact", str(feet)]} if swept else {"side": [0, 1]}
        plans.append(SweepPlan.grid("plywood", over, {} if swept else {"footprint": str(feet)}))
    digests = [plan.point(1).digest for plan in plans]
    assert digests[0] == digests[2] != digests[1]
    assert plans[0].described() == plans[2].described() != plans[1].described()
    same = [plan.point(0).digest for plan in plans]
    assert (same[0] == same[1]) == swept
    assert "footprint_files" not in SweepPlan.grid("plywood", OVER).described()
