"""The 91 time series of the MIT dataset replayed, each from its own tip path (needs the measured data)."""

import math

import numpy as np
import pytest
from made_replays import FRICTION

import cyclemap as cm
from cyclemap.evidence.replay.replay_table import replay_pushes
from cyclemap.mechanics import Pusher

pytestmark = pytest.mark.slow

COUNTS = {("abs", "butter"): 40, ("abs", "ellip1"): 13, ("abs", "ellip3"): 10, ("abs", "hex"): 14, ("abs", "rect1"): 13}
# Bounds on the mean error at the end: mm, degrees. Measured: 5.0 and 3.7, 2.2 and 4.3, 4.9 and 8.6, 2.5 and 3.7,
# 2.6 and 2.3.
BOUNDS = {"butter": (5.5, 4.2), "ellip1": (2.6, 4.9), "ellip3": (5.6, 9.6), "hex": (2.9, 4.2), "rect1": (2.9, 2.7)}


@pytest.fixture(scope="module")
def replayed(measured_data):
    return replay_pushes(measured_data / "mit_files", FRICTION)


def test_each_of_the_91_files_is_replayed_as_one_straight_stroke(replayed) -> None:
    assert replayed.not_replayed == ()
    assert len(replayed.table) == len(set(replayed.table["path"])) == 91
    groups = replayed.by("surface", "object")
    counts = dict(zip(zip(groups["surface"], groups["object"], strict=True), groups["count"], strict=True))
    assert counts == {**COUNTS, ("plywood", "hex"): 1}
    assert (replayed.table["strokes"] == 1).all()
    assert replayed.table["straightness"].max() < 0.16e-3
    assert replayed.table["touched"].all()


def test_outlines_fit_the_records_shifts_are_calibration_errors(replayed) -> None:
    """Rod and object start within 1.6 mm of contact in every file, and overlap by no more than a third of one."""
    assert replayed.table["start_gap"].abs().max() < 1.6e-3
    assert replayed.table["shift"].max() < 0.35e-3
    assert (replayed.table["shift"] > 0.0).sum() == (replayed.table["start_gap"] < 0.0).sum() > 10


def test_mean_errors_of_each_object_are_small_beside_its_motion(replayed) -> None:
    groups = replayed.by("object").set_index("object")
    assert set(groups.index) == set(BOUNDS)
    for kind, (millimetres, degrees) in BOUNDS.items():
        assert 1e3 * groups.loc[kind, "mean_error"] < millimetres
        assert math.degrees(groups.loc[kind, "mean_turn_error"]) < degrees
        assert groups.loc[kind, "relative_error"] < 0.25
    error, turn_error = replayed.mean_errors
    assert 1e3 * error < 4.2
    assert math.degrees(turn_error) < 4.6


def test_predicted_motions_follow_the_measured_ones(replayed) -> None:
    """Distances and turns of all pushes go together: correlations over 0.95 and 0.9, sides of turning agree."""
    table = replayed.table
    assert np.corrcoef(table["measured_motion"], table["predicted_motion"])[0, 1] > 0.95
    assert np.corrcoef(table["measured_turn"], table["predicted_turn"])[0, 1] > 0.9
    large = table[table["measured_turn"].abs() > math.radians(5.0)]
    assert len(large) > 60
    assert (np.sign(large["measured_turn"]) == np.sign(large["predicted_turn"])).mean() > 0.97


def test_contact_begins_and_ends_as_measured_in_most_pushes(replayed) -> None:
    assert replayed.table["touch_agrees"].mean() > 0.85
    assert replayed.table["leaving_agrees"].mean() > 0.93


@pytest.mark.parametrize("surface", ["plywood", "abs"])
@pytest.mark.parametrize("plate", ["rect2", "tri3"])
def test_an_identified_floor_explains_single_pushes_better_than_isotropic_friction(
    measured_data, surface, plate
) -> None:
    """Pressure of the plate and shift of its frame, as the material has them, are worth a third of the error."""
    floor = cm.load_material(f"{surface}-floor")
    name = "mit_push_endpoints_v10_more.csv" if plate == "tri3" else "mit_push_endpoints_v10.csv"
    found = cm.replay_pushes(
        measured_data / name,
        floor.friction,
        pusher=Pusher(friction=floor.found_with.pusher_friction),
        plates=floor.plates,
        frames=floor.frames,
        select={"surface": surface, "object": plate, "side": 1.0},
    )
    (row,) = found.by("object").to_dict("records")
    assert row["count"] > 60
    assert row["mean_error"] < 0.8 * row["isotropic_mean_error"]
    assert row["mean_turn_error"] < 0.8 * row["isotropic_mean_turn_error"]
