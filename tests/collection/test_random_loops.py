"""Cycles drawn from everything that can be asked for are done, their forces balanced, or refused
for a stated reason.

`python -m tests.benchmarks.random_cases` runs any number of them.
"""

from collections import Counter

import pytest
from random_loops import fates, worst_residual

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
