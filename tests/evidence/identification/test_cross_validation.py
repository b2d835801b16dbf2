"""Rows left out leave whole, are predicted without having been seen, and their errors are summed up
as they are.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from refusals import refused
from stand_ins import ELLIPSE, TRUTH, fitted, force_block, motion_block

from cyclemap.errors import ConvergenceError
from cyclemap.evidence import DataBlock, Parameter, ParameterSpace
from cyclemap.evidence.identification.data_block import JointProblem
from cyclemap.evidence.identification.identify import cross_validate, kind_errors, random_folds
from cyclemap.evidence.identification.surface_parameters import SURFACE

X = np.linspace(0.0, 1.0, 12)
DESIGN = np.stack([np.ones(12), X, X**2], axis=-1)
SPACE = ParameterSpace(
    tuple(Parameter(name, "", "1", -9.0, 9.0, 0.1, 1.0) for name in ("a", "b", "c"))
)
DATA = np.cos(3.0 * X) + 0.05 * np.random.default_rng(0).standard_normal(12)


@pytest.fixture
def joint() -> JointProblem:
    space = SURFACE.select((*ELLIPSE, "pusher_friction", "plate_dome"))
    return JointProblem((force_block(12, 0.01), motion_block(16, 0.02, 0.002)), space, {})


@pytest.mark.parametrize("size", [1, 2, 3])
def test_left_out_errors_of_a_linear_law_are_those_of_the_hat_matrix(size: int) -> None:
    """Of a group left out, the error is (1 - H)^-1 times the residuals, H its part of the hat
    matrix (Cook 1977).
    """
    groups = np.arange(12) // size
    parabola = DataBlock(
        "p", SPACE.names, lambda v: (DESIGN @ SPACE.vector(v) - DATA, DESIGN), groups, "1"
    )
    problem = JointProblem((parabola,), SPACE, {})
    fit = fitted(problem, SPACE.start)
    hat = DESIGN @ np.linalg.inv(DESIGN.T @ DESIGN) @ DESIGN.T
    expected = [
        np.linalg.solve(np.eye(size) - hat[rows, rows], fit.residuals[rows])
        for rows in (slice(first, first + size) for first in range(0, 12, size))
    ]
    found, failures = cross_validate(problem, fit, random_folds(problem, 12 // size))
    assert np.allclose(found, np.concatenate(expected), atol=2e-4) and failures == []


def test_random_folds_keep_groups_whole_and_deal_every_block_evenly(joint) -> None:
    fold = random_folds(joint, 4, seed=3)
    assert np.array_equal(fold, random_folds(joint, 4, seed=3))
    assert not np.array_equal(fold, random_folds(joint, 4, seed=4))
    assert all(len(np.unique(fold[joint.groups == group])) == 1 for group in range(28))
    assert np.bincount(fold[joint.block_index == 0]).tolist() == [6, 6, 6, 6]
    assert np.bincount(fold[joint.block_index == 1]).tolist() == [8, 8, 8, 8]
    for folds in (1, 29):
        refused(random_folds, joint, folds, told="folds must be from 2 to the 28 groups")


def test_rows_of_no_fold_always_stay_and_sizes_are_told_by_block_and_kind(joint) -> None:
    fold, fit = (
        np.where(joint.block_index == 1, joint.groups % 2, -1),
        fitted(joint, joint.space.start),
    )
    left_out, _ = cross_validate(joint, fit, fold)
    assert np.array_equal(np.isfinite(left_out), joint.block_index == 1)
    table = kind_errors(joint, fit, left_out, np.full(fold.size, np.nan))
    told = [("scan", "force (1)", 24), ("pushes", "shift (m)", 16), ("pushes", "turn (rad)", 16)]
    assert [(row.block, row.kind, row.rows) for row in table] == told
    assert np.isnan(table[0].left_out_rms) and np.isnan(table[0].isotropic_mean)
    assert table[1].left_out_rms > table[1].rms
    size = np.abs(fit.residuals[:24])
    assert (table[0].mean, table[0].median) == (np.mean(size), np.median(size))
    assert np.isclose(table[0].rms, np.sqrt(np.mean(size**2)))


def test_a_fold_without_an_answer_is_recorded_and_its_rows_stay_unknown() -> None:
    whole = motion_block(16, 0.02, 0.002)

    def fragile(rows: np.ndarray) -> Any:
        if 0 not in rows and len(rows) > 8:
            raise ConvergenceError("cannot do without the first push")
        return lambda values: tuple(part[rows] for part in whole.function(values))

    problem = JointProblem((replace(whole, part=fragile),), SURFACE.select(whole.parameters), {})
    fold = random_folds(problem, 4)
    found, failures = cross_validate(problem, fitted(problem, problem.space.vector(TRUTH)), fold)
    assert len(failures) == 1 and "cannot do without the first push" in failures[0]
    assert np.count_nonzero(np.isnan(found)) == np.count_nonzero(fold == fold[0]) == 8
