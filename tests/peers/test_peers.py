"""The simulators of the benchmark beside peers: that they solve the same push, by ways that share no code."""

import math
from dataclasses import fields, replace

import pytest

from tests.benchmarks.peers import simulators as roster
from tests.benchmarks.peers.package_push import DYNAMIC, ENGINE
from tests.benchmarks.peers.plain_push import SCIPY, NumpyPush, NumpySettings
from tests.benchmarks.peers.push_problem import ANGLES, CORNERS, Distance, Simulator, distance, four_corners, plain_grid
from tests.benchmarks.peers.settings import run_trial

PROBLEMS = {problem.name: problem for problem in (four_corners(), plain_grid())}
FEW = len(ANGLES)


@pytest.fixture(params=PROBLEMS)
def problem(request):
    return PROBLEMS[request.param]


@pytest.fixture(params=("mujoco", "drake"))
def engine(request):
    found = roster.engine(request.param)
    if isinstance(found, str):
        pytest.skip(found)
    return found


def chosen_runner(simulator: Simulator, problem):
    return simulator.build(problem, simulator.chosen[problem.name])


def test_plain_numpy_ends_where_the_engine_does(problem):
    """Forces summed over the points and Runge-Kutta's steps, against the contact curve and exact stick and slip."""
    peer = NumpyPush(problem, NumpySettings(60, softness=1e-4))
    off = distance(problem.ends(peer.end_pose, FEW), problem.converged[:FEW])
    assert off.place_mm < 0.02
    assert off.turn_deg < 0.04


@pytest.mark.parametrize("simulator", [ENGINE, SCIPY, DYNAMIC], ids=lambda simulator: simulator.name)
def test_chosen_settings_end_near_converged(simulator, problem):
    runner = chosen_runner(simulator, problem)
    assert distance(problem.ends(runner.end_pose, FEW), problem.converged[:FEW]).near


def test_the_engines_chosen_settings_end_near_converged(engine):
    """Rigid bodies with inertia on compliant contacts end where the quasi-static balance of forces has them end."""
    problem = four_corners()
    runner = chosen_runner(engine, problem)
    assert distance(problem.ends(runner.end_pose, FEW), problem.converged[:FEW]).near


def test_an_engine_that_is_not_installed_is_told_by_name(monkeypatch):
    def missing(name: str) -> None:
        raise ModuleNotFoundError("No module named 'mujoco'")

    monkeypatch.setattr(roster, "import_module", missing)
    assert "mujoco takes no part" in str(roster.engine("mujoco"))
    assert sum(isinstance(known, str) for known in roster.simulators().values()) == 2


def test_the_search_looks_only_at_settings_that_exist():
    found = [known for known in roster.simulators().values() if isinstance(known, Simulator)]
    assert len(found) >= 4
    for simulator in found:
        for settings in simulator.chosen.values():
            names = {field.name for field in fields(settings)}
            assert set(simulator.searched) <= names
            for name, (low, high) in simulator.searched.items():
                assert low <= getattr(settings, name) <= high
            assert simulator.finer(settings) != settings


def test_what_is_missing_from_converged_costs_more_than_time():
    trial = run_trial(ENGINE, four_corners(), ENGINE.chosen[CORNERS])
    assert trial is not None
    assert trial.cost == trial.seconds
    assert replace(trial, own=Distance(0.0, 0.2)).cost > 8.0 * trial.seconds
    assert replace(trial, off=Distance(math.inf, math.inf)).cost == math.inf
