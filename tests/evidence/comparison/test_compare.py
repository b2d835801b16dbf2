"""compare: every kind of prediction and data, the truth kept and a wrong law refused."""

import re
from dataclasses import replace

import numpy as np
import pytest
from made_collections import (
    NOISE,
    SINE,
    WORN,
    own_pushes,
    pairs_of,
    pose_row,
    sine_pairs,
    write_poses,
)
from refusals import refused

from cyclemap.collection import CollectionLoop
from cyclemap.errors import DataFileError
from cyclemap.evidence import (
    CollectionModel,
    Theta0Pairs,
    collection_p_values,
    compare,
    simulated_ensemble,
)
from cyclemap.evidence.comparison.collection_data import collection_data
from cyclemap.evidence.comparison.collection_null import as_prediction
from cyclemap.evidence.comparison.cycle_agreement import map_misfit, simulated_quantity
from cyclemap.maps import CircleMap, WrappedNormal, sample_staircase
from cyclemap.mechanics import MaterialPosterior
from cyclemap.views.compare_page import verdicts

STEPS = ["step height", "residence on a step"]


@pytest.fixture
def quick(monkeypatch):
    """Few collections where they take longest."""
    monkeypatch.setattr("cyclemap.evidence.comparison.compare.MOST_DETAILED", 3)
    monkeypatch.setattr("cyclemap.evidence.comparison.compare.ENSEMBLE", 60)


def asked(found) -> list[str]:
    return [verdict.question for verdict in verdicts(found)]


def answers(found) -> dict[str, bool | None]:
    return {verdict.question: verdict.agrees for verdict in verdicts(found)}


def test_the_misfit_of_a_models_own_paths_is_an_f_ratio() -> None:
    """Of thirteen and 86 degrees of freedom, whose mean is 86/84."""
    model = CollectionModel(CircleMap.rigid(0.31), WrappedNormal(0.05))
    ensemble = simulated_ensemble(model, 0.4, 100, 10, 6)
    ratios = map_misfit(model.paths(0.4, 100, 400, 5), ensemble)
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.06)
    assert np.var(ratios) == pytest.approx(2.0 / 13.0 + 2.0 / 86.0, rel=0.3)


def test_a_number_below_all_simulated_ones_is_as_unlikely_as_one_above_them() -> None:
    simulated = np.arange(-20.0, 21.0)
    below, above = (simulated_quantity(sign * 25.0, simulated).p_value.value for sign in (-1, 1))
    assert below == above == 1 / 42


def test_the_true_law_is_kept_in_every_question() -> None:
    pairs = sine_pairs(250, seed=3)
    truth = compare(SINE, pairs, noise=NOISE, runs=39)
    questions = asked(truth)
    assert questions[:3] == ["mean turn of a cycle", "cycle map", "histogram of directions"]
    assert questions[4:] == ["number of turns", "number of steps", *STEPS]
    assert [*answers(truth).values()] == [True] * 8
    assert truth.cycle.agreement.rms == pytest.approx(0.15, rel=0.1)
    assert truth.cycle.noise == pytest.approx(0.15)
    width = 2 * np.pi / truth.orientations.predicted.density.size
    for histogram in (truth.orientations.measured, truth.orientations.predicted):
        assert histogram.density.sum() * width == pytest.approx(1.0)
    (match,) = truth.directions.matches
    assert abs(match.difference) < 0.4 and truth.staircase.theory.visits[0].exits > 3
    climbed = np.ptp(pairs.path[[0, -1]]) / (2 * np.pi)
    assert truth.staircase.quantities["turns"].measured == pytest.approx(climbed)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("wrong", "noise"),
    [
        (CircleMap.arnold(0.15, 0.6), NOISE),
        (CircleMap(lambda x: SINE(x - 1.0) + 1.0), NOISE),
        (SINE, WrappedNormal(0.4)),
    ],
)
def test_a_wrong_law_is_refused(quick, wrong, noise) -> None:
    found = compare(wrong, sine_pairs(300), noise=noise, runs=49)
    assert max(test.value for test in found.orientations.tests.values()) <= 0.04
    # The noise is no part of the map: that test is blind to it.
    assert (found.cycle.p_value.value <= 0.02) == (wrong is not SINE)


@pytest.mark.slow
def test_wear_is_in_the_null_and_the_cycles_keep_their_numbers(quick) -> None:
    path = sample_staircase(WORN, NOISE, 400, 0.0, seed=3).theta
    right = compare(WORN, pairs_of(path), noise=NOISE, first=100, runs=49)
    still = compare(WORN.at(0), pairs_of(path), noise=NOISE, first=100, runs=49)
    shifted = compare(WORN, pairs_of(path[100:]), noise=NOISE, runs=49)
    assert right.cycle.agreement.pairs == shifted.cycle.agreement.pairs == 300
    assert right.data.pairs.path_cycle[0] == 100
    assert min(right.orientations.tests["watson"].value, right.cycle.p_value.value) > 0.05
    assert still.orientations.tests["watson"].value <= 0.02 and shifted.cycle.p_value.value <= 0.02
    assert right.staircase.theory is None


def test_pairs_without_an_order_compare_the_map_alone() -> None:
    pairs = sine_pairs(100)
    found = compare(SINE, Theta0Pairs(pairs.theta, pairs.theta_next), noise=NOISE, runs=19)
    parts = (found.cycle.p_value, found.orientations, found.directions, found.staircase)
    assert parts == (None,) * 4 and answers(found)["cycle map"] is None


def test_the_seed_settles_everything(quick) -> None:
    told = []
    for seed in (4, 4, 5):
        found = compare(SINE, sine_pairs(60), noise=NOISE, runs=19, seed=seed)
        told.append([verdict.words for verdict in verdicts(found)])
    assert told[0] == told[1] != told[2]


def test_a_loop_is_compared_with_its_pushes_and_its_cycles(quick, tmp_path, loop_of) -> None:
    path, progress, file = sine_pairs(40).path, [], tmp_path / "poses.csv"
    write_poses(file, own_pushes(CollectionLoop.mit("plywood"), path, off=(0.0, 0.001, 0.0)))
    found = compare(loop_of(SINE), file, noise=NOISE, runs=19, progress=progress.append)
    quantities = [f"mean {name} of rect1 on plywood" for name in ("turn of a push", "Δx", "Δy")]
    assert asked(found)[:5] == [*quantities, "ends of pushes", "mean turn of a cycle"]
    told = "Pushes end 1.0 mm and 0.0° from the prediction on average; isotropic"
    assert verdicts(found)[3].words.startswith(told)
    assert found.kind == "loop" and found.cycle.agreement.pairs == 40
    assert "predicted over 41 pushes" in verdicts(found)[1].words
    assert np.allclose(np.diff(found.data.pairs.path), np.diff(path), atol=1e-9)
    assert progress == sorted(progress) and progress[-1] == 1.0


def test_a_truth_that_the_posterior_allows_is_refused_as_seldom_as_the_level_says() -> None:
    """With the posterior the map of a surface drawn from it is kept, without it refused."""
    rng, quiet, loop = np.random.default_rng(4), WrappedNormal(0.05), CollectionLoop.mit("plywood")
    friction, ratios = loop.material.friction, rng.normal(1.0, 0.05, 44).tolist()
    posterior = MaterialPosterior(("mu_a",), tuple((friction.mu_a * r,) for r in ratios[:32]))
    known = replace(loop, material=replace(loop.material, posterior=posterior))
    prediction = as_prediction(known, quiet, 200, tolerance=1e-3)
    alone = replace(prediction, samples=())
    ensemble = simulated_ensemble(alone, 0.5, 151, 20, seed=9)
    rejected = {prediction: 0, alone: 0}
    for number, ratio in enumerate(ratios[32:]):
        surface = replace(loop.material, friction=replace(friction, mu_a=friction.mu_a * ratio))
        truth = replace(loop, material=surface).circle_map(1e-3)
        path = sample_staircase(truth, quiet, 150, 0.5, number).theta
        for model in rejected:
            statistics = {"map": map_misfit}
            found = collection_p_values(path, model, statistics, runs=59, ensemble=ensemble)
            rejected[model] += found["map"].value <= 0.1
    assert rejected[prediction] <= 4 and rejected[alone] >= 8


def test_more_than_three_sets_are_told_as_one(quick, tmp_path, loop_of) -> None:
    loop, rows = CollectionLoop.mit("plywood"), []
    for k in range(4):
        rows += own_pushes(loop, [0.5 + k, 1.0 + k, 1.5 + k], v=20 + k)
    found = compare(loop_of(SINE), write_poses(tmp_path / "boards.csv", rows))
    assert [one.count for one in found.pushes] == [3, 3, 3, 3]
    told = dict.fromkeys(f"{name} in 4 sets" for name in ("turn of a push", "Δx", "Δy"))
    assert answers(found) | told == answers(found)
    words = "Over 12 pushes in 4 sets the Δx is predicted with RMSE 0.00 mm"
    assert words in verdicts(found)[1].words


def test_pairs_keep_the_numbers_of_their_pushes() -> None:
    path = sine_pairs(20).path
    kept = np.delete(np.arange(20.0), [3, 7])
    ends = path[kept.astype(int)], path[kept.astype(int) + 1]
    own = collection_data(Theta0Pairs(*ends, path, cycle=kept), None, first=5).pairs
    assert own.cycle.tolist() == [5, 6, *range(8, 20)]
    assert np.array_equal(own.path, path[5:])
    assert collection_data(Theta0Pairs(*ends), None).pairs.cycle.tolist() == list(range(18))


def test_a_staircase_that_lacks_a_push_is_compared_over_its_longest_run_as_a_table_is() -> None:
    """Two cycles in one step are no step of a simulated collection."""
    number = np.delete(np.arange(20.0), 7)
    turn = np.diff(0.3 * number)
    pairs = Theta0Pairs.along(0.3 * number, turn, np.diff(number) == 1.0, number)
    data = collection_data(pairs, None)
    assert data.pairs.path_cycle.tolist() == list(range(8, 20))
    assert data.pairs.cycle.tolist() == [*range(6), *range(8, 19)]
    assert np.allclose(np.diff(data.pairs.path), 0.3)


@pytest.mark.slow
def test_a_worn_map_is_asked_as_far_as_the_path_of_flagged_pushes_goes() -> None:
    """Flagged pushes at the end make no pair, and are pushes of the path all the same."""
    loop, path = CollectionLoop.mit("plywood-measured"), sine_pairs(8).path
    pairs = Theta0Pairs.along(path, np.diff(path), np.arange(8) < 3, np.arange(91.0, 100.0))
    found = compare(loop, pairs, tolerance=1e-3)
    assert found.data.pairs.path_cycle[-1] == 99.0
    assert found.prediction.map.cycles[-1] >= 99.0


def test_the_collection_is_the_set_with_most_cycles_and_its_longest_run(tmp_path) -> None:
    rows = [pose_row(k, 0.1 * k, 1.0, (0.03, -0.08)) for k in range(10) if k != 3]
    rows += [pose_row(k, 0.2 * k, 1.0, (0.03, -0.08), surface="abs") for k in range(3)]
    data = collection_data(write_poses(tmp_path / "two.csv", rows), None)
    assert data.pairs.cycle.tolist() == [0, 1, 4, 5, 6, 7, 8]
    assert data.left_out["cycle of another set"] == 2
    assert data.pairs.path_cycle.tolist() == [4, 5, 6, 7, 8, 9]
    assert np.allclose(data.pairs.path, 0.1 * np.arange(4, 10))
    (tmp_path / "theta.csv").write_text("theta0_deg\n340\n355\n12\n")
    path = collection_data(tmp_path / "theta.csv", None).pairs.path
    assert np.degrees(path) == pytest.approx([340.0, 355.0, 372.0])


@pytest.mark.parametrize(
    ("prediction", "options", "words"),
    [
        (SINE, {}, "give the noise of a cycle"),
        (SINE, {"noise": 0.1}, "noise is 0.1"),
        ("plywood", {}, "give a CollectionLoop"),
        (None, {}, "the prediction is None"),
        (SINE, {"noise": NOISE, "first": 500}, "first is 500: no cycle is left of 20"),
        (SINE, {"noise": NOISE, "runs": 0}, "runs must be at least 1"),
    ],
)
def test_a_question_that_makes_no_sense_is_refused(prediction, options, words) -> None:
    refused(compare, prediction, sine_pairs(20), told=words, **options)


def test_data_that_cannot_be_read_are_refused(tmp_path) -> None:
    nowhere = tmp_path / "nowhere.csv"
    refused(compare, SINE, nowhere, noise=NOISE, told=r"nowhere\.csv", kind=DataFileError)
    (tmp_path / "bad.json").write_text("{")
    told = r"no push could be read, 1 files are bad; the first: .*bad\.json"
    refused(compare, SINE, tmp_path, noise=NOISE, told=told)


LOCKED, LITTLE = CircleMap.arnold(0.0, 0.9), WrappedNormal(0.02)


def test_a_number_that_no_collection_has_otherwise_is_no_question() -> None:
    """A loop that locks in climbs nothing; turns tell their interval's width."""
    path = sample_staircase(LOCKED, LITTLE, 80, 2.0, seed=3).theta
    found = compare(LOCKED, pairs_of(path), noise=LITTLE, runs=39)
    assert found.staircase.quantities["steps"].predicted == 0.0
    assert "number of steps" not in asked(found)
    for verdict in verdicts(found):
        ends = re.search(r"95 % of collections: (\S+) to (\S+)\)", verdict.words)
        assert ends is None or ends[1] != ends[2], verdict.words


def test_steps_that_a_prediction_denies_are_a_question() -> None:
    told = answers(compare(LOCKED, sine_pairs(200, seed=3), noise=LITTLE, runs=39))
    assert told["number of steps"] is False and told["number of turns"] is False
