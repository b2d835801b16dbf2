"""Standard errors, intervals and open directions agree with what is known in closed form."""

import math

import numpy as np
import pytest
from scipy.stats import t as student
from stand_ins import ELLIPSE, TRUTH, force_block, motion_block

from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import FunctionBlock, JointProblem, Values
from cyclemap.evidence.identification.identifiability import uncertainty
from cyclemap.evidence.identification.identify import identify
from cyclemap.evidence.identification.least_squares import fit_with_noise
from cyclemap.evidence.identification.surface_parameters import SURFACE, Parameter, ParameterSpace
from cyclemap.evidence.laws.linear_fit import student_quantile

X = np.linspace(0.0, 1.0, 12)
LINE = ParameterSpace(
    (Parameter("level", "value at zero", "m", -9.0, 9.0, 0.0, 1.0), Parameter("slope", "", "m", -9.0, 9.0, 0.0, 1.0))
)
DESIGN = np.stack([np.ones(12), X], axis=-1)


def line(data: np.ndarray, groups: np.ndarray | None = None) -> JointProblem:
    def law(values: Values) -> tuple[np.ndarray, np.ndarray]:
        return values["level"] + values["slope"] * X - data, DESIGN

    labels = np.arange(12) if groups is None else groups
    return JointProblem((FunctionBlock("line", ("level", "slope"), law, labels, "m"),), LINE, {})


def line_data(seed: int = 0) -> np.ndarray:
    return np.asarray(1.0 + 2.0 * X + 0.1 * np.random.default_rng(seed).standard_normal(12))


def test_a_straight_line_has_the_textbook_errors_and_its_interval_is_students() -> None:
    problem = line(line_data())
    fit = fit_with_noise(problem, LINE.start)
    errors = uncertainty(problem, fit)
    best, squares, _, _ = np.linalg.lstsq(DESIGN, line_data(), rcond=None)
    covariance = squares[0] / 10 * np.linalg.inv(DESIGN.T @ DESIGN)
    assert np.allclose(fit.vector, best, atol=1e-9)
    assert np.allclose(errors.covariance, covariance, rtol=1e-6)
    assert np.allclose(errors.freedom, 10.0)
    assert errors.open == ()
    found = identify(problem.blocks, LINE.names, space=LINE, starts=1)
    for index, name in enumerate(LINE.names):
        half = student.ppf(0.975, 10) * math.sqrt(covariance[index, index])
        ends = [found[name].lower, found[name].upper]
        assert np.allclose(ends, [best[index] - half, best[index] + half], atol=2e-5)


def test_rows_written_down_twice_as_one_group_tell_no_more_than_once() -> None:
    """Six places, each measured once but entered twice: grouped errors see six values, not twelve."""
    places = np.repeat(X[::2], 2)
    data = 1.0 + np.repeat(0.1 * np.random.default_rng(1).standard_normal(6), 2)

    def law(values: Values) -> tuple[np.ndarray, np.ndarray]:
        return values["level"] - data, np.ones((12, 1))

    block = FunctionBlock("twice", ("level",), law, np.repeat(np.arange(6), 2), "m")
    problem = JointProblem((block,), LINE.select(("level",)), {})
    errors = uncertainty(problem, fit_with_noise(problem, np.zeros(1)))
    assert len(places) == 12
    assert np.isclose(errors.standard_error[0], np.std(data[::2], ddof=1) / np.sqrt(6), rtol=1e-9)
    assert np.isclose(errors.freedom[0], 5.0)


def test_the_mean_of_two_samples_weighed_by_their_own_noise_varies_as_meier_says() -> None:
    """Meier (1953): (1 + 2 sum w (1 - w) / f) / sum(n / s^2), w the shares and f the freedoms of the two noises.

    What is reported adds the same again, for the bias of the first factor.
    """
    kinds = np.repeat(["a", "b"], [8, 20])
    data = np.where(kinds == "a", 0.1, 0.4) * np.random.default_rng(8).standard_normal(28)
    block = FunctionBlock("two", ("level",), lambda v: (v["level"] - data, np.ones((28, 1))), np.arange(28), kinds)
    problem = JointProblem((block,), LINE.select(("level",)), {})
    fit = fit_with_noise(problem, np.zeros(1))
    precision = np.array([8, 20]) / fit.noise**2
    share, plain = precision / np.sum(precision), 1.0 / np.sum(precision)
    extra = 2.0 * np.sum(share * (1.0 - share) / (np.array([8, 20]) - share)) * plain
    assert np.isclose(uncertainty(problem, fit).covariance[0, 0], plain + 2.0 * extra, rtol=1e-9)


def test_known_noise_gives_the_normal_quantile_and_its_own_errors() -> None:
    problem = line(line_data())
    errors = uncertainty(problem, fit_with_noise(problem, LINE.start, known={"m": 0.5}))
    assert np.allclose(errors.covariance, 0.25 * np.linalg.inv(DESIGN.T @ DESIGN), rtol=1e-9)
    assert student_quantile(0.95, float(errors.freedom[0])) == pytest.approx(1.959964, abs=1e-6)


def product(noise: float = 0.01) -> JointProblem:
    """Data that depend on the product of two parameters alone, and not at all on a third."""
    rng = np.random.default_rng(7)
    data = 0.3 * X + noise * rng.standard_normal(12)

    def law(values: Values) -> tuple[np.ndarray, np.ndarray]:
        a, b = values["pin"], values["lever"]
        return a * b * X - data, np.stack([b * X, a * X, 0.0 * X], axis=-1)

    names = ("pin", "lever", "idle")
    space = ParameterSpace(tuple(Parameter(name, "", "1", 0.1, 3.0, 0.6, 0.1) for name in names))
    return JointProblem((FunctionBlock("product", names, law, np.arange(12), "1"),), space, {})


def test_parameters_that_trade_off_are_named_and_have_their_whole_range() -> None:
    problem = product()
    fit = fit_with_noise(problem, problem.space.start)
    errors = uncertainty(problem, fit)
    assert np.all(np.isinf(errors.standard_error))
    assert sorted(len(direction.names) for direction in errors.open) == [1, 2]
    text = " ".join(str(direction) for direction in errors.open)
    assert "idle is not fixed by the data" in text
    assert "pin and lever trade off" in text or "lever and pin trade off" in text
    found = identify(problem.blocks, problem.space.names, space=problem.space, starts=1)
    for name in problem.space.names:
        assert (found[name].lower, found[name].upper, found[name].identifiable) == (0.1, 3.0, False)


def test_motion_alone_leaves_the_scale_of_friction_open_and_forces_fix_it() -> None:
    blind = FunctionBlock("still", ("friction_scale",), lambda v: (X, np.zeros((12, 1))), np.arange(12), "1")
    motion = JointProblem((blind, motion_block(20, 0.02, 0.002)), SURFACE.select(("friction_scale", *ELLIPSE[1:])), {
        name: TRUTH[name] for name in ("pusher_friction", "rim_share")
    })  # fmt: skip
    fit = fit_with_noise(motion, motion.space.start)
    assert [str(direction) for direction in uncertainty(motion, fit).open] == [
        "friction_scale is not fixed by the data"
    ]
    forced = JointProblem((*motion.blocks, force_block(12, 0.01)), motion.space, motion.fixed)
    assert uncertainty(forced, fit_with_noise(forced, forced.space.start)).open == ()


@pytest.mark.parametrize("level", [0.0, 1.0, -1.0])
def test_a_level_must_be_a_probability(level: float) -> None:
    with pytest.raises(InvalidInput, match="must be a probability"):
        student_quantile(level, 5.0)
