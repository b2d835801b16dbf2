"""The worst of a strategy over materials: the largest of the single scores, whoever computes them."""

import math

import numpy as np
import pytest
from robust_cases import GRID, NOISE, ROUGH, SHORT, short_loop

from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.mechanics import SidePush
from cyclemap.resets.robust.material_range import MaterialRange
from cyclemap.resets.robust.material_score import MaterialScore, material_score
from cyclemap.resets.robust.sampled_materials import SampledMaterials
from cyclemap.resets.robust.sampling_confidence import share_bound
from cyclemap.resets.robust.scenario_loops import loop_on
from cyclemap.resets.robust.worst_case import Allowance, WorstCase, spread_work, worst_case, worst_scores
from cyclemap.resets.strategies.drag_strategies import StraightReset, WayPoints
from cyclemap.resets.strategies.push_strategies import DrawnPushes, side_pushes

PAIR = DrawnPushes(side_pushes(SHORT, (0, 2)))
ABOUT = MaterialRange(ROUGH)


def test_scores_are_the_same_from_one_process_and_from_two():
    """Bit for bit and in order; each is the score of its own material; progress rises to one."""
    seen: list[float] = []
    once = worst_case(short_loop(ROUGH), PAIR, ABOUT, count=4, grid=GRID, progress=seen.append)
    twice = worst_case(short_loop(ROUGH), PAIR, ABOUT, count=4, grid=GRID, workers=2)
    assert once.scores == twice.scores and len(once.scores) == 4 and seen == [0.25, 0.5, 0.75, 1.0]
    alone = material_score(loop_on(short_loop(ROUGH), once.sample.materials[2]), PAIR, grid=GRID)
    assert once.scores[2] == alone and once.nominal == material_score(short_loop(ROUGH), PAIR, grid=GRID)
    assert once.worst()[1].total_variation == once.column("total_variation").max()
    assert not once.direction_matters and "phi" not in once.sample.names


def test_a_range_of_no_width_has_exactly_the_nominal_bias():
    still = MaterialRange(ROUGH, ratio=0.0, offset=0.0)
    found = worst_case(short_loop(ROUGH), PAIR, still, count=2, grid=GRID)
    assert set(found.scores) == {material_score(short_loop(ROUGH), PAIR, grid=GRID)}


def test_the_direction_is_drawn_for_a_strategy_with_directions_of_its_own():
    about, fixed = MaterialRange(ROUGH, offset=0.0), WayPoints(((0.05, 0.0),))
    found = worst_case(short_loop(ROUGH), fixed, about, count=2, noise=NOISE, grid=GRID)
    assert found.direction_matters and found.sample.names == ("ratio", "phi")
    assert found.sample.materials[1].friction.phi != ROUGH.friction.phi


def test_the_worst_material_is_scored_by_adaptive_maps_too():
    found = worst_case(short_loop(ROUGH), PAIR, MaterialRange(ROUGH, offset=0.0), count=3, noise=NOISE, grid=GRID)
    exact = worst_scores(short_loop(ROUGH), found, noise=NOISE, tolerance=1e-3, modes=16, bounded=False)
    assert float(exact.evenness.total_variation) == pytest.approx(found.worst()[1].total_variation, abs=2e-3)
    assert found.worst()[1].total_variation > found.nominal.total_variation


def made_up(values: list[float], chosen: int = 2, independent: bool = True) -> WorstCase:
    scores = tuple(MaterialScore(value, value, 0.1, 0.1, 0.0) for value in values)
    points = np.linspace(-1.0, 1.0, len(values))[:, None]
    sample = SampledMaterials((ROUGH,) * len(values), points, ("ratio",), chosen, independent, cube=independent)
    return WorstCase(StraightReset(), sample, scores, Allowance(), False)


def test_those_that_exceed_are_counted_and_their_share_bounded():
    """Of drawn materials only: chosen ones are no sample. Sobol points are not independent: no bound."""
    found = made_up([0.2, 0.01, *[0.02] * 18, 0.06, 0.07])
    assert len(found.exceeding) == 3 and not found.holds
    assert found.share_exceeding == share_bound(2, 20) and found.quantile(0.5) == 0.02
    unknown = made_up([0.01] * 5, independent=False)
    assert math.isnan(unknown.share_exceeding) and math.isnan(unknown.variation_between)
    held = made_up([0.01] * 1002)
    assert held.holds and 0.0029 < held.share_exceeding < 0.003
    assert held.variation_between == pytest.approx(0.01)


def test_an_allowance_is_kept_only_when_all_three_are():
    allowance = Allowance()
    assert allowance.is_met(MaterialScore(0.05, 0.1, 0.2, 0.1, 0.0))
    for over in ((0.051, 0.1, 0.2), (0.05, 0.101, 0.2), (0.05, 0.1, 0.201)):
        assert (
            not allowance.is_met(MaterialScore(*over, 0.1, 0.0))
            and allowance.excess(MaterialScore(*over, 0.1, 0.0)) > 0
        )


def test_an_error_names_the_material():
    missing = DrawnPushes((SHORT, SidePush(side=7)))
    with pytest.raises(CycleMapError, match=r"^rough: "):
        worst_case(short_loop(ROUGH), missing, ABOUT, count=1, grid=GRID)


def test_bad_questions_are_refused():
    with pytest.raises(InvalidInput, match="scores have no 'tv'"):
        made_up([0.1, 0.1]).column("tv")
    with pytest.raises(InvalidInput, match="total variation is above 0"):
        Allowance(total_variation=0.0)
    with pytest.raises(InvalidInput, match="workers must be at least 1"):
        list(spread_work(abs, [1, 2], -1))
