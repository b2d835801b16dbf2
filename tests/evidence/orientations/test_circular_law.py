"""The table of a law on the circle, against closed forms and scipy's von Mises law."""

import numpy as np
import pytest
from scipy.stats import vonmises

from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.circular_distance import CircularLaw, orientations

TURN = 2 * np.pi


def uniform(theta):
    return np.full_like(theta, 1.0 / TURN)


def box(theta):
    """All mass between 1 and 3."""
    return np.where((theta >= 1.0) & (theta < 3.0), 0.5, 0.0)


def test_the_distribution_function_is_that_of_the_von_mises_law() -> None:
    law, angles = CircularLaw(lambda theta: vonmises.pdf(theta, 20.0, loc=2.0)), np.linspace(0.0, 6.28, 777)
    truth = vonmises.cdf(angles, 20.0, loc=2.0) - vonmises.cdf(0.0, 20.0, loc=2.0)
    assert np.abs(law.cumulative(angles) - truth).max() < 1e-10


def test_the_error_falls_with_the_fourth_power_of_the_cell() -> None:
    angles = np.linspace(0.0, 6.28, 7777)
    truth = angles / TURN + 0.8 * np.sin(3 * angles) / (3 * TURN)
    counts = np.array([16, 32, 64, 128])
    errors = []
    for count in counts:
        law = CircularLaw(lambda theta: (1.0 + 0.8 * np.cos(3 * theta)) / TURN, cells=int(count))
        errors.append(np.abs(law.cumulative(angles) - truth).max())
    assert -np.polyfit(np.log(counts), np.log(errors), 1)[0] > 3.7


def test_the_distribution_function_never_falls_even_beside_jumps() -> None:
    reached = CircularLaw(box).cumulative(np.linspace(0.0, TURN * (1 - 1e-12), 50_001))
    assert np.diff(reached).min() >= -1e-14
    assert reached[0] == 0.0
    assert reached[-1] == pytest.approx(1.0, abs=1e-12)


def test_a_jump_costs_no_more_than_a_cell() -> None:
    law, angles = CircularLaw(box), np.linspace(0.0, 6.28, 999)
    assert np.abs(law.cumulative(angles) - np.clip(0.5 * (angles - 1.0), 0.0, 1.0)).max() < TURN / law.cells


def test_bins_share_out_the_whole_law() -> None:
    shares = CircularLaw(lambda theta: (1.0 + np.cos(theta)) / TURN).bin_probabilities(4)
    quarter, wave = 0.25, 1.0 / TURN
    assert np.allclose(shares, [quarter + wave, quarter - wave, quarter - wave, quarter + wave], atol=1e-12)


def test_whole_turns_do_not_matter() -> None:
    law = CircularLaw(lambda theta: (1.0 + np.cos(theta)) / TURN)
    assert np.allclose(law.cumulative([1.0, 1.0 + 3 * TURN, 1.0 - TURN]), law.cumulative(1.0), atol=1e-14)
    assert orientations("the sample", [-1e-20]).tolist() == [0.0]


@pytest.mark.parametrize(
    ("density", "match"),
    [
        (lambda theta: np.full_like(theta, 1.0 / 360.0), "integrates to 0.0174533 over the circle, not 1"),
        (lambda theta: uniform(theta) * 1.02, "integrates to 1.02"),
        (lambda theta: (1.0 + 1.5 * np.cos(theta)) / TURN, "must not be negative"),
        (lambda theta: np.where(theta > 3.0, np.nan, 0.1), "must be finite"),
        (lambda theta: np.array(1.0 / TURN), "must be vectorised"),
        (0.3, "vectorised callable"),
    ],
)
def test_what_is_no_density_is_refused(density, match) -> None:
    with pytest.raises(InvalidInput, match=match):
        CircularLaw(density)


def test_too_few_cells_are_refused() -> None:
    with pytest.raises(InvalidInput, match="cells must be at least 8"):
        CircularLaw(uniform, cells=4)
