"""Nodes hold what the loop does, with its derivatives, and the series between them is exact for short series."""

from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.data_blocks.cycle_pair_block import CYCLE_UNKNOWNS, interpolation, interpolation_slope, loop_on
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters
from cyclemap.evidence.published_comparison import cycle_nodes, node_values

SURFACE = SurfaceParameters(
    ellipticity_x=0.1,
    ellipticity_y=-0.05,
    offset_x=0.04,
    offset_y=0.08,
    pusher_friction=0.16,
    inner_share=0.1,
    rim_share=0.4,
    corner_share=0.1,
    pin_friction_radius=1.5e-3,
)


def test_a_series_of_low_orders_and_its_slope_come_back_between_the_nodes():
    nodes, theta = 2 * np.pi * np.arange(11) / 11, np.linspace(-1.0, 8.0, 40)
    values = 1.0 + np.cos(3 * nodes) - 0.5 * np.sin(5 * nodes)
    assert interpolation(theta, 11) @ values == pytest.approx(1.0 + np.cos(3 * theta) - 0.5 * np.sin(5 * theta))
    slope = -3 * np.sin(3 * theta) - 2.5 * np.cos(5 * theta)
    assert interpolation_slope(theta, 11) @ values == pytest.approx(slope)


def test_between_47_nodes_the_loop_is_met_within_a_hundredth_of_a_degree_and_ten_micrometres():
    loop = loop_on(SURFACE, CollectionLoop.mit())
    theta = np.array([0.3, 2.0, 4.4])
    found, runs = interpolation(theta, 47) @ node_values(loop), loop.cycles(theta)
    assert found[:, 0] == pytest.approx(runs.theta_next - theta, abs=np.deg2rad(0.01))
    assert found[:, 1] == pytest.approx(runs.push_turn, abs=np.deg2rad(0.01))
    assert found[:, 2:] == pytest.approx(runs.push_displacement, abs=1e-5)


def test_derivatives_are_those_of_the_values_by_central_differences():
    loop = CollectionLoop.mit()
    _, jacobian = cycle_nodes(SURFACE, loop, 9)
    assert jacobian.shape == (9, 4, len(CYCLE_UNKNOWNS))
    for index, name in enumerate(CYCLE_UNKNOWNS):
        step = 5e-4 * (1e-2 if name == "pin_friction_radius" else 1.0)
        ends = [replace(SURFACE, **{name: getattr(SURFACE, name) + sign * step}) for sign in (1, -1)]
        ahead, behind = (node_values(loop_on(surface, loop), 9) for surface in ends)
        slope = (ahead - behind) / (2 * step)
        assert jacobian[..., index] == pytest.approx(slope, rel=0.01, abs=3e-3 * np.abs(slope).max())


def test_an_even_number_of_nodes_is_refused():
    with pytest.raises(InvalidInput, match="odd"):
        cycle_nodes(SURFACE, CollectionLoop.mit(), 10)
