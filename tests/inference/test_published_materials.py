"""Published statistics as data: their derivatives are true,
and a surface comes back from its own."""

from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import SurfaceParameters, identify
from cyclemap.evidence.identification.stroke_block import CYCLE_UNKNOWNS, loop_on
from cyclemap.evidence.identification.surface_parameters import SURFACE
from cyclemap.figures.repeated_pushes import published_statistics
from tests.inference.published_materials import TOLERANCES, statistics_block
from tests.inference.published_prediction import node_values, predicted_statistics

LOOP, NODES, CYCLES = CollectionLoop.mit(), 11, 100
TRUTH = SurfaceParameters(
    ellipticity_x=0.1, offset_x=0.05, offset_y=-0.06, pusher_friction=0.15, floor_bow_x=-0.5
)


@pytest.mark.parametrize("material", ["abs", "pu"])
def test_derivatives_are_those_of_the_residuals_by_central_differences(material):
    """Through mechanics and law of orientations together, where the block itself differences the
    law alone.
    """
    block, values = (
        statistics_block(published_statistics(material), LOOP, 9, CYCLES),
        TRUTH.values(),
    )
    jacobian = block.residuals(values)[1]
    assert jacobian.shape == (len(block.groups), len(CYCLE_UNKNOWNS))
    for name in ("ellipticity_x", "floor_bow_x"):
        step = 1e-3 * SURFACE[name].scale
        up, down = (block.residuals(values | {name: values[name] + by})[0] for by in (step, -step))
        slope = (up - down) / (2 * step)
        found = jacobian[:, CYCLE_UNKNOWNS.index(name)]
        assert found == pytest.approx(slope, rel=0.01, abs=0.01 * np.abs(slope).max())


def test_a_surface_is_recovered_from_its_own_statistics():
    """Six numbers fix the offset of the ellipse when the rest and its quadrant are known."""
    given = published_statistics("delrin")
    made = predicted_statistics(node_values(loop_on(TRUTH, LOOP), NODES), given, cycles=CYCLES)
    moments = {"mean": tuple(made.mean.tolist()), "std": tuple(made.std.tolist())}
    block = statistics_block(replace(given, directions=(), **moments), LOOP, NODES, CYCLES)
    free, values = ["offset_x", "offset_y"], TRUTH.values()
    fixed = {name: values[name] for name in block.parameters if name not in free}
    noise = {kind: TOLERANCES[kind] for kind in set(block.kinds.tolist())}
    space = SURFACE.extended(*(replace(SURFACE[name], start=0.7 * values[name]) for name in free))
    found = identify([block], free, fixed, starts=1, noise=noise, space=space)
    least = 2 * sum(np.log(TOLERANCES[kind]) for kind in block.kinds)
    assert found.fit.deviance == pytest.approx(least, abs=1e-6)
    assert [found[name].value for name in free] == pytest.approx([0.05, -0.06], abs=1e-4)
