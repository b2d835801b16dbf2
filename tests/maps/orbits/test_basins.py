"""Basins against forward iteration of a fine grid, known end points, and invariance."""

import numpy as np
import pytest

from cyclemap.maps import CircleMap, basins, fixed_points, periodic_orbits
from tests.maps.known_maps import DOUBLING, TWO_PI, agree, apart, contraction, logistic

MAPS = {
    "locked": CircleMap.arnold(0.1, 0.9),
    "locked at 1/2": CircleMap.arnold(0.5, 0.9),
    "folded": CircleMap.arnold(0.05, 1.6),
    "period two behind a fold": CircleMap.arnold(0.3, 3.0),
    "logistic 3.2": logistic(3.2),
    "degree two": CircleMap(
        lambda x: 2 * x - 1.5 * np.sin(x), lambda x: 2 - 1.5 * np.cos(x), degree=2
    ),
    "with a gap": contraction(0.6, 0.77),
    # two stable orbits of period two, each with preimages of its immediate basin elsewhere
    "twin wells": CircleMap(
        lambda x: x - 1.2 * np.sin(2 * x) - 0.3 * np.sin(x),
        lambda x: 1 - 2.4 * np.cos(2 * x) - 0.3 * np.cos(x),
    ),
    "Möbius": CircleMap.moebius(0.5, 0.1),
}


def inside(arcs, theta):
    return np.any(
        ((theta[:, None] > arcs[:, 0]) & (theta[:, None] < arcs[:, 1]))
        | (theta[:, None] + TWO_PI < arcs[:, 1]),
        axis=1,
    )


def reached(circle_map, found, theta, cycles=600):
    """Which angles have come to which orbit."""
    for _ in range(cycles):
        theta = np.mod(circle_map(theta), TWO_PI)
    return [np.min(apart(theta[:, None], basin.orbit.points), axis=1) < 1e-6 for basin in found]


@pytest.mark.slow
@pytest.mark.parametrize("name", MAPS)
def test_forward_iteration_of_a_grid_agrees_with_the_arcs_which_are_disjoint_and_add_up(name):
    found = basins(MAPS[name], max_arcs=2000)
    rows = np.concatenate([basin.arcs for basin in found])
    rows = rows[np.argsort(rows[:, 0])]
    assert np.all((rows[:, 0] >= 0) & (rows[:, 0] < TWO_PI))
    assert np.all(np.append(rows[1:, 0], rows[0, 0] + TWO_PI) >= rows[:, 1] - 1e-11)
    total = sum(float(basin.measure) for basin in found)
    assert abs(total + found[0].undecided - 1) < 1e-12
    assert abs(np.sum(rows[:, 1] - rows[:, 0]) / TWO_PI - total) < 1e-12
    theta = (np.arange(2000) + 0.5003) * TWO_PI / 2000
    for basin, tends in zip(found, reached(MAPS[name], found, theta), strict=True):
        claimed = inside(basin.arcs, theta)
        assert not np.any(claimed & ~tends)  # nothing is claimed that does not tend there
        sampling = 1 / theta.size + 3 * np.sqrt(basin.undecided / theta.size)
        assert np.mean(tends & ~claimed) <= basin.undecided + sampling
        allowed = basin.measure.error_bound + 2 * sampling + len(basin.arcs) * 1e-5
        assert abs(np.mean(tends) - basin.measure) <= allowed


@pytest.mark.slow
@pytest.mark.parametrize("name", MAPS)
def test_the_map_carries_the_immediate_basin_into_itself_in_the_order_of_the_orbit(name):
    found = basins(MAPS[name], max_arcs=100)
    assert found
    for basin in found:
        assert basin.immediate.shape == (basin.orbit.period, 2)
        for i, arc in enumerate(basin.immediate):
            following = basin.immediate[(i + 1) % basin.orbit.period]
            image = MAPS[name](np.linspace(*arc, 2003)[1:-1])
            offset = np.mod(image - following[0], TWO_PI)
            assert np.all((offset <= following[1] - following[0] + 1e-9) | (offset > TWO_PI - 1e-9))
            assert inside(arc[None], basin.orbit.points[i : i + 1])[0]


@pytest.mark.parametrize("name", ["locked", "locked at 1/2", "Möbius", "with a gap"])
def test_basins_of_injective_maps_are_the_arcs_between_neighbouring_unstable_points_or_jumps(name):
    found = basins(MAPS[name])
    orbits = [o for n in (1, 2) for o in periodic_orbits(MAPS[name], n) if not o.stable]
    edges = np.sort(np.concatenate([*[o.points for o in orbits], MAPS[name].breaks]))
    if name == "with a gap":
        # The jump and its one preimage part the two halves of the orbit of period two.
        edges = np.array([0.0, (1 - 0.77) / 0.6 * TWO_PI])
    ends = np.mod(np.concatenate([b.immediate.ravel() for b in found]) + 1e-9, TWO_PI) - 1e-9
    agree(np.sort(ends), np.repeat(edges, 2), 1e-11)
    assert sum(b.arcs.shape[0] for b in found) == edges.size
    assert abs(sum(b.measure for b in found) - 1) < 1e-12


def test_the_logistic_maps_known_immediate_basins():
    """For 1 < r < 3 all of (0, 1) tends to 1 - 1/r, which parts the superstable orbit of period
    two.
    """
    (only,) = basins(logistic(2.9), max_period=2)
    agree(only.immediate, [[0, TWO_PI]], 1e-11)
    r = 1 + np.sqrt(5.0)
    (pair,) = basins(logistic(r), max_period=4)
    assert pair.orbit.period == 2 and pair.undecided < 1e-6
    arcs = pair.immediate / TWO_PI
    agree(arcs.ravel()[:3], [1 / r, 1 - 1 / r, 1 - 1 / r], 1e-11)
    # G = F² maps the far end of the upper arc onto its near end.
    far = logistic(r)(logistic(r)(pair.immediate[1, 1])) / TWO_PI
    assert abs(far - (1 - 1 / r)) < 1e-9


def test_more_arcs_leave_less_undecided_and_the_first_ones_stand():
    few, many = (basins(MAPS["period two behind a fold"], max_arcs=n)[0] for n in (500, 8000))
    assert 0 < many.undecided < few.undecided < 1
    assert few.measure <= many.measure <= few.measure + few.measure.error_bound
    np.testing.assert_array_equal(few.immediate, many.immediate)


def test_where_nothing_is_stable_there_is_no_basin():
    touching = CircleMap.arnold(0.9 / TWO_PI, 0.9)
    assert [point.kind for point in fixed_points(touching)] == ["saddle-node"]
    for circle_map in (touching, DOUBLING, CircleMap.rigid(0.1234)):
        assert basins(circle_map, max_period=3) == ()
