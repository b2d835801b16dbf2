"""Push end points and drag-backs as data: exact where the mechanics made them, their derivatives true."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

from cyclemap.evidence import (
    MeasuredDrag,
    MeasuredPush,
    SurfaceParameters,
    drag_turn_block,
    push_end_block,
    read_measured_drags,
)
from cyclemap.evidence.data_blocks.stroke_block import predicted_push_ends, surface_model
from cyclemap.mechanics import Pose, Slider, WorldPush

RECT1 = Slider.mit("rect1")
TRUTH = SurfaceParameters(
    ellipticity_x=0.1, ellipticity_y=-0.05, offset_x=0.04, offset_y=0.02, pusher_friction=0.2, rim_share=0.4,
    pin_friction_radius=1e-3,
)  # fmt: skip
VALUES = {**TRUTH.values(), "tip_offset_x": 8e-4, "tip_offset_y": -5e-4}
OFFSET = np.array([8e-4, -5e-4])
PLAIN = {**SurfaceParameters().values(), "tip_offset_x": 0.0, "tip_offset_y": 0.0}


def made_pushes(count: int) -> list[MeasuredPush]:
    """Pushes of 50 mm from random sides at random angles, as a robot whose frame is shifted would record them."""
    generator, model, pushes = np.random.default_rng(0), surface_model(TRUTH, RECT1, accuracy=1e-9), []
    for number in range(count):
        start, way = Pose(0.0, 0.0, float(generator.uniform(-3.0, 3.0))), float(generator.uniform(-math.pi, math.pi))
        along = 0.115 * np.array([math.cos(way), math.sin(way)])
        first = np.array(start.to_world(*generator.uniform(-0.02, 0.02, 2).tolist())) - along
        end = model.push(start, WorldPush(tuple(first.tolist()), way, 0.115)).end
        tips = (tuple(tip.tolist()) for tip in (first - OFFSET, first + along - OFFSET))
        pushes.append(MeasuredPush(start, end, *tips, number // 2))
    return pushes


def made_drags(count: int) -> list[MeasuredDrag]:
    """Drags of the ring to the origin from random poses."""
    generator, model, drags = np.random.default_rng(1), surface_model(TRUTH, RECT1, accuracy=1e-9), []
    for number in range(count):
        start = Pose(*generator.uniform(-0.08, 0.08, 2).tolist(), float(generator.uniform(-3.0, 3.0)))
        end = model.drag(start, ((0.0, 0.0),), pin_friction_radius=TRUTH.pin_friction_radius).end
        drags.append(MeasuredDrag(start, end, number))
    return drags


@pytest.mark.parametrize("made", ["pushes", "drags"])
@pytest.mark.parametrize("shares", [{}, {"corner_share": 0.3, "inner_share": 0.5}])
def test_strokes_made_by_the_mechanics_leave_no_residual_and_true_derivatives(made: str, shares: dict) -> None:
    strokes = {"pushes": made_pushes, "drags": made_drags}[made](8)
    block = {"pushes": push_end_block, "drags": drag_turn_block}[made](strokes, RECT1)
    values = VALUES | shares
    residual, jacobian = block.residuals(values)
    assert np.abs(residual).max() < 3e-5 or shares
    assert jacobian.shape == {"pushes": (24, 10), "drags": (8, 8)}[made]
    for column, name in enumerate(block.parameters):
        step = 1e-5 if name == "pin_friction_radius" else 2e-4
        # Shares at their least value have one side alone.
        low = 0.0 if name in ("corner_share", "inner_share") and values[name] == 0.0 else -step
        sides = [block.residuals({**values, name: values[name] + by})[0] for by in (step, low)]
        expected = (sides[0] - sides[1]) / (step - low)
        assert jacobian[:, column] == pytest.approx(expected, abs=0.02 * np.abs(expected).max()), name


def test_no_unknowns_within_their_bounds_take_more_than_the_whole_weight() -> None:
    for rim, corner, inner in itertools.product((0.0, 0.4, 1.0), repeat=3):
        surface = SurfaceParameters(rim_share=rim, corner_share=corner, inner_share=inner)
        pressure = surface_model(surface, RECT1).pressure
        assert {name: getattr(pressure, name) for name in surface.shares} == surface.shares
        assert pressure.even_share == pytest.approx((1.0 - rim) * (1.0 - corner) * (1.0 - inner), abs=1e-15)


@pytest.mark.parametrize(("shape", "lacking"), [("ellip2", {"corner_share"}), ("tri3", set())])
def test_shares_that_an_outline_cannot_have_are_no_unknowns(shape: str, lacking: set[str]) -> None:
    block = push_end_block(made_pushes(2), Slider.mit(shape))
    assert {"rim_share", "corner_share", "inner_share"} - set(block.parameters) == lacking
    residual, jacobian = block.residuals(VALUES)
    assert jacobian.shape == (6, len(block.parameters)) and np.isfinite(jacobian).all() and np.isfinite(residual).all()


def test_a_rod_that_starts_inside_is_drawn_back_and_one_that_misses_moves_nothing() -> None:
    model = surface_model(TRUTH, RECT1)
    inside = MeasuredPush(Pose(), Pose(), (-0.018, 0.0495), (-0.018, -0.0005))
    whole = model.push(Pose(), WorldPush((-0.018, 0.06), -math.pi / 2.0, 0.0605)).end
    missing = MeasuredPush(Pose(), Pose(), (0.2, 0.2), (0.2, 0.3))
    ends, by_shift = predicted_push_ends(model, [inside, missing])
    assert ends[0, 2] == pytest.approx(whole.theta, abs=1e-4)
    assert not ends[1].any() and not by_shift[1].any() and by_shift[0].any()
    assert not predicted_push_ends(model, [missing])[0].any()
    refused(predicted_push_ends, model, [MeasuredPush(Pose(), Pose(), (0.0, 0.0), (0.001, 0.0))], told="deep inside")


def test_a_subset_holds_whole_groups_and_an_empty_block_is_refused() -> None:
    block = push_end_block(made_pushes(6), RECT1)
    part = block.subset(block.groups == 1)
    assert len(part.groups) == 6
    assert part.residuals(VALUES)[0] == pytest.approx(block.residuals(VALUES)[0][6:12])
    refused(drag_turn_block, [], RECT1, told="no strokes")


@pytest.mark.parametrize(("surface", "slope", "radius"), [("plywood", 0.74, 0.0), ("abs", 0.68, 2e-3)])
def test_measured_drags_turn_less_than_even_pressure_and_a_free_ring_would_let_them(
    measured_data: Path, surface: str, slope: float, radius: float
) -> None:
    """Regression slopes measured over predicted are below one; weight on the rim and a rubbing ring help."""
    drags = read_measured_drags(measured_data / "mit_rect1_dragback_v10.csv", {"surface": surface})
    block = drag_turn_block(drags, RECT1)
    measured, ideal = np.array([drag.end.theta - drag.start.theta for drag in drags]), block.residuals(PLAIN)[0]
    predicted = measured + ideal
    assert predicted @ measured / (predicted @ predicted) == pytest.approx(slope, abs=0.02)
    rubbing = block.residuals({**PLAIN, "rim_share": 0.64, "pin_friction_radius": radius})[0]
    assert np.median(np.abs(rubbing)) < 0.8 * np.median(np.abs(ideal))
