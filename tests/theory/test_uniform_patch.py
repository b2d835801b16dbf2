"""The patch under uniform pressure: its closed form proved and equal to the code's, and its limits:
translation, far centres of rotation, rims and grids.
"""

import math

import numpy as np
import pytest
import sympy as sp

from cyclemap.mechanics import (
    EllipseFriction,
    LimitSurface,
    PatchFootprint,
    Polygon,
    grid_footprint,
)
from theory import patch_dissipation as form, patch_limits as limits
from theory.patch_dissipation import traction_matrix, velocity_image

LAW = EllipseFriction(0.31, 0.17, phi=0.8)
CONCAVE = ((0.0, 0.0), (0.1, 0.0), (0.1, 0.04), (0.04, 0.04), (0.04, 0.1), (0.0, 0.1))


@pytest.mark.parametrize("weight", [form.W_X, form.W_Y])
def test_the_divergence_theorem_carries_leaning_pressure_too(weight):
    assert form.divergence_residual(weight) == 0


def test_the_integrals_start_at_zero_and_a_side_through_the_centre_of_rotation_adds_nothing():
    assert form.length_integral(form.D, sp.Integer(0)) == 0
    assert form.inverse_integral(form.D, sp.Integer(0)) == 0
    assert form.side_term(sp.Integer(0)) == 0
    assert form.side_term(t_1=form.T0) == 0


def closed_form(corners):
    """Return a numerical function (twist, law) -> mean of |w| over a polygon and its derivative by
    v.
    """
    symbols = [sp.symbols(f"x_{i} y_{i}", real=True) for i in range(len(corners))]
    v_x, v_y, phi = sp.symbols("v_x v_y phi", real=True)
    matrix = form.traction_matrix(phi)
    images = [sp.symbols(f"p_{i} q_{i}", real=True) for i in range(len(corners))]
    flat = [c for image in images for c in image]
    integrals = sp.lambdify(
        flat, [form.polygon_integral(images), *form.polygon_force(images)], cse=True
    )
    image = sp.lambdify(
        [[c for s in symbols for c in s], v_x, v_y, form.OMEGA, form.MU_A, form.MU_B, phi],
        [c for w in form.velocity_image(symbols, (v_x, v_y), form.OMEGA, matrix) for c in w],
    )
    numeric = sp.lambdify([form.MU_A, form.MU_B, phi], matrix)
    area = Polygon(corners).area

    def evaluate(twist, law):
        integral, *force = integrals(*image(np.ravel(corners), *twist, law.mu_a, law.mu_b, law.phi))
        size = area * twist[2] ** 2 * law.mu_a * law.mu_b
        return integral / size, numeric(law.mu_a, law.mu_b, law.phi).T @ np.array(force) / size

    return evaluate


def random_polygons(count, seed):
    """A triangle and polygons of more sides, counter-clockwise about the origin; one concave."""
    rng = np.random.default_rng(seed)
    for k in range(count):
        angle = (np.arange(3 + k) + 0.8 * rng.uniform(size=3 + k)) * 2 * np.pi / (3 + k)
        corner = rng.uniform(0.03, 0.08, angle.size) * np.exp(1j * angle)
        yield tuple(zip(corner.real.tolist(), corner.imag.tolist(), strict=True))
    yield CONCAVE


def random_twist(corners, rng):
    """Centre of rotation within 2 extents of the middle, inside the patch and outside, either sense
    of turning.
    """
    centre = np.mean(corners, axis=0) + rng.normal(size=2) * 0.08
    omega = rng.choice((-1.0, 1.0)) * rng.uniform(0.5, 30.0)
    return np.array((omega * centre[1], -omega * centre[0], omega))


@pytest.mark.slow
def test_the_codes_patch_is_the_closed_form_to_rounding():
    rng = np.random.default_rng(1)
    for corners in random_polygons(2, seed=2):
        evaluate = closed_form(corners)
        surface = LimitSurface(PatchFootprint(Polygon(corners)), LAW)
        for _ in range(10):
            twist = random_twist(corners, rng)
            mean, force = evaluate(twist, LAW)
            assert abs(surface.dissipation(twist) / mean - 1.0) < 1e-13
            torque = (mean - force @ twist[:2]) / twist[2]
            size = np.array((1.0, 1.0, surface.footprint.extent))
            assert np.abs((surface.wrench(twist) - (*force, torque)) / size).max() < 1e-13


def test_the_curvature_of_a_polygon_is_the_derivative_of_its_force():
    corners = [sp.symbols(f"p_{i} q_{i}", real=True) for i in range(3)]
    a, b = sp.symbols("a b", real=True)
    moved = [(p + a, q + b) for p, q in corners]
    flat = [a, b, *(c for corner in corners for c in corner)]
    force = sp.lambdify(flat, list(form.polygon_force(moved)), cse=True)
    bend = sp.lambdify(flat, form.polygon_curvature(moved), cse=True)
    place, step = (0.3, -0.4, 0.9, 0.1, 0.2, 0.8), 1e-5
    pairs = [(force(*shift, *place), force(*-shift, *place)) for shift in step * np.eye(2)]
    slopes = np.subtract(*np.swapaxes(pairs, 0, 1)) / (2 * step)
    assert np.allclose(slopes.T, bend(0.0, 0.0, *place), rtol=0, atol=1e-9)


LAW = EllipseFriction(0.31, 0.17, phi=0.8)
SQUARE = Polygon(((-0.045, -0.045), (0.045, -0.045), (0.045, 0.045), (-0.045, 0.045)))
TRIANGLE = Polygon(((-0.05, -0.03), (0.07, -0.02), (0.0, 0.06)))


def predicted_near_translation(patch, velocity, omega):
    """Second-order dissipation about the centre of pressure, from the patch's second moments."""
    c, s = math.cos(LAW.phi), math.sin(LAW.phi)
    turn = np.array(((c, s), (-s, c)))
    moments, (v_m, v_n) = turn @ patch.second_moments @ turn.T, turn @ velocity
    symbols = (limits.MU_A, limits.MU_B, limits.V_M, limits.V_N, limits.OMEGA)
    near = sp.lambdify((*symbols, limits.C_MM, limits.C_MN, limits.C_NN), limits.near_translation())
    return near(LAW.mu_a, LAW.mu_b, v_m, v_n, omega, moments[0, 0], moments[0, 1], moments[1, 1])


@pytest.mark.parametrize(("outline", "order"), [(SQUARE, 4), (TRIANGLE, 3)])
def test_the_codes_patch_near_translation_is_the_second_order_form_with_an_error_of_the_next_order(
    outline, order
):
    """A patch that a half turn maps to itself has no term in omega^3."""
    patch, velocity, errors = PatchFootprint(outline), np.array((0.5, -0.8)), []
    x, y = patch.centre
    for omega in (2.0, 1.0, 0.5):
        twist = (velocity[0] + omega * y, velocity[1] - omega * x, omega)
        found = LimitSurface(patch, LAW).dissipation(twist)
        errors.append(abs(float(found) - predicted_near_translation(patch, velocity, omega)))
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.abs(orders - order).max() < 0.1


MATRIX = traction_matrix(sp.Float(LAW.phi)).subs({limits.MU_A: LAW.mu_a, limits.MU_B: LAW.mu_b})


def floats(values):
    return [sp.Float(value) for value in values]


def image_of(places, twist):
    vx, vy, omega = floats(twist)
    return velocity_image([floats(place) for place in places], (vx, vy), omega, MATRIX)


@pytest.mark.slow
def test_weight_on_the_rim_alone_dissipates_the_closed_forms_derivative_by_the_scale():
    """For a square and a triangle, turning both ways."""
    for outline, twist in ((SQUARE, (0.4, -0.2, 9.0)), (TRIANGLE, (0.1, 0.3, -20.0))):
        *corners, centre = image_of([*outline.vertices, outline.centroid], twist)
        found = LimitSurface(PatchFootprint(outline, rim_share=1.0), LAW).dissipation(twist)
        assert abs(found / float(limits.rim_mean(corners, centre)) - 1.0) < 1e-12


def grid_errors(twist, counts):
    """Errors of n x n grids on the square, and what is left of them after the leading term."""
    footprints = [PatchFootprint(SQUARE), *(grid_footprint(SQUARE, n) for n in counts)]
    exact, *found = (float(LimitSurface(each, LAW).dissipation(twist)) for each in footprints)
    corners, (vx, vy, omega) = [floats(corner) for corner in SQUARE.vertices], floats(twist)
    unit = float(limits.grid_defect(corners, (vx, vy), omega, MATRIX, sp.Integer(1)))
    errors = np.array(found) - exact
    return errors, errors - unit * (0.09 / np.array(counts)) ** 2


def test_a_grid_errs_by_the_derived_leading_term_and_the_rest_falls_with_the_fourth_power():
    for twist in ((1.0, 0.3, 8.0), (-0.7, 0.8, 6.0)):
        errors, rest = grid_errors(twist, (8, 16, 32))
        assert np.abs(np.log2(np.abs(errors[:-1] / errors[1:])) - 2.0).max() < 0.05
        assert np.abs(np.log2(np.abs(rest[:-1] / rest[1:])) - 4.0).max() < 0.1


def test_with_the_centre_of_rotation_inside_the_rest_falls_with_the_third_power():
    """The cone of |w| adds an error that depends on where in its cell the centre lies, but stays
    below C h^3.
    """
    counts = (8, 16, 32)
    for x, y in np.random.default_rng(0).uniform(-0.04, 0.04, (4, 2)):
        errors, rest = grid_errors((y, -x, 1.0), counts)
        assert (errors < 0.0).all()
        assert (np.abs(rest / errors) < 0.6 / np.array(counts)).all()


def test_a_square_spinning_on_the_papers_grid_lacks_the_derived_share_to_leading_order():
    friction, spin = EllipseFriction.isotropic(0.25), (0.0, 0.0, 1.0)
    exact = LimitSurface(PatchFootprint(SQUARE), friction).dissipation(spin)
    counts = (8, 16, 32)
    grids = [LimitSurface(grid_footprint(SQUARE, n), friction) for n in counts]
    lacks = np.array([grid.dissipation(spin) / exact - 1.0 for grid in grids])
    assert abs(lacks[0] + 0.0057) < 5e-5
    # The cone of |w| lies on a corner of the cells: what is left is of third order.
    derived = [float(limits.spinning_square_grid_defect(n)) for n in counts]
    rest = (lacks / derived - 1.0) * counts
    assert np.ptp(rest) < 0.02
    assert abs(rest.mean() + 0.45) < 0.02
