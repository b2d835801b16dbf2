"""Half-turn symmetry of a centred ellipse: in symbols, in the code's cycles, and what it means for
steps.
"""

import math

import numpy as np
import sympy as sp

from cyclemap.collection import CollectionLoop
from cyclemap.mechanics import EllipseFriction, Material, Pose, QuasiStaticModel, Slider
from theory import half_turn_symmetry as theory
from theory.plane_rotation import rotation
from theory.turned_surface import M0, N0, THETA, VELOCITY_X, VELOCITY_Y

CENTRED = EllipseFriction(0.35, 0.18, phi=0.7)
OFFSET = EllipseFriction(0.35, 0.18, 0.05, -0.03, 0.7)
NO_OFFSET = {M0: 0, N0: 0}
TWO_PI = 2.0 * math.pi


def loop_on(law):
    return CollectionLoop.mit(material=Material("test", law), accuracy=1e-9)


def test_without_offset_every_residual_is_zero_and_with_it_the_offset_is_all_that_is_left():
    oddness = theory.oddness_of_the_support()
    for residual in (oddness, theory.half_turn_residual(), theory.reversal_residual()):
        assert residual.subs(NO_OFFSET) == 0
    velocity = rotation(-theory.PHI) * sp.Matrix([VELOCITY_X, VELOCITY_Y])
    offset = -2 * (M0 * velocity[0] + N0 * velocity[1])
    assert sp.expand(oddness - offset) == 0


def test_the_codes_cycle_commutes_with_half_a_turn_only_without_offset():
    theta = np.random.default_rng(1).uniform(-3, 3, 4)
    for law, holds in ((CENTRED, True), (OFFSET, False)):
        loop = loop_on(law)
        off = np.abs(loop.next_theta(theta + math.pi) - loop.next_theta(theta) - math.pi).max()
        assert off < 1e-8 if holds else off > 1e-2


def test_a_retraced_drag_undoes_itself_only_without_offset():
    """Out along a bent path and back along it: the object lies as before,
    whatever the anisotropy."""
    out = ((0.1, 0.0), (0.12, 0.08), (-0.05, 0.1))
    for law, holds in ((CENTRED, True), (EllipseFriction.isotropic(0.3), True), (OFFSET, False)):
        model = QuasiStaticModel(Slider.mit("rect1"), law, accuracy=1e-10)
        for theta in (0.2, 1.9, -2.5):
            pose = Pose(0.0, 0.0, theta)
            there = model.drag(pose, out)
            back = model.drag(there.end, (*out[-2::-1], pose.to_world(*model.slider.hitch)))
            off = abs(back.turn + there.turn)
            assert abs(there.turn) > 0.1
            assert off < 1e-7 if holds else off > 1e-2


def test_only_even_harmonics_are_left():
    for n in range(6):
        assert sp.simplify(theory.harmonic_factor().subs(theory.HARMONIC, n) - (-1) ** n) == 0


def test_even_maps_commute_with_half_a_turn_and_descend_to_the_doubled_circle():
    lift = theory.even_map(3)
    assert sp.expand(lift.subs(THETA, THETA + sp.pi) - lift - sp.pi) == 0
    doubled = theory.doubled(lift)
    assert sp.expand(doubled.subs(THETA, THETA + 2 * sp.pi) - doubled - 2 * sp.pi) == 0
    assert sp.expand(doubled.subs(THETA, 2 * THETA) - 2 * lift) == 0
    # The same slope at y = 2θ.
    assert sp.expand(sp.diff(doubled, THETA).subs(THETA, 2 * THETA) - sp.diff(lift, THETA)) == 0
    # Iterates: f² doubled is the doubled map's second iterate.
    low = theory.even_map(1)
    twice = sp.expand(2 * low.subs(THETA, low).subs(THETA, THETA / 2))
    assert sp.expand(twice - theory.doubled(low).subs(THETA, theory.doubled(low))) == 0


def test_steps_are_half_a_turn_at_most_where_each_half_turn_has_a_bottleneck():
    assert theory.last_step(1) == sp.pi
    assert (sp.pi - theory.last_step(3)).is_positive
