"""Scores of a drawn cycle and their derivatives, on maps whose laws and spectra are known in closed form."""

import math

import numpy as np
import pytest

from cyclemap.maps import CircleMap, WrappedCauchy, WrappedNormal
from cyclemap.maps.mixtures.mixture_operator import mixture_operator
from cyclemap.resets.parameters.parameter_operator import DrawnCycle, variation_from_uniform
from cyclemap.resets.scores.reset_scores import reset_scores

POINTS = 360
GRID = 2.0 * math.pi * np.arange(POINTS) / POINTS


def _moebius(a, spread=0.6, modes=60):
    images = CircleMap.moebius(a, 0.0)(GRID)[None]
    return DrawnCycle(images, np.ones(1), WrappedCauchy(spread), modes)


def _drawn(turns=(0.4, 1.7), bends=(0.3, 0.2), weights=(0.3, 0.7), modes=40):
    rows = [GRID + turn + bend * np.sin(GRID + k) for k, (turn, bend) in enumerate(zip(turns, bends, strict=True))]
    return DrawnCycle(np.array(rows), np.array(weights), WrappedNormal(0.1), modes)


def _moment(a, spread):
    """c of the stationary wrapped Cauchy law with moments c^m: c = spread (c - a)/(1 - a c)."""
    roots = np.roots([a, spread - 1.0, -spread * a])
    return float(roots[np.abs(roots) < 1.0][0].real)


@pytest.mark.parametrize("a", [0.2, 0.5])
def test_the_moebius_cycle_with_cauchy_noise_is_known_exactly(a):
    """Its law is wrapped Cauchy with a known r: TV = (2/pi) arcsin r, sum of squares r^2/(1 - r^2); |lambda_2| is the
    derivative of c -> spread (c - a)/(1 - a c) there."""
    spread = 0.6
    r = abs(_moment(a, spread))
    cycle = _moebius(a, spread)
    assert abs(cycle.total_variation().value - 2.0 / math.pi * math.asin(r)) < 1e-6
    assert abs(cycle.deviation().value - math.sqrt(0.5 * r * r / (1.0 - r * r))) < 1e-10
    multiplier = spread * (1.0 - a * a) / (1.0 - a * _moment(a, spread)) ** 2
    assert abs(cycle.second_eigenvalue().value - multiplier) < 1e-8


def test_the_moebius_cycles_scores_move_with_its_parameter_as_the_closed_forms_do():
    """Through the images: the gradient by them times dF/da is the derivative of the closed form by a."""
    a, spread, step = 0.4, 0.6, 1e-6
    cycle = _moebius(a, spread)
    by_a = (CircleMap.moebius(a + step, 0.0)(GRID) - CircleMap.moebius(a - step, 0.0)(GRID)) / (2.0 * step)

    def slope(closed):
        return (closed(a + step) - closed(a - step)) / (2.0 * step)

    def multiplier(b):
        return spread * (1.0 - b * b) / (1.0 - b * _moment(b, spread)) ** 2

    closed = (
        (cycle.total_variation(), lambda b: 2.0 / math.pi * math.asin(abs(_moment(b, spread)))),
        (cycle.deviation(), lambda b: abs(_moment(b, spread)) / math.sqrt(2.0 - 2.0 * _moment(b, spread) ** 2)),
        (cycle.second_eigenvalue(), multiplier),
    )
    for score, known in closed:
        by_image, _ = cycle.by_images(score)
        assert abs(by_image[0] @ by_a - slope(known)) < 1e-4 * abs(slope(known))


def test_the_worst_start_of_the_moebius_cycle_is_the_one_that_stays_furthest_out():
    """After n cycles c_n is the n-th iterate of c -> spread (c - a)/(1 - a c), c_0 = exp(i theta), and the total
    variation (2/pi) arcsin |c_n|."""
    a, spread, cycles = 0.3, 0.6, 3
    cycle = _moebius(a, spread)
    c = np.exp(1j * GRID)
    for _ in range(cycles):
        c = spread * (c - a) / (1.0 - a * c)
    found = cycle.reach(cycles)
    assert abs(found.value - 2.0 / math.pi * math.asin(np.abs(c).max())) < 1e-5
    assert abs(np.abs(c[found.start]) - np.abs(c).max()) < 1e-5


def test_rotations_drawn_with_weights_have_the_spectrum_of_their_mean():
    """lambda_m = kappa_m sum_i w_i exp(i m a_i), and its modulus moves with each turn and weight as that does."""
    turns, weights = np.array([0.4, 1.1]), np.array([0.25, 0.75])
    cycle = _drawn(turns, (0.0, 0.0), weights)
    orders = np.arange(1, 41)
    modes = WrappedNormal(0.1).coefficients(orders) * (np.exp(1j * np.outer(orders, turns)) @ weights)
    best = int(np.argmax(np.abs(modes)))
    score = cycle.second_eigenvalue()
    assert abs(score.value - abs(modes[best])) < 1e-12
    by_image, by_weight = cycle.by_images(score)
    m, kappa = orders[best], WrappedNormal(0.1).coefficients(orders)[best]
    waves = kappa * np.exp(1j * m * turns)
    direction = np.conj(modes[best]) / abs(modes[best])
    assert np.abs(by_image.sum(axis=1) - np.real(direction * 1j * m * weights * waves)).max() < 1e-8
    assert np.abs(by_weight - np.real(direction * waves)).max() < 1e-8


def test_the_matrix_and_the_scores_are_those_of_the_mixture_operator():
    """The package's own operator of the same random map: another quadrature, other code."""
    cycle, noise = _drawn(), WrappedNormal(0.1)
    maps = [
        CircleMap(lambda t, a=a, b=b, k=k: t + a + b * np.sin(t + k), lambda t, b=b, k=k: 1.0 + b * np.cos(t + k))
        for k, (a, b) in enumerate(((0.4, 0.3), (1.7, 0.2)))
    ]
    operator = mixture_operator(maps, (0.3, 0.7), noise, 40)
    assert np.abs(cycle.matrix - operator.discretisation.matrix).max() < 1e-12
    scores = reset_scores(maps, noise, (0.3, 0.7), modes=40, bounded=False, pushes=4)
    assert abs(cycle.total_variation().value - scores.evenness.total_variation) < 1e-6
    assert abs(cycle.second_eigenvalue().value - (1.0 - scores.spectral_gap)) < 1e-10
    assert abs(cycle.reach(4).value - scores.curve.total_variation[-1]) < 2e-3


@pytest.mark.parametrize("name", ["total_variation", "deviation", "second_eigenvalue", "reach"])
def test_gradients_are_differences_of_the_scores_in_every_direction(name):
    """Images bent by a wave each, and weights: central differences to 1e-5 of the gradient."""
    cycle = _drawn()

    def score(one):
        return one.reach(5) if name == "reach" else getattr(one, name)()

    by_image, by_weight = cycle.by_images(score(cycle))
    bend, shift, step = np.stack([np.cos(GRID), np.sin(2.0 * GRID)]), np.array([1.0, -1.0]), 1e-5
    ends = [
        score(DrawnCycle(cycle.images + h * bend, cycle.weights + h * shift, cycle.noise, cycle.modes)).value
        for h in (-step, step)
    ]
    slope = (ends[1] - ends[0]) / (2.0 * step)
    assert abs(np.sum(by_image * bend) + by_weight @ shift - slope) < 1e-5 * abs(slope) and abs(slope) > 1e-3


def test_the_variation_of_a_single_wave_is_known():
    """Density (1 + 2 r cos)/2pi: TV = 2 r/pi, and so in every direction."""
    value, by_law = variation_from_uniform(np.array([1.0, 0.06, 0.08]))
    assert abs(value - 0.2 / math.pi) < 1e-6 and np.abs(by_law - (0.0, 1.2 / math.pi, 1.6 / math.pi)).max() < 1e-5


def test_the_deviation_is_never_below_the_total_variation():
    rng = np.random.default_rng(5)
    for _ in range(20):
        cycle = _drawn(rng.uniform(0.0, 6.0, 2), rng.uniform(0.0, 0.6, 2), rng.dirichlet((1.0, 1.0)))
        assert cycle.deviation().value >= cycle.total_variation().value - 1e-9
