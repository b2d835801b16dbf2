"""What a terminal shows: whole sentences in the help, tables of any width, words to complete, or nothing at all."""

import io
import re
import time

import click
import pytest
from rich.table import Table

from cyclemap.cli.main import cli, run
from cyclemap.cli.output import PeopleConsole, progress_bar


@pytest.mark.parametrize("columns", ["60", "100"])
def test_the_list_of_commands_has_whole_sentences(columns, monkeypatch, capsys) -> None:
    """Every command's first sentence stands in the help to its end, in lines that fit."""
    monkeypatch.setenv("COLUMNS", columns)
    assert run(["--help"]) == 0
    shown = capsys.readouterr().out
    assert "..." not in shown.partition("Commands:")[2]
    assert max(map(len, shown.splitlines())) <= int(columns)
    words = " ".join(shown.split())
    for name, command in cli.commands.items():
        assert f"{name} {command.get_short_help_str(limit=1000)}" in words


def told(width: int) -> str:
    """A table of two rows with a wide column, as a terminal of this width shows it."""
    table = Table(title="All")
    for name in ("name", "number"):
        table.add_column(name)
    table.add_row("first " * 9, "1")
    table.add_row("second", "-2.5")
    console, sink = PeopleConsole(), io.StringIO()
    console._force_terminal, console.no_color, console.file, console.width = True, True, sink, width
    console.print_table(table)
    return re.sub(r"\x1b\[[0-9;]*m", "", sink.getvalue())


def test_a_table_wider_than_the_terminal_is_told_row_by_row() -> None:
    """No number is lost, and each stands behind its column's name; with room enough it is a table."""
    narrow = told(50).splitlines()
    assert "number: 1" in narrow and "number: -2.5" in narrow and "name: second" in narrow
    assert "┃" in told(100) and "number:" not in told(100)


def test_quiet_says_nothing_and_does_the_same(tmp_path, monkeypatch, capsys) -> None:
    """--quiet leaves both streams empty, keeps the results and their JSON, and still tells errors."""
    monkeypatch.chdir(tmp_path)
    assert run(["fingerprint", "plywood", "--quiet"]) == 0
    shown = capsys.readouterr()
    assert (shown.out, shown.err) == ("", "")
    assert (tmp_path / "out" / "fingerprint_plywood.png").is_file()
    assert run(["cycle", "plywood", "--theta0-deg", "0", "--quiet", "--json", "-"]) == 0
    assert '"cycles"' in capsys.readouterr().out
    assert run(["cycle", "no-such-material", "--quiet"]) == 2
    assert capsys.readouterr().err.startswith("error: ")


def test_slow_work_tells_how_long_the_rest_will_take(monkeypatch, capsys) -> None:
    """A quarter done leaves three times what was spent."""
    monkeypatch.setattr("cyclemap.cli.output.LINE_SECONDS", 0.05)
    with progress_bar("work") as report:
        report(0.25)
        while "left" not in (line := capsys.readouterr().err):
            time.sleep(0.05)
    assert re.search(r"work: 25 % done, \d+ s, about \d+ s left", line)


def test_a_shell_is_told_which_words_may_follow(monkeypatch, capsys) -> None:
    """Click's protocol: the words so far come in variables, completions go to stdout; the page's script is bash's."""
    monkeypatch.setenv("_CYCLEMAP_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", "cyclemap port")
    monkeypatch.setenv("COMP_CWORD", "1")
    assert run([]) == 0
    assert capsys.readouterr().out.split() == ["plain,portrait"]
    monkeypatch.setattr(click.shell_completion.BashComplete, "_check_version", staticmethod(lambda: None))
    monkeypatch.setenv("_CYCLEMAP_COMPLETE", "bash_source")
    assert run([]) == 0
    assert "complete -o nosort" in capsys.readouterr().out
