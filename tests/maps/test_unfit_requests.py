"""Periods that would never end, parameters in wrong numbers, and results that nobody may write
to."""

import numpy as np
import pytest

from cyclemap import maps
from cyclemap.maps import ARNOLD_FAMILY, CircleMap, WrappedNormal, transfer_operator
from cyclemap.maps.families.family import parameter_tangent
from tests.refusals import refused

STICKY = CircleMap.arnold(0.1, 0.9)


def arnold(omega):
    return CircleMap.arnold(omega, 0.9)


@pytest.mark.parametrize("period", [10**6, 10**12, 10**30])
@pytest.mark.parametrize("proved", [False, True])
def test_points_of_huge_periods_are_refused_at_once(period, proved):
    for ask in (maps.periodic_points, maps.periodic_orbits):
        refused(ask, STICKY, period, proved=proved, told=r"the period: 1e\+.*give a smaller one")


@pytest.mark.parametrize("period", [10**4, 10**30])
def test_branches_of_huge_periods_are_refused_at_once(period):
    told = r"the period: 1e\+.*give a smaller one"
    for ask in (maps.bifurcations, maps.orbit_branches, maps.saddle_nodes):
        refused(ask, arnold, (0.0, 0.3), period, told=told)
    refused(maps.follow_orbit, arnold, 0.3, (0.0, 0.3), period=period, told=told)
    refused(maps.bifurcation_curves, CircleMap.arnold, (0.02, 0.3), (0.5, 0.9), period, told=told)


def test_periods_beyond_all_floats_are_refused():
    refused(maps.periodic_points, STICKY, 10**400, told="the period: above 1e300")


def test_parameters_that_do_not_fit_are_refused():
    refused(maps.rotation_numbers, ARNOLD_FAMILY, [0.1, 0.2], [0.3, 0.4, 0.5], told="broadcast")
    for ask in (maps.rotation_numbers, maps.lyapunov_exponents):
        for given in ([[0.1]], [[0.1]] * 3):
            refused(ask, ARNOLD_FAMILY, *given, told=r"\d parameters are given, .*omega")
    one = maps.ParametricLift(lambda x, p: x + p)
    refused(maps.rotation_plane, one, [0.1], [0.2], told="2 parameters are given")
    refused(maps.bifurcation_curves, None, (0.02, 0.3), (0.5, 0.9), told="family is None")


def test_what_is_no_sequence_is_refused():
    refused(
        maps.tongues, CircleMap.arnold, np.array(3.0), [0.4], (-0.5, 0.5), told="give a sequence"
    )
    refused(maps.find_steps, np.arange(9.0), zones=3.0, told="zones is 3.0")


def test_results_cannot_be_written_to():
    spectrum = transfer_operator(STICKY, WrappedNormal(0.3)).spectrum(3)
    vectors = [spectrum.right, spectrum.left]
    edges = maps.tongues(CircleMap.arnold, [0], [0.4], (-0.5, 0.5))
    branch = maps.follow_orbit(arnold, 0.7, (0.05, 0.1))
    tangent = parameter_tangent(arnold, 0.1, 1e-3, (0.0, 0.2))
    for array in (
        *(spectrum.values, spectrum.error_bounds, spectrum.condition, *vectors),
        *(edges.folded, branch.stable, *tangent.motions, tangent.break_rates),
    ):
        assert not array.flags.writeable
