"""What follows from an identified ellipse: values by its own formulas, intervals that hold the
truth.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from stand_ins import ELLIPSE, made_scans

from cyclemap.evidence import (
    Identification,
    friction_ellipse_from_scans,
    friction_scan_block,
    identified_material,
    identify,
)
from cyclemap.evidence.identification.surface_parameters import FLOOR_NAMES, SURFACE
from cyclemap.evidence.identified_material import Derived, derived_quantities, sampled_values
from cyclemap.mechanics import EllipseFriction

LAW = EllipseFriction(0.28, 0.22, 0.02, -0.012, 0.6)
MEAN = math.sqrt(0.28 * 0.22)
TRUTH = {
    "axis_ratio": 0.28 / 0.22,
    "axis_direction": 0.6,
    "offset_size": math.hypot(0.02, 0.012) / MEAN,
    "offset_direction": 0.6 + math.atan2(-0.012, 0.02),
    "mean_friction": MEAN,
}


def identified(
    law: EllipseFriction, noise: float, seed: int = 0, count: int = 36
) -> Identification:
    directions = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    return friction_ellipse_from_scans(made_scans(law, directions, 8.0, noise, seed), 8.0)


def derived(law: EllipseFriction, noise: float) -> dict[str, Derived]:
    return {one.name: one for one in derived_quantities(identified(law, noise))}


def test_values_are_those_of_the_ellipse() -> None:
    told = derived(LAW, 1e-5)
    assert {name: one.value for name, one in told.items()} == pytest.approx(TRUTH, abs=1e-3)
    assert all(one.lower <= one.value <= one.upper and one.known for one in told.values())


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    """12 seeded sets, 95 %: fewer than 10 held of one quantity would be a chance of 1 in 50."""
    held = dict.fromkeys(TRUTH, 0)
    for seed in range(12):
        for one in derived_quantities(identified(LAW, 0.1, seed, count=18), draws=200, seed=seed):
            held[one.name] += one.lower <= TRUTH[one.name] <= one.upper
    assert all(count >= 10 for count in held.values()), held


def test_isotropic_friction_has_no_direction_and_a_ratio_that_may_be_one() -> None:
    told = derived(EllipseFriction.isotropic(0.25), 0.1)
    assert told["axis_ratio"].lower == 1.0 and told["offset_size"].lower == 0.0
    assert not told["axis_direction"].known and not told["offset_direction"].known


def test_a_direction_at_the_end_of_its_range_has_an_interval_around_it() -> None:
    axis = derived(EllipseFriction(0.3, 0.2, phi=math.pi / 2), 0.05)["axis_direction"]
    assert axis.known and axis.upper - axis.lower < 0.2 and abs(math.cos(axis.value)) < 0.1


def test_samples_scatter_as_the_covariance_says() -> None:
    found = identified(LAW, 0.05)
    values = sampled_values(found, 4000, seed=3)
    drawn = np.array([[one[name] for name in found.problem.space.names] for one in values])
    assert drawn.shape == (4000, 5) and np.all(found.uncertainty.freedom > 20.0)
    assert np.mean(drawn, axis=0) == pytest.approx(found.fit.vector, abs=4e-4)
    assert np.std(drawn, axis=0) == pytest.approx(found.uncertainty.standard_error, rel=0.1)


def test_surfaces_that_may_wear_to_no_ellipse_have_a_posterior_of_those_that_do_not() -> None:
    """Late scans that hardly tell where the worn ellipse lies: many draws of it leave zero out."""
    directions = np.linspace(0.0, 2 * np.pi, 6, endpoint=False)
    fresh = friction_scan_block(made_scans(LAW, directions, 8.0, 0.1), 8.0)
    worn = tuple(replace(SURFACE[name], name=f"worn_{name}") for name in ELLIPSE[1:])
    late = replace(
        friction_scan_block(made_scans(LAW, directions, 8.0, 2.5, seed=1), 8.0),
        name="late scans",
        parameters=(ELLIPSE[0], *(parameter.name for parameter in worn)),
        asked=ELLIPSE,
        own_parameters=worn,
        kinds="late force (N)",
    )
    found = identify([fresh, late], [*ELLIPSE, *late.parameters[1:]], starts=1)
    count = len(sampled_values(found, 200))
    assert 20 < count < 190
    floor = {name: 0.0 for flat in FLOOR_NAMES for name in (flat, f"worn_{flat}")}
    held = replace(found, problem=replace(found.problem, fixed={**found.problem.fixed, **floor}))
    material = identified_material(held, "slate", last_cycle=10.0)
    assert material.wear is not None and len(material.posterior) == count
