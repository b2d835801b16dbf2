"""Compiled kernels for the tests that are about them."""

from pathlib import Path

import pytest

from cyclemap.mechanics.compiled import stroke_runner
from cyclemap.mechanics.compiled.compiler import NoCompiler, find_compiler
from cyclemap.mechanics.compiled.library_cache import CACHE_VARIABLE


@pytest.fixture(scope="session")
def kernel_folder(tmp_path_factory, worker_id) -> Path:
    """A folder of their own for this run, shared by all of its processes."""
    base = tmp_path_factory.getbasetemp()
    return (base if worker_id == "master" else base.parent) / "kernels"


@pytest.fixture(scope="module")
def compiled(kernel_folder):
    """Kernels compiled at once; without a compiler the tests are skipped."""
    try:
        find_compiler()
    except NoCompiler as reason:
        pytest.skip(f"compiled kernels are not tested: {reason}")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(CACHE_VARIABLE, str(kernel_folder))
        patch.setattr(stroke_runner, "WORTHWHILE", 0)
        yield
