"""Predicted against measured pushes: exact recovery of the loop's own, bias and spread apart, protocols kept apart."""

from dataclasses import replace

import numpy as np
import pytest
from made_collections import own_pushes, write_poses

from cyclemap.collection import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.comparison.collection_data import collection_data
from cyclemap.evidence.comparison.push_agreement import (
    mean_error,
    push_agreement,
    quantity_agreement,
    within_error,
)
from cyclemap.evidence.comparison.push_laws import predicted_pushes, push_laws

THETA = np.linspace(0.1, 6.1, 12)


@pytest.fixture(scope="module")
def loop() -> CollectionLoop:
    return CollectionLoop.mit("plywood")


def agreements(table, loop, **options):
    data = collection_data(table, loop, **options)
    return data, [push_agreement(one) for one in data.pushes]


def test_a_loops_own_pushes_come_back_with_no_error(loop, tmp_path) -> None:
    data, (found,) = agreements(write_poses(tmp_path / "own.csv", own_pushes(loop, THETA)), loop)
    assert found.count == 12
    assert np.abs(found.predicted - found.measured).max() < 1e-9
    for one in found.quantities:
        assert one.rmse < 1e-9
        assert one.predicted_std == pytest.approx(one.measured_std)
        assert one.explains
    assert data.left_out == {}


def test_a_constant_error_is_all_bias_and_no_spread(loop, tmp_path) -> None:
    rows = own_pushes(loop, THETA, off=(0.02, 0.001, -0.003))
    _, (found,) = agreements(write_poses(tmp_path / "off.csv", rows), loop)
    for one, off in zip(found.quantities, (0.02, 0.001, -0.003), strict=True):
        assert one.bias == pytest.approx(-off, abs=1e-9)
        assert one.spread < 1e-9
        assert one.rmse == pytest.approx(abs(off), rel=1e-6)
        assert one.percent == pytest.approx(100 * abs(off) / abs(one.measured_mean), rel=1e-6)


def test_rmse_is_bias_and_spread_at_right_angles_and_the_std_is_the_best_constant() -> None:
    rng = np.random.default_rng(1)
    measured, predicted = rng.normal(3.0, 1.0, 200), rng.normal(2.5, 1.0, 200)
    found = quantity_agreement("dx", measured, predicted)
    assert found.rmse == pytest.approx(np.hypot(found.bias, found.spread))
    constants = np.linspace(0.0, 6.0, 2001)
    best = np.sqrt(np.mean((measured[:, None] - constants) ** 2, axis=0)).min()
    assert found.measured_std == pytest.approx(best, abs=1e-6)
    assert not found.explains


def test_other_protocols_are_left_out_and_counted_or_adapted_to(loop, tmp_path) -> None:
    other = replace(loop, push=replace(loop.push, fraction=0.6, angle=0.2))
    hexagon = CollectionLoop.from_settings({"shape": "hex"}, loop)
    rows = own_pushes(loop, THETA) + own_pushes(other, THETA[:5], s=0.6, t=0.2)
    rows += own_pushes(hexagon, THETA[:4], shape="hex") + own_pushes(loop, THETA[:3], shape="teapot")
    table = write_poses(tmp_path / "mixed.csv", rows)
    data, kept = agreements(table, loop)
    assert [one.count for one in kept] == [12]
    assert data.left_out["another protocol"] == 12
    data, adapted = agreements(table, loop, adapt=True)
    assert sorted(one.count for one in adapted) == [4, 5, 12]
    assert data.left_out["no loop can be made for it"] == 3
    assert sum(one.adapted for one in adapted) == 2
    assert max(one.rmse for each in adapted for one in each.quantities) < 1e-9


def test_many_pushes_are_looked_up_as_well_as_run(loop) -> None:
    """Two routes: the sampled laws within their stated bounds of the pushes run one by one."""
    theta = np.random.default_rng(2).uniform(-7.0, 7.0, 30)
    run, exact = predicted_pushes(loop, theta)
    sampled, (turn_error, length_error) = predicted_pushes(loop, theta, most_run=10, tolerance=1e-4)
    assert exact == (0.0, 0.0)
    assert 0.0 < turn_error <= 1.1e-4
    assert 0.0 < length_error <= 1.1e-5
    assert np.abs(sampled[:, 0] - run[:, 0]).max() <= turn_error
    assert np.abs(sampled[:, 1:] - run[:, 1:]).max() <= length_error


def test_an_isotropic_loop_turns_alike_everywhere() -> None:
    laws = push_laws(CollectionLoop.mit("isotropic"), tolerance=1e-4)
    values = laws(np.linspace(0.0, 6.0, 50))
    assert np.ptp(values, axis=0).max() < 1e-5
    # Design oracle: 74.52037 degrees, 41.50526 and -71.78672 mm.
    assert np.allclose(values[0] * [180 / np.pi, 1e3, 1e3], [74.52037, 41.50526, -71.78672], atol=2e-3)


def test_the_error_of_a_mean_allows_for_correlation() -> None:
    rng = np.random.default_rng(3)
    independent = rng.standard_normal(4000)
    assert mean_error(independent) == pytest.approx(1 / np.sqrt(4000), rel=0.25)
    assert mean_error(np.repeat(independent[:400], 10)) == pytest.approx(1 / np.sqrt(400), rel=0.25)
    assert mean_error(independent[:2]) is None
    assert within_error(0.1, None, 2) is None


def test_data_that_leave_nothing_are_refused(loop, tmp_path) -> None:
    table = write_poses(tmp_path / "hex.csv", own_pushes(loop, THETA[:4], shape="hex"))
    with pytest.raises(InvalidInput, match=r"nothing is left of 4 pushes to compare with \(4 another protocol"):
        collection_data(table, loop)
    with pytest.raises(InvalidInput, match="data is list: give a PushTable"):
        collection_data([1.0, 2.0], loop)
    with pytest.raises(InvalidInput, match="first must be at least 0"):
        collection_data(table, loop, first=-1)
