"""Sampling of circle maps: stated errors hold, kinks and jumps are kept,
steep climbs are followed."""

import math
from functools import partial

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection.adaptive_map import sample_circle_map

FULL_TURN = 2.0 * math.pi


def smooth(theta, harmonics=3):
    """A smooth lift and its slope."""
    value = theta + 0.4 + 0.3 * math.sin(harmonics * theta + 0.2)
    return value, 1.0 + 0.3 * harmonics * math.cos(harmonics * theta + 0.2)


def jumping(theta, place=2.1):
    """A lift with a jump of 0.7 and a smooth course elsewhere."""
    turns, base = divmod(theta, FULL_TURN)
    value = base + 0.1 * math.sin(base) + (0.7 * (base - place) / FULL_TURN)
    value += 0.7 if base < place else 0.0
    return value + FULL_TURN * turns, 1.0 + 0.1 * math.cos(base) + 0.7 / FULL_TURN


def kinked(theta):
    """A lift with kinks at 1.3 and 4.4: slopes 0.5 between them, 1.5 or so elsewhere."""
    turns, base = divmod(theta, FULL_TURN)
    outside = (FULL_TURN - 0.5 * 3.1) / (FULL_TURN - 3.1)
    inside = min(max(base - 1.3, 0.0), 3.1)
    value = outside * (base - inside) + 0.5 * inside
    return value + FULL_TURN * turns, 0.5 if 1.3 < base < 4.4 else outside


def steep(theta):
    """A lift that climbs half a turn within 1e-3 rad of 3.0, continuously."""
    turns, base = divmod(theta, FULL_TURN)
    width = 1e-3
    value = 0.5 * base + 0.5 * math.pi * (1.0 + math.tanh((base - 3.0) / width))
    slope = (
        0.5 + 0.5 * math.pi / width / math.cosh(max(min((base - 3.0) / width, 300.0), -300.0)) ** 2
    )
    return value + FULL_TURN * turns, slope


def sampled(function, tolerance, **options):
    """The map that a function of one orientation gives."""
    return sample_circle_map(
        lambda theta: np.array([function(t) for t in theta.tolist()]).T, tolerance, **options
    )


def worst_error(circle, function, theta):
    return max(abs(float(circle(t)) - function(t)[0]) for t in theta.tolist())


LIFTS = [
    *((smooth, tolerance, [], [], []) for tolerance in (1e-4, 1e-6, 1e-8)),
    (jumping, 1e-6, [2.1], [-0.7], [2.1 - 1e-8, 2.1 + 1e-8]),
    (kinked, 1e-6, [1.3, 4.4], [], []),
    (steep, 1e-6, [], [], 3.0 + np.linspace(-4e-3, 4e-3, 500)),
]


@pytest.mark.parametrize(("lift", "tolerance", "breaks", "jumps", "beside"), LIFTS)
def test_jumps_and_kinks_are_kept_and_the_stated_error_holds_within_the_tolerance(
    lift, tolerance, breaks, jumps, beside
):
    """At 1,000 random places and beside what is steep, which is no jump."""
    circle = sampled(lift, tolerance)
    np.testing.assert_allclose(circle.breaks, breaks, atol=1e-9 if jumps else 1e-5)
    _, left, right = circle.jumps()
    np.testing.assert_allclose(right - left, jumps, atol=1e-6)
    theta = np.concatenate([np.random.default_rng(1).uniform(-20.0, 20.0, 1000), beside])
    assert worst_error(circle, lift, theta) <= circle.max_error <= tolerance


def test_cubics_grow_with_the_fourth_root_of_the_tolerance_and_samples_slower_than_the_sixth():
    """10,000 times the accuracy asks for 10 times the cubics, but for less than 4.6 times the
    samples.
    """
    coarse, fine = sampled(smooth, 1e-5), sampled(smooth, 1e-9)
    assert 5.0 <= len(fine.pieces.knots) / len(coarse.pieces.knots) <= 20.0
    assert fine.samples / coarse.samples < 10_000 ** (1 / 6)
    # Hermite's cubic is off by h^4/384 times the largest fourth derivative: no more than twice as
    # many as that asks.
    asked = 2.0 * np.pi * (0.3 * 3.0**4 / (384.0 * 1e-9)) ** 0.25
    assert len(fine.pieces.knots) < 2.0 * asked


def test_noise_that_the_tolerance_cannot_beat_is_confessed():
    """A sample that wobbles by 1e-5 cannot be interpolated to 1e-7: the stated error says so, and
    holds.
    """

    def wobbling(theta):
        value, slope = smooth(theta)
        return value + 1e-5 * math.sin(1e9 * math.sin(theta)), slope

    circle = sampled(wobbling, 1e-5)
    theta = np.random.default_rng(5).uniform(0.0, FULL_TURN, 300)
    assert worst_error(circle, wobbling, theta) <= 3.0 * circle.max_error


def test_waves_in_step_with_the_samples_are_seen():
    """At 24 places and all that halving them gives the ripple is 0 and level: samples there know
    nothing of it.
    """
    waves, height = 24 * 16, 0.3 / (24 * 16)

    def rippled(theta):
        value = theta + 0.3 * math.sin(theta) + height * (1.0 - math.cos(waves * theta))
        return value, 1.0 + 0.3 * math.cos(theta) + height * waves * math.sin(waves * theta)

    circle = sampled(rippled, 2e-5)
    theta = np.random.default_rng(6).uniform(0.0, FULL_TURN, 400)
    assert worst_error(circle, rippled, theta) <= circle.max_error <= 2e-5


def test_the_stated_error_holds_what_samples_are_off_by():
    """A sample that is off by a constant is interpolated as well as one that is not; the constant
    adds to the error.
    """
    plain, off = sampled(smooth, 1e-5), sampled(smooth, 1e-5, sample_error=3e-6)
    assert off.max_error == pytest.approx(plain.max_error + 3e-6, rel=1e-12)


def test_progress_rises_to_one_and_a_tolerance_that_is_no_positive_number_is_refused():
    seen = []
    sampled(smooth, 1e-5, progress=seen.append)
    assert seen == sorted(seen) and seen[-1] == 1.0
    for tolerance in (0.0, -1e-6, math.nan, "fine"):
        refused(sampled, smooth, tolerance, told="tolerance")


@pytest.mark.parametrize("beside", [-9e-11, -3e-11, 3e-11, 9e-11])
def test_a_jump_beside_a_sample_leaves_a_sliver_whose_error_is_known(beside):
    """Between the jump and a first sample there is too little room to be halved: its ends bound
    what it may hide.
    """
    lift = partial(jumping, place=FULL_TURN * 8 / 24 + beside)
    found = sampled(lift, 1e-6)
    assert found.breaks == pytest.approx([FULL_TURN * 8 / 24 + beside], abs=2e-10)
    assert worst_error(found, lift, np.linspace(0.01, 6.2, 200)) <= found.max_error < 1.0
