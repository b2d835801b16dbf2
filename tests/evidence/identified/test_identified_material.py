"""An identified surface as a material: what was found along with the friction goes with it."""

from dataclasses import replace

import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import MeasuredPush, SurfaceParameters, identified_material, identify, push_end_block
from cyclemap.evidence.data_blocks.stroke_block import predicted_push_ends, surface_model
from cyclemap.mechanics import Pose, Slider

RECT1 = Slider.mit("rect1")
TRUTH = SurfaceParameters(offset_x=0.03, pusher_friction=0.2, rim_share=0.4, corner_share=0.5)


def test_a_loop_on_the_material_rests_on_the_underside_that_was_identified() -> None:
    """The unknown share of the corners is of what the rim leaves: it comes back as that of the weight."""
    places = ((-0.02, 0.06, 0.0), (0.03, 0.06, 0.2), (0.01, 0.07, -0.3), (-0.04, 0.06, 0.1))
    pushes = [
        MeasuredPush(Pose(), Pose(), (x, y), (x + shift * 0.06, y - 0.06), number)
        for number, (x, y, shift) in enumerate(places)
    ]
    ends = predicted_push_ends(surface_model(TRUTH, RECT1, accuracy=1e-9), pushes)[0]
    block = push_end_block(
        [replace(one, end=Pose(*end)) for one, end in zip(pushes, ends.tolist(), strict=True)], RECT1
    )
    free, known = ("offset_x", "corner_share"), {**TRUTH.values(), "tip_offset_x": 0.0, "tip_offset_y": 0.0}
    fixed = {name: known[name] for name in block.parameters if name not in free}
    found = identify([block], free, fixed, starts=1, noise={"push place (m)": 1e-5, "push turn (rad)": 1e-4})
    assert found["offset_x"].value == pytest.approx(0.03, abs=2e-4)
    pressure = CollectionLoop.mit(material=identified_material(found, "made")).model.pressure
    assert pressure.rim_share == pytest.approx(0.4)
    assert pressure.corner_share == pytest.approx(0.3, abs=2e-3)
