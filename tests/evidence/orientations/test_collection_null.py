"""P-values under simulated chains and collections: level, power, wear, and what forgotten fits get wrong."""

import numpy as np
import pytest
from scipy.special import kolmogorov

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.orientations.circular_distance import CircularLaw
from cyclemap.evidence.orientations.collection_null import (
    CollectionModel,
    chain_p_value,
    chain_p_values,
    collection_p_values,
    orientation_statistics,
    refit_harmonic_map,
    simulated_ensemble,
)
from cyclemap.evidence.orientations.goodness_of_fit import watson_statistic
from cyclemap.maps import CircleMap, DriftingMap, WrappedNormal, sample_staircase, sample_staircases, transfer_operator

# A slow sine map, second eigenvalue 0.90: neighbours are strongly correlated.
MAP, NOISE = CircleMap.arnold(0.01, 0.15), WrappedNormal(0.3)
RUNS, PATHS, LENGTH = 39, 250, 80
FAST = {name: measure for name, measure in orientation_statistics().items() if name != "wasserstein"}


@pytest.fixture(scope="module")
def operator():
    return transfer_operator(MAP, NOISE)


@pytest.fixture(scope="module")
def paths():
    starts = np.random.default_rng(11).uniform(0.0, 2 * np.pi, PATHS)
    return sample_staircases(MAP, NOISE, LENGTH - 1, starts, seed=12)


def slope_refit(path):
    """Ω, K and sigma of a sine map by least squares."""
    design = np.column_stack([np.ones(path.size - 1), -np.sin(path[:-1])])
    (shift, strength), *_ = np.linalg.lstsq(design, np.diff(path), rcond=None)
    scatter = np.std(np.diff(path) - design @ [shift, strength])
    return CircleMap.arnold(shift / (2 * np.pi), strength), WrappedNormal(float(scatter))


@pytest.mark.slow
def test_under_the_chain_the_level_holds(operator, paths) -> None:
    found = [
        chain_p_values(path, MAP, NOISE, FAST, runs=RUNS, seed=k, operator=operator) for k, path in enumerate(paths)
    ]
    assert len(found) == PATHS
    for name in FAST:
        values = np.array([each[name].value for each in found])
        assert 0.06 <= np.mean(values <= 0.1) <= 0.15
        assert np.mean(values <= 0.5) == pytest.approx(0.5, abs=4 * 0.5 / np.sqrt(PATHS))


@pytest.mark.slow
def test_under_the_chain_the_level_of_the_wasserstein_distance_holds(paths) -> None:
    values = [
        chain_p_value(path, MAP, NOISE, "wasserstein", runs=19, seed=k).value for k, path in enumerate(paths[:200])
    ]
    assert len(values) == 200
    assert 0.06 <= np.mean(np.array(values) <= 0.1) <= 0.15


def test_formulas_for_independent_orientations_are_badly_wrong_there(operator, paths) -> None:
    """Watson's law of U² for many independent orientations (1961) is Kolmogorov's at π√U²."""
    statistic = watson_statistic(paths, CircularLaw(operator.density))
    assert np.mean(kolmogorov(np.pi * np.sqrt(statistic)) < 0.1) > 0.6


@pytest.mark.parametrize("name", ["wasserstein", "total_variation", "kuiper", "watson"])
def test_a_rotated_map_and_a_wrong_noise_are_rejected(name) -> None:
    truth, noise, length = CircleMap.arnold(0.05, 0.6), WrappedNormal(0.3), 600
    path = sample_staircases(truth, noise, length - 1, [0.5], seed=4)[0]
    turned = CircleMap(lambda theta: truth(theta - 0.4) + 0.4)
    assert chain_p_value(path, truth, noise, name, runs=99).value > 0.02
    assert chain_p_value(path, turned, noise, name, runs=99).value == 0.01
    assert chain_p_value(path, truth, WrappedNormal(0.15), name, runs=99).value == 0.01


@pytest.mark.slow
def test_fitted_parameters_make_p_too_large_unless_they_are_fitted_again() -> None:
    model = CircleMap.arnold(0.03, 0.4), WrappedNormal(0.6)
    starts = np.random.default_rng(31).uniform(0.0, 6.0, 70)
    measured = sample_staircases(*model, 149, starts, seed=1031)
    plain, refitted = [], []
    for k, path in enumerate(measured):
        fitted = slope_refit(path)
        plain.append(chain_p_value(path, *fitted, "watson", runs=19, seed=k).value)
        refitted.append(chain_p_value(path, *fitted, "watson", runs=19, seed=k, refit=slope_refit).value)
    # The mean of a calibrated one is 0.525, its standard error 0.29/√70 = 0.035.
    assert np.mean(plain) > 0.7
    assert np.mean(refitted) == pytest.approx(0.525, abs=0.105)


def test_whole_turns_and_the_seed_settle_everything(operator, paths) -> None:
    once = chain_p_value(paths[0], MAP, NOISE, "watson", runs=50, seed=9)
    again = chain_p_values(paths[0], MAP, NOISE, FAST, runs=50, seed=9, operator=operator)["watson"]
    assert (once.value, once.statistic) == (again.value, again.statistic)
    other = chain_p_value(np.mod(paths[0], 2 * np.pi), MAP, NOISE, "watson", runs=50, seed=9)
    assert other.value == once.value
    assert other.statistic == pytest.approx(once.statistic, rel=1e-9)


def test_rotating_map_and_path_changes_nothing() -> None:
    turned = CircleMap(lambda theta: MAP(theta - 1.0) + 1.0)
    path = sample_staircases(MAP, NOISE, 60, [0.3], seed=5)[0]
    for name in ("kuiper", "watson", "wasserstein"):
        here, there = (chain_p_value(path + s, m, NOISE, name, runs=50) for s, m in ((0.0, MAP), (1.0, turned)))
        assert there.statistic == pytest.approx(here.statistic, abs=1e-5)
        assert there.value == here.value


def test_a_statistic_of_ones_own_will_do(paths) -> None:
    def last(path, law):
        return np.cos(path[:, -1])

    found = chain_p_value(paths[1], MAP, NOISE, last, runs=30)
    assert found.statistic == pytest.approx(np.cos(paths[1][-1]))


def test_the_harmonic_refit_finds_map_and_noise() -> None:
    path = sample_staircases(CircleMap.arnold(0.1, 0.3), WrappedNormal(0.2), 20_000, [0.0], seed=6)[0]
    fitted, noise = refit_harmonic_map(path, harmonics=2)
    grid = np.linspace(0.0, 2 * np.pi, 50)
    assert np.abs(fitted(grid) - CircleMap.arnold(0.1, 0.3)(grid)).max() < 0.02
    assert noise.sigma == pytest.approx(0.2, rel=0.03)


@pytest.mark.parametrize(
    ("theta", "options", "match"),
    [
        ([], {}, "theta holds 0 orientations"),
        ([1.0], {}, "at least two"),
        ([1.0, np.nan], {}, "entry 1 is nan"),
        ([[1.0, 2.0]], {}, "must have 1 axes"),
        ([1.0, 2.0], {"runs": 0}, "runs must be at least 1"),
        ([1.0, 2.0], {"runs": 2.5}, "runs must be a whole number"),
        ([1.0, 2.0], {"seed": -1}, "seed must be at least 0"),
        ([1.0, 2.0], {"statistic": "rao"}, "'rao': it must be a callable or one of wasserstein"),
        ([1.0, 2.0], {"statistic": lambda path, law: 1.0}, "one value a path"),
        ([1.0, 2.0], {"statistic": lambda path, law: np.full(len(path), np.nan)}, "must be finite"),
        ([1.0, 2.0], {"noise": None}, "needs some"),
        ([1.0, 2.0], {"circle_map": np.sin}, "give a CircleMap"),
    ],
)
def test_bad_input_is_refused(theta, options, match) -> None:
    given = {"circle_map": MAP, "noise": NOISE, "statistic": "kuiper", **options}
    with pytest.raises(InvalidInput, match=match):
        chain_p_value(theta, **given)


def test_a_law_that_is_not_known_is_not_tested_against() -> None:
    """Two deep basins and almost no noise: how often each is visited is beyond double precision."""
    basins = CircleMap(lambda theta: theta - 0.3 * np.sin(2 * theta))
    with pytest.raises(ConvergenceError, match="hardly ever connects"):
        chain_p_value([0.0, 0.1], basins, WrappedNormal(0.02), "kuiper")


KICKS = WrappedNormal(0.3)
EARLY, LATE = CircleMap.arnold(0.02, 0.4), CircleMap.arnold(0.2, 0.4)
WORN = DriftingMap.between([(0, EARLY), (100, LATE)])


def test_the_law_of_a_long_collection_is_the_stationary_law() -> None:
    law = simulated_ensemble(CollectionModel(EARLY, KICKS), 0.0, 2000, 100, seed=1).law
    exact = CircularLaw(transfer_operator(EARLY, KICKS).density)
    assert np.abs(law.bin_probabilities(24) - exact.bin_probabilities(24)).max() < 1e-3


def test_the_law_after_one_cycle_is_the_noise_about_the_image() -> None:
    law = simulated_ensemble(CollectionModel(EARLY, KICKS), 0.7, 2, 5, seed=1).law
    exact = CircularLaw(lambda theta: KICKS.density(theta - EARLY(0.7)))
    assert np.abs(law.bin_probabilities(24) - exact.bin_probabilities(24)).max() < 5e-4


def test_images_under_wear_are_those_of_each_cycles_own_map_from_any_first_cycle() -> None:
    model = CollectionModel(WORN, KICKS, first=30)
    paths = model.paths(0.2, 120, 3, seed=2)
    images = model.images(paths)
    assert images.shape == (3, 119)
    for n in (0, 20, 69, 70, 118):
        assert np.allclose(images[:, n], WORN.at(30 + n)(paths[:, n]), atol=1e-12)
    # Kicks are what is left, and of the noise's size.
    assert np.std(paths[:, 1:] - images) == pytest.approx(0.3, rel=0.1)


def test_a_collection_that_begins_late_is_the_tail_of_one_that_begins_early() -> None:
    whole = sample_staircase(WORN, None, 100, 0.1).theta
    begun = CollectionModel(WORN, KICKS, first=40).begun
    assert np.allclose(sample_staircase(begun, None, 60, float(whole[40])).theta, whole[40:], atol=1e-12)


def test_wear_that_is_forgotten_is_found() -> None:
    path = CollectionModel(WORN, KICKS).paths(0.0, 200, 1, seed=9)[0]
    right = collection_p_values(path, CollectionModel(WORN, KICKS), runs=99)
    wrong = collection_p_values(path, CollectionModel(EARLY, KICKS), runs=99)
    assert min(one.value for one in right.values()) > 0.02
    assert all(wrong[name].value == 0.01 for name in ("watson", "turns"))


def test_the_refit_is_called_once_a_collection_and_its_ensemble_decides() -> None:
    model, seen, told = CollectionModel(EARLY, KICKS), [], []

    def refit(path):
        seen.append(path.size)
        return model

    path = model.paths(0.0, 40, 1, seed=3)[0]
    found = collection_p_values(path, model, runs=25, refit=refit, progress=told.append)
    assert seen == [40] * 25
    assert told[-1] == 1.0
    assert found["watson"].runs == 25
    # A refit that always gives the model back leaves the null of that model, with the smaller ensemble.
    ensemble = simulated_ensemble(model, 0.0, 40, 40, seed=1)
    plain = collection_p_values(path, model, runs=25, ensemble=ensemble)
    assert plain["watson"].value == found["watson"].value


@pytest.mark.parametrize(
    ("theta", "options", "match"),
    [
        ([1.0], {}, "at least two"),
        ([1.0, np.inf], {}, "entry 1 is inf"),
        ([1.0, 2.0], {"runs": 0}, "runs must be at least 1"),
        ([1.0, 2.0], {"seed": -1}, "seed must be at least 0"),
        ([1.0, 2.0], {"statistics": {"one": lambda paths, ensemble: np.float64(1.0)}}, "one value a path"),
    ],
)
def test_bad_input_of_a_collection_is_refused(theta, options, match) -> None:
    with pytest.raises(InvalidInput, match=match):
        collection_p_values(theta, CollectionModel(EARLY, KICKS), **options)
