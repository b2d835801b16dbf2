"""Least squares weighs kinds by their noise, turns with the world, and survives starts without an
answer.
"""

from itertools import product

import numpy as np
import pytest
from refusals import refused
from scipy import stats
from stand_ins import ELLIPSE, MOTION, TRUTH, fitted, force_block, motion_block

from cyclemap.errors import ConvergenceError, InvalidInput, UnsupportedContact
from cyclemap.evidence import DataBlock
from cyclemap.evidence.identification.data_block import JointProblem
from cyclemap.evidence.identification.identifiability import uncertainty
from cyclemap.evidence.identification.least_squares import NoiseLaw, multi_start, spread_starts
from cyclemap.evidence.identification.surface_parameters import SURFACE, Values

SPACE = SURFACE.select((*ELLIPSE, "pusher_friction", "plate_dome"))


def joint(noise: float) -> JointProblem:
    return JointProblem(
        (force_block(noise=noise), motion_block(16, 2 * noise, 0.2 * noise)), SPACE, {}
    )


def means(*samples: tuple[str, np.ndarray]) -> JointProblem:
    """The mean of several samples, each a kind of its own: the textbook's common mean."""
    data, kinds = (
        np.concatenate([s for _, s in samples]),
        np.concatenate([[k] * len(s) for k, s in samples]),
    )
    design, groups = np.ones((len(data), 1)), np.arange(len(data))
    block = DataBlock(
        "means", ("offset_x",), lambda v: (v["offset_x"] - data, design), groups, kinds
    )
    return JointProblem((block,), SURFACE.select(("offset_x",)), {})


def test_two_kinds_share_a_mean_as_their_noise_weighs_it() -> None:
    """Each kind's noise solves the equations of restricted maximum likelihood, to a thousandth as
    promised.
    """
    rng = np.random.default_rng(3)
    a, b = 0.1 + 0.01 * rng.standard_normal(8), 0.1 + 0.05 * rng.standard_normal(20)
    problem = means(("a", a), ("b", b))
    fit = fitted(problem, problem.space.start)
    weight = np.array([8, 20]) / fit.noise**2
    share = weight / np.sum(weight)
    assert np.isclose(fit.vector[0], share @ [np.mean(a), np.mean(b)], atol=1e-5)
    squares = [np.sum((a - fit.vector[0]) ** 2), np.sum((b - fit.vector[0]) ** 2)]
    assert np.allclose(fit.noise**2, squares / (np.array([8, 20]) - share), rtol=2e-3)
    given = fitted(problem, problem.space.start, known={"a": 0.01, "b": 0.05})
    assert given.noise.tolist() == [0.01, 0.05]


def with_holes(problem: JointProblem, threshold: float, error: type[Exception]) -> JointProblem:
    """The model has no answer where the rod's friction exceeds the threshold."""
    block = problem.blocks[1]

    def law(values: Values) -> tuple[np.ndarray, np.ndarray]:
        if values["pusher_friction"] > threshold:
            raise error("no answer there")
        return block.residuals(values)

    holed = DataBlock("holed", MOTION, law, block.groups, block.kinds)
    return JointProblem((problem.blocks[0], holed), problem.space, {})


@pytest.mark.parametrize("error", [ConvergenceError, UnsupportedContact, InvalidInput])
def test_starts_without_an_answer_are_recorded_and_passed_over(error: type[Exception]) -> None:
    problem = with_holes(joint(0.01), 0.21, error)
    found = multi_start(problem, spread_starts(problem, 9, seed=0))
    assert 1 <= len(found.failures) <= 7 and set(found.failures) == {
        f"{error.__name__}: no answer there"
    }
    whole = fitted(joint(0.01), SPACE.start)
    errors = uncertainty(joint(0.01), whole).standard_error
    assert np.all(np.abs(found.best.vector - whole.vector) < errors / 20.0), (
        "all that the noise's tolerance promises"
    )


def test_if_no_start_has_an_answer_the_first_reason_is_told() -> None:
    problem = with_holes(joint(0.01), -1.0, UnsupportedContact)
    told = "none of 3 starts has an answer; the first: UnsupportedContact: no ans"
    refused(
        multi_start, problem, spread_starts(problem, 3, seed=0), told=told, kind=ConvergenceError
    )


def test_a_search_that_meets_a_hole_on_its_way_turns_back() -> None:
    problem = with_holes(joint(0.0), 0.13, ConvergenceError)
    start = SPACE.vector({**TRUTH, "pusher_friction": 0.05})
    fit = fitted(problem, start, known=dict.fromkeys(problem.kind_names, 0.01))
    assert fit.vector[5] <= 0.13 and np.isfinite(fit.deviance)


def test_student_noise_lets_outliers_count_for_little() -> None:
    clean = 0.1 + 0.01 * np.random.default_rng(5).standard_normal(40)
    problem = means(("m", clean + 0.5 * (np.arange(40) < 4)))
    normal, robust = (
        fitted(problem, np.zeros(1), NoiseLaw(freedom)).vector[0] for freedom in (None, 4.0)
    )
    assert abs(normal - 0.15) < 0.01 and abs(robust - np.mean(clean)) < 0.003


def test_the_deviance_is_minus_twice_the_log_likelihood_but_for_a_constant() -> None:
    """Whether the noise is given, of one kind or two, or found; also what Student's law gives."""
    rng = np.random.default_rng(8)
    samples = ("a", 0.1 + 0.01 * rng.standard_normal(8)), ("b", 0.05 * rng.standard_normal(20))
    problem = means(*samples)
    for freedom, known in product((None, 4.0), (None, {"a": 0.02}, {"a": 0.02, "b": 0.5})):
        fit = fitted(problem, problem.space.start, NoiseLaw(freedom), known)
        law = stats.norm if freedom is None else stats.t(freedom)
        size = fit.noise[problem.kind_index]
        logs = law.logpdf(fit.residuals / size) - law.logpdf(0.0) - np.log(size)
        assert fit.deviance == pytest.approx(-2.0 * np.sum(logs), rel=1e-12)


def test_the_best_of_several_starts_is_the_likeliest_whichever_comes_first() -> None:
    """Of two minima the one with the smaller residuals: the noise found at each makes the sum of
    squares over it the same.
    """
    rng = np.random.default_rng(2)
    scatter, rows = 0.01 * rng.standard_normal(30), np.arange(30)

    def law(values: Values) -> tuple[np.ndarray, np.ndarray]:
        x = values["offset_x"]
        # On average nought at both 0.2 and -0.2, but there with five times the scatter.
        away = 0.05 * (x < 0.0) * (-1.0) ** rows
        return (x - 0.2) * (x + 0.2) + away + scatter, np.full((30, 1), 2.0 * x)

    block = DataBlock("two", ("offset_x",), law, rows, np.full(30, "m"))
    problem = JointProblem((block,), SURFACE.select(("offset_x",)), {})
    starts = np.array([[-0.18], [0.18]])
    for order in (starts, starts[::-1]):
        found = multi_start(problem, order)
        assert found.best.vector[0] == pytest.approx(0.2, abs=0.02) and found.arrived == 1


def test_a_kind_that_the_parameters_follow_wholly_asks_for_its_noise() -> None:
    problem = means(("a", np.array([0.1])))
    refused(
        fitted,
        problem,
        problem.space.start,
        told="can follow all rows of 'a'",
        kind=ConvergenceError,
    )
    assert fitted(problem, problem.space.start, known={"a": 0.01}).vector[0] == pytest.approx(0.1)


def test_starts_are_seeded_lie_within_the_bounds_and_begin_with_the_natural_one() -> None:
    starts, again = (spread_starts(joint(0.0), 12, seed=4) for _ in range(2))
    assert np.array_equal(starts, again) and np.array_equal(starts[0], SPACE.start)
    assert np.all((starts >= SPACE.lower) & (starts <= SPACE.upper))
    assert np.unique(starts, axis=0).shape == (12, 7)
