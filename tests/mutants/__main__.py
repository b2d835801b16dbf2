"""Plant faults one by one in a scratch copy, and see which die:
`python -m tests.mutants [PATH ...] [--seconds N]`.

A fault dies where a test of its own room fails. Each is told as it comes, with the text that took
the place of the right one, and at the end the score.
PATH : files under cyclemap, or how their names begin; all without.
"""

import argparse
import importlib
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest

from tests.mutants.planted_faults import FAULTS

ROOT = Path(__file__).resolve().parents[2]
COPIED = ("cyclemap", "tests", "figures", "theory", "building", "docs")
COPIED_FILES = ("pyproject.toml", "setup.py", "README.md", "run.py", "CHANGELOG.md", "MANIFEST.in")
COPIED_FILES += ("LICENSE", "CITATION.cff", "CONTRIBUTING.md", "constraints.txt")
# Imported once, before the forks; nothing of the project is.
LIBRARIES = ("numpy", "scipy.stats", "scipy.optimize", "scipy.interpolate", "scipy.linalg")
LIBRARIES += ("scipy.special", "scipy.sparse.linalg", "pandas", "matplotlib.figure", "click")
LIBRARIES += ("rich.console", "rich.table", "sympy")
LAST_LINES = 30  # of what pytest says where it fails with nothing planted
DIED, LIVED, LATE = "died", "lived", "took too long"


def scratch_copy(folder: Path) -> None:
    """What tests need of the project, where faults may be planted."""
    for name in COPIED:
        if (ROOT / name).is_dir():
            shutil.copytree(
                ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__", "_build")
            )
    for name in COPIED_FILES:
        shutil.copy(ROOT / name, folder / name)


def build(folder: Path) -> bool:
    """Compile the engine of the copy; whether it can be."""
    words = [sys.executable, "building/engine_library.py"]
    return subprocess.run(words, cwd=folder, capture_output=True, check=False).returncode == 0


def said_in(folder: Path) -> Path:
    """The file beside the copy with what the last tests said."""
    return folder.with_suffix(".txt")


def check_soundness(folder: Path, tests: set[str], seconds: int) -> None:
    """Run each test once with nothing planted, for one that fails then notices no fault."""
    for path in sorted(tests):
        if any(path.startswith(f"{other}/") for other in tests):
            continue  # goes with its folder
        ended = outcome(folder, path, seconds)
        if ended != LIVED:
            lines = said_in(folder).read_text(encoding="utf-8").splitlines()[-LAST_LINES:]
            problem = "takes too long" if ended == LATE else "fails"
            raise SystemExit("\n".join([*lines, f"{path}: {problem} with nothing planted"]))


def run_tests(folder: Path, words: list[str], seconds: int) -> int | None:
    """The exit code of pytest in the copy, in a fork that has its libraries already; None where it
    takes too long.
    """
    child = os.fork()
    if child == 0:
        # Of the processor: a busy machine makes nothing late.
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
        os.chdir(folder)
        os.environ["PYTHONPATH"] = str(folder)
        sys.dont_write_bytecode = True
        sys.path.insert(0, str(folder))
        for name in [name for name in sys.modules if name.partition(".")[0] == "tests"]:
            del sys.modules[name]
        said = os.open(said_in(folder), os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(said, 1)
        os.dup2(said, 2)
        code = 1
        try:
            code = int(pytest.main(words))
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(code)  # what the parent would clean up is not the child's
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return None if code == -signal.SIGXCPU else code


def outcome(folder: Path, tests: str, seconds: int) -> str:
    """How the tests take what is in the copy: the quick ones, then the slow."""
    for kind in ("not slow", "slow"):
        code = run_tests(
            folder, ["-q", "-x", "-p", "no:cacheprovider", "-m", kind, *tests.split()], seconds
        )
        if code is None:
            return LATE
        # 5: there is no test of that kind.
        if code not in (0, 5):
            return DIED
    return LIVED


def planted(folder: Path, name: str, fault: tuple[str, str], tests: str, seconds: int) -> str:
    """What becomes of one fault; the copy is left as it was."""
    path = folder / "cyclemap" / name
    whole, (text, instead) = path.read_text(encoding="utf-8"), fault
    if whole.count(text) != 1:
        raise SystemExit(
            f"{name}: {whole.count(text)} times {text!r}: a fault's text must stand there once"
        )
    path.write_text(whole.replace(text, instead), encoding="utf-8")
    try:
        if path.suffix == ".c" and not build(folder):
            raise SystemExit(f"{name}: {instead!r} does not compile")
        return outcome(folder, tests, seconds)
    finally:
        path.write_text(whole, encoding="utf-8")
        if path.suffix == ".c":
            build(folder)


def main() -> int:
    """Plant what is asked for; 1 where more than one in twenty lives."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("paths", nargs="*")
    parser.add_argument(
        "--seconds", type=int, default=300, help="most processor time of a test run"
    )
    asked = parser.parse_args()
    chosen = {name: FAULTS[name] for name in FAULTS if name.startswith(tuple(asked.paths or [""]))}
    counted = Counter[str]()
    for library in LIBRARIES:
        importlib.import_module(library)
    os.environ.setdefault("CYCLEMAP_DATA", str(ROOT.parent / "shared" / "data"))
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "project"
        scratch_copy(folder)
        all_tests = {path for tests, _ in chosen.values() for path in tests.split()}
        check_soundness(folder, all_tests, asked.seconds)
        for name, (tests, faults) in chosen.items():
            for fault in faults:
                begun = time.monotonic()
                ended = planted(folder, name, fault, tests, asked.seconds)
                counted[ended] += 1
                print(f"{ended}, {time.monotonic() - begun:.0f} s: {name}: {fault[1]}", flush=True)
    total = sum(counted.values())
    print(f"{counted[DIED]} of {total} died ({counted[DIED] / total:.1%}); {dict(counted)}")
    return 0 if counted[DIED] >= 0.95 * total else 1


if __name__ == "__main__":
    sys.exit(main())
