"""Random cycles across everything that can be asked for: each is done, or refused for a reason that
is stated.

Run `python -m tests.benchmarks.random_cases --count N --seed S` from the repository's root. Loops
of tests/collection's random_loops.py are run one by one; trajectories of a share of them are
checked by the residuals that they tell and by the independent balance of forces of
tests/mechanics/force_balance.py. It prints what became of them, and every failure with what makes
it again; its exit code is 1 where there is one, or a residual above 1e-9.
"""

import argparse
import os
import sys
import time
import warnings
from collections import Counter
from dataclasses import replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from cyclemap.collection import Cycle
from cyclemap.errors import DoubtfulInput

sys.path.insert(0, str(Path(__file__).parents[1] / "collection"))
sys.path.insert(0, str(Path(__file__).parents[1] / "mechanics"))
from force_balance import check
from random_loops import fates, worst_residual

ALLOWED = 1e-9


def imbalance(cycle: Cycle) -> float:
    """How far forces along a cycle are from what the ground can do, or outside the cone, relative
    to the friction.
    """
    model, pin, worst = cycle.loop.model, cycle.loop.reset.pin_friction_radius, 0.0
    for stroke in (cycle.push, *([cycle.drag] if cycle.drag_length > 0.0 else [])):
        found = check(model, stroke.trajectory, pin)
        worst = max(worst, found.surface, found.cone)
    return worst


def check_object(
    seed: int, number: int, count: int, every: int
) -> tuple[Counter[str], float, list[str]]:
    """Words of the cases of an object, their worst residual, and what to complain of."""
    words: Counter[str] = Counter()
    worst, complaints = 0.0, []
    for index, fate in enumerate(fates(seed, number, count)):
        words[fate.word] += 1
        # What makes the case again.
        told = f"object {number}, case {index}, theta {fate.theta!r}: "
        told += repr(replace(fate.loop, footprint=fate.loop.model.pressure))
        if fate.refusal is not None:
            # A refusal by its name and first words, without its numbers.
            plain = [
                word
                for word in str(fate.refusal).split()
                if not any(sign.isdigit() for sign in word)
            ]
            words[f"{type(fate.refusal).__name__} ({' '.join(plain[:7])})"] += 1
        if fate.word == "failed":
            complaints.append(f"{type(fate.refusal).__name__}: {fate.refusal}\n  {told}")
        if fate.word == "done" and index % every == 0:
            cycle = fate.loop.cycle(fate.theta)
            residual = max(worst_residual(cycle), imbalance(cycle))
            words["balanced"] += 1
            worst = max(worst, residual)
            if not residual <= ALLOWED:
                complaints.append(f"residual {residual:.2e}\n  {told}")
    return words, worst, complaints


def main() -> None:
    """Print what became of all cases."""
    parser = argparse.ArgumentParser(
        description="Random cycles across everything that can be asked for."
    )
    parser.add_argument("--count", type=int, default=10_000, help="cycles")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--every", type=int, default=10, help="every so many-th one is balanced")
    asked = parser.parse_args()
    # Rings on long arms and odd surfaces are meant here.
    warnings.simplefilter("ignore", DoubtfulInput)
    objects = 24 + asked.count // 2000
    words, worst, failures, begun = Counter(), 0.0, 0, time.perf_counter()
    for number in range(objects):
        share = asked.count * (number + 1) // objects - asked.count * number // objects
        found, residual, complaints = check_object(asked.seed, number, share, asked.every)
        words, worst, failures = words + found, max(worst, residual), failures + len(complaints)
        for complaint in complaints:
            print(complaint, flush=True)
        so_far = ", ".join(f"{count} {word}" for word, count in sorted(words.items()))
        taken = time.perf_counter() - begun
        print(
            f"{number + 1} of {objects} objects, {taken:.0f} s: {so_far}; worst residual "
            f"{worst:.1e}",
            flush=True,
        )
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
