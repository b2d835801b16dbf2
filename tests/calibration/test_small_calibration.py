"""Every p-value holds its level under its null:
a small version of `python -m tests.calibration`."""

import numpy as np
import pytest
from scipy.stats import binom

from tests.calibration.p_value_studies import STUDIES
from tests.calibration.planned_pushes import identified_errors

RUNS = 60


def rejects_no_more_often(values: np.ndarray, level: float, chance: float | None = None) -> bool:
    """Whether a calibrated p-value exceeds the share at or below the level once in 2000 times."""
    return np.sum(values <= level + 1e-12) <= binom.ppf(0.9995, values.size, chance or level)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "simulations"), [("chain", 19), ("ghost", 1), ("well", 1)])
def test_no_p_value_rejects_the_truth_more_often_than_it_says(name: str, simulations: int) -> None:
    found = STUDIES[name][0](RUNS, simulations, 77)
    assert len(found) >= 2
    for test, values in found.items():
        assert values.size > 0.8 * RUNS, test
        assert all(rejects_no_more_often(values, level) for level in (0.05, 0.1, 0.5)), test
        # Nor hardly ever: half of them lie above one half.
        assert np.mean(values <= 0.5) > 0.25, test


@pytest.mark.slow
def test_p_values_under_wear_hold_their_level() -> None:
    found = STUDIES["wear"][0](40, 19, 78)
    tests = ("wasserstein", "total_variation", "kuiper", "watson", "turns", "map")
    assert set(found) == {f"{name}, wear" for name in tests}
    for values in found.values():
        assert rejects_no_more_often(values, 0.1)
        assert 0.2 < np.mean(values <= 0.5) < 0.8


def test_a_mean_is_within_its_error_as_often_as_it_says() -> None:
    for values in STUDIES["bias"][0](RUNS, 1, 79).values():
        assert rejects_no_more_often(values, 0.05, 0.09)


@pytest.mark.slow
def test_errors_after_planned_pushes_of_rods_set_by_hand_are_of_the_size_that_is_said() -> None:
    """Each rod is 2 mm off its mark: with one noise for all pushes the unknowns of these worlds
    were off by 1.7 of their standard errors. A plate that is warped by 25 kPa is off by 3.3,
    so that single numbers are not asked for.
    """
    off = np.abs(identified_errors(6))
    assert off.shape == (6, 12)
    assert 0.6 < np.median(off) / 0.6745 < 1.4
    assert 0.88 < np.mean(off < 1.96) < 1.0
