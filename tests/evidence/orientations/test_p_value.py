"""Monte Carlo p-values: their definition, and their validity for any number of runs."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.goodness_of_fit import PValue, monte_carlo_p_value


def test_it_counts_the_observed_value_among_the_simulated() -> None:
    found = monte_carlo_p_value(2.5, [1.0, 2.0, 3.0, 4.0])
    assert (found.value, found.runs, found.statistic) == (3 / 5, 4, 2.5)
    assert monte_carlo_p_value(9.0, np.arange(9)).value == 0.1
    assert monte_carlo_p_value(-1.0, np.arange(9)).value == 1.0


def test_values_equal_but_for_rounding_count_as_reached() -> None:
    assert monte_carlo_p_value(0.3, [0.1 + 0.2, 0.3, 0.3 - 1e-16]).value == 1.0


def test_it_is_valid_for_few_runs() -> None:
    """Exchangeable values: P(p ≤ k/(runs + 1)) = k/(runs + 1) exactly."""
    drawn = np.random.default_rng(1).normal(size=(4000, 20))
    values = np.array([monte_carlo_p_value(row[0], row[1:]).value for row in drawn])
    for k in (1, 2, 10):
        assert np.mean(values <= k / 20 + 1e-12) == pytest.approx(k / 20, abs=4 * np.sqrt(k / 20 * (1 - k / 20) / 4000))


def test_its_standard_error_is_that_of_repeated_simulation() -> None:
    random = np.random.default_rng(2)
    repeated = [monte_carlo_p_value(1.0, random.normal(size=200)) for _ in range(1500)]
    spread = np.std([found.value for found in repeated])
    assert np.mean([found.standard_error for found in repeated]) == pytest.approx(spread, rel=0.1)
    assert monte_carlo_p_value(99.0, random.normal(size=200)).standard_error > 0.0


def test_quantiles_are_those_of_the_simulated_values() -> None:
    found = monte_carlo_p_value(0.0, np.arange(101.0))
    assert found.null_quantiles.tolist() == pytest.approx([100 * level for level in PValue.LEVELS])
    assert not found.null_quantiles.flags.writeable


def test_bad_input_is_refused() -> None:
    with pytest.raises(InvalidInput, match="no simulated values"):
        monte_carlo_p_value(1.0, [])
    with pytest.raises(InvalidInput, match="observed must be a finite number"):
        monte_carlo_p_value(np.nan, [1.0])
    with pytest.raises(InvalidInput, match="simulated must be finite"):
        monte_carlo_p_value(1.0, [1.0, np.inf])
