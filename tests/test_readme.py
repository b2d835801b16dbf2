"""The README's examples run as they stand."""

import re
from pathlib import Path

import pytest

import cyclemap as cm

README = Path(__file__).parents[1] / "README.md"


EXAMPLES = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)


@pytest.mark.parametrize(("index", "said"), [(0, "stable"), (1, "[4, 12, 36, 16]\nrotation numbers from 0 to 1/2\n")])
def test_python_examples_run_and_are_short(tmp_path, monkeypatch, capsys, index, said) -> None:
    monkeypatch.chdir(tmp_path)
    assert len(EXAMPLES) == 2
    assert len(EXAMPLES[index].strip().splitlines()) <= 15
    exec(compile(EXAMPLES[index], "README.md", "exec"), {})
    assert said in capsys.readouterr().out


def test_every_function_named_in_the_readme_exists() -> None:
    rows = re.findall(r"^\| `cm\.(\w+)`(?:: \w+)? \| (.*) \|$", README.read_text(encoding="utf-8"), re.M)
    assert len(rows) == 10
    places = {(room, name) for room, words in rows for name in re.findall(r"`(\w+)`", words)}
    missing = {one for room, one in places if not (hasattr(getattr(cm, room), one) or hasattr(cm.CircleMap, one))}
    assert missing == set()


def test_named_files_exist() -> None:
    links = re.findall(r"\]\(([^)#:]+)\)", README.read_text(encoding="utf-8"))
    assert "docs/portrait_plywood.png" in links
    for link in links:
        assert (README.parent / link).exists(), link
