"""Sampled runs follow the mechanics, scatter as they say, and wear."""

import numpy as np
import pytest
from figure_cases import SMALL

from cyclemap.collection import CollectionLoop, worn_loop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import InvalidInput
from cyclemap.evidence import SurfaceParameters
from cyclemap.figures.simulated_collections import (
    STANDS_FOR,
    Sampling,
    _friction_errors,
    fitted_laws,
    sampled_run,
    surface_state,
)

CIRCLE = np.linspace(0.0, 2 * np.pi, 2001)


@pytest.fixture(scope="module")
def pu():
    return sampled_run("pu", SMALL)


@pytest.fixture(scope="module")
def worn():
    return sampled_run("plywood-measured", SMALL)


def test_interpolated_pushes_are_those_of_the_mechanics_within_the_stated_error(pu) -> None:
    loop, state = CollectionLoop.mit("pu"), pu.states[0]
    theta = np.array([0.2, 1.9, 4.4, 7.0])
    direct = loop.cycles(theta)
    found = state.push_motion(theta)
    assert np.max(np.abs(found[:, 0] - direct.push_turn)) < np.deg2rad(0.2)
    assert np.max(np.abs(found[:, 1:] - direct.push_displacement)) < 0.2e-3
    assert np.all(state.motion_error < (np.deg2rad(0.2), 0.2e-3, 0.2e-3))


def test_a_finer_cycle_map_brings_finer_pushes(pu) -> None:
    finer = surface_state(CollectionLoop.mit("pu"), tolerance=1e-5)
    assert finer.theta.size > pu.states[0].theta.size
    assert np.all(finer.motion_error < 0.2 * pu.motion_error)


def test_the_orientations_scatter_about_the_map_by_the_noise_of_a_cycle(pu) -> None:
    kick = pu.pushes.pairs.theta_next - pu.map(pu.pushes.pairs.theta)
    assert kick.size == SMALL.pushes == pu.pushes.count
    assert np.std(kick) == pytest.approx(DEFAULT_SIGMA, rel=0.15)


def test_derivatives_by_the_friction_offset_are_those_of_cycles_run_on_a_changed_surface(pu) -> None:
    """Differences of whole cycles, run with the centre of the ellipse moved, give the scatter's derivatives."""
    theta, step = 2 * np.pi * 8 / 36, 1e-4
    exact = pu.states[0].by_offset(theta)
    for column, name in enumerate(("m0", "n0")):
        found = []
        for sign in (1.0, -1.0):
            law = CollectionLoop.mit("pu").material.friction
            settings = {name: getattr(law, name) + sign * step}
            cycle = CollectionLoop.from_settings(settings, CollectionLoop.mit("pu")).cycle(theta)
            found.append([cycle.push_turn, *cycle.push_displacement, cycle.theta_next])
        assert np.allclose(np.subtract(*found) / (2.0 * step), exact[:, column], rtol=2e-3, atol=2e-3)


def test_offsets_turn_the_cycle_by_its_kick_and_are_as_large_across_as_along() -> None:
    rng = np.random.default_rng(0)
    kick, slope = DEFAULT_SIGMA * rng.standard_normal(20_000), rng.uniform(3.0, 9.0, (20_000, 2))
    offset = _friction_errors(kick, slope, 0)
    assert np.allclose(np.sum(offset * slope, axis=1), kick, atol=1e-15)
    size = np.hypot(*slope.T)
    across = (slope[:, 0] * offset[:, 1] - slope[:, 1] * offset[:, 0]) / size
    assert np.std(across) == pytest.approx(np.std(kick / size), rel=0.05)


@pytest.mark.slow
def test_a_percent_of_friction_explains_the_scatter_of_theta0_on_every_material() -> None:
    found = [sampled_run(material, SMALL).jitter for material in STANDS_FOR.values()]
    assert [one.size for one in found] == [SMALL.pushes] * 4
    assert all(0.008 < np.sqrt(np.mean(one**2)) < 0.022 for one in found)


def test_wear_leads_from_the_fresh_map_to_the_worn_one(worn) -> None:
    assert worn.wears and [state.cycle for state in worn.states] == [0.0, 2000.0]
    theta = np.array([1.6, 4.0])
    loop = CollectionLoop.mit("plywood-measured")
    for cycle, allowed in ((0.0, 0.1), (1000.0, 0.5), (2000.0, 0.1)):
        direct = worn_loop(loop, cycle).next_theta(theta)
        assert np.max(np.abs(worn.map.at(cycle)(theta) - direct)) < np.deg2rad(allowed)


@pytest.mark.slow
def test_densities_are_laws_and_the_worn_one_is_the_mean_of_its_states(worn, pu) -> None:
    for run in (worn, pu):
        density = run.density(CIRCLE)
        assert np.all(density >= -1e-9)
        assert np.trapezoid(density, CIRCLE) == pytest.approx(1.0, abs=1e-4)
    each = np.array([operator.density(CIRCLE) for operator in worn.operators])
    assert np.allclose(worn.density(CIRCLE), np.mean(each, axis=0), atol=1e-12)


def test_runs_start_where_the_paper_says_and_are_computed_once() -> None:
    starts = {surface: sampled_run(material, SMALL).run.start for surface, material in STANDS_FOR.items()}
    assert starts == pytest.approx({"plywood": 1.745329, "abs": -2.617994, "delrin": 1.396263, "pu": 0.0}, abs=1e-6)
    one = sampled_run("pu", SMALL)
    assert one is sampled_run("pu", SMALL) and fitted_laws(one.pushes) is fitted_laws(one.pushes)
    assert SurfaceParameters.from_friction(CollectionLoop.mit("pu").material.friction).friction_scale == pytest.approx(
        np.log(one.states[0].mean_friction)
    )


@pytest.mark.parametrize(
    ("options", "message"), [({"pushes": 1}, "pushes"), ({"states": 1}, "states"), ({"tolerance": 0.0}, "tolerance")]
)
def test_bad_sampling_is_refused_with_its_name(options, message) -> None:
    with pytest.raises(InvalidInput, match=message):
        Sampling(**options)


def test_a_material_of_which_nothing_is_published_is_refused() -> None:
    with pytest.raises(InvalidInput, match=r"material of Ma & Rodriguez \(2018\).*isotropic"):
        sampled_run("isotropic", SMALL)
