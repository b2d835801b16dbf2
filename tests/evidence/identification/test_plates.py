"""Several plates and sessions on one floor: friction is the floor's, shapes each plate's and
session's.
"""

from dataclasses import replace

import numpy as np
import pytest

from cyclemap.evidence import (
    DataBlock,
    MeasuredPush,
    SurfaceParameters,
    identified_material,
    identify,
    push_end_block,
)
from cyclemap.evidence.identification.data_block import usual_beliefs
from cyclemap.evidence.identification.stroke_block import (
    TIP_OFFSET,
    surface_model,
)
from cyclemap.evidence.identification.surface_parameters import PLATE_NAMES, SURFACE
from cyclemap.evidence.predicted_strokes import predicted_push_ends
from cyclemap.mechanics import Pose, Slider

pytestmark = pytest.mark.slow

FLOOR = {
    "ellipticity_x": 0.12,
    "ellipticity_y": -0.06,
    "offset_x": 0.04,
    "offset_y": -0.03,
    "pusher_friction": 0.18,
}
FLOOR |= {"floor_dome": 1.0, "floor_bow_x": -2.0, "floor_bow_y": 1.0}
SHAPES = {
    "tri3": {"plate_dome": 4.0, "plate_warp_x": 2.0},
    "rect2": {"plate_dome": -2.0, "plate_warp_y": 1.5},
}
SHIFTS = {"tri3": (8e-4, -4e-4), "rect2": (-3e-4, 1.2e-3)}
TRUTH = {
    **FLOOR,
    **{
        f"{name}[{plate}]": value
        for plate, shapes in SHAPES.items()
        for name, value in shapes.items()
    },
    **{
        f"tip_offset_{a}[{p}]": at
        for p, shift in SHIFTS.items()
        for a, at in zip("xy", shift, strict=True)
    },
}
OWNED = (*SURFACE.select(PLATE_NAMES).parameters, *TIP_OFFSET)
PUSHES = 30


def collection(seed: int, wild: int = 0) -> list[DataBlock]:
    """Pushes of both plates by the mechanics, with noise; `wild` of each end somewhere else
    altogether.
    """
    rng, blocks = np.random.default_rng(seed), []
    for plate, shapes in SHAPES.items():
        slider, pushes = Slider.mit(plate), []
        rim = slider.outline.points(360)
        for number in range(PUSHES):
            start = Pose(0.3, 0.1, float(rng.uniform(0.0, 6.0)))
            touch = np.array(start.to_world(*rim[rng.integers(len(rim))].tolist()))
            way = np.array([start.x, start.y]) - touch
            turn = rng.normal(0.0, 0.4)
            way = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ (
                0.05 * way / np.hypot(*way)
            )
            first, last = touch - 0.3 * way, touch + 0.7 * way
            pushes.append(
                MeasuredPush(start, start, tuple(first.tolist()), tuple(last.tolist()), number)
            )
        model = surface_model(SurfaceParameters(**FLOOR, **shapes), slider)
        ends = predicted_push_ends(model, pushes, SHIFTS[plate])[0]
        ends += rng.standard_normal(ends.shape) * [1e-3, 1e-3, 0.01]
        ends[:wild] += [0.03, -0.02, 0.5]
        measured = [
            replace(push, end=Pose(*end)) for push, end in zip(pushes, ends.tolist(), strict=True)
        ]
        blocks.append(
            replace(
                push_end_block(measured, slider).of_owner(plate, OWNED), name=f"{plate} push ends"
            )
        )
    return blocks


@pytest.mark.parametrize("wild", [0, 2])
def test_friction_pressure_and_frames_of_two_plates_come_back_together(wild: int) -> None:
    free = tuple(TRUTH)
    found = identify(
        collection(3, wild), free, priors=usual_beliefs(free), starts=1, folds=3, student=4.0
    )
    for name, value in TRUTH.items():
        assert abs(found[name].value - value) < 4.0 * found[name].standard_error + 1e-4, found[name]
    assert (
        found["offset_x"].standard_error < 0.05
        and found["tip_offset_x[tri3]"].standard_error < 6e-4
    )
    assert found.plates["tri3"].bow == pytest.approx(2.0, abs=1.5)
    places = [one for one in found.errors if one.kind == "push place (m)"]
    assert [one.block for one in places] == ["tri3 push ends", "rect2 push ends"]
    for one in places:
        assert one.left_out_median < one.isotropic_median and one.mean <= one.left_out_mean * 1.2
    material = identified_material(found, "made")
    assert {
        one.plate: one.shape for one in material.plates
    } == found.plates and material.floor == found.floors[""]
    assert material.posterior is not None and "tri3.plate_dome_kpa" in material.posterior.parameters
    assert "believed beforehand" in material.provenance and "isotropic" in material.misfit
