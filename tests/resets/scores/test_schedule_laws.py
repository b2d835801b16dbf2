"""Laws under schedules by second routes: products of operators, rational steps, blocks of one, rotations."""

from dataclasses import dataclass

import numpy as np
import pytest
from made_strategies import PUSH, SIDES, STRATEGIES, THREE, made_maps, rigid_drift

from cyclemap.maps import UniformNoise, WrappedNormal
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.independent_sum import IndependentSum
from cyclemap.maps.mixtures.periodic_schedule import PeriodicSchedule
from cyclemap.resets.scores.effective_size import effective_size
from cyclemap.resets.scores.reset_scores import reset_scores
from cyclemap.resets.scores.strategy_operators import action_operators
from cyclemap.resets.scores.strategy_scores import strategy_scores
from cyclemap.resets.strategies.drag_strategies import GripperTurn, StraightReset, TrailingLeg
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes
from cyclemap.resets.strategies.schedules import SEQUENCE, GoldenAngle, Independent, LatinBlocks
from cyclemap.resets.strategies.spread import Spread

NOISE = WrappedNormal(0.12)


def test_alternating_between_a_push_and_itself_is_that_push_alone():
    """The periodic route against the independent one: law, curve, mixing, reach, effective size, all of one chain."""
    noise = WrappedNormal(0.4)
    alone = strategy_scores(made_maps(StraightReset()), noise, starts=64, tv=0.1, pushes=12)
    twice = strategy_scores(made_maps(AlternatingPushes((PUSH, PUSH))), noise, starts=64, tv=0.1, pushes=12)
    assert (alone.kind, twice.kind) == ("independent", "periodic")
    assert np.max(np.abs(alone.law.moments - twice.law.moments)) < 1e-8
    np.testing.assert_allclose(alone.curve.total_variation, twice.curve.total_variation, atol=1e-6)
    np.testing.assert_allclose(alone.curve.wasserstein, twice.curve.wasserstein, atol=1e-5)
    assert abs(alone.spectral_gap - twice.spectral_gap) < 1e-9
    assert alone.mixing_cycles.cycles == twice.mixing_cycles.cycles > 1
    limit = 0.05 + float(alone.total_variation)
    assert alone.within(limit).cycles == twice.within(limit).cycles > 1
    exactly = effective_size(alone.independent.operator, pushes=100, bounded=False).of(100)
    assert abs(twice.effective_size_per_100 / exactly - 1.0) < 1e-6


def test_a_periodic_schedule_has_the_laws_of_the_product_of_its_operators():
    maps = made_maps(AlternatingPushes(THREE))
    scores, other = strategy_scores(maps, NOISE, pushes=9), PeriodicSchedule(action_operators(maps, NOISE, 64))
    assert np.max(np.abs(scores.law.moments - other.recorded_law().moments)) < 1e-8
    phases = scores.schedule.phase_laws()
    assert len(phases) == 3 and phases[0].total_variation(phases[1]) > 0.1
    for phase, law in zip(phases, other.laws(), strict=True):
        assert np.max(np.abs(phase.moments - law.moments)) < 1e-8
    np.testing.assert_allclose(scores.curve.total_variation, other.worst(9, None, 64).total_variation, atol=1e-5)
    assert scores.spectral_gap == other.spectral_gap
    bounded = strategy_scores(maps, NOISE, bounded=True)
    assert bounded.law.error_bound < 1e-6 and abs(bounded.total_variation - scores.total_variation) < 1e-6


@pytest.mark.parametrize("size", [2, 4])
def test_blocks_have_the_laws_of_all_orders_of_their_operators(size):
    """Against the mean of all products of operators, another code: laws of a long run, and from the worst start."""
    maps = made_maps(TrailingLeg(0.1, schedule=LatinBlocks(size, jitter=False)))
    scores = strategy_scores(maps, NOISE, pushes=2 * size + 1)
    other = PeriodicSchedule(action_operators(maps, NOISE, 64), shuffled=True)
    assert np.max(np.abs(scores.law.moments - other.recorded_law().moments)) < 1e-6
    worst = other.worst(2 * size + 1, None, 64)
    np.testing.assert_allclose(scores.curve.total_variation, worst.total_variation, atol=2e-5)
    np.testing.assert_allclose(scores.curve.wasserstein, worst.wasserstein, atol=1e-4)


def test_blocks_of_one_are_no_schedule_at_all():
    """Of a middle: the fixed leg there. With jitter: the leg drawn anew, but for the nodes of the two quadratures."""
    middle = strategy_scores(made_maps(TrailingLeg(0.1, schedule=LatinBlocks(1, jitter=False))), NOISE)
    fixed = strategy_scores(made_maps(TrailingLeg(0.1, np.pi)), NOISE)
    assert middle.kind == "blocks" and fixed.kind == "independent"
    assert np.max(np.abs(middle.law.moments - fixed.law.moments)) < 1e-6
    narrow = Spread.within(1.0, 0.3)
    jittered = strategy_scores(made_maps(TrailingLeg(0.1, narrow, LatinBlocks(1))), NOISE)
    anew = strategy_scores(made_maps(TrailingLeg(0.1, narrow)), NOISE)
    assert np.max(np.abs(jittered.law.moments - anew.law.moments)) < 1e-4


@dataclass(frozen=True)
class RationalStep:
    """A schedule of one's own: i -> (start + i p/q) mod 1 on the middles of q sectors, from a random one."""

    step: int = 2
    sectors: int = 5
    kind = SEQUENCE

    def draws(self, cycles, dimensions, seed):
        start = np.random.default_rng(seed).integers(self.sectors)
        place = (start + self.step * np.arange(cycles)) % self.sectors
        return np.repeat((place[:, None] + 0.5) / self.sectors, dimensions, axis=1)


def test_a_rational_rotation_of_directions_is_the_periodic_schedule():
    """Its long run is that of the five operators in the order 0, 2, 4, 1, 3; the run may begin at any of them."""
    maps = made_maps(TrailingLeg(0.1, schedule=RationalStep()))
    scores = strategy_scores(maps, NOISE, followed=100)
    operators = action_operators(maps, NOISE, 64)
    law = PeriodicSchedule([operators[i] for i in (0, 2, 4, 1, 3)]).recorded_law()
    assert scores.kind == "sequence" and scores.schedule.chain.orders.shape[0] == 5
    assert scores.law.total_variation(law) < 2e-3 < 0.05 < law.total_variation()
    # Another order of the same five is another schedule.
    assert law.total_variation(PeriodicSchedule(operators).recorded_law()) > 0.01


def test_the_golden_angle_is_the_limit_of_its_fractions():
    """Periodic schedules of q = 21, 55 turns in the golden angle's order come near, the second nearer."""
    golden = strategy_scores(made_maps(TrailingLeg(0.1, schedule=GoldenAngle())), NOISE)
    apart = []
    for step, turns in ((13, 21), (34, 55)):
        made = made_maps(TrailingLeg(0.1, schedule=RationalStep(step, turns)))
        operators = action_operators(made, NOISE, 40)
        order = [operators[i * step % turns] for i in range(turns)]
        apart.append(golden.law.total_variation(PeriodicSchedule(order).recorded_law()))
    assert apart[0] < 5e-3 and apart[1] < min(2e-3, apart[0])


def test_blocks_of_gripper_turns_on_rotations_return_after_every_block():
    """Turns of 45, 135, 225, 315 degrees add up to two turns: after each block all that is left is noise."""
    scores = strategy_scores(
        made_maps(GripperTurn(schedule=LatinBlocks(4, jitter=False)), drift=rigid_drift), NOISE, pushes=8
    )
    for block in (1, 2):
        left = FourierLaw(np.exp(-0.5 * (np.arange(60) * 0.12) ** 2 * 4 * block))
        expected = left.total_variation()
        assert abs(scores.curve.total_variation[4 * block - 1] - expected) < 1e-4
    assert scores.total_variation < 1e-8 and scores.mixing_cycles.cycles > 50
    # In between the turns of an unfinished block are random: nearer to uniform than at its end.
    assert scores.curve.total_variation[1] < scores.curve.total_variation[3]


@pytest.mark.parametrize("pushes", [6, 8, 10])
def test_mixing_is_not_told_from_the_middle_of_a_block_which_parts_the_laws_again(pushes):
    """The same rotations: wherever the curve ends, mixed is after the last block whose noise leaves more than 0.45."""
    maps = made_maps(GripperTurn(schedule=LatinBlocks(4, jitter=False)), drift=rigid_drift)
    found = strategy_scores(maps, NOISE, pushes=pushes, tv=0.45).mixing_cycles.cycles
    left = [FourierLaw(np.exp(-2.0 * k * (np.arange(60) * 0.12) ** 2)).total_variation() for k in range(1, 30)]
    last = 1 + max(k for k, variation in enumerate(left) if variation > 0.45)
    assert found in (4 * last + 1, np.inf) and (found < np.inf) == (8 * pushes >= 4 * last)


def test_rotations_are_even_whatever_the_schedule_and_mix_by_their_noise_alone():
    """|λ₂| = κ₁ = exp(-σ²/2) a push; a golden gripper turn is uniform after one push, over its random beginning."""
    turning = strategy_scores(made_maps(AlternatingPushes(SIDES), drift=rigid_drift), NOISE)
    assert turning.total_variation < 1e-8
    assert abs(turning.spectral_gap - (1.0 - np.exp(-0.5 * 0.12**2))) < 1e-9
    golden = strategy_scores(made_maps(STRATEGIES["golden gripper turn"], drift=rigid_drift), NOISE, pushes=3)
    assert golden.total_variation < 1e-2 and np.all(golden.curve.total_variation[:1] < 1e-6)


def test_an_independent_gripper_turn_is_noise_exactly():
    """Uniform on a part of a turn: the law of one map with that noise more, turned by the middle; not of few nodes."""
    maps = made_maps(GripperTurn(Spread.within(0.3, 0.4)))
    spread = IndependentSum((NOISE, UniformNoise(0.4)))
    raised = made_maps(GripperTurn(0.3)).maps
    scores, other = strategy_scores(maps, NOISE, bounded=True), reset_scores(raised, spread)
    assert np.max(np.abs(scores.law.moments - other.law.moments)) < 1e-12
    assert scores.independent.operator.modes == other.operator.modes


def test_schedules_of_the_same_law_are_not_interchangeable():
    kept = {
        schedule: strategy_scores(made_maps(DrawnPushes(SIDES, made)), NOISE).total_variation
        for schedule, made in (("anew", Independent()), ("blocks", LatinBlocks(2, jitter=False)))
    }
    kept["in turn"] = strategy_scores(made_maps(AlternatingPushes(SIDES)), NOISE).total_variation
    values = sorted(kept.values())
    assert min(np.diff(values)) > 2e-3, kept
