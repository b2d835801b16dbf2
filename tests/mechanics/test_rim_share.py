"""Pressure that the rim carries more or less of: against plain quadrature, closed forms, points; what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest
from patch_reference import area_rule, reference
from random_cases import balance_errors, random_friction
from warp_reference import inner_of

from cyclemap.errors import InvalidInput
from cyclemap.mechanics import (
    Ellipse,
    EllipseFriction,
    LimitSurface,
    PatchFootprint,
    PointFootprint,
    Polygon,
    Pose,
    QuasiStaticModel,
    SidePush,
    Slider,
)
from cyclemap.mechanics.footprint import RIM_INNER

SQUARE = Slider.mit("rect1").outline
# Its inner copy lies inside, though it is not convex.
CHEVRON = Polygon(((0, 0), (0.1, 0), (0.1, 0.06), (0.06, 0.06), (0.06, 0.1), (0, 0.1)))
OUTLINES = {
    "square": SQUARE,
    "triangle": Slider.mit("tri2").outline,
    "concave": CHEVRON,
    "ellipse": Ellipse(0.0525, 0.0785),
}
every_outline = pytest.mark.parametrize("outline", OUTLINES.values(), ids=OUTLINES)


def by_quadrature(footprint, law, twist):
    """D, its gradient and Hessian from the pressure's definition: (1 - w) even, w on the frame, and the lean."""
    outline, w = footprint.outline, footprint.rim_share
    leaning = reference(outline, law, twist, 0.3, footprint.gradient)
    even, inner = reference(outline, law, twist, 0.3), reference(inner_of(outline), law, twist, 0.3)
    # The frame's mean times its area is the whole's less the inner region's.
    return [a - b + (1.0 - w) * b + w * (b - 0.64 * c) / 0.36 for a, b, c in zip(leaning, even, inner, strict=True)]


@every_outline
def test_dissipation_wrench_and_hessian_are_those_of_plain_quadrature(outline):
    rng, checked = np.random.default_rng(1), 0
    for share in (-0.5, 0.2, 0.7):
        gradient = tuple(rng.uniform(-0.07, 0.07, 2) / outline.extent)
        footprint, law = PatchFootprint(outline, gradient, share), random_friction(rng)
        for reach in (0.3, 1.0, 30.0):
            spin = rng.normal() / outline.extent
            twist = np.array((*rng.normal(size=2) * reach, spin))
            surface = LimitSurface(footprint, law)
            value, slope, hessian = by_quadrature(footprint, law, twist)
            scale = np.array((1.0, 1.0, outline.extent))
            assert abs(float(surface.dissipation(twist, 0.3)) - value) < 1e-10 * value
            assert np.abs((surface.wrench(twist, 0.3) - slope) / scale).max() < 1e-9
            bend = np.abs(surface.hessian(twist, 0.3) - hessian) / np.outer(scale, scale)
            assert bend.max() < 1e-7 * np.abs(hessian / np.outer(scale, scale)).max()
            checked += 1
    assert checked == 9


@every_outline
def test_the_rim_share_moves_load_outwards_and_leaves_the_centre_of_pressure(outline):
    centre = np.array(outline.centroid) + 0.003 * outline.extent
    radii = []
    for share in (-0.5, 0.0, 0.5):
        footprint = PatchFootprint.under(outline, tuple(centre), share)
        points, weights = footprint.quadrature
        assert weights.sum() == pytest.approx(1.0, abs=1e-13)
        assert np.allclose(weights @ points, centre, atol=1e-15)
        assert np.allclose(footprint.centre, centre, atol=1e-15)
        radii.append(weights @ ((points - outline.centroid) ** 2).sum(axis=1))
    fine, shares = area_rule(outline)
    even = shares @ ((fine - outline.centroid) ** 2).sum(axis=1)
    # The frame alone has 1 + RIM_INNER^2 times the even mean square of the lever.
    lean = radii[1] - even
    assert np.allclose(np.array(radii) - lean, even * (1.0 + np.array((-0.5, 0.0, 0.5)) * RIM_INNER**2), rtol=1e-10)


def test_a_discs_frame_resists_a_spin_by_its_closed_torque():
    law, radius = EllipseFriction.isotropic(0.3), 0.05
    frame = LimitSurface(PatchFootprint(Ellipse(radius, radius), rim_share=1.0), law).wrench((0.0, 0.0, 1.0))
    assert frame[2] == pytest.approx(0.3 * 2.0 / 3.0 * radius * (1.0 - 0.8**3) / (1.0 - 0.8**2), rel=1e-12)
    middle = LimitSurface(PatchFootprint(Ellipse(radius, radius), rim_share=-0.5625), law).wrench((0.0, 0.0, 1.0))
    assert middle[2] == pytest.approx(0.3 * 2.0 / 3.0 * 0.8 * radius, rel=1e-12)


def test_a_push_on_the_exact_frame_is_the_push_on_many_points_of_its_pressure():
    law, share = EllipseFriction(0.35, 0.2, 0.05, -0.03, 0.7), 0.6
    exact = QuasiStaticModel(Slider.mit("rect1"), law, footprint=PatchFootprint(SQUARE, rim_share=share))
    # The frame's inner edge, 36 mm from the middle, runs between cells of 2.25 mm.
    place = (np.arange(40) + 0.5) / 40 - 0.5
    x, y = (0.09 * p.ravel() for p in np.meshgrid(place, place))
    frame = np.maximum(np.abs(x), np.abs(y)) > 0.8 * 0.045
    weights = np.where(frame, 1.0 - share + share / 0.36, 1.0 - share)
    cells = PointFootprint(tuple(zip(x.tolist(), y.tolist(), strict=True)), tuple(weights.tolist()))
    push = SidePush(distance=0.03)
    for theta in (0.4, 2.0):
        found = exact.push(Pose(theta=theta), push)
        onto = replace(exact, footprint=cells, accuracy=1e-4).push(Pose(theta=theta), push)
        even = replace(exact, footprint=None).push(Pose(theta=theta), push)
        assert abs(found.turn - onto.turn) < math.radians(0.05)
        assert abs(found.turn - even.turn) > math.radians(0.5)


def test_equations_with_the_rims_term_at_share_zero_are_those_without():
    for shape in ("rect2", "ellip2"):
        model = QuasiStaticModel(Slider.mit(shape), EllipseFriction(0.3, 0.2, 0.02, 0.01, 0.4), accuracy=1e-9)
        nearly = replace(model, footprint=PatchFootprint(model.slider.outline, rim_share=1e-14))
        push = SidePush(0, 0.2, 0.1, 0.05)
        found, wanted = nearly.push(Pose(theta=1.0), push), model.push(Pose(theta=1.0), push)
        assert abs(found.turn - wanted.turn) < 1e-11
        assert np.allclose(found.displacement, wanted.displacement, atol=1e-12)


def test_pushes_and_drags_on_any_share_balance_their_forces():
    checked = 0
    for shape, share in (("rect1", 1.0), ("hex", -0.5625), ("tri3", 0.4), ("ellip1", 0.8)):
        slider = Slider.mit(shape)
        model = QuasiStaticModel(
            slider, random_friction(np.random.default_rng(3)), footprint=PatchFootprint(slider.outline, rim_share=share)
        )
        pushed = model.push(Pose(theta=0.6), SidePush(0, 0.3, 0.2, 0.06))
        dragged = model.drag(pushed.end, ((0.0, 0.0),))
        legs = [leg.phase for leg in dragged.legs]
        for phases, course in ((pushed.run.phases, pushed.trajectory), (legs, dragged.trajectory)):
            errors = balance_errors(model, phases, course)
            assert errors.max() < 1e-9
            checked += len(errors)
    assert checked > 40


@pytest.mark.parametrize(
    ("share", "gradient", "told"),
    [
        (1.01, (0, 0), "1.01"),
        (-0.57, (0, 0), "-0.57"),
        (float("nan"), (0, 0), "nan"),
        ("most", (0, 0), "most"),
        (1.0, (1, 0), "lifts"),
        (-0.5625, (1, 0), "lifts"),
        (0.5, (15, 0), "lifts"),
    ],
)
def test_shares_that_pull_at_the_ground_are_refused(share, gradient, told):
    with pytest.raises(InvalidInput, match=told):
        PatchFootprint(SQUARE, gradient, share)


def test_an_outline_that_does_not_hold_its_inner_copy_can_have_no_share():
    hook = Polygon(((0, 0), (0.1, 0), (0.1, 0.1), (0.09, 0.1), (0.09, 0.01), (0, 0.01)))
    assert PatchFootprint(hook).rim_share == 0.0
    with pytest.raises(InvalidInput, match="does not lie inside"):
        PatchFootprint(hook, rim_share=0.1)
    assert PatchFootprint(CHEVRON, rim_share=0.1).can_have_rim_share
