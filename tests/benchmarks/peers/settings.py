"""Search for the settings at which a simulator is fastest among those that end within what is asked of converged.

Run `python -m tests.benchmarks.peers.settings mujoco --minutes 10` from the repository's root; it prints every better
settings it finds. Settings are changed at random, by factors that shrink while nothing better is found (Rechenberg,
1973); what counts is the processor's time of a push, times a penalty for what is missing from converged: from the
quasi-static answer in all twelve pushes, and from the simulator's own limit of ever finer steps in three of them.
"""

import argparse
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from tests.benchmarks.peers.push_problem import (
    ANGLES,
    CORNERS,
    NEAR_DEG,
    NEAR_MM,
    Distance,
    PushProblem,
    Simulator,
    distance,
    four_corners,
    plain_grid,
)
from tests.benchmarks.peers.simulators import simulators

_TRIED = len(ANGLES)
# Settings are kept a little inside of what is asked: what is measured anew may come out a little different.
_MARGIN = 0.93
_PENALTY = 3.0
_WIDEST, _NARROWEST, _WIDEN, _SHRINK = 1.0, 0.05, 1.3, 0.97


@dataclass(frozen=True)
class Trial:
    """Settings that were tried: time (s) of a push, and how far it ends from the right answer and its own limit."""

    settings: Any
    seconds: float
    off: Distance
    own: Distance

    @property
    def cost(self) -> float:
        """Seconds, more where too much is missing from converged."""
        missing = max(_missing(self.off), _missing(self.own))
        return self.seconds * max(1.0, missing / _MARGIN) ** _PENALTY

    def __str__(self) -> str:
        return f"{1e3 * self.seconds:.3g} ms, off by {self.off}, from its own limit by {self.own}: {self.settings}"


def _missing(off: Distance) -> float:
    return max(off.place_mm / NEAR_MM, off.turn_deg / NEAR_DEG)


def run_trial(simulator: Simulator, problem: PushProblem, settings: Any, bar: float = math.inf) -> Trial | None:
    """Try settings; None where the simulator gives up, and as soon as they are seen to cost more than `bar`."""
    try:
        runner = simulator.build(problem, settings)
        runner.end_pose(*problem.pushes[0])
        start = time.process_time()
        ends = problem.ends(runner.end_pose, _TRIED)
        seconds = (time.process_time() - start) / _TRIED
        trial = Trial(settings, seconds, distance(ends, problem.converged[:_TRIED]), Distance(0.0, 0.0))
        if trial.cost >= bar:
            return None
        trial = replace(trial, off=distance(problem.ends(runner.end_pose), problem.converged))
        if trial.cost >= bar:
            return None
        finer = simulator.build(problem, simulator.finer(settings))
        return replace(trial, own=distance(ends, problem.ends(finer.end_pose, _TRIED)))
    except (ArithmeticError, AssertionError, RuntimeError, ValueError):
        return None


def search(simulator: Simulator, problem: PushProblem, minutes: float, seed: int) -> Iterator[Trial]:
    """Yield ever better trials, the chosen settings first."""
    random, width = np.random.default_rng(seed), _WIDEST
    best = run_trial(simulator, problem, simulator.chosen[problem.name])
    assert best is not None, "the chosen settings do not work"
    yield best
    stop = time.monotonic() + 60.0 * minutes
    while time.monotonic() < stop:
        trial = run_trial(simulator, problem, _changed(simulator, best.settings, width, random), best.cost)
        if trial is not None and trial.cost < best.cost:
            best, width = trial, min(_WIDEST, _WIDEN * width)
            yield best
        else:
            width = max(_NARROWEST, _SHRINK * width)


def _changed(simulator: Simulator, settings: Any, width: float, random: np.random.Generator) -> Any:
    """Settings of which about half are changed by a random factor, within their bounds."""
    kinds = {field.name: type(getattr(settings, field.name)) for field in fields(settings)}
    values = {}
    for name, (low, high) in simulator.searched.items():
        if random.random() < 0.5:
            factor = math.exp(width * random.normal())
            value = min(high, max(low, factor * getattr(settings, name)))
            values[name] = round(value) if kinds[name] is int else float(f"{value:.4g}")
    return replace(settings, **values)


def main() -> None:
    """Search for one simulator's settings on one problem."""
    known = simulators()
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.peers.settings", description=__doc__)
    parser.add_argument("simulator", choices=known)
    parser.add_argument("--problem", choices=("corners", "grid"), default="corners")
    parser.add_argument("--minutes", type=float, default=5.0)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    simulator = known[asked.simulator]
    problem = four_corners() if asked.problem == "corners" else plain_grid()
    if isinstance(simulator, str):
        parser.error(simulator)
    if problem.name not in simulator.chosen:
        parser.error(f"{asked.simulator} takes no part in {problem.name}, only in {CORNERS}")
    for trial in search(simulator, problem, asked.minutes, asked.seed):
        print(trial, flush=True)


if __name__ == "__main__":
    main()
