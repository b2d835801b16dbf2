"""Friction scans give back the ellipse that made them, with intervals that hold, and say when they
cannot.
"""

import dataclasses
import math

import numpy as np
import pytest
from refusals import refused
from stand_ins import ELLIPSE, made_scans

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import ConvergenceError
from cyclemap.evidence import (
    RecordingNoise,
    SurfaceParameters,
    friction_ellipse_from_scans,
    friction_scan_block,
    identify,
    load_pushes,
    simulate_collection,
)
from cyclemap.evidence.identification.surface_parameters import SURFACE
from cyclemap.mechanics import load_material

FRICTION, WEIGHT = load_material("plywood").friction, 8.2
TRUTH = SurfaceParameters.from_friction(FRICTION).values()
SPACE = SURFACE.select(ELLIPSE)


def scans_at(degrees, noise=0.0):
    return made_scans(FRICTION, np.radians(degrees), WEIGHT, noise)


def test_scans_of_a_simulated_collection_give_the_table_of_the_paper_within_their_intervals(
    tmp_path,
) -> None:
    """Ma & Rodriguez (2018), Table I, plywood; the law's angle is known up to a half turn, which
    turns m0, n0.
    """
    loop = CollectionLoop.mit("plywood", accuracy=1e-6)
    simulate_collection(loop, tmp_path / "made", 1, scans=True, noise=RecordingNoise(force=0.05))
    scans = load_pushes(tmp_path / "made").scans
    assert len(scans) == 144
    found = identify([friction_scan_block(scans, loop.model.weight)], ELLIPSE, starts=4, folds=6)
    assert found.fit.converged and found.starts.arrived == 4
    for estimate in found.estimates:
        assert estimate.identifiable and estimate.upper - estimate.lower < 1e-3
        assert estimate.lower < TRUTH[estimate.name] < estimate.upper
    law = found.friction()
    turned = dataclasses.replace(law, m0=-law.m0, n0=-law.n0, phi=law.phi + math.pi)
    assert dataclasses.astuple(turned) == pytest.approx(
        (0.2545, 0.2346, 0.0325, 0.0082, 2.6175), abs=2e-3
    )
    # The median over the middle of a stroke: sqrt(pi / 2) * 0.05 N / sqrt(750).
    assert found.fit.noise[0] == pytest.approx(
        math.sqrt(math.pi / 2.0) * 0.05 / math.sqrt(750), rel=0.15
    )
    assert found.errors[0].rows == 144 and found.errors[0].left_out_rms < 1.1 * found.errors[0].rms


@pytest.mark.parametrize(
    "ellipticity", [(0.0, 0.0), (1e-5, 2e-5), (0.004, -0.003), (0.12, -0.07), (-0.8, 0.6)]
)
def test_the_derivatives_are_those_of_differences_also_on_a_circle(ellipticity) -> None:
    scans, at, step = (
        scans_at(np.arange(0, 360, 25)),
        np.array([-1.3, *ellipticity, 0.06, -0.04]),
        1e-4,
    )
    block = friction_scan_block(scans, WEIGHT)
    exact = block.residuals(SPACE.values(at))[1]
    for column, unit in enumerate(np.eye(5) * step):
        moved = [block.residuals(SPACE.values(at + n * unit))[0] for n in (-2, -1, 1, 2)]
        slope = (moved[0] - 8.0 * moved[1] + 8.0 * moved[2] - moved[3]) / (12.0 * step)
        # Differences stumble within 1e-6 of a circle, where the ellipse is taken as not quite
        # round.
        assert np.allclose(exact[:, column], slope, atol=2e-5)


def test_scans_in_one_direction_are_one_group_whatever_turn_they_are_written_with() -> None:
    block = friction_scan_block(scans_at([0, 90, 180, 270, 360]), WEIGHT)
    assert len(np.unique(block.groups)) == 4
    part = block.subset(block.groups == block.groups[0])
    assert np.allclose(part.residuals(TRUTH)[0], 0.0, atol=1e-12) and len(part.groups) == 8


@pytest.mark.parametrize("degrees", [[30], [30, 120], [30, 210], [30, 34, 38], [0, 90, 180, 270]])
def test_too_few_directions_are_reported_as_not_identifiable(degrees) -> None:
    """Two directions give four numbers for five; three within 8 degrees too nearly alike; four
    around fix them.
    """
    found = friction_ellipse_from_scans(scans_at(degrees, 0.01), WEIGHT)
    known = [one.identifiable for one in found.estimates]
    assert sum("not identifiable" in note for note in found.notes) == known.count(False)
    assert known.count(False) >= 3 and found.uncertainty.open if len(degrees) < 4 else all(known)
    assert all(one.lower < TRUTH[one.name] < one.upper for one in found.estimates)


@pytest.mark.parametrize(
    ("change", "weight", "words"),
    [
        ({"force_across": None}, WEIGHT, "force_across is missing"),
        (
            {"force_along": np.where(np.arange(6) == 3, np.nan, 2.0)},
            WEIGHT,
            "scan 3 has no direction or no force",
        ),
        ({"direction": [0.0]}, WEIGHT, "columns of one length"),
        ({}, 0.0, "weight must be positive"),
    ],
)
def test_scans_that_cannot_be_used_are_refused_by_name(change, weight, words) -> None:
    scans = {
        name: column
        for name, column in {**scans_at([0, 60, 120]), **change}.items()
        if column is not None
    }
    refused(friction_scan_block, scans, weight, told=words)


def test_a_scan_alone_asks_for_its_noise() -> None:
    scan = {name: column[:1] for name, column in scans_at([30]).items()}
    refused(friction_ellipse_from_scans, scan, WEIGHT, told="give its noise", kind=ConvergenceError)
    assert not friction_ellipse_from_scans(scan, WEIGHT, noise=0.01)["offset_x"].identifiable
