"""Derivatives of a noisy family's law, winding, directions and passages by its parameter."""

import numpy as np
import pytest
from refusals import refused
from scipy.special import jv

from cyclemap.maps import (
    CircleMap,
    UniformNoise,
    WrappedNormal,
    mean_passage_time,
    response,
    transfer_operator,
)

TWO_PI = 2 * np.pi
SIGMA, K = 0.3, 0.9


def sine(omega):
    return CircleMap.arnold(omega, K)


def wandering_jump(place):
    """Slopes of a half, with a jump up by 1 at ``place``."""
    x = np.array([0.0, place, place, TWO_PI])
    return CircleMap.from_samples(
        x, [0.3, 0.3 + 0.5 * place, 1.3 + 0.5 * place, 0.3 + TWO_PI], [0.5] * 4
    )


def sawtooth(height, place):
    """p → slopes around a jump up by -``height`` at ``place(p)``."""

    def family(p):
        def lift(x):
            return x + 0.1 + height * (np.mod(x - place(p), TWO_PI) / TWO_PI - 0.5)

        return CircleMap(lift, breaks=[place(p)])

    return family


def assert_moves(found, number, p, step):
    """Against central differences of fourth order, with twice what a step twice as wide changes."""
    near, far = (
        (number(p - 2 * h) - 8 * number(p - h) + 8 * number(p + h) - number(p + 2 * h)) / (12 * h)
        for h in (step, 2 * step)
    )
    doubt = 2 * abs(near - far)
    assert abs(found - near) <= found.error_bound + doubt
    return max(found.error_bound, doubt)


def test_moments_and_winding_of_the_sine_family_move_as_its_bessel_operator_tells():
    """L_mk = κ_m e^{-2πimΩ} J_{m-k}(mK): p' solves (I - L) p' = L' p with L' = -2πim L."""
    omega, m = 0.1, np.arange(-40, 41)
    rows = np.exp(-0.5 * (m * SIGMA) ** 2 - 2j * np.pi * m * omega)
    operator = rows[:, None] * jv(m[:, None] - m, m[:, None] * K)
    rest = np.delete(np.arange(m.size), 40)
    law = np.zeros(m.size, dtype=complex)
    law[40] = 1.0
    inner = np.eye(80) - operator[np.ix_(rest, rest)]
    law[rest] = np.linalg.solve(inner, operator[rest, 40])
    moved = np.linalg.solve(inner, (-2j * np.pi * m[:, None] * operator @ law[:, None])[rest, 0])
    first = np.conj(moved[rest == 41][0])  # E e^{iθ}
    found = response(sine, omega, WrappedNormal(SIGMA), (0.0, 0.2))
    for function, truth in ((np.cos, first.real), (np.sin, first.imag)):
        value = found.expectation(function)
        assert value.holds(truth) and value.error_bound < 1e-8
    assert found.rotation_number.holds(1 - K / TWO_PI * first.imag)
    assert found.rotation_number.error_bound < 1e-9
    theta = np.linspace(0.0, 6.0, 9)
    shape = (np.exp(1j * np.multiply.outer(theta, m[rest])) @ moved).real / TWO_PI
    assert np.max(np.abs(found.density(theta) - shape)) < 1e-9
    ((theta, speed),) = found.stable_points
    assert abs(np.sin(theta) - TWO_PI * 0.1 / K) < 1e-12
    assert speed.holds(TWO_PI / (K * np.cos(theta))) and speed.error_bound < 1e-8


@pytest.mark.parametrize(
    ("sigma", "arc", "lifted"),
    [(0.3, (0.0, 1.6), False), (0.3, (-3.0, 3.0), True), (0.15, (-1.0, 2.3), False)],
)
def test_passage_times_move_as_their_differences(sigma, arc, lifted):
    noise = WrappedNormal(sigma)

    def time(p):
        return float(mean_passage_time(sine(p), noise, 0.77, arc, lifted=lifted))

    found = response(sine, 0.1, noise, (0.0, 0.2)).mean_passage_time(0.77, arc, lifted=lifted)
    assert assert_moves(found, time, 0.1, 2e-5) < 1e-5 * abs(found)
    assert found.error_bound < 1e-8 * abs(found)


@pytest.mark.parametrize(
    ("height", "arc", "lifted", "place"),
    [
        (1.0, (0.0, 2.0), False, lambda p: p),
        (-1.0, (-0.5, 3.0), True, lambda p: 2.0 - p),
        (-1.0, (0.0, 2.0), False, lambda p: p**3),
        (1.0, (-0.5, 3.0), True, lambda p: p**3),
    ],
)
def test_passage_times_move_as_their_differences_where_a_jump_moves(height, arc, lifted, place):
    family, noise = sawtooth(height, place), WrappedNormal(0.5)
    for start in (0.7, 1.4):

        def time(p, start=start):
            return float(mean_passage_time(family(p), noise, start, arc, lifted=lifted))

        answer = response(family, 1.0, noise, (0.0, 2.0))
        found = answer.mean_passage_time(start, arc, lifted=lifted)
        assert assert_moves(found, time, 1.0, 2e-4) < 1e-4 * abs(found)


def test_a_jump_that_moves_is_refused_at_the_start_and_at_an_end_of_the_arc():
    answer = response(sawtooth(1.0, lambda p: p), 1.0, WrappedNormal(0.5), (0.0, 2.0))
    for start, arc in ((1.0, (0.0, 2.0)), (0.5, (0.0, 1.0)), (1.5, (1.0, 2.0))):
        refused(answer.mean_passage_time, start, arc, told="a jump that moves .* is at 1")
    still = response(sawtooth(1.0, lambda p: 1.0), 1.0, WrappedNormal(0.5), (0.0, 2.0))
    assert still.mean_passage_time(1.0, (0.0, 2.0)).holds(0.0)


def random_family(rng):
    size, phase = rng.uniform(-0.3, 0.3, 3), rng.uniform(0, TWO_PI, 3)
    push, order = rng.uniform(-1, 1, 3), np.arange(1, 4)

    def family(p):
        waves = size + p * push

        def lift(x):
            return x + p + np.sum(waves * np.sin(np.multiply.outer(x, order) + phase), -1)

        def slope(x):
            return 1 + np.sum(waves * order * np.cos(np.multiply.outer(x, order) + phase), -1)

        return CircleMap(lift, slope)

    return family


def test_windings_move_as_their_differences_for_random_families_and_where_a_jump_wanders():
    rng, noise = np.random.default_rng(11), WrappedNormal(0.5)
    cases = [(random_family(rng), 0.1, (-0.5, 0.7)) for _ in range(4)]
    cases += [(wandering_jump, 2.5, (2.0, 3.0)), (sawtooth(1.0, lambda p: p**3), 1.0, (0.0, 2.0))]
    for family, p, ends in cases:

        def winding(value, family=family):
            return float(transfer_operator(family(value), noise).rotation_number)

        found = response(family, p, noise, ends).rotation_number
        assert assert_moves(found, winding, p, 1e-3) < 1e-6


def test_families_known_to_an_error_only_answer_within_their_bounds():
    """Every map of the family is off by so much, each in its own way."""
    rng, noise, off, within = np.random.default_rng(3), WrappedNormal(SIGMA), 1e-6, (0.0, 0.2)

    def nearly(omega):
        phase = rng.uniform(0.0, TWO_PI)
        return CircleMap(lambda x: sine(omega)(x) + off * np.sin(x + phase), max_error=off)

    exact, found = (response(family, 0.1, noise, within) for family in (sine, nearly))
    pairs = [(exact.rotation_number, found.rotation_number)]
    pairs += [(exact.expectation(f), found.expectation(f)) for f in (np.cos, np.sin)]
    pairs += [(exact.stable_points[0][1], found.stable_points[0][1])]
    times = [answer.mean_passage_time(0.77, (0.0, 1.6)) for answer in (exact, found)]
    for truth, value in [*pairs, times]:
        assert value.holds(float(truth))
        assert 1e3 * truth.error_bound < value.error_bound < 0.05 * (1.0 + abs(truth))
    assert max(abs(value - truth) / value.error_bound for truth, value in pairs) > 0.05


def test_what_has_no_response_is_refused():
    normal = WrappedNormal(SIGMA)
    for family, at, noise, told in (
        (sine, 0.3, normal, "outside the parameters"),
        (sine, 0.1, UniformNoise(1.0), "smooth density"),
        (CircleMap, 0.1, normal, "callable"),
    ):
        refused(response, family, at, noise, (0.0, 0.2), told=told)
    waves = response(sine, 0.1, normal, (0.0, 0.2))
    refused(waves.expectation, 3, told="function is 3")
    refused(waves.expectation, lambda theta: theta[:3], told="entry by entry")
