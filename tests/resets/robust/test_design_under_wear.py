"""A reset on a surface that wears: frozen laws at its ends, the course of the law between them, and redesigns."""

from dataclasses import replace

import numpy as np
import pytest
from robust_cases import EVEN, GRID, LAW, NOISE, ROUGH, SHORT, WEARING, short_loop

from cyclemap.collection.wearing_loop import worn_loop
from cyclemap.errors import InvalidInput
from cyclemap.maps import RandomMap, sample_random_paths
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.mechanics import Wear, load_material
from cyclemap.resets.robust.design_under_wear import redesign_under_wear, reset_under_wear
from cyclemap.resets.robust.material_score import material_score, sample_cycles
from cyclemap.resets.robust.wear_stages import stationary_law, wear_path
from cyclemap.resets.robust.worst_case import Allowance
from cyclemap.resets.strategies.drag_strategies import StraightReset
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes, side_pushes

PAIR = DrawnPushes(side_pushes(SHORT, (0, 2)))
LOOP = short_loop(WEARING)
PUSHES = 40


@pytest.fixture(scope="module")
def course():
    return reset_under_wear(LOOP, PAIR, PUSHES, knots=5, noise=NOISE, grid=GRID)


def test_a_surface_that_wears_to_itself_keeps_its_law():
    """The frozen law is constant, and the law of the orientation goes to it and stays."""
    same = replace(WEARING, wear=Wear(LAW, 40.0))
    still = reset_under_wear(short_loop(same), PAIR, 600, knots=3, noise=NOISE, grid=GRID)
    frozen = [still.frozen_variation(push) for push in (0, 150, 599)]
    assert np.ptp(frozen) < 1e-12 and still.blend_error < 1e-12
    assert abs(still.variation[-1] - frozen[0]) < 1e-6 and still.variation.size == 599


def test_frozen_laws_at_the_ends_are_those_of_the_fresh_and_the_worn_material(course):
    for push, cycles in ((0, 0.0), (40, 40.0)):
        here = material_score(worn_loop(LOOP, cycles), PAIR, noise=NOISE, grid=GRID)
        assert course.frozen_variation(push) == pytest.approx(here.total_variation, abs=1e-9)
    fresh, worn = course.stages[0].frozen_law(0), course.stages[0].frozen_law(40)
    assert float(fresh.total_variation(worn)) > 0.01


def test_the_law_of_the_collection_is_that_of_sampled_collections():
    """Against 4000 sampled paths of the frozen maps of each push: first moments of the whole collection."""
    short = reset_under_wear(LOOP, PAIR, 12, start=1.0, knots=4, noise=NOISE, grid=GRID)
    theta, total = np.full(4000, 1.0), 0.0
    for push in range(11):
        maps = sample_cycles(worn_loop(LOOP, push), PAIR.law().actions, GRID).maps
        theta = sample_random_paths(RandomMap(maps, None, NOISE), 1, theta, seed=push)[:, 1]
        total += np.exp(1j * theta).mean() / 11
    assert abs(short.collection.moments[1] - total) < 5.0 / np.sqrt(4000 * 11)
    assert abs(total) > 0.04


def test_the_collections_law_is_the_mean_of_the_pushes_laws(course):
    """Its bias is at most the mean of theirs: total variation is convex."""
    assert course.collection_variation <= course.variation.mean() + 1e-12
    assert course.variation[0] > 0.5 > course.variation[-1]


def test_the_push_that_leaves_the_allowance_is_the_first_one(course):
    biases = [course.frozen_variation(push) for push in range(PUSHES)]
    limit = 0.5 * (biases[0] + max(biases))
    first = next(push for push, bias in enumerate(biases) if bias > limit)
    assert course.leaves(limit) == first > 0
    assert course.leaves(0.9 * min(biases)) == 0 and course.leaves(1.1 * max(biases)) is None


def test_knots_between_agree_with_surfaces_computed_there(course):
    """Blending operators errs at second order: halfway between knots by less than the blend error of every second."""
    middle = 0.5 * (course.stages[0].knots[1] + course.stages[0].knots[2])
    exact = reset_under_wear(LOOP, PAIR, PUSHES, knots=9, noise=NOISE, grid=GRID).stages[0]
    between = course.stages[0].frozen_law(middle).total_variation(exact.frozen_law(middle))
    assert middle in exact.knots and float(between) <= course.blend_error < 0.01


def test_stages_follow_each_other(course):
    """The law up to a change is that of the first strategy alone; afterwards the frozen law is the second's."""
    sides = DrawnPushes(side_pushes(SHORT, (1, 3)))
    staged = reset_under_wear(LOOP, [(0, PAIR), (20, sides)], PUSHES, knots=5, noise=NOISE, grid=GRID)
    alone = reset_under_wear(LOOP, sides, PUSHES, knots=5, noise=NOISE, grid=GRID)
    assert len(staged.stages) == 2 and staged.stage(19) is staged.stages[0] and staged.stage(20) is staged.stages[1]
    assert np.abs(staged.variation[:20] - course.variation[:20]).max() < 2e-3
    assert staged.frozen_variation(30) == pytest.approx(alone.frozen_variation(30), abs=2e-3)
    assert np.abs(staged.variation[20:] - course.variation[20:]).max() > 2e-3


def test_on_even_friction_nothing_wears_the_evenness_off():
    even = reset_under_wear(short_loop(EVEN), StraightReset(), 300, knots=2, noise=NOISE, grid=GRID)
    assert even.frozen_variation(100) < 1e-6 and even.leaves(1e-4) is None and even.variation[-1] < 1e-2


def test_a_wear_path_runs_from_the_fresh_to_the_worn_friction():
    path = wear_path(WEARING, 40, 3)
    assert [one.friction for one in path] == [LAW, WEARING.friction_after(20.0), WEARING.wear.friction]
    assert all(one.wear is None for one in path) and wear_path(WEARING, 40, 2, 20)[0].friction == path[1].friction


def test_a_redesign_has_one_design_a_stage():
    """Each made for its own part of the wear, and with its first push, as reset_under_wear takes them."""
    easy = Allowance(0.5, 0.5, 10)
    options = {"allowance": easy, "grid": GRID, "noise": NOISE, "starts": 1, "count": 2}
    plan = redesign_under_wear(LOOP, 40, side_pushes(SHORT, (0, 1)), stages=2, on_path=2, **options)
    assert [first for first, _ in plan] == [0, 20] and all(design.holds for _, design in plan)
    assert [one.scenarios[0].friction for _, one in plan] == [LAW, WEARING.friction_after(20.0)]
    course = reset_under_wear(LOOP, [(n, one.strategy) for n, one in plan], 40, knots=2, noise=NOISE, grid=GRID)
    assert len(course.stages) == 2 and course.variation.size == 39


def test_the_stationary_law_is_one_that_a_cycle_leaves_as_it_is():
    rng = np.random.default_rng(0)
    matrix = 0.2 * rng.standard_normal((9, 9)) / 3.0
    matrix[0] = np.eye(9)[0]
    law = stationary_law(matrix)
    known = np.concatenate([law.moments.real, law.moments.imag[1:]])
    assert np.abs(matrix @ known - known).max() < 1e-14 and isinstance(law, FourierLaw)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda: wear_path(ROUGH, 10, 2), "does not wear"),
        (lambda: wear_path(load_material("plywood"), 10, 2), "does not wear"),
        (lambda: reset_under_wear(LOOP, [(1, PAIR)], 10), "the first at 0"),
        (lambda: reset_under_wear(LOOP, [(0, PAIR), (10, PAIR)], 10), "below 10"),
        (lambda: reset_under_wear(LOOP, [], 10), "the first at 0"),
        (lambda: reset_under_wear(LOOP, PAIR, 10, knots=1), "at least 2"),
        (lambda: reset_under_wear(LOOP, AlternatingPushes(PAIR.pushes), 10), "know of each other"),
        (lambda: redesign_under_wear(LOOP, 2, stages=3), "do not fit"),
    ],
)
def test_what_cannot_be_followed_is_refused(wrong, words):
    with pytest.raises(InvalidInput, match=words):
        wrong()
