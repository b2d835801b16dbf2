"""The closed form of a polygon's dissipation: proved, and equal to the code's patch and to plain
quadrature.
"""

import numpy as np
import pytest
import sympy as sp

from cyclemap.mechanics import EllipseFriction, LimitSurface, PatchFootprint, Polygon
from theory import patch_dissipation as theory

LAW = EllipseFriction(0.31, 0.17, phi=0.8)
CONCAVE = ((0.0, 0.0), (0.1, 0.0), (0.1, 0.04), (0.04, 0.04), (0.04, 0.1), (0.0, 0.1))


@pytest.mark.parametrize("weight", [theory.W_X, theory.W_Y])
def test_the_divergence_theorem_carries_leaning_pressure_too(weight):
    assert theory.divergence_residual(weight) == 0


def test_the_integrals_start_at_zero_and_a_side_through_the_centre_of_rotation_adds_nothing():
    assert theory.length_integral(theory.D, sp.Integer(0)) == 0
    assert theory.inverse_integral(theory.D, sp.Integer(0)) == 0
    assert theory.side_term(sp.Integer(0)) == 0
    assert theory.side_term(t_1=theory.T0) == 0


def closed_form(corners):
    """Return a numerical function (twist, law) -> mean of |w| over a polygon and its derivative by
    v.
    """
    symbols = [sp.symbols(f"x_{i} y_{i}", real=True) for i in range(len(corners))]
    v_x, v_y, phi = sp.symbols("v_x v_y phi", real=True)
    matrix = theory.traction_matrix(phi)
    images = [sp.symbols(f"p_{i} q_{i}", real=True) for i in range(len(corners))]
    flat = [c for image in images for c in image]
    integrals = sp.lambdify(
        flat, [theory.polygon_integral(images), *theory.polygon_force(images)], cse=True
    )
    image = sp.lambdify(
        [[c for s in symbols for c in s], v_x, v_y, theory.OMEGA, theory.MU_A, theory.MU_B, phi],
        [c for w in theory.velocity_image(symbols, (v_x, v_y), theory.OMEGA, matrix) for c in w],
    )
    numeric = sp.lambdify([theory.MU_A, theory.MU_B, phi], matrix)
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
    force = sp.lambdify(flat, list(theory.polygon_force(moved)), cse=True)
    bend = sp.lambdify(flat, theory.polygon_curvature(moved), cse=True)
    place, step = (0.3, -0.4, 0.9, 0.1, 0.2, 0.8), 1e-5
    pairs = [(force(*shift, *place), force(*-shift, *place)) for shift in step * np.eye(2)]
    slopes = np.subtract(*np.swapaxes(pairs, 0, 1)) / (2 * step)
    assert np.allclose(slopes.T, bend(0.0, 0.0, *place), rtol=0, atol=1e-9)
