"""A loop on a surface that wears: its drifting map is the loop's own at every age of it."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection import CollectionLoop, drifting_map, on_material, worn_loop
from cyclemap.mechanics import EllipseFriction, Material, Wear

FRESH, WORN = EllipseFriction(0.25, 0.25), EllipseFriction(0.33, 0.2, 0.05, 0.0, 0.3)
LOOP = CollectionLoop.mit(Material("wears", FRESH, wear=Wear(WORN, 400.0, ((100.0, 0.6),))))


def test_a_drifting_map_is_within_its_tolerance_the_map_of_the_loop_as_worn_at_each_cycle() -> None:
    """The pace of wear has a bend at cycle 100; most cycles lie between computed maps."""
    tolerance, theta = 0.03, np.linspace(0.0, 6.0, 13)
    drifting = drifting_map(LOOP, 401, tolerance)
    assert drifting.max_error <= tolerance and 4 < len(drifting.cycles) < 40
    for cycle in (0, 30, 60, 100, 130, 220, 310, 400):
        own = worn_loop(LOOP, cycle).next_theta(theta)
        assert np.max(np.abs(drifting.at(cycle)(theta) - own)) <= tolerance
    fresh, worn = (replace(LOOP, material=Material("still", law)) for law in (FRESH, WORN))
    for cycle, ended in ((0, fresh), (400, worn)):
        assert drifting.at(cycle)(theta) == pytest.approx(ended.next_theta(theta), abs=1e-3)


def test_a_surface_that_does_not_wear_has_no_drifting_map_and_stays_as_it_is() -> None:
    still = CollectionLoop.mit("plywood")
    assert worn_loop(still, 1e4) is still
    refused(drifting_map, still, 10, told="plywood does not wear")
    refused(drifting_map, LOOP, 0, told="cycles must be at least 1")


@pytest.mark.parametrize("make", [drifting_map, worn_loop, on_material])
def test_what_is_no_loop_and_no_material_is_refused(make) -> None:
    refused(make, 5, 5, told=r"loop must be a CollectionLoop, such as .*, not 5")
    refused(on_material, LOOP, 5, told="material must be a Material, not 5")
    refused(worn_loop, LOOP, -5.0, told="cycles must not be negative, not -5.0")
