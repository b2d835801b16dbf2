"""The animation of locking in: what its frames show, and that pixels and durations of a GIF come
back.
"""

import io
import math
from itertools import pairwise

import numpy as np
import pytest
from figure_cases import NOWHERE, exhibited
from PIL import Image
from refusals import refused

from cyclemap.arrays import placed
from cyclemap.errors import ConvergenceError
from cyclemap.figures import Frame, locking_in
from cyclemap.figures.locking_in import animated_gif

result = exhibited("locking-in")


def test_the_run_ends_near_the_stable_direction_at_63_degrees_and_every_cycle_brings_it_nearer(
    result,
) -> None:
    assert math.degrees(result.stable) == pytest.approx(63.2, abs=0.2)
    off = np.abs(result.theta - result.stable)
    assert np.all(np.diff(off) < 0.0)
    assert np.degrees(off[-2:]).max() < 3.5
    assert off[-1] / off[-2] == pytest.approx(result.multiplier, abs=0.02)


def test_there_is_a_picture_for_every_moment_that_was_asked_for(result) -> None:
    assert len(result.moments) == 5 + 4 + (result.cycles - 2)
    cycles = [moment.cycle for moment in result.moments]
    assert cycles == sorted(cycles)
    assert result.moments[-1].seconds > 1.0


def test_the_object_keeps_its_size_and_every_drag_ends_with_the_ring_on_the_target(result) -> None:
    outline, hitch = result.loop.slider.outline.points(4), np.array(result.loop.slider.hitch)
    for moment in result.moments:
        sides = np.linalg.norm(np.diff(placed(moment.pose, outline), axis=0), axis=1)
        assert np.allclose(sides, 0.09, atol=1e-12)
    drags = [moment for moment in result.moments if not moment.pushing]
    assert len(drags) == 4
    for moment in drags:
        assert np.allclose(placed(moment.pose, hitch), moment.rod_path[-1], atol=1e-5)
    assert np.allclose(placed(drags[-1].pose, hitch), 0.0, atol=1e-9)


@pytest.mark.slow
def test_every_moment_is_a_frame_that_differs_from_the_one_before_it(result) -> None:
    frames = list(locking_in.frames(result))
    assert [frame.seconds for frame in frames] == [moment.seconds for moment in result.moments]
    assert {frame.pixels.shape for frame in frames} == {(410, 720, 3)}
    for before, after in pairwise(frames):
        assert np.ptp(before.pixels.astype(int) - after.pixels) > 50


def _frame(shade: int, seconds: float) -> Frame:
    pixels = np.full((8, 12, 3), 255, dtype=np.uint8)
    pixels[:, shade % 12] = (20, 60, 110)
    return Frame(pixels, seconds)


def test_frames_come_back_in_order_with_pixels_and_durations_of_two_hundredths_at_least() -> None:
    given = [_frame(place, seconds) for place, seconds in enumerate((0.0, 0.034, 0.05, 0.07))]
    picture = Image.open(io.BytesIO(animated_gif(given)))
    assert (picture.n_frames, picture.size, picture.info["loop"]) == (4, (12, 8), 0)
    for number, (frame, lasts) in enumerate(zip(given, (20, 30, 50, 70), strict=True)):
        picture.seek(number)
        assert picture.info["duration"] == lasts
        assert np.abs(np.asarray(picture.convert("RGB"), dtype=int) - frame.pixels).max() <= 6


def test_a_run_that_does_not_lock_in_is_refused(monkeypatch) -> None:
    monkeypatch.setattr(locking_in, "MOST_CYCLES", 2)
    start = math.radians(120.0)
    refused(locking_in.compute, NOWHERE, start, told="do not lock", kind=ConvergenceError)
