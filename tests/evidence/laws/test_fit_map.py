"""Maps fitted to pairs come near those that made them, worn or not, and so does their staircase."""

import math
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.evidence import Theta0Pairs, measured_staircase, read_theta0_pairs
from cyclemap.evidence.laws.fit_map import fit_map, fit_worn_law
from cyclemap.maps import (
    CircleMap,
    DriftingMap,
    WrappedNormal,
    predict_staircase,
    sample_staircase,
    sample_staircases,
)

TURN = 2 * np.pi
GRID = np.linspace(0.0, TURN, 90, endpoint=False)
STAIRCASE = "plywood_rect1_theta0_2000.csv"


def worn_turn(theta: np.ndarray, cycle: np.ndarray | float) -> np.ndarray:
    return (
        0.5
        + 0.3 * np.cos(theta)
        + 0.1 * np.sin(2 * theta)
        + 2e-4 * cycle * (1.0 + np.cos(theta - 1.0))
    )


def worn_pairs(
    seed: int, sigma: float, count: int = 1000
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A path under a map that wears linearly, every cycle from where the last one ended."""
    cycle, kicks = (
        np.arange(float(count)),
        sigma * np.random.default_rng(seed).standard_normal(count),
    )
    path = [0.0]
    for n in range(count):
        path.append(path[-1] + float(worn_turn(np.array(path[-1]), float(n))) + kicks[n])
    return np.array(path[:-1]), np.array(path[1:]), cycle


def test_a_map_without_noise_is_found_exactly_with_its_derivative() -> None:
    truth = CircleMap.arnold(0.05, 0.8)
    theta = np.random.default_rng(0).uniform(-9.0, 9.0, 200)
    fitted = fit_map(theta, truth(theta))
    assert fitted.law.harmonics == 1
    assert np.allclose(fitted.map(GRID), truth(GRID), atol=1e-13)
    assert np.allclose(fitted.map.derivative(GRID), truth.derivative(GRID), atol=1e-13)
    assert fitted.map.scalar()(2.5) == pytest.approx(float(truth(2.5)), abs=1e-13)


@pytest.mark.slow
def test_wear_without_noise_is_found_exactly_with_its_degree() -> None:
    theta, theta_next, cycle = worn_pairs(0, 0.0)
    fitted = fit_map(theta, theta_next, cycle=cycle)
    assert fitted.wear is not None and (fitted.wear.harmonics, fitted.wear.degree) == (2, 1)
    for n in (0.0, 400.0, 999.0):
        assert np.allclose(fitted.map_at(n).turn(GRID), worn_turn(GRID, n), atol=1e-10)
    assert np.allclose(fitted.map_at(5000.0).turn(GRID), worn_turn(GRID, 999.0), atol=1e-10)


@pytest.mark.slow
def test_wear_and_its_degree_are_recovered_under_noise_and_the_bands_cover() -> None:
    runs, degrees, covered = 50, [], []
    for seed in range(runs):
        theta, theta_next, cycle = worn_pairs(seed, 0.03)
        degrees.append(
            fit_worn_law(theta, theta_next - theta, cycle, max_harmonics=4, seed=seed).degree
        )
        law = fit_worn_law(theta, theta_next - theta, cycle, harmonics=2, degree=1)
        worn = [(law.at(n), worn_turn(GRID, n)) for n in (0.0, 600.0, 999.0)]
        covered.append(
            [np.abs(one(GRID) - truth) <= one.half_bands(GRID)[0] for one, truth in worn]
        )
        assert law.whole.sigma == pytest.approx(0.03, rel=0.1)
    assert degrees.count(1) >= 0.9 * runs
    assert np.mean(covered) == pytest.approx(0.95, abs=0.03)


@pytest.mark.slow
def test_a_map_that_does_not_wear_is_found_to_have_degree_nought() -> None:
    chosen = []
    for seed in range(20):
        path = sample_staircase(
            CircleMap.arnold(0.2, 0.5), WrappedNormal(0.03), 600, seed=seed
        ).theta
        worn = fit_map(path[:-1], path[1:], cycle=np.arange(600), max_harmonics=5).wear
        assert worn is not None
        chosen.append((worn.harmonics, worn.degree))
    assert chosen.count((1, 0)) >= 18


@pytest.mark.slow
def test_worn_paths_are_those_of_the_drifting_map() -> None:
    theta, theta_next, cycle = worn_pairs(1, 0.03)
    fitted = fit_map(theta, theta_next, cycle=cycle)
    assert fitted.wear is not None
    starts = np.zeros(400)
    own = fitted.paths(starts, 300, first=200, seed=1)
    blend = DriftingMap.of_family(fitted.map_at, lambda n: 200 + n, 300, 1e-4)
    other = sample_staircases(blend, WrappedNormal(fitted.wear.whole.sigma), 300, starts, seed=2)
    climbs = np.stack([own[:, -1], other[:, -1]])
    error = float(np.sqrt(np.sum(np.var(climbs, axis=1)) / 400))
    assert own.shape == (400, 301)
    assert abs(np.diff(np.mean(climbs, axis=1))[0]) < 4 * error


@pytest.mark.parametrize(
    ("change", "options", "match"),
    [
        (
            lambda theta, ahead, cycle: (theta, ahead[:-1]),
            {},
            "theta and theta_next have 100 and 99 entries",
        ),
        (
            lambda theta, ahead, cycle: (theta, np.append(np.nan, ahead[1:])),
            {},
            "finite, but entry 0 is nan",
        ),
        (
            lambda theta, ahead, cycle: (theta, ahead, cycle[1:]),
            {},
            "cycle has 99 entries for 100 pairs",
        ),
        (lambda theta, ahead, cycle: (theta, ahead, np.full(100, 3.0)), {}, "every cycle is 3"),
        (lambda *pairs: pairs, {"wear_degree": -1}, "degree must be at least 0"),
    ],
)
def test_bad_input_is_refused_by_name(change, options, match) -> None:
    theta, theta_next, *cycle = change(*worn_pairs(0, 0.02, 100))
    refused(fit_map, theta, theta_next, cycle=cycle[0] if cycle else None, told=match, **options)


def test_a_map_without_numbered_cycles_makes_no_worn_ones() -> None:
    theta, theta_next, cycle = worn_pairs(0, 0.02, 100)
    for asked in (lambda one: one.map_at(3), lambda one: one.paths([0.0], 3)):
        refused(asked, fit_map(theta, theta_next, harmonics=2), told="fitted without cycle numbers")
    worn = fit_map(theta, theta_next, cycle=cycle, harmonics=2, wear_degree=1)
    refused(worn.paths, [0.0], 0, told="cycles must be at least 1")


@pytest.mark.slow
def test_the_plywood_turn_is_known_to_a_degree_and_better_with_wear(measured_data: Path) -> None:
    pairs = read_theta0_pairs(measured_data / STAIRCASE)
    fitted = fit_map(pairs.theta, pairs.theta_next, cycle=pairs.cycle, noise_harmonics=None)
    assert (fitted.pairs, pairs.path.size) == (1996, 2000)
    six = fit_map(pairs.theta, pairs.theta_next, harmonics=6)
    assert six.sigma == pytest.approx(DEFAULT_SIGMA, rel=0.02)
    assert fitted.wear is not None
    assert fitted.wear.degree >= 1 and np.rad2deg(fitted.wear.whole.rmse) < 0.75
    # Where the robot waits it scatters least: the bottleneck is far quieter than the steep flanks.
    assert np.all(
        fitted.wear.whole.noise(np.deg2rad([20.0, 200.0]))
        > 3 * fitted.wear.whole.noise(np.deg2rad(95.0))
    )


MAP, NOISE = CircleMap.arnold(0.11, 0.6), WrappedNormal(0.03)


def made(cycles: int = 4_000) -> Theta0Pairs:
    path = sample_staircase(MAP, NOISE, cycles, seed=2).theta
    return Theta0Pairs(path[:-1], path[1:], path)


@pytest.mark.slow
def test_the_law_behind_made_data_is_found_again() -> None:
    found, truth = measured_staircase(made()), predict_staircase(MAP, NOISE)
    assert found.foretold.fitted.sigma == pytest.approx(NOISE.sigma, rel=0.05)
    assert found.foretold.prediction.step == truth.step
    assert found.cycles_a_turn == pytest.approx(4_000 * TURN / np.ptp(found.path[[0, -1]]))
    assert found.foretold.prediction.mean_residence_cycles == pytest.approx(
        truth.mean_residence_cycles, rel=0.1
    )
    assert found.foretold.comparison.visits[0].mean_p_value > 0.01
    assert (
        abs(found.foretold.comparison.net_steps - found.foretold.comparison.expected_steps)
        < 4 * found.foretold.comparison.net_error
    )


@pytest.mark.slow
def test_measured_plywood_climbs_in_whole_turns_as_its_fitted_map_predicts(
    measured_data: Path,
) -> None:
    found = measured_staircase(read_theta0_pairs(measured_data / STAIRCASE))
    assert np.rad2deg(found.foretold.prediction.step) == pytest.approx(360.0)
    assert np.rad2deg(np.median(found.steps.heights)) == pytest.approx(360.0, abs=1.0)
    assert found.foretold.prediction.mean_residence_cycles == pytest.approx(82.0, abs=2.0)
    visit = found.foretold.comparison.visits[0]
    assert abs(visit.mean - visit.predicted) < 2 * visit.standard_error


def test_pairs_in_no_order_or_without_scatter_make_no_staircase() -> None:
    theta, path = np.linspace(0, 6, 50), np.arange(50) * 1.0
    refused(measured_staircase, Theta0Pairs(theta, theta + 0.1), told="no known order")
    refused(measured_staircase, Theta0Pairs(path[:-1], path[1:], path), told="no measurement")


def test_a_path_that_covers_part_of_the_circle_foretells_no_staircase_and_says_why() -> None:
    """What cycles do in a gap nothing tells; a map fitted there would be as steep as harmonics can
    be.
    """
    rng, theta = np.random.default_rng(1), [0.2]
    for _ in range(150):
        theta.append(theta[-1] + 0.25 * math.sin(1.2 - theta[-1]) + 0.1 * rng.standard_normal())
    path = np.array(theta)
    found = measured_staircase(Theta0Pairs(path[:-1], path[1:], path))
    assert found.foretold is None and "leave a gap of" in found.problem and found.steps.levels.size
    few = np.arange(0.0, 6.5, 0.9)
    assert "too few" in measured_staircase(Theta0Pairs(few[:-1], few[1:], few)).problem


@pytest.mark.parametrize("start", [0.0, -np.pi, 1.0])
def test_images_wrapped_into_one_turn_are_unwrapped(start: float) -> None:
    """Wrapped pairs give the map of the lifted ones; whole turns that are in no wrapping are
    refused.
    """
    rng, truth = np.random.default_rng(5), CircleMap.arnold(0.298, 0.6)
    path = [1.0]
    for kick in 0.1 * rng.standard_normal(300):
        path.append(float(truth(path[-1])) + kick)
    lifted = np.array(path)
    wrapped = start + np.mod(lifted - start, TURN)
    known, found = (fit_map(at[:-1], at[1:], harmonics=2) for at in (lifted, wrapped))
    assert np.allclose(found.map(GRID), known.map(GRID), atol=1e-12) and found.sigma < 0.12
    jumping = wrapped[1:] + TURN * rng.integers(0, 2, 300)
    refused(fit_map, wrapped[:-1], jumping, harmonics=2, told="turns jump by whole ones")
