"""Statistics of a run as data: what they are on simple surfaces, their derivatives, and recovery of a known surface."""

from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.evidence.data_blocks.cycle_pair_block import CYCLE_UNKNOWNS, loop_on
from cyclemap.evidence.identification.identify import identify
from cyclemap.evidence.identification.surface_parameters import SURFACE, SurfaceParameters
from cyclemap.evidence.published_comparison import (
    CYCLE_NOISE,
    TOLERANCES,
    node_values,
    predicted_statistics,
    statistics_block,
)
from cyclemap.evidence.published_statistics import published_statistics

LOOP = CollectionLoop.mit()
NODES, CYCLES = 11, 100
TRUTH = SurfaceParameters(ellipticity_x=0.1, offset_x=0.05, offset_y=-0.06, pusher_friction=0.15, rim_share=0.3)


def statistics_of(surface: SurfaceParameters, like: str):
    """A published row that the surface meets exactly, with the scatter and the directions of a real one."""
    given = published_statistics(like)
    found = predicted_statistics(node_values(loop_on(surface, LOOP), NODES), given, cycles=CYCLES)
    return replace(given, mean=tuple(found.mean.tolist()), std=tuple(found.std.tolist()))


def test_on_an_isotropic_surface_all_pushes_are_one_push_and_the_spread_is_the_scatter():
    given = published_statistics("pu")
    loop = loop_on(SurfaceParameters(), LOOP)
    found, push = predicted_statistics(node_values(loop, 9), given), loop.cycle(1.0)
    assert found.mean == pytest.approx([push.push_turn, *push.push_displacement], abs=1e-5)
    assert found.std == pytest.approx(given.rmse, rel=1e-4)
    assert found.law * found.law.size == pytest.approx(np.ones(found.law.size), abs=1e-3)


def test_the_statistics_are_those_of_a_sampled_run():
    """The same noisy cycles drawn one after the other, from many starts."""
    given = replace(published_statistics("delrin"), rmse=(0.0, 0.0, 0.0))
    angles, count = 2 * np.pi * np.arange(NODES) / NODES, 4000
    values = np.column_stack(
        [0.15 + 0.1 * np.cos(angles), 1.3 + 0.05 * np.sin(angles), 0.04 + 0.003 * np.cos(angles), -0.06 + 0 * angles]
    )
    found = predicted_statistics(values, given, cycles=CYCLES)
    rng, pushes = np.random.default_rng(1), []
    theta = 2 * np.pi * rng.random(count)
    for _ in range(CYCLES):
        pushes.append([1.3 + 0.05 * np.sin(theta), 0.04 + 0.003 * np.cos(theta)])
        theta = theta + 0.15 + 0.1 * np.cos(theta) + CYCLE_NOISE * rng.standard_normal(count)
    sampled = np.array(pushes).transpose(1, 0, 2).reshape(2, -1)
    assert found.mean[:2] == pytest.approx(sampled.mean(axis=1), rel=1e-3)
    assert found.std[:2] == pytest.approx(sampled.std(axis=1), rel=2e-3)


def test_share_of_the_first_direction_counts_the_cycles_nearer_to_it():
    """A map that returns to -150 degrees from all around keeps the run there; one to 150 degrees does not."""
    given, angles = published_statistics("abs"), 2 * np.pi * np.arange(NODES) / NODES
    shares = []
    for direction in given.directions:
        turn = -0.3 * np.sin(angles - direction)
        shares.append(predicted_statistics(np.column_stack([turn, *np.zeros((3, NODES))]), given).first_share)
    assert shares[0] > 0.999
    assert shares[1] < 0.02


@pytest.mark.parametrize("material", ["abs", "pu"])
def test_derivatives_are_those_of_the_residuals_by_central_differences(material):
    """Through mechanics and law of orientations together, where the block itself differences the law alone."""
    block = statistics_block(published_statistics(material), LOOP, nodes=9, cycles=CYCLES)
    values = TRUTH.values()
    rows, jacobian = block.residuals(values)
    assert jacobian.shape == (len(block.groups), len(CYCLE_UNKNOWNS)) == (rows.size, len(CYCLE_UNKNOWNS))
    for name in ("ellipticity_x", "rim_share"):
        step = 1e-3 * SURFACE[name].scale
        ends = [block.residuals({**values, name: values[name] + sign * step})[0] for sign in (1, -1)]
        slope = (ends[0] - ends[1]) / (2 * step)
        found = jacobian[:, CYCLE_UNKNOWNS.index(name)]
        assert found == pytest.approx(slope, rel=0.01, abs=0.01 * np.abs(slope).max())


def test_a_surface_is_recovered_from_its_own_statistics():
    """Six numbers fix the offset of the ellipse when the rest and its quadrant are known."""
    given = replace(statistics_of(TRUTH, "delrin"), directions=(), only_there=False)
    block = statistics_block(given, LOOP, nodes=NODES, cycles=CYCLES)
    free, values = ["offset_x", "offset_y"], TRUTH.values()
    fixed = {name: values[name] for name in block.parameters if name not in free}
    noise = {kind: TOLERANCES[kind] for kind in set(block.kinds.tolist())}
    near = [replace(SURFACE[name], start=0.7 * values[name]) for name in free]
    space = SURFACE.extended(*near)
    found = identify([block], free, fixed, starts=1, noise=noise, space=space)
    assert found.fit.deviance == pytest.approx(2 * sum(np.log(TOLERANCES[kind]) for kind in block.kinds), abs=1e-6)
    assert [found[name].value for name in free] == pytest.approx([0.05, -0.06], abs=1e-4)
