"""The model on real pushes: Yu et al. 2016, 50 mm pushes of rect1 on two surfaces (needs the measured data)."""

import csv
import math

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction, Pose, Pusher, QuasiStaticModel, SidePush, Slider, WorldPush

# One coefficient of ground friction: it changes no motion. Tip errors above 5 mm are failed pushes.
MODEL = QuasiStaticModel(Slider.mit("rect1"), EllipseFriction.isotropic(0.25), Pusher(friction=0.15), accuracy=1e-5)
WORST_TIP_MM, LENGTH = 5.0, 0.05


@pytest.fixture(scope="module")
def rows(measured_data):
    """The rect1 rows by surface, numbers as floats."""
    with (measured_data / "mit_push_endpoints_v10.csv").open(newline="") as file:
        kept = [r for r in csv.DictReader(file) if r["shape"] == "rect1" and float(r["tip_err_mm"]) <= WORST_TIP_MM]
    words = ("surface", "shape", "source")
    return [{k: v if k in words else float(v) for k, v in row.items()} for row in kept]


def nominal(row):
    return SidePush(int(row["i"]), row["s"], row["t"], LENGTH)


def measured(row):
    """The push along the tip's measured path."""
    dx, dy = row["tip_x1"] - row["tip_x0"], row["tip_y1"] - row["tip_y0"]
    return WorldPush((row["tip_x0"], row["tip_y0"]), math.atan2(dy, dx), math.hypot(dx, dy))


def error(row, push):
    """Distance (mm) and turn (deg) between the predicted and the measured end pose."""
    end = MODEL.push(Pose(row["x0"], row["y0"], row["th0"]), push).end
    turn = math.remainder(end.theta - row["th1"], 2.0 * math.pi)
    return 1e3 * math.hypot(end.x - row["x1"], end.y - row["y1"]), abs(math.degrees(turn))


@pytest.mark.parametrize(("surface", "count", "published"), [("plywood", 395, (3.7, 4.0)), ("abs", 394, (2.8, 3.3))])
def test_nominal_pushes_end_within_the_published_mean_errors(rows, surface, count, published):
    errors = [error(row, nominal(row)) for row in rows if row["surface"] == surface]
    assert len(errors) == count
    assert np.abs(np.mean(errors, axis=0) - published).max() < 0.1


def test_pushes_along_the_measured_tip_explain_the_data_as_well_where_the_tip_starts_outside(rows):
    errors, refused = [], 0
    for row in rows:
        try:
            errors.append(error(row, measured(row)))
        except InvalidInput:
            refused += 1  # The measured tip overlaps the measured object, or passes it by.
    assert len(errors) == 505
    assert refused == 284
    assert np.mean(errors, axis=0)[0] < 3.5
    assert np.mean(errors, axis=0)[1] < 3.6


def test_predictions_beat_the_guess_that_nothing_moves_by_far(rows):
    still = [1e3 * math.hypot(row["x1"] - row["x0"], row["y1"] - row["y0"]) for row in rows]
    assert np.mean([error(row, nominal(row))[0] for row in rows[::5]]) < 0.2 * np.mean(still)
