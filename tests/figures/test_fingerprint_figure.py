"""The figure's caption holds: within the stated error, the square of the anisotropy, an edge that
is nearly right.
"""

import math

import numpy as np
import pytest
from figure_cases import exhibited

from cyclemap.figures import fingerprint as figure

result = exhibited("fingerprint")


def test_the_predicted_direction_lies_within_the_error_it_states(result) -> None:
    (stable,) = (found for found in result.checked.directions if found.predicted.stable)
    assert stable.within_error
    assert math.degrees(stable.full.points[0]) == pytest.approx(63.168, abs=0.02)


def test_the_error_of_the_turn_is_of_second_order_and_that_of_the_direction_of_first(
    result,
) -> None:
    assert figure.order(result.scales, result.turn_error) == pytest.approx(2.0, abs=0.1)
    assert figure.order(result.scales, result.direction_error) == pytest.approx(1.0, abs=0.05)
    assert np.count_nonzero(result.scales <= figure.ASYMPTOTIC) == 3
    assert np.all(result.second_turn_error < result.turn_error)


def test_the_edge_is_omega_over_the_amplitude_and_the_full_maps_lies_a_little_inside(
    result,
) -> None:
    found = result.prediction.fingerprint.cycle
    expected = np.diag(found.turn / np.array([found.offset_amplitude, found.ellipse_amplitude]))
    assert result.predicted_edge == pytest.approx(expected, abs=1e-12)
    shares = np.diag(result.full_edge) / np.diag(expected)
    assert np.all((shares > 0.8) & (shares < 1.0))
