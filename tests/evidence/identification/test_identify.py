"""Identification gives back what made the data, its intervals hold as often as they say, and it tells its doubts."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest
from stand_ins import ELLIPSE, MOTION, TRUTH, force_block, motion_block

from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import FunctionBlock, JointProblem, Values
from cyclemap.evidence.identification.identifiability import uncertainty
from cyclemap.evidence.identification.identify import identify
from cyclemap.evidence.identification.least_squares import Fit, fit_with_noise
from cyclemap.evidence.identification.surface_parameters import SURFACE, Parameter, SurfaceParameters
from cyclemap.evidence.identified_material import identified_material
from cyclemap.evidence.laws.linear_fit import student_quantile

NAMES = (*ELLIPSE, "pusher_friction", "rim_share")
SPACE = SURFACE.select(NAMES)
RUNS = 200


def blocks(noise: float, seed: int = 0, count: int = 16, shared: float = 0.0) -> tuple[FunctionBlock, FunctionBlock]:
    return force_block(noise=noise, seed=seed), motion_block(count, 2 * noise, 0.2 * noise, seed, shared)


def test_without_noise_the_friction_comes_back_exactly_and_becomes_a_material() -> None:
    steps: list[float] = []
    found = identify(blocks(0.0), NAMES, starts=3, folds=3, progress=steps.append)
    assert found.converged
    assert found.notes == ()
    assert max(abs(found.values[name] - TRUTH[name]) for name in NAMES) < 1e-9
    assert found.starts.arrived == 3
    truth = SurfaceParameters.from_values(TRUTH).to_friction()
    material = identified_material(found, "made")
    assert np.allclose(dataclasses.astuple(found.friction()), dataclasses.astuple(truth), atol=1e-9)
    assert "inferred from scan (24 values), pushes (32 values)" in material.provenance
    assert "left out" in material.misfit
    assert steps == sorted(steps)
    assert steps[-1] == 1.0


def single_rows(problem: JointProblem) -> JointProblem:
    """The same data, every row taken for a group of its own."""
    parts = tuple(dataclasses.replace(block, groups=np.arange(len(block.groups))) for block in problem.blocks)
    return dataclasses.replace(problem, blocks=parts)


def holds_truth(problem: JointProblem, fit: Fit) -> np.ndarray:
    """Whether the 95 % interval of each parameter, by covariance, holds the truth."""
    errors = uncertainty(problem, fit)
    half = np.array([student_quantile(0.95, freedom) for freedom in errors.freedom.tolist()])
    return np.asarray(np.abs(fit.vector - SPACE.vector(TRUTH)) < half * errors.standard_error)


@pytest.mark.slow
def test_intervals_of_95_percent_cover_in_90_to_99_percent_of_runs() -> None:
    covered = []
    for seed in range(RUNS):
        problem = single_rows(JointProblem(blocks(0.01, seed, 24), SPACE, {}))
        covered.append(holds_truth(problem, fit_with_noise(problem, SPACE.start)))
    shares = np.mean(covered, axis=0)
    assert shares.shape == (7,) and np.all((shares >= 0.9) & (shares <= 0.99))


@pytest.mark.slow
def test_grouped_errors_cover_where_turn_and_shift_share_nine_tenths_and_single_rows_would_not() -> None:
    grouped, single = [], []
    for seed in range(RUNS):
        problem = JointProblem(blocks(0.01, seed, 30, 0.9), SPACE, {})
        fit = fit_with_noise(problem, SPACE.start)
        grouped.append(holds_truth(problem, fit))
        single.append(holds_truth(single_rows(problem), fit))
    shares = np.mean(grouped, axis=0)
    assert shares.shape == (7,)
    assert np.all((shares >= 0.9) & (shares <= 0.99))
    assert np.sum(np.mean(single, axis=0) < 0.9) >= 3


def test_the_whole_of_it_reports_intervals_errors_and_starts() -> None:
    found = identify(blocks(0.01, seed=4), NAMES, starts=4, folds=4)
    assert [estimate.name for estimate in found.estimates] == list(NAMES)
    for estimate in found.estimates:
        assert estimate.lower < estimate.value < estimate.upper
        assert estimate.identifiable
        assert estimate.unit == SURFACE[estimate.name].unit
        half = 0.5 * (estimate.upper - estimate.lower)
        freedom = float(found.uncertainty.freedom[NAMES.index(estimate.name)])
        assert half == pytest.approx(student_quantile(0.95, freedom) * estimate.standard_error)
    assert [(row.kind, row.rows) for row in found.errors] == [("force (1)", 24), ("shift (m)", 16), ("turn (rad)", 16)]
    assert all(row.left_out_rms > row.rms for row in found.errors)
    assert found.starts.count == 4
    assert found["offset_x"].value == found.values["offset_x"]
    assert found.friction() == found.surface.to_friction()


def test_the_answer_to_one_seed_is_one_answer() -> None:
    first, second = (identify(blocks(0.01), NAMES, starts=3, folds=3, seed=5) for _ in range(2))
    assert first.estimates == second.estimates
    assert first.errors == second.errors


def test_what_motion_cannot_tell_is_said_and_what_was_not_given_is_named() -> None:
    still = FunctionBlock("still", ("corner_share",), lambda v: (np.ones(8), np.zeros((8, 1))), np.arange(8), "none")
    pushes = motion_block(20, 0.02, 0.002)
    found = identify([pushes, still], [*MOTION[:4], "corner_share"], {"pusher_friction": 0.17}, starts=2)
    assert not found["corner_share"].identifiable
    assert (found["corner_share"].lower, found["corner_share"].upper) == (0.0, 1.0)
    assert np.isinf(found["corner_share"].standard_error)
    assert str(found["corner_share"]) == "corner_share not identifiable"
    assert "corner_share is not fixed by the data" in found.notes
    assert "rim_share was neither free nor given: taken as 0" in found.notes
    assert found["offset_x"].identifiable


def test_a_block_brings_parameters_of_its_own() -> None:
    class Biased:
        name, kinds = "biased", np.full(40, "turn (rad)")
        own_parameters = (Parameter("bias", "a shift of every turn", "rad", -1.0, 1.0, 0.0, 0.1),)
        groups, parameters = np.arange(40), ("bias",)

        def residuals(self, values: Values) -> tuple[np.ndarray, np.ndarray]:
            return values["bias"] - 0.3 - 0.01 * np.cos(np.arange(40.0)), np.ones((40, 1))

        def subset(self, keep_groups: object) -> "Biased":
            raise NotImplementedError

    found = identify([Biased()], ["bias"], starts=2)
    assert found["bias"].lower < 0.3 < found["bias"].upper
    assert found["bias"].description == "a shift of every turn"


def test_a_value_on_its_bound_says_which() -> None:
    space = SURFACE.extended(replace(SURFACE["rim_share"], lower=0.45, upper=0.9, start=0.675, nominal=0.45))
    found = identify(blocks(0.005), NAMES, starts=2, space=space)
    assert found["rim_share"].at_bound == "lower"
    assert found["rim_share"].lower_open
    assert found["rim_share"].lower == 0.45
    assert "rim_share lies on a bound" in found.notes


def test_questions_that_make_no_sense_are_refused_by_name() -> None:
    both = blocks(0.01)
    with pytest.raises(InvalidInput, match="did you mean 'offset_x'"):
        identify(both, ["ofset_x"])
    with pytest.raises(InvalidInput, match="also fixed"):
        identify(both, NAMES, {"offset_x": 0.1})
    with pytest.raises(InvalidInput, match="name what is free"):
        identify(both, [])
    with pytest.raises(InvalidInput, match="unknown parameter 'warmth'"):
        identify(both, NAMES, {"warmth": 1.0})
    with pytest.raises(InvalidInput, match="must be a probability"):
        identify(both, NAMES, level=95)
    with pytest.raises(InvalidInput, match="number of starts"):
        identify(both, NAMES, starts=0)
    found = identify(both, NAMES, starts=1)
    with pytest.raises(InvalidInput, match="needs a name"):
        identified_material(found, " ")
    with pytest.raises(InvalidInput, match="unknown identified parameter"):
        found["corner_share"]
