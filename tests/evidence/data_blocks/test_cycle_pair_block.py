"""Measured cycles as data: exact where the mechanics made them, their derivatives true, wear blended."""

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import DataBlock, SurfaceParameters, cycle_pair_block
from cyclemap.evidence.data_blocks.stroke_block import CYCLE_UNKNOWNS, loop_on

MIT = CollectionLoop.mit()
TRUTH = SurfaceParameters(
    ellipticity_x=-0.1, ellipticity_y=0.12, offset_x=0.03, offset_y=-0.02, pusher_friction=0.17,
    inner_share=0.1, rim_share=0.2, corner_share=0.1, pin_friction_radius=5e-4,
)  # fmt: skip
LATE = {"ellipticity_x": -0.05, "ellipticity_y": 0.1, "offset_x": 0.01, "offset_y": -0.01}
FRESH = TRUTH.values()
VALUES = {**FRESH, **{f"worn_{name}": value for name, value in LATE.items()}}
THETA = np.random.default_rng(0).uniform(-3.0, 9.0, 12)


def made_block(share: np.ndarray | None = None) -> DataBlock:
    turns = loop_on(TRUTH, MIT).next_theta(THETA) - THETA
    return cycle_pair_block(MIT, THETA, turns, np.arange(12), share)


@pytest.mark.slow
def test_cycles_made_by_the_mechanics_leave_no_residual_and_true_derivatives() -> None:
    block = made_block()
    residual, jacobian = block.residuals(FRESH)
    # The Fourier series through 47 cycles is this near; a measured cycle scatters by ten times as much.
    assert np.abs(residual).max() < 2e-3
    for column, name in enumerate(CYCLE_UNKNOWNS):
        step = 1e-6 if name == "pin_friction_radius" else 1e-3 if name.endswith("share") else 1e-4
        sides = [block.residuals({**FRESH, name: FRESH[name] + s * step})[0] for s in (1, -1)]
        expected = (sides[0] - sides[1]) / (2.0 * step)
        assert jacobian[:, column] == pytest.approx(expected, abs=0.02 * np.abs(expected).max()), name


@pytest.mark.slow
def test_wear_blends_the_turns_of_the_fresh_and_the_worn_surface() -> None:
    """At share 0 the prediction is that of the fresh ellipse, at 1 of the worn one, between them on a straight line."""
    fresh, at_end = (made_block().residuals(values)[0] for values in (FRESH, {**FRESH, **LATE}))
    for share in (0.0, 0.25, 1.0):
        block = made_block(np.full(12, share))
        residual, jacobian = block.residuals(VALUES)
        assert residual == pytest.approx((1.0 - share) * fresh + share * at_end, abs=1e-12)
        assert jacobian.shape == (12, len(CYCLE_UNKNOWNS) + 4)
        moved = block.residuals({**VALUES, "worn_offset_x": VALUES["worn_offset_x"] + 1e-4})[0]
        column = jacobian[:, block.parameters.index("worn_offset_x")]
        assert column == pytest.approx((moved - residual) / 1e-4, abs=2e-3)


def test_a_subset_keeps_its_rows_and_their_wear() -> None:
    block = made_block(np.linspace(0.0, 1.0, 12))
    assert block.subset(np.isin(np.arange(12), [2, 5])).residuals(VALUES)[0] == pytest.approx(
        block.residuals(VALUES)[0][[2, 5]]
    )


def test_unequal_lists_and_shares_beyond_one_are_refused() -> None:
    refused(cycle_pair_block, MIT, THETA, THETA[1:], np.arange(12), told="one turn for each")
    refused(made_block, np.full(12, 1.5), told="from 0 to 1")
