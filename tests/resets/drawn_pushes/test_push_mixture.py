"""Bias and speed of drawn pushes: against the operator's own laws, closed forms, and gradients against differences."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, WrappedNormal
from cyclemap.maps.mixtures.law_evolution import law_after
from cyclemap.maps.mixtures.mixture_operator import mixture_operator
from cyclemap.resets.drawn_pushes.push_library import PushLibrary
from cyclemap.resets.drawn_pushes.push_mixture import PushMixture

NOISE, MODES = WrappedNormal(0.15), 32
MAPS = [CircleMap.arnold(omega, bend) for omega, bend in ((0.0, 0.8), (0.3, 0.6), (0.55, 0.9), (0.8, 0.4))]
WEIGHTS = np.array([0.4, 0.1, 0.3, 0.2])


@pytest.fixture(scope="module")
def mixture():
    return PushMixture(PushLibrary.of_maps([MAPS], NOISE, np.full((1, 4), 0.1), MODES).matrices[0])


def differences(function, weights, step=1e-6):
    """Central differences by every weight, which need not add up to one."""
    return np.array([(function(weights + e) - function(weights - e)) / (2 * step) for e in step * np.eye(len(weights))])


@pytest.mark.parametrize(
    "measure",
    [
        lambda mixture, w: mixture.bias(w),
        lambda mixture, w: mixture.bias(w, 0.02),
        lambda mixture, w: mixture.bias_after(w, 1, 0.02, 80.0),
        lambda mixture, w: mixture.bias_after(w, 6, 0.02, 80.0),
        lambda mixture, w: mixture.bias_after(w, 13, 0.01),
        lambda mixture, w: mixture.bias_after(w, 50, 0.0, 300.0),
    ],
)
def test_gradients_are_those_of_finite_differences(mixture, measure):
    value, gradient = measure(mixture, WEIGHTS)
    assert value > 0.01 and gradient.shape == (4,) and np.abs(gradient).max() > 0.01
    assert np.abs(gradient - differences(lambda w: measure(mixture, w)[0], WEIGHTS)).max() < 1e-8


def test_the_laws_are_those_of_the_mixtures_operator(mixture):
    """Stationary by its moments; after seven pushes by the law carried on from each start."""
    operator = mixture_operator(MAPS, WEIGHTS, NOISE, MODES)
    law = mixture.stationary(WEIGHTS)
    moments = np.array([operator.moment(n) for n in range(1, MODES + 1)])
    assert np.abs(law[1 : MODES + 1] + 1j * law[MODES + 1 :] - moments).max() < 1e-12
    assert abs(mixture.bias(WEIGHTS)[0] - operator.tv_from_uniform) < 1e-4
    starts = 2 * np.pi * np.arange(32) / 32
    late = [law_after(operator, start, 7).total_variation() for start in starts.tolist()]
    assert len(late) == 32 and abs(mixture.bias_after(WEIGHTS, 7)[0] - max(late)) < 2e-4
    assert abs(mixture.second_eigenvalue(WEIGHTS) - 1.0 + operator.spectral_gap) < 1e-9


def test_rotations_are_exactly_even_and_forget_by_the_mean_of_their_phases():
    """Drawn rotations keep the uniform law; the first harmonic shrinks by κ_1 |Σ w_i e^{iα_i}| a push."""
    turns, weights = np.array([0.11, 0.37, 0.52]), np.array([0.5, 0.3, 0.2])
    library = PushLibrary.of_maps([[CircleMap.rigid(turn) for turn in turns]], NOISE, [[0.1] * 3], modes=12)
    mixture = PushMixture(library.matrices[0])
    assert mixture.bias(weights)[0] < 1e-14
    orders = np.arange(1, 13)
    phases = NOISE.coefficients(orders) * np.abs(np.exp(2j * np.pi * np.multiply.outer(orders, turns)) @ weights)
    assert abs(mixture.second_eigenvalue(weights) - phases.max()) < 1e-12
    # Far from the start only the slowest harmonic is left: its total variation is 2 r^n / pi.
    assert abs(mixture.bias_after(weights, 40)[0] / (2 * phases.max() ** 40 / np.pi) - 1.0) < 0.01


def test_smoothing_and_soft_maximum_overrate_by_no_more_than_they_say(mixture):
    plain, soft = mixture.bias(WEIGHTS)[0], mixture.bias(WEIGHTS, 0.04)[0]
    assert plain <= soft <= plain + 0.02
    plain, soft = mixture.bias_after(WEIGHTS, 9)[0], mixture.bias_after(WEIGHTS, 9, 0.0, 50.0)[0]
    assert plain <= soft <= plain + np.log(32) / 50.0


def test_fewer_modes_are_a_part_of_the_same_matrices(mixture):
    cut = mixture.cut(20)
    assert cut.modes == 20 and mixture.cut(100) is mixture
    assert abs(cut.bias(WEIGHTS)[0] - mixture.bias(WEIGHTS)[0]) < 1e-4
    direct = PushLibrary.of_maps([MAPS], NOISE, np.full((1, 4), 0.1), 20).matrices[0]
    assert np.abs(cut.matrices - direct).max() < 1e-9


@pytest.mark.parametrize("shape", [(0, 3, 3), (2, 4, 4), (2, 3, 5)])
def test_matrices_of_another_shape_are_refused(shape):
    with pytest.raises(InvalidInput, match="matrices"):
        PushMixture(np.zeros(shape))
