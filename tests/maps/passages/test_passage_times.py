"""Passage times, hitting probabilities, survival, and the bounds on their errors."""

from fractions import Fraction

import numpy as np
import pytest

from cyclemap.maps import (
    CircleMap,
    Estimate,
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
KNOWN = 44.62425322366


def two_wells():
    """Stable points near 0.1 and near π, the first much deeper."""
    return CircleMap(
        lambda x: x + 0.05 - 0.4 * np.sin(2 * x) + 0.1 * np.cos(x),
        lambda x: 1 - 0.8 * np.cos(2 * x) - 0.1 * np.sin(x),
    )


def test_the_known_passage_out_of_a_quarter_turn():
    noise = WrappedNormal(0.05 * TWO_PI)
    found = mean_passage_time(STICKY, noise, STABLE, (0.0, np.pi / 2))
    assert isinstance(found, Estimate)
    assert abs(found - KNOWN) < found.error_bound + 5e-12  # all the digits that are known
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
    laws = (
        WrappedNormal(0.5),
        WrappedNormal(0.2),
        WrappedNormal(0.05),
        WrappedCauchy(0.8),
        VonMises(40.0),
    )
    for noise in laws:
        exact = 1 / noise.arc_probability(1.0, TWO_PI - 1.0)
        found = mean_passage_time(reset(0.0), noise, 0.0, (-1.0, 1.0))
        assert abs(found - exact) <= found.error_bound < 1e-11 * exact


def test_bounds_hold_and_are_near_the_truth_while_nodes_are_too_few():
    """On nodes too few by far the bound of the discretisation still holds, and is not far above the
    error.
    """
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
    found = mean_passage_time(
        STICKY, WrappedNormal(0.025), STABLE, (UNSTABLE - 4, UNSTABLE), lifted=True
    )
    assert found == np.inf and found.error_bound == np.inf


def test_two_deep_wells_in_one_arc_keep_their_digits():
    """From either well the path falls into the deeper one first, unless it escapes: times agree,
    digits stay.
    """
    ends, noise = (-1.5, 4.7), WrappedNormal(0.1)
    times = [
        mean_passage_time(two_wells(), noise, start, ends, lifted=True) for start in (0.1, np.pi)
    ]
    assert times[0] > 1e35 and times[0].error_bound < 1e-11 * times[0]
    assert abs(times[1] / times[0] - 1) < 1e-12


def test_elimination_without_subtraction_is_exact_for_a_walk_with_tiny_escape():
    """A two-state chain that leaves with chance e = 1e-40 from its second state only."""
    e, q = 1e-40, np.array([[0.5, 0.5], [0.25, 0.75]])
    chain = eliminated(q, np.array([0.0, e]))
    # T1 = 2 + T2, and T2 = (1 + T1/4)/(1/4 + e), so T2 = 1.5/e.
    values, top, change = chain.expected(np.ones(2))
    assert abs(values[1] * e / 1.5 - 1) < 1e-15
    assert top == values[1] and change[1] == 0
    assert abs(change[0] - 2) < 1e-15  # T1 - T2, forty digits below T2


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
    """Reaching the far well before slipping home: the two chances have a ratio of 1e-14 and sum to
    1.
    """
    noise, a, b = WrappedNormal(0.08), (1.2, 1.5), (1.9, 2.0)
    rare = hitting_probability(two_wells(), noise, np.pi + 0.3, a, b)
    assert 1e-16 < rare < 1e-12
    assert rare.error_bound < 1e-11 * rare
    assert hitting_probability(two_wells(), noise, np.pi + 0.3, b, a).holds(1.0)


def test_a_jump_that_a_map_hides_is_found_by_panels_that_close_in_on_it():
    def jumping(breaks):
        return CircleMap(
            lambda x: x + 0.05 + 0.2 * np.floor((np.mod(x, TWO_PI) - 0.5) / TWO_PI),
            np.ones_like,
            breaks,
        )

    hidden, declared = (
        mean_passage_time(jumping(breaks), WrappedNormal(0.2), 0.5, (0.0, 1.0))
        for breaks in ((), (0.0, 0.5))
    )
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
    assert (
        abs(found - lives.mean()) < 4 * lives.std() / np.sqrt(paths)
        and found.error_bound < 1e-11 * found
    )
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
    for sigma in (0.4, 0.15, 0.08, 0.03):
        noise, arc = WrappedNormal(sigma), (-1.0, 1.0)
        staying = float(noise.arc_probability(np.array(-2.5), np.array(-0.5)))
        chances = survival_probabilities(reset(1.5), noise, 0.0, arc, 3)
        np.testing.assert_allclose(chances, staying ** np.arange(4.0), rtol=1e-7, atol=0.0)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [WrappedNormal(0.3), WrappedNormal(0.1)])
def test_chances_and_their_complements_add_up_to_one_within_their_bounds(noise):
    near, far = (-0.3, 0.3), (3.0, 3.2)
    for start in np.linspace(1.2, 2.8, 7):
        one = hitting_probability(CircleMap.arnold(0.0, 0.9), noise, start, near, far)
        other = hitting_probability(CircleMap.arnold(0.0, 0.9), noise, start, far, near)
        gap = abs(Fraction(float(one)) + Fraction(float(other)) - 1)
        assert gap <= Fraction(one.error_bound) + Fraction(other.error_bound)
        assert one.error_bound < 1e-11 and 0.0 <= one <= 1.0


def test_both_ends_of_an_arc_belong_to_it():
    for low in np.random.default_rng(1).uniform(-7, 7, 8):
        for end in (low, low + 0.07):
            moved = [
                mean_passage_time(STICKY, WrappedNormal(0.3), end + s, (low, low + 0.07))
                for s in (0.0, -TWO_PI)
            ]
            assert moved[1] == pytest.approx(moved[0], rel=1e-10)


def test_a_start_inside_one_of_the_arcs_is_decided_and_one_half_way_is_even():
    still, noise = CircleMap.rigid(0.0), WrappedNormal(0.3)
    assert hitting_probability(still, noise, 0.0, (1, 2), (-2, -1)).holds(0.5)
    for start, answer in ((1.5, 1.0), (-1.5, 0.0)):
        known = hitting_probability(still, noise, start, (1, 2), (-2, -1))
        assert known == answer and known.error_bound == 0
