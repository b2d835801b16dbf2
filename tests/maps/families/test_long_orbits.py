"""Long orbits: diagrams, Birkhoff averages and Lyapunov exponents."""

from itertools import pairwise

import mpmath
import numpy as np
import pytest

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps import (
    CircleMap,
    ParametricLift,
    WrappedCauchy,
    WrappedNormal,
    birkhoff_average,
    lyapunov_exponent,
    lyapunov_exponents,
    orbit_diagram,
    periodic_orbits,
    rotation_number,
    saddle_nodes,
)
from tests.maps.known_maps import KNOWN_TURNS


@pytest.mark.slow
def test_an_attractor_is_followed_until_its_saddle_node_from_either_side():
    """Two wells, of which a tilt fills the shallow one first: it is seen only by a path that comes
    from within it.
    """

    def tilted(p):
        return CircleMap(lambda x: x + p - 0.1 * np.sin(x) - 0.3 * np.sin(2 * x))

    values = np.linspace(-0.2, 0.3, 51)
    up = orbit_diagram(tilted, values, cycles=1, transient=300, start=np.pi).theta[:, 0]
    down = orbit_diagram(tilted, values[::-1], cycles=1, transient=300, start=0.0).theta[::-1, 0]
    apart = np.abs(np.angle(np.exp(1j * (up - down)))) > 0.5
    [last] = np.flatnonzero(np.diff(apart))
    # Where the paths join, the shallow well ends in a saddle-node.
    nodes = [float(found.parameter) for found in saddle_nodes(tilted, (0.1, 0.3), resolution=4)]
    assert np.all(apart[: last + 1]) and any(
        values[last] < node < values[last + 1] for node in nodes
    )


def test_exponents_over_a_plane_are_those_of_one_map_at_a_time():
    omega, K = np.array([0.05, 0.1, 0.3]), np.array([0.5, 0.9])
    found = lyapunov_exponents(CircleMap.arnold, omega[:, None], K)
    assert found.value.shape == (3, 2)
    single = lyapunov_exponents(lambda a, b: CircleMap.arnold(a, b), omega[:, None], K)
    np.testing.assert_allclose(found.value, single.value, rtol=0, atol=1e-9)
    exact = np.array([[lyapunov_exponent(CircleMap.arnold(a, b)) for b in K] for a in omega])
    assert np.all(np.abs(found.value - exact) < 2e-3 + found.error)


def test_a_rotation_has_none_and_a_doubling_map_has_ln_2():
    turning = lyapunov_exponents(CircleMap.arnold, [0.1, 0.3], 0.0)
    assert np.all(turning.value == 0.0) and np.all(turning.error == 0.0)
    # The tent-like family x → x + s sin 2x has F'(0) = 1 + 2s: at rest on 0 the exponent is its
    # logarithm.
    family = ParametricLift(
        lambda x, s: x + s * np.sin(2 * x), lambda x, s: 1 + 2 * s * np.cos(2 * x)
    )
    at_rest = lyapunov_exponents(family, [-0.25, -0.5], start=0.0)
    np.testing.assert_allclose(at_rest.value[:1], np.log(0.5), rtol=1e-14)
    assert np.isneginf(at_rest.value[1]) and at_rest.error[1] == 0.0


TWO_PI = 2 * np.pi


@pytest.mark.slow
def test_four_standard_errors_of_chaotic_members_hold_their_exponents():
    """Blaschke products e^{i} z(z - a)/(1 - az) keep uniform measure: ∫ ln F' dθ/2π is known."""

    def product(a):
        return CircleMap(
            lambda x: 2 * x + 1 + 2 * np.arctan2(a * np.sin(x), 1 - a * np.cos(x)),
            lambda x: 1 + (1 - a * a) / (1 - 2 * a * np.cos(x) + a * a),
            degree=2,
        )

    values, grid = np.linspace(0.1, 0.6, 60), TWO_PI * np.arange(400) / 400
    known = [np.mean(np.log(product(a).derivative(grid))) for a in values]
    found = lyapunov_exponents(product, values)
    off = np.abs(found.value - known)
    assert np.mean(off <= found.error) >= 0.98
    # And a quarter of them does not hold most.
    assert np.mean(off <= 0.25 * found.error) < 0.8


@pytest.mark.parametrize(("circle_map", "turns"), KNOWN_TURNS)
def test_the_error_bound_holds_at_every_length_and_falls_faster_than_any_power(circle_map, turns):
    means = [
        birkhoff_average(circle_map, iterates=n, start=1.0) for n in (100, 300, 1000, 3000, 10000)
    ]
    errors = [abs(mean - TWO_PI * turns) for mean in means]
    bounds = [mean.error_bound for mean in means]
    assert all(error <= bound for error, bound in zip(errors, bounds, strict=True))
    assert errors[0] > 1e-9 and errors[-1] < 1e-14 and bounds[-1] < 1e-14
    # A hundred times better for three times the length, at least twice: faster than the fourth
    # power.
    steps = [a / max(b, 1e-16) for a, b in pairwise(bounds)]
    assert sum(step > 100 for step in steps) >= 2


@pytest.mark.parametrize(
    ("one_in", "a", "shortest"), [(10, 0.6, 960), (40, 0.6, 540), (60, 0.9, 420)]
)
def test_the_error_bound_holds_where_halves_of_the_orbit_happen_to_err_little(one_in, a, shortest):
    """Möbius maps of badly approximable rotation numbers near 1/10, 1/40, 1/60: the mean of e^{iθ} is
    their fixed point within the circle.
    """
    turns = 1.0 / (one_in + 0.5 * (np.sqrt(5.0) - 1.0))
    omega = np.arccos(np.sqrt(1.0 - a * a) * np.cos(np.pi * turns)) / np.pi
    turn = np.exp(2j * np.pi * omega)
    truth = min(np.roots([a, turn - 1.0, -turn * a]), key=abs).real
    circle_map = CircleMap.moebius(a, omega)
    for iterates in range(shortest, shortest + 20):
        mean = birkhoff_average(circle_map, np.cos, start=1.0, iterates=iterates)
        assert abs(mean - truth) <= mean.error_bound


@pytest.mark.parametrize("gap", [1e-12, 4e-11, 1e-9, 1e-7, 1e-5, 1e-3])
def test_the_exponent_of_a_bottleneck_is_zero_within_its_bound(gap):
    """A Möbius map outside its tongue is a rotation in other angles; through the narrowest of these
    bottlenecks an orbit takes more cycles than are followed.
    """
    omega = 0.3585962076586148
    found = lyapunov_exponent(
        CircleMap.moebius(np.sin(np.pi * omega) * (1.0 - gap), omega), start=1.0
    )
    assert found.holds(0.0)
    assert np.isfinite(found.error_bound) == (gap > 1e-10)


@pytest.mark.parametrize("gap", [1e-12, 1e-9, 1e-6])
def test_the_mean_turn_through_a_bottleneck_is_within_its_bound(gap):
    """The turns of a Möbius map outside its tongue are known; where no turn is ended within the orbit
    the rotation number is the middle of its bounds.
    """
    omega = 0.3
    a = np.sin(np.pi * omega) * (1.0 - gap)
    with mpmath.workdps(40):
        cosine = mpmath.cos(mpmath.pi * omega) / mpmath.sqrt(1 - mpmath.mpf(a) ** 2)
        truth = float(mpmath.acos(cosine) / mpmath.pi)
    found = rotation_number(CircleMap.moebius(a, omega))
    assert found.estimate.holds(truth) and found.lower <= truth <= found.upper
    assert abs(found.value - truth) <= 0.5 * (found.upper - found.lower)
    assert np.isfinite(found.estimate.error_bound) == (gap > 1e-8)


def test_the_mean_turn_of_a_slow_rotation_is_known_before_it_has_gone_round():
    mean = birkhoff_average(CircleMap.rigid(1e-6))
    assert mean.holds(2e-6 * np.pi) and mean.error_bound < 1e-14


@pytest.mark.parametrize(("period", "a"), [(7, 0.3), (15, 0.9)])
def test_orbits_that_nearly_close_are_told_apart_by_where_they_start(period, a):
    """Of a Möbius map that turns by 1/period + 1e-7 every exponent is zero, but forty thousand cycles
    see little but ``period`` points, others from each start.
    """
    turns = 1.0 / period + 1e-7
    omega = np.arccos(np.sqrt(1.0 - a * a) * np.cos(np.pi * turns)) / np.pi
    found = lyapunov_exponent(CircleMap.moebius(a, omega))
    assert found.holds(0.0) and found.error_bound < 1e-6


@pytest.mark.slow
def test_chaotic_orbits_have_a_bound_of_a_plain_means_size():
    """x → 3x (mod 2π): cos has mean 0 and variance 1/2; the bound is of the order of the sampling
    error.
    """
    tripling = CircleMap(lambda x: 3 * x, degree=3)
    held = 0
    for start in np.linspace(0.1, 6.0, 40):
        mean = birkhoff_average(tripling, np.cos, start=start, iterates=4000)
        held += abs(mean) <= 2 * mean.error_bound
        assert mean.error_bound < 0.2
    assert held >= 32


def test_known_exponents_under_noise():
    sticky = lyapunov_exponent(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.05 * TWO_PI))
    assert abs(sticky + 0.97812914157904) < 1e-13
    assert sticky.error_bound < 1e-12
    solvable = lyapunov_exponent(CircleMap.moebius(0.5, 0.3), WrappedCauchy(0.9))
    assert abs(solvable + 0.0285247244779752248) <= solvable.error_bound < 1e-12
    assert abs(solvable + 0.0285247244779752248) < 1e-14


def test_flat_pieces_and_superstable_orbits_give_minus_infinity():
    """x - sin x, the sine map of K = 1 at Ω = 0, holds 0, where its slope is 0."""
    flat = CircleMap.from_samples([0, 1, 2, 6], [1, 1, 1, 7.2], [0, 0, 0, 0.3])
    assert lyapunov_exponent(flat, WrappedNormal(0.3)) == lyapunov_exponent(flat) == -np.inf
    superstable = lyapunov_exponent(CircleMap.arnold(0.0, 1.0))
    mean = birkhoff_average(CircleMap.rigid(0.1), lambda x: np.full_like(x, -np.inf), iterates=16)
    for found in (superstable, mean):
        assert found == -np.inf and found.error_bound == 0.0


@pytest.mark.parametrize("strength", [0.5, 0.99, 0.9999, 1.0, 1.0001, 1.5, 3.0])
def test_near_critical_slopes_are_integrated_too(strength):
    """E ln|1 - K cos θ| under a uniform law is ln((1 + √(1 - K²))/2) up to K = 1 and ln(K/2) beyond
    (Jensen).
    """
    found = lyapunov_exponent(CircleMap.arnold(0.3, strength), WrappedNormal(8.0))
    known = np.log((1 + np.sqrt(1 - strength**2)) / 2) if strength <= 1 else np.log(strength / 2)
    assert abs(found - known) <= found.error_bound < (1e-6 if strength == 1.0 else 1e-11)


@pytest.mark.parametrize(
    ("omega", "strength", "period"),
    [
        (0.02, 0.9, 1),
        (0.9 / TWO_PI - 1e-6, 0.9, 1),
        (0.5, 0.9, 2),
        (0.34, 1.0, 3),
        (0.28, 1.0, 4),
        (0.41, 1.0, 5),
    ],
)
def test_stable_orbits_give_their_multiplier_whatever_their_period_and_however_slowly_they_attract(
    omega, strength, period
):
    sine = CircleMap.arnold(omega, strength)
    (stable,) = (orbit for orbit in periodic_orbits(sine, period) if orbit.stable)
    found = lyapunov_exponent(sine)
    assert abs(found - np.log(abs(stable.multiplier)) / period) <= found.error_bound + 1e-12
    assert found < 0 and found.error_bound < 1e-9


@pytest.mark.parametrize(
    ("omega", "strength", "period"),
    [(0.0, 30.0, 2), (0.7, 30.0, 3), (0.3, 90.0, 3), (0.1, 10.0, 4)],
)
def test_the_bound_holds_where_steep_images_magnify_the_rounding_of_an_orbit(
    omega, strength, period
):
    """Beside a superstable orbit, whose multiplier hangs on its last digits; against 50 digits."""
    fold = np.arccos(1.0 / strength)
    for _ in range(60):  # the shift for which the fold comes back to itself
        angle, by_shift = fold, 0.0
        for _ in range(period):
            by_shift = by_shift * (1.0 - strength * np.cos(angle)) + TWO_PI
            angle = angle + TWO_PI * omega - strength * np.sin(angle)
        omega -= np.angle(np.exp(1j * (angle - fold))) / by_shift
    omega += 1e-9 / strength ** (period - 1)
    found = lyapunov_exponent(CircleMap.arnold(omega, strength), start=fold)
    with mpmath.workdps(50):
        point = mpmath.mpf(fold)
        for _ in range(12):
            angle, slope = point, mpmath.mpf(1)
            for _ in range(period):
                slope *= 1 - mpmath.mpf(strength) * mpmath.cos(angle)
                angle += 2 * mpmath.pi * mpmath.mpf(omega) - strength * mpmath.sin(angle)
            off = angle - point
            off -= 2 * mpmath.pi * mpmath.nint(off / (2 * mpmath.pi))
            point -= off / (slope - 1)
        exact = mpmath.log(abs(slope)) / period
        assert abs(off) < 1e-40 and -15.0 < exact < -1.0
        assert abs(found - exact) <= found.error_bound < 1.0


def test_quasi_periodic_orbits_have_exponent_zero_within_the_bound():
    for sine in (CircleMap.arnold(0.6, 0.5), CircleMap.moebius(0.5, 0.3), CircleMap.rigid(0.1234)):
        found = lyapunov_exponent(sine)
        assert abs(found) <= found.error_bound + 1e-15
        assert found.error_bound < 1e-9


@pytest.mark.slow
def test_a_chaotic_orbit_has_a_statistical_bound():
    """The Blaschke product e^{i} z(z - a)/(1 - az) keeps uniform measure: its exponent is ∫ ln F'
    dθ/2π.
    """
    a = 0.4
    doubling = CircleMap(
        lambda x: 2 * x + 1 + 2 * np.arctan2(a * np.sin(x), 1 - a * np.cos(x)),
        lambda x: 1 + (1 - a * a) / (1 - 2 * a * np.cos(x) + a * a),
        degree=2,
    )
    grid = TWO_PI * np.arange(400) / 400
    known = np.mean(np.log(doubling.derivative(grid)))
    found = lyapunov_exponent(doubling)
    assert abs(found - known) <= found.error_bound
    assert 1e-4 < found.error_bound < 2e-2
    noisy = lyapunov_exponent(doubling, WrappedNormal(0.2))
    assert abs(noisy - known) <= noisy.error_bound < 1e-12


def test_the_maps_own_error_counts_through_the_law():
    """With max_error = ε the bound covers what a change of F by ε cos θ, its slope left alone,
    does.
    """
    sine, noise, epsilon = CircleMap.arnold(0.1, 0.9), WrappedNormal(0.3), 1e-6
    plain = lyapunov_exponent(sine, noise)
    claimed = lyapunov_exponent(CircleMap(sine, sine.derivative, max_error=epsilon), noise)
    shifted = lyapunov_exponent(
        CircleMap(lambda x: sine(x) + epsilon * np.cos(x), sine.derivative), noise
    )
    assert claimed == plain and plain.error_bound < 1e-12
    assert 1e-8 < abs(shifted - plain) <= claimed.error_bound <= 30 * abs(shifted - plain)


def test_a_repelling_orbit_is_not_taken_for_the_attractor():
    """θ = 0 is a fixed point of slope -1.5 with Ω = 0, K = 2.5: only a start there stays there."""
    sine = CircleMap.arnold(0.0, 2.5)
    (stable,) = (
        orbit for period in (1, 2) for orbit in periodic_orbits(sine, period) if orbit.stable
    )
    found = lyapunov_exponent(sine)
    assert abs(found - np.log(abs(stable.multiplier)) / stable.period) <= found.error_bound + 1e-12
    assert abs(lyapunov_exponent(sine, start=0.0) - np.log(1.5)) < 1e-14
    assert lyapunov_exponent(sine, start=0.3, transient=10_000) == pytest.approx(found, abs=1e-12)


@pytest.mark.slow
def test_several_attractors_are_said():
    """Two stable points with slopes 0.2 and 0.6: each from its own side."""
    two = CircleMap(
        lambda x: x - 0.3 * np.sin(2 * x) - 0.2 * np.sin(x),
        lambda x: 1 - 0.6 * np.cos(2 * x) - 0.2 * np.cos(x),
    )
    with pytest.raises(
        InvalidInput, match=r"several attractors: .*-1\.6\d+ .*-0\.5\d+ .*give the start"
    ):
        lyapunov_exponent(two)
    assert abs(lyapunov_exponent(two, start=0.1) - np.log(0.2)) < 1e-12
    assert abs(lyapunov_exponent(two, start=3.0) - np.log(0.6)) < 1e-12


@pytest.mark.slow
def test_the_error_of_differences_is_in_the_bound():
    """The sine map without its derivative; and a constant, whose exponent is -∞."""
    constant = lyapunov_exponent(CircleMap(lambda x: 0 * x + 1.0, degree=0))
    assert constant == float("-inf")
    nearly = lyapunov_exponent(CircleMap(lambda x: 1.0 + 1e-13 * np.sin(x), degree=0))
    assert nearly.holds(np.log(1e-13 * np.cos(1.0)))
    for omega, strength in ((0.1, 0.9), (0.6, 0.5), (0.5, 0.99), (0.0, 1.000001)):
        exact = CircleMap.arnold(omega, strength)
        found, known = lyapunov_exponent(CircleMap(exact)), lyapunov_exponent(exact)
        assert abs(found - known) <= found.error_bound + known.error_bound
        noisy, truth = (
            lyapunov_exponent(one, WrappedNormal(0.3)) for one in (CircleMap(exact), exact)
        )
        assert (
            abs(noisy - truth) <= noisy.error_bound + truth.error_bound and noisy.error_bound < 1e-3
        )


def test_a_lift_that_is_nowhere_smooth_is_refused_before_its_orbits_are_made():
    """Weierstrass's sum with ab > 1 has a derivative nowhere,
    and few of its values tell as much."""
    asked = []

    def rough(theta):
        asked.append(np.size(theta))
        return theta + 0.3 + 0.5 * sum(0.5**k * np.cos(3.0**k * theta) for k in range(20))

    for noise in (None, WrappedNormal(0.1)):
        with pytest.raises(
            ConvergenceError, match=r"cannot be told from differences .* give the derivative"
        ):
            lyapunov_exponent(CircleMap(rough), noise)
    assert sum(asked) < 40_000
