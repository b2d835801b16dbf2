"""Least squares weighs kinds by their noise and survives starts without an answer; standard errors,
intervals and open directions agree with what is known in closed form.
"""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from refusals import refused
from scipy import stats
from scipy.stats import t as student
from stand_ins import MOTION, SPACE, TRUTH, fitted, joint

from cyclemap.errors import ConvergenceError, InvalidInput, UnsupportedContact
from cyclemap.evidence import DataBlock, Parameter, ParameterSpace, identify
from cyclemap.evidence.identification.data_block import JointProblem, linear_block
from cyclemap.evidence.identification.least_squares import (
    NoiseLaw,
    multi_start,
    spread_starts,
    uncertainty,
)
from cyclemap.evidence.identification.surface_parameters import SURFACE, Values

X = np.linspace(0.0, 1.0, 12)
DESIGN = np.stack([np.ones(12), X], axis=-1)
LINE = ParameterSpace(
    tuple(Parameter(name, "", "m", -9.0, 9.0, 0.0, 1.0) for name in ("level", "slope"))
)
DATA = 1.0 + 2.0 * X + 0.1 * np.random.default_rng(0).standard_normal(12)
BLOCK = linear_block("line", LINE.names, DESIGN, DATA, np.arange(12), "m")
PROBLEM = JointProblem((BLOCK,), LINE, {})


def level_of(data: np.ndarray, groups: np.ndarray, kinds: object = "m") -> JointProblem:
    block = linear_block("level", ("level",), np.ones((len(data), 1)), data, groups, kinds)
    return JointProblem((block,), LINE.select(("level",)), {})


def means(*samples: tuple[str, np.ndarray]) -> JointProblem:
    """The mean of several samples, each a kind of its own: the textbook's common mean."""
    data = np.concatenate([sample for _, sample in samples])
    kinds = np.repeat([kind for kind, _ in samples], [len(sample) for _, sample in samples])
    return level_of(data, np.arange(len(data)), kinds)


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
    assert 1 <= len(found.failures) <= 7
    assert set(found.failures) == {f"{error.__name__}: no answer there"}
    whole = fitted(joint(0.01), SPACE.start)
    errors = uncertainty(joint(0.01), whole).standard_error
    assert np.all(np.abs(found.best.vector - whole.vector) < errors / 20.0)


def test_if_no_start_has_an_answer_the_first_reason_is_told() -> None:
    problem = with_holes(joint(0.01), -1.0, UnsupportedContact)
    told = "none of 3 starts has an answer; the first: UnsupportedContact: no ans"
    starts = spread_starts(problem, 3, seed=0)
    refused(multi_start, problem, starts, told=told, kind=ConvergenceError)


def test_a_search_that_meets_a_hole_on_its_way_turns_back() -> None:
    problem = with_holes(joint(0.0), 0.13, ConvergenceError)
    start = SPACE.vector({**TRUTH, "pusher_friction": 0.05})
    fit = fitted(problem, start, known=dict.fromkeys(problem.kind_names, 0.01))
    assert fit.vector[5] <= 0.13 and np.isfinite(fit.deviance)


def test_student_noise_lets_outliers_count_for_little() -> None:
    clean = 0.1 + 0.01 * np.random.default_rng(5).standard_normal(40)
    problem = means(("m", clean + 0.5 * (np.arange(40) < 4)))
    fits = [fitted(problem, np.zeros(1), NoiseLaw(freedom)) for freedom in (None, 4.0)]
    normal, robust = (fit.vector[0] for fit in fits)
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
    problem, told = means(("a", np.array([0.1]))), "can follow all rows of 'a'"
    refused(fitted, problem, problem.space.start, told=told, kind=ConvergenceError)
    assert fitted(problem, problem.space.start, known={"a": 0.01}).vector[0] == pytest.approx(0.1)


def test_starts_are_seeded_lie_within_the_bounds_and_begin_with_the_natural_one() -> None:
    starts, again = (spread_starts(joint(0.0), 12, seed=4) for _ in range(2))
    assert np.array_equal(starts, again) and np.array_equal(starts[0], SPACE.start)
    assert np.all((starts >= SPACE.lower) & (starts <= SPACE.upper))
    assert np.unique(starts, axis=0).shape == (12, 7)


def test_a_straight_line_has_the_textbook_errors_and_its_interval_is_students() -> None:
    fit = fitted(PROBLEM, LINE.start)
    errors = uncertainty(PROBLEM, fit)
    best, squares, _, _ = np.linalg.lstsq(DESIGN, DATA, rcond=None)
    covariance = squares[0] / 10 * np.linalg.inv(DESIGN.T @ DESIGN)
    assert np.allclose(fit.vector, best, atol=1e-9)
    assert np.allclose(errors.covariance, covariance, rtol=1e-6)
    assert np.allclose(errors.freedom, 10.0) and errors.open == ()
    found = identify([BLOCK], LINE.names, space=LINE, starts=1)
    half = student.ppf(0.975, 10) * np.sqrt(np.diag(covariance))
    intervals = [[one.lower, one.upper] for one in found.estimates]
    assert np.allclose(intervals, best[:, None] + np.outer(half, [-1, 1]), atol=2e-5)


def test_rows_written_down_twice_as_one_group_tell_no_more_than_once() -> None:
    data = np.random.default_rng(1).standard_normal(6)
    problem = level_of(np.repeat(data, 2), np.repeat(np.arange(6), 2))
    errors = uncertainty(problem, fitted(problem, np.zeros(1)))
    assert np.isclose(errors.standard_error[0], np.std(data, ddof=1) / np.sqrt(6), rtol=1e-9)
    assert np.isclose(errors.freedom[0], 5.0)


def test_the_mean_of_two_samples_weighed_by_their_own_noise_varies_as_meier_says() -> None:
    """Meier (1953): (1 + 2 sum w (1 - w) / f) / sum(n / s^2), w the shares and f the freedoms of
    the two noises.

    What is reported adds the same again, for the bias of the first factor.
    """
    count, kinds = np.array([8, 20]), np.repeat(["a", "b"], [8, 20])
    data = np.where(kinds == "a", 0.1, 0.4) * np.random.default_rng(8).standard_normal(28)
    problem = means(("a", data[:8]), ("b", data[8:]))
    fit = fitted(problem, np.zeros(1))
    plain = 1.0 / np.sum(count / fit.noise**2)
    share = plain * count / fit.noise**2
    extra = 2.0 * np.sum(share * (1.0 - share) / (count - share)) * plain
    assert np.isclose(uncertainty(problem, fit).covariance[0, 0], plain + 2.0 * extra, rtol=1e-9)


def test_parameters_that_trade_off_are_named_and_have_their_whole_range() -> None:
    """Data that depend on the product of two parameters alone, and not at all on a third."""
    data = 0.3 * X + 0.01 * np.random.default_rng(7).standard_normal(12)

    def law(values: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
        a, b = values["pin"], values["lever"]
        return a * b * X - data, np.stack([b * X, a * X, 0.0 * X], axis=-1)

    names = ("pin", "lever", "idle")
    space = ParameterSpace(tuple(Parameter(name, "", "1", 0.1, 3.0, 0.6, 0.1) for name in names))
    block = DataBlock("product", names, law, np.arange(12), "1")
    found = identify([block], names, space=space, starts=1)
    assert np.all(np.isinf(found.uncertainty.standard_error))
    assert len(found.uncertainty.open) == 2 and "idle is not fixed by the data" in found.notes
    told = " ".join(found.notes)
    assert "pin and lever trade off" in told or "lever and pin trade off" in told
    ranges = {(row.lower, row.upper, row.identifiable) for row in found.estimates}
    assert ranges == {(0.1, 3.0, False)}


def test_rows_of_known_noise_count_alone_though_they_share_groups() -> None:
    """Of a straight line with noise that was given the covariance is the inverse information."""
    block = replace(BLOCK, groups=np.arange(12) // 3)
    found = identify([block], LINE.names, noise={"m": 0.05}, starts=1, space=LINE)
    information = DESIGN.T @ DESIGN / 0.05**2
    assert found.uncertainty.covariance == pytest.approx(np.linalg.inv(information), rel=1e-6)
    level = found["level"]
    assert level.upper - level.value == pytest.approx(1.959964 * level.standard_error, rel=1e-6)
    free = identify([block], LINE.names, starts=1, space=LINE)
    assert free.uncertainty.freedom.max() < 12.0 < found.uncertainty.freedom.min()
