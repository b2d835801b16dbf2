"""The scripts of the explorer's page keep the rules of the house."""

import shutil
import subprocess
from pathlib import Path

import pytest

import cyclemap as cm
from cyclemap.views.explorer_page import SCRIPTS, WORKER

CHECKER = Path(__file__).parent / "house_rules.js"
EXPLORER = Path(cm.__file__).parent / "views" / "explorer"


def problems(*scripts):
    """What the checker says of files that are one script, line by line."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("no Node found: scripts of pages are not checked; install nodejs")
    words = [node, "--expose-internals", CHECKER, *scripts]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.split("\n")[:-1]


@pytest.mark.parametrize("names", [SCRIPTS, WORKER, ()])
def test_scripts_keep_the_rules(names) -> None:
    """So does the checker itself."""
    assert problems(*(EXPLORER / name for name in names) if names else (CHECKER,)) == []


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("var x = 1;\nx += 1;", "var"),
        ("const x = 1;", "x is not used"),
        ("const f = (x, y) => x;\nf(1);", "y is not used"),
        ("let x = 1;\nconsole.log(x);", "let of what stays"),
        ("console.log(1 == 2);", "== converts"),
        ("console.log(missing);", "missing is declared nowhere"),
        ("console.log(1);" + 120 * " ", "wider than 120"),
    ],
)
def test_what_breaks_a_rule_is_told_with_its_place(fault, words, tmp_path) -> None:
    script = tmp_path / "planted.js"
    script.write_text(f"// One line before.\n{fault}\n")
    [told] = problems(script)
    assert told == f"{script}:2: {words}"
