"""Predicted against measured pushes: exact recovery of the loop's own, bias and spread apart,
protocols kept apart.
"""

from dataclasses import replace

import numpy as np
import pytest
from made_collections import own_pushes, write_poses
from refusals import refused

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import compare
from cyclemap.evidence.comparison.collection_data import collection_data
from cyclemap.evidence.comparison.push_agreement import (
    mean_error,
    push_agreements,
    within_error,
)
from cyclemap.mechanics import MaterialPosterior
from cyclemap.protocol import loop_from_settings

THETA = np.linspace(0.1, 6.1, 12)


@pytest.fixture(scope="module")
def loop() -> CollectionLoop:
    return CollectionLoop.mit("plywood")


@pytest.fixture
def written(tmp_path):
    return lambda rows: write_poses(tmp_path / "poses.csv", rows)


def agreements(table, loop, **options):
    data = collection_data(table, loop, **options)
    return data, push_agreements(data.pushes, lambda done: None)[0]


def renamed(loop, name, **change) -> CollectionLoop:
    return replace(loop, material=replace(loop.material, name=name, **change))


def test_a_push_for_which_the_mechanics_have_no_answer_is_left_out_and_counted(
    loop, written, monkeypatch
) -> None:
    """One of twelve is few; where two of twelve have none the comparison is refused."""
    path, strokes_of = written(own_pushes(loop, THETA)), type(loop.model).push_strokes

    def failing(count):
        def strokes(model, pose, push):
            asked = strokes_of(model, pose, push)
            away = abs(pose.theta - THETA[:count]).min() < 1e-6
            return replace(asked, direction=asked.direction + np.pi * away)

        return strokes

    monkeypatch.setattr(type(loop.model), "push_strokes", failing(1))
    found = compare(loop, path, runs=19)
    assert found.data.left_out == {"the mechanics have no answer": 1}
    (agreement,) = found.pushes
    np.testing.assert_allclose(agreement.theta, THETA[1:], rtol=0, atol=1e-9)
    np.testing.assert_allclose(agreement.predicted, agreement.measured, rtol=0, atol=1e-9)
    monkeypatch.setattr(type(loop.model), "push_strokes", failing(2))
    refused(compare, loop, path, runs=19, told="points away")


@pytest.mark.parametrize("off", [(0.0, 0.0, 0.0), (0.02, 0.001, -0.003)])
def test_a_constant_error_of_a_loops_own_pushes_is_all_bias_and_no_spread(
    loop, written, off
) -> None:
    data, (found,) = agreements(written(own_pushes(loop, THETA, off=off)), loop)
    assert data.left_out == {} and found.count == 12
    assert np.abs(found.predicted - found.measured + off).max() < 1e-9
    for one, shift in zip(found.quantities, off, strict=True):
        assert one.bias == pytest.approx(-shift, abs=1e-9) and one.spread < 1e-9
        assert one.rmse == pytest.approx(abs(shift), rel=1e-6, abs=1e-9)
        percent = 100 * abs(shift) / abs(one.measured_mean)
        assert one.percent == pytest.approx(percent, rel=1e-6, abs=1e-5)
        assert one.predicted_std == pytest.approx(one.measured_std)
        # What is off by rounding alone is not off.
        assert shift or (one.explains and one.agrees is True)


def test_place_direction_length_and_object_of_a_push_are_the_datas(loop, written) -> None:
    other = replace(loop, push=replace(loop.push, fraction=0.6, angle=0.2, distance=0.05))
    hexagon = loop_from_settings({"shape": "hex"}, loop)
    rows = own_pushes(loop, THETA) + own_pushes(other, THETA[:5], s=0.6, t=0.2, push_mm=50)
    rows += own_pushes(hexagon, THETA[:4], shape="hex")
    rows += own_pushes(loop, THETA[:3], shape="teapot")
    for given in (loop, other, hexagon):
        data, found = agreements(written(rows), given)
        sets = sorted((one.count, round(one.length, 9)) for one in found)
        assert sets == [(4, 0.15), (5, 0.05), (12, 0.15)]
        untold = [n for why, n in data.left_out.items() if why.startswith("its outline is not")]
        assert untold == [3]
        assert max(one.rmse for each in found for one in each.quantities) < 1e-9


def test_the_cycle_map_is_that_of_the_cycles_in_the_data(loop, written) -> None:
    """Cycles of 50 mm pushes at another place, beside MIT's loop of 150 mm."""
    other = replace(loop, push=replace(loop.push, fraction=0.6, distance=0.05))
    theta = 0.3 * np.arange(8)
    push = collection_data(written(own_pushes(other, theta, s=0.6, push_mm=50)), loop).loop.push
    assert (push.fraction, push.distance) == (0.6, pytest.approx(0.05))
    assert collection_data(written(own_pushes(loop, theta)), loop).loop is loop


@pytest.fixture
def two_surfaces(loop, written):
    return written(own_pushes(loop, THETA) + own_pushes(loop, THETA[:5], surface="abs"))


def test_pushes_on_another_surface_than_the_material_are_left_out_by_name(
    loop, two_surfaces
) -> None:
    for name in ("plywood", "plywood-identified", "plywood (changed)"):
        data = collection_data(two_surfaces, renamed(loop, name))
        assert [(one.theta.size, one.facts["surface"]) for one in data.pushes] == [(12, "plywood")]
        assert data.left_out["on abs, not plywood"] == 5
    words = r"nothing is left of 17 .*5: on abs, not delrin; 12: on plywood, not delrin"
    refused(collection_data, two_surfaces, CollectionLoop.mit("delrin"), told=words)


def test_a_material_of_no_surface_is_set_beside_one_surface_at_a_time(loop, two_surfaces) -> None:
    mine = renamed(loop, "mine")
    told = r"several surfaces \(abs, plywood\), .* 'mine' names none of them"
    refused(collection_data, two_surfaces, mine, told=told)
    (of_abs,) = collection_data(two_surfaces, mine, select={"surface": "abs"}).pushes
    assert of_abs.theta.size == 5
    told = "no such surface: delrin; the data have abs, plywood"
    refused(collection_data, two_surfaces, mine, select={"surface": "delrin"}, told=told)


def test_the_error_of_a_mean_holds_what_the_materials_posterior_leaves_open(loop, written) -> None:
    mu_a = loop.material.friction.mu_a
    rows = tuple((mu_a * ratio,) for ratio in np.linspace(0.9, 1.1, 5))
    posterior = MaterialPosterior(("mu_a",), rows)
    known = renamed(loop, "plywood", posterior=posterior)
    _, (found,) = agreements(written(own_pushes(loop, THETA)), known)
    means = []
    for number in range(5):
        own = replace(loop, material=known.material.sample(number))
        runs = [own.model.push(own.start_pose(float(theta)), own.push) for theta in THETA]
        means.append(np.mean([[run.turn, *run.displacement] for run in runs], axis=0))
    for one, error in zip(found.quantities, np.std(means, axis=0, ddof=1), strict=True):
        assert (one.model_error, one.bias_error) == pytest.approx((error, error), rel=1e-3)


def test_a_length_that_the_data_do_not_tell_must_be_said(loop, written) -> None:
    table = written(own_pushes(loop, THETA, push_mm=""))
    told = "12: the data do not tell how far the rod moved: add a column push_mm"
    refused(collection_data, table, loop, told=told)
    _, (found,) = agreements(table, loop, push_length=0.15)
    assert found.quantities[0].rmse < 1e-9


def test_the_error_of_a_mean_allows_for_correlation() -> None:
    independent = np.random.default_rng(3).standard_normal(4000)
    assert mean_error(independent) == pytest.approx(1 / np.sqrt(4000), rel=0.25)
    assert mean_error(np.repeat(independent[:400], 10)) == pytest.approx(1 / np.sqrt(400), rel=0.25)
    assert mean_error(independent[:2]) is None and within_error(0.1, None, 2) is None


def test_what_the_pushes_of_a_set_have_in_common_counts_once_a_set() -> None:
    """12 sets of 200, each off by a number of its own: the mean is off as that of 12 numbers."""
    off, said = [], []
    for seed in range(200):
        random = np.random.default_rng(seed)
        values = np.repeat(random.standard_normal(12), 200) + 0.1 * random.standard_normal(2400)
        off.append(np.mean(values))
        said.append((mean_error(values, sizes=[200] * 12), mean_error(values)))
    together, beside = np.mean(said, axis=0)
    assert together == pytest.approx(np.std(off), rel=0.1) and beside < 0.8 * together


@pytest.mark.parametrize(
    ("count", "rho", "most"),
    [
        (3, 0.0, 0.06),
        (4, 0.0, 0.06),
        (5, 0.0, 0.065),
        (10, 0.0, 0.06),
        (20, 0.0, 0.06),
        (40, 0.4, 0.085),
    ],
)
def test_a_mean_of_nought_is_refused_in_one_case_in_twenty_of_few_values_too(
    count, rho, most
) -> None:
    """The error's own uncertainty counts: with 1.96 errors it would be one case in eight of 20, one
    in three of three.
    """
    values = np.random.default_rng(count).standard_normal((count + 50, 2000))
    for place in range(1, len(values)):
        values[place] = rho * values[place - 1] + np.sqrt(1 - rho**2) * values[place]
    rows = values[50:].T
    kept = sum(within_error(float(row.mean()), mean_error(row), count) for row in rows)
    assert 0.035 < 1.0 - kept / 2000 < most


def test_data_that_leave_nothing_are_refused(loop, written) -> None:
    table = written(own_pushes(loop, THETA[:4], shape="pot"))
    told = r"nothing is left of 4 pushes to compare with \(4: its outline is not told"
    refused(collection_data, table, loop, told=told)
    refused(collection_data, [1.0, 2.0], loop, told="data is list: give a PushTable")
    refused(collection_data, table, loop, first=-1, told="first must be at least 0")
