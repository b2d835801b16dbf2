"""A plan is checked before anything runs, and tells its points apart by all that their numbers
depend on.
"""

from dataclasses import replace

import numpy as np
import pytest
from fake_numbers import FakeNumbers, fake_plan
from refusals import refused

from cyclemap.mechanics import load_material
from cyclemap.sweeps import Grid, PortraitNumbers, SweepPlan
from cyclemap.sweeps.portrait_numbers import code_version

OVER = {"mu_a": (0.2, 0.3)}


def test_points_carry_what_is_set_and_what_is_swept() -> None:
    """The same plan, whether values are Python's or NumPy's, whole or not."""
    plan = SweepPlan.grid("plywood", OVER, {"side": 1, "push_mm": 100})
    point = plan.point(1)
    assert (point.number, dict(point.swept)) == (1, {"mu_a": 0.3})
    assert dict(point.settings) == {"side": 1.0, "push_mm": 100.0, "mu_a": 0.3}
    assert point.material == load_material("plywood")
    arrays = SweepPlan.grid(
        "plywood", {"mu_a": np.array([0.2, 0.3])}, {"side": np.int64(1), "push_mm": 100.0}
    )
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
    refused(
        PortraitNumbers, ("turn",), told="unknown group of quantities 'turn': did you mean 'turns'"
    )
    refused(PortraitNumbers, (), told="no quantities")
    refused(PortraitNumbers, tolerance=0.0, told="tolerance must be positive")


FEET = "x_mm,y_mm,weight\n-30,-30,1\n30,-30,1\n0,30,{weight}\n"


@pytest.mark.parametrize("swept", [True, False])
def test_a_footprint_file_counts_by_what_it_holds(tmp_path, swept) -> None:
    """Support points that were edited make other points and another plan; the same ones again make
    the same.
    """
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
