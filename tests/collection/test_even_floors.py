"""What a floor's shape takes part in, and what it is taken out of: twins, fingerprints, dynamic
loops, wear.
"""

from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection import (
    CollectionLoop,
    DynamicLoop,
    check_prediction,
    direction_uncertainty,
    fingerprint,
    isotropic_twin,
    predict,
    worn_loop,
)
from cyclemap.errors import DoubtfulInput, InvalidInput
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
    with pytest.raises(InvalidInput, match="alike everywhere, but the loop's has a field"):
        check_prediction(prediction, loop)


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
    with pytest.raises(InvalidInput, match="no floor that varies from place to place"):
        DynamicLoop(loop)


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
