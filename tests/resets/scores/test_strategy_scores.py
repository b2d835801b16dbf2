"""Scores of every kind of strategy: against a hundred thousand sampled pushes, second routes, and bad input."""

import json
from dataclasses import dataclass

import numpy as np
import pytest
from made_strategies import PUSH, SIDES, STRATEGIES, made_maps
from score_agreement import linear_scores, table_of

from cyclemap.errors import InvalidInput
from cyclemap.maps import UniformNoise, WrappedNormal
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.resets.scores.reset_scores import reset_scores
from cyclemap.resets.scores.strategy_sampler import law_starts, run_seed, strategy_sampler
from cyclemap.resets.scores.strategy_scores import strategy_scores
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.drag_strategies import StraightReset
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes
from cyclemap.resets.strategies.strategy import ActionLaw
from cyclemap.resets.strategies.strategy_sampling import sample_strategy

NOISE = WrappedNormal(0.12)
RUNS, PUSHES, SKIPPED = 500, 250, 50  # of the samples: 10⁵ pushes that count, in independent collections


def far(values, truth, allowed=0.0):
    """By how many standard errors the mean of independent values misses the truth by more than ``allowed``."""
    spread = float(np.std(values, ddof=1)) / np.sqrt(len(values)) + 1e-12
    return max(0.0, abs(float(np.mean(values)) - float(truth)) - float(allowed)) / spread


@pytest.mark.parametrize("name", STRATEGIES)
def test_predicted_scores_agree_with_1e5_sampled_pushes(name):
    """TV, W1 and the means of cos θ, sin θ, cos 2θ, sin 2θ, each as a mean over 500 independent collections.

    What the prediction says of its own error, by runs of its own, is allowed besides; 4.5 standard errors in all.
    """
    maps = made_maps(STRATEGIES[name])
    scores = strategy_scores(maps, NOISE, modes=40)
    law, even, stated = scores.law, scores.evenness, scores.independent is None
    theta = strategy_sampler(maps, NOISE, law)(RUNS, PUSHES, 5)[:, SKIPPED:]
    assert theta.size == 100_000
    variation, potential = (np.mean(table_of(part, theta), axis=1) for part in linear_scores(law))
    allowed = [part.error_bound if stated else 0.0 for part in (even.total_variation, even.wasserstein)]
    found = [
        far(variation, even.total_variation, allowed[0] + 1e-9),
        far(potential, even.wasserstein, allowed[1] + 1e-9),
    ]
    for order in (1, 2):
        waves = np.mean(np.exp(1j * order * theta), axis=1)
        # A mean of a wave differs between two laws by at most twice their total variation.
        found += [far(waves.real, law.moments[order].real, 2 * allowed[0])]
        found += [far(waves.imag, law.moments[order].imag, 2 * allowed[0])]
    assert len(found) == 6 and max(found) < 4.5, found
    assert even.total_variation.error_bound < 0.03 or not stated


@pytest.mark.parametrize("name", ["golden leg", "leg in blocks", "pushes in blocks", "alternating pushes"])
def test_the_law_after_n_pushes_from_the_worst_start_is_that_of_sampled_collections(name):
    """At n = 3 and 5 pushes, in 2,000 collections from that start, each with its own beginning of the schedule."""
    maps = made_maps(STRATEGIES[name], nodes=8)
    scores = strategy_scores(maps, NOISE, modes=40, pushes=5)
    laws = scores.schedule._laws_after(5)
    for n in (3, 5):
        start = float(scores.curve.start[n - 1])
        column = laws[n - 1][0][:, int(np.argmin(np.abs(scores.schedule.grid.angles - start)))]
        law = FourierLaw(np.append(1.0, column[1:41] + 1j * column[41:]))
        assert abs(law.total_variation() - scores.curve.total_variation[n - 1]) < 2e-3
        theta = strategy_sampler(maps, NOISE, start)(2000, n + 1, n)[:, n]
        variation, potential = (table_of(part, theta) for part in linear_scores(law))
        assert far(variation, law.total_variation()) < 4.5
        assert far(potential, law.wasserstein()) < 4.5


@pytest.mark.parametrize("name", ["leg in blocks", "golden pushes", "alternating pushes"])
def test_the_effective_size_is_that_of_the_means_of_sampled_collections(name):
    """The worst mean among combinations of cos θ, sin θ, cos 2θ, sin 2θ over 100 pushes, 2,500 times: to 12 %."""
    maps = made_maps(STRATEGIES[name], nodes=8)
    scores = strategy_scores(maps, NOISE, modes=40)
    theta = strategy_sampler(maps, NOISE, scores.law)(2500, 100, 6)
    waves = np.stack([wave(k * theta) for k in (1, 2) for wave in (np.cos, np.sin)])
    single = np.cov(waves.reshape(4, -1))
    worst = np.max(np.linalg.eigvals(np.linalg.solve(single, np.cov(waves.mean(axis=2)))).real)
    assert abs(1.0 / worst / scores.effective_size_per_100 - 1.0) < 0.12
    # Not what as many independent pushes are worth.
    assert abs(scores.effective_size_per_100 / 100.0 - 1.0) > 0.15


# -- together ------------------------------------------------------------------------------------------------------


def test_reach_is_read_off_the_curve_and_is_never_where_the_long_run_is_too_uneven():
    scores = strategy_scores(made_maps(STRATEGIES["leg in blocks"]), NOISE, pushes=30)
    limit = 1.5 * float(scores.total_variation)
    found, curve = int(scores.within(limit).cycles), scores.curve.total_variation
    assert np.all(curve[found - 1 :] <= limit) and (found == 1 or curve[found - 2] > limit)
    assert scores.within(0.5 * float(scores.total_variation)).cycles == np.inf
    target = strategy_scores(made_maps(STRATEGIES["leg in blocks"]), NOISE, target=scores.law)
    assert target.total_variation < 1e-8 and target.within(0.2).cycles < np.inf


def test_reach_is_to_within_twice_the_variation_that_counts_as_near():
    for strategy in (DrawnPushes(SIDES), AlternatingPushes(SIDES)):
        scores = strategy_scores(made_maps(strategy), NOISE, modes=40, tv=0.2)
        assert scores.reach_cycles.cycles == scores.within(0.4).cycles < scores.within(0.3).cycles


@pytest.mark.parametrize("name", ["drawn pushes", "alternating pushes", "leg in blocks of middles", "golden pushes"])
def test_summaries_of_all_kinds_have_the_keys_of_reset_scores(name):
    maps = made_maps(STRATEGIES[name])
    scores = strategy_scores(maps, NOISE, modes=30, pushes=10, runs=60)
    found = json.loads(json.dumps(scores.summary(), allow_nan=False))
    plain = reset_scores(maps.maps, NOISE, maps.weights, modes=20, bounded=False, pushes=4, runs=2).summary()
    independent = found["kind"] == "independent"
    assert set(plain) - set(found) == (set() if independent else {"sector_share_worst_start"})
    assert (
        (found["spectral_gap"] is None) == (found["kind"] in ("blocks", "sequence")) == ("spectral_gap" in why(found))
    )
    assert found["certified"] is False and 0.0 < found["tv_from_target"] < 1.0 and 0.0 < found["sector_share"] <= 1.0
    assert found["effective_size_per_100"] > 0.0 and found["near_tv"] == 0.05
    assert set(scores.summary(coverage=False)) < set(found)


def why(summary):
    return summary["undefined"]


def test_many_sampled_collections_are_those_of_sample_strategy():
    """Path by path, to rounding, from the same seeds: independent, blocks, and a gripper beside pushes in turn."""
    for name in ("pushes and legs", "leg in blocks", "pushes in turn and a golden gripper"):
        maps = made_maps(STRATEGIES[name], nodes=6)
        paths = strategy_sampler(maps, NOISE, 0.7)(3, 30, 9)
        for run, path in enumerate(paths):
            one = sample_strategy(maps, 29, start=0.7, noise=NOISE, seed=run_seed(9, run))
            np.testing.assert_allclose(path, one.theta, atol=1e-8)


def test_drawn_starts_follow_their_law():
    law = FourierLaw(np.array([1.0, 0.3 + 0.1j]))
    starts = law_starts(law, 20_000, np.random.default_rng(1))
    assert abs(np.mean(np.exp(1j * starts)) - law.moments[1]) < 4 / np.sqrt(20_000)


def test_bad_input_is_refused():
    maps = made_maps(StraightReset())
    with pytest.raises(InvalidInput, match="make them with strategy_maps"):
        strategy_scores(maps.maps, NOISE)
    with pytest.raises(InvalidInput, match="scores need some"):
        strategy_scores(maps, None)
    with pytest.raises(InvalidInput, match=r"tv is 0"):
        strategy_scores(maps, NOISE, tv=0.0)
    with pytest.raises(InvalidInput, match="pushes must be at least 1"):
        strategy_scores(maps, NOISE, pushes=0)
    with pytest.raises(InvalidInput, match="modes must be at least 2"):
        strategy_scores(maps, NOISE, modes=1)
    with pytest.raises(InvalidInput, match="starts must be at least 8"):
        strategy_scores(maps, NOISE, starts=3)
    with pytest.raises(InvalidInput, match="narrow smooth noise"):
        strategy_scores(maps, UniformNoise(0.3)).total_variation  # noqa: B018


@dataclass(frozen=True)
class Own:
    """A strategy that says its law and its actions, but not what it draws."""

    kind: str
    name = "own"
    needs = ()

    def prepared(self, loop):
        return loop

    def actions(self, cycles, seed=0):
        return (CycleAction(push=PUSH),) * cycles

    def law(self, nodes=1):
        return ActionLaw(tuple(CycleAction(push=push) for push in SIDES), [0.5, 0.5], self.kind)


def test_a_strategy_that_does_not_say_what_it_draws_is_scored_where_its_law_is_enough():
    drawn = strategy_scores(made_maps(DrawnPushes(SIDES)), NOISE)
    own = strategy_scores(made_maps(Own("independent")), NOISE)
    assert own.total_variation == drawn.total_variation
    turn = strategy_scores(made_maps(Own("periodic")), NOISE)
    assert (
        abs(turn.total_variation - strategy_scores(made_maps(AlternatingPushes(SIDES)), NOISE).total_variation) < 1e-12
    )
    assert 0.5 < turn.coverage.sector_share.mean <= 1.0
    with pytest.raises(InvalidInput, match="own does not say what it draws"):
        strategy_scores(made_maps(Own("blocks")), NOISE).total_variation  # noqa: B018
    with pytest.raises(InvalidInput, match="own does not say what it draws"):
        strategy_sampler(made_maps(Own("periodic")), NOISE)
