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


def differences(number, p, step):
    """dn/dp by central differences of fourth order, and twice what a step twice as wide changes."""
    near, far = (
        (number(p - 2 * h) - 8 * number(p - h) + 8 * number(p + h) - number(p + 2 * h)) / (12 * h)
        for h in (step, 2 * step)
    )
    return near, 2 * abs(near - far)


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
    assert (
        found.rotation_number.holds(1 - K / TWO_PI * first.imag)
        and found.rotation_number.error_bound < 1e-9
    )
    theta = np.linspace(0.0, 6.0, 9)
    shape = (
        sum(np.exp(1j * k * theta) * part for k, part in zip(m[rest], moved, strict=True)).real
        / TWO_PI
    )
    assert np.max(np.abs(found.density(theta) - shape)) < 1e-9


def test_the_stable_direction_moves_as_its_closed_form():
    ((theta, speed),) = response(sine, 0.1, WrappedNormal(SIGMA), (0.0, 0.2)).stable_points
    assert abs(np.sin(theta) - TWO_PI * 0.1 / K) < 1e-12
    assert speed.holds(TWO_PI / (K * np.cos(theta))) and speed.error_bound < 1e-8


@pytest.mark.parametrize(
    ("sigma", "arc", "lifted"),
    [(0.3, (0.0, 1.6), False), (0.3, (-3.0, 3.0), True), (0.15, (-1.0, 2.3), False)],
)
def test_passage_times_move_as_their_differences(sigma, arc, lifted):
    noise = WrappedNormal(sigma)
    found = response(sine, 0.1, noise, (0.0, 0.2)).mean_passage_time(0.77, arc, lifted=lifted)
    fair, doubt = differences(
        lambda p: float(mean_passage_time(sine(p), noise, 0.77, arc, lifted=lifted)), 0.1, 2e-5
    )
    assert abs(found - fair) <= found.error_bound + doubt
    assert found.error_bound < 1e-8 * abs(found) and doubt < 1e-5 * abs(found)


@pytest.mark.parametrize("height", [1.0, -1.0])
@pytest.mark.parametrize(("arc", "lifted"), [((0.0, 2.0), False), ((-0.5, 3.0), True)])
@pytest.mark.parametrize("place", [lambda p: p, lambda p: 2.0 - p, lambda p: p**3])
def test_passage_times_move_as_their_differences_where_a_jump_moves(height, arc, lifted, place):
    family, noise = sawtooth(height, place), WrappedNormal(0.5)
    for start in (0.7, 1.4):
        answer = response(family, 1.0, noise, (0.0, 2.0))
        found = answer.mean_passage_time(start, arc, lifted=lifted)
        fair, doubt = differences(
            lambda p, s=start: float(mean_passage_time(family(p), noise, s, arc, lifted=lifted)),
            1.0,
            2e-4,
        )
        assert abs(found - fair) <= found.error_bound + doubt
        assert max(found.error_bound, doubt) < 1e-4 * abs(found)


def test_windings_move_as_their_differences_where_a_jump_moves_unevenly():
    family, noise = sawtooth(1.0, lambda p: p**3), WrappedNormal(0.5)
    found = response(family, 1.0, noise, (0.0, 2.0)).rotation_number
    fair, doubt = differences(
        lambda p: float(transfer_operator(family(p), noise).rotation_number), 1.0, 2e-4
    )
    assert abs(found - fair) <= found.error_bound + doubt
    assert found.error_bound < 1e-10 and doubt < 1e-10


def test_a_jump_that_moves_is_refused_at_the_start_and_at_an_end_of_the_arc():
    answer = response(sawtooth(1.0, lambda p: p), 1.0, WrappedNormal(0.5), (0.0, 2.0))
    for start, arc in ((1.0, (0.0, 2.0)), (0.5, (0.0, 1.0)), (1.5, (1.0, 2.0))):
        refused(answer.mean_passage_time, start, arc, told="a jump that moves .* is at 1")
    still = response(sawtooth(1.0, lambda p: 1.0), 1.0, WrappedNormal(0.5), (0.0, 2.0))
    assert still.mean_passage_time(1.0, (0.0, 2.0)).holds(0.0)


def test_windings_of_random_families_move_as_their_differences_and_where_a_jump_wanders():
    rng, noise = np.random.default_rng(11), WrappedNormal(0.5)

    def random_family():
        size, phase, push = (
            rng.uniform(-0.3, 0.3, 3),
            rng.uniform(0, TWO_PI, 3),
            rng.uniform(-1, 1, 3),
        )
        order = np.arange(1, 4)

        def family(p):
            return CircleMap(
                lambda x: (
                    x
                    + p
                    + np.sum((size + p * push) * np.sin(np.multiply.outer(x, order) + phase), -1)
                ),
                lambda x: (
                    1
                    + np.sum(
                        (size + p * push) * order * np.cos(np.multiply.outer(x, order) + phase), -1
                    )
                ),
            )

        return family

    families = [(random_family(), 0.1, (-0.5, 0.7)) for _ in range(8)] + [
        (wandering_jump, 2.5, (2.0, 3.0))
    ]
    for family, p, ends in families:
        found = response(family, p, noise, ends).rotation_number
        fair, doubt = differences(
            lambda v, f=family: float(transfer_operator(f(v), noise).rotation_number), p, 1e-3
        )
        assert abs(found - fair) <= found.error_bound + doubt
        assert found.error_bound < 1e-6 and doubt < 1e-6


def test_families_known_to_an_error_only_answer_within_their_bounds():
    """Every map of the family off by so much, each in its own way: the bounds hold the exact one's
    answers.
    """
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
    refused(response, sine, 0.3, WrappedNormal(SIGMA), (0.0, 0.2), told="outside the parameters")
    refused(response, sine, 0.1, UniformNoise(1.0), (0.0, 0.2), told="smooth density")
    waves = response(sine, 0.1, WrappedNormal(SIGMA), (0.0, 0.2))
    refused(waves.expectation, 3, told="function is 3")
    refused(waves.expectation, lambda theta: theta[:3], told="entry by entry")
    refused(response, CircleMap, 0.1, WrappedNormal(SIGMA), (0.0, 0.2), told="callable")
