"""Identification gives back what made the data, its intervals hold as often as they say, and it
tells its doubts.
"""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from stand_ins import ELLIPSE, MOTION, TRUTH, fitted, force_block, motion_block

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import DataBlock, SurfaceParameters, identified_material, identify
from cyclemap.evidence.identification.data_block import JointProblem
from cyclemap.evidence.identification.identifiability import uncertainty
from cyclemap.evidence.identification.stroke_block import TIP_OFFSET
from cyclemap.evidence.identification.surface_parameters import SURFACE
from cyclemap.evidence.laws.linear_fit import student_quantile
from cyclemap.mechanics.plate_footprint import mean_pressure

NAMES = (*ELLIPSE, "pusher_friction", "plate_dome")
SPACE = SURFACE.select(NAMES)


def blocks(
    noise: float, seed: int = 0, count: int = 16, shared: float = 0.0
) -> tuple[DataBlock, DataBlock]:
    return force_block(noise=noise, seed=seed), motion_block(
        count, 2 * noise, 0.2 * noise, seed, shared
    )


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
    assert loop.model.pressure.plate.dome * mean_pressure(loop.slider) == pytest.approx(
        TRUTH["plate_dome"], abs=1e-9
    )
    assert steps == sorted(steps) and steps[-1] == 1.0


@pytest.mark.slow
@pytest.mark.parametrize(("count", "shared"), [(24, 0.0), (30, 0.9)])
def test_intervals_cover_in_90_to_99_percent_of_runs_where_pushes_are_groups(
    count: int, shared: float
) -> None:
    """Where turn and shift of a push share nine tenths of their variance, rows as groups of their
    own do not.
    """
    grouped, single = [], []
    for seed in range(200):
        problem = JointProblem(blocks(0.01, seed, count, shared), SPACE, {})
        rows = tuple(
            replace(block, groups=np.arange(len(block.groups))) for block in problem.blocks
        )
        fit = fitted(problem, SPACE.start)
        for held, blocks_of in ((grouped, problem.blocks), (single, rows)):
            errors = uncertainty(replace(problem, blocks=blocks_of), fit)
            half = np.array(
                [student_quantile(0.95, freedom) for freedom in errors.freedom.tolist()]
            )
            held.append(np.abs(fit.vector - SPACE.vector(TRUTH)) < half * errors.standard_error)
    often = np.mean(grouped if shared else single, axis=0)
    assert np.all((often >= 0.9) & (often <= 0.99))
    assert not shared or np.sum(np.mean(single, axis=0) < 0.9) >= 3


def test_the_whole_of_it_reports_intervals_errors_and_starts_alike_for_one_seed() -> None:
    found, again = (
        identify(blocks(0.01, seed=4), NAMES, starts=3, folds=4, seed=5) for _ in range(2)
    )
    assert (found.estimates, found.errors) == (again.estimates, again.errors)
    assert [estimate.name for estimate in found.estimates] == list(NAMES)
    assert all(
        estimate.identifiable and estimate.unit == SURFACE[estimate.name].unit
        for estimate in found.estimates
    )
    assert [(row.kind, row.rows) for row in found.errors] == [
        ("force (1)", 24),
        ("shift (m)", 16),
        ("turn (rad)", 16),
    ]
    assert all(row.left_out_rms > row.rms for row in found.errors)
    assert found.starts.count == 3
    assert found["offset_x"].value == found.values["offset_x"]
    refused(lambda: found["plate_warp_x"], told="unknown identified parameter")
    refused(identified_material, found, " ", told="needs a name")


def test_what_motion_cannot_tell_is_said_and_what_was_not_given_is_named() -> None:
    still = DataBlock(
        "still", ("plate_warp_x",), lambda v: (np.ones(8), np.zeros((8, 1))), np.arange(8), "none"
    )
    pushes = motion_block(20, 0.02, 0.002)
    found = identify(
        [pushes, still], [*MOTION[:4], "plate_warp_x"], {"pusher_friction": 0.17}, starts=2
    )
    warp = found["plate_warp_x"]
    assert (warp.lower, warp.upper, warp.identifiable, warp.standard_error) == (
        -60.0,
        60.0,
        False,
        np.inf,
    )
    assert "plate_warp_x is not fixed by the data" in found.notes
    assert "plate_dome was neither free nor given: taken as 0" in found.notes
    assert found["offset_x"].identifiable


def test_a_value_on_its_bound_says_which() -> None:
    space = SURFACE.extended(
        replace(SURFACE["plate_dome"], lower=0.45, upper=0.9, start=0.675, nominal=0.45)
    )
    found = identify(blocks(0.005), NAMES, starts=2, space=space)
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
    names, off = tuple(one.name for one in TIP_OFFSET), 1e-4 * np.cos(np.arange(8.0))
    jacobian = np.eye(2)[[0, 1] * 4]
    block = DataBlock(
        "ends", names, lambda v: (jacobian @ [v[n] for n in names] + off, jacobian), range(8), "m"
    )
    block = replace(block, own_parameters=TIP_OFFSET).of_owner("hex", TIP_OFFSET)
    (frame,) = identified_material(identify([block], block.parameters), "made").frames
    assert (frame.plate, frame.x, frame.y) == (
        "hex",
        *(pytest.approx(-np.mean(off[n::2]), abs=1e-9) for n in (0, 1)),
    )
