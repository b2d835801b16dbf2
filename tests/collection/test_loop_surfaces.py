"""Surfaces as a loop meets them: what a floor's shape takes part in and what it is taken out of, and
a surface that wears, whose drifting map is the loop's own at every age of it.
"""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection import (
    CollectionLoop,
    DynamicLoop,
    check_prediction,
    direction_uncertainty,
    drifting_map,
    fingerprint,
    isotropic_twin,
    on_material,
    predict,
    worn_loop,
)
from cyclemap.errors import DoubtfulInput
from cyclemap.mechanics import (
    EllipseFriction,
    FloorField,
    Material,
    PatchFootprint,
    PointFootprint,
    PressedFootprint,
    Slider,
    SurfaceShape,
    Wear,
)

SQUARE = Slider.mit("rect1").outline
EVEN = EllipseFriction.isotropic(0.25)
FIELD = FloorField(((0, 0, 0, 0, 0), (0, 3.0, 0, 0, 2.0), (1.0, 0, 0, 0, 0)), 0.2)
VARYING = PressedFootprint(SQUARE, floor=SurfaceShape(2.0), field=FIELD)
BOWED = SurfaceShape(10.0, 10.0, 1.5)


def test_an_isotropic_twin_turns_alike_from_everywhere_whatever_the_floor():
    theta = np.linspace(0.0, 6.0, 7)
    for footprint in (VARYING, PressedFootprint(SQUARE, floor=SurfaceShape(2.0, 1.0, 0.4))):
        loop = CollectionLoop.mit("plywood", footprint=footprint)
        twin = isotropic_twin(loop)
        assert np.ptp(loop.next_theta(theta) - theta) > 0.1
        assert np.ptp(twin.next_theta(theta) - theta) < 1e-6
        assert twin.footprint.floor.dome == 2.0


def test_a_fingerprint_is_of_a_floor_alike_everywhere_and_no_check_takes_another():
    loop = CollectionLoop.mit("isotropic", footprint=VARYING)
    even = CollectionLoop.mit("isotropic", footprint=replace(VARYING, field=None))
    assert np.array_equal(fingerprint(loop).cycle.hessian, fingerprint(even).cycle.hessian)
    prediction = predict(fingerprint(loop), EVEN)
    refused(check_prediction, prediction, loop, told="alike everywhere, but the loop's has a field")


def test_an_even_patch_answers_a_bow_as_the_outline_itself_does():
    bows = [
        fingerprint(CollectionLoop.mit("isotropic", footprint=footprint)).cycle.bow_amplitude
        for footprint in (None, PatchFootprint(SQUARE), PatchFootprint(SQUARE, rim_share=0.5))
    ]
    assert bows[0] == bows[1] > 0.05 and bows[2] == 0.0


@pytest.mark.parametrize(
    ("fresh", "worn"), [(BOWED, SurfaceShape()), (SurfaceShape(), BOWED)], ids=["flat", "bowed"]
)
def test_a_floor_that_wears_to_or_from_flat_has_one_plate_all_the_way(fresh, worn):
    """The turns of cycles right after the first and right before the last are theirs."""
    wear = Wear(EVEN, 100.0, floor=worn)
    loop = CollectionLoop.mit(Material("worn", EVEN, floor=fresh, wear=wear))
    turns = [worn_loop(loop, cycles).next_theta(0.0) for cycles in (0.0, 1e-6, 99.999999, 100.0)]
    assert turns[0] == pytest.approx(turns[1], abs=1e-6)
    assert turns[2] == pytest.approx(turns[3], abs=1e-6)
    assert loop.next_theta(0.0) == pytest.approx(turns[0], abs=1e-9)
    assert abs(turns[0] - turns[3]) > 0.1


def test_the_dynamic_simulation_refuses_a_floor_that_varies():
    loop = CollectionLoop.mit("plywood", footprint=VARYING)
    refused(DynamicLoop, loop, told="no floor that varies from place to place")


@pytest.mark.parametrize(
    "friction",
    [EllipseFriction(0.25, 0.25, m0=0.24), EllipseFriction(9.9, 9.9), EllipseFriction(1.95, 1.9)],
    ids=["far off the centre", "as large as can be", "as large as is not doubted"],
)
@pytest.mark.filterwarnings("ignore:friction of 9.9")
def test_directions_are_told_of_any_friction_that_there_is(friction):
    """Its axes' ratio is varied without leaving what friction can be."""
    loop = CollectionLoop.mit(Material("edge", friction))
    assert direction_uncertainty(loop).samples in (1, 2)


@pytest.mark.parametrize(
    "footprint",
    [
        PointFootprint([(45, 45), (-45, 45), (-45, -45), (45, -45)], [1] * 4),
        PatchFootprint(Slider.mit("rect3").outline),
    ],
    ids=["millimetres", "another object's"],
)
def test_a_footprint_that_reaches_out_of_the_object_is_doubted(footprint):
    with pytest.warns(DoubtfulInput, match="is it in metres, and of this object"):
        CollectionLoop.mit(footprint=footprint).cycle(0.0)


def test_what_values_share_cannot_be_written_into():
    patch = PatchFootprint(SQUARE)
    arrays = [SQUARE.array, patch.second_moments, VARYING.floor_bend, VARYING.field_bend]
    arrays += PointFootprint([(0.01, 0.0), (-0.01, 0.0), (0.0, 0.01)], [1, 1, 1]).quadrature
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[:] = 7.0


FRESH, WORN = EllipseFriction(0.25, 0.25), EllipseFriction(0.33, 0.2, 0.05, 0.0, 0.3)
LOOP = CollectionLoop.mit(Material("wears", FRESH, wear=Wear(WORN, 400.0, ((100.0, 0.6),))))


def test_a_drifting_map_is_within_its_tolerance_the_map_of_the_loop_as_worn_at_each_cycle() -> None:
    """The pace of wear has a bend at cycle 100; most cycles lie between computed maps."""
    tolerance, theta = 0.06, np.linspace(0.0, 6.0, 13)
    drifting = drifting_map(LOOP, 401, tolerance)
    assert drifting.max_error <= tolerance and 4 < len(drifting.cycles) < 40
    for cycle in (0, 60, 100, 130, 310, 400):
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
