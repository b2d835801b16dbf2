"""A foundation that is pressed: where the weight rests, its friction, and what cycles come to."""

import math
from dataclasses import replace

import numpy as np
import pytest
from foundation_reference import pressed_reference, quadratic_of

import cyclemap as cm
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import (
    Ellipse,
    EllipseFriction,
    FloorField,
    LimitSurface,
    PatchFootprint,
    Polygon,
    PressedFootprint,
    SidePush,
    Slider,
    SurfaceShape,
    grid_footprint,
    resting_pressure,
)
from cyclemap.mechanics.cycle_batch import CycleSlopes, run_batch
from cyclemap.mechanics.engine.schema import PARAMETERS, SHAPES
from cyclemap.mechanics.engine.strokes import friction_values, pressure_tables
from cyclemap.mechanics.footprint import pressure_points

SQUARE = Slider.mit("rect1").outline
LOOP = cm.CollectionLoop.mit(material="isotropic")
# dome, bow_x, bow_y of the floor, then of the plate; orientation; push turn, dx, dy, drag turn.
DESIGN = (
    ((0.4, -0.4, 0.0), (0.0, 0.0, 0.0), 0.0, (73.031, 42.383, -72.824, -62.999)),
    ((2.0, -2.0, 0.0), (0.0, 0.0, 0.0), 40.0, (72.095, 43.405, -69.907, -62.834)),
    ((10.0, -10.0, 0.0), (0.0, 0.0, 0.0), 90.0, (67.125, 36.474, -99.118, -63.636)),
    ((10.0, -10.0, 0.0), (0.0, 0.0, 0.0), 130.0, (57.176, 38.129, -105.014, -49.031)),
    ((2.0, -2.0, 0.0), (0.0, 1.0, 0.5), 0.0, (67.936, 45.358, -68.857, -47.488)),
    ((2.0, -2.0, 0.0), (0.0, 1.0, 0.5), 130.0, (66.126, 42.524, -86.424, -53.766)),
)
TROUGH, WARP = SurfaceShape(2.0, 2.0, math.pi / 2), SurfaceShape(0.5, 1.0, 0.4)


FLAT = SurfaceShape()


def on(loop=LOOP, plate=FLAT, floor=FLAT, outline=None, **changes):
    footprint = PressedFootprint(outline or loop.slider.outline, plate, floor)
    return replace(loop, footprint=footprint, **changes)


def turns(loop, theta):
    """Push turn, displacement, drag turn (4, n) of cycles."""
    ran = run_batch((loop,), np.atleast_1d(theta)[None])
    return np.array((ran.push_turn[0], *ran.push_displacement[0].T, ran.drag_turn[0]))


@pytest.mark.parametrize(("floor", "plate", "degrees", "expected"), DESIGN)
def test_cycles_are_those_of_an_independent_solver(floor, plate, degrees, expected):
    loop = on(plate=SurfaceShape.of_bend(*plate), floor=SurfaceShape.of_bend(*floor))
    push, dx, dy, drag = turns(loop, math.radians(degrees))[:, 0]
    np.testing.assert_allclose(np.degrees((push, drag)), (expected[0], expected[3]), atol=0.01)
    np.testing.assert_allclose(np.multiply(1e3, (dx, dy)), expected[1:3], atol=0.02)


def star(rng, corners, is_concave):
    angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, corners))
    radius = 0.05 * (rng.uniform(0.35, 1.3, corners) if is_concave else np.ones(corners))
    places = np.column_stack((1.3 * radius * np.cos(angle), radius * np.sin(angle)))
    return Polygon(tuple(map(tuple, places)))


def drawn(count, seed):
    """Random outlines on random shapes, to near the rigid limit, some with a centre of mass that is
    off the centroid: contacts of all kinds; with an orientation.
    """
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        kind, size = len(found) % 3, (1.0, 10.0, 100.0, 300.0)[int(rng.integers(4))]
        plate, floor = (SurfaceShape.of_bend(*rng.normal(0.0, size, 3)) for _ in range(2))
        try:
            outline = (
                Ellipse(0.05, 0.05 * rng.uniform(0.3, 1.0))
                if kind == 2
                else star(rng, int(rng.integers(3, 9)), kind == 1)
            )
            middle, off = np.array(outline.centroid), rng.normal(0.0, 0.04, 2) * rng.integers(2)
            centre = tuple((middle + outline.extent * off).tolist())
            footprint = PressedFootprint(outline, plate, floor, centre)
            pressure_tables(footprint)
        except InvalidInput:
            # corners in a line, a centre of mass outside of what is convex, islands too stiff
            continue
        found.append((footprint, rng.uniform(0.0, 7.0), rng))
    return found


def differences(footprint, theta, matrix, twist):
    """How far load and moments, D, wrench and Hessian are off a quadrature, relative."""
    size, middle = footprint.extent, np.array(footprint.outline.centroid) / footprint.extent
    quadratic = quadratic_of(footprint, theta)
    moments, speed, wrench, hessian = pressed_reference(footprint, quadratic, matrix, twist)
    x, y = middle
    about = np.array(twist) + twist[2] * np.array((y, -x, 0.0))
    values = friction_values(
        pressure_tables(footprint), theta, tuple(np.transpose(matrix).ravel().tolist()), about[None]
    )[0]
    shift = np.array(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (y, -x, 1.0)))
    found = values[[4, 5, 7, 5, 6, 8, 7, 8, 9]].reshape(3, 3)
    load = np.array((1.0, *(np.array(footprint.centre) / size - middle)))
    return (
        np.abs(moments - load).max(),
        abs(values[0] - speed) / speed,
        np.abs(shift @ values[1:4] - wrench).max() / np.abs(wrench).max(),
        np.abs(shift @ found @ shift.T - hessian).max() / np.abs(hessian).max(),
    )


@pytest.mark.slow
def test_load_and_friction_are_those_of_a_quadrature_over_the_area():
    off = []
    for index, (footprint, theta, rng) in enumerate(drawn(4, 5)):
        matrix = np.array(((1.2, 0.3), (-0.2, 0.8))) if index % 2 else np.eye(2)
        for radius in (0.3, 1.2, 4.5):
            angle = rng.uniform(0.0, 2.0 * np.pi)
            twist = (radius * math.cos(angle), radius * math.sin(angle), 1.0)
            off.append(differences(footprint, theta, matrix, twist))
    # The quadrature itself is off, where rays graze thin contacts, by less the more panels it has.
    assert np.max(off) < 1e-3 and np.median(off, axis=0).max() < 1e-6


def test_load_and_friction_of_a_band_on_a_square_are_those_of_a_quadrature():
    footprint = PressedFootprint(SQUARE, WARP, SurfaceShape(10.0, 10.0, math.pi / 2))
    assert max(differences(footprint, 0.7, np.eye(2), (0.3, -0.5, 1.0))) < 1e-6


def contact_integrals(footprint, theta):
    """Load and moments of the pressure in extents, off the centroid, by the engine's own sums: of
    an object that does not turn D = |v| load, and the torques are the moments.
    """
    x, y = np.array(footprint.outline.centroid) / footprint.extent
    twists = np.array(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    values = friction_values(pressure_tables(footprint), theta, (1.0, 0.0, 0.0, 1.0), twists)
    return values[0, 0], values[1, 3] - x * values[1, 2], -values[0, 3] - y * values[0, 1]


def test_load_and_moments_balance_between_the_rows_of_the_table():
    for footprint, theta, rng in drawn(9, 8):
        size = footprint.extent
        lever = (np.array(footprint.centre) - footprint.outline.centroid) / size
        # Near the rigid limit stiff terms cancel, and their rounding is left.
        stiffness = np.abs(footprint.plate_bend).sum() + np.abs(footprint.floor_bend).sum()
        for turn in (theta, *rng.uniform(-10.0, 10.0, 8)):
            found = contact_integrals(footprint, turn)
            bound = 1e-11 + 2e-12 * stiffness
            np.testing.assert_allclose(found, (1.0, *lever), rtol=0.0, atol=bound)


# A hyperbola that bends by two hundredths across to what it bends by along: nothing runs from one of
# its branches to the other, between which rounding would have it bend.
SLIVERS = PressedFootprint(
    Polygon(((0.04, 0.03), (-0.04, 0.03), (-0.04, -0.03), (0.04, -0.03))),
    SurfaceShape(8.101898201730458, 0.9577288880504555, 1.014216064321661),
    SurfaceShape(-5.161052958961521, 3.85009274318957, 1.5923354350937586),
)


def touching(outline, bow, axis):
    """A trough that just touches in the middle: P = 0 falls into one line, twice."""
    return PressedFootprint(outline, floor=SurfaceShape(bow, bow, axis))


@pytest.mark.parametrize(
    ("footprint", "turns"),
    [
        (PressedFootprint(SQUARE, WARP, TROUGH), np.linspace(0.0, 7.0, 12)),
        *(
            (touching(*trough, axis), (0.0, 0.3, math.pi / 2, 2.0))
            for trough in ((Ellipse(0.05, 0.05), 2.0), (SQUARE, 1.5 / 0.81))
            for axis in (math.pi / 2, 0.1, 0.0)
        ),
        (SLIVERS, np.linspace(2.25, 2.35, 5)),
    ],
)
def test_a_balance_leaves_nothing_on_usual_shapes_and_where_contacts_just_touch(footprint, turns):
    found = [contact_integrals(footprint, turn) for turn in turns]
    np.testing.assert_allclose(found, np.tile((1.0, 0.0, 0.0), (len(turns), 1)), atol=1e-11)


THETA = np.linspace(0.0, 6.0, 7)


def test_the_plates_shape_alone_leaves_the_map_a_rotation():
    found = turns(on(plate=WARP), THETA)
    np.testing.assert_allclose(found, found[:, :1] + np.zeros(7), rtol=0.0, atol=1e-8)
    assert abs(found[0, 0] - turns(LOOP, 0.0)[0, 0]) > 1e-3


def test_turning_the_floor_conjugates():
    turn = 0.9
    turned = replace(TROUGH, axis=TROUGH.axis + turn)
    first, second = on(plate=WARP, floor=TROUGH), on(plate=WARP, floor=turned)
    np.testing.assert_allclose(turns(second, THETA + turn), turns(first, THETA), atol=1e-8)


def test_isotropic_friction_on_a_bowed_floor_has_the_symmetry_of_half_a_turn():
    loop = on(plate=WARP, floor=TROUGH)
    found = turns(loop, THETA)
    np.testing.assert_allclose(turns(loop, THETA + math.pi), found, rtol=0.0, atol=1e-8)
    assert np.ptp(found[0]) > 0.05


def test_flat_shapes_press_evenly():
    twists = np.random.default_rng(0).normal(size=(50, 3)) * (1.0, 1.0, 20.0)
    law = EllipseFriction(0.3, 0.2, 0.04, 0.02, 0.5)
    for outline in (SQUARE, star(np.random.default_rng(1), 7, True), Ellipse(0.05, 0.03)):
        pressed = LimitSurface(PressedFootprint(outline), law)
        even = LimitSurface(PatchFootprint(outline), law)
        for name in ("dissipation", "wrench", "hessian"):
            found, expected = (getattr(each, name)(twists, 0.8) for each in (pressed, even))
            np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


def test_a_limit_surface_turns_the_floor_against_the_plate():
    # The frame is the orientation: seen from the floor, turned floor and turned plate are alike.
    turn, twist = 0.6, np.array((0.1, 0.05, 1.5))
    law = EllipseFriction.isotropic(0.3)
    turned = replace(TROUGH, axis=TROUGH.axis - turn)
    found = LimitSurface(PressedFootprint(SQUARE, WARP, TROUGH), law).wrench(twist, turn)
    expected = LimitSurface(PressedFootprint(SQUARE, WARP, turned), law).wrench(twist)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-11)


def test_the_pressure_is_the_sum_of_both_shapes_where_it_rests():
    footprint, theta = PressedFootprint(SQUARE, WARP, TROUGH), 0.7
    grid = (np.arange(400) + 0.5) / 400 * 0.09 - 0.045
    places = np.stack(np.meshgrid(grid, grid), axis=-1)
    pressure = resting_pressure(footprint, theta, places)
    assert pressure.mean() == pytest.approx(1.0, abs=1e-5)
    moment = np.mean(pressure[..., None] * places, axis=(0, 1))
    np.testing.assert_allclose(moment, 0.0, atol=1e-7)


@pytest.mark.slow
def test_a_push_whose_slip_was_bracketed_only_to_the_digits_of_its_pressure_is_solved():
    """The bracket's residual was 1.6e-10 of the load where 1e-10 was asked; a neighbour within a
    ten-millionth of a radian took another way.
    """
    ellipse = Ellipse(0.0525, 0.065445)
    plate = SurfaceShape(-8.81998143600099, 6.296304934625663, 0.7344537478609858)
    floor = SurfaceShape(10.088401621836036, 6.763275390737316, 1.6791934906485084)
    digits = """
        -1.1543057911847712 6.66165215475341 -7.9618489050624905 -1.1585977763316044
        -17.030507828631023 2.05963818071572 -3.7427594620279825 -2.716868160220897
        2.9879406125064345 11.78552708378943 2.9188926927254286 -3.2139439719004907
        0.9146714180874151 -10.489961489683186 -2.07326919441902
    """
    coefficients = np.reshape([float(word) for word in digits.split()], (3, 5))
    model = replace(
        LOOP.model,
        slider=Slider(ellipse, 1.1104, hitch=LOOP.model.slider.hitch),
        friction=EllipseFriction(0.25, 0.25),
        pusher=replace(LOOP.model.pusher, friction=0.17895),
        footprint=PressedFootprint(
            ellipse, plate, floor, field=FloorField(tuple(map(tuple, coefficients)), 0.025)
        ),
        accuracy=1e-8,
    )
    push = SidePush(0, 0.55, 0.698, 0.05016521011177545)
    turns = [
        model.push(model.start_pose(-2.4476878 + off), push).turn for off in (-1e-7, 0.0, 1e-7)
    ]
    assert np.ptp(turns) < 1e-6
    assert math.degrees(turns[1]) == pytest.approx(-7.55995, abs=2e-5)


def test_accuracy_is_what_was_asked_for():
    ellipse = cm.CollectionLoop.mit(material="isotropic", slider=Slider.mit("ellip2"))
    loops = (
        on(floor=TROUGH),
        on(plate=WARP, floor=SurfaceShape(10.0, 10.0, 1.2)),
        # Rests on long arcs of its rim.
        on(ellipse, SurfaceShape(20.0, 6.0, 1.8), SurfaceShape(9.0, 20.0, 1.8)),
        on(ellipse, SurfaceShape(-4.0, 5.0, 1.8), SurfaceShape(0.0, 13.0, 0.6)),
    )
    for loop in loops:
        exact = turns(replace(loop, accuracy=1e-11), THETA)
        for accuracy in (1e-4, 1e-6, 1e-8):
            found = turns(replace(loop, accuracy=accuracy), THETA)
            # What is asked for is aimed at.
            assert np.abs(found - exact)[[0, 3]].max() < 2.0 * accuracy


def test_sums_from_near_and_from_far_agree():
    for floor in (TROUGH, SurfaceShape(8.0, 8.0, 0.4), SurfaceShape(-8.0, 1.0)):
        tables = pressure_tables(PressedFootprint(SQUARE, WARP, floor))
        angle = np.linspace(0.0, 6.0, 40)
        # The first call changes from one to the other at 1.7 times 3.
        sums = [
            friction_values(
                tables,
                0.4,
                (1.0, 0.0, 0.0, 1.0),
                np.column_stack((np.cos(angle), np.sin(angle), np.full(40, (1.0 + e) / 5.1))),
            )
            for e in (1e-13, -1e-13)
        ]
        off = np.abs(sums[0] - sums[1]).max(axis=0)
        assert off[:4].max() < 1e-9 and off[4:].max() < 1e-8
        assert off.max() > 0.0


def test_on_a_floor_that_varies_with_the_place_slopes_know_where_pushes_begin():
    """Those of pushes and drags taken apart are those of whole cycles, to the bit, and their
    differences.
    """
    rows = ((0.4, -0.3, 0.1, 0.2, 0.1), (0.5, 0.2, -0.1, 0.1, 0.2), (-0.2, 0.3, 0.1, 0.1, 0.0))
    footprint = PressedFootprint(SQUARE, floor=TROUGH, field=FloorField(rows, reach=0.15))
    loop = replace(LOOP, footprint=footprint, accuracy=1e-9)
    theta, apart = np.linspace(-3.0, 3.0, 4), 1e-4
    values, slopes = CycleSlopes(loop)(theta)
    whole = run_batch((loop,), theta[None], 1)
    np.testing.assert_array_equal(values, whole.theta_next[0])
    np.testing.assert_array_equal(slopes, whole.jacobian[0, :, -1, 0])
    ends = [run_batch((loop,), theta[None] + sign * apart).theta_next[0] for sign in (1.0, -1.0)]
    np.testing.assert_allclose(slopes, (ends[0] - ends[1]) / (2.0 * apart), rtol=0.0, atol=1e-4)


def test_derivatives_by_shapes_that_a_footprint_does_not_have_are_nan():
    ran = run_batch((LOOP,), np.array([[0.3]]), len(PARAMETERS))
    columns = [PARAMETERS.index(name) for name in SHAPES]
    assert np.isnan(ran.jacobian[..., columns]).all()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: SurfaceShape(math.nan), "dome"),
        (lambda: SurfaceShape(0.0, math.inf), "bow"),
        (lambda: SurfaceShape(0.0, 1.0, math.nan), "axis"),
        (lambda: SurfaceShape(1001.0), "rigid"),
        (lambda: PressedFootprint(circle(201)), "simplify"),
        (lambda: PressedFootprint(SQUARE, centre=(0.09, 0.0)), "tip"),
        (lambda: PressedFootprint(SQUARE, centre=(math.nan, 0.0)), "centre of mass"),
        (lambda: PressedFootprint(grid_footprint(SQUARE, 8)), "support points"),
        (lambda: PressedFootprint(SQUARE, plate=3), "plate must be a SurfaceShape, not 3"),
        (lambda: PressedFootprint(SQUARE, floor=None), "floor must be a SurfaceShape, not None"),
        (lambda: PressedFootprint(SQUARE, field=3), "must be a FloorField or None, not 3"),
        (
            lambda: resting_pressure(PatchFootprint(SQUARE), 0.0, (0.0, 0.0)),
            "footprint must be a PressedFootprint, not Patch",
        ),
        (lambda: pressure_points(PressedFootprint(SQUARE), 8), "changes as the object turns"),
        (
            lambda: cm.protocol.loop_from_settings({"rim_share": 0.1}, on(floor=TROUGH)),
            "set one of them to 0",
        ),
        (lambda: resting_pressure(PressedFootprint(SQUARE), math.nan, ((0.0, 0.0),)), "theta"),
        (lambda: resting_pressure(PressedFootprint(SQUARE), 0.0, ((math.nan, 0.0),)), "places"),
    ],
)
def test_what_cannot_be_is_refused_with_its_reason(make, words):
    with pytest.raises(InvalidInput, match=words):
        make()


def circle(corners):
    angle = np.arange(corners) * 2.0 * np.pi / corners
    places = 0.05 * np.column_stack((np.cos(angle), np.sin(angle)))
    return Polygon(tuple(map(tuple, places.tolist())))


def test_outlines_of_two_hundred_corners_press():
    disc = LimitSurface(PressedFootprint(circle(200), floor=TROUGH), EllipseFriction(0.3, 0.3))
    round_one = LimitSurface(PressedFootprint(Ellipse(0.05, 0.05), floor=TROUGH), disc.friction)
    twist = (0.1, 0.0, 3.0)
    np.testing.assert_allclose(disc.wrench(twist), round_one.wrench(twist), rtol=0.0, atol=1e-4)
