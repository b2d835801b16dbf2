"""A seeded sample of the damage that `python -m tests.faults` does at full size."""

import pytest

from tests.faults.__main__ import damaged_files, faults
from tests.faults.kills import kill_and_go_on


@pytest.mark.slow
def test_damaged_files_are_read_or_refused(tmp_path) -> None:
    found = damaged_files(tmp_path, 110, 1)
    assert found["files"] == 110 and faults(found) == {}
    assert found["refused"] > 40 and found["read"] > 15


@pytest.mark.slow
@pytest.mark.parametrize("command", ["simulate", "sweep"])
def test_a_killed_command_goes_on_to_the_same_end(tmp_path, command, capsys) -> None:
    found = kill_and_go_on(command, tmp_path, 1, 1, print)
    assert faults(found) == {} and found["killed"] >= 1, capsys.readouterr().out
