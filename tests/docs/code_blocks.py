"""The code blocks of a page, and how each kind is run.

Blocks of one page run in order, in one temporary folder and with one set of Python names:

```` ```python ```` or ```` ```pycon ````: with `>>>` a doctest; without, a program that must run.
```` ```console ```` or ```` ```sh ````: each line `$ cyclemap ...` is run in this process and must
succeed; what follows it, up to the next `$`, must be what is printed, `...` standing for anything.
```` ```toml ````: parsed. ```` ```text ````: shown. Both, with a caption, are written to the file
that the caption names, for the blocks after them.

A block of another kind is an error. One is left out only with a reason, `% not run: why` on the
line before the fence; what it names must then be there: commands with their options, modules, tools
of run.py.
"""

import contextlib
import doctest
import io
import re
import shlex
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.main import cli, run

REPOSITORY = Path(__file__).parents[2]
DOCS = REPOSITORY / "docs"
FENCE = re.compile(
    r"^(?P<indent> *)(?P<ticks>`{3,}|:{3,})(?P<braced>\{code-block\} ?)?(?P<kind>[\w{}-]*) "
    r"*(?P<rest>.*)$"
)
REASON = re.compile(r"^% not run: (?P<why>\S.*)$")
PYTHON, COMMANDS, FILES = {"python", "pycon"}, {"console", "sh"}, {"toml", "text"}
RUN_TOOLS = {"test", "docs", "wheels"}
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@dataclass(frozen=True)
class Block:
    """kind : the fence's first word.
    text : what stands in it.
    line : where it begins.
    why : it is not run, or None.
    """

    kind: str
    text: str
    line: int
    caption: str | None = None
    why: str | None = None


def pages() -> dict[Path, list[Block]]:
    """Every Markdown page of the site, with its code."""
    found = [path for path in sorted(DOCS.rglob("*.md")) if "_build" not in path.parts]
    return {path: list(blocks(path.read_text(encoding="utf-8"))) for path in found}


def blocks(text: str) -> Iterator[Block]:
    """The code blocks of a page, also those inside `:::` directives; a directive in backticks holds
    no code.
    """
    lines = text.splitlines()
    number = 0
    while number < len(lines):
        fence = FENCE.match(lines[number])
        if not fence or fence["ticks"][0] == ":":
            number += 1
            continue
        ends = (
            i
            for i, line in enumerate(lines)
            if i > number and line.rstrip() == fence["indent"] + fence["ticks"]
        )
        end = next(ends, len(lines))
        if not fence["kind"].startswith("{"):
            why, caption = REASON.match(lines[number - 1]) if number else None, None
            body, kind = lines[number + 1 : end], fence["kind"] or fence["rest"].strip()
            while body and re.match(r"^:\w+:", body[0].strip()):
                option = body.pop(0).strip()
                if option.startswith(":caption:"):
                    caption = option.removeprefix(":caption:").strip().strip("`")
            text = "\n".join(row[len(fence["indent"]) :] for row in body).strip("\n") + "\n"
            yield Block(kind, text, number + 1, caption, why and why["why"])
        number = end + 1


def run_block(block: Block, names: dict[str, Any], place: str) -> None:
    """Run a block in the current folder, with Python's names; AssertionError tells the place and
    what went wrong.
    """
    if block.why is not None:
        check_named(block, place)
    elif block.kind in PYTHON:
        run_python(block, names, place)
    elif block.kind in COMMANDS:
        run_commands(block, place)
    else:
        assert block.kind in FILES, f"{place}: a block of unknown kind {block.kind!r}"
        if block.kind == "toml":
            tomllib.loads(block.text)
        if block.caption:
            path = Path(block.caption)
            assert not path.is_absolute() and ".." not in path.parts, (
                f"a caption {block.caption!r} outside the folder"
            )
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text, encoding="utf-8")


def run_python(block: Block, names: dict[str, Any], place: str) -> None:
    """A doctest, or a program whose output does not matter."""
    if ">>>" not in block.text:
        with contextlib.redirect_stdout(io.StringIO()):
            exec(compile(block.text, place, "exec"), names)
        return
    test = doctest.DocTestParser().get_doctest(block.text, names, place, place, block.line)
    assert test.examples, f"{place}: no example"
    words = io.StringIO()
    outcome = doctest.DocTestRunner(optionflags=FLAGS, verbose=False).run(
        test, out=words.write, clear_globs=False
    )
    names.update(test.globs)
    assert outcome.failed == 0, f"{place}\n{words.getvalue()}"


def run_commands(block: Block, place: str) -> None:
    """Each command must succeed, and print what stands after it."""
    commands = list(commands_in(block.text))
    assert commands, f"{place}: no line `$ cyclemap ...`"
    for command, wanted in commands:
        words = shlex.split(command, comments=True)
        assert words[0] == "cyclemap", f"{place}: {command!r} is no command of cyclemap"
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            code = run(words[1:])
        assert code == 0, f"{place}: {command!r} ended with {code}:\n{printed.getvalue()}"
        said = printed.getvalue()
        agrees = not wanted or doctest.OutputChecker().check_output(wanted, said, FLAGS)
        assert agrees, f"{place}: {command!r} printed\n{said}\nand not\n{wanted}"


def commands_in(text: str) -> Iterator[tuple[str, str]]:
    """Pairs of a command and what is said to be printed; a backslash at a line's end goes on with
    the command.
    """
    for part in re.split(r"^\$ ", text.replace("\\\n", " "), flags=re.MULTILINE)[1:]:
        command, _, wanted = part.partition("\n")
        yield command, wanted.strip("\n") + "\n" if wanted.strip() else ""


def check_named(block: Block, place: str) -> None:
    """What is not run must at least be there: commands with their options, tools of run.py,
    modules.
    """
    commands = [command for command, _ in commands_in(block.text)]
    assert commands, f"{place}: no line `$ ...`"
    for command in commands:
        match shlex.split(command, comments=True):
            case ["cyclemap", name, *words]:
                check_command(name, words, f"{place}: {command}")
            case ["python3", "run.py", name, *words]:
                if name not in RUN_TOOLS:
                    check_command(name, words, f"{place}: {command}")
            case ["python", "-m", module, *_]:
                found = REPOSITORY.joinpath(*module.split("."))
                assert found.with_suffix(".py").exists() or (found / "__main__.py").exists(), (
                    f"{place}: no {module}"
                )
            case _:
                raise AssertionError(f"{place}: {command!r} is no command of this project")


def check_command(name: str, words: list[str], place: str) -> None:
    """The command and its options exist; nothing is run."""
    assert name in cli.commands, f"{place}: there is no such command"
    command = cli.commands[name]
    with click.Context(command, info_name=name) as context:
        command.make_parser(context).parse_args(args=list(words))
