"""Ranges of materials: the corners are where they are said to be, and what is inside lies between them."""

import math
from dataclasses import replace

import pytest

import cyclemap as cm
from cyclemap.errors import InvalidInput
from cyclemap.resets import MaterialRange, material_range

PLYWOOD = cm.load_material("plywood")


def test_corners_stretch_axes_against_each_other_and_scale_offsets() -> None:
    about, law = material_range(PLYWOOD), PLYWOOD.friction
    assert len(about.searched) == 9 and len(about.materials) == 13 and about.nominal.friction == law
    found = set()
    for material in about.others:
        friction = material.friction
        assert friction.mu_a * friction.mu_b == pytest.approx(law.mu_a * law.mu_b)
        ratio = friction.mu_a / friction.mu_b / (law.mu_a / law.mu_b)
        found.add((round(ratio, 9), round(friction.m0 / law.m0, 9), round(friction.n0 / law.n0, 9)))
        assert friction.phi == law.phi and material.wear is None
    assert found == {(r, m, n) for r in (1.1, round(1 / 1.1, 9)) for m in (0.5, 1.5) for n in (0.5, 1.5)}


def test_offsets_that_are_zero_stay_zero_and_no_range_is_the_material_alone() -> None:
    assert len(material_range(cm.load_material("isotropic")).searched) == 3
    assert material_range(PLYWOOD, 0.0, 0.0).others == ()
    assert material_range(PLYWOOD, 0.0, 0.0).materials == (PLYWOOD,)


def test_a_surface_that_wears_is_in_its_range_fresh_and_worn() -> None:
    measured = cm.load_material("plywood-measured")
    laws = [one.friction for one in material_range(measured).searched]
    assert len(laws) == 10 and laws[0] == measured.friction and laws[-1] == measured.wear.friction


def test_materials_inside_lie_between_the_corners_and_are_the_same_each_time() -> None:
    about = material_range(PLYWOOD)
    assert about.tried == material_range(PLYWOOD).tried and len(about.tried) == 4
    ratios = [one.friction.mu_a / one.friction.mu_b for one in about.searched]
    for material in about.tried:
        assert min(ratios) <= material.friction.mu_a / material.friction.mu_b <= max(ratios)
        assert 0.5 - 1e-9 <= material.friction.m0 / PLYWOOD.friction.m0 <= 1.5 + 1e-9


def test_what_is_no_range_is_refused() -> None:
    with pytest.raises(InvalidInput, match="less than 100 %, not by 100 %"):
        material_range(PLYWOOD, axes=1.0)
    with pytest.raises(InvalidInput, match="must not be negative"):
        material_range(PLYWOOD, offsets=-0.1)
    with pytest.raises(InvalidInput):
        material_range(replace(PLYWOOD, friction=replace(PLYWOOD.friction, m0=0.2)), offsets=0.5)
    with pytest.raises(InvalidInput, match="made of materials"):
        MaterialRange(PLYWOOD, ("plywood",))  # type: ignore[arg-type]
    assert math.isclose(material_range(PLYWOOD).nominal.friction.mu_a, PLYWOOD.friction.mu_a)
