"""Generates and compiles the engine: cyclemap/mechanics/engine becomes one shared library without
Python in it.

The compiler is the first of $CC, cc, gcc and clang that works; where none does, the one of the
package ziglang. Run as a program, with numpy and casadi at hand, it puts the library where a
checkout that is installed editable looks for it.
"""

import ctypes
import importlib.util
import os
import re
import runpy
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ENGINE = ROOT / "cyclemap" / "mechanics" / "engine"
ZIGLANG = "ziglang==0.17.1"
# What other_systems.py needs besides numpy and casadi.
WHEEL_TOOLS = (ZIGLANG, "setuptools>=77.0.3")
# No operation is fused, and none reordered. Compilers, and the mathematical functions of systems,
# still round differently: what two libraries find agrees to 1.1e-14 rad, not to the bit.
FLAGS = (
    *("-O3", "-fPIC", "-shared", "-fvisibility=hidden"),
    *("-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off"),
)
# zig compiles for the processor at hand unless told otherwise.
ZIG = (sys.executable, "-m", "ziglang", "cc", "-mcpu=baseline")
TRIAL = (
    "#include <math.h>\n#include <string.h>\ndouble trial(double x) { return exp(x) + "
    "(double)strlen(ENGINE_VERSION); }"
)

_TERMINAL_ESCAPE = re.compile(
    r"\x1b(?:\[[0-?]*[ -/]*[@-~]|\][^\x07\x1b]*(?:\x07|\x1b\\)|[ -/]*[0-~])"
)
_MOST_LINES, _MOST_COLUMNS = 6, 160
_PATIENCE_SECONDS = 900


class BuildError(SystemExit):
    """The engine cannot be built; the message, which Python prints without a traceback, says why
    and what to do.
    """

    def __init__(self, *lines: str) -> None:
        super().__init__("\n".join(("error: cyclemap's engine cannot be built.", *lines)))


class Refused(Exception):
    """A program did not do what it was run for: how it ended, and all that it said,
    in plain lines."""

    def __init__(self, end: str, said: Sequence[str] = ()) -> None:
        super().__init__("\n".join((end, *said[:_MOST_LINES])))
        self.last_lines = said[-_MOST_LINES:]


def missing_requirements() -> list[str]:
    """Return the package that brings a C compiler, where none works and it is not there."""
    return [] if working_compiler()[0] or importlib.util.find_spec("ziglang") else [ZIGLANG]


def working_compiler() -> tuple[list[str], list[str]]:
    """Return the command of the first C compiler that works, empty where none does, and why those
    before it do not.
    """
    complaints: list[str] = []
    with tempfile.TemporaryDirectory(prefix="cyclemap-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        (folder / "trial.c").write_text(TRIAL, encoding="utf-8")
        for compiler in filter(None, (os.environ.get("CC"), "cc", "gcc", "clang")):
            try:
                command = shlex.split(compiler)
                _compile(command, folder / "trial.c", folder / f"trial{len(complaints)}.so", (), "")
            except (Refused, ValueError) as error:
                complaints.append(f"{compiler}: {error}")
            else:
                return command, complaints
    return [], complaints


def build(place: Path = ENGINE) -> None:
    """Generate and compile the engine and put it into the folder `place`, whole or not at all, else
    BuildError.
    """
    sources = runpy.run_path(str(ENGINE / "library.py"))
    target, version = sources["library_path"](place), sources["digest_of"](ENGINE)
    with tempfile.TemporaryDirectory(prefix="cyclemap-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        generate(folder)
        command, complaints = working_compiler()
        if not command and importlib.util.find_spec("ziglang") is None:
            raise BuildError(
                "No C compiler works:",
                *(f"  {complaint}" for complaint in complaints),
                "  ziglang: not installed",
                "Install a C compiler and the C library's headers (on Debian: gcc and "
                "libc6-dev), name one in CC, or",
                f"`pip install {ZIGLANG}`, which pip does by itself unless it is told "
                "--no-build-isolation.",
            )
        library = folder / "engine"
        try:
            _compile(command or ZIG, ENGINE / "engine.c", library, (folder, ENGINE), version)
        except Refused as error:
            raise BuildError(
                f"{shlex.join(command or ZIG)}: {error}",
                "Mend that, or name another C compiler in CC.",
            ) from error
        place_whole(library.read_bytes(), target)


def generate(folder: Path) -> None:
    """Write the generated sources, in a process of its own, where the engine's modules find each
    other.
    """
    code = (
        f"import sys; sys.path[:0] = {[str(ENGINE), str(ROOT)]!r};import pathlib, generate; "
        f"generate.write_sources(pathlib.Path({str(folder)!r}))"
    )
    try:
        _run([sys.executable, "-B", "-c", code], folder)
    except Refused as error:
        raise BuildError("Its equations cannot be written as C:", *error.last_lines) from error


def compile_for(
    command: Sequence[str],
    flags: Sequence[str],
    source: Path,
    target: Path,
    include: Sequence[Path],
    version: str,
) -> None:
    """Compile one C file into a library; Refused, with what the compiler said,
    where it does not."""
    words = [
        *command,
        *flags,
        *(f"-I{folder}" for folder in include),
        f'-DENGINE_VERSION="{version}"',
    ]
    _run([*words, str(source), "-o", str(target), "-lm"], target.parent)


def _compile(
    command: Sequence[str], source: Path, target: Path, include: Sequence[Path], version: str
) -> None:
    """Compile one C file into a shared library that this Python can load."""
    compile_for(command, FLAGS, source, target, include, version)
    try:
        ctypes.CDLL(str(target))
    except OSError as error:
        raise Refused("what it compiled cannot be loaded here", _plain_lines(str(error))) from error


def _run(command: Sequence[str], folder: Path) -> None:
    """Run a program in `folder`; Refused, with its first words, where it fails."""
    # zig keeps what it made of its own library in a cache: here it leaves nothing behind.
    caches = {f"ZIG_{scope}_CACHE_DIR": str(folder / "zig") for scope in ("GLOBAL", "LOCAL")}
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            env=os.environ | caches,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=_PATIENCE_SECONDS,
            check=False,
        )
    except FileNotFoundError:
        raise Refused("not found") from None
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Refused(str(error)) from error
    if done.returncode:
        raise Refused(
            f"failed with exit code {done.returncode}",
            _plain_lines(done.stdout.decode(errors="replace")),
        )


def _plain_lines(text: str) -> list[str]:
    """What a program said, line by line, without terminal escapes and control characters."""
    lines = _TERMINAL_ESCAPE.sub("", text).expandtabs().splitlines()
    plain = ("".join(filter(str.isprintable, line))[:_MOST_COLUMNS].rstrip() for line in lines)
    return [f"    {line}" for line in plain if line]


def place_whole(content: bytes, target: Path) -> None:
    """Write `target` by way of a file beside it: who reads it meanwhile gets the old or the new."""
    beside = target.with_name(f"{target.name}.{os.getpid()}.part")
    try:
        try:
            beside.write_bytes(content)
            beside.replace(target)
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:
        raise BuildError(
            f"{target} cannot be written: {error.strerror}.",
            "Make its folder writable, or `pip install .`, which leaves the sources alone.",
        ) from error


if __name__ == "__main__":
    try:
        if missing := missing_requirements():
            subprocess.run(
                [sys.executable, "-m", "pip", "install", "--quiet", *missing], check=False
            )
        build()
    except KeyboardInterrupt:
        sys.exit(130)
