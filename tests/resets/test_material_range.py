"""Ranges of materials: the corners are where they are said to be, and what is inside lies between
them.
"""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import cyclemap as cm
from cyclemap.collection import on_material
from cyclemap.mechanics import FoundWith, MaterialPosterior, PlatePressure
from cyclemap.resets import MaterialRange, material_range

PLYWOOD = cm.load_material("plywood")


def test_corners_stretch_axes_against_each_other_and_scale_offsets() -> None:
    """Materials inside lie between them and are the same each time."""
    about, law = material_range(PLYWOOD), PLYWOOD.friction
    assert len(about.searched) == 9 and len(about.materials) == 13 and about.nominal.friction == law
    found = set()
    for material in about.others:
        friction = material.friction
        assert friction.mu_a * friction.mu_b == pytest.approx(law.mu_a * law.mu_b)
        ratio = friction.mu_a / friction.mu_b / (law.mu_a / law.mu_b)
        found.add((round(ratio, 9), round(friction.m0 / law.m0, 9), round(friction.n0 / law.n0, 9)))
        assert friction.phi == law.phi and material.wear is None
    assert found == set(itertools.product((1.1, round(1 / 1.1, 9)), (0.5, 1.5), (0.5, 1.5)))
    assert about.tried == material_range(PLYWOOD).tried and len(about.tried) == 4
    for friction in (material.friction for material in about.tried):
        assert 1 / 1.1 <= friction.mu_a / friction.mu_b / (law.mu_a / law.mu_b) <= 1.1
        assert 0.5 - 1e-9 <= friction.m0 / law.m0 <= 1.5 + 1e-9


def test_a_surface_that_wears_is_in_its_range_fresh_and_worn() -> None:
    """Offsets that are zero stay zero, and no range is the material alone."""
    measured = cm.load_material("plywood-measured")
    laws = [one.friction for one in material_range(measured).searched]
    assert len(laws) == 10 and laws[0] == measured.friction and laws[-1] == measured.wear.friction
    assert len(material_range(cm.load_material("isotropic")).searched) == 3
    assert material_range(PLYWOOD, 0.0, 0.0).materials == (PLYWOOD,)


def posterior(count) -> MaterialPosterior:
    names = ("mu_a", "m0", "pusher_mu", "pin_friction_mm", "rect1.rim_share")
    rows = [
        (0.25 + 1e-4 * k, 0.03, 0.14 + 1e-4 * k, 0.9 + 1e-3 * k, 1e-3 * k) for k in range(count)
    ]
    return MaterialPosterior(names, tuple(rows))


SLATE = replace(
    PLYWOOD,
    name="slate",
    found_with=FoundWith(pusher_friction=0.15, pin_friction_radius=9e-4),
    plates=(PlatePressure("rect1", rim_share=0.3),),
    posterior=posterior(200),
)


def test_a_material_with_a_posterior_is_searched_on_some_samples_and_judged_on_others() -> None:
    about = material_range(SLATE)
    assert about.origin == "71 of the 200 samples of its posterior"
    assert about.nominal.friction == SLATE.friction
    assert (len(about.searched), len(about.tried), len(about.materials)) == (13, 59, 72)
    assert not {one.name for one in about.searched} & {one.name for one in about.tried}
    shares = [one.pressure_of("rect1").rim_share for one in about.others]
    assert (min(shares), max(shares), len(set(shares))) == (0.0, pytest.approx(0.199), 12)
    assert about.share == 0.95 and 0.95 <= about.confidence == pytest.approx(1.0 - 0.95**59)
    few = material_range(replace(SLATE, posterior=posterior(3)))
    assert few.origin == "3 of the 3 samples of its posterior"
    assert (len(few.searched), len(few.tried), few.confidence) == (3, 1, pytest.approx(0.05))
    by_axes = material_range(SLATE, axes=0.05).searched
    assert {one.pressure_of("rect1") for one in by_axes} == set(SLATE.plates)


def sampled_range(count) -> MaterialRange:
    return MaterialRange(PLYWOOD, (PLYWOOD,), "", (PLYWOOD,) * count, sampled=True)


def test_the_worst_holds_for_as_much_of_a_posterior_as_is_promised_as_surely() -> None:
    """Of uniform values 95 % are no worse in 95 % of 1,500 posteriors, and not in all."""
    random, tried = np.random.default_rng(11), {59: [], 188: []}
    for count, found in tried.items():
        about = sampled_range(count)
        for _ in range(1500):
            # What was searched on is better than it should be.
            values = np.concatenate([[-1.0, -1.0], random.random(count)])
            found.append(values[about.worst(values)])
        kept = np.mean(np.array(found) >= 0.95)
        assert kept == pytest.approx(about.confidence, abs=0.02) and kept > 0.93
    assert np.mean(tried[188]) < np.mean(tried[59]) < 1.0
    corners = material_range(PLYWOOD)
    assert corners.worst(np.arange(13.0)) == 12 and corners.worst(-np.arange(13.0)) == 0
    assert (corners.share, corners.confidence) == (1.0, 1.0)
    few = sampled_range(20)
    assert few.worst(np.array([0.0, 3.0, *random.random(20)])) == 1
    assert few.confidence == pytest.approx(1 - 0.95**20)


def test_samples_of_a_surface_that_wears_lie_along_its_wear() -> None:
    measured = cm.load_material("plywood-measured")
    row = (0.26, 0.25, 0.26, 0.21)
    samples = MaterialPosterior(("mu_a", "mu_b", "worn.mu_a", "worn.mu_b"), (row,) * 5)
    about = material_range(replace(measured, posterior=samples))
    found = sorted(one.friction.mu_b for one in about.materials[1:])
    assert (found[0], found[-1]) == pytest.approx((0.21, 0.25)) and len(set(found)) == 5


def test_a_loop_on_another_material_is_what_that_material_makes_of_it() -> None:
    """All that a sample brings along; what was set by hand stays."""
    mit = cm.CollectionLoop.mit(SLATE)
    for sample in (SLATE.sample(0), SLATE.sample(69)):
        assert on_material(mit, sample) == cm.CollectionLoop.mit(sample)
    own = cm.protocol.loop_from_settings({"pusher_mu": 0.3, "footprint": "grid:8"}, mit)
    moved = on_material(own, SLATE.sample(69))
    assert (moved.pusher, moved.footprint) == (own.pusher, own.footprint)
    assert moved.reset != own.reset


def test_what_is_no_range_is_refused() -> None:
    refused(material_range, PLYWOOD, axes=1.0, told="less than 100 %, not by 100 %")
    refused(material_range, PLYWOOD, offsets=-0.1, told="must not be negative")
    far = replace(PLYWOOD, friction=replace(PLYWOOD.friction, m0=0.2))
    refused(material_range, far, offsets=0.5)
    refused(MaterialRange, PLYWOOD, ("plywood",), told="made of materials")
