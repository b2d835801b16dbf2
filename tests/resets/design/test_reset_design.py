"""Designed resets: what is chosen, what is certain, and the answers to demands that nothing meets."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import WrappedNormal
from cyclemap.mechanics import SidePush, Slider
from cyclemap.resets.design.action_cache import ActionCache
from cyclemap.resets.design.reset_candidates import Effort
from cyclemap.resets.design.reset_curves import reset_curves
from cyclemap.resets.design.reset_demands import ResetDemands
from cyclemap.resets.design.reset_design import _given_names, design_reset
from cyclemap.resets.design.reset_survey import ResetSurvey
from cyclemap.resets.design.reset_trial import reset_trial
from cyclemap.resets.scores.strategy_scores import strategy_scores
from cyclemap.resets.strategies.drag_strategies import StraightReset, TrailingLeg, WayPoints
from cyclemap.resets.strategies.schedules import GoldenAngle
from cyclemap.resets.strategies.strategy_maps import strategy_maps

NOISE = WrappedNormal(math.radians(6.0))
LITTLE = Effort((), (), (), (), (), 4, 0, 1, 1)
TOLERANCE = 1e-2


@pytest.fixture(scope="module")
def plywood():
    """The MIT loop on plywood with pushes on all sides, and noise wide enough to be quick."""
    told: list[tuple[str, float]] = []
    made = design_reset(
        CollectionLoop.mit(),
        None,
        NOISE,
        thoroughness=LITTLE,
        tolerance=TOLERANCE,
        progress=lambda *one: told.append(one),
    )
    return made, told


@pytest.fixture(scope="module")
def kept():
    """The same with the loop's own push, a drag through a fixed way-point, and an allowance that nothing meets."""
    demands = ResetDemands(0.001, 0.001, 10, drag_ratio=1.2, reach=0.05, seconds=5.0)
    loop, aside = CollectionLoop.mit(), WayPoints(((0.05, 0.05),))
    also = [aside, TrailingLeg(0.05, schedule=GoldenAngle())]
    return design_reset(loop, demands, NOISE, keep_push=True, thoroughness=LITTLE, also=also, tolerance=TOLERANCE)


def test_a_reset_with_the_same_rod_and_ring_meets_the_demands_with_a_shorter_drag(plywood) -> None:
    design, _ = plywood
    assert design.met and design.certified and design.binding == ()
    chosen = design.chosen
    assert chosen.numbers.bounded and chosen.numbers.tv.upper <= 0.05 and chosen.numbers.tv_after.upper <= 0.1
    assert chosen.candidate.strategy.needs == () and chosen.drag_ratio < 1.0
    assert design.own.numbers.tv > 0.5 and design.own.drag_ratio == 1.0
    assert design.own in design.ranking and chosen is next(one for one in design.ranking if one.certain)


def test_strategies_that_need_more_stand_last_and_would_meet_the_demands(plywood) -> None:
    design, _ = plywood
    assert (
        {one.name.split(",")[0] for one in design.with_more}
        == {"gripper"}
        == {one.name.split(",")[0] for one in design.ranking[-2:]}
    )
    narrow = next(one for one in design.with_more if "within" in one.name)
    assert 0.03 < narrow.numbers.tv <= 0.05


def test_the_front_holds_what_nothing_betters_in_bias_and_drag_together(plywood) -> None:
    design, _ = plywood
    able = [one for one in design.ranking if not one.lacking]
    for one in able:
        better = [
            other
            for other in able
            if other.cost.mean_drag_length <= one.cost.mean_drag_length and other.numbers.tv < one.numbers.tv
        ]
        assert (one in design.front) == (not better)
    assert len(design.front) >= 1


def test_the_push_maps_are_shared_by_all_strategies(plywood) -> None:
    design, told = plywood
    assert design.cache.computed == 8 and len(design.ranking) >= 10
    assert next(stage for stage, _ in told) == "cycle maps of pushes"
    assert all(0.0 < done <= 1.0 for _, done in told) and len({stage for stage, _ in told}) >= 4


def test_a_run_by_the_full_mechanics_agrees_with_the_prediction_and_one_of_another_reset_does_not(plywood) -> None:
    design, _ = plywood
    trial = reset_trial(design.cache, design.chosen.candidate, 150, seed=2)
    assert trial.pushes == 150 and trial.agrees
    for found in (trial.total_variation, trial.kuiper, trial.misfit):
        assert 0.0 <= found.low < found.mean < found.high <= 1.0
    other = design.cache.finer(1.0)
    own = design.own.candidate
    for action in design.chosen.candidate.strategy.law().actions:
        other.put(other.loop, action, design.cache.kernel(own.strategy).maps[0])
    assert not reset_trial(other, design.chosen.candidate, 150, seed=2).agrees


def test_the_curves_hold_both_laws_all_maps_and_cycles_that_end_at_the_target(plywood) -> None:
    design, _ = plywood
    curves = reset_curves(design, pushes=40)
    for curve, one in ((curves.before, design.own), (curves.after, design.chosen)):
        assert np.trapezoid(curve.density, curves.theta) == pytest.approx(1.0, abs=2e-3)
        assert curve.path.shape == (40,) and curve.path[0] == 0.0
        assert sum(weight for _, weight in curve.turns) == pytest.approx(1.0)
        assert len(curve.scenes) == 4 and curve.reach == one.cost.reach
        for scene in curve.scenes:
            assert scene.ring[-1] == pytest.approx([0.0, 0.0], abs=1e-9)
            assert np.hypot(*(scene.rod[-1] - scene.rod[0])) <= 0.15 + 1e-9
            assert np.hypot(*scene.pushed.T).max() <= curve.reach + 1e-3
        ways = np.array([scene.rod[-1] - scene.rod[0] for scene in curve.scenes])
        angles = np.sort(np.mod(np.arctan2(ways[:, 1], ways[:, 0]), 2.0 * np.pi))
        assert np.diff(angles, append=angles[0] + 2.0 * np.pi) == pytest.approx(np.full(4, 0.5 * np.pi), abs=1e-6)


def test_impossible_demands_are_answered_by_the_nearest_and_what_stands_in_the_way(kept) -> None:
    assert not kept.met and not kept.certified
    assert kept.chosen is kept.ranking[0] and kept.chosen.misses
    assert {one.demand for one in kept.binding} >= {"reach", "seconds"}
    assert all(one.out_of_reach and one.least > one.limit for one in kept.binding)
    assert kept.push_floor == pytest.approx(0.075 + 0.00475) and kept.push_floor < kept.own.cost.rod_reach
    assert kept.seconds_floor == pytest.approx(17.5) and kept.seconds_floor < kept.own.cost.mean_seconds


def test_keeping_the_push_leaves_only_drags_and_grippers(kept) -> None:
    assert all(one.candidate.keeps_push(kept.loop) for one in kept.ranking)
    names = [one.name for one in kept.ranking]
    assert "way-points (given)" in names and "as it is" in names


def test_a_strategy_by_golden_angle_is_ranked_with_the_scores_of_its_schedule(kept) -> None:
    """Two routes: the maps of the cache, and those of the strategy by itself."""
    (golden,) = [one for one in kept.ranking if one.name == "trailing leg (given)"]
    maps = strategy_maps(kept.loop, golden.candidate.strategy, nodes=golden.candidate.nodes, tolerance=TOLERANCE)
    scores = strategy_scores(maps, NOISE, pushes=10)
    assert golden.numbers.tv == pytest.approx(scores.total_variation, abs=1e-9)
    assert golden.numbers.tv_after == pytest.approx(scores.curve.total_variation[-1], abs=1e-9)
    assert golden.numbers.effective_per_100 == pytest.approx(scores.effective_size_per_100, rel=1e-6)
    assert not golden.certain and golden.numbers.tv > 0.01


def test_a_run_by_golden_angle_agrees_with_its_own_prediction(kept) -> None:
    (golden,) = [one for one in kept.ranking if one.name == "trailing leg (given)"]
    trial = reset_trial(kept.cache, golden.candidate, 60, seed=1, runs=250)
    assert trial.agrees and trial.misfit.low < trial.misfit.high < 1.0


def test_the_pushes_found_are_ranked_by_golden_angle_and_in_blocks_too(plywood) -> None:
    design, _ = plywood
    ordered = [one for one in design.ranking if ": " in one.name]
    assert sorted(one.name.split(": ")[1] for one in ordered) == ["blocks of 12", "golden angle"]
    drawn = next(one for one in design.ranking if one.name == ordered[0].name.split(": ")[0])
    assert all(one.cost == drawn.cost and one.contact == drawn.contact for one in ordered)
    assert all(float(one.numbers.tv) != float(drawn.numbers.tv) for one in ordered)


def test_isotropic_friction_leaves_no_bias_and_what_is_missed_is_speed() -> None:
    """Every cycle of an isotropic surface is a rotation: the even law is stationary, however slow it is reached."""
    loop = CollectionLoop.mit("isotropic")
    design = design_reset(loop, None, WrappedNormal(0.02), keep_push=True, thoroughness=LITTLE, tolerance=TOLERANCE)
    assert design.own.numbers.tv < 1e-9
    leg = TrailingLeg(design.own.cost.mean_drag_length, side_step=0.05)
    assert design.cache.numbers(leg, 64, 50, 0.1).tv < 3e-3
    assert [miss.demand for miss in design.chosen.misses] == ["tv_after"] == [one.demand for one in design.binding]


def test_other_outlines_are_pushed_on_their_own_sides() -> None:
    loop = replace(CollectionLoop.mit(), slider=Slider.mit("tri1"), push=SidePush(0, 0.6))
    cache = ActionCache(loop, NOISE, TOLERANCE, orientations=2)
    survey = ResetSurvey(cache, ResetDemands(), keep_push=False, progress=lambda stage, done: None)
    survey.look_at_pushes(LITTLE)
    assert survey.library is not None and len(survey.library.pushes) + len(survey.left_out) == 6
    assert {push.side for push in survey.library.pushes} == {0, 1, 2}
    assert all("push on side" in one.name and one.reason for one in survey.left_out)


def test_bad_demands_efforts_and_lengths_are_refused() -> None:
    loop = CollectionLoop.mit()
    with pytest.raises(InvalidInput, match="give ResetDemands"):
        design_reset(loop, 0.05)  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match="unknown effort 'lazy'"):
        design_reset(loop, thoroughness="lazy")


def test_bad_trials_are_refused(kept) -> None:
    with pytest.raises(InvalidInput, match="pushes must be at least 1"):
        reset_trial(kept.cache, kept.chosen.candidate, 0)
    with pytest.raises(InvalidInput, match="runs must be at least 250"):
        reset_trial(kept.cache, kept.chosen.candidate, 10, runs=3)


def test_given_strategies_of_one_name_are_told_apart_by_numbers() -> None:
    names = _given_names((TrailingLeg(0.05), StraightReset(), TrailingLeg(0.07)))
    assert names == ["trailing leg (given, 1)", "straight (given)", "trailing leg (given, 2)"]
