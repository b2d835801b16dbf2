"""Sums over many waves are taken in blocks: whether all are kept in one or made anew in several changes nothing."""

import numpy as np
import pytest

from cyclemap.maps import CircleMap, WrappedNormal
from cyclemap.maps.operator import fourier_basis as module
from cyclemap.maps.operator.fourier_basis import FourierDiscretisation

MAP, NOISE, MODES = CircleMap.arnold(0.1, 0.9), WrappedNormal(0.2), 40


def numbers(basis: FourierDiscretisation) -> dict[str, np.ndarray]:
    law = np.random.default_rng(1).standard_normal(basis.size)
    return {"matrix": basis.matrix, "cycle": basis.cycle(law), "expected slope": basis.expected_slope(law)}


def test_many_blocks_give_what_one_gives(monkeypatch) -> None:
    whole = numbers(FourierDiscretisation(MAP, NOISE, MODES))
    monkeypatch.setattr(module, "_ENTRIES", 1)
    basis = FourierDiscretisation(MAP, NOISE, MODES)
    assert len(list(basis._before)) > 1
    parts = numbers(basis)
    assert whole.keys() == parts.keys() and len(whole) == 3
    for name, value in whole.items():
        assert parts[name] == pytest.approx(value, abs=1e-12 * np.abs(value).max()), name


def test_the_slope_at_chosen_angles_is_the_one_at_the_nodes_there() -> None:
    basis = FourierDiscretisation(MAP, NOISE, MODES)
    duals = np.random.default_rng(2).standard_normal((basis.size, 3))
    theta, _ = basis.rule()
    whole = basis.expected_slope(duals)
    assert whole.shape == (theta.size, 3)
    np.testing.assert_allclose(basis.expected_slope(duals, at=theta[5:20]), whole[5:20], rtol=0, atol=1e-12)
