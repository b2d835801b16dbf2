"""The engine's build: what it makes, that it is made anew when it must, and what is said where it
cannot be.
"""

import ctypes
import gzip
import importlib.util
import os
import re
import runpy
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest
from refusals import refused

from cyclemap.errors import EngineNotBuilt
from cyclemap.mechanics.engine import library
from cyclemap.mechanics.engine.library import digest_of, is_built, library_path
from cyclemap.mechanics.engine.strokes import LAYOUT

ROOT = Path(__file__).parents[2]
ENGINE = Path("cyclemap") / "mechanics" / "engine"
GENERATOR = """from pathlib import Path

def write_sources(folder: Path) -> None:
    (folder / "kernels.c").write_text("static double kernel(double x) { return 2.0 * x; }")
"""
DRIVER = """#include "kernels.c"
#include "driver.c"
__attribute__((visibility("default"))) const char *cm_version(void) { return ENGINE_VERSION; }
__attribute__((visibility("default"))) double cm_double(double x) { return driver(x); }
"""
# A compiler that fails with colours, a window title, a bell and bytes that are no text.
BROKEN = (
    "#!/bin/sh\nprintf '\\033[1;31mno licence\\033[0m \\377\\033]0;title\\007\\007\\n' "
    ">&2\nexit 7\n"
)

needs_compiler = pytest.mark.skipif(
    not any(map(shutil.which, ("cc", "gcc", "clang")))
    and importlib.util.find_spec("ziglang") is None,
    reason="building is not tested: there is no C compiler",
)
needs_shell = pytest.mark.skipif(os.name == "nt", reason="the broken compiler is a shell script")


@pytest.fixture
def checkout(tmp_path) -> Path:
    """A small copy of this project, whose engine doubles a number."""
    root = tmp_path / "checkout"
    engine = root / ENGINE
    engine.mkdir(parents=True)
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE", "MANIFEST.in"):
        shutil.copy(ROOT / name, root)
    (root / "figures").mkdir()
    (root / "figures" / "__init__.py").touch()
    shutil.copytree(
        ROOT / "building", root / "building", ignore=shutil.ignore_patterns("__pycache__")
    )
    shutil.copy(ROOT / ENGINE / "library.py", engine)
    for folder in (engine, *engine.parents[:2]):
        (folder / "__init__.py").touch()
    (root / "cyclemap" / "__init__.py").write_text('__version__ = "1.2.3"\n')
    (engine / "strokes.py").write_text("# calls the engine\n")
    (engine / "generate.py").write_text(GENERATOR)
    (engine / "engine.c").write_text(DRIVER)
    (engine / "driver.c").write_text("static double driver(double x) { return kernel(x); }\n")
    return root


def called(checkout: Path, code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run Python beside the modules that build, without the compiler that a package may have
    brought.
    """
    hidden = "import sys; sys.modules['ziglang'] = None; " if environment else ""
    return subprocess.run(
        [sys.executable, "-B", "-c", hidden + code],
        cwd=checkout / "building",
        env={name: value for name, value in os.environ.items() if name != "CC"} | environment,
        capture_output=True,
        text=True,
        check=False,
    )


def built(checkout: Path) -> subprocess.CompletedProcess[str]:
    return called(checkout, "import engine_library; engine_library.build()")


def files_of(checkout: Path) -> set[Path]:
    return {path.relative_to(checkout) for path in checkout.rglob("*") if path.is_file()}


@needs_compiler
def test_library_runs_tells_its_sources_is_all_that_is_left_and_is_taken_as_it_is_without_sources(
    checkout,
) -> None:
    """The version is the digest of the sources; without the C files, as in an installed package,
    there is none.
    """
    before, engine = files_of(checkout), checkout / ENGINE
    assert built(checkout).returncode == 0
    loaded = library.open_engine(engine)
    loaded.cm_double.restype, loaded.cm_double.argtypes = ctypes.c_double, [ctypes.c_double]
    assert loaded.cm_double(21.0) == 42.0
    assert loaded.cm_version().decode() == digest_of(engine)
    assert files_of(checkout) - before == {library_path(engine).relative_to(checkout)}
    for path in engine.glob("*.c"):
        path.unlink()
    assert digest_of(engine) is None
    assert len(library.open_engine(engine).cm_version()) == 64
    damaged = engine.rename(checkout / "damaged")
    library_path(damaged).unlink()
    library_path(damaged).write_bytes(b"no library")
    refused(
        library.open_engine,
        damaged,
        told=r"cannot be loaded \(.*\): in a checkout, ",
        kind=EngineNotBuilt,
    )


@pytest.mark.slow
@needs_compiler
def test_changed_source_is_refused_until_it_is_built(checkout) -> None:
    """A library of other sources than those beside it is never used in silence, and one build mends
    that.
    """
    engine = checkout / ENGINE
    told = r"missing: in a checkout, `python3 run\.py doctor` or `pip"
    refused(library.open_engine, engine, told=told, kind=EngineNotBuilt)
    built(checkout)
    (engine / "strokes.py").write_text("# calls it otherwise\n")
    assert is_built(engine)
    told = "not made from the sources beside it"
    for name in ("driver.c", "generate.py"):
        before = (engine / name).read_text()
        (engine / name).write_text(f"{before}\n\n")
        assert not is_built(engine)
        refused(library.open_engine, engine, told=told, kind=EngineNotBuilt)
        (engine / name).write_text(before)
        assert is_built(engine)
    (engine / name).write_text(f"{before}\n\n")
    built(checkout)
    assert library.open_engine(engine).cm_version().decode() == digest_of(engine)


def test_engine_for_browsers_is_made_from_the_sources() -> None:
    """Its version is their digest: after a change, `python3 run.py wheels browser` makes it
    anew."""
    kept = gzip.decompress((ROOT / ENGINE / "engine.wasm.gz").read_bytes())
    assert kept.startswith(b"\0asm")
    assert digest_of(ROOT / ENGINE).encode() in kept, "run `python3 run.py wheels browser`"


def test_a_library_of_another_system_or_without_a_symbol_goes_into_no_wheel(
    tmp_path, monkeypatch
) -> None:
    monkeypatch.syspath_prepend(ROOT / "building")
    building = runpy.run_path(str(ROOT / "building" / "other_systems.py"))
    whole = b"".join(name.encode() for name in building["EXPORTS"])
    library = tmp_path / "library"
    for name, system in building["SYSTEMS"].items():
        library.write_bytes(system.begins + whole)
        building["check"](name, system, library)
        library.write_bytes(b"\x7fELF\x02\x02" + whole)
        with pytest.raises(SystemExit, match="another format"):
            building["check"](name, system, library)
        library.write_bytes(system.begins + whole.replace(b"cm_press", b""))
        with pytest.raises(SystemExit, match="no cm_press"):
            building["check"](name, system, library)
    library.write_bytes(building["SYSTEMS"]["linux-x86_64"].begins + whole + b"\0GLIBC_2.28\0")
    with pytest.raises(SystemExit, match=r"needs glibc 2\.28"):
        building["check"]("linux-x86_64", building["SYSTEMS"]["linux-x86_64"], library)


@pytest.mark.skipif(
    sys.platform != "linux",
    reason="elsewhere the system looks by itself whether a library is whole",
)
def test_library_cut_short_is_refused_wherever_it_ends(tmp_path) -> None:
    """Its digest may still be in it: without a look at its end,
    the first call would kill Python."""
    whole = library_path(ROOT / ENGINE).read_bytes()
    sources = digest_of(ROOT / ENGINE)
    assert sources is not None
    holds_digest = whole.index(sources.encode()) + len(sources)
    cut = library_path(tmp_path)
    for length in (len(whole) - 1, (len(whole) + holds_digest) // 2, holds_digest, 64, 40, 8):
        cut.write_bytes(whole[:length])
        assert not is_built(tmp_path)
        refused(
            library.open_engine,
            tmp_path,
            told=r"is cut short: in a checkout, ",
            kind=EngineNotBuilt,
        )
    cut.write_bytes(whole)
    assert is_built(tmp_path)
    assert library.open_engine(tmp_path).cm_version().decode() == sources


@needs_shell
def test_build_without_a_compiler_says_what_was_tried_and_what_to_do(checkout, tmp_path) -> None:
    """Every compiler with what it said, in plain text, and the way out: no traceback,
    no library."""
    (tmp_path / "cc").write_text(BROKEN)
    (tmp_path / "cc").chmod(0o755)
    done = called(
        checkout,
        "import engine_library; engine_library.build()",
        PATH=str(tmp_path),
        CC="/none/cc -m64",
    )
    lines = done.stderr.splitlines()
    assert done.returncode == 1
    assert lines[:5] == [
        "error: cyclemap's engine cannot be built.",
        "No C compiler works:",
        "  /none/cc -m64: not found",
        "  cc: failed with exit code 7",
        "    no licence \ufffd",
    ]
    assert [line.split(":")[0].strip() for line in lines[5:8]] == ["gcc", "clang", "ziglang"]
    assert "pip install ziglang==" in lines[-1]
    assert len(lines) == 10
    assert not library_path(checkout / ENGINE).exists()


@pytest.mark.slow
@needs_compiler
def test_build_that_fails_leaves_the_library_and_tells_the_place(checkout) -> None:
    """What the compiler says of a mistake is passed on, and so is a mistake in the equations."""
    engine = checkout / ENGINE
    built(checkout)
    before = library_path(engine).read_bytes()
    (engine / "driver.c").write_text("static double driver( {\n")
    done = built(checkout)
    assert done.returncode == 1
    assert re.search(r"driver\.c:1:\d+: .*error", done.stderr)
    (engine / "generate.py").write_text("import no_such_package\n")
    done = built(checkout)
    assert done.returncode == 1
    assert (
        done.stderr.splitlines()[-1].strip()
        == "ModuleNotFoundError: No module named 'no_such_package'"
    )
    assert library_path(engine).read_bytes() == before
    assert len(list(engine.glob("_engine*"))) == 1


@pytest.mark.slow
def test_compiler_is_asked_for_only_where_none_works(checkout, tmp_path) -> None:
    """The hooks ask for a package that brings a compiler, at one version, where the path holds
    none.
    """
    for kind in ("wheel", "editable"):
        asked = f"import setuptools_backend as b; print(*b.get_requires_for_build_{kind}())"
        assert re.fullmatch(
            r"ziglang==[\d.]+\n", called(checkout, asked, PATH=str(tmp_path)).stdout
        )
        if shutil.which("cc"):
            assert called(checkout, asked, CC="/none/cc").stdout == "\n"


@pytest.mark.slow
@needs_compiler
def test_wheel_holds_the_library_for_one_platform_and_every_python_3(checkout, tmp_path) -> None:
    """The wheel has the library and no C, is tagged so, and building it leaves the checkout as it
    was.
    """
    before = files_of(checkout)
    done = called(
        checkout, f"import setuptools_backend as b; print(b.build_wheel({str(tmp_path)!r}))"
    )
    name = done.stdout.splitlines()[-1]
    assert re.fullmatch(r"cyclemap-[\d.]+-py3-none-(?!any)\w+\.whl", name)
    assert files_of(checkout) == before
    with zipfile.ZipFile(tmp_path / name) as wheel:
        names = wheel.namelist()
        meta = next(name for name in names if name.endswith(".dist-info/WHEEL"))
        assert "Root-Is-Purelib: false" in wheel.read(meta).decode()
    assert library_path(ENGINE).as_posix() in names
    assert not [name for name in names if name.endswith(".c") or name.startswith("building")]


@pytest.mark.slow
@needs_compiler
def test_source_distribution_holds_what_a_build_needs_and_no_library(checkout, tmp_path) -> None:
    """C files and backend are in it, a library built before is not."""
    built(checkout)
    called(
        checkout,
        f"import os, setuptools_backend as b; os.chdir('..'); b.build_sdist({str(tmp_path)!r})",
    )
    (path,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(path) as archive:
        names = {path.split("/", 1)[1] for path in archive.getnames() if "/" in path}
    engine = {
        f"{ENGINE.as_posix()}/{name}"
        for name in ("engine.c", "driver.c", "generate.py", "library.py")
    }
    assert names >= engine | {
        "building/engine_library.py",
        "building/setuptools_backend.py",
        "pyproject.toml",
    }
    assert names >= {"setup.py", "figures/__init__.py"}
    assert not [name for name in names if "_engine." in name]


def test_build_and_package_allow_the_same_versions() -> None:
    """The functions are generated by versions of NumPy and CasADi that may run beside them."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    needed = {
        text for text in project["build-system"]["requires"] if not text.startswith("setuptools")
    }
    assert {text.split(">=")[0] for text in needed} == {"numpy", "casadi"}
    assert needed <= set(project["project"]["dependencies"])


def test_python_and_the_library_agree_on_what_they_pass_each_other() -> None:
    """Sizes of structures and rows stand in Python and in C: a row too short would be read beyond
    its end.
    """
    assert tuple((ctypes.c_int64 * len(LAYOUT)).in_dll(library.load(), "cm_layout")) == LAYOUT
