"""The push by this package: its quasi-static engine, and the paper's dynamic simulation."""

from dataclasses import dataclass, replace

import cyclemap
from cyclemap.mechanics import DynamicModel, Pose, SidePush
from tests.benchmarks.peers.push_problem import CORNERS, GRID, PushProblem, Simulator


@dataclass(frozen=True)
class EngineSettings:
    """The accuracy asked of `QuasiStaticModel`, rad."""

    accuracy: float


class EnginePush:
    """`QuasiStaticModel.push`, one push a call."""

    def __init__(self, problem: PushProblem, settings: EngineSettings) -> None:
        self._model = problem.model(settings.accuracy)

    def end_pose(self, pose: Pose, push: SidePush) -> Pose:
        """The object's pose when the rod stops, or leaves."""
        return self._model.push(pose, push).end


@dataclass(frozen=True)
class DynamicSettings:
    """What the accuracy and the time of a push hang on: see `DynamicModel`."""

    speed: float
    stiffness: float
    regularisation: float
    tolerance: float
    damping: float = 1.0


class DynamicPush:
    """`DynamicModel.push` on the problem's support points."""

    def __init__(self, problem: PushProblem, settings: DynamicSettings) -> None:
        self._model = DynamicModel(
            problem.slider,
            problem.friction,
            problem.pusher,
            problem.footprint,
            settings.speed,
            settings.stiffness,
            settings.damping,
            settings.regularisation,
            settings.tolerance,
        )

    def end_pose(self, pose: Pose, push: SidePush) -> Pose:
        """The object's pose once it rests."""
        return self._model.push(pose, push, samples=1).end


ENGINE = Simulator(
    "cyclemap",
    cyclemap.__version__,
    EnginePush,
    # The coarsest of 1e-2, 1e-3, ... at which no corner of the object ends more than 10 µm off.
    chosen={CORNERS: EngineSettings(1e-2), GRID: EngineSettings(1e-2)},
    finer=lambda settings: replace(settings, accuracy=1e-3 * settings.accuracy),
    searched={"accuracy": (1e-8, 1e-2)},
)
DYNAMIC = Simulator(
    "cyclemap, dynamic",
    cyclemap.__version__,
    DynamicPush,
    # Found by `python -m tests.benchmarks.peers.settings dynamic`, and again with `--problem grid`.
    chosen={
        CORNERS: DynamicSettings(0.02168, 3.31e4, 8.27e-4, 4.24e-5, 1.12),
        GRID: DynamicSettings(0.004325, 2.366e5, 6.66e-4, 2.95e-5, 4.85),
    },
    finer=lambda settings: replace(settings, tolerance=1e-3 * settings.tolerance),
    searched={
        "speed": (0.002, 0.1),
        "stiffness": (2e4, 1e8),
        "regularisation": (1e-6, 0.1),
        "tolerance": (1e-6, 1e-3),
        "damping": (0.1, 10.0),
    },
)
