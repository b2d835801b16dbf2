"""A seeded sample of the damage that `python -m tests.faults` does at full size."""

import pytest

from tests.faults.__main__ import damaged_files, faults


@pytest.mark.slow
def test_damaged_files_are_read_or_refused(tmp_path) -> None:
    found = damaged_files(tmp_path, 220, 1)
    assert found["files"] == 220 and faults(found) == {}
    assert found["refused"] > 100 and found["read"] > 30
