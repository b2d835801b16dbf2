"""Pushes and drags against independent solvers' numbers, and against real pushes (Yu et al.
2016)."""

import csv
import math

import numpy as np
import pytest

from cyclemap.mechanics import (
    DragBack,
    EllipseFriction,
    Pose,
    Pusher,
    QuasiStaticModel,
    SidePush,
    Slider,
    corner_footprint,
    grid_footprint,
    load_material,
)

SLIDER, PLYWOOD = Slider.mit("rect1"), load_material("plywood").friction
ISOTROPIC = EllipseFriction.isotropic(0.25)

# theta_0, push turn (deg), dx, dy (mm), drag turn (deg), drag (mm).
TABLE = (
    (0, 73.65314, 42.59622, -66.68390, -63.68794, 93.49103),
    (60, 73.84911, 42.21066, -71.18737, -73.51442, 97.47321),
    (150, 65.58227, 33.54062, -107.07023, -77.99290, 126.58208),
    (270, 72.40902, 43.24562, -53.21574, -49.51194, 81.52020),
)
EVEN = (74.52037, 41.50526, -71.78672, -66.51814, 97.91241)
ROWS = [(PLYWOOD, None, *row) for row in TABLE] + [
    (ISOTROPIC, None, at, *EVEN) for at in (0.0, 77.7, -140.0)
]
# Of the paper's grid its turns alone are known.
ROWS += [
    (PLYWOOD, grid_footprint(SLIDER.outline, 8), 0, 73.88566, *[math.nan] * 2, -64.08039, math.nan)
]


@pytest.mark.parametrize("row", ROWS)
def test_independent_solvers_tables_are_met_to_1e_4(row):
    """A cycle whose ring starts at the world's origin; without anisotropy the same from every
    orientation.
    """
    law, footprint, theta_deg, *wanted = row
    model = QuasiStaticModel(SLIDER, law, footprint=footprint)
    push, drag = model.cycle(math.radians(theta_deg), SidePush(), DragBack())
    found = (
        math.degrees(push.turn),
        *(1e3 * push.displacement),
        math.degrees(drag.turn),
        1e3 * drag.length,
    )
    assert np.nanmax(np.abs(np.subtract(found, wanted))) < 1e-4


def test_four_corners_give_what_a_rigid_body_engine_tends_to():
    model = QuasiStaticModel(SLIDER, ISOTROPIC, footprint=corner_footprint(SLIDER.outline))
    push = model.push(Pose(), SidePush())
    assert np.abs(1e3 * push.displacement - (38.278, -110.568)).max() < 0.002
    assert abs(math.degrees(push.turn) - 50.012) < 0.002


# One coefficient of ground friction: it changes no motion. Tip errors above 5 mm are failed pushes.
MODEL = QuasiStaticModel(
    Slider.mit("rect1"), EllipseFriction.isotropic(0.25), Pusher(friction=0.15), accuracy=1e-5
)
WORST_TIP_MM, LENGTH = 5.0, 0.05


@pytest.fixture(scope="module")
def rows(measured_data):
    """The rect1 rows by surface, numbers as floats."""
    with (measured_data / "mit_push_endpoints_v10.csv").open(newline="") as file:
        kept = [
            r
            for r in csv.DictReader(file)
            if r["shape"] == "rect1" and float(r["tip_err_mm"]) <= WORST_TIP_MM
        ]
    words = ("surface", "shape", "source")
    return [{k: v if k in words else float(v) for k, v in row.items()} for row in kept]


def error(row):
    """Distance (mm) and turn (deg) between the end pose predicted of the nominal push and the
    measured one.
    """
    push = SidePush(int(row["i"]), row["s"], row["t"], LENGTH)
    end = MODEL.push(Pose(row["x0"], row["y0"], row["th0"]), push).end
    turn = math.remainder(end.theta - row["th1"], 2.0 * math.pi)
    return 1e3 * math.hypot(end.x - row["x1"], end.y - row["y1"]), abs(math.degrees(turn))


@pytest.mark.parametrize(
    ("surface", "count", "published"), [("plywood", 395, (3.7, 4.0)), ("abs", 394, (2.8, 3.3))]
)
def test_nominal_pushes_end_within_the_published_mean_errors(rows, surface, count, published):
    errors = [error(row) for row in rows if row["surface"] == surface]
    assert len(errors) == count
    assert np.abs(np.mean(errors, axis=0) - published).max() < 0.1
