"""All scores of a reset together: against simulated pushes, symmetries, what is not certified says so."""

import json

import numpy as np
import pytest
from score_agreement import agreement, agreement_from_start

from cyclemap.collection import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, UniformNoise, WrappedCauchy, WrappedNormal, conjugate, transfer_operator
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.independent_sum import IndependentSum
from cyclemap.resets.scores.coverage_measures import independent_sector_share
from cyclemap.resets.scores.reset_scores import ResetScores, reset_scores

TWO_PI = 2 * np.pi


def sticking():
    """A sampled map like a robot's: two slow zones, one of which it barely passes, and kinks of the interpolant."""
    theta = np.linspace(0, TWO_PI, 120, endpoint=False)
    turn = 0.22 - 0.16 * np.cos(2 * theta - 3.3) - 0.05 * np.cos(theta - 1.6)
    slope = 1 + 0.32 * np.sin(2 * theta - 3.3) + 0.05 * np.sin(theta - 1.6)
    return CircleMap.from_samples(theta, theta + turn, slope)


CASES = {
    "one map": [sticking()],
    "four directions": [conjugate(sticking(), k * np.pi / 2) for k in range(4)],
    "folded and not": [CircleMap.arnold(0.3, 3.0), CircleMap.arnold(0.1, 0.9)],
}


@pytest.mark.parametrize("name", CASES)
def test_predictions_agree_with_simulated_pushes_within_sampling_error(name):
    """TV, W1, means, variances of means and sectors of 200 collections; TV and W1 five cycles after the worst start."""
    scores = reset_scores(CASES[name], WrappedNormal(0.1), pushes=10, starts=64)
    found = agreement(scores, 200, 150)
    assert len(found) == 11
    start = float(scores.curve.start[4])
    found |= {f"start {key}": value for key, value in agreement_from_start(scores.operator, start, 5, 5000).items()}
    assert max(np.abs(list(found.values()))) < 4.0, found


def test_predictions_for_the_robots_own_map_agree_with_simulated_pushes():
    """Table I plywood, the cycle map to 1e-3 rad, pushed from two opposite directions by turns drawn by a coin."""
    plywood = CollectionLoop.mit("plywood").circle_map(1e-3)
    for maps in ([plywood], [plywood, conjugate(plywood, np.pi)]):
        scores = reset_scores(maps, WrappedNormal(np.radians(3.0)), pushes=20, modes=120)
        found = agreement(scores, 200, 150)
        assert len(found) == 11
        assert max(np.abs(list(found.values()))) < 4.0, found


def test_more_directions_are_more_even_and_worth_more():
    one, four = (reset_scores(CASES[name], WrappedNormal(0.1)) for name in ("one map", "four directions"))
    assert four.evenness.total_variation < 0.2 * one.evenness.total_variation
    assert four.evenness.wasserstein < 0.2 * one.evenness.wasserstein
    assert four.evenness.peak_to_mean < one.evenness.peak_to_mean
    assert four.visits.stationary[-1] > one.visits.stationary[-1]


def test_an_extra_uniform_turn_is_the_perfect_reset():
    scores = reset_scores(CASES["one map"], IndependentSum((WrappedNormal(0.1), UniformNoise(np.pi))), pushes=20)
    assert scores.evenness.total_variation < 1e-12
    assert scores.mixing_cycles.cycles == scores.reach_cycles.cycles == 1
    assert abs(scores.effective_size_per_100 - 100.0) < 1e-6
    assert scores.certified
    exact = [independent_sector_share(n, scores.sectors) for n in range(1, 21)]
    np.testing.assert_allclose(scores.visits.worst, exact, atol=1e-9)
    assert scores.coverage.largest_gap.agrees(TWO_PI / 20 * np.sum(1 / np.arange(1, 21)))


def test_scores_do_not_depend_on_where_angles_are_counted_from():
    maps = CASES["folded and not"]
    plain = reset_scores(maps, WrappedNormal(0.2), pushes=8)
    turned = reset_scores([conjugate(part, TWO_PI / 12 * 5) for part in maps], WrappedNormal(0.2), pushes=8)
    assert abs(plain.evenness.wasserstein - turned.evenness.wasserstein) < 1e-6
    assert abs(plain.spectral_gap - turned.spectral_gap) < 1e-10
    assert abs(plain.effective_size.each[0] - turned.effective_size.each[0]) < 1e-10
    assert plain.mixing_cycles == turned.mixing_cycles
    np.testing.assert_allclose(plain.visits.stationary, turned.visits.stationary, atol=1e-8)


def test_a_target_that_the_law_meets_is_reached_as_soon_as_it_mixes():
    operator = transfer_operator(CircleMap.arnold(0.3, 3.0), WrappedNormal(0.3))
    own = FourierLaw(np.array([operator.moment(n) for n in range(operator.modes + 1)]))
    scores = ResetScores(operator, target=own, pushes=5)
    assert scores.evenness.total_variation < 1e-9
    assert scores.within(0.05).cycles == scores.mixing_cycles.cycles
    assert ResetScores(operator, target=operator.density).evenness.total_variation < 1e-6
    assert ResetScores(operator).within(0.1 * operator.tv_from_uniform).cycles == np.inf


def test_the_summary_is_json_with_every_error_beside_its_number():
    scores = reset_scores([CircleMap.rigid(0.2)], WrappedNormal(0.5), pushes=6, runs=50)
    found = json.loads(json.dumps(scores.summary(), allow_nan=False))
    assert found["tv_from_target"] < 1e-14 and found["certified"] is True
    assert found["mixing_cycles_earliest"] <= found["mixing_cycles"] <= found["mixing_cycles_latest"]
    for name in ("tv_from_target", "wasserstein_deg", "peak_to_mean", "spectral_gap", "effective_size_per_100"):
        assert found[f"{name}_error"] >= 0.0
    assert abs(found["wasserstein_deg"]) < 1e-9
    assert all(type(value) in (float, int, bool, list, type(None)) for value in scores.summary().values())
    assert found["largest_gap_deg_standard_error"] > 0.0


def test_truncated_operators_are_not_certified():
    few = transfer_operator(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.2), modes=20)
    full = transfer_operator(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.2))
    scores, truth = ResetScores(few, pushes=3), ResetScores(full, pushes=3)
    assert not scores.certified and not scores.mixing_cycles.certified
    for found, exact in (
        (scores.evenness.total_variation, truth.evenness.total_variation),
        (scores.evenness.wasserstein, truth.evenness.wasserstein),
        (scores.effective_size.worst, truth.effective_size.worst),
    ):
        assert abs(found - exact) <= found.error_bound + exact.error_bound
        assert abs(found - exact) > 1e-7


def test_a_quick_look_without_bounds_gives_the_same_numbers_and_certifies_none():
    """A third of the modes and no bounds, as a search would use them: an even law has few harmonics."""
    maps, noise = CASES["four directions"], WrappedNormal(0.05)
    full = reset_scores(maps, noise, pushes=5, starts=64)
    quick = reset_scores(maps, noise, modes=full.operator.modes // 3, bounded=False, pushes=5, starts=64)
    assert abs(quick.evenness.total_variation - full.evenness.total_variation) < 1e-5
    assert abs(quick.effective_size_per_100 - full.effective_size_per_100) < 1e-3
    assert abs(quick.spectral_gap - full.spectral_gap) < 1e-6
    assert quick.within(0.2).latest == np.inf and quick.within(0.2).cycles == full.within(0.2).cycles
    assert quick.evenness.total_variation.error_bound == 1.0
    assert quick.effective_size_per_100.error_bound == np.inf
    assert not quick.certified and full.evenness.certified


def test_bad_input_is_refused():
    one = [CircleMap.rigid(0.2)]
    with pytest.raises(InvalidInput, match="one CircleMap or more"):
        reset_scores([], WrappedNormal(0.1))
    with pytest.raises(InvalidInput, match="2 entries for 1 maps"):
        reset_scores(one, WrappedNormal(0.1), [0.5, 0.5])
    with pytest.raises(InvalidInput, match="narrow smooth noise"):
        reset_scores(one, UniformNoise(0.3))
    with pytest.raises(InvalidInput, match=r"tv is 1\.5"):
        reset_scores(one, WrappedCauchy(0.5), tv=1.5)
    with pytest.raises(InvalidInput, match="pushes must be at least 1"):
        reset_scores(one, WrappedCauchy(0.5), pushes=0)
    with pytest.raises(InvalidInput, match="make it with transfer_operator"):
        ResetScores("operator")
