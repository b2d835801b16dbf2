"""Animated GIFs: durations and pixels come back, and what is no animation is refused."""

import io

import numpy as np
import pytest
from PIL import Image

from cyclemap.errors import InvalidInput
from cyclemap.figures.catalogue import Frame
from cyclemap.figures.locking_in import animated_gif, figure_pixels
from cyclemap.views.style import new_figure


def _frame(shade: int, seconds: float = 0.05, height: int = 8) -> Frame:
    pixels = np.full((height, 12, 3), 255, dtype=np.uint8)
    pixels[:, shade % 12] = (20, 60, 110)
    return Frame(pixels, seconds)


def test_frames_come_back_in_order_with_their_pixels_and_durations() -> None:
    given = [_frame(place, 0.04 + 0.01 * place) for place in range(4)]
    picture = Image.open(io.BytesIO(animated_gif(given)))
    assert (picture.n_frames, picture.size, picture.info["loop"]) == (4, (12, 8), 0)
    for number, frame in enumerate(given):
        picture.seek(number)
        assert picture.info["duration"] == round(1000 * frame.seconds)
        assert np.abs(np.asarray(picture.convert("RGB"), dtype=int) - frame.pixels).max() <= 6


def test_durations_are_hundredths_and_two_of_them_at_least() -> None:
    picture = Image.open(io.BytesIO(animated_gif([_frame(0, 0.0), _frame(1, 0.034)])))
    durations = []
    for number in range(2):
        picture.seek(number)
        durations.append(picture.info["duration"])
    assert durations == [20, 30]


def test_a_figure_becomes_pixels_of_its_size() -> None:
    pixels = figure_pixels(new_figure(1.2, 0.8), 50)
    assert pixels.shape == (40, 60, 3)
    assert pixels.min() == 255


def test_no_frames_and_frames_of_two_sizes_are_refused() -> None:
    with pytest.raises(InvalidInput, match="at least one frame"):
        animated_gif([])
    with pytest.raises(InvalidInput, match="one size"):
        animated_gif([_frame(0), _frame(0, height=9)])
