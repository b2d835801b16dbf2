"""The self-check: sound here, sound without a compiler, and not sound where the kernels or the numbers are wrong."""

from dataclasses import replace

import pytest

from cyclemap.collection import kernel_check as module
from cyclemap.collection.kernel_check import KernelCheck, check_kernels

SOUND = KernelCheck("/usr/bin/cc", "", 1e-6, 5e-3, 5e-4, 1e-14)


def test_without_a_compiler_the_check_is_sound_and_tells_why(monkeypatch):
    monkeypatch.setenv("CYCLEMAP_COMPILER", "none")
    found = check_kernels()
    assert found.problems == ()
    assert found.compiler is None and "asks for the interpreter" in found.refusal
    assert found.compiled_seconds is None and found.difference is None
    assert 0.0 < found.error < module.REFERENCE_ERROR and found.interpreted_seconds > 0.0


def test_a_compiler_that_fails_is_a_problem(monkeypatch, tmp_path):
    broken = tmp_path / "broken-cc"
    broken.write_text("#!/bin/sh\necho kernels.c:1: no >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("CYCLEMAP_COMPILER", str(broken))
    monkeypatch.setenv("CYCLEMAP_CACHE", str(tmp_path / "kernels"))
    (problem,) = check_kernels().problems
    assert "refused the kernels: kernels.c:1: no" in problem


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"refusal": "no space"}, "a compiler is at hand, but: no space"),
        ({"error": 1e-3}, "off their reference"),
        ({"error": float("nan")}, "off their reference"),
        ({"difference": 1e-9}, "compiled and interpreted cycles differ"),
    ],
)
def test_what_should_work_and_does_not_is_told(wrong, told):
    assert SOUND.problems == ()
    (problem,) = replace(SOUND, **wrong).problems
    assert told in problem
