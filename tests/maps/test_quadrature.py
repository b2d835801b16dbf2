"""Quadrature rules that fit a map."""

import numpy as np
import pytest

from cyclemap.maps import CircleMap
from cyclemap.maps.quadrature import arc_rule


@pytest.mark.parametrize("breaks", [(), (1.0,), (0.0,), (3.0, 3.1, 6.28)])
def test_rule_is_exact_for_harmonics_and_for_steps_at_breaks(breaks) -> None:
    """The weights sum to a turn, harmonics of the bandwidth are integrated, and so is a step at any
    break.
    """
    theta, weight = arc_rule(
        CircleMap(lambda x: x + 0.3, np.ones_like, breaks), 0.0, 2.0 * np.pi, 40
    )
    assert weight.sum() == pytest.approx(2.0 * np.pi, abs=1e-12)
    assert weight @ np.cos(17 * theta) ** 2 == pytest.approx(np.pi, abs=1e-11)
    for place in breaks:
        assert weight @ (theta < place) == pytest.approx(place, abs=1e-12)
