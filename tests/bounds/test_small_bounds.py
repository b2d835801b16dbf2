"""No stated bound lies below the error: a small version of `python -m tests.bounds`."""

import pytest

from tests.bounds.bound_study import study
from tests.bounds.family_study import study_families


@pytest.mark.slow
def test_no_bound_is_below_the_error_on_random_lifts() -> None:
    found = study(12, 7)
    assert found.broken == []
    assert found.judged["moment"] >= 20 and found.judged["density"] >= 10
    assert sum(found.refused.values()) <= 2


@pytest.mark.slow
def test_no_bound_is_below_the_error_on_random_families() -> None:
    """Of bifurcations, curves of them, and their points of codimension two."""
    found = study_families(12, 5)
    assert found.broken == []
    assert found.judged["saddle-node"] >= 30 and found.judged["border-collision"] >= 9
    assert found.judged["curve of saddle-node"] >= 12 and found.judged["cusp"] >= 2
    assert found.judged["period-doubling"] >= 4 and found.judged["border saddle-node"] >= 6
    assert sum(found.refused.values()) <= 2
