"""The list of planted faults is one of the code as it is: each text stands once in its file, and
changes there.
"""

import ast
from pathlib import Path

import pytest

import cyclemap
from tests.mutants.planted_faults import FAULTS

HOME = Path(cyclemap.__file__).parent


@pytest.mark.parametrize("name", FAULTS)
def test_faults_can_be_planted_and_there_are_tests_to_notice_them(name) -> None:
    tests, faults = FAULTS[name]
    whole = (HOME / name).read_text(encoding="utf-8")
    for text, instead in faults:
        assert whole.count(text) == 1, text
        assert text != instead
        if name.endswith(".py"):
            ast.parse(whole.replace(text, instead))
    root = Path(__file__).resolve().parents[2]
    assert all((root / path).exists() for path in tests.split())


def test_there_are_enough_of_them_and_the_docs_tell_how_many() -> None:
    count = sum(len(faults) for _, faults in FAULTS.values())
    assert count >= 150
    root = Path(__file__).resolve().parents[2]
    assert f"plants {count} faults" in (root / "docs/accuracy.md").read_text(encoding="utf-8")
