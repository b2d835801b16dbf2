"""An offset ellipse acts as one constant force at the centre of pressure: proved, and so in the
code's footprints.
"""

import numpy as np
import pytest
import sympy as sp

from cyclemap.mechanics import (
    Ellipse,
    EllipseFriction,
    LimitSurface,
    PatchFootprint,
    PointFootprint,
    Polygon,
)
from theory import offset_force as theory
from theory.traction_law import M0, N0

LAW = EllipseFriction(0.31, 0.17, 0.06, -0.04, 0.9)
CENTRED = EllipseFriction(0.31, 0.17, 0.0, 0.0, 0.9)
TRIANGLE = Polygon(((-0.05, -0.03), (0.07, -0.02), (0.0, 0.06)))
FOOTPRINTS = {
    "patch": PatchFootprint(TRIANGLE),
    "leaning": PatchFootprint(TRIANGLE, centre=(0.008, 0.001)),
    "rim": PatchFootprint(TRIANGLE, rim_share=0.4),
    "ellipse": PatchFootprint(Ellipse(0.05, 0.03)),
    "points": PointFootprint(((0.01, 0.02), (0.05, -0.03), (-0.04, 0.01)), (1.0, 2.0, 0.5)),
}
TWISTS = np.random.default_rng(0).normal(size=(40, 3)) * (1.0, 1.0, 20.0)


def constant_wrench(footprint, frame):
    x, y = sp.symbols("x y", real=True)
    wrench = sp.lambdify((M0, N0, theory.PHI, x, y), list(theory.offset_wrench((x, y))))
    return np.array(wrench(LAW.m0, LAW.n0, LAW.phi - frame, *footprint.centre))


@pytest.mark.parametrize("footprint", FOOTPRINTS.values(), ids=FOOTPRINTS)
@pytest.mark.parametrize("frame", [0.0, 1.3])
def test_the_codes_limit_surface_is_the_centred_one_shifted_by_the_derived_wrench(footprint, frame):
    shift = constant_wrench(footprint, frame)
    offset, centred = LimitSurface(footprint, LAW), LimitSurface(footprint, CENTRED)
    moved = offset.wrench(TWISTS, frame) - centred.wrench(TWISTS, frame)
    assert moved.shape == (40, 3)
    assert np.allclose(moved, shift, rtol=0, atol=1e-14)
    power = offset.dissipation(TWISTS, frame) - centred.dissipation(TWISTS, frame)
    assert np.allclose(power, TWISTS @ shift, rtol=0, atol=1e-13)
    assert np.array_equal(offset.hessian(TWISTS, frame), centred.hessian(TWISTS, frame))


def test_the_slope_of_the_equivalent_table_is_the_length_of_the_offset():
    assert theory.slope().subs({M0: 3, N0: 4}) == 5
