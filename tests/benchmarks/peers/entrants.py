"""Who takes part in a table: simulators built and warm, with how far they are from converged,
measured on the spot.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from math import tau
from typing import Any

import numpy as np

from cyclemap.collection import CollectionLoop
from cyclemap.mechanics import Pose, QuasiStaticModel, SidePush
from cyclemap.mechanics.quasi_static import run_strokes
from tests.benchmarks.peers.package_push import ACCURACY, DYNAMIC, ENGINE
from tests.benchmarks.peers.plain_push import NUMPY, SCIPY
from tests.benchmarks.peers.push_problem import ANGLES, PushProblem, Simulator, distance

# Pushes of which a simulator's own limit is computed: one of each angle of approach.
_LIMIT = len(ANGLES)
# This package's engine on the problem itself; and its rows under even pressure: pushes alone, with
# the way back.
ONE_CALL, EVEN, DRAGGED = "many in one call", "even pressure", "with the drag back"
# Pushes in one call: of a problem's, so many times; under even pressure, from so many orientations.
_REPEATED, _MANY = 20, 240
# Coarsest accuracy at which the object's corners end within 10 µm of where they should; the table
# tells how far.
EVEN_ACCURACY = 1e-3


@dataclass(frozen=True)
class Entrant:
    """name : with its version.
    run : does its pushes, so many.
    note : what is to be known of their ends.
    """

    name: str
    run: Callable[[], Any]
    pushes: int
    note: str


def engine(name: str) -> Simulator | str:
    """The simulator of a physics engine, `mujoco` or `drake`; where it is not installed, the reason
    in words.
    """
    try:
        found: Simulator = import_module(f"tests.benchmarks.peers.{name}_push").SIMULATOR
    except ModuleNotFoundError as missing:
        return f"{name} takes no part: {missing}; install the extra `peers`"
    return found


def simulators() -> list[Simulator | str]:
    """All simulators, this package's engine first; in place of those not installed why they take no
    part.
    """
    return [ENGINE, engine("mujoco"), engine("drake"), DYNAMIC, SCIPY, NUMPY]


def entrants(problem: PushProblem) -> list[Entrant]:
    """All that take part in a problem, this package's engine first; last its pushes in one call."""
    rows = []
    for known in simulators():
        if isinstance(known, str) or problem.name not in known.problems:
            continue
        end_pose = known.build(problem)
        ends, finer = problem.ends(end_pose), problem.ends(known.build(problem, finer=True), _LIMIT)
        off, own = distance(ends, problem.converged), distance(ends[:_LIMIT], finer)
        note = (
            f"{'' if off.near and own.near else 'NOT CONVERGED: '}off by {off}; from its own "
            f"limit {own}"
        )
        rows.append(
            Entrant(
                f"{known.name} {known.version}",
                partial(problem.ends, end_pose),
                len(problem.pushes),
                note,
            )
        )
    pushes = problem.pushes * _REPEATED
    run = _in_one_call(problem.model(ACCURACY[problem.name]), pushes)
    return [*rows, Entrant(ONE_CALL, run, len(pushes), "the first row's pushes and ends")]


def even_entrants() -> list[Entrant]:
    """This package's usual push, MIT's on plywood under even pressure: many in one call."""
    theta = np.linspace(0.0, tau, _MANY, endpoint=False)
    loop = CollectionLoop.mit(accuracy=EVEN_ACCURACY)
    ends = []
    for which in (loop, replace(loop, accuracy=1e-11)):
        runs = which.cycles(theta)
        moved = np.column_stack([runs.push_displacement, runs.push_turn])
        ends.append([Pose(*row) for row in moved.tolist()])
    note = f"in one call: off by {distance(*ends)}"
    even = [(Pose(theta=t), loop.push) for t in theta.tolist()]
    return [
        Entrant(EVEN, _in_one_call(loop.model, even), _MANY, note),
        Entrant(DRAGGED, lambda: loop.cycles(theta), _MANY, f"{note}, `CollectionLoop.cycles`"),
    ]


def _in_one_call(
    model: QuasiStaticModel, pushes: list[tuple[Pose, SidePush]]
) -> Callable[[], object]:
    """The pushes alone, without the way back."""
    courses = [model.course(model.push_strokes(pose, push), pose) for pose, push in pushes]
    return lambda: run_strokes(courses)
