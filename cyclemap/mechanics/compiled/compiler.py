"""The C compiler at hand, or why there is none."""

import os
import shlex
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

# Name of the compiler to use, or `none` for the interpreter.
COMPILER_VARIABLE = "CYCLEMAP_COMPILER"
# Rounding stays as written: no reordering, no fused multiplication and addition, so that interpreter and C agree.
FLAGS = ("-O3", "-fPIC", "-shared", "-fno-math-errno", "-ffp-contract=off", "-w")

_COMMON = ("cc", "gcc", "clang")
_PATIENCE_SECONDS = 120


class NoCompiler(Exception):
    """There is no compiled code to be had; the message tells why."""


@dataclass(frozen=True)
class Compiler:
    """A C compiler: the command that runs it, and what tells it from another one."""

    command: tuple[str, ...]
    identity: str

    def shared_library(self, source: str) -> bytes:
        """Return the shared library compiled from C source; NoCompiler with the first complaint if that fails."""
        with tempfile.TemporaryDirectory(prefix="cyclemap-") as folder:
            (Path(folder) / "kernels.c").write_text(source)
            command = [*self.command, *FLAGS, "kernels.c", "-o", "kernels.so", "-lm"]
            try:
                done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=_PATIENCE_SECONDS)
            except (OSError, subprocess.TimeoutExpired) as error:
                raise NoCompiler(f"{self.command[0]} could not be run: {error}") from error
            if done.returncode != 0:
                complaint = next(iter(done.stderr.strip().splitlines()), f"exit code {done.returncode}")
                raise NoCompiler(f"{self.command[0]} refused the kernels: {complaint}")
            return (Path(folder) / "kernels.so").read_bytes()


def find_compiler() -> Compiler:
    """Return the compiler that CYCLEMAP_COMPILER or CC names, else the common one; NoCompiler tells why there is none.

    CYCLEMAP_COMPILER=none asks for the interpreter.
    """
    named = os.environ.get(COMPILER_VARIABLE) or os.environ.get("CC")
    if named == "none":
        raise NoCompiler(f"{COMPILER_VARIABLE}=none asks for the interpreter")
    try:
        choices = [shlex.split(named)] if named else [[name] for name in _COMMON]
    except ValueError as error:
        raise NoCompiler(f"{named!r} cannot be read as a command ({error}): mend {COMPILER_VARIABLE} or CC") from error
    for words in choices:
        program = shutil.which(words[0]) if words else None
        if program is not None:
            binary = Path(program).resolve()
            stamp = binary.stat()
            return Compiler((program, *words[1:]), f"{binary} {stamp.st_size} {stamp.st_mtime_ns} {words[1:]}")
    sought = named or ", ".join(_COMMON)
    raise NoCompiler(f"no C compiler found ({sought}): install one, or name it in {COMPILER_VARIABLE}")
