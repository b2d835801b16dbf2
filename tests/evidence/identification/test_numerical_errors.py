"""Predictions are computed to an accuracy: what that moves an estimate by is in its interval."""

from dataclasses import replace

import numpy as np

from cyclemap import ConvergenceError, Pose, SidePush, Slider
from cyclemap.evidence import (
    DataBlock,
    MeasuredDrag,
    SurfaceParameters,
    drag_turn_block,
    identify,
    push_end_block,
)
from cyclemap.evidence.identification.data_block import linear_block
from cyclemap.evidence.identification.stroke_block import surface_model
from cyclemap.evidence.identification.surface_parameters import SURFACE
from cyclemap.evidence.predicted_strokes import (
    predicted_drag_ends,
    predicted_push_ends,
    push_from_contact,
)

PLATE = Slider.mit("rect1")
FREE = (*SURFACE.names[1:5], "floor_dome", "floor_bow_x", "pusher_friction")


def usual_values(rng: np.random.Generator) -> dict[str, float]:
    """A surface of a usual kind."""
    centre = np.array([0.0, 0.0, 0.0, 0.0, 2.5, 0.0, 0.2])
    width = np.array([0.1, 0.1, 0.05, 0.05, 0.8, 2.0, 0.04])
    drawn = centre + width * np.clip(rng.standard_normal(centre.size), -2.0, 2.0)
    return SurfaceParameters().values() | dict(zip(FREE, drawn.tolist(), strict=True))


def ratio_block(ratios: np.ndarray) -> DataBlock:
    rows = np.arange(ratios.size)
    ones = np.ones((ratios.size, 1))
    return linear_block("ratios", ("pusher_friction",), ones, ratios, rows, "ratio")


def test_an_error_of_the_computation_moves_the_estimate_within_its_interval() -> None:
    """Rows computed .01 too large, nearly without noise: the truth is .01 away, and is in the
    interval; without word of that error it is outside.
    """
    data = 0.2 + 1e-6 * np.cos(7.0 * np.arange(12))

    coarse, exact = (ratio_block(data - off) for off in (0.01, 0.0))
    plain, refined = coarse, replace(coarse, refined=(exact.function,))
    silent = identify([plain], ["pusher_friction"], starts=1)["pusher_friction"]
    honest = identify([refined], ["pusher_friction"], starts=1)["pusher_friction"]
    assert silent.upper < 0.2
    assert honest.value == silent.value
    assert honest.lower < 0.2 < honest.upper
    assert np.isclose(honest.standard_error, 0.01 * np.sqrt(1.0 + 1.0 / 12.0), rtol=1e-3)
    # A part of the rows keeps its own errors.
    half = refined.subset(np.arange(12) < 6)
    assert np.allclose(half.numerical_errors({"pusher_friction": 0.3}), 0.01)


def test_data_that_have_no_answer_so_closely_computed_are_identified_with_a_note() -> None:
    """As before, but that nothing is known of the error of what is computed."""

    def unanswered(values: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
        raise ConvergenceError("the motion has no answer")

    plain = ratio_block(np.array([0.19, 0.2, 0.22]))
    before = identify([plain], ["pusher_friction"], starts=1)
    after = identify([replace(plain, refined=(unanswered,))], ["pusher_friction"], starts=1)
    assert after.estimates == before.estimates
    assert sum("the motion has no answer" in note for note in after.notes) == 1


def test_intervals_of_exact_pushes_and_drags_hold_the_truth() -> None:
    """Strokes computed a million times more closely than the search begins with, without noise:
    it goes on more closely, and what is left of its own accuracy is in the intervals.
    """
    rng = np.random.default_rng(1)
    for _ in range(2):
        values = usual_values(rng)
        model = surface_model(SurfaceParameters.from_values(values), PLATE, 1e-9)
        pushes = []
        drags = []
        for _ in range(30):
            start = Pose(0.0, 0.0, rng.uniform(0.0, 2.0 * np.pi))
            fraction, angle, far = rng.uniform([0.1, -0.6, 0.03], [0.9, 0.6, 0.15]).tolist()
            side = SidePush(int(rng.integers(4)), fraction, angle, far)
            pushes.append(push_from_contact(PLATE, 0.00475, side, start, start))
            apart = Pose(*rng.uniform(-0.05, 0.1, 2), start.theta)
            drags.append(MeasuredDrag(apart, Pose()))
        push_ends = predicted_push_ends(model, pushes)[0].tolist()
        drag_ends = predicted_drag_ends(model, drags, values["pin_friction_radius"])[0].tolist()
        for index in range(30):
            pushes[index] = replace(pushes[index], end=Pose(*push_ends[index]), contact=index)
            drags[index] = replace(drags[index], end=Pose(*drag_ends[index]), contact=index)
        blocks = [push_end_block(pushes, PLATE), drag_turn_block(drags, PLATE)]
        fixed = {name: values[name] for name in SURFACE.names if name not in FREE}
        for row in identify(blocks, FREE, fixed, starts=1).estimates:
            assert row.lower <= values[row.name] <= row.upper, row
            assert row.standard_error < 3e-6
