"""Least squares finds parameters exactly, weighs kinds by their noise, and survives starts without an answer."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest
from stand_ins import ELLIPSE, MOTION, TRUTH, force_block, motion_block

from cyclemap.errors import ConvergenceError, InvalidInput, UnsupportedContact
from cyclemap.evidence.identification.data_block import FunctionBlock, JointProblem, Values
from cyclemap.evidence.identification.least_squares import NoiseLaw, fit_with_noise, multi_start, spread_starts
from cyclemap.evidence.identification.surface_parameters import SURFACE, SurfaceParameters

SPACE = SURFACE.select((*ELLIPSE, "pusher_friction", "rim_share"))


def joint(noise: float, seed: int = 0, count: int = 16) -> JointProblem:
    blocks = force_block(noise=noise, seed=seed), motion_block(count, 2 * noise, 0.2 * noise, seed)
    return JointProblem(blocks, SPACE, {})


def means(*samples: tuple[str, np.ndarray]) -> JointProblem:
    """The mean of several samples, each a kind of its own: the textbook's common mean."""
    data, kinds = np.concatenate([s for _, s in samples]), np.concatenate([[k] * len(s) for k, s in samples])

    def law(values: Values) -> tuple[np.ndarray, np.ndarray]:
        return values["offset_x"] - data, np.ones((len(data), 1))

    block = FunctionBlock("means", ("offset_x",), law, np.arange(len(data)), kinds)
    return JointProblem((block,), SURFACE.select(("offset_x",)), {})


def test_without_noise_every_start_finds_the_parameters_exactly() -> None:
    problem = joint(0.0)
    found = multi_start(problem, spread_starts(problem, 6, seed=1))
    assert found.arrived == found.count == 6
    assert found.failures == ()
    assert found.best.converged
    assert np.allclose(found.best.vector, SPACE.vector(TRUTH), atol=1e-9)


def test_the_noise_of_one_kind_is_the_standard_deviation_and_the_value_the_mean() -> None:
    data = 0.1 + 0.02 * np.random.default_rng(0).standard_normal(9)
    problem = means(("m", data))
    fit = fit_with_noise(problem, problem.space.start)
    assert np.isclose(fit.vector[0], np.mean(data), atol=1e-12)
    assert np.isclose(fit.noise[0], np.std(data, ddof=1), rtol=1e-9)
    assert fit.gradient < 1e-6


def test_two_kinds_share_a_mean_as_their_noise_weighs_it() -> None:
    """Each kind's noise solves the equations of restricted maximum likelihood, to a thousandth as promised."""
    rng = np.random.default_rng(3)
    a, b = 0.1 + 0.01 * rng.standard_normal(8), 0.1 + 0.05 * rng.standard_normal(20)
    problem = means(("a", a), ("b", b))
    fit = fit_with_noise(problem, problem.space.start)
    weight = np.array([8, 20]) / fit.noise**2
    share = weight / np.sum(weight)
    assert np.isclose(fit.vector[0], share @ [np.mean(a), np.mean(b)], atol=1e-5)
    squares = [np.sum((a - fit.vector[0]) ** 2), np.sum((b - fit.vector[0]) ** 2)]
    assert np.allclose(fit.noise**2, squares / (np.array([8, 20]) - share), rtol=2e-3)
    given = fit_with_noise(problem, problem.space.start, known={"a": 0.01, "b": 0.05})
    assert given.noise.tolist() == [0.01, 0.05]


def test_turning_the_world_turns_the_answer() -> None:
    """The same forces, seen in axes turned by an angle, give the turned friction and the same fit."""
    angle, block = 0.7, force_block(10, 0.01)
    law = dataclasses.replace(SurfaceParameters.from_values(TRUTH).to_friction())
    c, k = np.cos(angle), np.sin(angle)

    def turned(values: Values) -> tuple[np.ndarray, np.ndarray]:
        back = SurfaceParameters.from_friction(SurfaceParameters.from_values(values).to_friction().turned(-angle))
        residual, jacobian = block.residuals(back.values())
        spin = np.eye(5)
        spin[1:3, 1:3] = [[np.cos(2 * angle), np.sin(2 * angle)], [-np.sin(2 * angle), np.cos(2 * angle)]]
        spin[3:, 3:] = [[c, k], [-k, c]]
        return residual, jacobian @ spin

    fits = []
    for one in (block, dataclasses.replace(block, function=turned)):
        problem = JointProblem((one,), SURFACE.select(ELLIPSE), {})
        fits.append(fit_with_noise(problem, problem.space.start))
    first, second = (SurfaceParameters(*fit.vector.tolist()) for fit in fits)
    expected = SurfaceParameters.from_friction(first.to_friction().turned(angle))
    assert np.allclose(list(second.values().values()), list(expected.values().values()), atol=1e-6)
    assert np.isclose(fits[0].deviance, fits[1].deviance, atol=1e-6)
    assert abs(first.to_friction().mu_a - law.mu_a) < 0.02


def test_a_truth_beyond_a_bound_ends_on_it_and_says_so() -> None:
    narrow = replace(SPACE["rim_share"], lower=0.45, upper=0.9, start=0.675, nominal=0.45)
    problem = JointProblem((force_block(), motion_block()), SPACE.extended(narrow), {})
    fit = fit_with_noise(problem, problem.space.start)
    assert fit.on_bounds == ("rim_share",)
    assert abs(fit.vector[-1] - 0.45) < 1e-3
    assert fit.converged


def with_holes(problem: JointProblem, threshold: float, error: type[Exception]) -> JointProblem:
    """The model has no answer where the rod's friction exceeds the threshold."""
    block = problem.blocks[1]

    def law(values: Values) -> tuple[np.ndarray, np.ndarray]:
        if values["pusher_friction"] > threshold:
            raise error("no answer there")
        return block.residuals(values)

    holed = FunctionBlock("holed", MOTION, law, block.groups, block.kinds)
    return JointProblem((problem.blocks[0], holed), problem.space, {})


@pytest.mark.parametrize("error", [ConvergenceError, UnsupportedContact, InvalidInput])
def test_starts_without_an_answer_are_recorded_and_passed_over(error: type[Exception]) -> None:
    problem = with_holes(joint(0.01), 0.21, error)
    found = multi_start(problem, spread_starts(problem, 9, seed=0))
    assert 1 <= len(found.failures) <= 7
    assert set(found.failures) == {f"{error.__name__}: no answer there"}
    whole = fit_with_noise(joint(0.01), SPACE.start)
    assert np.allclose(found.best.vector, whole.vector, atol=5e-5)


def test_if_no_start_has_an_answer_the_first_reason_is_told() -> None:
    problem = with_holes(joint(0.01), -1.0, UnsupportedContact)
    with pytest.raises(ConvergenceError, match="none of 3 starts has an answer; the first: UnsupportedContact: no ans"):
        multi_start(problem, spread_starts(problem, 3, seed=0))


def test_a_search_that_meets_a_hole_on_its_way_turns_back() -> None:
    """The best point without the hole lies within it, so the search ends outside with a finite deviance."""
    problem = with_holes(joint(0.0), 0.13, ConvergenceError)
    start = SPACE.vector({**TRUTH, "pusher_friction": 0.05})
    fit = fit_with_noise(problem, start, known=dict.fromkeys(problem.kind_names, 0.01))
    assert fit.vector[5] <= 0.13
    assert np.isfinite(fit.deviance)


def test_student_noise_lets_outliers_count_for_little() -> None:
    clean = 0.1 + 0.01 * np.random.default_rng(5).standard_normal(40)
    spoiled = clean.copy()
    spoiled[:4] += 0.5
    normal, robust = (
        fit_with_noise(means(("m", spoiled)), np.zeros(1), NoiseLaw(freedom)).vector[0] for freedom in (None, 4.0)
    )
    assert abs(normal - 0.15) < 0.01
    assert abs(robust - np.mean(clean)) < 0.003


def test_a_kind_that_the_parameters_follow_wholly_asks_for_its_noise() -> None:
    problem = means(("a", np.array([0.1])))
    with pytest.raises(ConvergenceError, match="can follow all rows of 'a'"):
        fit_with_noise(problem, problem.space.start)
    assert fit_with_noise(problem, problem.space.start, known={"a": 0.01}).vector[0] == pytest.approx(0.1)
    with pytest.raises(InvalidInput, match="unknown kind of noise 'b'"):
        fit_with_noise(problem, problem.space.start, known={"b": 0.01})
    with pytest.raises(InvalidInput, match="must exceed one"):
        NoiseLaw(0.5)


def test_starts_are_seeded_lie_within_the_bounds_and_begin_with_the_natural_one() -> None:
    problem = joint(0.0)
    starts = spread_starts(problem, 12, seed=4)
    assert starts.shape == (12, 7)
    assert np.array_equal(starts, spread_starts(problem, 12, seed=4))
    assert np.array_equal(starts[0], SPACE.start)
    assert np.all((starts >= SPACE.lower) & (starts <= SPACE.upper))
    assert len(np.unique(starts, axis=0)) == 12
