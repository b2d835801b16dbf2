"""Every code block of the site runs and gives what stands beside it; `code_blocks.py` tells the
convention.
"""

import re
from pathlib import Path

import click
import pytest
from code_blocks import DOCS, REPOSITORY, Block, blocks, commands_in, pages, run_block

from cyclemap.cli.main import cli

PAGES = pages()


@pytest.mark.slow
@pytest.mark.parametrize(
    "page", [page for page in PAGES if PAGES[page]], ids=lambda page: str(page.relative_to(DOCS))
)
def test_blocks_of_a_page_run_and_give_what_the_page_says(
    page: Path, tmp_path, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    names = {"__name__": "page"}
    for block in PAGES[page]:
        run_block(block, names, f"{page.relative_to(REPOSITORY)}, line {block.line}")


def test_the_pages_that_teach_by_example_have_examples() -> None:
    """A page whose blocks were not found would pass in silence."""
    taught = [page for page in PAGES if page.match("how-to/*") or page.name == "quick-start.md"]
    few = {page.name for page in taught if len(PAGES[page]) < 2}
    assert len(taught) >= 6 and few <= {"index.md"}


def test_blocks_are_found_with_their_captions_and_reasons() -> None:
    page = (
        "```{toctree}\na\n```\ntext\n```python\n>>> 1\n1\n```\n:::{note}\n```sh\n$ cyclemap "
        "--version\n```\n:::\n"
        "```{code-block} toml\n:caption: a.toml\n\nx = 1\n```\n% not run: it takes "
        "long\n```sh\n$ cyclemap x\n```\n"
    )
    first, second, third, fourth = blocks(page)
    assert (first.kind, second.kind, third.kind, fourth.kind) == ("python", "sh", "toml", "sh")
    assert (third.caption, third.text, fourth.why) == ("a.toml", "x = 1\n", "it takes long")
    assert first.caption is second.caption is first.why is second.why is None


@pytest.mark.parametrize(
    ("kind", "text", "why"),
    [
        ("python", ">>> 1 + 1\n3\n", None),
        ("python", "import no_such_module\n", None),
        ("console", "$ cyclemap no-such-command\n", None),
        ("console", "$ cyclemap --version\nversion twelve\n", None),
        ("console", "cyclemap --version\n", None),
        ("sh", "$ ls\n", None),
        ("toml", "x = = 1\n", None),
        ("console", "$ cyclemap no-such-command\n", "it takes long"),
        ("console", "$ cyclemap cycle plywood --no-such-option 3\n", "it takes long"),
        ("console", "$ python3 run.py no-such-tool\n", "it takes long"),
        ("console", "$ python -m tests.no_such_module\n", "it takes long"),
        ("console", "$ rm -r out\n", "it takes long"),
        ("console", "text\n", "it takes long"),
    ],
)
def test_a_block_fails_that_says_something_wrong_or_names_what_is_not_there(
    kind, text, why, here
) -> None:
    with pytest.raises((AssertionError, ImportError, ValueError, click.NoSuchOption)):
        run_block(Block(kind, text, 1, why=why), {}, "here")


def test_commands_that_pages_name_in_passing_exist() -> None:
    text = " ".join(page.read_text(encoding="utf-8") for page in PAGES)
    named = {*re.findall(r"`cyclemap ([a-z][a-z-]*)", text)}
    assert {"cycle", "portrait", "identify"} <= named | set(cli.commands)
    assert len(named) >= 5
    assert named - set(cli.commands) == set()


def test_commands_are_split_from_what_they_print() -> None:
    text = "$ cyclemap a \\\n  --b\nsaid\nmore\n$ cyclemap c\n"
    found = [(" ".join(command.split()), wanted) for command, wanted in commands_in(text)]
    assert found == [("cyclemap a --b", "said\nmore\n"), ("cyclemap c", "")]
