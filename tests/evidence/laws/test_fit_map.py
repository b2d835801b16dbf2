"""Maps fitted to pairs come near those that made them, worn or not, and so does their staircase."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_sets import worn_pairs
from refusals import refused

from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.evidence import Theta0Pairs, measured_staircase, read_theta0_pairs
from cyclemap.evidence.laws.fit_map import FittedMap, fit_map
from cyclemap.maps import (
    CircleMap,
    DriftingMap,
    WrappedNormal,
    sample_staircases,
)

TURN = 2 * np.pi
GRID = np.linspace(0.0, TURN, 90, endpoint=False)
NOISE = WrappedNormal(0.03)


def wearing(theta, cycle):
    """A turn (rad) of two harmonics that wears linearly."""
    fresh = 0.5 + 0.3 * np.cos(theta) + 0.1 * np.sin(2 * theta)
    return fresh + 2e-4 * cycle * (1.0 + np.cos(theta - 1.0))


def wearing_map(number: int, sigma: float, **options: Any) -> FittedMap:
    """The map fitted to a thousand pairs that wear, one of several sets."""
    pairs = worn_pairs(1000, sigma, number, wearing)
    return fit_map(pairs.theta, pairs.theta_next, cycle=pairs.cycle, seed=number, **options)


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
    fitted = wearing_map(0, 0.0, max_harmonics=4)
    assert (fitted.wear.harmonics, fitted.wear.degree) == (2, 1)
    for cycle, told in ((0.0, 0.0), (400.0, 400.0), (999.0, 999.0), (5000.0, 999.0)):
        assert np.allclose(fitted.map_at(cycle).turn(GRID), wearing(GRID, told), atol=1e-10)


@pytest.mark.slow
def test_wear_and_its_degree_are_recovered_under_noise_and_the_bands_cover() -> None:
    covered = []
    for number in range(50):
        wear = wearing_map(number, 0.03, harmonics=2, wear_degree=1).wear
        assert wear.whole.sigma == pytest.approx(0.03, rel=0.1)
        for cycle in (0.0, 600.0, 999.0):
            law = wear.at(cycle)
            covered.append(np.abs(law(GRID) - wearing(GRID, cycle)) <= law.half_bands(GRID)[0])
    assert np.mean(covered) == pytest.approx(0.95, abs=0.03)
    degrees = [wearing_map(number, 0.03, max_harmonics=3).wear.degree for number in range(8)]
    assert degrees.count(1) >= 7


@pytest.mark.slow
def test_worn_paths_are_those_of_the_drifting_map() -> None:
    fitted = wearing_map(1, 0.03, harmonics=2, wear_degree=1)
    starts = np.zeros(400)
    own = fitted.paths(starts, 300, first=200, seed=1)
    blend = DriftingMap.of_family(fitted.map_at, lambda n: 200 + n, 300, 1e-4)
    other = sample_staircases(blend, WrappedNormal(fitted.wear.whole.sigma), 300, starts, seed=2)
    climbs = np.stack([own[:, -1], other[:, -1]])
    error = float(np.sqrt(np.sum(np.var(climbs, axis=1)) / 400))
    assert own.shape == (400, 301)
    assert abs(np.diff(np.mean(climbs, axis=1))[0]) < 4 * error
    assert np.std(climbs[0]) == pytest.approx(np.std(climbs[1]), rel=0.2)


PAIRS = worn_pairs(100, turn=wearing)
NOT_KNOWN = np.append(np.nan, PAIRS.theta_next[1:])


@pytest.mark.parametrize(
    ("ahead", "options", "match"),
    [
        (PAIRS.theta_next[:-1], {}, "theta and theta_next have 100 and 99 entries"),
        (NOT_KNOWN, {}, "finite, but entry 0 is nan"),
        (PAIRS.theta_next, {"cycle": PAIRS.cycle[1:]}, "cycle has 99 entries for 100 pairs"),
        (PAIRS.theta_next, {"cycle": np.full(100, 3.0)}, "every cycle is 3"),
        (PAIRS.theta_next, {"cycle": PAIRS.cycle, "wear_degree": -1}, "degree must be at least 0"),
    ],
)
def test_bad_input_is_refused_by_name(ahead, options, match) -> None:
    refused(fit_map, PAIRS.theta, ahead, told=match, **options)


def test_a_map_without_numbered_cycles_makes_no_worn_ones() -> None:
    plain = fit_map(PAIRS.theta, PAIRS.theta_next, harmonics=2)
    refused(plain.map_at, 3, told="fitted without cycle numbers")
    refused(plain.paths, [0.0], 3, told="fitted without cycle numbers")
    worn = fit_map(PAIRS.theta, PAIRS.theta_next, cycle=PAIRS.cycle, harmonics=2, wear_degree=1)
    refused(worn.paths, [0.0], 0, told="cycles must be at least 1")


@pytest.mark.slow
def test_measured_plywood_climbs_in_whole_turns_as_its_fitted_map_predicts(
    measured_data: Path,
) -> None:
    found = measured_staircase(read_theta0_pairs(measured_data / "plywood_rect1_theta0_2000.csv"))
    assert found.foretold.fitted.sigma == pytest.approx(DEFAULT_SIGMA, rel=0.02)
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
