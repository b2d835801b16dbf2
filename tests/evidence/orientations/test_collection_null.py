"""Collections under a map that may wear: the law of what they record by two routes, and exact p-values."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.circular_distance import CircularLaw
from cyclemap.evidence.orientations.collection_null import CollectionModel, collection_p_values, simulated_ensemble
from cyclemap.maps import CircleMap, DriftingMap, WrappedNormal, sample_staircase, transfer_operator

NOISE = WrappedNormal(0.3)
EARLY, LATE = CircleMap.arnold(0.02, 0.4), CircleMap.arnold(0.2, 0.4)
WORN = DriftingMap.between([(0, EARLY), (100, LATE)])


def test_the_law_of_a_long_collection_is_the_stationary_law() -> None:
    law = simulated_ensemble(CollectionModel(EARLY, NOISE), 0.0, 2000, 100, seed=1).law
    exact = CircularLaw(transfer_operator(EARLY, NOISE).density)
    assert np.abs(law.bin_probabilities(24) - exact.bin_probabilities(24)).max() < 1e-3


def test_the_law_after_one_cycle_is_the_noise_about_the_image() -> None:
    law = simulated_ensemble(CollectionModel(EARLY, NOISE), 0.7, 2, 5, seed=1).law
    exact = CircularLaw(lambda theta: NOISE.density(theta - EARLY(0.7)))
    assert np.abs(law.bin_probabilities(24) - exact.bin_probabilities(24)).max() < 5e-4


def test_images_under_wear_are_those_of_each_cycles_own_map_from_any_first_cycle() -> None:
    model = CollectionModel(WORN, NOISE, first=30)
    paths = model.paths(0.2, 120, 3, seed=2)
    images = model.images(paths)
    assert images.shape == (3, 119)
    for n in (0, 20, 69, 70, 118):
        assert np.allclose(images[:, n], WORN.at(30 + n)(paths[:, n]), atol=1e-12)
    # Kicks are what is left, and of the noise's size.
    assert np.std(paths[:, 1:] - images) == pytest.approx(0.3, rel=0.1)


def test_a_collection_that_begins_late_is_the_tail_of_one_that_begins_early() -> None:
    whole = sample_staircase(WORN, None, 100, 0.1).theta
    begun = CollectionModel(WORN, NOISE, first=40).begun
    assert np.allclose(sample_staircase(begun, None, 60, float(whole[40])).theta, whole[40:], atol=1e-12)


def test_wear_that_is_forgotten_is_found() -> None:
    path = CollectionModel(WORN, NOISE).paths(0.0, 200, 1, seed=9)[0]
    right = collection_p_values(path, CollectionModel(WORN, NOISE), runs=99)
    wrong = collection_p_values(path, CollectionModel(EARLY, NOISE), runs=99)
    assert min(one.value for one in right.values()) > 0.02
    assert all(wrong[name].value == 0.01 for name in ("watson", "turns"))


def test_the_refit_is_called_once_a_collection_and_its_ensemble_decides() -> None:
    model, seen, told = CollectionModel(EARLY, NOISE), [], []

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
def test_bad_input_is_refused(theta, options, match) -> None:
    with pytest.raises(InvalidInput, match=match):
        collection_p_values(theta, CollectionModel(EARLY, NOISE), **options)
