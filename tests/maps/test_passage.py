"""Passage times and hitting probabilities: known numbers, exact cases, Monte Carlo, very long passages."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import (
    CircleMap,
    WrappedCauchy,
    WrappedNormal,
    fixed_points,
    hitting_probability,
    mean_passage_time,
    transfer_operator,
)
from cyclemap.maps.passage import _Killed, _without_subtraction

TWO_PI = 2 * np.pi
STICKY = CircleMap.arnold(0.1, 0.9)
STABLE, UNSTABLE = (float(p.points[0]) for p in fixed_points(STICKY))


def test_the_known_passage_out_of_a_quarter_turn():
    noise = WrappedNormal(0.05 * TWO_PI)
    found = mean_passage_time(STICKY, noise, STABLE, (0.0, np.pi / 2))
    assert abs(found - 44.62425322366) < 1e-10
    assert found == transfer_operator(STICKY, noise).mean_passage_time(STABLE, (0.0, np.pi / 2))
    assert abs(mean_passage_time(STICKY, noise, STABLE + TWO_PI, (-TWO_PI, -1.5 * np.pi)) - found) < 1e-9


def test_a_sampled_map_gives_the_same_passage_to_its_own_error():
    x = np.linspace(0, TWO_PI, 300, endpoint=False)
    sampled = CircleMap.from_samples(x, STICKY(x), STICKY.derivative(x))
    found = mean_passage_time(sampled, WrappedNormal(0.05 * TWO_PI), STABLE, (0.0, np.pi / 2))
    assert abs(found - 44.62425322366) < 1e-6


def test_pure_noise_leaves_an_arc_as_fast_as_its_escape_chance_when_the_map_resets():
    """A map that sends everything to 0 makes the passage geometric: T = 1/P(ξ outside the arc)."""
    x = np.array([-1.5, 1.5, 1.5, TWO_PI - 1.5])
    reset = CircleMap.from_samples(x, [0, 0, 0, TWO_PI], [0, 0, 0, 0.0])
    for sigma in (0.5, 0.2, 0.05):
        noise = WrappedNormal(sigma)
        chance = noise.arc_probability(1.0, TWO_PI - 1.0)
        found = mean_passage_time(reset, noise, 0.0, (-1.0, 1.0))
        assert abs(found * chance - 1) < 1e-11


def test_passage_with_cauchy_noise_is_geometric_too():
    x = np.array([-1.5, 1.5, 1.5, TWO_PI - 1.5])
    reset = CircleMap.from_samples(x, [0, 0, 0, TWO_PI], [0, 0, 0, 0.0])
    noise = WrappedCauchy(0.8)
    found = mean_passage_time(reset, noise, 0.3, (-1.0, 1.0))
    assert abs(found * noise.arc_probability(1.0, TWO_PI - 1.0) - 1) < 1e-9


def test_monte_carlo_agrees():
    noise, rng = WrappedNormal(0.35), np.random.default_rng(8)
    arc = (STABLE - 0.8, STABLE + 1.1)
    theta, alive, lives = np.full(20_000, STABLE), np.ones(20_000, dtype=bool), np.zeros(20_000)
    while np.any(alive):
        lives[alive] += 1
        theta[alive] = STICKY(theta[alive]) + noise.sample(rng, int(alive.sum()))
        alive &= np.mod(theta - arc[0], TWO_PI) <= arc[1] - arc[0]
    found = mean_passage_time(STICKY, noise, STABLE, arc)
    assert abs(found - lives.mean()) < 5 * lives.std() / np.sqrt(lives.size)


def test_a_map_with_a_jump_inside_the_arc():
    down = CircleMap.from_samples([0, 2, 2, 4, 6], [0.7, 2.3, 1.6, 3.8, 6.5], [0.8] * 5)
    noise, rng = WrappedNormal(0.3), np.random.default_rng(9)
    theta, alive, lives = np.full(10_000, 1.0), np.ones(10_000, dtype=bool), np.zeros(10_000)
    while np.any(alive):
        lives[alive] += 1
        theta[alive] = down(theta[alive]) + noise.sample(rng, int(alive.sum()))
        alive &= np.mod(theta - 0.5, TWO_PI) <= 2.5
    found = mean_passage_time(down, noise, 1.0, (0.5, 3.0))
    assert abs(found - lives.mean()) < 5 * lives.std() / np.sqrt(lives.size)


def test_very_long_passages_grow_as_large_deviations_say():
    """σ² ln T tends to a constant barrier: successive slopes in 1/σ² agree, up to 1e98 cycles."""
    sigmas = np.array([0.14, 0.1, 0.07, 0.05])
    times = [mean_passage_time(STICKY, WrappedNormal(s), STABLE, (-3.9, UNSTABLE)) for s in sigmas]
    slopes = np.diff(np.log(times)) / np.diff(1 / sigmas**2)
    assert times[-1] > 1e98
    assert np.max(np.abs(slopes / slopes[-1] - 1)) < 0.02


def test_elimination_without_subtraction_is_exact_for_a_walk_with_tiny_escape():
    """A two-state chain that leaves with chance e = 1e-40 from its second state only."""
    e, q = 1e-40, np.array([[0.5, 0.5], [0.25, 0.75]])
    chain = _Killed(q, np.array([0.0, e]), np.ones(2))
    found = _without_subtraction(chain)
    # T1 = 2 + T2, and T2 = (1 + T1/4)/(1/4 + e), so T2 = 1.5/e.
    assert abs(found[1] * e / 1.5 - 1) < 1e-15


def test_blocks_change_nothing():
    rng = np.random.default_rng(2)
    q = rng.uniform(0, 1, (130, 130))
    q /= q.sum(axis=1, keepdims=True) * 1.01
    out = 1 - q.sum(axis=1)
    expected = np.linalg.solve(np.eye(130) - q, np.ones(130))
    np.testing.assert_allclose(_without_subtraction(_Killed(q, out, np.ones(130))), expected, rtol=1e-11)


def test_lifted_and_wrapped_passages_agree_when_no_step_is_a_turn_long():
    for arc in ((0.0, 1.5), (-2.0, 2.0)):
        plain = mean_passage_time(STICKY, WrappedNormal(0.25), STABLE, arc)
        lifted = mean_passage_time(STICKY, WrappedNormal(0.25), STABLE, arc, lifted=True)
        assert abs(plain / lifted - 1) < 1e-9


def test_a_larger_arc_is_left_later():
    noise, ends = WrappedNormal(0.3), (-0.5, -2.0, UNSTABLE - TWO_PI)
    times = [mean_passage_time(STICKY, noise, STABLE, (low, UNSTABLE), lifted=True) for low in ends]
    assert times[0] < times[1] < times[2]


def test_hitting_probabilities_add_to_one_and_are_symmetric():
    noise, a, b = WrappedNormal(0.3), (2.0, 2.6), (4.0, 5.0)
    for start in (0.1, 3.3, 5.5):
        one = hitting_probability(STICKY, noise, start, a, b)
        other = hitting_probability(STICKY, noise, start, b, a)
        assert 0 < one < 1
        assert abs(one + other - 1) < 1e-10
    still = CircleMap.rigid(0.0)
    assert abs(hitting_probability(still, noise, 0.0, (1, 2), (-2, -1)) - 0.5) < 1e-11
    assert hitting_probability(still, noise, 1.5, (1, 2), (-2, -1)) == 1.0
    assert hitting_probability(still, noise, -1.5, (1, 2), (-2, -1)) == 0.0


def test_hitting_probability_against_monte_carlo():
    noise, rng = WrappedNormal(0.4), np.random.default_rng(10)
    a, b = (2.2, 3.0), (5.0, 6.0)
    theta, won = np.full(20_000, STABLE), np.zeros(20_000)
    alive = np.ones(20_000, dtype=bool)
    while np.any(alive):
        theta[alive] = np.mod(STICKY(theta[alive]) + noise.sample(rng, int(alive.sum())), TWO_PI)
        in_a, in_b = (theta >= a[0]) & (theta <= a[1]), (theta >= b[0]) & (theta <= b[1])
        won[alive & in_a] = 1
        alive &= ~(in_a | in_b)
    found = transfer_operator(STICKY, noise).hitting_probability(STABLE, a, b)
    assert abs(found - won.mean()) < 5 * won.std() / np.sqrt(won.size)


@pytest.mark.parametrize("arc", [(0.0, 7.0), (1.0, 1.0), (0.0, TWO_PI), (0.0, np.nan), 3.0, (0, 1, 2)])
def test_arcs_outside_the_circle_are_refused(arc):
    with pytest.raises(InvalidInput):
        mean_passage_time(STICKY, WrappedNormal(0.3), 0.5, arc)


def test_both_ends_of_an_arc_belong_to_it():
    noise, checked = WrappedNormal(0.3), 0
    for start in np.random.default_rng(1).uniform(-7, 7, 40):
        arc = (start, start + 0.07)
        for end in arc:
            times = [mean_passage_time(STICKY, noise, end + shift, arc) for shift in (0.0, TWO_PI, -TWO_PI)]
            np.testing.assert_allclose(times, times[0], rtol=1e-10)
            checked += 1
    assert checked == 80


def test_other_bad_requests_are_refused():
    noise = WrappedNormal(0.3)
    with pytest.raises(InvalidInput, match="outside the arc"):
        mean_passage_time(STICKY, noise, 3.0, (0.0, 1.0))
    with pytest.raises(InvalidInput, match="overlap"):
        hitting_probability(STICKY, noise, 0.0, (1.0, 2.0), (1.5, 3.0))
    with pytest.raises(InvalidInput, match="raise its width"):
        mean_passage_time(STICKY, WrappedNormal(1e-4), STABLE, (0.0, 1.0))
