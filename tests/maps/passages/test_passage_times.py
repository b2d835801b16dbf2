"""Passage times, hitting probabilities and survival, under smooth and under uniform noise."""

from fractions import Fraction

import numpy as np
import pytest

from cyclemap.errors import ConvergenceError
from cyclemap.maps import (
    CircleMap,
    UniformNoise,
    VonMises,
    WrappedCauchy,
    WrappedNormal,
    fixed_points,
    hitting_probability,
    mean_passage_time,
    survival_probabilities,
)
from cyclemap.maps.passages.killed_chain import Passage, eliminated, killed_chain
from tests.maps.known_maps import DROPPING, reset, simulated, within

TWO_PI = 2 * np.pi
STICKY = CircleMap.arnold(0.1, 0.9)
STABLE, UNSTABLE = (float(p.points[0]) for p in fixed_points(STICKY))


# Stable points near 0.1 and near π, the first much deeper.
TWO_WELLS = CircleMap(
    lambda x: x + 0.05 - 0.4 * np.sin(2 * x) + 0.1 * np.cos(x),
    lambda x: 1 - 0.8 * np.cos(2 * x) - 0.1 * np.sin(x),
)


def test_the_known_passage_out_of_a_quarter_turn():
    noise = WrappedNormal(0.05 * TWO_PI)
    found = mean_passage_time(STICKY, noise, STABLE, (0.0, np.pi / 2))
    assert abs(found - 44.62425322366) < found.error_bound + 5e-12  # all the digits that are known
    assert found.error_bound < 1e-12
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
    for noise in (WrappedNormal(0.5), WrappedNormal(0.05), WrappedCauchy(0.8), VonMises(40.0)):
        exact = 1 / noise.arc_probability(1.0, TWO_PI - 1.0)
        found = mean_passage_time(reset(0.0), noise, 0.0, (-1.0, 1.0))
        assert abs(found - exact) <= found.error_bound < 1e-11 * exact


def test_bounds_hold_and_are_near_the_truth_while_nodes_are_too_few():
    """While it is above rounding the bound is less than a hundred times the error."""
    judged, cases = 0, ((WrappedNormal(0.1), 1.57), (WrappedCauchy(0.8), 2.0), (VonMises(20), 2.0))
    for law, end in cases:
        arc = (0.0, end)
        exact = mean_passage_time(STICKY, law, STABLE, arc)
        for stretch in (0.2, 0.25, 0.3, 0.35, 0.4):
            passage = Passage.out_of(STICKY, law, arc, lifted=False)
            chain = killed_chain(passage, every_sample=False, stretch=stretch)
            rough = chain.expected(1.0, np.zeros(1))
            error, bound = abs(rough.value_at(STABLE) - exact), rough.error_bounds(STABLE)[0]
            assert error <= bound + exact.error_bound
            if error > 1e-12 * exact:
                assert bound < 100 * error
                judged += 1
    assert judged >= 6


def test_a_passage_beyond_all_floats_is_inf_and_says_that_nothing_is_known():
    arc = (UNSTABLE - 4, UNSTABLE)
    found = mean_passage_time(STICKY, WrappedNormal(0.025), STABLE, arc, lifted=True)
    assert found == np.inf and found.error_bound == np.inf


def test_two_deep_wells_in_one_arc_keep_their_digits():
    """From either well the path falls into the deeper one first, unless it escapes."""
    ends, noise = (-1.5, 4.7), WrappedNormal(0.1)
    deep, shallow = (
        mean_passage_time(TWO_WELLS, noise, start, ends, lifted=True) for start in (0.1, np.pi)
    )
    assert deep > 1e35 and deep.error_bound < 1e-11 * deep
    assert abs(shallow / deep - 1) < 1e-12


def test_elimination_without_subtraction_is_exact_for_a_walk_with_tiny_escape():
    """Two states, left with chance e from the second only: T1 = 2 + T2 and T2 = 1.5/e."""
    e, q = 1e-40, np.array([[0.5, 0.5], [0.25, 0.75]])
    values, top, change = eliminated(q, np.array([0.0, e])).expected(np.ones(2))
    assert abs(values[1] * e / 1.5 - 1) < 1e-15
    assert top == values[1] and change[1] == 0
    assert abs(change[0] - 2) < 1e-15  # forty digits below T2


def test_elimination_agrees_with_plain_solutions_whatever_the_number_of_states():
    rng = np.random.default_rng(2)
    for count in (1, 2, 3, 130):
        q = rng.uniform(0, 1, (count, count))
        q /= q.sum(axis=1, keepdims=True) * 1.01
        chain, plain = eliminated(q, 1 - q.sum(axis=1)), np.eye(count) - q
        for reward in rng.uniform(0, 1, count), rng.uniform(0, 1, (count, 3)):
            values, _, _ = chain.expected(reward)
            np.testing.assert_allclose(values, np.linalg.solve(plain, reward), rtol=1e-11)


@pytest.mark.slow
def test_hitting_probability_against_monte_carlo():
    noise, a, b = WrappedNormal(0.4), (2.2, 3.0), (5.0, 6.0)
    _, last = simulated(STICKY, noise, STABLE, lambda x: within(x, a) | within(x, b), 100_000)
    found = hitting_probability(STICKY, noise, STABLE, a, b)
    assert abs(found - np.mean(within(last, a))) < 4 * np.sqrt(found * (1 - found) / last.size)


@pytest.mark.slow
def test_tiny_hitting_probabilities_keep_their_digits():
    """Reaching the far well before slipping home: two chances with a ratio of 1e-14."""
    noise, a, b = WrappedNormal(0.08), (1.2, 1.5), (1.9, 2.0)
    rare = hitting_probability(TWO_WELLS, noise, np.pi + 0.3, a, b)
    assert 1e-16 < rare < 1e-12 and rare.error_bound < 1e-11 * rare
    assert hitting_probability(TWO_WELLS, noise, np.pi + 0.3, b, a).holds(1.0)


def test_a_jump_that_a_map_hides_is_found_by_panels_that_close_in_on_it():
    lift = lambda x: x + 0.05 + 0.2 * np.floor((np.mod(x, TWO_PI) - 0.5) / TWO_PI)  # noqa: E731
    maps = [CircleMap(lift, np.ones_like, breaks) for breaks in ((), (0.0, 0.5))]
    hidden, declared = (mean_passage_time(m, WrappedNormal(0.2), 0.5, (0.0, 1.0)) for m in maps)
    assert abs(hidden - declared) <= hidden.error_bound + declared.error_bound < 1e-11


@pytest.mark.parametrize(
    ("circle_map", "sigma", "start", "arc"),
    [(STICKY, 0.35, STABLE, (-0.03, 1.87)), (DROPPING, 0.3, 1.0, (0.5, 3.0))],
)
def test_monte_carlo_agrees(circle_map, sigma, start, arc):
    """Times and survival of many paths, of a map that jumps inside the arc, too."""
    noise, paths = WrappedNormal(sigma), 60_000
    lives, _ = simulated(circle_map, noise, start, lambda x: ~within(x, arc), paths)
    found = mean_passage_time(circle_map, noise, start, arc)
    assert abs(found - lives.mean()) < 4 * lives.std() / np.sqrt(paths)
    assert found.error_bound < 1e-11 * found
    chances = survival_probabilities(circle_map, noise, start, arc, 40)
    seen = np.mean(lives[:, None] > np.arange(41), axis=0)
    assert np.all(np.abs(seen - chances) < 5 * np.sqrt(chances * (1 - chances) / paths) + 1e-12)


def test_survival_probabilities_sum_to_the_mean_passage_and_end_geometric():
    noise, arc = WrappedNormal(0.1 * np.pi), (0.0, np.pi / 2)
    chances = survival_probabilities(STICKY, noise, STABLE, arc, 2_500)
    assert chances.shape == (2_501,) and chances[0] == 1 and np.all(np.diff(chances) < 0)
    assert abs(chances.sum() - mean_passage_time(STICKY, noise, STABLE, arc)) < 1e-11
    assert abs(chances[201] / chances[200] - chances[301] / chances[300]) < 1e-13


def test_small_chances_of_survival_keep_their_digits():
    """A map that resets to one angle stays n cycles with the n-th power of the chance of one."""
    for sigma in (0.4, 0.03):
        noise, arc = WrappedNormal(sigma), (-1.0, 1.0)
        staying = float(noise.arc_probability(np.array(-2.5), np.array(-0.5)))
        chances = survival_probabilities(reset(1.5), noise, 0.0, arc, 3)
        np.testing.assert_allclose(chances, staying ** np.arange(4.0), rtol=1e-7, atol=0.0)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [WrappedNormal(0.3), WrappedNormal(0.1)])
def test_chances_and_their_complements_add_up_to_one_within_their_bounds(noise):
    near, far = (-0.3, 0.3), (3.0, 3.2)
    odd = CircleMap.arnold(0.0, 0.9)
    for start in np.linspace(1.2, 2.8, 7):
        one = hitting_probability(odd, noise, start, near, far)
        other = hitting_probability(odd, noise, start, far, near)
        gap = abs(Fraction(float(one)) + Fraction(float(other)) - 1)
        assert gap <= Fraction(one.error_bound) + Fraction(other.error_bound)
        assert one.error_bound < 1e-11 and 0.0 <= one <= 1.0


def test_both_ends_of_an_arc_belong_to_it():
    """Wherever the start lies on the lift."""
    for low in np.random.default_rng(1).uniform(-7, 7, 8):
        arc = (low, low + 0.07)
        for end in arc:
            here = mean_passage_time(STICKY, WrappedNormal(0.3), end, arc)
            there = mean_passage_time(STICKY, WrappedNormal(0.3), end - TWO_PI, arc)
            assert there == pytest.approx(here, rel=1e-10)


def test_a_start_inside_one_of_the_arcs_is_decided_and_one_half_way_is_even():
    noise = WrappedNormal(0.3)
    assert hitting_probability(STILL, noise, 0.0, (1, 2), (-2, -1)).holds(0.5)
    for start, answer in ((1.5, 1.0), (-1.5, 0.0)):
        known = hitting_probability(STILL, noise, start, (1, 2), (-2, -1))
        assert known == answer and known.error_bound == 0


STILL = CircleMap.rigid(0.0)
FOLDED = CircleMap.arnold(0.3, 3.0)
BARRIER = 0.9 - 0.2 * np.pi  # the least halfwidth that carries the sticky map past θ = π/2


def assert_agrees(found, lives):
    """With the mean of simulated lives, within four and a half standard errors."""
    error = lives.std() / np.sqrt(lives.size)
    assert abs(found - lives.mean()) < 4.5 * error + found.error_bound
    assert found.error_bound < 0.01 * found


def walk_time(x, length, h):
    """Of the driftless walk out of (0, L), h <= L <= 2h: u' = v/2h, v' = -u/2h, v(x) = u(x + h)."""
    d = (length - h) / (2 * h)
    share = (1 - np.sin(d)) / np.cos(d)
    middle = 1 / (1 - 2 * share * np.sin(d) - 2 * (1 - np.cos(d)) - (2 * h - length) / (2 * h))
    near = min(x, length - x)
    if near >= length - h:
        return middle
    return middle * (share * np.cos(near / (2 * h)) + np.sin(near / (2 * h)))


def test_a_walk_leaves_a_short_arc_with_the_same_chance_every_cycle():
    for h, start in ((0.5, 0.0), (0.47, 0.13), (3.0, 0.45)):
        found = mean_passage_time(STILL, UniformNoise(h), start, (0.0, 0.45), lifted=True)
        assert found.holds(2 * h / (2 * h - 0.45)) and found.error_bound < 1e-10


@pytest.mark.parametrize("length", [0.55, 0.99])
def test_a_walk_leaves_a_longer_arc_after_the_time_of_its_delay_equation(length):
    for start in (0.0, 0.3, length - 0.1):
        found = mean_passage_time(STILL, UniformNoise(0.5), start + 2.0, (2.0, 2.0 + length))
        exact = walk_time(start, length, 0.5)
        assert abs(found - exact) <= found.error_bound < 1e-2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("circle_map", "h", "start", "ends"),
    [
        (STILL, 0.2, 0.3, (0.0, 1.0)),
        (STICKY, 4.0, 0.77, (-0.2, 1.6)),
        (DROPPING, 1.0, 1.0, (0.5, 3.0)),
        (FOLDED, 0.3, 1.0, (0.5, 3.0)),
    ],
)
def test_monte_carlo_agrees_under_uniform_noise(circle_map, h, start, ends):
    noise = UniformNoise(h)
    lives, _ = simulated(circle_map, noise, start, lambda theta: ~within(theta, ends))
    assert_agrees(mean_passage_time(circle_map, noise, start, ends), lives)


def test_lifted_and_wrapped_passages_differ_only_by_steps_of_a_turn():
    def times(h):
        return (
            mean_passage_time(STICKY, UniformNoise(h), 0.77, (-0.2, 1.6), lifted=lifted)
            for lifted in (False, True)
        )

    wrapped, lifted = times(0.8)
    assert abs(wrapped - lifted) <= wrapped.error_bound + lifted.error_bound
    wrapped, lifted = times(7.0)
    assert wrapped > lifted + 0.1
    noise, (low, high) = UniformNoise(2.0), (-2.2, 3.6)
    lives, _ = simulated(STICKY, noise, 0.77, lambda theta: (theta < low) | (theta > high))
    assert_agrees(mean_passage_time(STICKY, noise, 0.77, (low, high), lifted=True), lives)


def test_a_long_passage_agrees_with_a_chain_of_cells():
    """Cells of width δ, each with the law of its middle: an error of order δ²."""
    h, ends = 0.4, (0.0, 1.6)
    times = []
    for count in (500, 1000):
        edges = np.linspace(*ends, count + 1)
        middle = STICKY(0.5 * (edges[1:] + edges[:-1]))[:, None]
        overlap = np.minimum(edges[1:], middle + h) - np.maximum(edges[:-1], middle - h)
        chain = np.eye(count) - np.maximum(overlap, 0.0) / (2 * h)
        solved = np.linalg.solve(chain, np.ones(count))
        times.append(np.interp(0.77, 0.5 * (edges[1:] + edges[:-1]), solved))
    limit = times[1] + (times[1] - times[0]) / 3
    found = mean_passage_time(STICKY, UniformNoise(h), 0.77, ends)
    assert abs(found / limit - 1) < 2e-3
    assert found > 20_000 and found.error_bound < 0.01 * found


def test_the_time_is_infinite_where_the_noise_is_too_small():
    """But finite where the path cannot fall back, trap or no trap."""
    found = mean_passage_time(STICKY, UniformNoise(0.1), 0.77, (0.0, 1.6))
    assert found == np.inf and found.error_bound == 0.0
    assert mean_passage_time(STICKY, UniformNoise(BARRIER + 0.1), 0.77, (0.0, 1.6)) < 1e6
    noise, arc = UniformNoise(0.12), (0.0, 4.5)
    lives, _ = simulated(STICKY, noise, 2.56, lambda theta: ~within(theta, arc), 5_000)
    assert_agrees(mean_passage_time(STICKY, noise, 2.56, arc), lives)


@pytest.mark.parametrize("beyond", [-1e-4, 1e-4, 0.02])
def test_a_gap_as_narrow_as_a_cell_is_refused_or_infinite_but_never_guessed(beyond):
    try:
        found = mean_passage_time(STICKY, UniformNoise(BARRIER + beyond), 0.77, (0.0, 1.6))
    except ConvergenceError as refusal:
        assert "a gap as narrow as a cell" in str(refusal)
    else:
        assert found == np.inf and beyond < 0.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("circle_map", "h", "start", "a", "b"),
    [
        (DROPPING, 0.9, 2.0, (3.0, 3.5), (0.0, 0.5)),
        (FOLDED, 0.3, 2.0, (3.0, 3.5), (0.0, 0.5)),
        (STILL, 0.4, 2.0, (3.0, 4.0), (0.0, 1.5)),
    ],
)
def test_monte_carlo_hits_agree_under_uniform_noise(circle_map, h, start, a, b):
    _, last = simulated(
        circle_map, UniformNoise(h), start, lambda theta: within(theta, a) | within(theta, b)
    )
    found = hitting_probability(circle_map, UniformNoise(h), start, a, b)
    share = np.mean(within(last, a))
    assert abs(found - share) < 4.5 * np.sqrt(max(found * (1 - found), 1e-6) / last.size)
    assert found.error_bound < 1e-3


def test_an_arc_that_cannot_be_reached_has_chance_zero():
    found = hitting_probability(STICKY, UniformNoise(0.1), 0.77, (1.6, 2.0), (-1.0, -0.5))
    assert found == 0.0 and found.error_bound < 1e-15


def test_bounds_under_uniform_noise_hold_where_a_map_is_off_to_both_sides():
    """Pulled apart or together: moved as a whole an odd map's passages stay as long."""

    def pulled(by, claim=0.0):
        return CircleMap(lambda x: x - 0.3 * np.sin(x) + by * np.sin(x), max_error=claim)

    for off in (1e-4, 1e-3):
        claimed = mean_passage_time(pulled(0.0, off), UniformNoise(0.6), 0.0, (-1.0, 1.0))
        for by in (-off, off):
            other = mean_passage_time(pulled(by), UniformNoise(0.6), 0.0, (-1.0, 1.0))
            assert abs(claimed - other) <= claimed.error_bound
        assert claimed.error_bound < 1_000.0 * off
