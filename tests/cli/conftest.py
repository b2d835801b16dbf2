"""What the tests of commands share: how a refusal looks, and what a command that draws leaves behind."""

from collections.abc import Callable
from pathlib import Path

import pytest

from cyclemap.cli.main import run


@pytest.fixture
def refused(here, capsys) -> Callable[..., None]:
    """Run what is refused: one line with these words and the exit code, nothing on stdout, nothing written."""

    def check(arguments: list[str], words: str, code: int = 2) -> None:
        before = sorted(here.rglob("*"))
        capsys.readouterr()
        assert run(arguments) == code
        shown = capsys.readouterr()
        assert shown.out == ""
        assert shown.err.startswith("error: ") and shown.err.count("\n") == 1
        assert words in shown.err
        assert sorted(here.rglob("*")) == before

    return check


@pytest.fixture(scope="session")
def assert_written() -> Callable[[Path, str, str], None]:
    """A folder holds the picture and the JSON that was printed, under this name, and nothing else."""

    def check(folder: Path, stem: str, text: str) -> None:
        written = {path.name: path.read_bytes() for path in folder.iterdir()}
        assert set(written) == {f"{stem}.png", f"{stem}.json"}
        assert written[f"{stem}.png"].startswith(b"\x89PNG")
        assert written[f"{stem}.json"].decode() == text

    return check
