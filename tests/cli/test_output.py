"""Files appear whole or not at all, under names of their own; a terminal shows whole sentences,
tables of any width, and a bar if need be.
"""

import io
import json
import re
import shlex
import stat
import sys
import time

import click
import pytest
from rich.table import Table

from cyclemap import CollectionLoop
from cyclemap.cli import output
from cyclemap.cli.commands import ReportOptions
from cyclemap.cli.main import cli
from cyclemap.cli.options import parameters, said_command
from cyclemap.cli.output import PeopleConsole, file_stem, progress_bar, result_name
from cyclemap.protocol import loop_from_settings
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


def test_two_objects_on_one_surface_leave_two_results(here, said) -> None:
    (here / "table.toml").write_text('name = "table"\n[friction]\nmu_a = 0.26\nmu_b = 0.2\n')
    for setting in ("shape=rect1", "shape=hex", "shape=tri1", "object_name=lid"):
        said(f"cycle table.toml --theta0-deg 0 --set {setting} --out made")
    files = {path.name: json.loads(path.read_text()) for path in (here / "made").iterdir()}
    names = ("hex_on_table", "lid_on_table", "table", "tri1_on_table")
    assert sorted(files) == [f"cycles_{name}.json" for name in names]
    assert len({report["cycles"][0]["push_turn_deg"] for report in files.values()}) == 3


@pytest.mark.parametrize(
    ("words", "name"),
    [
        ("--over mu_a=0.2,0.3 --set shape=hex", "sweep_hex_on_plywood"),
        ("--over mu_a=0.2,0.3 --set push_mm=90", "sweep_plywood"),
        ("--over shape=hex,tri1", "sweep_plywood"),
    ],
)
def test_a_sweep_of_an_object_is_stored_by_its_name(here, said, words, name) -> None:
    assert f"out/{name}.sqlite" in said(f"sweep plywood {words} --status").out


@pytest.mark.parametrize("name", ["rect1", "own outline"])
def test_a_name_borrowed_from_the_square_is_told(name) -> None:
    """An object of another outline that is called rect1, and one without a name."""
    loop = loop_from_settings({"semi_x_mm": 40, "semi_y_mm": 50, "object_name": name})
    assert result_name("portrait", loop) == f"portrait_{name.replace(' ', '_')}_on_plywood"
    assert result_name("portrait", CollectionLoop.mit()) == "portrait_plywood"


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


@pytest.mark.parametrize("columns", [60, 100])
def test_the_list_of_commands_has_whole_sentences(columns, monkeypatch, said) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    shown = said("--help").out
    assert "..." not in shown.partition("Commands:")[2]
    assert max(map(len, shown.splitlines())) <= columns
    words = " ".join(shown.split())
    for name, command in cli.commands.items():
        assert f"{name} {command.get_short_help_str(limit=1000)}" in words


def told(width: int) -> str:
    """A table of two rows with a wide column, as a terminal of this width shows it."""
    table = Table("name", "number", title="All")
    table.add_row("first " * 9, "1")
    table.add_row("second", "-2.5")
    console, sink = PeopleConsole(), io.StringIO()
    console._force_terminal, console.no_color, console.file, console.width = True, True, sink, width
    console.print_table(table)
    return re.sub(r"\x1b\[[0-9;]*m", "", sink.getvalue())


def test_a_table_wider_than_the_terminal_is_told_row_by_row() -> None:
    assert {"number: 1", "number: -2.5", "name: second"} <= {*told(50).splitlines()}
    assert "┃" in told(100) and "number:" not in told(100)


def test_words_of_a_wide_table_are_broken_and_numbers_never(capsys) -> None:
    row = (" ".join(["words"] * 40), "-2.50")
    PeopleConsole().print_table(output.people_table("Rows", ("what", "value"), [row], words=(0,)))
    shown = capsys.readouterr().out
    assert max(map(len, shown.splitlines())) <= 120
    assert shown.count("words") == 40 and shown.count("-2.50") == 1


def test_quiet_says_nothing_and_does_the_same(here, said) -> None:
    assert said("fingerprint plywood --quiet") == ("", "")
    assert (here / "out" / "fingerprint_plywood.png").is_file()
    assert '"cycles"' in said("cycle plywood --theta0-deg 0 --quiet --json -").out
    (here / "own.csv").write_text("yaw_deg\n" + "".join(f"{31 * n % 360}\n" for n in range(20)))
    assert said("watch own.csv --quiet") == ("", "")
    assert said("cycle no-such-material --quiet", 2).err.startswith("error: ")


def test_a_shell_is_told_which_words_may_follow(monkeypatch, said) -> None:
    """Click's protocol: the words so far come in variables, completions go to stdout; the page's
    script is bash's.
    """
    monkeypatch.setenv("_CYCLEMAP_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", "cyclemap port")
    monkeypatch.setenv("COMP_CWORD", "1")
    assert said("").out.split() == ["plain,portrait"]
    bash = click.shell_completion.BashComplete
    monkeypatch.setattr(bash, "_check_version", staticmethod(lambda: None))
    monkeypatch.setenv("_CYCLEMAP_COMPLETE", "bash_source")
    assert "complete -o nosort" in said("").out


def test_a_command_is_told_as_it_was_said_with_all_that_was_said_of_its_data(capsys) -> None:
    def say(**asked: object) -> None:
        click.echo(shlex.join(said_command("out", files_by_name=True)))

    report = click.Command("report", params=[*parameters(ReportOptions)], callback=say)
    line = (
        "plywood --protocol mine.toml --set push_mm=60 --set side=1 --data mine.csv --columns "
        "theta0=yaw --units deg,mm --angles clockwise --frame mirrored --offset-deg -3.5 --reset"
    )
    typed = line.replace("mine.", "some/folder/mine.").split()
    report.main([*typed, "--out", "elsewhere"], standalone_mode=False)
    assert capsys.readouterr().out == f"cyclemap report {line}\n"
