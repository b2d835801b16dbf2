"""Fixtures that several rooms' tests share."""

import json
import math
import os
import shlex
import signal
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import hypothesis
import pytest

# As the command line does, and before numpy is imported: threads would only get in each other's
# way.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

REPOSITORY = Path(__file__).parents[1]

# The same examples in every run; `--hypothesis-profile=search` looks at others.
hypothesis.settings.register_profile("seeded", derandomize=True, deadline=None)
hypothesis.settings.register_profile("search", deadline=None)
hypothesis.settings.load_profile("seeded")

# What a shell starts in the background ignores interrupts, and so would all that it starts: some
# tests send them.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def measured_data() -> Path:
    """The folder of measured data: $CYCLEMAP_DATA, or ../shared/data beside the repository."""
    folder = Path(os.environ.get("CYCLEMAP_DATA", REPOSITORY.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(
            f"measured data not found: {folder} is no folder (set CYCLEMAP_DATA to where it is)"
        )
    return folder


@pytest.fixture(autouse=True)
def _silent_progress(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands say every few seconds that they go on: on a busy machine, that is no part of what
    they answer.
    """
    if request.path.parent.name in ("cli", "docs"):
        monkeypatch.setattr("cyclemap.cli.output.LINE_SECONDS", 3600.0)


@dataclass(frozen=True)
class StubLoop:
    """A loop whose cycle map is given outright, while all else is the real loop's."""

    real: Any
    given: Any

    def __getattr__(self, name: str) -> Any:
        return getattr(self.real, name)

    def circle_map(self, tolerance: float = 1e-6, progress: Any = None) -> Any:
        if progress is not None:
            progress(0.5)
            progress(1.0)
        return self.given


@pytest.fixture(scope="session")
def real_loop():
    """The MIT loop on plywood."""
    from cyclemap.collection.loop import CollectionLoop

    return CollectionLoop.mit(material="plywood")


@pytest.fixture(scope="session")
def loop_of(real_loop):
    """Make a loop that has a given cycle map."""
    return partial(StubLoop, real_loop)


@pytest.fixture
def here(tmp_path, monkeypatch) -> Path:
    """An empty current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def said(capsys) -> Callable[..., Any]:
    """Run a command line as it is typed, ending with an exit code, and return what it says."""
    from cyclemap.cli.main import run

    def read(line: str, code: int = 0) -> Any:
        capsys.readouterr()
        ended = run(shlex.split(line))
        shown = capsys.readouterr()
        assert ended == code, shown.err
        return shown

    return read


@pytest.fixture
def report_of(said) -> Callable[..., dict]:
    """The report of a command, without NaN or infinity; it says nothing else, unless it may."""

    def read(line: str, silent: bool = True) -> dict:
        shown = said(f"{line} --json -")
        assert not (silent and shown.err)
        return report_in(shown.out)

    return read


def report_in(text: str) -> dict:
    """A report from its text, which holds no NaN or infinity."""
    return json.loads(text, parse_constant=lambda name: pytest.fail(f"JSON holds {name}"))


@pytest.fixture
def saved_report(here, said) -> Callable[..., dict]:
    """The report of a command that writes what it prints to `place`, beside a picture, and nothing
    else there.
    """

    def read(place: str, line: str) -> dict:
        shown, path = said(f"{line} --json -"), here / place
        written = {file.name: file.read_bytes() for file in path.parent.iterdir()}
        assert set(written) == {f"{path.name}.png", f"{path.name}.json"}
        assert written[f"{path.name}.png"].startswith(b"\x89PNG")
        assert (shown.err, shown.out.encode()) == ("", written[f"{path.name}.json"])
        return report_in(shown.out)

    return read


@pytest.fixture(scope="session")
def theta0_file() -> Callable[[Path, Iterable[float]], Path]:
    """Write orientations (rad) as a table of θ0 in degrees."""

    def write(file: Path, theta: Iterable[float]) -> Path:
        file.write_text(
            "theta0_deg\n" + "".join(f"{math.degrees(one) % 360:.4f}\n" for one in theta)
        )
        return file

    return write


@pytest.fixture(scope="session")
def sine_path() -> Callable[[float, int], list[float]]:
    """A noisy path of the sine map with a slow zone: its orientations, rad."""
    from cyclemap.maps import CircleMap, WrappedNormal, sample_staircase

    def sample(sigma: float, cycles: int) -> list[float]:
        path = sample_staircase(CircleMap.arnold(0.11, 0.6), WrappedNormal(sigma), cycles, seed=1)
        return path.theta.tolist()

    return sample


@pytest.fixture
def protocol_file(tmp_path) -> Callable[[str], Path]:
    """Write a text as a protocol file."""

    def write(text: str) -> Path:
        path = tmp_path / "protocol.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def refused(here, said) -> Callable[..., None]:
    """Run a command that is refused: one line with these words, the exit code, nothing on stdout,
    nothing written.
    """

    def check(line: str, words: str, code: int = 2) -> None:
        before = sorted(here.rglob("*"))
        shown = said(line, code)
        assert shown.out == ""
        assert shown.err.startswith("error: ") and shown.err.count("\n") == 1
        assert words in shown.err
        assert sorted(here.rglob("*")) == before

    return check
