"""The engine for other systems, all by one compiler on one machine: WebAssembly for the browser,
and wheels.

    python3 run.py wheels              the engine for browsers, a wheel for every system, into dist/
    python3 run.py wheels NAME ...     those named: browser, linux-x86_64, macos-arm64, ...

Each library is checked for its format and for what it exports; a wheel of this system is run, and
so is the engine of one for which an emulator is installed (qemu-aarch64, qemu-x86_64).
"""

import gzip
import platform
import re
import runpy
import shutil
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import dataclass
from pathlib import Path

from engine_library import (
    ENGINE,
    FLAGS,
    ROOT,
    ZIG,
    BuildError,
    Refused,
    compile_for,
    generate,
    place_whole,
)
from setuptools_backend import copy_sources

EXPORTS = (
    "cm_run",
    "cm_record",
    "cm_friction",
    "cm_balance",
    "cm_press",
    "cm_layout",
    "cm_version",
)
WASM = ENGINE / "engine.wasm.gz"
# Browsers call no function of a system; what is not exported is left out.
_WASM_EXPORTS = ("cm_run", "cm_record", "cm_balance", "cm_layout", "cm_version", "__heap_base")
_WASM_FLAGS = (
    *(
        "-target",
        "wasm32-wasi",
        "-mexec-model=reactor",
        "-msimd128",
        "-s",
        "-Wl,-z,stack-size=1048576",
    ),
    *(f"-Wl,--export={name}" for name in _WASM_EXPORTS),
    *(flag for flag in FLAGS if flag not in ("-shared", "-fPIC")),
)


@dataclass(frozen=True)
class System:
    """A system that a wheel is for: what zig calls it, the wheel's tag, the library's name and how
    it begins.

    machine : what an emulator of it is called; empty where there is none.
    """

    target: str
    tag: str
    library: str
    begins: bytes
    machine: str = ""


_ELF_X86, _ELF_ARM = (
    b"\x7fELF\x02\x01\x01" + bytes(9) + b"\x03\x00" + machine
    for machine in (b"\x3e\x00", b"\xb7\x00")
)
_MACHO_X86, _MACHO_ARM = b"\xcf\xfa\xed\xfe\x07\x00\x00\x01", b"\xcf\xfa\xed\xfe\x0c\x00\x00\x01"
SYSTEMS = {
    "linux-x86_64": System(
        "x86_64-linux-gnu.2.17", "manylinux_2_17_x86_64", "_engine.so", _ELF_X86, "x86_64"
    ),
    "linux-aarch64": System(
        "aarch64-linux-gnu.2.17", "manylinux_2_17_aarch64", "_engine.so", _ELF_ARM, "aarch64"
    ),
    "musl-x86_64": System(
        "x86_64-linux-musl", "musllinux_1_2_x86_64", "_engine.so", _ELF_X86, "x86_64"
    ),
    "musl-aarch64": System(
        "aarch64-linux-musl", "musllinux_1_2_aarch64", "_engine.so", _ELF_ARM, "aarch64"
    ),
    "macos-x86_64": System("x86_64-macos.11.0", "macosx_11_0_x86_64", "_engine.dylib", _MACHO_X86),
    "macos-arm64": System("aarch64-macos.11.0", "macosx_11_0_arm64", "_engine.dylib", _MACHO_ARM),
    "windows-x86_64": System("x86_64-windows-gnu", "win_amd64", "_engine.dll", b"MZ"),
}


def main(names: list[str]) -> int:
    """Build what is named, else all; the exit code."""
    unknown = [name for name in names if name not in ("browser", *SYSTEMS)]
    if unknown:
        print(f"error: {unknown[0]!r} is none of: browser, {', '.join(SYSTEMS)}", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory(prefix="cyclemap-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        generate(folder)
        for name in names or ("browser", *SYSTEMS):
            if name == "browser":
                print(renew_wasm(wasm(folder)))
            else:
                print(wheel(name, SYSTEMS[name], folder))
    return 0


def wasm(folder: Path) -> bytes:
    """Compile the engine, whose generated sources lie in `folder`, to WebAssembly."""
    target = folder / "engine.wasm"
    _compiled(_WASM_FLAGS, folder, target)
    return target.read_bytes()


def renew_wasm(made: bytes) -> str:
    """Keep the engine for browsers beside its sources, untouched where it is the same; which it
    was, in a line.
    """
    kept = gzip.decompress(WASM.read_bytes()) if WASM.exists() else b""
    if made != kept:
        place_whole(gzip.compress(made, 9, mtime=0), WASM)
    told = "as it was, to the byte" if made == kept else "made anew: commit it"
    return f"{WASM.relative_to(ROOT)}: {WASM.stat().st_size / 1e3:.0f} kB, {told}"


def wheel(name: str, system: System, folder: Path) -> str:
    """Compile the engine for a system, check it, and put a wheel into dist/; what became of it, in
    a line.
    """
    library = folder / name / system.library
    library.parent.mkdir()
    _compiled(("-target", system.target, "-s", *FLAGS), folder, library)
    check(name, system, library)
    sources = library.parent / "sources"
    copy_sources(sources)
    shutil.copyfile(library, sources / ENGINE.relative_to(ROOT) / system.library)
    dist = ROOT / "dist"
    dist.mkdir(exist_ok=True)
    made = pack(sources, dist, system.tag)
    is_here = name == here()
    ran = (
        run_wheel(made, library.parent / "unpacked")
        if is_here
        else run_engine(system, folder, library.parent)
    )
    return f"dist/{made.name}: {made.stat().st_size / 1e3:.0f} kB, {ran}"


def pack(sources: Path, dist: Path, tag: str) -> Path:
    """Build a wheel of sources with the library beside them; where it is."""
    code = (
        f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r}); from setuptools import "
        f"build_meta;print(build_meta.build_wheel({str(dist)!r}, {{'--build-option': "
        f"['--plat-name', {tag!r}]}}))"
    )
    words = [sys.executable, "-c", code]
    done = subprocess.run(
        words, cwd=sources, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    if done.returncode:
        raise BuildError(f"setuptools cannot make a wheel for {tag}:", done.stdout[-2000:])
    return dist / done.stdout.split()[-1]


def here() -> str:
    """The name of the system that this is, where a wheel is for it."""
    kind = {"win32": "windows", "darwin": "macos"}.get(sys.platform, "linux")
    return f"{kind}-{platform.machine().lower().replace('amd64', 'x86_64')}"


def run_wheel(made: Path, folder: Path) -> str:
    """Run a published cycle by a wheel of this system, from where it is unpacked."""
    with zipfile.ZipFile(made) as archive:
        archive.extractall(folder)
    done = subprocess.run([sys.executable, "-c", _CYCLE, str(folder)], check=False)
    if done.returncode:
        raise BuildError(f"{made.name} does not run: see above.")
    return "its cycles run"


# Where a cycle of MIT's loop on plywood ends, by an independent solver.
_CYCLE = """
import math, sys
# A checkout that is installed editable would come first.
sys.meta_path = [finder for finder in sys.meta_path if "editable" not in str(finder)]
sys.path.insert(0, sys.argv[1])
import cyclemap
assert cyclemap.__file__.startswith(sys.argv[1]), cyclemap.__file__
cycle = cyclemap.CollectionLoop.mit().cycle(0.0)
assert abs(math.degrees(cycle.theta_next) - (73.65314 - 63.68794)) < 1e-4, cycle.theta_next
"""


def check(name: str, system: System, library: Path) -> None:
    """Raise BuildError where a library is not of its system, or does not export all that Python
    calls.
    """
    content = library.read_bytes()
    missing = [symbol for symbol in EXPORTS if symbol.encode() not in content]
    if not content.startswith(system.begins) or missing:
        raise BuildError(
            f"What was compiled for {name} has another format, or no {', '.join(missing)}."
        )
    newest = max(
        (
            tuple(map(int, version.split(b".")))
            for version in re.findall(rb"GLIBC_([\d.]+)", content)
        ),
        default=(),
    )
    if newest > (2, 17):
        raise BuildError(f"What was compiled for {name} needs glibc {'.'.join(map(str, newest))}.")


def run_engine(system: System, folder: Path, place: Path) -> str:
    """Run the engine in a small program of another system, by an emulator where that takes one;
    what came of it.
    """
    is_machine = sys.platform == "linux" and platform.machine() == system.machine
    emulator = None if is_machine or not system.machine else shutil.which(f"qemu-{system.machine}")
    if not (is_machine or emulator):
        return "not run: no such machine and no emulator of it here"
    source, program = folder / "trial.c", place / "trial"
    source.write_text(_TRIAL, encoding="utf-8")
    try:
        flags = ("-target", f"{system.machine}-linux-musl", "-static", "-O2")
        compile_for(ZIG, flags, source, program, (folder, ENGINE), "trial")
        subprocess.run([emulator, program] if emulator else [program], check=True)
    except (Refused, subprocess.CalledProcessError) as error:
        raise BuildError(f"The engine for {system.target} does not run: {error}") from error
    return f"run by {Path(emulator).name}" if emulator else "the engine runs"


# The engine itself, in a program without a system's libraries, which an emulator need not have.
_TRIAL = """#include "engine.c"
int main(void) {
    return cm_layout[2] == sizeof(Loop) && strcmp(cm_version(), "trial") == 0 ? 0 : 1;
}
"""


def _compiled(flags: tuple[str, ...], folder: Path, target: Path) -> None:
    version = runpy.run_path(str(ENGINE / "library.py"))["digest_of"](ENGINE)
    try:
        compile_for(ZIG, flags, ENGINE / "engine.c", target, (folder, ENGINE), version)
    except Refused as error:
        raise BuildError(f"zig cannot compile it: {error}") from error


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
