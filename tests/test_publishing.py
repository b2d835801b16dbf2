"""What people, a package index, an archive and a journal read is there, whole, and told once; what
the README says to run runs.
"""

import re
import tomllib
from importlib.metadata import version
from pathlib import Path

import click
import pytest

import cyclemap
from cyclemap.cli.main import cli

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_version_stands_in_one_place_and_heads_the_changelog() -> None:
    assert PROJECT["project"]["dynamic"] == ["version"] and "version" not in PROJECT["project"]
    assert PROJECT["tool"]["setuptools"]["dynamic"]["version"] == {"attr": "cyclemap.__version__"}
    assert version("cyclemap") == cyclemap.__version__
    assert re.findall(r"^version:", text("CITATION.cff"), re.MULTILINE) == []
    assert re.findall(r"^## (\S+)", text("CHANGELOG.md"), re.MULTILINE)[0] == cyclemap.__version__


def test_what_is_vendored_comes_with_its_licence_and_the_wheel_carries_it() -> None:
    vendored = sorted({path.parent for path in (ROOT / "cyclemap").rglob("*.min.js")})
    assert vendored, (
        "nothing is vendored any more: take its licence out of pyproject.toml, and this test"
    )
    carried = {
        path for pattern in PROJECT["project"]["license-files"] for path in ROOT.glob(pattern)
    }
    assert ROOT / "LICENSE" in carried
    for folder in vendored:
        assert folder / "LICENSE" in carried, f"{folder} has no licence that the wheel carries"


def test_the_paper_is_of_the_journals_form() -> None:
    """Header, sections, 750 to 1750 words, every reference cited and there, every figure there."""
    head, body = text("paper/paper.md").split("---\n", 2)[1:]
    for key in ("title", "tags", "authors", "affiliations", "date", "bibliography"):
        assert re.search(rf"^{key}:", head, re.MULTILINE), key
    titles = re.findall(r"^# (.+)$", body, re.MULTILINE)
    assert titles[:2] == ["Summary", "Statement of need"] and titles[-1] == "References"
    assert 750 <= len(body.split()) <= 1750
    known = set(re.findall(r"^@\w+\{(\w+),", text("paper/paper.bib"), re.MULTILINE))
    assert set(re.findall(r"@(\w+)", body)) == known
    for picture in re.findall(r"!\[[^]]*\]\(([^)]+)\)", body):
        assert (ROOT / "paper" / picture).is_file(), picture


def test_who_wants_to_report_or_to_cite_finds_how() -> None:
    for name in ("SECURITY.md", "CODE_OF_CONDUCT.md", "CONTRIBUTING.md", "CITATION.cff", "LICENSE"):
        assert len(text(name).split()) > 60, name


README = text("README.md")


def test_the_readme_is_read_in_two_minutes() -> None:
    assert len(README.splitlines()) <= 110
    assert README.count("![") == 1


def test_the_readmes_python_runs_as_it_stands(tmp_path, monkeypatch, capsys) -> None:
    (example,) = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
    assert len(example.strip().splitlines()) <= 10
    monkeypatch.chdir(tmp_path)
    exec(compile(example, "README.md", "exec"), {})
    said = capsys.readouterr().out
    assert "63.17 stable" in said and "turns a cycle: 0.0" in said


def test_the_readmes_commands_exist_with_their_options() -> None:
    (block,) = re.findall(r"```sh\n(cyclemap .*?)```", README, flags=re.DOTALL)
    commands = re.findall(r"^cyclemap (\w+) (.*?)(?: {2,}#.*)?$", block, flags=re.MULTILINE)
    assert 6 <= len(commands) <= 8
    for name, words in commands:
        command = cli.commands[name]
        with click.Context(command, info_name=name) as context:
            command.make_parser(context).parse_args(args=words.split())


@pytest.mark.parametrize("link", re.findall(r"\]\(([^)#:]+)\)", README))
def test_the_readmes_links_lead_somewhere(link: str) -> None:
    assert (ROOT / link).exists()
