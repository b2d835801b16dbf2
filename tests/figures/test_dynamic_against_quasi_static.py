"""What the caption of dynamic-against-quasi-static claims: small differences that fall with the
speed squared.
"""

import math

import numpy as np
import pytest

from cyclemap.figures.cycles import inertia_caption

NAME = "dynamic-against-quasi-static"


@pytest.mark.slow
def test_the_difference_falls_with_the_speed_squared_on_both_laws(result) -> None:
    assert result.differences.shape == (2, 3)
    assert result.orders == pytest.approx((2.0, 2.0), abs=0.05)


@pytest.mark.slow
def test_the_caption_tells_the_largest_differences_of_the_result(result) -> None:
    caption = inertia_caption(result)
    for comparison in (result.material, result.isotropic):
        drag = math.degrees(np.abs(comparison.difference("drag_turn")).max())
        assert 0.05 < drag < 0.2
        assert f"{drag:.2f}° in the drag" in caption
    left = math.degrees(result.differences[:, 0].max())
    assert f"At 10 mm/s {left:.3f}° are left" in caption
