"""Materials written as TOML come back as they were."""

import math
from dataclasses import fields, replace

import pytest

from cyclemap.mechanics import (
    CycleNoise,
    EllipseFriction,
    FoundWith,
    FrameShift,
    Material,
    MaterialPosterior,
    PlatePressure,
    Wear,
    load_material,
    material_names,
)
from cyclemap.mechanics.material_text import material_toml

RICH = Material(
    'plywood "B" of the lab\'s\tbench, ø \\',
    EllipseFriction(0.31, 0.22, 0.012, -0.034, -0.7),
    provenance="two\nlines \x7f",
    misfit="turn 2.1°",
    inferred=True,
    found_with=FoundWith(pusher_friction=0.17, pin_friction_radius=0.00123),
    wear=Wear(EllipseFriction(0.29, 0.24, 0.01, -0.02, 1.1), 1500.0, ((100.0, 0.1), (1 / 3 + 400.0, 2 / 3))),
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
    alike = {name: getattr(given, name) for name in ("friction", "wear", "found_with", "frames")}
    assert replace(found, **alike) == given
    shifts = [(one.plate, one.x, one.y) for one in given.frames]
    assert [(one.plate, pytest.approx(one.x), pytest.approx(one.y)) for one in found.frames] == shifts
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
        assert getattr(found.found_with, field.name) == (None if value is None else pytest.approx(value, abs=1e-15))


def test_a_material_with_everything_comes_back(tmp_path) -> None:
    assert_same(read_back(RICH, tmp_path), RICH)


@pytest.mark.parametrize("field", [field.name for field in fields(FoundWith)])
def test_each_thing_found_with_the_friction_comes_back_alone(field, tmp_path) -> None:
    given = replace(RICH, found_with=FoundWith(**{field: 0.0123}), wear=None, posterior=None)
    assert_same(read_back(given, tmp_path), given)


def test_every_built_in_material_comes_back(tmp_path) -> None:
    assert len(material_names()) >= 2
    for name in material_names():
        assert_same(read_back(load_material(name), tmp_path), load_material(name))


def test_numbers_lose_no_digit_but_by_the_change_of_units(tmp_path) -> None:
    law = EllipseFriction(0.1 + 0.2, 1 / 3, 1e-17, math.pi / 100, 0.0)
    assert read_back(Material("digits", law), tmp_path).friction == law
