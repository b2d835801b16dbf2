"""The digest of the code changes with every source that numbers come from, Python or C, and with nothing else."""

from pathlib import Path

import pytest

from cyclemap.sweeps import code_version as module

SOURCES = ("mechanics/push.py", "mechanics/engine/steps.c", "maps/lifts/lift.py", "collection/loop.py")
OTHERS = ("mechanics/push.pyc", "mechanics/notes.txt", "views/page.py", "sweeps/sweep_store.py")


@pytest.fixture
def package(tmp_path, monkeypatch) -> Path:
    """A package of a few files."""
    for name in (*SOURCES, *OTHERS, "sweeps/portrait_numbers.py"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(name)
    monkeypatch.setattr(module, "PACKAGE", tmp_path)
    return tmp_path


def digest() -> str:
    return module.code_version.__wrapped__()


@pytest.mark.parametrize("name", [*SOURCES, "sweeps/portrait_numbers.py"])
def test_an_edit_of_a_source_is_another_version(package, name) -> None:
    before = digest()
    (package / name).write_text("changed")
    assert digest() != before
    (package / name).write_text(name)
    assert digest() == before


@pytest.mark.parametrize("name", OTHERS)
def test_an_edit_of_anything_else_is_not(package, name) -> None:
    before = digest()
    (package / name).write_text("changed")
    assert digest() == before


def test_the_engine_that_runs_the_strokes_is_among_the_sources() -> None:
    kinds = {path.suffix for path in module._files(module.PACKAGE / "mechanics")}
    assert kinds == {".py", ".c"}
