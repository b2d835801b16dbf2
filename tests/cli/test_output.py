"""Files appear whole or not at all; the progress bar keeps out of the way."""

import re
import stat
import sys
import time

import pytest

from cyclemap.cli import output
from cyclemap.cli.json_report import json_text
from cyclemap.cli.output import file_stem, progress_bar, write_json
from cyclemap.whole_files import write_whole


def test_written_file_is_whole_readable_and_alone(tmp_path) -> None:
    path = tmp_path / "new" / "folder" / "picture.png"
    write_whole(path, b"first")
    write_whole(path, b"second")
    assert path.read_bytes() == b"second"
    assert [entry.name for entry in path.parent.iterdir()] == ["picture.png"]
    assert path.stat().st_mode & stat.S_IRUSR


def test_failed_write_leaves_the_old_file_and_no_rest(tmp_path, monkeypatch) -> None:
    path = tmp_path / "report.json"
    write_whole(path, b"old")

    def full_disk(self, target):
        raise OSError("no space left")

    monkeypatch.setattr("pathlib.Path.replace", full_disk)
    with pytest.raises(OSError, match="no space left"):
        write_whole(path, b"new")
    assert path.read_bytes() == b"old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["report.json"]


def test_json_refuses_numbers_that_are_not_finite(tmp_path) -> None:
    with pytest.raises(ValueError, match="JSON"):
        write_json(tmp_path / "x.json", {"value": float("nan")})
    assert json_text({"θ": 1.5}) == '{\n  "θ": 1.5\n}\n'


@pytest.mark.parametrize(("name", "stem"), [("plywood", "plywood"), ("../a b", "a_b"), ("Ω/2", "Ω_2")])
def test_file_stem_is_a_plain_name(name, stem) -> None:
    assert file_stem(name) == stem


class FakeTerminal:
    """Takes what is written to it and says it is a terminal."""

    encoding = "utf-8"

    def __init__(self) -> None:
        self.text = ""

    def write(self, text: str) -> int:
        self.text += text
        return len(text)

    def flush(self) -> None:
        """Nothing is held back."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("patience", "shown"), [(60.0, False), (0.0, True)])
def test_bar_appears_only_once_patience_is_over(monkeypatch, patience, shown) -> None:
    terminal = FakeTerminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(output, "PATIENCE_SECONDS", patience)
    monkeypatch.setenv("TERM", "xterm")
    with progress_bar("cycle map") as report:
        report(0.1)
        wait_until(lambda: terminal.text or not shown)
        report(0.9)
    assert ("cycle map" in terminal.text) is shown


def test_without_a_terminal_long_work_says_a_line_now_and_then(monkeypatch, capsys) -> None:
    """Whether it reports what is done of it, or cannot."""
    monkeypatch.setattr(output, "LINE_SECONDS", 0.01)
    lines: list[str] = []

    def told() -> list[str]:
        lines.extend(capsys.readouterr().err.splitlines())
        return lines

    with progress_bar("cycle \x1b map") as report:
        wait_until(lambda: len(told()) > 2)
        report(0.5)
        wait_until(lambda: "50 %" in told()[-1])
    assert re.fullmatch(r"cycle \\x1b map: \d+ s", lines[0])
    assert re.fullmatch(r"cycle \\x1b map: 50 % done, \d+ s, about \d+ s left", lines[-1])


def test_short_work_says_nothing(capsys) -> None:
    with progress_bar("cycle map") as report:
        report(0.5)
    assert capsys.readouterr().err == ""


def wait_until(condition) -> None:
    deadline = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.005)
