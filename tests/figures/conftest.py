"""The small result of an exhibit, computed once for all tests of a file."""

import pytest
from figure_cases import small


@pytest.fixture(scope="module")
def result(request):
    """Of the exhibit that the file calls its `NAME`, without measured data."""
    return small(request.module.NAME)
