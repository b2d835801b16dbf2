"""Ranges of materials: what they hold, how they are drawn, and what a turned surface leaves as it is."""

import math

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction, FoundWith, Material, load_material
from cyclemap.resets.robust.material_range import MaterialRange
from cyclemap.resets.robust.sampled_materials import MaterialList, SampledMaterials, material_source, spread_out
from cyclemap.resets.robust.sampling_confidence import largest_between, share_bound
from cyclemap.resets.robust.scenario_loops import direction_matters, loop_on
from cyclemap.resets.strategies.combined import combine
from cyclemap.resets.strategies.drag_strategies import GripperTurn, StraightReset, TrailingLeg, WayPoints
from cyclemap.resets.strategies.push_strategies import DrawnPushes, fraction_pushes
from cyclemap.resets.strategies.schedules import LatinBlocks

PLYWOOD = load_material("plywood")
LAW = PLYWOOD.friction


def ratio(material):
    return material.friction.mu_a / material.friction.mu_b


def test_a_range_holds_the_nominal_material_its_corners_and_nothing_outside():
    """Ratio within 10 %, offsets within 50 %, geometric mean kept; all eight corners among the first."""
    sample = MaterialRange(PLYWOOD).without_direction().sampled(40, seed=3)
    assert len(sample) == 40 and sample.chosen == 9 and sample.drawn == 31 and sample.names == ("ratio", "m0", "n0")
    laws = [one.friction for one in sample.materials]
    assert laws[0] == LAW
    found = np.array(
        [
            (ratio(one) / (LAW.mu_a / LAW.mu_b), one.friction.m0 / LAW.m0, one.friction.n0 / LAW.n0)
            for one in sample.materials
        ]
    )
    corners = {tuple(row) for row in np.round(found[1:9], 9).tolist()}
    assert corners == {(a, b, c) for a in (0.9, 1.1) for b in (0.5, 1.5) for c in (0.5, 1.5)}
    low, high = found.min(axis=0), found.max(axis=0)
    assert np.allclose(low, [0.9, 0.5, 0.5]) and np.allclose(high, [1.1, 1.5, 1.5])
    assert all(law.mu_a * law.mu_b == pytest.approx(LAW.mu_a * LAW.mu_b) and law.phi == LAW.phi for law in laws)


def test_every_direction_is_drawn_where_phi_may_be_any():
    sample = MaterialRange(PLYWOOD).sampled(265, seed=1)
    turns = np.array([one.friction.phi - LAW.phi for one in sample.materials[sample.chosen :]])
    assert turns.size == 256 and np.abs(turns).max() <= math.pi
    counts, _ = np.histogram(turns, bins=16, range=(-math.pi, math.pi))
    assert np.all(counts == 16)  # Sobol points: exactly as many in each of 2^4 equal sectors
    assert len(MaterialRange(PLYWOOD).scenarios()) == 36


def test_samples_come_again_with_their_seed_and_differ_with_another():
    about = MaterialRange(PLYWOOD, pusher_friction=0.3)
    for draw in ("sobol", "independent"):
        once, again, other = (about.sampled(30, seed, draw) for seed in (5, 5, 6))
        assert np.array_equal(once.points, again.points) and once.independent == (draw == "independent")
        assert not np.array_equal(once.points, other.points)
    rods = [one.found_with.pusher_friction for one in about.sampled(17).materials]
    assert len(rods) == 17 and min(rods[1:]) == pytest.approx(0.105) and max(rods[1:]) == pytest.approx(0.195)


def test_a_range_of_no_width_is_the_nominal_material_alone():
    still = MaterialRange(PLYWOOD, ratio=0.0, offset=0.0, phi=0.0)
    assert still.names == () and [one.friction for one in still.sampled(4).materials] == [LAW] * 4
    assert [one.friction for one in still.scenarios().materials] == [LAW]


def test_a_loop_on_another_material_is_the_loop_made_for_it_and_back_again():
    """Rod, ring, pressure and lever follow the material; what was replaced on purpose stays where both say the same."""
    names = ("plywood", "plywood-measured", "abs", "delrin", "pu")
    count = 0
    for start in names:
        for end in names:
            moved, made = loop_on(CollectionLoop.mit(start), load_material(end)), CollectionLoop.mit(end)
            assert moved.slider.hitch == pytest.approx(made.slider.hitch, abs=1e-15)
            assert (moved.pusher, moved.reset, moved.footprint) == (made.pusher, made.reset, made.footprint)
            count += 1
    assert count == 25
    own = CollectionLoop.from_settings({"pusher_mu": 0.4}, CollectionLoop.mit("abs"))
    assert loop_on(own, MaterialRange(own.material).at([1.0, 1.0, 0.0, 0.0])).pusher.friction == 0.4
    warped = Material("warped", LAW, found_with=FoundWith(rim_share=0.5))
    assert loop_on(CollectionLoop.mit(warped), PLYWOOD).footprint is None


def test_the_surfaces_direction_matters_to_fixed_directions_only():
    loop, sides = CollectionLoop.mit(), DrawnPushes(fraction_pushes(CollectionLoop.mit().push, (0.3, 0.7)))
    free = [sides, StraightReset(), GripperTurn(), TrailingLeg(0.05), combine(sides, TrailingLeg(0.05))]
    fixed = [WayPoints(((0.05, 0.0),)), TrailingLeg(0.05, 0.3), TrailingLeg(0.05, schedule=LatinBlocks(6, False))]
    assert [direction_matters(loop, one) for one in free] == [False] * 5
    assert [direction_matters(loop, one) for one in fixed] == [True] * 3


def test_lists_and_single_materials_are_sources_too():
    two = [PLYWOOD, load_material("pu")]
    assert material_source(two).scenarios().materials == tuple(two)
    assert material_source(PLYWOOD).sampled(5).materials == (PLYWOOD,)
    assert MaterialList(tuple(two)).without_direction().sampled(1).materials == (PLYWOOD,)


def test_points_spread_out_leave_no_point_far():
    """Greedy choice is within twice the best: on a line of 101 points three suffice for a radius of 25."""
    line = np.arange(101.0)[:, None]
    kept = spread_out(line, 3)
    assert kept[:2] == [0, 100] and np.abs(line - line[kept].T).min(axis=1).max() <= 2 * 25


def test_the_bound_of_a_share_is_that_of_clopper_and_pearson():
    """None of n: 1 - 0.05^(1/n), below 3/n; and at the bound the binomial probability is 5 %."""
    from scipy.stats import binom

    for drawn in (10, 100, 1000):
        assert share_bound(0, drawn) == pytest.approx(1.0 - 0.05 ** (1.0 / drawn)) and share_bound(0, drawn) < 3 / drawn
    for exceeding in (1, 7):
        assert binom.cdf(exceeding, 200, share_bound(exceeding, 200)) == pytest.approx(0.05)
    assert share_bound(0, 0) == 1.0


def test_between_samples_a_smooth_function_is_not_larger_than_told():
    points = 2.0 * np.random.default_rng(1).random((400, 3)) - 1.0
    values = np.sin(points @ [0.5, 0.3, 0.2])
    told = largest_between(points, values)
    assert values.max() < math.sin(1.0) < told < math.sin(1.0) + 0.25
    assert largest_between(points[:2], values[:2]) == math.inf
    assert largest_between(np.zeros((4, 0)), np.arange(4.0)) == 3.0


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda: MaterialRange("plywood"), "give a Material"),
        (lambda: MaterialRange(PLYWOOD, ratio=1.0), "must keep its sign"),
        (lambda: MaterialRange(PLYWOOD, offset=-0.1), "must not be negative"),
        (lambda: MaterialRange(PLYWOOD, offset=9.0), "does not contain zero"),
        (lambda: MaterialRange(PLYWOOD, phi=4.0), "every direction"),
        (lambda: MaterialRange(PLYWOOD).at([0.0, 2.0, 0.0, 0.0]), "coordinates in"),
        (lambda: MaterialRange(PLYWOOD).sampled(10, draw="grid"), "must be 'sobol' or"),
        (lambda: MaterialList(()), "one or more"),
        (lambda: material_source("plywood"), "no set of materials"),
        (lambda: SampledMaterials((PLYWOOD,), np.zeros((2, 0)), (), 1), "need points of shape"),
        (lambda: share_bound(3, 2), "cannot exceed"),
        (lambda: share_bound(0, 2, 1.0), "between 0 and 1"),
    ],
)
def test_what_is_no_range_or_sample_is_refused(wrong, words):
    with pytest.raises(InvalidInput, match=words):
        wrong()


def test_an_isotropic_range_without_offset_varies_its_ratio_alone():
    even = Material("even", EllipseFriction.isotropic(0.25))
    assert MaterialRange(even, phi=0.0).names == ("ratio",)
