"""The figure of the floor's shape: what its caption claims."""

import numpy as np
import pytest

from cyclemap import CollectionLoop
from cyclemap.evidence import read_theta0_pairs
from cyclemap.figures.catalogue import MeasuredFolder
from cyclemap.figures.plywood_turns import floor_shapes

NAME = "floor-shape"


def test_a_flat_floor_with_friction_alike_all_around_turns_every_cycle_alike(result) -> None:
    assert np.ptp(result.floors[0].turn) < 1e-6


def test_a_floors_shape_alone_makes_even_harmonics_only(result) -> None:
    trough = result.floors[2]
    assert trough.harmonic(2) > np.radians(10.0)
    assert max(trough.harmonic(1), trough.harmonic(3)) < 1e-6


def test_on_a_trough_the_plate_rests_on_what_lies_far_out_along_y(result) -> None:
    for pressure in result.resting:
        middle = pressure.shape[0] // 2
        assert np.nanmax(pressure[middle - 10 : middle + 10]) == 0.0
        assert np.nanmax(pressure[: middle // 2]) > 1.0


def test_the_trough_explains_more_of_the_measured_turns_than_the_ellipse() -> None:
    measured = MeasuredFolder.found()
    if measured.find("plywood_rect1_theta0_2000.csv") is None:
        pytest.skip("no measured data: set CYCLEMAP_DATA")
    missed = [floor.miss for floor in floor_shapes(measured).floors]
    assert np.degrees(missed).round(1).tolist() == [12.3, 17.5, 6.9, 5.0]


def test_shapes_identified_from_pushes_and_drags_tell_half_of_what_the_staircase_turns() -> None:
    """plywood-floor knows of no cycle: pushes of 50 mm and drag-backs. Its slow directions are
    where θ0 was slow.
    """
    path = MeasuredFolder.found().find("plywood_rect1_theta0_2000.csv")
    if path is None:
        pytest.skip("no measured data: set CYCLEMAP_DATA")
    pairs = read_theta0_pairs(path)
    turns, theta = pairs.theta_next[500:] - pairs.theta[500:], pairs.theta[500:] % (2.0 * np.pi)
    bins = (theta // np.radians(10.0)).astype(int)
    measured = np.degrees([np.median(turns[bins == index]) for index in range(36)])
    middles = np.radians(np.arange(5.0, 360.0, 10.0))
    predicted = np.degrees(CollectionLoop.mit("plywood-floor").circle_map(1e-5).turn(middles))
    flat = np.degrees(CollectionLoop.mit("isotropic").circle_map(1e-5).turn(middles))
    missed, missed_flat = np.sqrt(np.mean((np.stack([predicted, flat]) - measured) ** 2, axis=1))
    assert missed < 0.5 * missed_flat and missed < 6.0
    halves = np.stack([np.argmin(turn.reshape(2, 18), axis=1) for turn in (predicted, measured)])
    assert np.abs(10.0 * (halves[0] - halves[1])).max() <= 25.0
