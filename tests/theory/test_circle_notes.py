"""The notes on drag, symmetry and passage run as they stand, and the files that they name exist."""

import doctest
import re
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
NOTES = (
    *("moebius-drag", "trailing-leg", "isotropy", "random-leg"),
    *("turned-surface", "half-turn-symmetry", "passage-time"),
)


def note(name):
    return (REPOSITORY / "docs" / "theory" / f"{name}.md").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("name", NOTES)
def test_the_notes_example_gives_what_it_says(name):
    blocks = re.findall(r"^```python\n(.*?)^```", note(name), flags=re.MULTILINE | re.DOTALL)
    assert len(blocks) == 1
    parsed = doctest.DocTestParser().get_doctest(blocks[0], {}, name, f"{name}.md", 0)
    assert len(parsed.examples) >= 3
    outcome = doctest.DocTestRunner().run(parsed)
    assert outcome.failed == 0


@pytest.mark.parametrize("name", NOTES)
def test_the_modules_and_notes_that_a_note_names_exist(name):
    modules = re.findall(r"`(theory/\w+\.py)`", note(name))
    assert modules
    links = re.findall(r"\]\(([\w-]+\.md)\)", note(name))
    for path in (*modules, *(f"docs/theory/{link}" for link in links)):
        assert (REPOSITORY / path).is_file(), path
