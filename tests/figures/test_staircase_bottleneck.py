"""The staircase and its bottleneck: what the caption claims, on a small version and on measured
data.
"""

import math

import numpy as np
import pytest
from figure_cases import assert_drawn
from refusals import refused

from cyclemap.errors import ConvergenceError
from cyclemap.figures import bottleneck as figure
from cyclemap.figures.bottleneck import bottleneck, measured_bottleneck
from cyclemap.figures.catalogue import THETA0_FILE
from cyclemap.maps import CircleMap, WrappedNormal, sample_staircase

NAME = "staircase-bottleneck"


def test_no_direction_repeats_and_the_slowest_is_where_the_saddle_node_was(result) -> None:
    one = result.computed
    turn = np.degrees(one.map.turn(np.linspace(0.0, 2 * np.pi, 2_000)))
    assert 0.0 < turn.min() < 0.5
    assert math.degrees(one.passage.theta) == pytest.approx(162.7, abs=1.0)
    assert math.degrees(one.passage.gap) == pytest.approx(turn.min(), abs=0.01)


def test_steps_sampled_last_as_long_as_predicted_and_about_as_passage_theory_says(result) -> None:
    one = result.computed
    mean, spread = one.visit
    assert one.lengths.size > 80
    assert one.lengths.mean() == pytest.approx(mean, abs=4 * spread / math.sqrt(one.lengths.size))
    assert one.lengths.std() == pytest.approx(spread, rel=0.35)
    assert one.passage.passage_cycles == pytest.approx(mean, rel=0.15)


def test_the_passage_law_fits_the_predicted_directions_at_the_bottleneck(result) -> None:
    """Where a cycle moves by v, a path is 1/v as often: the density's peak is that of the passage
    law.
    """
    one = result.computed
    law = float(one.prediction.mean_turn) / (2 * np.pi) / one.passage.gap
    assert one.density.max() == pytest.approx(law, rel=0.15)
    assert np.trapezoid(one.density, np.linspace(0.0, 2 * np.pi, 721)) == pytest.approx(
        1.0, abs=1e-6
    )


@pytest.mark.slow
def test_the_measured_staircase_has_a_bottleneck_near_95_degrees_and_its_steps_shorten(
    result, measured_data
) -> None:
    found = measured_bottleneck(measured_data / THETA0_FILE)
    assert math.degrees(found.passage.theta) == pytest.approx(95.0, abs=5.0)
    first, second = np.array_split(found.lengths, 2)
    assert found.lengths.size >= 10
    assert first.mean() > 1.5 * second.mean()
    mean, spread = found.visit
    assert abs(found.lengths.mean() - mean) < 2 * found.lengths.std() / math.sqrt(
        found.lengths.size
    )
    assert found.lengths.std() > 1.3 * spread
    assert found.run is not None
    assert found.run.shape == found.path.shape
    assert found.run[0] == found.path[0]
    both = type(result)(result.computed, found)
    assert_drawn(figure.draw_bottleneck(both), 8)
    assert "95°" in figure.bottleneck_caption(both)


def test_measured_pairs_without_an_order_and_a_map_without_bottleneck_are_refused(tmp_path) -> None:
    (tmp_path / "pairs.csv").write_text(
        "theta0_deg,theta_next_deg\n" + "".join(f"{k},{k + 2}\n" for k in range(50))
    )
    refused(measured_bottleneck, tmp_path / "pairs.csv", told="no known order")
    turn, path = (
        CircleMap.rigid(0.1),
        sample_staircase(CircleMap.rigid(0.1), WrappedNormal(0.1), 100).theta,
    )
    refused(bottleneck, "a rotation", turn, 0.1, path, told="no bottleneck", kind=ConvergenceError)
