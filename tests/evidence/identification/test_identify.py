"""Identification gives back what made the data, its intervals hold as often as they say, and it
tells its doubts.
"""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from stand_ins import MOTION, NAMES, SPACE, TRUTH, blocks, fitted, joint, motion_block

from cyclemap.collection import CollectionLoop
from cyclemap.errors import ConvergenceError
from cyclemap.evidence import (
    Parameter,
    ParameterSpace,
    SurfaceParameters,
    identified_material,
    identify,
)
from cyclemap.evidence.identification.data_block import JointProblem, linear_block
from cyclemap.evidence.identification.identify import cross_validate, kind_errors, random_folds
from cyclemap.evidence.identification.least_squares import uncertainty
from cyclemap.evidence.identification.stroke_block import TIP_OFFSET
from cyclemap.evidence.identification.surface_parameters import SURFACE
from cyclemap.evidence.laws.linear_fit import student_quantile
from cyclemap.mechanics.plate_footprint import mean_pressure


def test_without_noise_the_friction_comes_back_exactly_and_becomes_a_material() -> None:
    steps: list[float] = []
    found = identify(blocks(0.0), NAMES, starts=3, folds=3, progress=steps.append)
    assert found.fit.converged and found.notes == () and found.starts.arrived == 3
    assert max(abs(found.values[name] - TRUTH[name]) for name in NAMES) < 1e-9
    truth = SurfaceParameters.from_values(TRUTH).to_friction()
    assert np.allclose(dataclasses.astuple(found.friction()), dataclasses.astuple(truth), atol=1e-9)
    material = identified_material(found, "made")
    assert "inferred from scan (24 values), pushes (32 values)" in material.provenance
    assert "left out" in material.misfit
    loop = CollectionLoop.mit(material=material)
    dome = loop.model.pressure.plate.dome * mean_pressure(loop.slider)
    assert dome == pytest.approx(TRUTH["plate_dome"], abs=1e-9)
    assert steps == sorted(steps) and steps[-1] == 1.0


@pytest.mark.slow
@pytest.mark.parametrize(("count", "shared"), [(24, 0.0), (30, 0.9)])
def test_intervals_cover_as_often_as_they_say_where_pushes_are_groups(count, shared) -> None:
    """Where turn and shift of a push share nine tenths of their variance, rows as groups of their
    own do not.
    """
    grouped, single = [], []
    for seed in range(60):
        problem = JointProblem(blocks(0.01, seed, count, shared), SPACE, {})
        alone = [replace(block, groups=np.arange(len(block.groups))) for block in problem.blocks]
        fit = fitted(problem, SPACE.start)
        for held, own in ((grouped, problem.blocks), (single, tuple(alone))):
            errors = uncertainty(replace(problem, blocks=own), fit)
            half = np.array([student_quantile(0.95, rows) for rows in errors.freedom.tolist()])
            held.append(np.abs(fit.vector - SPACE.vector(TRUTH)) < half * errors.standard_error)
    often = np.mean(grouped if shared else single, axis=0)
    assert np.mean(often) == pytest.approx(0.95, abs=0.025) and np.all(often >= 0.87)
    assert not shared or np.sum(np.mean(single, axis=0) < 0.9) >= 3


def test_the_whole_of_it_reports_intervals_errors_and_starts_alike_for_one_seed() -> None:
    asked = {"starts": 3, "folds": 4, "seed": 5}
    found, again = (identify(blocks(0.01, seed=4), NAMES, **asked) for _ in range(2))
    assert (found.estimates, found.errors) == (again.estimates, again.errors)
    assert [row.name for row in found.estimates] == list(NAMES)
    assert all(row.identifiable for row in found.estimates)
    assert [row.unit for row in found.estimates] == [row.unit for row in SPACE.parameters]
    assert all(row.left_out_rms > row.rms for row in found.errors)
    assert found.starts.count == 3
    assert found["offset_x"].value == found.values["offset_x"]
    refused(lambda: found["plate_warp_x"], told="unknown identified parameter")
    refused(identified_material, found, " ", told="needs a name")


def test_what_motion_cannot_tell_is_said_and_what_was_not_given_is_named() -> None:
    rows = np.arange(8)
    still = linear_block("still", ("plate_warp_x",), np.zeros((8, 1)), rows, rows, "none")
    free, held = [*MOTION[:4], "plate_warp_x"], {"pusher_friction": 0.17}
    found = identify([motion_block(20, 0.02, 0.002), still], free, held, starts=1)
    warp = found["plate_warp_x"]
    assert (warp.lower, warp.upper, warp.standard_error) == (-60.0, 60.0, np.inf)
    assert not warp.identifiable
    assert "plate_warp_x is not fixed by the data" in found.notes
    assert "plate_dome was neither free nor given: taken as 0" in found.notes
    assert found["offset_x"].identifiable


def test_a_value_on_its_bound_says_which() -> None:
    bounded = replace(SURFACE["plate_dome"], lower=0.45, upper=0.9, start=0.675, nominal=0.45)
    found = identify(blocks(0.005), NAMES, starts=1, space=SURFACE.extended(bounded))
    dome = found["plate_dome"]
    assert (dome.at_bound, dome.lower_open, dome.lower) == ("lower", True, 0.45)
    assert found.fit.converged and "plate_dome lies on a bound" in found.notes


@pytest.mark.parametrize(
    ("free", "options", "words"),
    [
        (["ofset_x"], {}, "did you mean 'offset_x'"),
        (NAMES, {"fixed": {"offset_x": 0.1}}, "also fixed"),
        ([], {}, "name what is free"),
        (NAMES, {"fixed": {"warmth": 1.0}}, "unknown parameter 'warmth'"),
        (NAMES, {"level": 95}, "must be a probability"),
        (NAMES, {"level": 0.0}, "must be a probability"),
        (NAMES, {"starts": 0}, "number of starts"),
        (NAMES, {"noise": {"b": 0.01}}, "unknown kind of noise 'b'"),
        (NAMES, {"student": 0.5}, "must exceed one"),
    ],
)
def test_questions_that_make_no_sense_are_refused_by_name(free, options, words) -> None:
    refused(identify, blocks(0.01), free, told=words, **options)


def test_the_shift_of_a_data_sets_frame_is_its_plates_in_the_material() -> None:
    rows, jacobian = np.arange(8), np.eye(2)[[0, 1] * 4]
    off, names = 1e-4 * np.cos(rows), tuple(row.name for row in TIP_OFFSET)
    block = linear_block("ends", names, jacobian, off, rows, "m")
    block = replace(block, own_parameters=TIP_OFFSET).of_owner("hex", TIP_OFFSET)
    (frame,) = identified_material(identify([block], block.parameters, starts=1), "made").frames
    means = off[::2].mean(), off[1::2].mean()
    assert frame.plate == "hex" and (frame.x, frame.y) == pytest.approx(means, abs=1e-9)


@pytest.mark.parametrize("size", [1, 2, 3])
def test_left_out_errors_of_a_linear_law_are_those_of_the_hat_matrix(size: int) -> None:
    """Of a group left out, the error is (1 - H)^-1 times the residuals, H its part of the hat
    matrix (Cook 1977); kinds keep their weights.
    """
    x = np.linspace(0.0, 1.0, 12)
    design = np.stack([np.ones(12), x, x**2], axis=-1)
    data = np.cos(3.0 * x) + 0.05 * np.random.default_rng(0).standard_normal(12)
    groups = np.arange(12) // size
    space = ParameterSpace(tuple(Parameter(name, "", "1", -9.0, 9.0, 0.1, 1.0) for name in "abc"))
    kinds = np.where(groups % 2, "rough", "fine")
    parabola = linear_block("parabola", space.names, design, data, groups, kinds)
    problem = JointProblem((parabola,), space, {})
    fit = fitted(problem, space.start, known={"rough": 0.2, "fine": 0.05})
    weighed = design.T / fit.noise[problem.kind_index] ** 2
    hat = design @ np.linalg.solve(weighed @ design, weighed)
    expected = [
        np.linalg.solve(np.eye(size) - hat[rows, rows], fit.residuals[rows])
        for rows in (slice(first, first + size) for first in range(0, 12, size))
    ]
    found, failures = cross_validate(problem, fit, random_folds(problem, 12 // size))
    assert np.allclose(found, np.concatenate(expected), atol=2e-4) and failures == []


def test_random_folds_keep_groups_whole_and_deal_every_block_evenly() -> None:
    problem = joint(0.01)
    fold = random_folds(problem, 4, seed=3)
    assert np.array_equal(fold, random_folds(problem, 4, seed=3))
    assert not np.array_equal(fold, random_folds(problem, 4, seed=4))
    assert all(len(np.unique(fold[problem.groups == group])) == 1 for group in range(28))
    for block, rows in enumerate((6, 8)):
        assert np.bincount(fold[problem.block_index == block]).tolist() == [rows] * 4
    for folds in (1, 29):
        refused(random_folds, problem, folds, told="folds must be from 2 to the 28 groups")


def test_rows_of_no_fold_always_stay_and_sizes_are_told_by_block_and_kind() -> None:
    problem = joint(0.01)
    fold = np.where(problem.block_index == 1, problem.groups % 2, -1)
    fit = fitted(problem, SPACE.start)
    left_out, _ = cross_validate(problem, fit, fold)
    assert np.array_equal(np.isfinite(left_out), problem.block_index == 1)
    table = kind_errors(problem, fit, left_out, np.full(fold.size, np.nan))
    told = [("scan", "force (1)", 24), ("pushes", "shift (m)", 16), ("pushes", "turn (rad)", 16)]
    assert [(row.block, row.kind, row.rows) for row in table] == told
    assert np.isnan(table[0].left_out_rms) and np.isnan(table[0].isotropic_mean)
    assert table[1].left_out_rms > table[1].rms
    size = np.abs(fit.residuals[:24])
    assert (table[0].mean, table[0].median) == (np.mean(size), np.median(size))
    assert np.isclose(table[0].rms, np.sqrt(np.mean(size**2)))


def test_a_fold_without_an_answer_is_recorded_and_its_rows_stay_unknown() -> None:
    whole = motion_block(16, 0.02, 0.002)

    def fragile(rows):
        if 0 not in rows and len(rows) > 8:
            raise ConvergenceError("cannot do without the first push")
        return lambda values: tuple(part[rows] for part in whole.function(values))

    problem = JointProblem((replace(whole, part=fragile),), SURFACE.select(whole.parameters), {})
    fold = random_folds(problem, 4)
    found, failures = cross_validate(problem, fitted(problem, problem.space.vector(TRUTH)), fold)
    assert len(failures) == 1 and "cannot do without the first push" in failures[0]
    assert np.count_nonzero(np.isnan(found)) == np.count_nonzero(fold == fold[0]) == 8
