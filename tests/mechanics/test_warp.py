"""Warped footprints: saddles of pressure on the frame, against plain quadrature, symmetries and points; refusals."""

import math
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from patch_reference import area_rule
from random_cases import balance_errors, random_friction
from test_patch_integrals import OUTLINES, PLACES, twist_about
from warp_reference import by_quadrature, frame_rule, inner_of, saddle

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
from cyclemap.mechanics.patch_integrals import WARPED_FAR_RATIO

SQUARE = Slider.mit("rect1").outline
LAW = EllipseFriction(0.35, 0.2, 0.05, -0.03, 0.7)
every_outline = pytest.mark.parametrize("outline", OUTLINES.values(), ids=OUTLINES)


def relative_errors(outline, place, seed):
    """Of D, its gradient and its Hessian."""
    rng = np.random.default_rng(seed)
    law, frame = random_friction(rng), rng.uniform(-3, 3)
    size = outline.extent
    footprint = PatchFootprint(outline, (0.1 / size, -0.05 / size), 0.2, (0.1, -0.12))
    twist = twist_about(place, outline, rng)
    surface, scale = LimitSurface(footprint, law), np.array((1.0, 1.0, 1.0 / size))
    value, slope, hessian = by_quadrature(footprint, law, twist, frame)
    both = np.outer(scale, scale)
    return (
        abs(surface.dissipation(twist, frame) / value - 1.0),
        np.linalg.norm(scale * (surface.wrench(twist, frame) - slope)) / np.linalg.norm(scale * slope),
        np.linalg.norm(both * (surface.hessian(twist, frame) - hessian)) / np.linalg.norm(both * hessian),
    )


@every_outline
def test_dissipation_wrench_and_hessian_match_quadrature_to_1e_10_wherever_the_centre_lies(outline):
    seeds = [(place, 10 * i + k) for i, place in enumerate(PLACES) for k in range(2)]
    errors = np.array([relative_errors(outline, place, seed) for place, seed in seeds])
    assert len(errors) == 22
    assert errors[:, :2].max() < 1e-11
    assert errors[:, 2].max() < 1e-10


@every_outline
def test_rim_integrals_and_area_rule_agree_where_one_hands_over_to_the_other(outline):
    rng, worst = np.random.default_rng(3), 0.0
    surface = LimitSurface(PatchFootprint(outline, warp=(0.15, -0.1)), EllipseFriction.isotropic(0.3))
    for angle in rng.uniform(0.0, 2.0 * math.pi, 8):
        sides = []
        for ratio in (WARPED_FAR_RATIO * (1 - 1e-14), WARPED_FAR_RATIO * (1 + 1e-14)):
            x, y = np.array(outline.centroid) + ratio * outline.extent * np.array((math.cos(angle), math.sin(angle)))
            twist = np.array((y, -x, 1.0)) / outline.extent
            sides.append(np.concatenate([surface.wrench(twist), surface.hessian(twist).ravel()]))
        worst = max(worst, np.abs(sides[0] - sides[1]).max() / np.abs(sides[0]).max())
    assert 0.0 < worst < 2e-11


@every_outline
def test_a_warp_changes_neither_load_nor_centre_of_pressure_but_the_second_moments_as_its_definition_says(outline):
    centre = tuple(np.array(outline.centroid) + 0.003 * outline.extent)
    for warp in ((0.15, 0.0), (0.0, -0.15), (-0.1, 0.1)):
        without, with_it = (PatchFootprint.under(outline, centre, 0.1, w) for w in ((0.0, 0.0), warp))
        levers, weights = (np.array(footprint.quadrature[0]) for footprint in (without, with_it)), []
        second = []
        for footprint, lever in zip((without, with_it), levers, strict=True):
            weights = footprint.quadrature[1]
            assert weights.sum() == pytest.approx(1.0, abs=1e-13)
            assert np.allclose(weights @ lever, centre, atol=1e-14 * max(1.0, abs(centre[0])))
            assert footprint.centre == without.centre
            x = (lever - outline.centroid) / outline.extent
            second.append(np.einsum("k,ki,kj->ij", weights, x, x))
        lever, share = frame_rule(outline)
        x = lever / outline.extent
        wanted = np.einsum("k,k,ki,kj->ij", share, saddle(outline, warp).at(lever), x, x)
        assert np.abs(second[1] - second[0] - wanted).max() < 1e-12


def test_on_a_square_the_saddles_are_plain_and_load_the_corners_of_one_diagonal():
    first, second = PatchFootprint(SQUARE).saddles
    corner, size = np.array((0.045, 0.045)), SQUARE.extent
    assert abs(first.constant) + abs(second.constant) < 1e-15
    assert np.abs(np.concatenate([first.slope, second.slope])).max() * size < 1e-15
    assert float(second.at(corner)) == pytest.approx(1.0)
    assert float(second.at(corner * (1, -1))) == pytest.approx(-1.0)
    assert float(first.at(corner * (1, 0))) == pytest.approx(0.5)


def test_dissipation_is_linear_in_rim_share_and_warp():
    rng = np.random.default_rng(2)
    for outline in (SQUARE, Slider.mit("tri2").outline, Slider.mit("ellip2").outline):
        twists = rng.normal(size=(20, 3)) * (1.0, 1.0, 2.0 / outline.extent)

        def values(share, a, b, outline=outline, twists=twists):
            return LimitSurface(PatchFootprint(outline, rim_share=share, warp=(a, b)), LAW).wrench(twists, 0.4)

        even = values(0.0, 0.0, 0.0)
        parts = [values(*step) - even for step in ((0.3, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.1))]
        assert np.abs(values(0.3, 0.1, 0.1) - even - sum(parts)).max() < 1e-12
        assert np.abs(values(0.0, -0.1, 0.0) - even + parts[1]).max() < 1e-12
        assert min(np.abs(part).max() for part in parts) > 1e-4


@pytest.mark.parametrize("outline", [SQUARE, Ellipse(0.05, 0.05)], ids=["square", "disc"])
def test_turned_by_a_right_angle_the_same_pressure_has_the_opposite_warp(outline):
    rng, size = np.random.default_rng(4), outline.extent
    twists = rng.normal(size=(30, 3)) * (1.0, 1.0, 2.0 / size)
    turned = np.column_stack([-twists[:, 1], twists[:, 0], twists[:, 2]])
    surface, opposite = (LimitSurface(PatchFootprint(outline, warp=(s * 0.1, s * 0.2)), LAW) for s in (1.0, -1.0))
    # The body turned by a quarter under a frame turned back: the ground's axes stay.
    found, wanted = opposite.dissipation(turned, 0.3), surface.dissipation(twists, 0.3 + math.pi / 2.0)
    assert np.abs(found - wanted).max() < 1e-13
    assert np.abs(found - surface.dissipation(turned, 0.3)).max() > 1e-3


def test_a_mirrored_push_on_the_mirrored_warp_is_the_mirrored_push():
    law, push = EllipseFriction.isotropic(0.3), SidePush(0, 0.3, 0.2, 0.08)
    mirrored = SidePush(0, 0.7, -0.2, 0.08)
    plate = QuasiStaticModel(Slider.mit("rect1"), law, accuracy=1e-9)
    ends = []
    for warp, stroke in (((0.1, 0.2), push), ((0.1, -0.2), mirrored), ((0.1, 0.2), mirrored)):
        model = replace(plate, footprint=PatchFootprint(SQUARE, warp=warp))
        ends.append(model.push(Pose(), stroke))
    assert abs(ends[0].turn) > 0.2
    assert abs(ends[0].turn + ends[1].turn) < 1e-8
    # Side 0 lies below, so that the mirror is x -> -x.
    assert np.allclose(ends[0].displacement * (-1, 1), ends[1].displacement, atol=1e-9)
    assert abs(ends[0].turn + ends[2].turn) > 1e-3


def cells(share, warp, count):
    """The square's pressure on points at the middles of cells; multiples of ten cells meet the frame's inner edge."""
    place = 0.09 * ((np.arange(count) + 0.5) / count - 0.5)
    x, y = (p.ravel() for p in np.meshgrid(place, place))
    frame = np.maximum(np.abs(x), np.abs(y)) > 0.8 * 0.045
    saddles = (warp[0] * (x * x - y * y) + warp[1] * 2.0 * x * y) / SQUARE.extent**2
    weights = 1.0 - share + np.where(frame, share + saddles, 0.0) / 0.36
    return PointFootprint(tuple(zip(x.tolist(), y.tolist(), strict=True)), tuple(weights.tolist()))


@pytest.mark.parametrize("theta", [0.4, 1.0])
def test_a_push_is_that_on_points_of_the_same_pressure_as_their_spacing_goes_to_zero(theta):
    """The points' error is of second order in their spacing; what extrapolation leaves is a 10 000th of the effect."""
    share, warp, push = 0.3, (0.1, 0.25), SidePush(distance=0.04)
    exact = QuasiStaticModel(Slider.mit("rect1"), LAW, footprint=PatchFootprint(SQUARE, (0.0, 0.0), share, warp))
    wanted = exact.push(Pose(theta=theta), push).turn
    grids = [replace(exact, footprint=cells(share, warp, count), accuracy=1e-8) for count in (10, 20, 40)]
    errors = np.array([grid.push(Pose(theta=theta), push).turn - wanted for grid in grids])
    flat = replace(exact, footprint=PatchFootprint(SQUARE, rim_share=share))
    effect = abs(flat.push(Pose(theta=theta), push).turn - wanted)
    assert effect > math.radians(0.1)
    assert abs(errors[2]) < 0.02 * effect
    assert np.all(np.abs(errors[:2] / errors[1:] - 4.0) < 0.05)
    assert abs(4.0 * errors[2] - errors[1]) / 3.0 < 1e-4 * effect


def test_equations_with_the_warps_terms_at_warp_zero_are_those_without():
    for shape in ("rect2", "ellip2"):
        model = QuasiStaticModel(Slider.mit(shape), LAW, accuracy=1e-9)
        nearly = replace(model, footprint=PatchFootprint(model.slider.outline, warp=(1e-14, 0.0)))
        push = SidePush(0, 0.2, 0.1, 0.05)
        found, wanted = nearly.push(Pose(theta=1.0), push), model.push(Pose(theta=1.0), push)
        assert abs(found.turn - wanted.turn) < 1e-11
        assert np.allclose(found.displacement, wanted.displacement, atol=1e-12)


def test_pushes_and_drags_on_any_warp_balance_their_forces():
    checked = 0
    for shape, share, warp in (
        ("rect1", 0.5, (0.3, -0.3)),
        ("hex", 0.0, (0.0, 0.3)),
        ("tri3", 0.4, (-0.2, 0.1)),
        ("ellip1", -0.2, (0.1, 0.1)),
    ):
        slider = Slider.mit(shape)
        footprint = PatchFootprint(slider.outline, (0.0, 0.0), share, warp)
        model = QuasiStaticModel(slider, random_friction(np.random.default_rng(3)), footprint=footprint)
        pushed = model.push(Pose(theta=0.6), SidePush(0, 0.3, 0.2, 0.06))
        dragged = model.drag(pushed.end, ((0.0, 0.0),), pin_friction_radius=0.001)
        errors = balance_errors(model, pushed.run.phases, pushed.trajectory)
        assert errors.max() < 1e-9
        assert dragged.end != pushed.end
        checked += len(errors)
    assert checked > 20


def least_pressure(outline, gradient, share, warp):
    """By brute force: at the nodes of a fine rule of frame and inner region, and along both edges."""
    rim = outline.points(4_000) - np.array(outline.centroid)
    share_of_side = np.linspace(0.0, 1.0, 2 if len(rim) > 100 else 400)[:, None]
    along = np.concatenate([a + share_of_side * (b - a) for a, b in pairwise(rim)])
    every = np.concatenate([scale * along for scale in np.linspace(0.8, 1.0, 21)])
    frame = 1.0 + 0.64 / 0.36 * share + every @ np.array(gradient) + saddle(outline, warp).at(every) / 0.36
    inside = area_rule(inner_of(outline))[0] - np.array(outline.centroid)
    return min(frame.min(), float((1.0 - share + inside @ np.array(gradient)).min()))


@pytest.mark.parametrize("name", ["square", "triangle", "hexagon", "thin", "ellipse"])
def test_a_warp_is_refused_just_where_its_pressure_goes_below_zero_anywhere(name):
    """The saddles are harmonic, so that edges tell; on a straight edge the least place may lie between its corners."""
    outline, rng, refused = OUTLINES[name], np.random.default_rng(6), 0
    for _ in range(12):
        gradient = tuple(rng.uniform(-0.4, 0.4, 2) / outline.extent)
        share, direction = rng.uniform(-0.2, 0.4), rng.uniform(0.0, 2.0 * math.pi)
        warp = rng.uniform(0.02, 0.8) * np.array((math.cos(direction), math.sin(direction)))
        least = least_pressure(outline, gradient, share, warp)
        assert abs(least) > 1e-4  # What the brute force may miss.
        if least > 0.0:
            assert PatchFootprint(outline, gradient, share, tuple(warp)).warp == tuple(warp)
            continue
        refused += 1
        with pytest.raises(InvalidInput, match="lifts the outline") as told:
            PatchFootprint(outline, gradient, share, tuple(warp))
        found = float(re.search(r"least pressure (\S+) of", str(told.value))[1])
        assert found == pytest.approx(least, rel=0.01, abs=2e-4)
    assert 1 < refused < 12


def test_the_largest_saddle_of_a_square_leaves_nothing_at_its_corner():
    assert PatchFootprint(SQUARE, warp=(0.0, 0.36)).warp == (0.0, 0.36)
    with pytest.raises(InvalidInput, match=r"warp \(0.0, 0.361\).*least pressure -0.00278"):
        PatchFootprint(SQUARE, warp=(0.0, 0.361))
    # (x^2 - y^2)/R^2 is least in the middle of a side.
    assert PatchFootprint(SQUARE, warp=(0.72, 0.0)).warp == (0.72, 0.0)
    with pytest.raises(InvalidInput, match=r"0\.721"):
        PatchFootprint(SQUARE, warp=(0.721, 0.0))


@pytest.mark.parametrize(
    ("warp", "told"), [((math.nan, 0.0), "warp"), ((0.1,), "warp"), ("much", "warp"), ((0.1, 0.2, 0.3), "warp")]
)
def test_warps_that_are_no_pair_of_numbers_are_refused(warp, told):
    with pytest.raises(InvalidInput, match=told):
        PatchFootprint(SQUARE, warp=warp)


def test_an_outline_that_does_not_hold_its_inner_copy_can_have_no_warp():
    hook = Polygon(((0, 0), (0.1, 0), (0.1, 0.1), (0.09, 0.1), (0.09, 0.01), (0, 0.01)))
    with pytest.raises(InvalidInput, match="does not lie inside"):
        PatchFootprint(hook, warp=(0.0, 0.1))
