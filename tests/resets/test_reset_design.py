"""The design of a reset for plywood: what it promises is what the mechanics do, and demands bind as
they should.
"""

import math
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from refusals import refused

import cyclemap as cm
from cyclemap.mechanics import FoundWith, MaterialPosterior
from cyclemap.resets import (
    MaterialRange,
    ResetDemands,
    ResetStrategy,
    design_reset,
    histogram_distances,
    histogram_shares,
    material_range,
    orientation_law,
    run_strategy,
    sample_turns,
    sampled_orientations,
)
from cyclemap.resets.action_cycles import contact_lengths
from cyclemap.resets.reset_search import push_set, scored, searched

pytestmark = pytest.mark.slow

LOOP = cm.CollectionLoop.mit()
SIGMA = math.radians(1.1)
# A few materials of the range about plywood.
ABOUT = MaterialRange(LOOP.material, material_range(LOOP.material).others[::4])
COIN = ResetStrategy.pushes(LOOP.push, (1, 2))


@pytest.fixture(scope="module")
def design():
    return design_reset(LOOP, given=COIN, materials=ABOUT)


def row_of(design, role):
    (found,) = [row for row in design.rows if role in row.roles]
    return found


def test_it_finds_what_is_more_uniform_than_the_coin_between_sides_1_and_2(design) -> None:
    chosen, coin = design.chosen, row_of(design, "yours")
    assert coin.nominal.total_variation == pytest.approx(0.0385, abs=2e-4)
    assert coin.nominal.after == pytest.approx(0.0387, abs=2e-4)
    assert 1e3 * coin.drag == pytest.approx(74.3, abs=0.2)
    assert design.met and not chosen.misses
    assert chosen.worst <= 0.10 and chosen.worst_after <= 0.12
    assert chosen.worst_after < coin.worst_after
    assert chosen.nominal.total_variation < coin.nominal.total_variation
    assert chosen.seconds < coin.seconds


def test_rows_are_few_and_each_has_its_role(design) -> None:
    """One's own strategy is told in place of what a gripper could do."""
    roles = [role for row in design.rows for role in row.roles]
    assert len(design.rows) <= 7 and roles[0] == "chosen" and roles[-1] == "as it is"
    assert len(set(roles)) == len(roles)
    assert {"simplest", "most uniform", "cheapest", "way back only", "yours"} <= set(roles)
    able = [row for row in design.rows if not row.lacking]
    assert row_of(design, "most uniform").worst_after == min(row.worst_after for row in able)
    assert row_of(design, "cheapest").seconds == min(row.seconds for row in able if not row.misses)
    own = row_of(design, "as it is")
    assert own is design.own and own.misses[:2] == ("tv", "after")
    assert own.nominal.total_variation == pytest.approx(0.957, abs=2e-3)


def test_the_worst_of_the_range_is_where_it_is_said_to_be(design) -> None:
    """Laws made anew on every material that was tried, from finer samples."""
    row, materials = design.chosen, design.about.materials
    turns = sample_turns(row.strategy.prepared(LOOP), row.strategy.actions, materials, 72)
    laws = [orientation_law(turn, row.strategy, SIGMA) for turn in turns.refined(1024)]
    assert row.worst == pytest.approx(max(law.total_variation for law in laws), abs=3e-3)
    assert row.worst_after == pytest.approx(max(law.after for law in laws), abs=3e-3)
    there = laws[materials.index(row.worst_material)]
    assert there.after == pytest.approx(row.worst_after, abs=3e-3)


def test_pushes_by_the_mechanics_show_the_histograms_that_were_promised(design) -> None:
    """24 collections of 150 pushes on the worst material, against 400 of the row's promise."""
    row, runs, pushes = design.chosen, 24, 150
    loop = replace(LOOP, material=row.worst_material, accuracy=1e-5)
    turn = sample_turns(loop, row.strategy.actions, [row.worst_material], 72).refined(720)[0]
    promised = sampled_orientations(turn, row.strategy, pushes, 400, SIGMA, seed=9)
    start = np.random.default_rng(3).uniform(0.0, 2.0 * math.pi, runs)
    run = run_strategy(loop, row.strategy, pushes, runs=runs, start=start, sigma=SIGMA, seed=8)
    expected, found = (
        histogram_distances(histogram_shares(path)) for path in (promised, run.theta[:, :-1])
    )
    error = math.sqrt(found.var(ddof=1) / runs + expected.var(ddof=1) / 400)
    assert abs(found.mean() - expected.mean()) < 3.5 * error


@pytest.fixture(scope="module")
def source():
    """Pushes that keep the object for 120 mm."""
    return push_set(LOOP, ABOUT, SIGMA, 0.12)


@pytest.fixture(scope="module")
def pairs(source):
    """Shares of every two of them."""
    pairs = np.array(list(combinations(range(len(source.actions)), 2)))
    shares = np.zeros((len(pairs), len(source.actions)))
    np.put_along_axis(shares, pairs, 0.5, axis=1)
    return shares


def test_pushes_looked_at_keep_the_object_and_count_by_the_worst(source, pairs) -> None:
    assert np.array_equal(source.contact, contact_lengths(LOOP, source.actions))
    assert source.contact.min() >= 0.12
    alone = [scored(replace(source, kernels=each[None]), pairs, 50) for each in source.kernels]
    tv, after = (np.array([getattr(one, name) for one in alone]) for name in ("tv", "after"))
    found = scored(source, pairs, 50)
    assert found.tv == pytest.approx(tv.max(axis=0))
    assert found.after == pytest.approx(after.max(axis=0))
    # On which material it is worst depends on the pair.
    assert len(set(np.argmax(tv, axis=0).tolist())) > 1


def test_every_pair_of_pushes_was_looked_at(source, pairs) -> None:
    """Brute force: none is more uniform than the best that the search kept."""
    best = scored(source, pairs, 50)
    found = searched(source, 50, lambda done: None)
    two = ((found.shares > 0.0).sum(axis=1) == 2) & (found.shares.max(axis=1) == 0.5)
    assert two.sum() == len(pairs) > 20
    assert found.after[two].min() == pytest.approx(best.after.min(), abs=1e-12)
    assert found.after.min() <= best.after.min()


def test_a_loop_whose_histogram_is_nearer_to_uniform_than_any_reset_is_left_as_it_is() -> None:
    """On isotropic friction cycles step evenly around, though each tells its start."""
    even = replace(LOOP, material=cm.load_material("isotropic"))
    demands = ResetDemands(keep_push=True, abilities=("gripper",))
    left = design_reset(even, demands, materials=material_range(even.material, 0.0, 0.0))
    assert left.met and left.chosen is left.own and left.chosen.roles[:2] == ("chosen", "as it is")
    assert left.chosen.strategy.actions == (cm.resets.CycleAction(),)
    assert left.chosen.nominal.after > 0.5 and not left.chosen.misses
    assert left.chosen.worst_histogram[0] < min(row.worst_histogram[0] for row in left.rows[1:])
    assert left.chosen.worst_histogram[0] < 0.5 * left.independent


def test_contact_is_demanded_at_least() -> None:
    """The loop's own push keeps the object for 132 mm: too little for 140, which then binds."""
    demands = ResetDemands(keep_push=True, abilities=("gripper",), contact=0.14, pushes=100)
    design = design_reset(LOOP, demands, materials=material_range(LOOP.material, 0.0, 0.0))
    assert 0.12 < design.chosen.contact < 0.14 and not design.met
    assert "contact" in design.chosen.misses
    assert "contact" in [limit.demand for limit in design.binding]


def test_demands_that_nothing_meets_are_answered_by_the_nearest_and_what_binds() -> None:
    """What binds is told as the row of the same reset tells it."""
    about = material_range(LOOP.material, 0.1, 0.0)
    kept = design_reset(LOOP, ResetDemands(keep_push=True), materials=about)
    chosen = kept.chosen
    assert not kept.met and {"tv", "after"} <= set(chosen.misses) and len(kept.rows) <= 7
    assert all(action.push is None for action in chosen.strategy.actions)
    least = {limit.demand: limit.value for limit in kept.binding}
    assert least["tv"] > kept.demands.allow_tv and least["after"] >= least["tv"] - 1e-9
    own = [limit for limit in kept.binding if limit.strategy == chosen.strategy]
    told = {limit.demand: limit.value for limit in own}
    assert told["tv"] == chosen.worst and told["after"] == chosen.worst_after
    assert "gripper" not in chosen.strategy.needs
    assert row_of(kept, "with a gripper").lacking == ("gripper",)


def test_a_material_with_a_narrow_posterior_is_designed_for_by_that() -> None:
    """Where offsets may be half as large only gripper turns by 10 degrees do it; known, four."""
    law, random = LOOP.material.friction, np.random.default_rng(0)
    drawn = random.normal(1.0, 0.015, (6, 3)) * [law.mu_a, law.m0, 0.15]
    posterior = MaterialPosterior(("mu_a", "m0", "pusher_mu"), tuple(drawn.tolist()))
    known = replace(LOOP.material, found_with=FoundWith(pusher_friction=0.15), posterior=posterior)
    demands = ResetDemands(keep_push=True, abilities=("gripper",))
    wide = design_reset(LOOP, demands, materials=ABOUT)
    narrow = design_reset(replace(LOOP, material=known), demands)
    assert wide.met and wide.chosen.strategy.needs == ("gripper",)
    assert len(wide.chosen.strategy.actions) == 36
    assert len(narrow.chosen.strategy.actions) == 4
    assert narrow.about.origin == "6 of the 6 samples of its posterior"
    worst = []
    for sample in (known.sample(k) for k in range(6)):
        loop = cm.CollectionLoop.mit(sample)
        (turns,) = sample_turns(loop, narrow.chosen.strategy.actions, [sample], 72).refined(1024)
        worst.append(orientation_law(turns, narrow.chosen.strategy, SIGMA).after)
    assert narrow.chosen.worst_after == pytest.approx(max(worst), abs=2e-3)
    assert max(worst) < 0.2 * row_of(wide, "with a gripper").worst_after


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"allow_tv": 0.0}, "allow_tv is 0"),
        ({"extra_tv": 1.0}, "extra_tv is 1"),
        ({"within": 0}, "within must be at least 1"),
        ({"pushes": 10**9}, "pushes is 1000000000: more than 10000"),
        ({"drag_ratio": -1.0}, "drag_ratio must be positive"),
        ({"contact": math.nan}, "contact must be a finite number"),
        ({"abilities": ("wings",)}, "ability 'wings' is not known"),
    ],
)
def test_bad_demands_are_refused_by_name(fields, said) -> None:
    refused(ResetDemands, **fields, told=said)
