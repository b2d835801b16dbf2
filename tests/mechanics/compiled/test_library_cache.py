"""Kept kernels: found again, shared by processes, passed over where damaged, done without where they must be."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from cyclemap.mechanics.compiled import compiler as module
from cyclemap.mechanics.compiled.compiler import NoCompiler, find_compiler
from cyclemap.mechanics.compiled.library_cache import cache_folder, cached_library

SOURCE = "int answer(void) { return 42; }\n"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty cache; skips where nothing can be compiled."""
    monkeypatch.delenv("CYCLEMAP_COMPILER", raising=False)
    try:
        find_compiler()
    except NoCompiler as reason:
        pytest.skip(f"the cache of compiled kernels is not tested: {reason}")
    monkeypatch.setenv("CYCLEMAP_CACHE", str(tmp_path / "kernels"))
    return tmp_path / "kernels"


def source() -> str:
    return SOURCE


def never() -> str:
    raise AssertionError("compiled again")


def test_a_library_is_compiled_once_and_found_again(folder):
    assert cached_library("one", None) is None
    assert cached_library("one", source).answer() == 42
    assert cached_library("one", never).answer() == 42
    assert cached_library("another", None) is None
    assert len(list(folder.iterdir())) == 1


def test_other_flags_or_another_compiler_have_their_own_library(folder, monkeypatch):
    cached_library("one", source)
    monkeypatch.setenv("CYCLEMAP_COMPILER", f"{find_compiler().command[0]} -g")
    assert cached_library("one", None) is None
    assert cached_library("one", source).answer() == 42
    assert len(list(folder.iterdir())) == 2


@pytest.mark.parametrize("damage", [lambda b: b[: len(b) // 2], lambda b: b"", lambda b: b[:-1] + bytes([b[-1] ^ 1])])
def test_a_damaged_library_is_removed_and_compiled_again(folder, damage):
    # Never loaded in this process, so that nothing stays mapped.
    child = (
        "from cyclemap.mechanics.compiled.library_cache import cached_library\n"
        f"print(cached_library('one', lambda: {SOURCE!r}).answer())"
    )
    subprocess.run([sys.executable, "-c", child], check=True, capture_output=True)
    (path,) = folder.iterdir()
    whole = path.read_bytes()
    path.write_bytes(damage(whole))
    assert cached_library("one", None) is None
    assert list(folder.iterdir()) == []
    assert cached_library("one", source).answer() == 42


def test_processes_at_once_do_not_disturb_each_other(folder):
    child = (
        "from cyclemap.mechanics.compiled.library_cache import cached_library\n"
        f"print(cached_library('one', lambda: {SOURCE!r}).answer())"
    )

    def run(_: int) -> str:
        return subprocess.run([sys.executable, "-c", child], check=True, capture_output=True, text=True).stdout

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(run, range(4))) == ["42\n"] * 4
    assert not [path for path in folder.iterdir() if path.suffix != ".so"]
    assert cached_library("one", never).answer() == 42


def test_a_cache_that_cannot_be_written_says_so(folder, monkeypatch):
    folder.write_text("a file where the folder should be")
    with pytest.raises(NoCompiler, match=r"cannot be kept.*CYCLEMAP_CACHE"):
        cached_library("one", source)


def test_a_compiler_that_refuses_says_why():
    with pytest.raises(NoCompiler, match=r"refused the kernels: kernels\.c"):
        cached_library("one", lambda: "int answer(void) { return }\n")


def test_no_compiler_is_told_apart_from_one_that_is_not_wanted(monkeypatch):
    monkeypatch.setenv("CYCLEMAP_COMPILER", "none")
    with pytest.raises(NoCompiler, match="asks for the interpreter"):
        find_compiler()
    monkeypatch.setenv("CYCLEMAP_COMPILER", "no-such-compiler")
    with pytest.raises(NoCompiler, match="no C compiler found \\(no-such-compiler\\)"):
        find_compiler()


def test_a_compiler_that_hangs_is_given_up(monkeypatch, tmp_path):
    slow = tmp_path / "slow-cc"
    slow.write_text("#!/bin/sh\nsleep 5\n")
    slow.chmod(0o755)
    monkeypatch.setenv("CYCLEMAP_COMPILER", str(slow))
    monkeypatch.setattr(module, "_PATIENCE_SECONDS", 0.2)
    with pytest.raises(NoCompiler, match="could not be run"):
        cached_library("one", source)


def test_the_cache_is_where_it_is_asked_to_be_else_in_the_users_own(monkeypatch, tmp_path):
    assert cache_folder() == tmp_path / "kernels"
    monkeypatch.delenv("CYCLEMAP_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "mine"))
    assert cache_folder() == tmp_path / "mine" / "cyclemap"
