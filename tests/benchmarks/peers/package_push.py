"""The push by this package: its quasi-static engine, and the paper's dynamic simulation."""

import cyclemap
from cyclemap.mechanics import DynamicModel
from tests.benchmarks.peers.push_problem import CORNERS, GRID, EndPose, PushProblem, Simulator

# rad, of each problem: the coarsest of 1e-2, 1e-3, ... at which no corner of the object ends more
# than 10 µm off.
ACCURACY = {CORNERS: 1e-2, GRID: 1e-3}
# Speed, stiffness, damping, regularisation and tolerance of `DynamicModel`.
DYNAMIC_SETTINGS = {
    CORNERS: (0.02168, 3.31e4, 1.12, 8.27e-4, 4.24e-5),
    GRID: (0.004325, 2.366e5, 4.85, 6.66e-4, 2.95e-5),
}


def engine_push(problem: PushProblem, finer: bool = False) -> EndPose:
    """`QuasiStaticModel.push`, one push a call; finer at a thousandth of the accuracy."""
    model = problem.model((1e-3 if finer else 1.0) * ACCURACY[problem.name])
    return lambda pose, push: model.push(pose, push).end


def dynamic_push(problem: PushProblem, finer: bool = False) -> EndPose:
    """`DynamicModel.push` on the support points, until the object rests; finer at a thousandth of
    the tolerance.
    """
    *settings, tolerance = DYNAMIC_SETTINGS[problem.name]
    tolerance *= 1e-3 if finer else 1.0
    model = DynamicModel(
        problem.slider,
        problem.friction,
        problem.pusher,
        problem.footprint,
        *settings,
        tolerance=tolerance,
    )
    return lambda pose, push: model.push(pose, push, samples=1).end


ENGINE = Simulator("cyclemap", cyclemap.__version__, engine_push)
DYNAMIC = Simulator("cyclemap, dynamic", cyclemap.__version__, dynamic_push)
