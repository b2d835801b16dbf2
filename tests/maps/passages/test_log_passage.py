"""Passages beyond every float: closed forms, plain times, large deviations."""

import numpy as np
import pytest
from scipy.special import log_ndtr

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps import (
    CircleMap,
    VonMises,
    WrappedNormal,
    fixed_points,
    log10_passage_time,
    mean_passage_time,
)
from cyclemap.maps.passages import log_passage
from tests.maps.known_maps import reset

STICKY = CircleMap.arnold(0.1, 0.9)
STABLE, UNSTABLE = (float(p.points[0]) for p in fixed_points(STICKY))


@pytest.mark.slow
@pytest.mark.parametrize("lifted", [True, False])
def test_a_reset_leaves_with_its_exceedance_whatever_its_size(lifted):
    """A map that sends the arc to 0.1: T = 1/P(ξ > 0.9 or ξ < -1.1), known by log_ndtr, up to
    10^175,911.
    """
    for sigma in (0.1, 0.02, 0.01, 0.001):
        exact = -np.logaddexp(log_ndtr(-0.9 / sigma), log_ndtr(-1.1 / sigma)) / np.log(10)
        noise = WrappedNormal(sigma)
        found = log10_passage_time(reset(0.1), noise, 0.0, (-1.0, 1.0), lifted=lifted)
        assert found.holds(exact) and found.error_bound < 1e-13 * (1000 + exact)


@pytest.mark.slow
def test_both_methods_agree_where_the_time_is_still_a_float(monkeypatch):
    """At 1e98 and at 1e38 cycles, on the line and on the circle, from the bottom and from high."""
    cases = (0.05, True, STABLE), (0.08, False, STABLE), (0.08, True, UNSTABLE - 0.02)
    for sigma, lifted, start in cases:
        ends, noise = (-3.0, UNSTABLE), WrappedNormal(sigma)
        plain = mean_passage_time(STICKY, noise, start, ends, lifted=lifted)
        with monkeypatch.context() as patched:
            patched.setattr(log_passage, "LONGEST", 0.0)
            found = log10_passage_time(STICKY, noise, start, ends, lifted=lifted)
        assert abs(found - np.log10(plain)) < found.error_bound + plain.error_bound / plain
        direct = log10_passage_time(STICKY, noise, start, ends, lifted=lifted)
        assert direct == np.log10(plain) and direct.holds(float(found))


@pytest.mark.slow
def test_a_wide_noise_and_one_of_a_milliradian_lie_on_the_same_line():
    """ln T = V/σ² - n ln σ + c + O(σ²): the logarithm that is left in the slopes falls like σ²."""
    sigmas, ends = np.array([0.004, 0.002, 0.001]), (0.0, 1.5)
    logs = [log10_passage_time(STICKY, WrappedNormal(s), STABLE, ends) * np.log(10) for s in sigmas]
    barrier = (logs[2] - logs[1]) / (sigmas[2] ** -2 - sigmas[1] ** -2)
    again = (logs[1] - logs[0]) / (sigmas[1] ** -2 - sigmas[0] ** -2)
    assert logs[2] > 200_000
    assert abs(barrier / again - 1) < 5e-5
    assert abs(barrier - again) < 2 * np.log(2) * sigmas[1] ** 2


@pytest.mark.slow
def test_two_wells_that_are_both_endless_are_refused():
    two = CircleMap(lambda x: x - 0.25 * np.sin(2 * x), lambda x: 1 - 0.5 * np.cos(2 * x))
    ends = (-0.5 * np.pi, 1.5 * np.pi)
    with pytest.raises(ConvergenceError, match="several parts"):
        log10_passage_time(two, WrappedNormal(0.025), 0.0, ends, lifted=True)


def test_other_laws_are_refused_only_where_they_must_be():
    ends = (-1.5, UNSTABLE)
    assert log10_passage_time(STICKY, VonMises(10.0), STABLE, ends) > 1
    with pytest.raises(InvalidInput, match="more than 1e300"):
        log10_passage_time(STICKY, VonMises(1_500.0), STABLE, ends, lifted=True)


def test_a_chain_that_wider_noise_makes_no_coarser_is_begun_by_all_its_moves(monkeypatch):
    """Its nodes are the map's own however wide the noise: the answer is the same."""
    noise, arc = WrappedNormal(0.028), (-3.0, 2.37)
    swept = log10_passage_time(STICKY, noise, 0.77, arc, lifted=True)
    monkeypatch.setattr(log_passage, "_FEW", 60)
    again = log10_passage_time(STICKY, noise, 0.77, arc, lifted=True)
    assert abs(again - swept) <= again.error_bound + swept.error_bound < 1e-6
