"""Weights for many materials at once: better in the worst of them than any made for one, and checked on all."""

from dataclasses import replace

import numpy as np
import pytest
from robust_cases import EVEN, GRID, LAW, ROUGH, SHORT, short_loop

from cyclemap.errors import InvalidInput
from cyclemap.maps import WrappedNormal
from cyclemap.mechanics import Material
from cyclemap.resets.drawn_pushes.push_weights import best_push_weights, push_weights
from cyclemap.resets.robust.robust_weights import choice_of_pushes, robust_push_weights
from cyclemap.resets.robust.sampled_materials import MaterialList
from cyclemap.resets.robust.scenario_weights import least_worst_weights, scenario_library, scenario_row
from cyclemap.resets.robust.worst_case import Allowance

LOOP = short_loop(ROUGH)
CHOICE = [replace(SHORT, side=side, fraction=place) for side, place in ((0, 0.3), (0, 0.7), (1, 0.7), (2, 0.3))]
TURNED = Material("turned", replace(LAW, m0=-0.04, n0=0.03, mu_a=0.3))
SLOW = Allowance(total_variation=0.2, reach=0.8, pushes=10)


@pytest.fixture(scope="module")
def rows():
    return [scenario_row(LOOP, CHOICE, GRID, one) for one in (ROUGH, TURNED, EVEN)]


@pytest.fixture(scope="module")
def library(rows):
    return scenario_library(CHOICE, rows, WrappedNormal(0.1), 16)


def test_a_library_of_scenarios_has_their_cycles(rows, library):
    """One map a push and material, through cycles of the mechanics; on even friction every map is a rotation."""
    assert library.matrices.shape == (3, 4, 33, 33) and library.mean_drags.shape == (3, 4)
    at = 2.0 * np.pi * 5 / GRID.samples
    count = 0
    for row in rows:
        for push, one in zip(CHOICE, row.maps, strict=True):
            assert float(one(at)) == pytest.approx(replace(row.loop, push=push).cycle(at).theta_next, abs=1e-4)
            count += 1
    assert count == 12 and max(np.ptp(one.derivative(np.arange(6.0))) for one in rows[2].maps) < 1e-4


def test_the_worst_scenario_is_as_good_as_in_a_search_over_all(rows, library):
    """Searching among those that count loses nothing, and no single material's best is better in the worst case."""
    own = np.array([row.own_drag for row in rows])
    found = least_worst_weights(library, own, SLOW, None, 2, 0)
    over_all = best_push_weights(library, drag_limit=2.0 * own, within=10, extra_tv=0.8, starts=2)
    assert found.tv.shape == (3,) and found.met
    assert found.tv.max() <= over_all.tv.max() + 5e-4
    for number in range(2):
        single = scenario_library(CHOICE, [rows[number]], WrappedNormal(0.1), 16)
        alone = best_push_weights(single, drag_limit=2.0 * own[number], within=10, extra_tv=0.8, starts=1)
        spread = push_weights(library, alone.numbers, alone.weights, within=10, extra_tv=0.8)
        assert spread.tv.max() >= found.tv.max() - 5e-4


class Hidden(MaterialList):
    """Materials of which the scenarios show the first alone."""

    def scenarios(self):
        return self.sampled(1)

    def without_direction(self):
        return self


OPTIONS = {"grid": GRID, "noise": WrappedNormal(0.1), "starts": 1, "count": 2}


def test_a_design_that_holds_is_checked_on_every_material():
    held = robust_push_weights(LOOP, [ROUGH, TURNED], CHOICE, allowance=SLOW, **OPTIONS)
    assert held.holds and len(held.history) == 1 and held.scenarios == (ROUGH, TURNED)
    assert held.check.worst()[1].total_variation == pytest.approx(held.found.tv.max(), abs=1e-3)


def test_the_worst_material_that_exceeds_becomes_a_scenario(rows):
    """Made for one material it misses the allowance on the other; that is added, and then the two together hold."""
    both = scenario_library(CHOICE, rows[:2], WrappedNormal(0.1), 16)
    best = least_worst_weights(both, np.array([row.own_drag for row in rows[:2]]), SLOW, None, 1, 0).tv.max()
    between = Allowance(best + 2e-3, 0.8, 10)
    made = robust_push_weights(LOOP, Hidden((ROUGH, TURNED)), CHOICE, allowance=between, **OPTIONS)
    assert made.scenarios == (ROUGH, TURNED) and len(made.history) == 2 and made.holds
    assert made.history[0] > between.total_variation > made.history[1]
    assert made.history[1] == pytest.approx(best, abs=1e-3)


def test_an_allowance_that_cannot_be_kept_ends_with_the_scenario_that_misses_it():
    strict = Allowance(total_variation=1e-4, reach=0.8, pushes=10)
    missed = robust_push_weights(LOOP, [ROUGH, TURNED], CHOICE[:2], allowance=strict, **OPTIONS)
    assert not missed.holds and len(missed.history) == 1 and len(missed.scenarios) == 2
    assert missed.check.worst()[0] in missed.scenarios and set(missed.found.pushes) <= set(CHOICE[:2])


def test_pushes_to_choose_from_are_the_loops_on_every_side():
    made = choice_of_pushes(LOOP)
    assert len(made) == 16 and {push.side for push in made} == {0, 1, 2, 3} and {p.distance for p in made} == {0.06}
    with pytest.raises(InvalidInput, match="one or more of SidePush"):
        choice_of_pushes(LOOP, ["side 0"])
