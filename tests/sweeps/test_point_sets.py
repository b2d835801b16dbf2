"""What `key=values` says, and every way in which it can say nothing."""

import numpy as np
import pytest
from refusals import refused

from cyclemap.protocol.settings import SETTINGS
from cyclemap.sweeps import Grid, Sample, SweepAxis, SweepRange
from cyclemap.sweeps.point_sets import SWEPT, parse_over


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("side=0,1,2,3", SweepAxis("side", (0.0, 1.0, 2.0, 3.0))),
        ("material=plywood, abs", SweepAxis("material", ("plywood", "abs"))),
        ("footprint=exact,grid:8", SweepAxis("footprint", ("exact", "grid:8"))),
        (
            "way_points_mm=[[0,50]],[[0,60],[10,60]]",
            SweepAxis("way_points_mm", (((0.0, 50.0),), ((0.0, 60.0), (10.0, 60.0)))),
        ),
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
    for options, told in (
        ({"count": 0}, "sample must be at least 1"),
        ({"sequence": "latin"}, ""),
        ({"seed": -1}, ""),
    ):
        refused(Sample, (ranged,), **{"count": 4, **options}, told=told or next(iter(options)))


def test_a_grid_runs_through_every_combination_once_the_last_axis_fastest() -> None:
    """Every setting, noise and material can be swept."""
    assert set(SWEPT) == {*SETTINGS, "material"}
    grid = Grid(
        (parse_over("mu_a=0.2,0.3"), parse_over("side=0,1,2"), parse_over("material=abs,pu"))
    )
    found = [tuple(grid.settings(number).values()) for number in range(len(grid))]
    assert len(found) == len(set(found)) == 12
    assert found[:3] == [(0.2, 0.0, "abs"), (0.2, 0.0, "pu"), (0.2, 1.0, "abs")]
    assert list(grid.settings(0)) == ["mu_a", "side", "material"]


def box(sample: Sample):
    return np.array([list(sample.settings(number).values()) for number in range(len(sample))])


@pytest.mark.parametrize("sequence", ["sobol", "uniform"])
def test_a_sample_is_the_same_for_a_seed_and_begins_with_the_shorter_one(sequence) -> None:
    """Points are drawn in blocks: the same whichever are asked for, in whatever order, beyond one
    block too.
    """
    ranges = (SweepRange("mu_a", 0.2, 0.3), SweepRange("hitch_x_mm", -12.0, 4.0))
    long, short = Sample(ranges, 2100, 3, sequence), Sample(ranges, 10, 3, sequence)
    points = box(long)
    assert points[:10].tolist() == box(short).tolist()
    assert list(long.settings(2050).values()) == points[2050].tolist()
    assert np.unique(points, axis=0).shape == (2100, 2)
    assert np.all(points >= [0.2, -12.0]) and np.all(points < [0.3, 4.0])
    assert not np.allclose(points[:10], box(Sample(ranges, 10, 4, sequence)))


def test_a_sobol_sample_fills_the_box_more_evenly_than_a_uniform_one() -> None:
    """Each of the 64 cells of an 8 by 8 grid holds 32 of 2048 points of a Sobol net, exactly (Sobol
    1967).
    """
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
    assert {name: drawn.count(name) for name in ("abs", "pu", "delrin")} == pytest.approx(
        {"abs": 100, "pu": 100, "delrin": 100}, abs=5
    )
