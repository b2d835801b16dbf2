"""Who takes part in a table: simulators built and warm, with how far they are from converged, measured on the spot."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cyclemap.collection import CollectionLoop
from cyclemap.mechanics import Pose, QuasiStaticModel, SidePush
from cyclemap.mechanics.quasi_static import run_strokes
from tests.benchmarks.peers.package_push import ENGINE
from tests.benchmarks.peers.push_problem import ANGLES, Distance, PushProblem, Simulator, distance
from tests.benchmarks.peers.simulators import simulators

# Pushes of which a simulator's own limit is computed: one of each angle of approach.
_LIMIT = len(ANGLES)
# This package's rows under even pressure: pushes alone, and with the way back.
EVEN, DRAGGED = "even pressure", "with the drag back"
# This package's engine on the problem itself.
ONE_CALL = "many in one call"
# Pushes in one call: of a problem's, so many times; under even pressure, from so many orientations.
_REPEATED = 20
_MANY = 240
# Coarsest accuracy at which the object's corners end within 10 µm of where they should; the table tells how far.
EVEN_ACCURACY = 1e-3


@dataclass(frozen=True)
class Entrant:
    """name : with its version. run : does its pushes, so many. note : what is to be known of their ends."""

    name: str
    run: Callable[[], Any]
    pushes: int
    note: str


def entrants(problem: PushProblem) -> list[Entrant]:
    """All that take part in a problem, this package's engine first."""
    found = [known for known in simulators().values() if not isinstance(known, str)]
    return [_entrant(known, problem) for known in found if problem.name in known.chosen] + [_many(problem)]


def _many(problem: PushProblem) -> Entrant:
    """This package's engine on the same problem, many pushes in one call."""
    pushes = problem.pushes * _REPEATED
    model = problem.model(ENGINE.chosen[problem.name].accuracy)
    return Entrant(ONE_CALL, _in_one_call(model, pushes), len(pushes), "the first row's pushes and ends")


def _entrant(simulator: Simulator, problem: PushProblem) -> Entrant:
    settings = simulator.chosen[problem.name]
    runner = simulator.build(problem, settings)
    ends = problem.ends(runner.end_pose)
    finer = simulator.build(problem, simulator.finer(settings))
    off, own = distance(ends, problem.converged), distance(ends[:_LIMIT], problem.ends(finer.end_pose, _LIMIT))
    told = "" if off.near and own.near else "NOT CONVERGED: "
    note = f"{told}off by {off}; from its own limit {own}"
    return Entrant(
        f"{simulator.name} {simulator.version}", lambda: problem.ends(runner.end_pose), len(problem.pushes), note
    )


def even_entrants() -> list[Entrant]:
    """This package's usual push, MIT's on plywood under even pressure: many in one call."""
    theta = np.linspace(0.0, math.tau, _MANY, endpoint=False)
    loop = CollectionLoop.mit(accuracy=EVEN_ACCURACY)
    even = [(Pose(theta=t), loop.push) for t in theta.tolist()]
    note = f"in one call: off by {_even_distance(loop, theta)}"
    return [
        Entrant(EVEN, _in_one_call(loop.model, even), _MANY, note),
        Entrant(DRAGGED, lambda: loop.cycles(theta), _MANY, f"{note}, `CollectionLoop.cycles`"),
    ]


def _even_distance(loop: CollectionLoop, theta: np.ndarray) -> Distance:
    """The worst distance of a loop's pushes from those at 1e-11 rad."""
    found, exact = (which.cycles(theta) for which in (loop, replace(loop, accuracy=1e-11)))
    return distance(*([_pose(one, i) for i in range(theta.size)] for one in (found, exact)))


def _pose(cycles: Any, i: int) -> Pose:
    return Pose(*cycles.push_displacement[i].tolist(), float(cycles.push_turn[i]))


def _in_one_call(model: QuasiStaticModel, pushes: Sequence[tuple[Pose, SidePush]]) -> Callable[[], object]:
    """The pushes alone, without the way back."""
    courses = [model.course(model.push_strokes(pose, push), pose) for pose, push in pushes]
    return lambda: run_strokes(courses)
