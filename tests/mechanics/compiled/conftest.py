"""Compiled kernels for the tests that are about them."""

import pytest

from cyclemap.mechanics.compiled import stroke_runner
from cyclemap.mechanics.compiled.compiler import NoCompiler, find_compiler


@pytest.fixture(scope="module")
def compiled():
    """Kernels compiled at once; without a compiler the tests are skipped."""
    try:
        find_compiler()
    except NoCompiler as reason:
        pytest.skip(f"compiled kernels are not tested: {reason}")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stroke_runner, "WORTHWHILE", 0)
        yield
