"""The README is short, and what it says to run runs."""

import re
from pathlib import Path

import click
import pytest

from cyclemap.cli.main import cli

README = Path(__file__).parents[1] / "README.md"
TEXT = README.read_text(encoding="utf-8")


def test_it_is_read_in_two_minutes() -> None:
    assert len(TEXT.splitlines()) <= 110
    assert TEXT.count("![") == 1


def test_its_python_runs_as_it_stands(tmp_path, monkeypatch, capsys) -> None:
    (example,) = re.findall(r"```python\n(.*?)```", TEXT, flags=re.DOTALL)
    assert len(example.strip().splitlines()) <= 10
    monkeypatch.chdir(tmp_path)
    exec(compile(example, "README.md", "exec"), {})
    said = capsys.readouterr().out
    assert "63.17 stable" in said and "turns a cycle: 0.0" in said


def test_its_commands_exist_with_their_options() -> None:
    (block,) = re.findall(r"```sh\n(cyclemap .*?)```", TEXT, flags=re.DOTALL)
    commands = re.findall(r"^cyclemap (\w+) (.*?)(?: {2,}#.*)?$", block, flags=re.MULTILINE)
    assert 6 <= len(commands) <= 8
    for name, words in commands:
        command = cli.commands[name]
        with click.Context(command, info_name=name) as context:
            command.make_parser(context).parse_args(args=words.split())


@pytest.mark.parametrize("link", re.findall(r"\]\(([^)#:]+)\)", TEXT))
def test_its_links_lead_somewhere(link: str) -> None:
    assert (README.parent / link).exists()
