"""Outlines, sliders, rods, protocols, materials: what they are, how they are written, what they
cannot be.
"""

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from refusals import refused

from cyclemap.errors import DataFileError
from cyclemap.mechanics import (
    MIT_HITCH,
    MIT_SHAPE_NAMES,
    CycleNoise,
    DragBack,
    DynamicModel,
    Ellipse,
    EllipseFriction,
    FoundWith,
    FrameShift,
    Material,
    MaterialPosterior,
    PlatePressure,
    Polygon,
    Pose,
    Pusher,
    QuasiStaticModel,
    SidePush,
    Slider,
    Wear,
    WorldPush,
    load_material,
    material_names,
)
from cyclemap.mechanics.material_text import material_toml

NAN, INF = float("nan"), float("inf")
BOW_TIE = ((0, 0), (1, 1), (1, 0), (0, 1))
SQUARE = ((0, 0), (1, 0), (1, 1), (0, 1))


def test_outlines_sliders_rods_and_protocols_that_cannot_be_are_refused():
    for vertices, told in (
        (SQUARE[:2], "three vertices"),
        (BOW_TIE, "cross"),
        (SQUARE[::-1], "run clockwise"),
        (((0, 0), (1, 0), (NAN, 1)), "finite"),
        (((0, 0), (1, 0), ("a", 1)), "numbers only"),
        (((0, 0), (0, 0), (1, 1), (0, 1)), "coincide"),
        (((0, 0), (1, 1), (2, 2)), "no area"),
        (((0, 0, 0), (1, 0, 0), (1, 1, 0)), "shape"),
        (((0, 0), (2, 0), (1, 0), (1, 1)), "cross or touch"),
        (((0, 0), (2, 0), (2, 2), (1, 0), (0, 2)), "cross or touch"),
    ):
        refused(Polygon, vertices, told=told)
    outline = Polygon(SQUARE)
    for call, values, told in (
        (Slider, ("rect1",), "Polygon or an Ellipse"),
        (Slider, (outline, -1.0), "-1.0"),
        (Slider, (outline, 1.0, (2.0, 0.5)), "outside the outline"),
        (Slider, (outline, 1.0, None, (0.0, INF)), "hitch"),
        (Slider.mit, ("rect4",), "did you mean 'rect"),
        (Ellipse, (0.0, 1.0), "semi_x"),
        (Pusher, (-0.001,), "-0.001"),
        (Pusher, ("thin",), "thin"),
        (SidePush, (-1,), "-1"),
        (SidePush, (0.5,), "0.5"),
        (SidePush, (0, 1.2), "1.2"),
        (SidePush, (0, 0.5, math.pi / 2), "points away"),
        (SidePush, (0, 0.5, 0.0, -0.1), "distance"),
        (WorldPush, ((0.0, NAN), 0.0, 1.0), "start"),
        (WorldPush, ((0.0, 0.0), INF, 1.0), "direction"),
        (WorldPush, ((0.0, 0.0), 0.0, 0.0), "distance"),
        (WorldPush, ("here", 0.0, 1.0), "start"),
        (Pose, (0.0, 0.0, NAN), "theta"),
        (DragBack, (((0.0, 1.0, 2.0),),), "way-point"),
        (DragBack, (5,), "way-points must be places"),
        (DragBack, (None,), "way-points must be places"),
        (DragBack, (np.array(5.0),), "way-point must be two finite numbers"),
        (Slider.mit, (5,), "slider shape must be a str, not 5"),
        (Ellipse, (1e-200, 1e-200), "1e-200 m is that of no object: give it in metres"),
        (Ellipse, (1.0, 1e200), "1e\\+200 m is that of no object"),
        (Polygon, (np.multiply(SQUARE, 1e-200),), "1e-200 m is that of no object"),
        (outline.contains, ([(0.5, NAN)],), "points must be finite"),
        (outline.contains, ([0.5],), "points must have shape"),
    ):
        refused(call, *values, told=told)
    refused(Slider, outline, inertia=0.0, told="inertia")
    refused(
        QuasiStaticModel,
        Slider.mit("rect1"),
        EllipseFriction.isotropic(0.2),
        accuracy=1e-13,
        told="accuracy",
    )


def test_places_are_asked_of_outlines_in_lists_as_in_arrays():
    for outline in (Polygon(SQUARE), Ellipse(1.0, 2.0)):
        inside = outline.contains([(0.5, 0.5), (1.5, 0.5)])
        assert inside.tolist() == [True, False]
        assert np.array_equal(outline.contains(np.array([(0.5, 0.5), (1.5, 0.5)])), inside)


@pytest.mark.parametrize("kind", [QuasiStaticModel, DynamicModel])
def test_parts_of_a_model_and_strokes_that_are_none_are_refused(kind):
    model = kind(Slider.mit("rect1"), EllipseFriction.isotropic(0.2))
    for name in ("slider", "friction", "pusher"):
        for value in (3, None):
            refused(replace, model, told=f"{name} must be an? .*, not {value}", **{name: value})
    refused(replace, model, footprint=3, told="footprint")
    refused(model.push, None, SidePush(), told="pose must be a Pose, not None")
    refused(model.push, Pose(), 5, told="push.* must be a SidePush.*, not 5")
    refused(model.drag, None, ((0.05, 0.0),), told="pose must be a Pose, not None")


def test_area_and_centroid_of_a_polygon_move_with_it_exactly():
    places = np.array(((0, 0), (0.1, 0), (0.1, 0.04), (0.04, 0.04), (0.04, 0.1), (0, 0.1)))
    far = Polygon(tuple(map(tuple, np.add(places, (1000.0, -500.0)))))
    near = Polygon(tuple(map(tuple, places)))
    assert abs(near.area - 0.0064) < 1e-17
    assert np.allclose(near.centroid, (0.03875, 0.03875), atol=1e-16)
    assert np.allclose(np.subtract(far.centroid, near.centroid), (1000.0, -500.0), atol=1e-9)
    assert not near.is_convex
    assert Polygon(SQUARE).is_convex


def test_the_mit_shapes_have_their_documented_sizes():
    centroids = {"tri1": (3.03, 3.06), "tri2": (-5.42, 3.09), "tri3": (-13.88, 3.19)}
    for name, wanted in centroids.items():
        assert np.allclose(np.multiply(Slider.mit(name).outline.centroid, 1e3), wanted, atol=0.15)
    assert Slider.mit("rect1").outline.vertices[:2] == ((0.045, 0.045), (-0.045, 0.045))
    assert Slider.mit("rect2").outline.area == pytest.approx(0.08991 * 0.11258)
    assert Slider.mit("hex").outline.vertices[0] == (0.0605, 0.0)
    assert Slider.mit("ellip3").outline == Ellipse(0.0525, 0.0785)
    assert math.hypot(*MIT_HITCH) == pytest.approx(0.015)
    assert len(MIT_SHAPE_NAMES) == 10


def test_inertias_of_the_mit_plates_agree_with_their_outlines_to_a_few_percent():
    for name in ("rect1", "rect2", "rect3"):
        slider = Slider.mit(name)
        width, height = np.ptp(slider.outline.array, axis=0)
        assert slider.inertia == pytest.approx(
            slider.mass * (width**2 + height**2) / 12.0, rel=0.01
        )


def test_table_one_is_plywood_and_unknown_materials_are_told():
    assert {"plywood", "isotropic"} <= set(material_names())
    law = load_material("plywood").friction
    assert (law.mu_a, law.mu_b, law.m0, law.n0) == (0.2545, 0.2346, 0.0325, 0.0082)
    assert law.phi == pytest.approx(2.6175, abs=1e-15)
    refused(load_material, "plywod", told="did you mean 'plywood'")


WORN_TABLE = """
[friction]
mu_a = 0.3
mu_b = 0.3
[worn]
cycles = 100
mu_a = 0.3
mu_b = 0.3"""


def test_parts_of_a_material_that_are_none_are_refused_by_name():
    law = EllipseFriction.isotropic(0.25)
    for name, value in (
        ("name", 5),
        ("friction", 5),
        ("found_with", None),
        ("wear", 5),
        ("posterior", 5),
        ("noise", 5),
        ("floor", None),
        ("field", 5),
        ("plates", 5),
        ("plates", (5,)),
        ("frames", "ab"),
        ("sessions", (5,)),
    ):
        told = rf"{name} of a material must be a.*, not "
        refused(replace, Material("a", law), told=told, **{name: value})
    row = ((0.1,), (0.2,))
    for call, values, told in (
        (PlatePressure, (5,), "name of a plate must be a str, not 5"),
        (PlatePressure, ("a", 0.0, 0.0, 0.0, 3), "shape of a must be a SurfaceShape, not 3"),
        (FoundWith, (NAN,), "pusher friction must be a finite number, not nan"),
        (FoundWith, (0.1, "x"), "pin friction radius must be a finite number, not 'x'"),
        (FoundWith, (-0.1,), "pusher friction must not be negative"),
        (MaterialPosterior, (("mu_a",), 5), "samples of a posterior must be a tuple"),
        (MaterialPosterior, (5, row), "parameters of a posterior must be a tuple"),
        (MaterialPosterior, ((5,), row), "a parameter of a posterior must be a str, not 5"),
        (MaterialPosterior, (("mu_a",), ((True,), (0.2,))), "sample 0 must be a finite number"),
    ):
        refused(call, *values, told=told)


def test_a_bad_or_absent_material_file_is_told_by_name(tmp_path):
    path = tmp_path / "bad.toml"
    refused(load_material, path, told="no such", kind=DataFileError)
    for text, told in (
        ("mu_a = 0.3", "unknown key"),
        ("[friction]\nmu_b = 0.3", "needs mu_a"),
        ("[friction]\nmu_a = 0.3\nmu_c = 0.1", "mu_c"),
        ("[friction]\nmu_a = 0.3", "needs mu_b"),
        ("[friction]\nmu_b = 0.3\nmu_a = 'rough'", "rough"),
        ("[friction]\nmu_a = 0.3\nmu_b = 0.3\nm0 = 0.4", "gain energy"),
        ("[friction]\nmu_b = 0.3\nmu_a = nan", "nan"),
        ("[friction\nmu_a = 0.3", "not TOML"),
        ("name = 'x'", "needs a table"),
        *((f"{WORN_TABLE}\ncourse = {course}", "course of wear") for course in ("5", "true")),
        (f"{WORN_TABLE}\n[found_with]\npusher_mu = -1", "pusher_mu must not be negative"),
        (f"{WORN_TABLE}\n[found_with]\npin_friction_mm = -1", "pin_friction_mm must not be neg"),
        (
            f"{WORN_TABLE}\n[posterior]\nparameters = ['mu_a']\nsamples = [[true], [0.2]]",
            "mu_a of posterior sample 0 must be a finite number, not True",
        ),
    ):
        path.write_text(text)
        refused(load_material, path, told=rf"bad\.toml.*{told}", kind=DataFileError)


RICH = Material(
    'plywood "B" of the lab\'s\tbench, ø \\',
    EllipseFriction(0.31, 0.22, 0.012, -0.034, -0.7),
    provenance="two\nlines \x7f",
    misfit="turn 2.1°",
    inferred=True,
    found_with=FoundWith(pusher_friction=0.17, pin_friction_radius=0.00123),
    wear=Wear(
        EllipseFriction(0.29, 0.24, 0.01, -0.02, 1.1),
        1500.0,
        ((100.0, 0.1), (1 / 3 + 400.0, 2 / 3)),
    ),
    noise=CycleNoise((-4.1, 1 / 3, -0.2), 0.69),
    plates=(PlatePressure("rect1", 0.1, 1 / 3), PlatePressure('my "box"', corner_share=0.1 + 0.2)),
    frames=(FrameShift('my "box"', 1e-3, -2.5e-3),),
    posterior=MaterialPosterior(
        ("mu_a", "phi_deg", "worn.mu_a", "worn.phi_deg", "rect1.rim_share"),
        ((0.1 + 0.2, 1 / 3, 0.2, -1e-17, 0.1), (0.3, 100.0 / 3, 0.2, 7.0, 0.2)),
    ),
)


def read_back(material: Material, folder) -> Material:
    file = folder / "material.toml"
    file.write_text(material_toml(material), encoding="utf-8")
    return load_material(file)


def assert_same(found: Material, given: Material) -> None:
    changed_units = ("friction", "wear", "found_with", "frames", "plates", "sessions")
    alike = {name: getattr(given, name) for name in changed_units}
    assert replace(found, **alike) == given
    for plate, own in zip(found.plates, given.plates, strict=True):
        assert plate.shape.axis == pytest.approx(own.shape.axis, abs=1e-15)
        turned = replace(plate.shape, axis=own.shape.axis)
        assert replace(plate, shape=turned) == own
    for session, own_session in zip(found.sessions, given.sessions, strict=True):
        assert session.shape.axis == pytest.approx(own_session.shape.axis, abs=1e-15)
        turned = replace(session.shape, axis=own_session.shape.axis)
        assert replace(session, shape=turned) == own_session
    shifts = [(one.plate, one.x, one.y) for one in given.frames]
    assert [
        (one.plate, pytest.approx(one.x), pytest.approx(one.y)) for one in found.frames
    ] == shifts
    laws = [(found.friction, given.friction)]
    if given.wear is not None:
        assert found.wear is not None and found.wear.cycles == given.wear.cycles
        assert found.wear.course == given.wear.course
        laws.append((found.wear.friction, given.wear.friction))
    for law, other in laws:
        assert [getattr(law, f.name) for f in fields(law)] == pytest.approx(
            [getattr(other, f.name) for f in fields(other)], abs=1e-15
        )
    for field in fields(FoundWith):
        value = getattr(given.found_with, field.name)
        assert getattr(found.found_with, field.name) == (
            None if value is None else pytest.approx(value, abs=1e-15)
        )


def test_a_material_with_everything_and_every_built_in_one_come_back(tmp_path) -> None:
    materials = [RICH, *map(load_material, material_names())]
    assert len(materials) >= 3
    for material in materials:
        assert_same(read_back(material, tmp_path), material)


def test_numbers_lose_no_digit_but_by_the_change_of_units(tmp_path) -> None:
    law = EllipseFriction(0.1 + 0.2, 1 / 3, 1e-17, math.pi / 100, 0.0)
    assert read_back(Material("digits", law), tmp_path).friction == law
