"""Standard errors, intervals and open directions agree with what is known in closed form."""

import numpy as np
import pytest
from scipy.stats import t as student
from stand_ins import fitted

from cyclemap.evidence import DataBlock, Parameter, ParameterSpace, identify
from cyclemap.evidence.identification.data_block import JointProblem
from cyclemap.evidence.identification.identifiability import uncertainty
from cyclemap.evidence.laws.linear_fit import student_quantile

X = np.linspace(0.0, 1.0, 12)
DESIGN = np.stack([np.ones(12), X], axis=-1)
LINE = ParameterSpace(
    tuple(Parameter(name, "", "m", -9.0, 9.0, 0.0, 1.0) for name in ("level", "slope"))
)
DATA = 1.0 + 2.0 * X + 0.1 * np.random.default_rng(0).standard_normal(12)
BLOCK = DataBlock(
    "line", LINE.names, lambda v: (DESIGN @ LINE.vector(v) - DATA, DESIGN), np.arange(12), "m"
)
PROBLEM = JointProblem((BLOCK,), LINE, {})


def level_of(data: np.ndarray, groups: np.ndarray, kinds: object = "m") -> JointProblem:
    design = np.ones((len(data), 1))
    block = DataBlock("level", ("level",), lambda v: (v["level"] - data, design), groups, kinds)
    return JointProblem((block,), LINE.select(("level",)), {})


def test_a_straight_line_has_the_textbook_errors_and_its_interval_is_students() -> None:
    fit = fitted(PROBLEM, LINE.start)
    errors = uncertainty(PROBLEM, fit)
    best, squares, _, _ = np.linalg.lstsq(DESIGN, DATA, rcond=None)
    covariance = squares[0] / 10 * np.linalg.inv(DESIGN.T @ DESIGN)
    assert np.allclose(fit.vector, best, atol=1e-9) and np.allclose(
        errors.covariance, covariance, rtol=1e-6
    )
    assert np.allclose(errors.freedom, 10.0) and errors.open == ()
    found = identify([BLOCK], LINE.names, space=LINE, starts=1)
    half = student.ppf(0.975, 10) * np.sqrt(np.diag(covariance))
    intervals = [[one.lower, one.upper] for one in found.estimates]
    assert np.allclose(intervals, best[:, None] + np.outer(half, [-1, 1]), atol=2e-5)


def test_known_noise_gives_the_normal_quantile_and_its_own_errors() -> None:
    errors = uncertainty(PROBLEM, fitted(PROBLEM, LINE.start, known={"m": 0.5}))
    assert np.allclose(errors.covariance, 0.25 * np.linalg.inv(DESIGN.T @ DESIGN), rtol=1e-9)
    assert student_quantile(0.95, float(errors.freedom[0])) == pytest.approx(1.959964, abs=1e-6)


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
    problem = level_of(data, np.arange(28), kinds)
    fit = fitted(problem, np.zeros(1))
    share, plain = (
        count / fit.noise**2 / np.sum(count / fit.noise**2),
        1.0 / np.sum(count / fit.noise**2),
    )
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
    found = identify(
        [DataBlock("product", names, law, np.arange(12), "1")], names, space=space, starts=1
    )
    assert np.all(np.isinf(found.uncertainty.standard_error))
    assert len(found.uncertainty.open) == 2 and "idle is not fixed by the data" in found.notes
    assert any(
        f"{a} and {b} trade off" in " ".join(found.notes) for a, b in (names[:2], names[1::-1])
    )
    assert {(one.lower, one.upper, one.identifiable) for one in found.estimates} == {
        (0.1, 3.0, False)
    }


def test_rows_of_known_noise_count_alone_though_they_share_groups() -> None:
    """Of a straight line with noise that was given the covariance is the inverse information, to
    rounding.
    """
    x = np.linspace(0.0, 1.0, 12)
    columns = np.column_stack([np.ones(12), x])
    data = columns @ (0.3, 0.2) + 0.05 * np.cos(9.0 * x)

    def law(values):
        return columns @ (values["offset_x"], values["offset_y"]) - data, columns

    block = DataBlock("line", ("offset_x", "offset_y"), law, np.arange(12) // 3, "m")
    found = identify([block], ["offset_x", "offset_y"], noise={"m": 0.05}, starts=1)
    assert found.uncertainty.covariance == pytest.approx(
        0.05**2 * np.linalg.inv(columns.T @ columns), rel=1e-6
    )
    free = identify([block], ["offset_x", "offset_y"], starts=1)
    assert free.uncertainty.freedom.max() < 12.0 < found.uncertainty.freedom.min()
