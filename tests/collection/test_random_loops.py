"""Cycles drawn from everything that can be asked for are done, their forces balanced, or refused for a stated reason.

`python -m tests.benchmarks.random_cases` runs any number of them.
"""

from collections import Counter

import numpy as np
import pytest
from random_loops import SHARES, fates, random_loop, random_object, worst_residual

from cyclemap.collection import CollectionLoop
from cyclemap.errors import ConvergenceError, TooManySteps, UnsupportedContact
from cyclemap.mechanics import Ellipse, PatchFootprint, Polygon

pytestmark = pytest.mark.filterwarnings("ignore::cyclemap.errors.DoubtfulInput")

# MIT's square, a thin rectangle, and a concave pentagon.
SOME = (1, 4, 6)


def test_random_cycles_are_done_with_residuals_below_1e_9_or_refused_for_a_stated_reason():
    words, residuals = Counter(), []
    for number in SOME:
        found = fates(3, number, 40)
        words.update(fate.word for fate in found)
        done = [fate for fate in found if fate.word == "done"]
        residuals += [worst_residual(fate.loop.cycle(fate.theta)) for fate in done[::10]]
    assert words["done"] >= 100 and words["failed"] == 0 and words.total() == 120
    assert len(residuals) >= 8
    assert max(residuals) <= 1e-9


def test_the_cases_are_spread_over_what_can_be_asked_for():
    """Every outline and kind of footprint, and of each other thing both ends."""

    rng = np.random.default_rng(5)
    objects = [random_object(rng, number) for number in range(64)]
    outlines = [base.slider.outline for base in objects]
    assert sum(isinstance(outline, Ellipse) for outline in outlines) > 10
    assert sum(isinstance(outline, Polygon) and not outline.is_convex for outline in outlines) > 3
    pressures = [base.model.pressure for base in objects]
    patches = [pressure for pressure in pressures if isinstance(pressure, PatchFootprint)]
    assert len(patches) == 60
    assert sum(patch.gradient != (0.0, 0.0) for patch in patches) > 10
    for share in SHARES:
        assert sum(getattr(patch, share) > 0.01 for patch in patches) > 4


def test_the_loops_are_spread_over_what_can_be_asked_for():
    """Of each thing both ends."""
    rng = np.random.default_rng(5)
    base = random_object(rng, 1)
    loops = [random_loop(rng, base) for _ in range(300)]
    laws = [loop.material.friction for loop in loops]
    ratios = [max(law.mu_a / law.mu_b, law.mu_b / law.mu_a) for law in laws]
    assert min(ratios) == 1.0 and max(ratios) > 8.0
    assert {loop.push.side for loop in loops} == {0, 1, 2, 3}
    assert {len(loop.reset.way_points) for loop in loops} == {0, 1, 3}
    for values in (
        [loop.pusher.friction for loop in loops],
        [loop.pusher.radius for loop in loops],
        [loop.reset.pin_friction_radius for loop in loops],
        [abs(loop.push.angle) for loop in loops],
    ):
        assert min(values) < 0.05 * max(values)
    assert min(loop.accuracy for loop in loops) < 1e-9 and max(loop.accuracy for loop in loops) > 1e-5


@pytest.mark.parametrize(
    ("error", "word"), [(ConvergenceError, "failed"), (UnsupportedContact, "refused"), (TooManySteps, "refused")]
)
def test_an_error_that_is_no_stated_refusal_counts_as_a_failure(monkeypatch, error, word):
    def refuse(loop, theta):
        raise error("as told")

    monkeypatch.setattr(CollectionLoop, "cycle", refuse)
    assert [fate.word for fate in fates(3, 1, 3)] == [word] * 3
