"""Theorem: a rod that starts inside an outline touched it where one that came the same way from outside does."""

import math

import numpy as np
import pytest

from cyclemap.evidence.replay.replay_table import dataset_sliders
from cyclemap.mechanics.contact_curve import contact_curve
from cyclemap.mechanics.first_touch import first_touch, first_touches, overlaps


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rect1", "tri3", "hex", "ellip1", "ellip3", "butter"])
def test_a_touch_lies_behind_a_rod_that_went_on_inside(name: str) -> None:
    outline = dataset_sliders()[name].outline
    radius, rng = 0.00475, np.random.default_rng(5)
    curve = contact_curve(outline, radius)
    starts = rng.uniform(-2.0, 2.0, (120, 2)) * outline.extent
    starts = starts[[not overlaps(outline, radius, place) for place in starts]]
    directions = np.arctan2(*(-starts).T[::-1]) + rng.normal(0.0, 0.4, len(starts))
    travel, piece, coordinate = first_touches(curve.pieces, radius, starts, directions)
    met = 0
    for number, (start, direction) in enumerate(zip(starts, directions.tolist(), strict=True)):
        one = first_touch(curve.pieces, radius, start, direction)
        if one is None:
            assert math.isnan(travel[number])
            continue
        assert one[1] == piece[number]
        assert (one[0], one[2]) == pytest.approx((travel[number], coordinate[number]), rel=1e-9, abs=1e-12)
        behind = start + (one[0] + 1e-3) * np.array([math.cos(direction), math.sin(direction)])
        if overlaps(outline, radius, behind):
            back = first_touches(curve.pieces, radius, behind[None], np.array([direction]))[0][0]
            assert back == pytest.approx(-1e-3, abs=1e-10)
            met += 1
    assert met > 30


@pytest.mark.parametrize("name", ["rect1", "hex", "ellip3"])
def test_a_rod_that_touches_meets_the_object_at_once_or_has_left_it(name: str) -> None:
    """Half a nanometre off or in, as rounding leaves it: inwards the touch is here, outwards there is none."""
    outline, radius = dataset_sliders()[name].outline, 0.00475
    pieces = contact_curve(outline, radius).pieces
    start, direction = np.array([2.0 * outline.extent, 0.003]), math.pi
    touch = first_touch(pieces, radius, start, direction)
    assert touch is not None
    for off in (-5e-10, 0.0, 5e-10):
        place = start - np.array([touch[0] - off, 0.0])
        met = first_touch(pieces, radius, place, direction)
        assert met is not None and met[0] == pytest.approx(0.0, abs=1e-9)
        assert first_touch(pieces, radius, place, 0.0) is None
