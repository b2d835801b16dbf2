"""Isotropic friction: a rigid rotation, in symbols and in the code; the ellipsoid's rotation beside
the real one.
"""

import math

import numpy as np
import sympy as sp

from cyclemap.collection import CollectionLoop
from cyclemap.mechanics import EllipseFriction, Material
from theory import isotropy as theory
from theory.turned_surface import PHI, THETA, spelled_out

ISOTROPIC = EllipseFriction.isotropic(0.25)


def loop_with(**changes):
    return CollectionLoop.mit(material=Material("test", ISOTROPIC), accuracy=1e-9, **changes)


def test_orientation_and_material_angle_drop_out_and_the_wrench_turns_along():
    assert not theory.squared_isotropic_dissipation().has(THETA, PHI)
    assert theory.turning_residual() == sp.zeros(4, 1)


def test_the_leg_back_looks_the_same_from_every_start():
    leg = theory.leg_seen_by_the_object()
    assert not leg.has(THETA)
    assert not theory.turn_of_the_ellipsoids_leg().has(THETA)
    turn = theory.PUSH_TURN
    rotation = sp.Matrix([[sp.cos(turn), sp.sin(turn)], [-sp.sin(turn), sp.cos(turn)]])
    wanted = -rotation * sp.Matrix([theory.RING_X, theory.RING_Y])
    assert (leg - wanted).applyfunc(spelled_out) == sp.zeros(2, 1)


def test_the_ellipsoids_drag_turn_is_five_degrees_more_than_the_squares():
    """MIT's push: the square turns back by 66.52 degrees, the ellipsoid of its second moment by
    71.50.
    """
    loop = loop_with()
    cycle = loop.cycle(0.0)
    ring = np.array(cycle.push.end.to_world(*loop.model.slider.hitch))
    hx, hy = loop.slider.hitch
    kappa = math.hypot(hx, hy) / (hx**2 + hy**2 + 0.09**2 / 12)
    numbers = {theory.PUSH_TURN: cycle.push_turn, theory.RING_X: ring[0], theory.RING_Y: ring[1]}
    numbers |= {theory.LEVER_X: hx, theory.LEVER_Y: hy}
    tangent = theory.turn_of_the_ellipsoids_leg().subs(numbers)
    end, start = (2.0 * math.atan(float(tangent.subs(theory.RATE, k))) for k in (kappa, 0))
    assert abs(math.degrees(cycle.drag_turn) + 66.51814) < 1e-4
    assert abs(math.degrees(end - start) + 71.498) < 1e-3
