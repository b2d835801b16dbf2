"""The phase diagram: what its caption claims, on a small version."""

import math
from functools import partial

import numpy as np
import pytest
from figure_cases import exhibited

from cyclemap.collection import CollectionLoop
from cyclemap.figures import phase_diagram
from cyclemap.figures.loop_family import ring_fold, with_anisotropy_times, with_ring_at
from cyclemap.figures.phase_diagram import RADII
from cyclemap.maps import fixed_points

PLYWOOD = CollectionLoop.mit(material="plywood")

result = exhibited("phase-diagram")


def fixed_directions(loop):
    return len(fixed_points(loop.circle_map(tolerance=1e-4)))


def test_at_the_tip_of_the_tongue_isotropic_friction_turns_the_object_by_nothing(result) -> None:
    tip = with_ring_at(with_anisotropy_times(PLYWOOD, 0.0), result.first.neutral)
    assert abs(tip.cycle(1.0).theta_next - 1.0) < math.radians(0.05)
    assert 1000 * result.first.neutral == pytest.approx(21.3, abs=0.1)
    assert np.nanmin(result.first.scale) < 0.02


def test_the_grid_is_locked_between_the_edges_and_winds_outside(result) -> None:
    locked = result.plane.period == 1
    assert 20 < locked.sum() < locked.size - 20
    assert np.all(result.stable[locked] == 1)
    compared = 0
    for edge, outside in ((result.inner, -1), (result.outer, 1)):
        for scale, fold in edge:
            column = int(np.argmin(np.abs(result.plane.second_values - scale)))
            if abs(result.plane.second_values[column] - scale) > 0.03:
                continue
            away = outside * (result.plane.first_values - fold.radius)
            assert not locked[away > 0.001, column].any()
            compared += 1
    assert compared >= 1


def test_edges_are_folds_of_the_mechanics_with_fixed_points_on_one_side_only(result) -> None:
    assert len(result.inner) == len(result.outer) == 2
    scale, fold = result.inner[0]
    surface = with_anisotropy_times(PLYWOOD, scale)
    for radius, count in ((fold.radius - 2e-4, 0), (fold.radius + 2e-4, 2)):
        assert fixed_directions(with_ring_at(surface, radius)) == count
    for radius, edge in ((RADII[0], result.inner), (RADII[1], result.outer)):
        assert edge[-1][1].radius == pytest.approx(radius, abs=5e-4)


def test_the_first_order_edge_is_missed_by_the_square_of_the_anisotropy(result) -> None:
    """First order gives ε to O(ε²): halving ε quarters what it misses on the exact edge."""
    first, misses = result.first, []
    ahead = first.turn > 0.0
    grid = 2 * np.pi * np.arange(24) / 24
    for scale in (0.3, 0.15):
        surface = with_anisotropy_times(PLYWOOD, scale)
        start = float(np.interp(-scale, -first.scale[ahead], first.radius[ahead]))
        theta = float(grid[np.argmin(with_ring_at(surface, start).next_theta(grid) - grid)])
        fold = ring_fold(partial(with_ring_at, surface), theta, start)
        misses.append(
            float(np.interp(fold.radius, first.radius[ahead], first.scale[ahead])) - scale
        )
    assert misses[0] / misses[1] == pytest.approx(4.0, rel=0.35)


def test_the_mit_ring_locks_on_plywood_and_from_the_scale_that_the_caption_tells(result) -> None:
    assert result.mit == pytest.approx(0.015)
    for scale, count in ((result.mit_scale - 0.03, 0), (result.mit_scale + 0.03, 2)):
        assert fixed_directions(with_anisotropy_times(PLYWOOD, scale)) == count
    assert f"{result.mit_scale:.2f} times Table I" in phase_diagram.caption(result)
    assert "one stable direction" in phase_diagram.caption(result)
