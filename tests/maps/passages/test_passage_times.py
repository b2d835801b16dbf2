"""Passage times and hitting probabilities, their bounds and their derivatives."""

from fractions import Fraction

import numpy as np
import pytest

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps import (
    CircleMap,
    Estimate,
    UniformNoise,
    VonMises,
    WrappedCauchy,
    WrappedNormal,
    fixed_points,
    hitting_probability,
    mean_passage_time,
    passage_response,
    transfer_operator,
)
from cyclemap.maps.passages.killed_chain import arc_chain, eliminated

TWO_PI = 2 * np.pi
STICKY = CircleMap.arnold(0.1, 0.9)
STABLE, UNSTABLE = (float(p.points[0]) for p in fixed_points(STICKY))
KNOWN = 44.62425322366


def two_wells():
    """Stable points near 0.1 and near π, the first much deeper."""
    return CircleMap(
        lambda x: x + 0.05 - 0.4 * np.sin(2 * x) + 0.1 * np.cos(x), lambda x: 1 - 0.8 * np.cos(2 * x) - 0.1 * np.sin(x)
    )


def simulated_lives(circle_map, noise, start, inside, paths, seed):
    """Cycles until ``inside`` first fails, for many paths."""
    rng = np.random.default_rng(seed)
    theta, lives = np.full(paths, start), np.zeros(paths)
    alive = np.arange(paths)
    while alive.size:
        theta = circle_map(theta) + noise.sample(rng, alive.size)
        lives[alive] += 1
        stays = inside(theta)
        theta, alive = theta[stays], alive[stays]
    return lives


def test_the_known_passage_out_of_a_quarter_turn():
    noise = WrappedNormal(0.05 * TWO_PI)
    found = mean_passage_time(STICKY, noise, STABLE, (0.0, np.pi / 2))
    assert isinstance(found, Estimate)
    assert abs(found - KNOWN) < found.error_bound + 5e-12  # all the digits that are known
    assert found.error_bound < 1e-12
    assert found == transfer_operator(STICKY, noise).mean_passage_time(STABLE, (0.0, np.pi / 2))
    moved = mean_passage_time(STICKY, noise, STABLE + TWO_PI, (-TWO_PI, -1.5 * np.pi))
    assert abs(moved - found) < moved.error_bound + found.error_bound


def test_a_sampled_map_gives_the_same_passage_to_its_own_error_and_its_bound_says_so():
    x = np.linspace(0, TWO_PI, 300, endpoint=False)
    sampled = CircleMap.from_samples(x, STICKY(x), STICKY.derivative(x), max_error=5e-10)
    dense = np.linspace(0, TWO_PI, 9_001)
    assert np.max(np.abs(sampled(dense) - STICKY(dense))) < 5e-10
    for sigma in (0.05 * TWO_PI, 0.1):
        exact = mean_passage_time(STICKY, WrappedNormal(sigma), STABLE, (0.0, np.pi / 2))
        found = mean_passage_time(sampled, WrappedNormal(sigma), STABLE, (0.0, np.pi / 2))
        assert abs(found - exact) < found.error_bound < 1e-5 * exact
        assert found.error_bound < 1_000 * abs(found - exact)


def test_pure_noise_leaves_an_arc_as_fast_as_its_escape_chance_when_the_map_resets():
    """A map that sends everything to 0 makes the passage geometric: T = 1/P(ξ outside the arc)."""
    x = np.array([-1.5, 1.5, 1.5, TWO_PI - 1.5])
    reset = CircleMap.from_samples(x, [0, 0, 0, TWO_PI], [0, 0, 0, 0.0])
    laws = WrappedNormal(0.5), WrappedNormal(0.2), WrappedNormal(0.05), WrappedCauchy(0.8), VonMises(40.0)
    for noise in laws:
        exact = 1 / noise.arc_probability(1.0, TWO_PI - 1.0)
        found = mean_passage_time(reset, noise, 0.0, (-1.0, 1.0))
        assert abs(found - exact) <= found.error_bound < 1e-11 * exact


def test_bounds_hold_and_are_near_the_truth_while_nodes_are_too_few():
    """On nodes too few by far the bound of the discretisation still holds, and is not far above the error."""
    judged, cases = 0, ((WrappedNormal(0.1), 1.57), (WrappedCauchy(0.8), 2.0), (VonMises(20), 2.0))
    for law, end in cases:
        arc = (0.0, end)
        exact = mean_passage_time(STICKY, law, STABLE, arc)
        for stretch in (0.2, 0.25, 0.3, 0.35, 0.4):
            chain = arc_chain(STICKY, law, arc, False, every_sample=False, stretch=stretch)
            rough = chain.expected(1.0, np.zeros(1))
            error, bound = abs(rough.value_at(STABLE) - exact), rough.error_bounds(STABLE)[0]
            assert error <= bound + exact.error_bound
            if error > 1e-12 * exact:
                assert bound < 100 * error
                judged += 1
    assert judged >= 6


def test_bounds_hold_among_solutions_on_different_nodes():
    """Where the error is rounding alone, two solutions differ by less than both bounds, up to 1e98 cycles."""
    for sigma in (0.3, 0.1, 0.05):
        ends = (UNSTABLE - TWO_PI, UNSTABLE)
        one = mean_passage_time(STICKY, WrappedNormal(sigma), STABLE, ends, lifted=True)
        chain = arc_chain(STICKY, WrappedNormal(sigma), ends, True, stretch=1.4)
        other = chain.expected(1.0, np.zeros(2)).value_at(STABLE)
        assert abs(one - other) < one.error_bound < 1e-11 * one


def test_monte_carlo_agrees():
    noise, arc = WrappedNormal(0.35), (STABLE - 0.8, STABLE + 1.1)
    inside = lambda theta: np.mod(theta - arc[0], TWO_PI) <= arc[1] - arc[0]  # noqa: E731
    lives = simulated_lives(STICKY, noise, STABLE, inside, 100_000, 8)
    found = mean_passage_time(STICKY, noise, STABLE, arc)
    assert abs(found - lives.mean()) < 4 * lives.std() / np.sqrt(lives.size)


@pytest.mark.slow
def test_a_map_with_a_jump_inside_the_arc():
    down = CircleMap.from_samples([0, 2, 2, 4, 6], [0.7, 2.3, 1.6, 3.8, 6.5], [0.8] * 5)
    noise = WrappedNormal(0.3)
    lives = simulated_lives(down, noise, 1.0, lambda theta: np.mod(theta - 0.5, TWO_PI) <= 2.5, 40_000, 9)
    found = mean_passage_time(down, noise, 1.0, (0.5, 3.0))
    assert abs(found - lives.mean()) < 4 * lives.std() / np.sqrt(lives.size)
    assert found.error_bound < 1e-11 * found


def test_very_long_passages_grow_as_large_deviations_say():
    """σ² ln T tends to a constant barrier: successive slopes in 1/σ² agree, up to 1e98 cycles."""
    sigmas = np.array([0.14, 0.1, 0.07, 0.05])
    times = [mean_passage_time(STICKY, WrappedNormal(s), STABLE, (-3.9, UNSTABLE), lifted=True) for s in sigmas]
    slopes = np.diff(np.log(times)) / np.diff(1 / sigmas**2)
    assert times[-1] > 1e98
    assert np.max(np.abs(slopes / slopes[-1] - 1)) < 0.02


def test_a_passage_beyond_all_floats_is_inf_and_says_that_nothing_is_known():
    found = mean_passage_time(STICKY, WrappedNormal(0.025), STABLE, (UNSTABLE - 4, UNSTABLE), lifted=True)
    assert found == np.inf and found.error_bound == np.inf


def test_two_deep_wells_in_one_arc_keep_their_digits():
    """From either well the path falls into the deeper one first, unless it escapes: times agree, digits stay."""
    ends, noise = (-1.5, 4.7), WrappedNormal(0.1)
    times = [mean_passage_time(two_wells(), noise, start, ends, lifted=True) for start in (0.1, np.pi)]
    assert times[0] > 1e35 and times[0].error_bound < 1e-11 * times[0]
    assert abs(times[1] / times[0] - 1) < 1e-12


def test_elimination_without_subtraction_is_exact_for_a_walk_with_tiny_escape():
    """A two-state chain that leaves with chance e = 1e-40 from its second state only."""
    e, q = 1e-40, np.array([[0.5, 0.5], [0.25, 0.75]])
    chain = eliminated(q, np.array([0.0, e]))
    # T1 = 2 + T2, and T2 = (1 + T1/4)/(1/4 + e), so T2 = 1.5/e.
    assert abs(chain.solve(np.ones(2))[1] * e / 1.5 - 1) < 1e-15
    values, top, change = chain.expected(np.ones(2))
    assert top == values[1] and change[1] == 0
    assert abs(change[0] - 2) < 1e-15  # T1 - T2, forty digits below T2


def test_elimination_agrees_with_plain_solutions_from_both_sides_and_blocks_change_nothing():
    rng = np.random.default_rng(2)
    q = rng.uniform(0, 1, (130, 130))
    q /= q.sum(axis=1, keepdims=True) * 1.01
    chain, plain = eliminated(q, 1 - q.sum(axis=1)), np.eye(130) - q
    reward = rng.uniform(0, 1, 130)
    np.testing.assert_allclose(chain.solve(reward), np.linalg.solve(plain, reward), rtol=1e-11)
    np.testing.assert_allclose(chain.visits(reward), np.linalg.solve(plain.T, reward), rtol=1e-11)
    closed = q / q.sum(axis=1, keepdims=True)
    law = eliminated(closed, np.zeros(130)).stationary()
    assert abs(law.sum() - 1) < 1e-14
    np.testing.assert_allclose(law @ closed, law, rtol=1e-12)


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
        assert abs(one + other - 1) <= one.error_bound + other.error_bound + 2e-16 < 1e-12
    still = CircleMap.rigid(0.0)
    assert hitting_probability(still, noise, 0.0, (1, 2), (-2, -1)).holds(0.5)
    for start, answer in ((1.5, 1.0), (-1.5, 0.0)):
        known = hitting_probability(still, noise, start, (1, 2), (-2, -1))
        assert known == answer and known.error_bound == 0


@pytest.mark.slow
def test_hitting_probability_against_monte_carlo():
    noise, rng, paths = WrappedNormal(0.4), np.random.default_rng(10), 100_000
    a, b = (2.2, 3.0), (5.0, 6.0)
    theta, won = np.full(paths, STABLE), 0
    while theta.size:
        theta = np.mod(STICKY(theta) + noise.sample(rng, theta.size), TWO_PI)
        in_a, in_b = (theta >= a[0]) & (theta <= a[1]), (theta >= b[0]) & (theta <= b[1])
        won += int(in_a.sum())
        theta = theta[~(in_a | in_b)]
    found = transfer_operator(STICKY, noise).hitting_probability(STABLE, a, b)
    assert abs(found - won / paths) < 4 * np.sqrt(found * (1 - found) / paths)


@pytest.mark.slow
def test_tiny_hitting_probabilities_keep_their_digits():
    """Reaching the far well before slipping home: the two chances have a ratio of 1e-14 and sum to 1."""
    noise, a, b = WrappedNormal(0.08), (1.2, 1.5), (1.9, 2.0)
    rare = hitting_probability(two_wells(), noise, np.pi + 0.3, a, b)
    assert 1e-16 < rare < 1e-12
    assert rare.error_bound < 1e-11 * rare
    assert hitting_probability(two_wells(), noise, np.pi + 0.3, b, a).holds(1.0)


@pytest.mark.parametrize("arc", [(0.0, 7.0), (1.0, 1.0), (0.0, TWO_PI), (0.0, np.nan), 3.0, (0, 1, 2)])
def test_arcs_outside_the_circle_are_refused(arc):
    with pytest.raises(InvalidInput, match="arc"):
        mean_passage_time(STICKY, WrappedNormal(0.3), 0.5, arc)


def test_both_ends_of_an_arc_belong_to_it():
    noise, checked = WrappedNormal(0.3), 0
    for start in np.random.default_rng(1).uniform(-7, 7, 8):
        arc = (start, start + 0.07)
        for end in arc:
            times = [mean_passage_time(STICKY, noise, end + shift, arc) for shift in (0.0, TWO_PI, -TWO_PI)]
            np.testing.assert_allclose(times, times[0], rtol=1e-10)
            checked += 1
    assert checked == 16


@pytest.mark.slow
@pytest.mark.parametrize("noise", [WrappedNormal(0.3), WrappedNormal(0.1), UniformNoise(0.4)])
def test_chances_next_to_one_and_their_complements_add_up_to_one_within_their_bounds(noise):
    near, far = (-0.3, 0.3), (3.0, 3.2)
    for start in np.linspace(1.2, 2.8, 7):
        one = hitting_probability(CircleMap.arnold(0.0, 0.9), noise, start, near, far)
        other = hitting_probability(CircleMap.arnold(0.0, 0.9), noise, start, far, near)
        gap = abs(Fraction(float(one)) + Fraction(float(other)) - 1)
        assert gap <= Fraction(one.error_bound) + Fraction(other.error_bound)
        assert one.error_bound < 1e-11 and 0.0 <= one <= 1.0


def test_other_bad_requests_are_refused():
    noise = WrappedNormal(0.3)
    with pytest.raises(InvalidInput, match="outside the arc"):
        mean_passage_time(STICKY, noise, 3.0, (0.0, 1.0))
    with pytest.raises(InvalidInput, match="overlap"):
        hitting_probability(STICKY, noise, 0.0, (1.0, 2.0), (1.5, 3.0))
    with pytest.raises(InvalidInput, match="raise its width"):
        mean_passage_time(STICKY, WrappedNormal(1e-4), STABLE, (0.0, 1.0))
    with pytest.raises(InvalidInput, match="the noise is None"):
        mean_passage_time(STICKY, None, 0.5, (0.0, 1.0))
    with pytest.raises(InvalidInput, match="start"):
        mean_passage_time(STICKY, noise, np.nan, (0.0, 1.0))


def test_a_map_with_a_jump_that_it_hides_is_not_certified():
    def jumping(breaks):
        return CircleMap(lambda x: x + 0.05 + 0.2 * np.floor((np.mod(x, TWO_PI) - 0.5) / TWO_PI), np.ones_like, breaks)

    with pytest.raises(ConvergenceError, match="give the map's breaks"):
        mean_passage_time(jumping(()), WrappedNormal(0.2), 0.5, (0.0, 1.0))
    found = mean_passage_time(jumping((0.0, 0.5)), WrappedNormal(0.2), 0.5, (0.0, 1.0))
    assert found.error_bound < 1e-12


def tangent(theta):
    """∂F/∂K of the sine map."""
    return -np.sin(theta)


def slope(function, step=1e-5):
    """Central difference of fourth order."""
    ends = 8 * (function(step) - function(-step)) - (function(2 * step) - function(-2 * step))
    return float(ends / (12 * step))


def altered(noise, change):
    return type(noise)(next(iter(vars(noise).values())) + change)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("noise", "lifted"),
    [(WrappedNormal(0.3), False), (WrappedCauchy(0.9), False), (WrappedCauchy(0.9), True), (VonMises(20.0), True)],
)
def test_every_derivative_of_the_passage_agrees_with_differences(noise, lifted):
    start, low, high = 0.77, 0.0, 1.6

    def time(strength=0.0, noisier=0.0, moved=0.0, below=0.0, above=0.0):
        one = CircleMap.arnold(0.1, 0.9 + strength)
        return float(
            mean_passage_time(one, altered(noise, noisier), start + moved, (low + below, high + above), lifted=lifted)
        )

    found = passage_response(STICKY, noise, start, (low, high), tangent, lifted=lifted)
    assert abs(found.time - time()) < 1e-12 * time()
    pairs = [
        (found.to_map, slope(lambda h: time(strength=h))),
        (found.to_noise, slope(lambda h: time(noisier=h))),
        (found.to_start, slope(lambda h: time(moved=h))),
        (found.to_arc_start, slope(lambda h: time(below=h))),
        (found.to_arc_end, slope(lambda h: time(above=h))),
    ]
    for exact, difference in pairs:
        assert abs(exact - difference) < 1e-8 * abs(exact) + 1e-9
        assert exact.error_bound < 1e-9 * abs(exact)


def test_the_adjoint_gives_the_same_response_to_the_map():
    """δT = Σ (visits of the path from the start) · (δK T): one left solution against one right solution."""
    noise, ends, start = WrappedNormal(0.15), (-3.0, 2.0), 0.77
    chain = arc_chain(STICKY, noise, ends, True, stretch=1.1)
    times = chain.elimination.solve(np.ones(chain.theta.size))
    first = chain.transitions(STICKY(np.array([start])))[0]
    visits = chain.elimination.visits(first)
    sources = tangent(chain.theta) * (chain.transition_slopes(chain.images) @ times)
    at_start = tangent(start) * float((chain.transition_slopes(STICKY(np.array([start]))) @ times)[0])
    found = passage_response(STICKY, noise, start, ends, tangent, lifted=True)
    # Without the chances of leaving the adjoint's sources cancel: T is 1e10, and six digits are left.
    assert abs(found.to_map / (visits @ sources + at_start) - 1) < 1e-3
    assert abs(found.to_map - slope(lambda h: _time(0.9 + h, noise, start, ends))) < 1e-7 * found.to_map


def _time(strength, noise, start, ends):
    return float(mean_passage_time(CircleMap.arnold(0.1, strength), noise, start, ends, lifted=True))


def test_a_reset_responds_in_closed_form_even_at_a_hundred_digits():
    """T = 1/P(|ξ - c| > 1) for a map that is constant, c: derivatives by c, σ and the ends are known."""
    x = np.array([-1.5, 1.5, 1.5, TWO_PI - 1.5])
    for sigma in (0.5, 0.1, 0.05):
        noise = WrappedNormal(sigma)
        reset = CircleMap.from_samples(x, [0.1, 0.1, 0.1, TWO_PI], [0, 0, 0, 0.0])
        found = passage_response(reset, noise, 0.0, (-1.0, 1.0), np.ones_like, lifted=True)
        above, below = noise.line_density(0.9), noise.line_density(1.1)
        time = 1 / float(noise.exceedance(0.9) + noise.exceedance(1.1))
        assert found.to_map == pytest.approx(-(time**2) * (above - below), rel=1e-12)
        assert found.to_noise == pytest.approx(-(time**2) * (0.9 * above + 1.1 * below) / sigma, rel=1e-12)
        assert found.to_arc_end == pytest.approx(time**2 * above, rel=1e-12)
        assert found.to_arc_start == pytest.approx(-(time**2) * below, rel=1e-12)
        assert abs(found.to_start) <= found.to_start.error_bound + 1e-300


def test_a_long_passage_barely_knows_its_start_and_the_slope_keeps_its_digits():
    """At 1e98 cycles dT/dx at the bottom is about 1/relaxation, ninety digits below T: it must not drown."""
    noise, ends = WrappedNormal(0.05), (-3.9, 2.36)
    found = passage_response(STICKY, noise, 0.77, ends, tangent, lifted=True)
    assert found.time > 1e95 and 1 < abs(found.to_start) < 1e3
    chain = arc_chain(STICKY, noise, ends, True, stretch=1.2)
    expected = chain.expected(1.0, np.zeros(2))

    def change(step):
        return expected.values_at(STICKY(np.array([0.77 + step])))[1][0]

    assert abs(found.to_start / slope(change, 1e-4) - 1) < 1e-6


def test_bad_requests_are_refused():
    noise, arc = WrappedNormal(0.3), (0.0, 1.6)
    with pytest.raises(InvalidInput, match="entry by entry"):
        passage_response(STICKY, noise, 0.7, arc, lambda theta: 1.0)
    with pytest.raises(InvalidInput, match="outside the arc"):
        passage_response(STICKY, noise, 3.0, arc)
    with pytest.raises(InvalidInput, match="jumps"):
        passage_response(STICKY, UniformNoise(0.3), 0.7, arc)
    with pytest.raises(ConvergenceError, match="1e300"):
        passage_response(STICKY, WrappedNormal(0.02), 0.7, (-1.5, 2.3), lifted=True)
    assert passage_response(STICKY, noise, 0.7, arc).to_map is None
