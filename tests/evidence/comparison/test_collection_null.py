"""P-values under simulated collections: power, wear, and what forgotten fits get wrong; levels:
tests/calibration.
"""

import numpy as np
import pytest
from refusals import refused

from cyclemap.evidence.comparison.collection_null import (
    CollectionModel,
    collection_p_values,
    collection_statistics,
    simulated_ensemble,
)
from cyclemap.evidence.laws.circular_distance import CircularLaw
from cyclemap.maps import CircleMap, DriftingMap, WrappedNormal, transfer_operator

KICKS = WrappedNormal(0.3)
EARLY, LATE = CircleMap.arnold(0.02, 0.4), CircleMap.arnold(0.2, 0.4)
WORN = DriftingMap.between([(0, EARLY), (100, LATE)])


def sine_fit(path) -> CollectionModel:
    """Ω, K and sigma of a sine map by least squares."""
    design = np.column_stack([np.ones(path.size - 1), -np.sin(path[:-1])])
    (shift, strength), *_ = np.linalg.lstsq(design, np.diff(path), rcond=None)
    scatter = float(np.std(np.diff(path) - design @ [shift, strength]))
    sine = CircleMap.arnold(shift / (2 * np.pi), strength)
    return CollectionModel(sine, WrappedNormal(scatter))


def test_a_climb_of_no_turns_lies_as_far_off_as_one_of_twice_as_many() -> None:
    model = CollectionModel(CircleMap.rigid(0.05), WrappedNormal(0.01))
    ensemble = simulated_ensemble(model, 0.0, 100, 20, seed=3)
    ends = np.array([[0.0], [10.0 * np.pi], [20.0 * np.pi]])
    paths = ends * np.linspace(0.0, 1.0, 101)
    turns = collection_statistics()["turns"](paths, ensemble)
    np.testing.assert_allclose(turns, [5.0, 0.0, 5.0], rtol=0, atol=0.1)


@pytest.mark.slow
def test_fitted_parameters_make_p_too_large_unless_they_are_fitted_again() -> None:
    model = CollectionModel(CircleMap.arnold(0.03, 0.4), WrappedNormal(0.6))
    values = []
    for k, path in enumerate(model.paths(1.0, 120, 40, seed=1031)):
        for refit in (None, sine_fit):
            found = collection_p_values(path, sine_fit(path), runs=19, seed=k, refit=refit)
            values.append(found["watson"].value)
    plain, refitted = np.mean(np.reshape(values, (-1, 2)), axis=0)
    # The mean of a calibrated one is 0.525, its standard error 0.29/√40 = 0.046.
    assert plain > 0.7 and refitted == pytest.approx(0.525, abs=0.138)


@pytest.mark.parametrize(
    ("start", "length", "count", "density", "within"),
    [
        (0.0, 2000, 60, transfer_operator(EARLY, KICKS).density, 1e-3),
        (0.7, 2, 5, lambda theta: KICKS.density(theta - EARLY(0.7)), 5e-4),
    ],
)
def test_a_collections_law_is_of_its_first_image_at_first_and_stationary_at_last(
    start, length, count, density, within
) -> None:
    law = simulated_ensemble(CollectionModel(EARLY, KICKS), start, length, count, seed=1).law
    exact = CircularLaw(density).bin_probabilities(24)
    assert law.bin_probabilities(24) == pytest.approx(exact, abs=within)


def test_collections_of_two_samples_of_a_posterior_that_are_alike_have_noise_of_their_own() -> None:
    """The same seed for both would make every other collection a copy."""
    paths = CollectionModel(EARLY, KICKS, samples=(EARLY, EARLY, LATE)).paths(0.5, 40, 9, seed=3)
    assert len({tuple(row) for row in paths.tolist()}) == 9
    steps = np.diff(paths, axis=1) - (EARLY(paths[:, :-1]) - paths[:, :-1])
    assert abs(np.corrcoef(steps[0], steps[1])[0, 1]) < 0.5


def test_images_under_wear_are_those_of_each_cycles_own_map_from_any_first_cycle() -> None:
    model = CollectionModel(WORN, KICKS, first=30)
    paths = model.paths(0.2, 120, 3, seed=2)
    images = model.images(paths)
    for n in (0, 20, 69, 70, 118):
        assert np.allclose(images[:, n], WORN.at(30 + n)(paths[:, n]), atol=1e-12)
    # Kicks are what is left, and of the noise's size.
    assert np.std(paths[:, 1:] - images) == pytest.approx(0.3, rel=0.1)


def test_the_refit_is_called_once_a_collection_and_its_ensemble_decides() -> None:
    model, seen, told = CollectionModel(EARLY, KICKS), [], []

    def refit(path):
        seen.append(path.size)
        return model

    path = model.paths(0.0, 40, 1, seed=3)[0]
    found = collection_p_values(path, model, runs=25, refit=refit, progress=told.append)
    assert (seen, told[-1], found["watson"].runs) == ([40] * 25, 1.0, 25)
    # A refit that always gives the model back leaves the null of that model, with the smaller
    # ensemble.
    ensemble = simulated_ensemble(model, 0.0, 40, 40, seed=1)
    plain = collection_p_values(path, model, runs=25, ensemble=ensemble)
    assert plain["watson"].value == found["watson"].value


def one_statistic(measure):
    return {"statistics": {"one": measure}}


@pytest.mark.parametrize(
    ("theta", "options", "match"),
    [
        ([1.0], {}, "at least two"),
        ([1.0, np.inf], {}, "entry 1 is inf"),
        ([[1.0, 2.0]], {}, "must have 1 axes"),
        ([1.0, 2.0], {"runs": 0}, "runs must be at least 1"),
        ([1.0, 2.0], {"seed": -1}, "seed must be at least 0"),
        ([1.0, 2.0], one_statistic(lambda paths, ensemble: np.float64(1.0)), "one value a path"),
        ([1.0, 2.0], one_statistic(lambda paths, _: np.full(len(paths), np.nan)), "be finite"),
    ],
)
def test_bad_input_of_a_collection_is_refused(theta, options, match) -> None:
    refused(collection_p_values, theta, CollectionModel(EARLY, KICKS), **options, told=match)
