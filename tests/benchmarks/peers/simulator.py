"""What is known of a simulator that takes part: how it is built, with which settings, and with which finer ones."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from cyclemap.mechanics import Pose, SidePush
from tests.benchmarks.peers.push_problem import PushProblem


class Runner(Protocol):
    """A simulator that is built and warm."""

    def end_pose(self, pose: Pose, push: SidePush) -> Pose:
        """The object's pose after a push from a pose."""


@dataclass(frozen=True)
class Simulator:
    """One simulator.

    build : from a problem and settings. chosen : settings by the problem's name; it takes part where it has some.
    finer : settings whose results stand for the limit of ever finer steps, all else being the same. searched : by the
    settings' names, between which values the search looks.
    """

    name: str
    version: str
    build: Callable[[PushProblem, Any], Runner]
    chosen: Mapping[str, Any]
    finer: Callable[[Any], Any]
    searched: Mapping[str, tuple[float, float]]
