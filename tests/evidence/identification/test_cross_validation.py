"""Rows left out leave whole, are predicted without having been seen, and their errors are summed up as they are."""

import numpy as np
import pytest
from stand_ins import ELLIPSE, TRUTH, force_block, motion_block

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.identification.cross_validation import cross_validate, kind_errors, random_folds
from cyclemap.evidence.identification.data_block import FunctionBlock, JointProblem, Values
from cyclemap.evidence.identification.least_squares import fit_with_noise
from cyclemap.evidence.identification.surface_parameters import SURFACE, Parameter, ParameterSpace

X = np.linspace(0.0, 1.0, 12)
DESIGN = np.stack([np.ones(12), X, X**2], axis=-1)
SPACE = ParameterSpace(tuple(Parameter(name, "", "1", -9.0, 9.0, 0.1, 1.0) for name in ("a", "b", "c")))
DATA = np.cos(3.0 * X) + 0.05 * np.random.default_rng(0).standard_normal(12)


def parabola(groups: np.ndarray) -> JointProblem:
    def law(values: Values) -> tuple[np.ndarray, np.ndarray]:
        return DESIGN @ SPACE.vector(values) - DATA, DESIGN

    return JointProblem((FunctionBlock("parabola", SPACE.names, law, groups, "1"),), SPACE, {})


def joint() -> JointProblem:
    space = SURFACE.select((*ELLIPSE, "pusher_friction", "rim_share"))
    return JointProblem((force_block(12, 0.01), motion_block(16, 0.02, 0.002)), space, {})


@pytest.mark.parametrize("size", [1, 2, 3])
def test_left_out_errors_of_a_linear_law_are_those_of_the_hat_matrix(size: int) -> None:
    """Of a group left out, the error is (1 - H)^-1 times the residuals, H its part of the hat matrix (Cook 1977)."""
    groups = np.arange(12) // size
    problem = parabola(groups)
    fit = fit_with_noise(problem, SPACE.start)
    hat = DESIGN @ np.linalg.inv(DESIGN.T @ DESIGN) @ DESIGN.T
    expected = np.concatenate(
        [
            np.linalg.solve(np.eye(size) - hat[np.ix_(rows, rows)], fit.residuals[rows])
            for rows in (np.flatnonzero(groups == group) for group in range(12 // size))
        ]
    )
    found = cross_validate(problem, fit, random_folds(problem, 12 // size))
    assert np.allclose(found.residuals, expected, atol=2e-4)
    assert found.failures == ()


def test_random_folds_keep_groups_whole_and_deal_every_block_evenly() -> None:
    problem = joint()
    fold = random_folds(problem, 4, seed=3)
    assert np.array_equal(fold, random_folds(problem, 4, seed=3))
    assert not np.array_equal(fold, random_folds(problem, 4, seed=4))
    assert all(len(np.unique(fold[problem.groups == group])) == 1 for group in range(28))
    assert np.bincount(fold[problem.block_index == 0]).tolist() == [6, 6, 6, 6]
    assert np.bincount(fold[problem.block_index == 1]).tolist() == [8, 8, 8, 8]


def test_rows_of_no_fold_always_stay() -> None:
    problem = joint()
    fold = np.where(problem.block_index == 1, problem.groups % 2, -1)
    found = cross_validate(problem, fit_with_noise(problem, problem.space.start), fold)
    assert np.all(np.isnan(found.residuals[problem.block_index == 0]))
    assert np.all(np.isfinite(found.residuals[problem.block_index == 1]))
    table = kind_errors(problem, fit_with_noise(problem, problem.space.start), found)
    assert [(row.block, row.kind, row.rows) for row in table] == [
        ("scan", "force (1)", 24),
        ("pushes", "shift (m)", 16),
        ("pushes", "turn (rad)", 16),
    ]
    assert np.isnan(table[0].left_out_rms)
    assert table[1].left_out_rms > table[1].rms


def test_sizes_of_errors_are_mean_median_and_root_mean_square() -> None:
    problem = parabola(np.arange(12))
    fit = fit_with_noise(problem, SPACE.start)
    (row,) = kind_errors(problem, fit, None)
    size = np.abs(fit.residuals)
    assert (row.mean, row.median) == (np.mean(size), np.median(size))
    assert np.isclose(row.rms, np.sqrt(np.mean(size**2)))
    assert np.isnan(row.left_out_mean)


def test_a_fold_without_an_answer_is_recorded_and_its_rows_stay_unknown() -> None:
    whole = motion_block(16, 0.02, 0.002)

    class Fragile:
        name, parameters, groups = "fragile", whole.parameters, whole.groups
        kinds, residuals = whole.kinds, whole.residuals

        def subset(self, keep_groups: np.ndarray) -> FunctionBlock:
            if 0 not in keep_groups and len(keep_groups) > 8:
                raise ConvergenceError("cannot do without the first push")
            return whole.subset(keep_groups)

    space = SURFACE.select(whole.parameters)
    problem = JointProblem((Fragile(),), space, {})
    fold = random_folds(problem, 4)
    found = cross_validate(problem, fit_with_noise(problem, space.vector(TRUTH)), fold)
    assert len(found.failures) == 1
    assert "cannot do without the first push" in found.failures[0]
    assert np.count_nonzero(np.isnan(found.residuals)) == np.count_nonzero(fold == fold[0]) == 8


def test_folds_that_do_not_fit_are_refused() -> None:
    problem = joint()
    for folds in (1, 29):
        with pytest.raises(InvalidInput, match="folds must be from 2 to the 28 groups"):
            random_folds(problem, folds)
