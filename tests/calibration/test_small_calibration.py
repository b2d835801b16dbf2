"""Every p-value holds its level under its null: a small version of `python -m tests.calibration`."""

import numpy as np
import pytest
from p_value_studies import STUDIES
from rejection_table import HEADER, rejection_rate, row, uniformity

RUNS = 100
# Simulations of each null: what takes a second or two.
QUICK = {"chain": 19, "ghost": 1, "well": 1}


def highest_share(level: float, count: int) -> float:
    """The share of rejections that a calibrated p-value exceeds once in 2000 times."""
    from scipy.stats import binom

    return float(binom.ppf(0.9995, count, level)) / count


@pytest.mark.slow
@pytest.mark.parametrize("name", QUICK)
def test_no_p_value_rejects_the_truth_more_often_than_it_says(name) -> None:
    study, _ = STUDIES[name]
    found = study(RUNS, QUICK[name], 77)
    assert len(found) >= 2
    for test, values in found.items():
        assert values.size > 0.8 * RUNS, test
        for level in (0.05, 0.1, 0.5):
            assert rejection_rate(values, level)[0] <= highest_share(level, values.size), (test, level)
        # Nor hardly ever: half of them lie above one half.
        assert np.mean(values <= 0.5) > 0.25, test


@pytest.mark.slow
def test_p_values_under_wear_hold_their_level() -> None:
    study, _ = STUDIES["wear"]
    found = study(40, 19, 78)
    assert set(found) == {
        f"{name}, wear" for name in ("wasserstein", "total_variation", "kuiper", "watson", "turns", "map")
    }
    for values in found.values():
        assert rejection_rate(values, 0.1)[0] <= highest_share(0.1, values.size)
        assert 0.2 < np.mean(values <= 0.5) < 0.8


def test_a_mean_is_within_its_error_as_often_as_it_says() -> None:
    study, _ = STUDIES["bias"]
    for values in study(RUNS, 1, 79).values():
        assert rejection_rate(values, 0.05)[0] <= highest_share(0.09, RUNS)


def test_the_table_tells_rates_errors_and_what_cannot_be_reached() -> None:
    values = np.arange(1, 40) / 40.0
    line = row("made", values)
    assert len(line) == len(HEADER)
    assert line.split()[:3] == ["made", "39", "-"]
    assert "5.1 ± 3.5 %" in line
    assert uniformity(values) > 0.9
    assert uniformity(values**3) < 0.01
    assert "too little" in row("none", np.empty(0))
