"""The simulators of the benchmark beside peers: that they solve the same push, by ways that share
no code.
"""

import math

import numpy as np
import pytest

from cyclemap.mechanics import Pose
from tests.benchmarks.peers import entrants as roster
from tests.benchmarks.peers.package_push import DYNAMIC, ENGINE
from tests.benchmarks.peers.plain_push import SCIPY, numpy_push
from tests.benchmarks.peers.push_problem import ANGLES, Distance, distance, four_corners, plain_grid
from tests.benchmarks.timing import in_turns

PROBLEMS = {problem.name: problem for problem in (four_corners(), plain_grid())}
FEW = len(ANGLES)
OUTLINE = four_corners().slider.outline.vertices


@pytest.fixture(params=PROBLEMS)
def problem(request):
    return PROBLEMS[request.param]


@pytest.fixture(params=("mujoco", "drake"))
def engine(request):
    found = roster.engine(request.param)
    if isinstance(found, str):
        pytest.skip(found)
    return found


def test_the_distance_of_poses_is_the_worst_in_place_and_in_turn():
    ends = [Pose(0.0, 0.0, 0.0), Pose(0.003, 0.004, 0.0), Pose(0.0, 0.0, -0.1)]
    found = distance(ends, [Pose()] * 3)
    assert found.place_mm == pytest.approx(5.0)
    assert found.turn_deg == pytest.approx(math.degrees(0.1))
    assert not found.near
    assert Distance(0.2, 0.1).near


def test_the_pushes_go_around_the_circle_and_take_every_angle_alike():
    pushes = four_corners().pushes
    assert len(pushes) == 12
    turns = np.diff([pose.theta for pose, _ in pushes])
    np.testing.assert_allclose(turns, math.tau / 12)
    assert [sum(push.angle == angle for _, push in pushes) for angle in ANGLES] == [4, 4, 4]


def test_plain_numpy_ends_where_the_engine_does(problem):
    """Forces summed over the points and Runge-Kutta's steps, against the contact curve and exact
    stick and slip.
    """
    off = distance(
        problem.ends(numpy_push(problem, 60, softness=1e-4), FEW), problem.converged[:FEW]
    )
    assert off.place_mm < 0.02
    assert off.turn_deg < 0.04


@pytest.mark.parametrize(
    "simulator", [ENGINE, SCIPY, DYNAMIC], ids=lambda simulator: simulator.name
)
def test_simulators_end_near_converged(simulator, problem):
    assert distance(problem.ends(simulator.build(problem), FEW), problem.converged[:FEW]).near


def test_the_engine_is_timed_where_no_corner_ends_more_than_10_micrometres_off(problem):
    ends = problem.ends(ENGINE.build(problem))
    corners = [
        (pose, exact, corner)
        for pose, exact in zip(ends, problem.converged, strict=True)
        for corner in OUTLINE
    ]
    gaps = [
        math.dist(pose.to_world(*corner), exact.to_world(*corner))
        for pose, exact, corner in corners
    ]
    assert len(gaps) == 48 and 0.0 < max(gaps) < 1e-5


def test_the_engines_end_near_converged_and_repeat_themselves(engine):
    """Rigid bodies with inertia on compliant contacts, and a push leaves nothing behind that would
    change the next.
    """
    problem = four_corners()
    end_pose = engine.build(problem)
    first, again = problem.ends(end_pose, FEW), problem.ends(end_pose, FEW)
    assert distance(first, problem.converged[:FEW]).near
    assert distance(first, again).place_mm < 1e-3


def test_the_engines_refuse_friction_with_directions(engine):
    with pytest.raises(AssertionError):
        engine.build(plain_grid())


def test_an_engine_that_is_not_installed_is_told_by_name(monkeypatch):
    def missing(name: str) -> None:
        raise ModuleNotFoundError("No module named 'mujoco'")

    monkeypatch.setattr(roster, "import_module", missing)
    assert "mujoco takes no part" in str(roster.engine("mujoco"))
    assert sum(isinstance(known, str) for known in roster.simulators()) == 2


def test_what_is_timed_runs_in_turns():
    order: list[str] = []
    times = in_turns([lambda: order.append("a"), lambda: order.append("b")], 3)
    assert order == ["a", "b"] * 4 and len(times) == 2
