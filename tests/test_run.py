"""run.py: what it installs when, what it says when it cannot, and that no failing check is lost."""

import errno
import importlib.util
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from refusals import refused

ROOT = Path(__file__).parents[1]


@pytest.fixture
def run(tmp_path):
    """run.py, at work in an empty folder."""
    spec = importlib.util.spec_from_file_location("run", ROOT / "run.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    venv = tmp_path / ".venv"
    module.ROOT, module.VENV = tmp_path, venv
    module.STAMP, module.PYTHON = venv / "stamp.json", venv / "bin" / "python"
    optional = '[project.optional-dependencies]\npeers = ["drake>=1.51"]\n'
    groups = '[dependency-groups]\ntest = ["pytest>=9"]\n'
    needed = f'[project]\ndependencies = ["numpy>=2.0.0"]\n{optional}{groups}'
    (tmp_path / "pyproject.toml").write_text(needed)
    (tmp_path / "constraints.txt").write_text("numpy==2.4.6\npytest==9.2.0\n")
    (tmp_path / "setup.py").touch()
    return module


@pytest.fixture
def installer(run, monkeypatch) -> SimpleNamespace:
    """Its outside calls are recorded and succeed, but as `outcomes` has it."""
    made = SimpleNamespace(calls=[], outcomes=[], pip=False, engine=True)

    def called(name: str) -> bool:
        made.calls.append(name)
        return made.outcomes.pop(0) if made.outcomes else True

    def rebuild() -> None:
        made.calls.append("rebuild")
        run.PYTHON.parent.mkdir(parents=True, exist_ok=True)
        run.PYTHON.touch()
        made.pip = True

    def build_engine() -> bool:
        made.engine = called("build engine")
        return made.engine

    def ensure(testing: bool = False) -> list[str]:
        made.calls.clear()
        run.ensure_installed(testing)
        return list(made.calls)

    made.ensure = ensure

    def install(testing: bool, afresh: bool = False) -> bool:
        return called(f"install{' testing' * testing}{' afresh' * afresh}")

    monkeypatch.setattr(run, "pip_works", lambda: made.pip)
    monkeypatch.setattr(run, "engine_is_built", lambda: made.engine)
    for function in (rebuild, build_engine, install):
        monkeypatch.setattr(run, function.__name__, function)
    return made


def change(run) -> None:
    """Ask for another version."""
    (run.ROOT / "pyproject.toml").write_text("[project]\nversion = '2'\n")


def test_what_is_there_is_not_installed_again_and_test_tools_are_added_once_and_kept(
    installer, run
) -> None:
    assert installer.ensure() == ["rebuild", "install"]
    assert installer.ensure() == []
    assert installer.ensure(testing=True) == ["install testing"]
    assert installer.ensure(testing=True) == installer.ensure() == []
    change(run)
    assert installer.ensure() == ["install testing"]


def test_run_cut_short_is_repaired(installer, run) -> None:
    installer.ensure()
    run.STAMP.unlink()
    assert installer.ensure() == ["install afresh"]
    run.STAMP.write_text("{half a stam")
    installer.outcomes = [False, True]
    assert installer.ensure() == ["install afresh", "rebuild", "install"]


def test_failed_installation_leaves_no_stamp_and_a_failed_update_what_was_there(
    installer, run
) -> None:
    installer.outcomes = [False]
    refused(installer.ensure, told="could not install", kind=run.InstallError)
    assert not run.STAMP.exists()
    installer.ensure()
    change(run)
    installer.outcomes = [False]
    refused(installer.ensure, told=r"could not bring \.venv up to date", kind=run.InstallError)
    assert "rebuild" not in installer.calls


def test_changed_engine_is_built_without_an_installation(installer, run) -> None:
    installer.ensure()
    installer.engine, installer.outcomes = False, [False]
    refused(installer.ensure, told="engine could not be built", kind=run.InstallError)
    assert installer.ensure() == ["build engine"]
    assert installer.ensure() == []


@pytest.mark.parametrize(
    ("pins", "numpy"), [("constraints.txt", "2.4.6"), ("floors", "2.0.0"), ("newest", None)]
)
def test_each_environment_pins_what_it_says(run, monkeypatch, tmp_path, pins, numpy) -> None:
    made = []
    if pins != "constraints.txt":
        run.move_to(pins)
        for path in (run.VENV, run.STAMP, run.PYTHON):
            assert path.is_relative_to(tmp_path / f".venv-{pins}")
    run.VENV.mkdir()

    def done(command, env, **_):
        made.append((command, env))
        return subprocess.CompletedProcess((), 0)

    monkeypatch.setattr(run.subprocess, "run", done)
    assert run.install(testing=True)
    [(command, surroundings)] = made
    assert command[-1] == "pytest>=9"
    for name in ("PIP_CONSTRAINT", "PIP_BUILD_CONSTRAINT"):
        pinned = dict(line.split("==") for line in Path(surroundings[name]).read_text().split())
        assert pinned.get("numpy") == numpy
        assert pinned.get("pytest") == (None if pins == "newest" else "9.2.0")


@pytest.mark.parametrize(
    ("version", "missing", "said"),
    [
        ((3, 10, 4), None, "this is Python 3.10; cyclemap needs 3.11"),
        ((3, 12, 0), "ensurepip", "no module ensurepip"),
    ],
)
def test_unfit_python_is_one_line_and_exit_1(
    run, monkeypatch, capsys, version, missing, said
) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(run.sys, "version_info", version)

    def found(name):
        return None if name == missing else find(name)

    monkeypatch.setattr(run.importlib.util, "find_spec", found)
    assert run.main(["portrait", "plywood"]) == 1
    error = capsys.readouterr().err
    assert error.startswith("error: ") and said in error and error.count("\n") == 1


def test_python_too_old_to_read_the_project_is_told_so() -> None:
    """Python 3.10 has no module tomllib: it is asked for after the version is."""
    old = "import sys; sys.modules['tomllib'] = None; sys.version_info = (3, 10, 13)"
    call = "sys.argv = ['run.py', 'portrait', 'plywood']"
    code = f"{old}; {call}; import runpy; runpy.run_path('run.py', run_name='__main__')"
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    told = "this is Python 3.10; cyclemap needs 3.11 or newer: run with a newer python3"
    assert (done.returncode, done.stderr) == (1, f"error: {told}\n")


@pytest.mark.parametrize("made", [False, True])
def test_checkout_that_cannot_be_written_is_told_so_before_anything_is_tried(
    installer, run, monkeypatch, capsys, made
) -> None:
    """To remove a folder would not help; where all is installed, nothing has to be written."""
    if made:
        installer.ensure()
        assert installer.ensure() == []
        change(run)

    def no_file(dir: Path) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(dir))

    monkeypatch.setattr(run.tempfile, "TemporaryFile", no_file)
    installer.calls.clear()
    capsys.readouterr()
    assert run.main(["portrait", "plywood"]) == 1
    place = run.VENV if made else run.VENV.parent
    told = f"{place} cannot be written (Read-only file system): make it writable, or copy"
    mend = "the checkout to a folder of yours and run it there"
    assert capsys.readouterr().err == f"error: {told} {mend}\n"
    assert installer.calls == []


@pytest.mark.parametrize("quick", [["--quick"], []])
@pytest.mark.parametrize("failing", range(5))
def test_every_check_runs_any_failure_counts_and_a_quick_run_leaves_out_slow_tests(
    run, monkeypatch, failing, quick
) -> None:
    made: list[list[str]] = []

    def call(command, cwd=None):
        made.append([str(part) for part in command])
        return 3 if len(made) == failing + 1 else 0

    monkeypatch.setattr(run, "call", call)
    assert run.run_tests([*quick, "-k", "cycle"]) == (3 if failing < 4 else 0)
    assert [command[2] for command in made] == ["ruff", "ruff", "mypy", "pytest"]
    assert made[-1][-2:] == ["-k", "cycle"] and "--quick" not in made[-1]
    assert ("not slow" in made[-1]) == bool(quick)


@pytest.mark.parametrize(("code", "said"), [(0, "index.html"), (2, "")])
def test_documentation_is_built_with_warnings_as_errors_and_its_place_told(
    run, monkeypatch, capsys, code, said
) -> None:
    made = []

    def call(command, cwd=None):
        made.append(command)
        return code

    monkeypatch.setattr(run, "ensure_installed", lambda testing: made.append(testing))
    monkeypatch.setattr(run, "call", call)
    assert run.main(["docs", "-j2"]) == code
    assert made[0] is True
    assert list(made[1][1:4]) == ["-m", "sphinx", "-W"] and "-j2" in made[1]
    assert capsys.readouterr().out.strip().endswith(said)


def test_no_argument_shows_how_to_use_it(run, capsys) -> None:
    assert run.main([]) == 2
    assert "python3 run.py portrait plywood" in capsys.readouterr().out


def test_continuous_integration_runs_what_a_developer_runs() -> None:
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    assert script.read_text().splitlines()[-1] == "exec python3 run.py test"
