"""The paper's repeated pushes: recorded sets are found by the names of their files; sampled runs
follow the mechanics, scatter as they say, and wear.
"""

import shutil

import numpy as np
import pytest
from figure_cases import RECORDED_ABS, RECORDED_PLYWOOD, SMALL, recorded_folder
from refusals import refused

from cyclemap.cli.run_figures import WatchedFolder
from cyclemap.collection import CollectionLoop, worn_loop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.evidence import simulate_collection
from cyclemap.figures import MeasuredFolder
from cyclemap.figures.repeated_pushes import (
    STANDS_FOR,
    Sampling,
    SurfaceState,
    fitted_laws,
    measured_theta0,
    recorded_set,
    sampled_run,
    surface_states,
)
from cyclemap.maps import WrappedNormal, transfer_operator
from cyclemap.mechanics import SidePush
from cyclemap.protocol import loop_from_settings
from cyclemap.views.panels.orientation import CIRCLE


@pytest.fixture(scope="module")
def pu():
    return sampled_run("pu", SMALL)


@pytest.fixture(scope="module")
def worn():
    return sampled_run("plywood-measured", SMALL)


def worst_push(state: SurfaceState) -> np.ndarray:
    """How far interpolated pushes on pu lie from those of the mechanics: Δθ, Δx and Δy."""
    theta = np.array([0.2, 1.9, 4.4, 7.0])
    runs = CollectionLoop.mit("pu").cycles(theta)
    exact = np.column_stack([runs.push_turn, runs.push_displacement])
    return np.abs(state.motion(theta) - exact).max(axis=0)


def test_interpolated_pushes_are_those_of_the_mechanics_and_nearer_on_a_finer_cycle_map(pu) -> None:
    worst = worst_push(pu.states[0])
    assert np.all(worst < (np.deg2rad(0.2), 0.2e-3, 0.2e-3))
    (finer,) = surface_states("pu", 1, tolerance=1e-5)
    assert np.all(worst_push(finer) < 0.2 * worst)


def test_the_orientations_scatter_about_the_map_by_the_noise_of_a_cycle(pu) -> None:
    kick = pu.pushes.pairs.theta_next - pu.map(pu.pushes.pairs.theta)
    assert kick.size == SMALL.pushes == pu.pushes.count
    assert np.std(kick) == pytest.approx(DEFAULT_SIGMA, rel=0.15)


def test_derivatives_by_the_friction_offset_are_those_of_cycles_run_on_a_changed_surface(
    pu,
) -> None:
    theta, step, loop = 2 * np.pi * 8 / 36, 1e-4, CollectionLoop.mit("pu")
    (exact,) = pu.states[0].slopes(np.array([theta]))
    for column, name in enumerate(("m0", "n0")):
        found = []
        for shift in (step, -step):
            settings = {name: getattr(loop.material.friction, name) + shift}
            cycle = loop_from_settings(settings, loop).cycle(theta)
            found.append([cycle.push_turn, *cycle.push_displacement, cycle.theta_next])
        slope = np.subtract(*found) / (2.0 * step)
        assert np.allclose(slope, exact[:, column], rtol=2e-3, atol=2e-3)


def test_offsets_turn_the_cycle_by_its_kick_and_are_as_large_across_as_along(pu) -> None:
    law = CollectionLoop.mit("pu").material.friction
    offset, pairs = np.sqrt(law.mu_a * law.mu_b) * pu.jitter, pu.pushes.pairs
    slope = pu.states[0].slopes(pairs.theta)[:, -1]
    kick, across = np.sum(offset * slope, axis=1), np.sum(offset[:, ::-1] * slope * (-1, 1), axis=1)
    assert np.allclose(kick, pairs.theta_next - pu.map(pairs.theta), atol=1e-12)
    size = np.hypot(*slope.T)
    assert np.std(across / size) == pytest.approx(np.std(kick / size), rel=0.2)


@pytest.mark.slow
def test_a_percent_of_friction_explains_the_scatter_of_theta0_on_every_material() -> None:
    found = [sampled_run(material, SMALL).jitter for material in STANDS_FOR.values()]
    assert [one.shape for one in found] == [(SMALL.pushes, 2)] * 4
    assert all(0.008 < np.sqrt(np.mean(np.sum(one**2, axis=1))) < 0.022 for one in found)


def test_wear_leads_from_the_fresh_map_to_the_worn_one(worn) -> None:
    assert [state.cycle for state in worn.states] == [0.0, 2000.0]
    theta = np.array([1.6, 4.0])
    loop = CollectionLoop.mit("plywood-measured")
    for cycle, allowed in ((0.0, 0.1), (1000.0, 0.5), (2000.0, 0.1)):
        direct = worn_loop(loop, cycle).next_theta(theta)
        assert np.max(np.abs(worn.map.at(cycle)(theta) - direct)) < np.deg2rad(allowed)


@pytest.mark.slow
def test_densities_are_laws_and_the_worn_one_is_the_mean_of_its_states(worn, pu) -> None:
    for run in (worn, pu):
        density, _ = run.density
        assert np.all(density >= -1e-9)
        assert np.trapezoid(density, CIRCLE) == pytest.approx(1.0, abs=1e-4)
    each = [transfer_operator(state.map, WrappedNormal(DEFAULT_SIGMA)) for state in worn.states]
    density, error = worn.density
    mean = np.mean([operator.density(CIRCLE) for operator in each], axis=0)
    assert np.allclose(density, mean, atol=1e-12)
    assert error == pytest.approx(np.mean([operator.error_bound for operator in each]))


def test_runs_start_where_the_paper_says_and_are_computed_once() -> None:
    starts = [sampled_run(material, SMALL).run.start for material in STANDS_FOR.values()]
    assert np.degrees(starts) == pytest.approx([100.0, -150.0, 80.0, 0.0], abs=1e-6)
    one = sampled_run("pu", SMALL)
    assert one is sampled_run("pu", SMALL) and fitted_laws(one.pushes) is fitted_laws(one.pushes)


def test_bad_sampling_and_a_material_of_which_nothing_is_published_are_refused() -> None:
    for name, value in (("pushes", 1), ("states", 1), ("tolerance", 0.0)):
        refused(Sampling, told=name, **{name: value})
    refused(sampled_run, "isotropic", SMALL, told=r"material of Ma & Rodriguez \(2018\).*isotropic")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    return recorded_folder(tmp_path_factory)


def test_sets_are_found_wherever_they_lie_below_the_folder(recorded) -> None:
    plywood, made_abs, *others = (
        recorded_set(recorded, name) for name in ("plywood", "abs", "delrin", "pu")
    )
    counts = plywood.count, made_abs.count
    assert counts == (RECORDED_PLYWOOD, RECORDED_ABS) and others == [None, None]
    pairs = measured_theta0(recorded, "abs")
    assert pairs.path.size == RECORDED_ABS and pairs.theta.size == RECORDED_ABS - 1
    assert measured_theta0(recorded, "pu") is None


def test_pushes_of_another_protocol_or_too_few_are_no_set(tmp_path) -> None:
    base = CollectionLoop.mit("abs", accuracy=1e-4, push=SidePush(distance=0.02))
    simulate_collection(loop_from_settings({"fraction": 0.5}, base), tmp_path / "other", 20)
    simulate_collection(base, tmp_path / "few", 19)
    assert recorded_set(MeasuredFolder(tmp_path), "abs") is None


def test_damaged_files_are_passed_over(recorded, tmp_path) -> None:
    shutil.copytree(recorded.path / "one", tmp_path / "one")
    files = sorted((tmp_path / "one").rglob("*.h5"))
    files[3].write_bytes(b"no HDF5")
    found = recorded_set(MeasuredFolder(tmp_path), "abs")
    assert found.count == RECORDED_ABS - 1


def test_who_watches_the_folder_learns_where_the_pushes_were(recorded) -> None:
    watched = WatchedFolder(recorded.path)
    assert recorded_set(watched, "abs") is not None and recorded_set(watched, "pu") is None
    (used,) = watched.there
    assert any("motion_surface=abs" in file.name for file in (recorded.path / used).iterdir())
