"""Phase diagrams of the rotation number: the same numbers whichever way they are computed, and exact tongues."""

from fractions import Fraction

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import ARNOLD_FAMILY, MOEBIUS_FAMILY, CircleMap, periodic_orbits, rotation_numbers, rotation_plane

TWO_PI = 2 * np.pi
EDGE = (0.46966533712136485155, 1 - 0.46966533712136485155)  # of the tongue 1/2 at K = 0.9


def one_by_one(omega, K):
    """The sine family as a callable whose formula is not known."""
    return CircleMap.arnold(omega, K)


def test_many_at_once_and_map_by_map_agree():
    omegas, strengths = np.linspace(0.05, 0.95, 13), np.linspace(0.1, 1.0, 5)
    together = rotation_plane(ARNOLD_FAMILY, omegas, strengths)
    singly = rotation_plane(one_by_one, omegas, strengths)
    assert together.value.shape == singly.value.shape == (13, 5)
    for plane in (together, singly):
        assert np.all(plane.upper - plane.lower <= 2e-3 * (1 + 1e-9))
        assert np.all((plane.lower <= plane.value) & (plane.value <= plane.upper))
        assert not np.any(plane.folded)
    assert np.all((together.lower <= singly.upper) & (singly.lower <= together.upper))
    both = (together.period > 0) & (singly.period > 0)
    assert np.sum(both) > 10
    assert np.all((together.winding == singly.winding)[both] & (together.period == singly.period)[both])


def test_the_diagram_shows_the_tongue_of_one_half_between_its_known_edges():
    omegas = np.concatenate([np.linspace(0.44, EDGE[0] - 1e-4, 50), np.linspace(EDGE[0] + 1e-4, 0.5, 50)])
    plane = rotation_plane(ARNOLD_FAMILY, omegas, [0.9])
    half = np.array([plane.locked(i, 0) == Fraction(1, 2) for i in range(100)])
    assert not np.any(half[:50])
    assert np.sum(half[50:]) >= 49
    assert np.all(plane.upper[:50, 0] <= 0.5 + 1e-3)


def test_every_proved_ratio_has_its_orbit():
    omegas, strengths = np.linspace(0.21, 0.5, 24), np.array([0.8, 0.95])
    plane = rotation_plane(ARNOLD_FAMILY, omegas, strengths)
    checked = 0
    for i, omega in enumerate(omegas):
        for j, strength in enumerate(strengths):
            ratio = plane.locked(i, j)
            if ratio is not None and ratio.denominator < 8:
                assert periodic_orbits(CircleMap.arnold(omega, strength), ratio.denominator, ratio.numerator)
                checked += 1
    assert checked >= 5


@pytest.mark.parametrize(("family", "known"), [(CircleMap.arnold, ARNOLD_FAMILY), (CircleMap.moebius, MOEBIUS_FAMILY)])
def test_the_textbook_maps_are_recognised_and_done_many_at_once(family, known):
    first, second = np.linspace(0.1, 0.9, 9), np.linspace(0.1, 0.6, 7)
    plane, other = rotation_plane(family, first, second), rotation_plane(known, first, second)
    for name in ("value", "lower", "upper", "period", "winding"):
        np.testing.assert_array_equal(getattr(plane, name), getattr(other, name))
    np.testing.assert_array_equal(rotation_numbers(family, first, 0.5).value, rotation_numbers(known, first, 0.5).value)


@pytest.mark.parametrize("family", [ARNOLD_FAMILY, one_by_one])
def test_folded_maps_show_their_rotation_interval(family):
    """(Ω .5, K 3) has [1/6, 5/6] and (.3, 3) has [0, 1/2]; K = .5 beside them does not fold."""
    plane = rotation_plane(family, [0.3, 0.5], [0.5, 3.0], tolerance=5e-3)
    assert plane.folded.tolist() == [[False, True], [False, True]]
    np.testing.assert_allclose(plane.lower[:, 1], [0, 1 / 6], atol=1e-15)
    np.testing.assert_allclose(plane.upper[:, 1], [1 / 2, 5 / 6], atol=1e-15)
    assert np.all((plane.lower <= plane.value) & (plane.value <= plane.upper))
    assert np.all(plane.period[:, 1] == 0)
    assert plane.locked(0, 1) is None


def test_axes_may_descend():
    plane = rotation_plane(one_by_one, [0.6, 0.4], [0.5, 0.7, 0.9], tolerance=0.05)
    assert np.all(plane.value[0] > plane.value[1] - 0.1)


def test_results_never_change():
    plane = rotation_plane(ARNOLD_FAMILY, [0.1], [0.5])
    for name in ("first_values", "second_values", "value", "lower", "upper", "period", "winding", "folded"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(plane, name)[...] = 0


def test_bad_axes_and_families_are_refused():
    good = [0.1, 0.2]
    with pytest.raises(InvalidInput, match="first_values must be finite"):
        rotation_plane(ARNOLD_FAMILY, [0.1, np.nan], good)
    with pytest.raises(InvalidInput, match="second_values is empty"):
        rotation_plane(ARNOLD_FAMILY, good, [])
    for axis in ([0.1, 0.3, 0.2], [0.1, 0.1], [3.0, 1.0, 2.0]):
        with pytest.raises(InvalidInput, match="turns back"):
            rotation_plane(ARNOLD_FAMILY, axis, good)
    with pytest.raises(InvalidInput, match="axes"):
        rotation_plane(ARNOLD_FAMILY, [[0.1]], good)
    with pytest.raises(InvalidInput, match="tolerance"):
        rotation_plane(ARNOLD_FAMILY, good, good, tolerance=0.0)
    with pytest.raises(InvalidInput, match="callable"):
        rotation_plane(None, good, good)
    with pytest.raises(InvalidInput, match="degree 1"):
        rotation_plane(lambda p, q: CircleMap(lambda x: 2 * x + p + q, degree=2), good, good)
    with pytest.raises(InvalidInput, match="must be a CircleMap"):
        rotation_plane(lambda p, q: p + q, good, good)
