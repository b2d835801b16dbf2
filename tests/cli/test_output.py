"""Files appear whole or not at all; a terminal shows whole sentences, tables of any width, and a
bar if need be.
"""

import io
import re
import shlex
import stat
import sys
import time

import click
import pytest
from rich.table import Table

from cyclemap.cli import output
from cyclemap.cli.commands import ReportOptions
from cyclemap.cli.main import cli, run
from cyclemap.cli.options import parameters, said_command
from cyclemap.cli.output import PeopleConsole, file_stem, progress_bar
from cyclemap.text_files import write_whole
from cyclemap.written import json_text


def test_a_written_file_is_whole_readable_and_alone_and_stays_where_the_next_write_fails(
    tmp_path, monkeypatch
) -> None:
    path = tmp_path / "new" / "folder" / "picture.png"
    write_whole(path, b"first")
    write_whole(path, b"second")
    assert path.read_bytes() == b"second" and path.stat().st_mode & stat.S_IRUSR

    def full_disk(self, target):
        raise OSError("no space left")

    monkeypatch.setattr("pathlib.Path.replace", full_disk)
    with pytest.raises(OSError, match="no space left"):
        write_whole(path, b"third")
    assert path.read_bytes() == b"second"
    assert [entry.name for entry in path.parent.iterdir()] == ["picture.png"]


def test_json_refuses_numbers_that_are_not_finite_and_file_stems_are_plain() -> None:
    with pytest.raises(ValueError, match="JSON"):
        json_text({"value": float("nan")})
    assert json_text({"θ": 1.5}) == '{\n  "θ": 1.5\n}\n'
    assert [file_stem(name) for name in ("plywood", "../a b", "Ω/2")] == ["plywood", "a_b", "Ω_2"]


class FakeTerminal(io.StringIO):
    """Takes what is written to it and says it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("patience", "shown"), [(60.0, False), (0.0, True)])
def test_bar_appears_only_once_patience_is_over(monkeypatch, patience, shown) -> None:
    terminal = FakeTerminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(output, "PATIENCE_SECONDS", patience)
    monkeypatch.setenv("TERM", "xterm")
    with progress_bar("cycle map") as report:
        report(0.1)
        wait_until(lambda: terminal.getvalue() or not shown)
        report(0.9)
    assert ("cycle map" in terminal.getvalue()) is shown


def test_without_a_terminal_long_work_says_a_line_now_and_then(monkeypatch, capsys) -> None:
    monkeypatch.setattr(output, "LINE_SECONDS", 0.01)
    lines: list[str] = []

    def told() -> list[str]:
        lines.extend(capsys.readouterr().err.splitlines())
        return lines

    with progress_bar("cycle \x1b map") as report:
        wait_until(lambda: len(told()) > 2)
        report(0.5)
        wait_until(lambda: "50 %" in told()[-1])
    assert re.fullmatch(r"cycle \\x1b map: \d+ s", lines[0])
    assert re.fullmatch(r"cycle \\x1b map: 50 % done, \d+ s, about \d+ s left", lines[-1])


def wait_until(condition) -> None:
    deadline = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.005)


@pytest.mark.parametrize("columns", ["60", "100"])
def test_the_list_of_commands_has_whole_sentences(columns, monkeypatch, capsys) -> None:
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
    narrow = told(50).splitlines()
    assert "number: 1" in narrow and "number: -2.5" in narrow and "name: second" in narrow
    assert "┃" in told(100) and "number:" not in told(100)


def test_words_of_a_wide_table_are_broken_and_numbers_never(monkeypatch, capsys) -> None:
    table = output.people_table(
        "Rows", ("what", "value"), [(" ".join(["words"] * 40), "-2.50")], words=(0,)
    )
    PeopleConsole().print_table(table)
    shown = capsys.readouterr().out
    assert max(map(len, shown.splitlines())) <= 120
    assert shown.count("words") == 40 and shown.count("-2.50") == 1


def test_quiet_says_nothing_and_does_the_same(here, capsys) -> None:
    assert run(["fingerprint", "plywood", "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")
    assert (here / "out" / "fingerprint_plywood.png").is_file()
    assert run(["cycle", "plywood", "--theta0-deg", "0", "--quiet", "--json", "-"]) == 0
    assert '"cycles"' in capsys.readouterr().out
    (here / "own.csv").write_text("yaw_deg\n" + "".join(f"{31 * n % 360}\n" for n in range(20)))
    assert run(["watch", "own.csv", "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")
    assert run(["cycle", "no-such-material", "--quiet"]) == 2
    assert capsys.readouterr().err.startswith("error: ")


def test_a_shell_is_told_which_words_may_follow(monkeypatch, capsys) -> None:
    """Click's protocol: the words so far come in variables, completions go to stdout; the page's
    script is bash's.
    """
    monkeypatch.setenv("_CYCLEMAP_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", "cyclemap port")
    monkeypatch.setenv("COMP_CWORD", "1")
    assert run([]) == 0
    assert capsys.readouterr().out.split() == ["plain,portrait"]
    monkeypatch.setattr(
        click.shell_completion.BashComplete, "_check_version", staticmethod(lambda: None)
    )
    monkeypatch.setenv("_CYCLEMAP_COMPLETE", "bash_source")
    assert run([]) == 0
    assert "complete -o nosort" in capsys.readouterr().out


def test_a_command_is_told_as_it_was_said_with_all_that_was_said_of_its_data(capsys) -> None:
    def say(**asked: object) -> None:
        click.echo(shlex.join(said_command("out", files_by_name=True)))

    report = click.Command("report", params=[*parameters(ReportOptions)], callback=say)
    said = (
        "plywood --protocol mine.toml --set push_mm=60 --set side=1 --data mine.csv --columns "
        "theta0=yaw --units deg,mm"
    )
    said += " --angles clockwise --frame mirrored --offset-deg -3.5 --reset"
    typed = said.replace("mine.", "some/folder/mine.").split()
    report.main([*typed, "--out", "elsewhere"], standalone_mode=False)
    assert capsys.readouterr().out == f"cyclemap report {said}\n"
