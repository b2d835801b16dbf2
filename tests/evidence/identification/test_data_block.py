"""Blocks of data and of beliefs keep their rows, groups and derivatives together."""

import numpy as np
import pytest
from refusals import refused
from stand_ins import ELLIPSE, SPACE, TRUTH, force_block, joint

from cyclemap.errors import ConvergenceError
from cyclemap.evidence import DataBlock, identify
from cyclemap.evidence.identification.data_block import JointProblem, linear_block, prior_block
from cyclemap.evidence.identification.surface_parameters import SURFACE


def test_equal_labels_in_two_blocks_are_two_groups_and_equal_kinds_share_their_noise() -> None:
    both = force_block(6), force_block(4, name="second")
    problem = JointProblem(both, SURFACE.select(ELLIPSE), {})
    assert len(np.unique(problem.groups)) == 10
    assert problem.kind_names == ("force (1)",)


def test_a_parameter_whose_data_leave_is_held() -> None:
    problem = joint(0.0)
    part = problem.subset(problem.block_index == 0, TRUTH)
    assert part.space.names == ELLIPSE
    assert part.fixed == {name: TRUTH[name] for name in ("pusher_friction", "plate_dome")}
    assert [block.name for block in part.blocks] == ["scan"]


def made(rows: int = 3, groups: object = (0, 1, 2), kinds: object = "m") -> DataBlock:
    return DataBlock("x", ("offset_x",), lambda _: (np.ones(3), np.ones((rows, 1))), groups, kinds)


def problem_of(*names: str) -> JointProblem:
    return JointProblem((force_block(),), SURFACE.select(names), {})


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (lambda: problem_of(*ELLIPSE, "plate_dome"), "depends on plate_dome"),
        (lambda: problem_of(*ELLIPSE[:4]), "the data depend on offset_y"),
        (lambda: JointProblem((force_block(),) * 2, SPACE, {}), "names of their own"),
        (lambda: made(groups=np.array([0.0, 1.0, 2.0])), "whole numbers, one a row"),
        (lambda: made(kinds=["m", "m"]), "kinds of block 'x'"),
        (lambda: made(2).residuals({"offset_x": 0.0}), r"3 rows gave .* derivatives \(2, 1\)"),
        (lambda: prior_block({}), "one parameter at least"),
        (lambda: prior_block({"plate_dome": (0.5, 0.0)}), "plate_dome"),
    ],
)
def test_blocks_that_do_not_fit_are_refused(asked, words) -> None:
    refused(asked, told=words)


def test_numbers_that_are_not_finite_stop_at_the_block() -> None:
    rows = np.array([0.0, np.nan]), np.zeros((2, 5))
    broken = DataBlock("broken", ELLIPSE, lambda _: rows, [0, 1], "m")
    values = dict.fromkeys(ELLIPSE, 0.0)
    refused(broken.residuals, values, told="'broken'", kind=ConvergenceError)


def test_a_belief_alone_keeps_its_deviation_beside_data_that_share_groups() -> None:
    """What the data do not depend on has the interval of its belief, however near to it the
    estimate lies.
    """
    rows = np.arange(40)
    data, jacobian = 0.2 + 0.01 * np.cos(7.0 * rows), np.eye(2)[[0] * 40]
    names = ("pusher_friction", "plate_dome")
    law = linear_block("law", names, jacobian, data, rows // 2, "m")
    beliefs = {"plate_dome": (0.4, 0.1), "pusher_friction": (0.15, 0.05)}
    found = identify([law], list(beliefs), priors=beliefs, starts=1)
    assert found["plate_dome"].value == pytest.approx(0.4, abs=1e-6)
    assert found["plate_dome"].standard_error == pytest.approx(0.1, rel=1e-6)
    assert found["plate_dome"].upper == pytest.approx(0.4 + 1.96 * 0.1, abs=1e-3)
    assert found["pusher_friction"].standard_error < 0.01
