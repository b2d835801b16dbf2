"""The pieces of one step: the method's coefficients, the tangents of a contact, and what a step predicts."""

import numpy as np
import pytest

from cyclemap.mechanics import EllipseFriction, PatchFootprint, Slider, grid_footprint
from cyclemap.mechanics.contact_equations import ARGUMENTS, contact_functions
from cyclemap.mechanics.limit_surface import normalised
from cyclemap.mechanics.motion_functions import BEND
from cyclemap.mechanics.pressure_family import PressureFamily
from cyclemap.mechanics.runge_kutta import STAGES, C

OUTLINE = Slider.mit("rect1").outline
LAW = EllipseFriction(0.25, 0.22, 0.03, 0.01, 0.3)


def test_what_bends_as_a_square_from_the_start_is_predicted_exactly():
    places = np.append(C, 1.0)
    for i in range(2, STAGES + 1):
        assert BEND[i, :i] @ places[:i] ** 2 == pytest.approx(places[i] ** 2, abs=1e-14)
        assert not BEND[i, i:].any()


def test_what_bends_as_a_cube_too_is_predicted_between_the_first_stages_and_the_end():
    places = np.append(C, 1.0)
    for i in range(3, STAGES + 1):
        assert BEND[i, :i] @ places[:i] ** 3 == pytest.approx(places[i] ** 3, abs=1e-13)


@pytest.mark.parametrize("equations", ["stick", "slide", "ring_friction"])
@pytest.mark.parametrize("near", [True, False], ids=["near", "far"])
@pytest.mark.parametrize("footprint", [PatchFootprint(OUTLINE), grid_footprint(OUTLINE, 3)], ids=["patch", "points"])
def test_the_tangent_by_the_state_is_the_first_part_of_the_whole_and_both_are_differences(equations, near, footprint):
    functions = contact_functions(PressureFamily.of(normalised(footprint)), equations, near)
    rng, count = np.random.default_rng(3), functions.solver.size1_in(0)
    state = rng.uniform(-0.5, 0.5, 6)
    arguments = np.concatenate([state, [LAW.mu_a, LAW.mu_b, LAW.m0, LAW.n0, LAW.phi, 0.0, 0.0, 0.0]])
    z = np.array([0.7, 0.2])[:count]
    whole = np.array(functions.tangent(z, arguments))
    part, solved = functions.state_tangent(z, arguments)
    assert whole.shape == (count, len(ARGUMENTS)) and part.shape == (count, 5)
    np.testing.assert_allclose(np.array(part), whole[:, :5], rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(np.array(solved), np.array(functions.solver(z, arguments)), rtol=1e-13, atol=1e-14)
    step = 1e-6
    for k in range(11):
        sides = []
        for sign in (1.0, -1.0):
            moved = arguments + sign * step * np.eye(len(ARGUMENTS))[k]
            sides.append(np.array(functions.solver(z, moved)).ravel()[:count])
        jacobian = np.array(
            [
                (np.array(functions.solver(z + step * unit, arguments)) - functions.solver(z - step * unit, arguments))
                for unit in np.eye(count)
            ]
        )[:, :count, 0] / (2.0 * step)
        expected = -np.linalg.solve(jacobian.T, (sides[0] - sides[1]) / (2.0 * step))
        np.testing.assert_allclose(whole[:, k], expected, rtol=1e-5, atol=1e-6)
