"""The README's example runs as it stands."""

import re
from pathlib import Path

README = Path(__file__).parents[1] / "README.md"


def test_python_example_runs_and_is_short(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    examples = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert len(examples) == 1
    assert len(examples[0].strip().splitlines()) <= 15
    exec(compile(examples[0], "README.md", "exec"), {})
    assert "stable" in capsys.readouterr().out


def test_named_files_exist() -> None:
    links = re.findall(r"\]\(([^)#:]+)\)", README.read_text(encoding="utf-8"))
    assert "docs/portrait_plywood.png" in links
    for link in links:
        assert (README.parent / link).exists(), link
