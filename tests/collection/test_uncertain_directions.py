"""Intervals of stable directions hold the directions of further draws, and say which way they were
found.
"""

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection import CollectionLoop, DirectionUncertainty, direction_uncertainty
from cyclemap.collection.loop_surfaces import on_material
from cyclemap.maps import WrappedNormal, fixed_points, response
from cyclemap.mechanics import (
    EllipseFriction,
    FoundWith,
    Material,
    MaterialPosterior,
    PlatePressure,
    load_material,
)
from cyclemap.mechanics.cycle_batch import run_batch
from cyclemap.protocol import loop_from_settings

NAMES = ("mu_a", "mu_b", "m0", "n0", "phi_deg", "pusher_mu", "rect1.rim_share")


def drawn(base: Material, size: float, rows: int, seed: int) -> Material:
    """The material with a posterior of normal errors, `size` times a few per cent."""
    law, z = base.friction, np.random.default_rng(seed).normal(size=(rows, len(NAMES)))
    middle = np.array([law.mu_a, law.mu_b, law.m0, law.n0, math.degrees(law.phi), 0.15, 0.2])
    samples = middle + size * z * (0.005, 0.005, 0.004, 0.004, 3.0, 0.015, 0.04)
    found = FoundWith(pusher_friction=0.15)
    base = replace(base, found_with=found, plates=(PlatePressure("rect1", rim_share=0.2),))
    return replace(base, posterior=MaterialPosterior(NAMES, tuple(map(tuple, samples.tolist()))))


def loops_of(loop: CollectionLoop) -> list[CollectionLoop]:
    assert loop.material.posterior is not None
    return [
        on_material(loop, loop.material.sample(number))
        for number in range(len(loop.material.posterior))
    ]


def on(material: Material, ring: float = 1.0) -> CollectionLoop:
    loop = CollectionLoop.mit(material)
    x, y = loop.slider.hitch
    return replace(loop, slider=replace(loop.slider, hitch=(ring * x, ring * y)))


def inside(found: DirectionUncertainty, theta: np.ndarray) -> float:
    (one,) = found.directions
    return float(np.mean(np.mod(theta - one.lower, 2.0 * math.pi) <= one.upper - one.lower))


@pytest.mark.slow
def test_the_first_order_interval_holds_the_directions_of_further_draws() -> None:
    """Truth by Newton's method on the cycle itself, for 300 draws that the interval has not
    seen."""
    plywood = load_material("plywood")
    found = direction_uncertainty(on(drawn(plywood, 0.5, 200, 1)))
    assert (found.method, found.chance, found.is_posterior, found.samples) == (
        "first order",
        1.0,
        True,
        200,
    )
    assert pickle.loads(pickle.dumps(found)) == found
    loops = loops_of(on(drawn(plywood, 0.5, 300, 2)))
    theta = np.full((len(loops), 1), found.directions[0].theta)
    for _ in range(6):
        batch = run_batch(loops, theta, 1)
        step = (batch.theta_next - theta) / (1.0 - batch.jacobian[:, :, -1, 0])
        theta = theta + step
    assert np.abs(step).max() < 1e-6
    assert 0.9 <= inside(found, theta.ravel()) <= 0.99


@pytest.mark.slow
def test_near_the_saddle_node_samples_are_run_and_tell_how_many_lock_in() -> None:
    """Truth by the certified fixed points of each draw's own map."""
    plywood = load_material("plywood")
    found = direction_uncertainty(on(drawn(plywood, 1.0, 100, 1), 0.72))
    assert found.method == "samples" and 0.0 < found.chance < 1.0
    assert found.first_order_error is not None and found.first_order_error > math.radians(1.0)
    maps = [loop.circle_map(1e-3) for loop in loops_of(on(drawn(plywood, 1.0, 100, 2), 0.72))]
    stable = [
        [float(orbit.points[0]) for orbit in fixed_points(one) if orbit.stable] for one in maps
    ]
    locked = [row[0] for row in stable if row]
    # Two shares of 100 each: three standard errors of their difference.
    assert len(locked) / 100 == pytest.approx(found.chance, abs=3.0 * math.sqrt(0.5 / 100))
    assert 0.87 <= inside(found, np.array(locked)) <= 0.99


@pytest.mark.slow
def test_both_ways_agree_where_errors_are_small_and_where_the_ellipse_is_nearly_a_circle(
    monkeypatch,
) -> None:
    round_floor = Material("round", EllipseFriction(0.2501, 0.25, 0.04, 0.01, 0.3))
    for material in (load_material("plywood"), round_floor):
        loop = on(drawn(material, 0.1, 40, 3))
        first = direction_uncertainty(loop)
        monkeypatch.setattr("cyclemap.collection.uncertain_directions._LEAST", -1.0)
        monkeypatch.setattr("cyclemap.collection.uncertain_directions._SHARE", -1.0)
        full = direction_uncertainty(loop)
        monkeypatch.undo()
        assert (first.method, full.method) == ("first order", "samples")
        (one,), (other,) = first.directions, full.directions
        width = other.upper - other.lower
        assert (one.lower, one.upper) == pytest.approx((other.lower, other.upper), abs=0.06 * width)


def test_what_was_set_otherwise_than_by_the_material_stays_as_set() -> None:
    material = drawn(load_material("plywood"), 1.0, 3, 5)
    place = material.posterior.parameters.index("pusher_mu")
    assert (
        on_material(CollectionLoop.mit(material), material.sample(1)).pusher.friction
        == material.posterior.samples[1][place]
    )
    loop = loop_from_settings({"pusher_mu": 0.3, "rim_share": 0.7}, CollectionLoop.mit(material))
    sample = on_material(loop, loop.material.sample(1))
    assert (sample.pusher, sample.footprint) == (loop.pusher, loop.footprint)
    assert sample.material.friction == material.sample(1).friction != loop.material.friction


@pytest.mark.parametrize("kg", [0.7, 1.1])
def test_shapes_that_are_the_materials_but_for_an_objects_weight_vary_with_its_samples(kg) -> None:
    loop = loop_from_settings({"mass_kg": kg}, CollectionLoop.mit("plywood-floor"))
    for number in (0, 1):
        sample = loop.material.sample(number)
        expected = replace(loop, footprint=None).with_material(sample).footprint
        assert on_material(loop, loop.material.sample(number)).footprint.is_near(expected)
        assert not expected.is_near(loop.footprint)


def test_a_material_without_posterior_tells_what_its_axes_would_do_and_no_chance() -> None:
    refused(direction_uncertainty, 5, told="loop must be a CollectionLoop.*, not 5")
    found = direction_uncertainty(CollectionLoop.mit("plywood"))
    assert (found.source, found.samples, found.locks) == ("axis ratio", 2, 2)
    law, ends = CollectionLoop.mit("plywood").material.friction, []
    for ratio in (1.0 / 1.1, 1.0, 1.1):
        friction = replace(law, mu_a=law.mu_a * math.sqrt(ratio), mu_b=law.mu_b / math.sqrt(ratio))
        points = fixed_points(CollectionLoop.mit(Material("varied", friction)).circle_map())
        ends += [float(orbit.points[0]) for orbit in points if orbit.stable]
    (one,) = found.directions
    assert (one.lower, one.upper) == pytest.approx((min(ends), max(ends)), abs=3e-4)


@pytest.mark.slow
def test_a_direction_moves_by_the_engines_derivatives_as_the_response_of_sampled_maps_tells():
    """By the rod's friction: dθ*/dp = -f_p/(f' - 1), exact, and by differences of five maps."""
    loop = CollectionLoop.mit("plywood")

    def family(friction):
        return loop_from_settings({"pusher_mu": friction}, loop).circle_map(1e-7)

    ((theta, rate),) = response(family, 0.15, WrappedNormal(0.3), (0.0, 0.8)).stable_points
    exact = loop.sensitivity(theta)
    assert rate.holds(-exact.by("pusher_friction") / (exact.by("theta") - 1.0))
    assert rate.error_bound < 0.01 < abs(rate)
