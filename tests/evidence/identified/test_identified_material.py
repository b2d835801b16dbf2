"""An identified surface as a material: what was found along with the friction goes with it."""

import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.evidence.data_blocks.stroke_block import predicted_push_ends, push_end_block, surface_model
from cyclemap.evidence.identification.identify import identify
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters
from cyclemap.evidence.identified_material import identified_material
from cyclemap.evidence.pushes.measured_strokes import MeasuredPush
from cyclemap.mechanics import Pose, Slider

RECT1 = Slider.mit("rect1")
TRUTH = SurfaceParameters(offset_x=0.03, pusher_friction=0.2, rim_share=0.4, corner_share=0.5)


def test_a_loop_on_the_material_rests_on_the_underside_that_was_identified() -> None:
    """The unknown share of the corners is of what the rim leaves: it comes back as that of the weight."""
    places = ((-0.02, 0.06, 0.0), (0.03, 0.06, 0.2), (0.01, 0.07, -0.3), (-0.04, 0.06, 0.1))
    model, pushes = surface_model(TRUTH, RECT1, accuracy=1e-9), []
    for number, (x, y, shift) in enumerate(places):
        push = MeasuredPush(Pose(), Pose(), (x, y), (x + shift * 0.06, y - 0.06), number)
        end = Pose(*predicted_push_ends(model, [push])[0][0].tolist())
        pushes.append(MeasuredPush(Pose(), end, push.tip_start, push.tip_end, number))
    block = push_end_block(pushes, RECT1)
    free = ("offset_x", "corner_share")
    own = dict.fromkeys((part.name for part in block.own_parameters), 0.0)
    fixed = {name: value for name, value in {**TRUTH.values(), **own}.items() if name in block.parameters}
    for name in free:
        fixed.pop(name)
    noise = {"push place (m)": 1e-5, "push turn (rad)": 1e-4}
    material = identified_material(identify([block], free, fixed, starts=1, noise=noise), "made")
    pressure = CollectionLoop.mit(material=material).model.pressure
    assert pressure.rim_share == pytest.approx(0.4)
    assert pressure.corner_share == pytest.approx(0.3, abs=2e-3)
