"""No stated bound lies below the error: a small version of `python -m tests.bounds`."""

import pytest

from tests.bounds.bound_study import study


@pytest.mark.slow
def test_no_bound_is_below_the_error_on_random_lifts() -> None:
    found = study(24, 7)
    assert found.broken == []
    assert found.judged["moment"] >= 40 and found.judged["density"] >= 20
    assert sum(found.refused.values()) <= 4
