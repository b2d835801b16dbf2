"""What a map may be off by, ``max_error``, is in the bounds of all that its operator tells."""

import numpy as np
import pytest

from cyclemap.maps import (
    CircleMap,
    UniformNoise,
    VonMises,
    WrappedCauchy,
    WrappedNormal,
    transfer_operator,
)
from cyclemap.maps.operator.fourier_basis import ShiftedDiscretisation
from cyclemap.maps.operator.poisson_equation import FourierLaw

TWO_PI = 2 * np.pi
GRID = np.linspace(0, TWO_PI, 400, endpoint=False)
LOCKED, FOLDED = CircleMap.arnold(0.1, 0.9), CircleMap.arnold(0.3, 1.7)
WELLS = CircleMap(lambda x: x - 0.35 * np.sin(2 * x) + 0.05 * np.sin(x))
EVEN_WELLS = CircleMap(lambda x: x - 0.2 * np.sin(2 * x))
WAVES = [(0, 0.0), (0, np.pi), *((order, phase) for order in (1, 2, 4) for phase in range(3))]
TOLD = ["moment(1)", "moment(2)", "density", "winding", "tv", "mean", "gap", "diffusion"]


def moved(circle_map, epsilon, order, phase):
    """The map off by a wave of size ε."""
    return CircleMap(lambda x: circle_map(x) + epsilon * np.cos(order * x + phase))


def told(operator, kind):
    """What the operator tells of a kind, and its bound."""
    if kind.startswith("moment"):
        order = int(kind[-2])
        return operator.moment(order), operator.moment_error(order)
    if kind == "density":
        return operator.density(GRID), operator.error_bound
    if kind == "mean":
        value = operator.expectation(lambda theta: np.sin(3 * theta) ** 2)
    else:
        name = {"winding": "rotation_number", "tv": "tv_from_uniform", "gap": "spectral_gap"}
        value = getattr(operator, name.get(kind, kind))
    return value, value.error_bound


def shares(circle_map, noise, epsilon, kinds):
    """For each kind the largest change that a wave makes, as a share of the bound."""
    claimed = transfer_operator(CircleMap(circle_map, max_error=epsilon), noise)
    largest = dict.fromkeys(kinds, 0.0)
    for order, phase in WAVES:
        other = transfer_operator(moved(circle_map, epsilon, order, phase), noise)
        for kind in kinds:
            value, bound = told(claimed, kind)
            change = np.max(np.abs(told(other, kind)[0] - value))
            largest[kind] = max(largest[kind], float(change / bound))
    return largest


@pytest.mark.parametrize("circle_map", [LOCKED, FOLDED, WELLS], ids=["locked", "folded", "wells"])
@pytest.mark.parametrize(
    ("noise", "share"),
    [
        (WrappedNormal(0.25), 1e-4),
        (WrappedNormal(0.25), 0.35),
        (WrappedCauchy(0.8), 0.03),
        (VonMises(9.0), 0.35),
    ],
)
def test_bounds_hold_for_maps_that_are_off_by_a_share_of_the_noise(circle_map, noise, share):
    """However large: where the first order alone would be left behind, too."""
    kinds = TOLD if isinstance(noise, WrappedNormal) else TOLD[:-1]
    for kind, largest in shares(circle_map, noise, 0.25 * share, kinds).items():
        assert largest <= 1.0, kind


@pytest.mark.parametrize("circle_map", [LOCKED, FOLDED], ids=["locked", "folded"])
def test_bounds_are_reached_by_some_small_wave(circle_map):
    """A locked map turned as a whole reaches nearly all of some."""
    largest = shares(circle_map, WrappedNormal(0.25), 1e-6, TOLD)
    assert min(share for kind, share in largest.items() if kind != "tv") > 0.1
    assert largest["tv"] > 0.05
    if circle_map is LOCKED:
        assert min(largest[kind] for kind in ("moment(1)", "winding", "mean", "diffusion")) > 0.95


def test_eigenvalues_hold_for_maps_that_are_off():
    """Each of the first five, matched by the nearest; under noise whose density jumps, too."""
    judged, epsilon = 0, 1e-3
    for circle_map in (LOCKED, FOLDED, WELLS):
        for noise in (WrappedNormal(0.3), UniformNoise(0.8)):
            claimed = transfer_operator(CircleMap(circle_map, max_error=epsilon), noise)
            spectrum = claimed.spectrum(5)
            for order, phase in WAVES[::3]:
                other = transfer_operator(moved(circle_map, epsilon, order, phase), noise)
                apart = np.abs(spectrum.values[:, None] - other.eigenvalues(12)).min(axis=1)
                assert np.all(apart <= spectrum.error_bounds + 1e-12)
            judged += int(np.sum(np.isfinite(spectrum.error_bounds)) - 1)
    assert judged >= 15


@pytest.mark.parametrize("epsilon", [1e-4, 5e-3])
def test_the_worst_map_moves_an_eigenvalue_by_its_bound_and_no_more(epsilon):
    """Off by ±ε with the signs of wᵀ∂L/∂F v only the second order keeps the bound of λ₂ above."""
    noise = WrappedNormal(0.5)
    claimed = transfer_operator(CircleMap(EVEN_WELLS, max_error=epsilon), noise)
    spectrum = claimed.spectrum(3)
    basis = claimed.discretisation
    points = np.linspace(0, TWO_PI, 20_000, endpoint=False)
    factors = basis.derived(basis.kappa * spectrum.left[:, 1].real)
    density = basis.density(points, spectrum.right[:, 1].real)
    response = basis.dual(EVEN_WELLS(points), factors) * density
    ends = points[np.flatnonzero(np.diff(np.sign(response), append=np.sign(response[0])))]
    assert 2 <= ends.size <= 20
    middle = 0.5 * (ends + np.append(ends[1:], ends[0] + TWO_PI))
    sign = np.sign(np.interp(middle, points, response, period=TWO_PI))
    changes = []
    for way in (epsilon, -epsilon):

        def lift(x, way=way):
            return EVEN_WELLS(x) + way * sign[np.searchsorted(ends, np.mod(x, TWO_PI)) - 1]

        other = transfer_operator(CircleMap(lift, None, ends), noise)
        changes.append(np.abs(other.eigenvalues(4) - spectrum.values[1]).min())
    assert 0.75 < max(changes) / spectrum.error_bounds[1] <= 1.0


def test_the_bound_of_all_eigenvalues_counts_the_maps_error_too():
    """Of a rotation the operator's norm without its law is |λ₂| itself."""
    noise = WrappedNormal(0.3)
    turning = CircleMap.rigid(0.25)
    basis = transfer_operator(CircleMap(turning, max_error=0.02), noise).discretisation
    plain = transfer_operator(turning, noise).discretisation
    changes = []
    for order, phase in WAVES:
        other = transfer_operator(moved(turning, 0.02, order, phase), noise)
        changes.append(np.linalg.norm(other.discretisation.matrix - plain.matrix))
    assert 0.3 * basis.moved < max(changes) <= basis.moved
    assert plain.moved == 0.0


def test_a_diffusion_whose_change_no_first_order_tells_has_no_bound():
    """Of two equal wells: a map turned as a whole by 0.0875 rad makes it 45 times larger."""
    claimed = transfer_operator(CircleMap(WELLS, max_error=0.02), WrappedNormal(0.25))
    assert np.isinf(claimed.diffusion.error_bound)


def test_without_a_map_error_bounds_are_of_the_computation_alone():
    exact = transfer_operator(LOCKED, WrappedNormal(0.25))
    assert exact.error_bound < 1e-12 and exact.diffusion.error_bound < 1e-12
    assert exact.spectral_gap.error_bound < 1e-12


def worst_change(claimed, function):
    """What the mean of a function changes for the map off by ±ε with the signs of its gain by F."""
    law, basis = claimed.law, claimed.discretisation
    theta, weight = basis.rule
    moments = basis.integrals(theta, weight * function(theta))
    shift = basis.map.max_error * np.sign(basis.expected_slope(law.dual(moments)))
    changes = []
    for way in (1, -1):
        beside = ShiftedDiscretisation(basis.map, basis.noise, basis.modes, 1, way * shift)
        other = FourierLaw(beside)
        changes.append(abs(moments @ (other.coefficients - law.coefficients)))
    return float(max(changes))


def test_the_worst_maps_for_a_mean_stay_within_its_bound():
    """Off by ±ε with the signs of what a mean gains by F both parts of the second order are needed;
    noise and ε up to the noise's own size at random.
    """
    rng = np.random.default_rng(1)
    largest = 0.0
    for _ in range(5):
        turn, steep, second, phase = rng.uniform(-1.0, 1.0, 4)
        sigma = float(rng.choice([0.2, 0.4, 0.8, 1.2]))

        def lift(x, turn=turn, steep=steep, second=second, phase=phase):
            bent = 1.5 * steep * np.sin(x) + 0.4 * second * np.sin(2 * x + 6 * phase)
            return x + 3 * turn + bent

        for epsilon in (0.03 * sigma, 0.3 * sigma, sigma):
            claimed = transfer_operator(CircleMap(lift, max_error=epsilon), WrappedNormal(sigma))
            for order, phase in ((1, 0.0), (1, 1.5), (2, 0.0), (2, 1.5), (3, 0.0)):
                wave = lambda theta, m=order, by=phase: np.cos(m * theta + by)  # noqa: E731
                share = worst_change(claimed, wave) / claimed.expectation(wave).error_bound
                largest = max(largest, share)
    assert 0.95 < largest <= 1.0
