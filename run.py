#!/usr/bin/env python3
"""Everything from a fresh checkout, with nothing but Python 3.11 or newer.

    python3 run.py portrait plywood     install what is needed, then run `cyclemap portrait plywood`
    python3 run.py COMMAND ...          the same for any command of cyclemap
    python3 run.py test [PYTEST ...]    install the test tools too, check style, types and tests
    python3 run.py test --quick ...     the same without the tests marked slow: in two minutes
    python3 run.py test --floors ...    the tests on the oldest packages that pyproject.toml allows
    python3 run.py test --newest ...    run the tests on the newest packages there are
    python3 run.py docs [SPHINX ...]    build the documentation into docs/_build/html
    python3 run.py wheels [NAME ...]    the engine for browsers, wheels for all systems, in dist/

The packages of constraints.txt go into the folder .venv beside this file; --floors and --newest
have folders of their own. A folder is made on the first run, brought up to date when
pyproject.toml, constraints.txt or Python changes, and repaired when an earlier run was cut short.
The compiled engine is built anew when its sources change.
"""

from __future__ import annotations

import hashlib
import importlib.util
import json
import os
import runpy
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
STAMP = VENV / "cyclemap-installed.json"
PYTHON = VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
# What pins the versions: the tested set, the floors of pyproject.toml, or nothing.
PINS = "constraints.txt"
ENGINE = ROOT / "cyclemap" / "mechanics" / "engine"
BUILDING = ROOT / "building"
OLDEST = (3, 11)
MEND = "its words are above: mend that and run again"

CHECKS = (["ruff", "format", "--check", "."], ["ruff", "check", "."], ["mypy"])


class InstallError(Exception):
    """The packages could not be installed: the message says what to do."""


def main(arguments: list[str]) -> int:
    """Install what is needed, run what is asked, and return the exit code."""
    if not arguments or arguments[0] in ("-h", "--help"):
        print(__doc__.strip())
        return 0 if arguments else 2
    command, *rest = arguments
    try:
        check_python()
        if command == "test" and rest[:1] in (["--floors"], ["--newest"]):
            move_to(rest.pop(0).removeprefix("--"))
        ensure_installed(testing=command in ("test", "docs"))
        if command == "test":
            return run_tests(rest)
        if command == "wheels":
            return build_wheels(rest)
        return (
            build_docs(rest) if command == "docs" else call([PYTHON, "-m", "cyclemap", *arguments])
        )
    except InstallError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130


def check_python() -> None:
    """Raise InstallError where this Python is too old or cannot make a virtual environment."""
    if sys.version_info < OLDEST:
        found, needed = (".".join(map(str, version[:2])) for version in (sys.version_info, OLDEST))
        raise InstallError(
            f"this is Python {found}; cyclemap needs {needed} or newer: run with a newer python3"
        )
    missing = [name for name in ("venv", "ensurepip") if importlib.util.find_spec(name) is None]
    if missing:
        raise InstallError(
            f"this Python has no module {missing[0]}; install it (on Debian: python3-venv)"
        )


def move_to(pins: str) -> None:
    """Work in the environment of the `floors` or of the `newest` packages instead of the tested
    set.
    """
    global VENV, STAMP, PYTHON, PINS
    place = VENV.with_name(f".venv-{pins}")
    STAMP, PYTHON = place / STAMP.relative_to(VENV), place / PYTHON.relative_to(VENV)
    VENV, PINS = place, pins


def ensure_installed(testing: bool) -> None:
    """Make the environment hold the package, and the test tools if `testing`; do nothing where it
    already does.
    """
    stamp = read_stamp()
    fresh = stamp.get("key") == install_key()
    if fresh and (stamp.get("testing") or not testing) and PYTHON.exists():
        if not (engine_is_built() or build_engine()):
            raise InstallError(f"the engine could not be built; {MEND}")
        return
    testing = testing or bool(stamp.get("testing"))
    check_place()
    print(f"installing cyclemap into {VENV} ...", file=sys.stderr)
    # Without a stamp the last run was cut short: what pip believes to be there may not be whole.
    if not (pip_works() and install(testing, afresh=not stamp)):
        if stamp and pip_works():
            raise InstallError(f"pip could not bring {VENV.name} up to date; {MEND}")
        rebuild()
        if not install(testing):
            raise InstallError(f"pip could not install the packages; {MEND}")
    STAMP.write_text(json.dumps({"key": install_key(), "testing": testing}), encoding="utf-8")


def install_key() -> str:
    """What an installation depends on: the project's metadata, how it is built, the Python, and the
    place.
    """
    files = [
        ROOT / "pyproject.toml",
        ROOT / "setup.py",
        ROOT / "constraints.txt",
        *sorted(BUILDING.glob("*.py")),
    ]
    parts = (*(path.read_bytes() for path in files), sys.version.encode(), os.fsencode(ROOT))
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def read_stamp() -> dict:
    """The stamp of the last finished installation; empty where there is none."""
    try:
        stamp = json.loads(STAMP.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stamp if isinstance(stamp, dict) else {}


def check_place() -> None:
    """Raise InstallError where the folder that packages go into cannot be written."""
    place = VENV if VENV.is_dir() else VENV.parent
    try:
        with tempfile.TemporaryFile(dir=place):
            pass
    except OSError as error:
        raise InstallError(
            f"{place} cannot be written ({error.strerror}): make it writable, or copy the checkout "
            "to a folder of yours and run it there"
        ) from error


def pip_works() -> bool:
    """Whether .venv is there, has this version of Python, and its pip starts."""
    if not PYTHON.exists():
        return False
    question = f"import sys, pip; sys.exit(sys.version_info[:3] != {sys.version_info[:3]})"
    try:
        return (
            subprocess.run([PYTHON, "-c", question], capture_output=True, check=False).returncode
            == 0
        )
    except OSError:
        return False


def rebuild() -> None:
    """Make the environment from nothing."""
    made = subprocess.run(
        [sys.executable, "-m", "venv", "--clear", VENV], stdout=sys.stderr, check=False
    )
    if made.returncode:
        raise InstallError(f"could not make {VENV} (see above); remove that folder and run again")


def install(testing: bool, afresh: bool = False) -> bool:
    """Install the package, editable, and the tools if `testing`, at the pinned versions; whether
    that worked.
    """
    command = [PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    command += ["--force-reinstall"] if afresh else []
    # Python 3.10, which is told to be too old, has no such module.
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    extras = [name for name in project["project"]["optional-dependencies"] if name != "peers"]
    package = f"{ROOT}[{','.join(extras)}]" if testing else ROOT
    tools = (
        [tool for group in project["dependency-groups"].values() for tool in group]
        if testing
        else []
    )
    pins = (ROOT / "constraints.txt").read_text(encoding="utf-8") if PINS != "newest" else ""
    if PINS == "floors":
        floors = dict(one.split(">=") for one in project["project"]["dependencies"])
        kept = [line for line in pins.splitlines() if line.split("==")[0].lower() not in floors]
        pins = "\n".join([*kept, *(f"{name}=={version}" for name, version in floors.items())])
    file = VENV / "constraints.txt"
    file.write_text(pins, encoding="utf-8")
    # By the environment, they hold for what builds the package, too. Standard output belongs to
    # what follows.
    surroundings = {**os.environ, "PIP_CONSTRAINT": str(file), "PIP_BUILD_CONSTRAINT": str(file)}
    made = subprocess.run(
        [*command, "--editable", package, *tools], stdout=sys.stderr, env=surroundings, check=False
    )
    return made.returncode == 0


def engine_is_built() -> bool:
    """Whether the engine's library is there and made from the sources as they are."""
    return runpy.run_path(str(ENGINE / "library.py"))["is_built"](ENGINE)


def build_engine() -> bool:
    """Build the engine's library with what .venv holds, many times faster than an installation;
    whether that worked.
    """
    print("building the engine ...", file=sys.stderr)
    return (
        subprocess.run(
            [PYTHON, BUILDING / "engine_library.py"], stdout=sys.stderr, check=False
        ).returncode
        == 0
    )


def run_tests(arguments: list[str]) -> int:
    """Run every check and then the tests, whose summary comes last; the first exit code that is not
    0.

    Style and types are those of the tested set: other versions of the packages have other type
    stubs, and warn of what they deprecate in each other.
    """
    usual = VENV.name == ".venv"
    codes = [call([PYTHON, "-m", *check], cwd=ROOT) for check in CHECKS if usual]
    formatter = PYTHON.with_name(f"clang-format{PYTHON.suffix}")
    if usual and formatter.exists():
        codes.append(call([formatter, "--dry-run", "-Werror", *sorted(ENGINE.glob("*.c"))]))
    chosen = [] if usual else ["-W", "ignore::DeprecationWarning", "-W", "ignore::FutureWarning"]
    if "--quick" in arguments:
        chosen += ["-m", "not slow"]
    rest = [argument for argument in arguments if argument != "--quick"]
    # The tests of a module share what it prepares: one process runs them all. In their own order
    # the short ones of docstrings come last, so that no process waits long for another.
    shared = ["-n", "auto", "--dist", "loadscope", "--no-loadscope-reorder"]
    codes.append(call([PYTHON, "-m", "pytest", *shared, *chosen, *rest], cwd=ROOT))
    return next((code for code in codes if code), 0)


def build_docs(arguments: list[str]) -> int:
    """Build the documentation, its warnings as errors, and say where it is; the exit code."""
    code = call(
        [
            PYTHON,
            "-m",
            "sphinx",
            "-W",
            "-E",
            "--keep-going",
            "-q",
            *arguments,
            "docs",
            "docs/_build/html",
        ],
        cwd=ROOT,
    )
    if not code:
        print(f"open {ROOT / 'docs' / '_build' / 'html' / 'index.html'}")
    return code


def build_wheels(arguments: list[str]) -> int:
    """Install the compiler for other systems where it is not, and build what is named; the exit
    code.
    """
    needed = [*runpy.run_path(str(BUILDING / "engine_library.py"))["WHEEL_TOOLS"]]
    made = subprocess.run(
        [PYTHON, "-m", "pip", "install", "--quiet", *needed], stdout=sys.stderr, check=False
    )
    if made.returncode:
        raise InstallError(f"pip could not install {', '.join(needed)}; {MEND}")
    return call([PYTHON, BUILDING / "other_systems.py", *arguments])


def call(command: list, cwd: Path | None = None) -> int:
    """Run `command` with this terminal and return its exit code."""
    return subprocess.run(command, cwd=cwd, check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
