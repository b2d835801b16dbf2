"""The measured cycle map, its wear, its pace, and what it foretells of its own path."""

import tracemalloc
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from made_sets import TURN, worn_pairs, worn_turn
from refusals import refused

from cyclemap.evidence.laws.fit_map import fit_map
from cyclemap.evidence.laws.measured_cycle_map import (
    MeasuredCycleMap,
    full_turns,
    measured_cycle_map,
    turn_pace,
)
from cyclemap.evidence.laws.turn_bins import is_covered, turn_bins
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs, read_theta0_pairs

pytestmark = pytest.mark.slow


def rotation(turns_a_push: float, count: int = 200):
    path, cycle = 0.3 + TURN * turns_a_push * np.arange(count + 1.0), np.arange(float(count))
    return path, fit_map(path[:-1], path[1:], cycle=cycle, harmonics=0, wear_degree=0)


@pytest.mark.parametrize("pace", [0.05, -0.05])
def test_a_rotation_takes_its_twenty_pushes_a_turn_measured_and_predicted(pace) -> None:
    path, fitted = rotation(pace)
    found = turn_pace(fitted, path, np.arange(201.0), level=1.0, runs=3)
    assert found.measured.tolist() == [20.0] * 9
    assert found.predicted.tolist() == found.lower.tolist() == found.upper.tolist() == [20.0] * 9
    assert found.inside == 1.0 and np.all(np.diff(found.start) == 20.0)


def test_jitter_about_the_mark_makes_no_turn_and_a_path_that_goes_nowhere_has_none() -> None:
    still, fitted = rotation(0.001, 60)
    found = turn_pace(fitted, still, np.arange(61.0), level=2.0, runs=3)
    assert found.measured.size == found.predicted.size == 0 and np.isnan(found.inside)
    jitter = 1.0 + 0.1 * np.cos(np.arange(50.0))
    path = np.concatenate([np.linspace(0.0, 1.0, 20), jitter, np.linspace(1.0, 9.0, 80)])
    assert full_turns(path, level=1.0).size == 2


GRID = np.linspace(0.0, TURN, 90)


@pytest.fixture(scope="module")
def made() -> MeasuredCycleMap:
    return measured_cycle_map(worn_pairs(), runs=60)


def test_the_made_map_is_found_with_its_wear_its_scatter_and_its_bottleneck(made) -> None:
    worn = made.fitted.wear
    assert (worn.harmonics, worn.degree, made.wears) == (1, 1, True)
    assert worn.whole.sigma == pytest.approx(0.02, rel=0.1)
    for state in (made.early, made.late):
        assert not state.fixed_points
        (passage,) = state.passages
        assert [passage.theta, state.slowest.theta] == pytest.approx([np.pi] * 2, abs=0.05)
        assert passage.lower < worn_turn(np.pi, state.cycle) < passage.upper
        assert passage.upper - passage.lower < 0.02
    assert (made.early.cycle, made.late.cycle) == pytest.approx((112.375, 786.625))


def test_the_made_path_turns_and_crowds_as_its_map_foretells(made) -> None:
    forecast = made.forecast
    assert forecast.first_cycle == 225.0
    low, high = np.quantile(forecast.turns, [0.005, 0.995])
    assert low - 0.5 <= forecast.measured_turns <= high + 0.5
    assert forecast.left_out_turns == pytest.approx(0.0, abs=1e-9)
    assert forecast.wasserstein < np.max(forecast.run_distances)
    peak = np.argmax(forecast.histogram.density)
    assert abs(np.rad2deg(forecast.histogram.edges[peak]) - 180.0) < 20.0
    assert forecast.run.shape == forecast.measured.shape == forecast.lower.shape == (901,)
    held = (forecast.lower <= forecast.measured) & (forecast.measured <= forecast.upper)
    assert np.mean(held) > 0.5 and forecast.pace.inside > 0.75


def test_without_wear_early_and_late_are_one_map() -> None:
    shares: list[float] = []
    found = measured_cycle_map(worn_pairs(400), wear=False, runs=5, progress=shares.append)
    assert shares == sorted(shares) and shares[-1] == 1.0
    assert not found.wears and found.fitted.wear.degree == 0
    first, last = (found.fitted.map_at(cycle).turn(GRID) for cycle in (0.0, 399.0))
    assert np.array_equal(first, last)
    assert found.early.slowest == found.late.slowest and found.forecast is not None


def test_pairs_in_no_order_have_a_map_and_no_forecast() -> None:
    pairs = worn_pairs(200)
    found = measured_cycle_map(Theta0Pairs(pairs.theta, pairs.theta_next), harmonics=1)
    assert (found.forecast, found.fitted.wear, found.wears) == (None, None, False)
    assert np.isnan(found.early.cycle)
    assert found.early.slowest.theta == pytest.approx(np.pi, abs=0.1)


def test_cycles_left_out_of_the_fit_are_told_in_turns() -> None:
    pairs = worn_pairs(400)
    path, kept = pairs.path.copy(), np.arange(400) != 300
    path[301:] += TURN / 3
    theta, ahead = path[:-1][kept], path[1:][kept]
    cut = Theta0Pairs(theta, ahead, path, {"jump": 1}, pairs.cycle[kept], pairs.path_cycle)
    found = measured_cycle_map(cut, harmonics=1, runs=5)
    own = (pairs.path[301] - pairs.path[300]) / TURN
    assert found.forecast.left_out_turns == pytest.approx(1 / 3 + own, abs=1e-9)


@pytest.mark.parametrize("count", [25, 99])
def test_no_wear_is_told_of_short_runs(count) -> None:
    """The map of these cycles wears by 0.6° in 100 cycles: fewer say nothing of it."""
    found = measured_cycle_map(worn_pairs(count), runs=2)
    assert not found.wears and found.fitted.wear.degree == 0


def steady_pairs(
    low: float, high: float, seed: int, least: float = 0.02, count: int = 120
) -> Theta0Pairs:
    """Pairs in no order from an arc, of a map that turns least, by ``least`` (rad), at 180°."""
    rng = np.random.default_rng(seed)
    theta = rng.uniform(low, high, count)
    turn = least + 0.25 * (1.0 + np.cos(theta)) + 0.02 * rng.standard_normal(count)
    return Theta0Pairs(theta, theta + turn)


def test_nothing_is_told_of_orientations_that_were_not_measured() -> None:
    """90° of the circle: every place told lies there, whatever the fitted series does elsewhere."""
    low, high = np.radians([230.0, 320.0])
    for seed in range(4):
        found = measured_cycle_map(steady_pairs(low, high, seed), harmonics=2)
        assert (found.late.fixed_points, found.late.undecided) == ((), ())
        places = (*found.late.passages, found.late.slowest, found.quietest, found.loudest)
        assert all(low - 0.02 <= place.theta <= high + 0.02 for place in places)
        assert is_covered(found.pairs.theta, [found.late.slowest.theta]).all()


@pytest.mark.parametrize(("harmonics", "reach"), [(1, 0.8), (None, 1.3)])
def test_the_interval_of_the_least_turn_holds_the_true_turn(harmonics, reach) -> None:
    held = []
    for seed in range(15):
        pairs = steady_pairs(np.pi - reach, np.pi + reach, seed)
        slowest = measured_cycle_map(pairs, harmonics=harmonics).late.slowest
        held.append(slowest.lower <= 0.02 + 0.25 * (1.0 + np.cos(slowest.theta)) <= slowest.upper)
    assert np.mean(held) >= 0.9


@pytest.mark.parametrize(
    ("least", "expected"), [(-0.05, (2, 0, 0)), (0.0, (0, 1, 0)), (0.05, (0, 0, 1))]
)
def test_fixed_points_what_is_undecided_and_bottlenecks_are_told_apart(least, expected) -> None:
    """Scatter of 0.02 rad and 120 pairs tell a least turn of 0.05 rad, either way, not one of 0."""
    told = []
    for seed in range(6):
        state = measured_cycle_map(steady_pairs(0.0, TURN, seed, least), harmonics=1).late
        told.append((len(state.fixed_points), len(state.undecided), len(state.passages)))
        assert all(one.lower <= 0.0 <= one.upper for one in state.undecided)
    assert told.count(expected) >= 5


def test_paths_that_leave_the_measured_orientations_foretell_nothing() -> None:
    """Forty steps of a random walk: other walks go where this one has not been."""
    path, number = np.cumsum(0.1 * np.random.default_rng(0).standard_normal(41)), np.arange(41.0)
    walk = Theta0Pairs(path[:-1], path[1:], path, cycle=number[:-1], path_cycle=number)
    assert measured_cycle_map(walk, harmonics=0, runs=20).forecast is None


def test_too_few_pairs_are_refused_by_number() -> None:
    pairs = worn_pairs(12)
    refused(measured_cycle_map, pairs, told="12 pairs are too few for a cycle map; give at least")


def test_where_there_is_wear_its_degree_is_that_of_least_error_in_cycles_left_out() -> None:
    """Not the one that the cautious rule takes, which depends on how the folds are dealt."""

    def bent(theta, cycle):
        return worn_turn(theta, 10 * cycle) + 0.03 * (cycle / 100 - 1.0) ** 2

    bolder = 0
    for seed in (0, 1, 2, 7):
        pairs = worn_pairs(200, 0.05, seed, bent)
        options = {"cycle": pairs.cycle, "harmonics": 1, "noise_harmonics": None}
        cautious = fit_map(pairs.theta, pairs.theta_next, **options).wear
        best = int(np.argmin(cautious.rmse_by_order))
        found = measured_cycle_map(pairs, harmonics=1, runs=2).fitted.wear
        assert found.degree == best
        bolder += best > cautious.degree
    assert bolder >= 2


@cache
def plywood(folder: Path) -> MeasuredCycleMap:
    return measured_cycle_map(read_theta0_pairs(folder / "plywood_rect1_theta0_2000.csv"), runs=100)


def test_the_plywood_law_is_fitted_to_within_its_noise(measured_data) -> None:
    """Residuals in units of the fitted scatter have size 1, and their medians over 5° bins stay
    within one of it.
    """
    found = plywood(measured_data)
    pairs, worn = found.pairs, found.fitted.wear
    assert (pairs.theta.size, pairs.path.size, worn.degree) == (1996, 2000, 2)
    cycles = zip(pairs.cycle, pairs.theta, strict=True)
    law = np.array([float(worn.at(cycle)(theta)) for cycle, theta in cycles])
    scatter = worn.whole.noise(pairs.theta)
    assert np.sqrt(np.mean(((pairs.turn - law) / scatter) ** 2)) == pytest.approx(1.0, abs=0.05)
    late = pairs.cycle >= 500
    residual = Theta0Pairs(pairs.theta[late], pairs.theta[late] + (pairs.turn - law)[late])
    bins = turn_bins(residual)
    assert bins.centre.size >= 60
    assert np.mean(np.abs(bins.median) <= worn.whole.noise(bins.centre)) >= 0.95
    assert np.rad2deg(np.sqrt(np.mean(bins.median**2))) < 1.0


def test_the_drifting_plywood_map_makes_the_measured_turns_steps_and_peak(measured_data) -> None:
    """17.48 turns of pushes 500 to 2000, 0.23 of them by two jumps that no map explains; without
    wear 20 and more.
    """
    forecast = plywood(measured_data).forecast
    pace, explained = forecast.pace, forecast.measured_turns - forecast.left_out_turns
    assert (forecast.first_cycle, pace.measured.size) == (500.0, 17)
    assert (forecast.measured_turns, forecast.left_out_turns) == pytest.approx(
        (17.48, 0.2276), abs=5e-3
    )
    assert np.mean(forecast.turns) == pytest.approx(16.4, abs=0.3)
    assert abs(explained - np.mean(forecast.turns)) < 1.5 * np.std(forecast.turns) < 1.7
    assert pace.measured[[0, -1]] == pytest.approx([257.0, 45.0], abs=2.0)
    for turn in (0, -1):
        assert pace.lower[turn] <= pace.measured[turn] <= pace.upper[turn]
    # The two turns about the jump at push 1391, and two beside it, lie outside.
    assert pace.inside >= 0.7
    assert np.median(pace.predicted / pace.measured) == pytest.approx(1.0, abs=0.1)
    for histogram in (forecast.measured_histogram, forecast.histogram):
        peak = int(np.argmax(histogram.density))
        assert np.all(np.abs(np.rad2deg(histogram.edges[peak : peak + 2]) - 95.0) <= 5.0 + 1e-9)
    assert forecast.wasserstein < min(np.radians(4.0), np.quantile(forecast.run_distances, 0.99))
    assert forecast.total_variation < 0.1


def test_the_plywood_bottleneck_near_95_degrees_opens_tenfold(measured_data) -> None:
    found = plywood(measured_data)
    for state in (found.early, found.late):
        assert not state.fixed_points
        assert np.rad2deg(state.slowest.theta) == pytest.approx(95.5, abs=4.0)
    assert found.late.slowest.turn > 5.0 * found.early.slowest.turn > 0.0
    assert np.rad2deg(found.quietest.scatter) < 0.5 < 2.0 < np.rad2deg(found.loudest.scatter)


def test_a_long_log_is_fitted_in_memory_that_grows_with_its_pairs_alone() -> None:
    theta = np.cumsum(np.full(30_001, 1.9))
    pairs = Theta0Pairs(theta[:-1], theta[1:])
    tracemalloc.start()
    measured_cycle_map(pairs, harmonics=2, wear=False, runs=2)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 500 * pairs.theta.nbytes


def resting_pairs(pull: float, scatter: float, count: int, seed: int) -> tuple[Theta0Pairs, float]:
    """A path that is drawn to one angle, from up to half a radian beside it; and that angle."""
    rng = np.random.default_rng(seed)
    rest = rng.uniform(0.0, TURN)
    path = [rest + rng.uniform(-0.5, 0.5)]
    for kick in scatter * rng.standard_normal(count):
        path.append(path[-1] - pull * np.sin(path[-1] - rest) + kick)
    theta = np.array(path)
    return Theta0Pairs(theta[:-1], theta[1:], path=theta), rest


@pytest.mark.parametrize(("pull", "scatter"), [(0.1, 0.03), (0.3, 0.01), (0.6, 0.1)])
def test_of_a_loop_that_rests_every_interval_holds_the_true_turn(pull, scatter) -> None:
    """The order that predicts best may leave out the pull itself: the interval knows."""
    held = []
    for seed in range(8):
        pairs, rest = resting_pairs(pull, scatter, 60, seed)
        state = measured_cycle_map(pairs, wear=False, runs=2).late
        for place in (*state.passages, *state.undecided, state.slowest):
            held.append(place.lower <= -pull * np.sin(place.theta - rest) <= place.upper)
    assert np.mean(held) >= 0.95


def test_a_loop_that_came_to_rest_is_told_to_rest_there_with_its_own_scatter() -> None:
    """Where it came from, no fold can be judged that leaves it out: it must not choose the law."""
    for seed in range(6):
        pairs, rest = resting_pairs(0.6, 0.01, 150, seed)
        found = measured_cycle_map(pairs, wear=False, runs=2)
        (orbit,) = found.late.fixed_points
        assert orbit.kind == "stable" and abs(np.sin(orbit.points[0] - rest)) < 0.005
        assert found.fitted.sigma == pytest.approx(0.01, rel=0.25)
