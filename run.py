#!/usr/bin/env python3
"""Everything from a fresh checkout, with nothing but Python 3.11 or newer.

    python3 run.py portrait plywood     install what is needed, then run `cyclemap portrait plywood`
    python3 run.py COMMAND ...          the same for any command of cyclemap
    python3 run.py test [PYTEST ...]    install the test tools too, check style and types, run the tests
    python3 run.py docs [SPHINX ...]    build the documentation into docs/_build/html

The packages go into the folder .venv beside this file. It is made on the first run, brought up to date when
pyproject.toml or Python changes, and repaired when an earlier run was cut short. The compiled engine is built anew
when its sources change.
"""

from __future__ import annotations

import hashlib
import importlib.util
import json
import os
import runpy
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
STAMP = VENV / "cyclemap-installed.json"
PYTHON = VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
ENGINE = ROOT / "cyclemap" / "mechanics" / "engine"
BUILDING = ROOT / "building"
OLDEST = (3, 11)
MEND = "its words are above: mend that and run again"

CHECKS = (
    ["ruff", "format", "--check", "."],
    ["ruff", "check", "."],
    ["mypy"],
)


class InstallError(Exception):
    """The packages could not be installed: the message says what to do."""


def main(arguments: list[str]) -> int:
    """Install what is needed, run what is asked, and return the exit code."""
    if not arguments or arguments[0] in ("-h", "--help"):
        print(__doc__.strip())
        return 0 if arguments else 2
    tools = {"test": run_tests, "docs": build_docs}
    try:
        check_python()
        ensure_installed(testing=arguments[0] in tools)
        if arguments[0] in tools:
            return tools[arguments[0]](arguments[1:])
        return call([PYTHON, "-m", "cyclemap", *arguments])
    except InstallError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130


def check_python() -> None:
    """Raise InstallError where this Python is too old or cannot make a virtual environment."""
    if sys.version_info < OLDEST:
        found, needed = (".".join(map(str, version[:2])) for version in (sys.version_info, OLDEST))
        raise InstallError(f"this is Python {found}; cyclemap needs {needed} or newer: run with a newer python3")
    missing = [name for name in ("venv", "ensurepip") if importlib.util.find_spec(name) is None]
    if missing:
        raise InstallError(f"this Python has no module {missing[0]}; install it (on Debian: python3-venv)")


def ensure_installed(testing: bool) -> None:
    """Make .venv hold the package, and the test tools if `testing`; do nothing where it already does."""
    stamp = read_stamp()
    fresh = stamp.get("key") == install_key()
    if fresh and (stamp.get("testing") or not testing) and PYTHON.exists():
        if not (engine_is_built() or build_engine()):
            raise InstallError(f"the engine could not be built; {MEND}")
        return
    testing = testing or bool(stamp.get("testing"))
    print(f"installing cyclemap into {VENV} ...", file=sys.stderr)
    # Without a stamp the last run was cut short: what pip believes to be there may not be whole.
    if not (pip_works() and install(testing, afresh=not stamp)):
        if stamp and pip_works():
            raise InstallError(f"pip could not bring .venv up to date; {MEND}")
        rebuild()
        if not install(testing):
            raise InstallError(f"pip could not install the packages; {MEND}")
    STAMP.write_text(json.dumps({"key": install_key(), "testing": testing}), encoding="utf-8")


def install_key() -> str:
    """What an installation depends on: the project's metadata, how it is built, the Python, and the place."""
    files = [ROOT / "pyproject.toml", *sorted(BUILDING.glob("*.py"))]
    parts = (*(path.read_bytes() for path in files), sys.version.encode(), os.fsencode(ROOT))
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def read_stamp() -> dict:
    """The stamp of the last finished installation; empty where there is none."""
    try:
        stamp = json.loads(STAMP.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stamp if isinstance(stamp, dict) else {}


def pip_works() -> bool:
    """Whether .venv is there, has this version of Python, and its pip starts."""
    if not PYTHON.exists():
        return False
    question = f"import sys, pip; sys.exit(sys.version_info[:3] != {sys.version_info[:3]})"
    try:
        return subprocess.run([PYTHON, "-c", question], capture_output=True, check=False).returncode == 0
    except OSError:
        return False


def rebuild() -> None:
    """Make .venv from nothing."""
    made = subprocess.run([sys.executable, "-m", "venv", "--clear", VENV], stdout=sys.stderr, check=False)
    if made.returncode:
        raise InstallError(f"could not make {VENV} (see above); remove that folder and run again")


def install(testing: bool, afresh: bool = False) -> bool:
    """Install the package, editable, at the versions pyproject.toml pins; whether that worked."""
    command = [PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    command += ["--force-reinstall"] if afresh else []
    command += ["--editable", f"{ROOT}[test]" if testing else str(ROOT)]
    # Standard output belongs to the command that follows.
    return subprocess.run(command, stdout=sys.stderr, check=False).returncode == 0


def engine_is_built() -> bool:
    """Whether the engine's library is there and made from the sources as they are."""
    return runpy.run_path(str(ENGINE / "sources.py"))["is_built"](ENGINE)


def build_engine() -> bool:
    """Build the engine's library with what .venv holds, many times faster than an installation; whether that worked."""
    print("building the engine ...", file=sys.stderr)
    return subprocess.run([PYTHON, BUILDING / "engine_library.py"], stdout=sys.stderr, check=False).returncode == 0


def run_tests(arguments: list[str]) -> int:
    """Run every check and then the tests, whose summary comes last; the first exit code that is not 0."""
    codes = [call([PYTHON, "-m", *check], cwd=ROOT) for check in CHECKS]
    codes.append(call([PYTHON, "-m", "pytest", "-n", "auto", *arguments], cwd=ROOT))
    return next((code for code in codes if code), 0)


def build_docs(arguments: list[str]) -> int:
    """Build the documentation, its warnings as errors, and say where it is; the exit code."""
    code = call(
        [PYTHON, "-m", "sphinx", "-W", "-E", "--keep-going", "-q", *arguments, "docs", "docs/_build/html"], cwd=ROOT
    )
    if not code:
        print(f"open {ROOT / 'docs' / '_build' / 'html' / 'index.html'}")
    return code


def call(command: list, cwd: Path | None = None) -> int:
    """Run `command` with this terminal and return its exit code."""
    return subprocess.run(command, cwd=cwd, check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
