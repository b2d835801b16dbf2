"""A fine plane shows its wide tongues; cells that lock alone are not outlined, and coarse planes are as they are."""

import numpy as np
import pytest

from cyclemap.maps import RotationPlane
from cyclemap.views.sweep_page import without_specks


def plane(size, locked) -> RotationPlane:
    """A plane that locks at 1/q in the cells of `locked`, by q."""
    period = np.zeros((size, size), dtype=np.int64)
    for q, cells in locked.items():
        period[cells] = q
    flat, axis = np.zeros((size, size)), np.arange(float(size))
    return RotationPlane(axis, axis, flat, flat, flat, period, np.sign(period), period < 0, 1e-4)


WIDE = np.s_[3:20, 5:9]
NARROW = ((30, 31, 32), (10, 11, 12))


def test_wide_tongues_stay_whole_and_lone_cells_go() -> None:
    given = plane(60, {3: WIDE, 4: NARROW, 5: np.s_[40:60, 50:51]})
    found = without_specks(given)
    assert np.array_equal(found.period, plane(60, {3: WIDE}).period)
    assert np.array_equal(found.winding, np.sign(found.period))
    assert np.count_nonzero(given.period) == 17 * 4 + 3 + 20, "what is given stays as it is"


def test_two_tongues_side_by_side_are_not_taken_for_one() -> None:
    """A column each of 1/2 and 1/3: neither is two cells wide."""
    assert not without_specks(plane(60, {2: np.s_[10:40, 20], 3: np.s_[10:40, 21]})).period.any()


def test_a_tongue_that_is_one_cell_wide_at_a_place_is_not_cut_in_two() -> None:
    given = plane(60, {3: np.s_[10:20, 5:9]})
    for cells in (np.s_[20, 7], np.s_[21, 8], np.s_[22:30, 8:12], np.s_[30:34, 8]):
        given.period[cells] = given.winding[cells] = 1
    given.period[given.period > 0] = 3
    found = without_specks(given)
    assert found.period[20, 7] == found.period[21, 8] == 3
    assert found.period[30:34, 8].tolist() == [3, 0, 0, 0], "what trails off is cut short"


@pytest.mark.parametrize("corner", [np.s_[:2, :2], np.s_[:2, -2:], np.s_[-2:, :2], np.s_[-2:, -2:]])
def test_a_tongue_in_a_corner_stays(corner) -> None:
    assert np.count_nonzero(without_specks(plane(60, {2: corner})).period) == 4


def test_a_coarse_plane_keeps_every_cell() -> None:
    given = plane(10, {3: np.s_[4, 4]})
    assert without_specks(given) is given
