"""The rooms' names are there when they are asked for, and their modules not before."""

import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

from cyclemap.lazy_names import import_on_first_use

ROOMS = ("maps", "mechanics", "collection", "protocol", "evidence", "sweeps", "resets")
# Functions that are called like the module they are in.
NAMESAKES = ("collection.fingerprint", "collection.portrait", "sweeps.run_sweep")


def loaded(code: str, names: tuple[str, ...]) -> list[str]:
    """Which of the modules `names` a new process has loaded after `code`."""
    probe = (
        f"import sys\n{code}\nprint(*[name for name in {names!r} if name in sys.modules], "
        "file=sys.stderr)"
    )
    run = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    # A slow machine has a portrait say how far it is before that.
    return run.stderr.splitlines()[-1].split()


@pytest.mark.slow
@pytest.mark.parametrize("room", ROOMS)
def test_every_name_of_a_room_is_the_one_that_its_module_defines(room: str) -> None:
    """One list: __all__ holds what is imported for type checkers, and each name is the module's own
    object.
    """
    package = import_module(f"cyclemap.{room}")
    assert len(package.__all__) >= 10 and set(package.__all__) == set(package._places)
    for name, place in package._places.items():
        assert getattr(package, name) is getattr(import_module(place), name)
    assert set(package.__all__) <= set(dir(package))


def test_a_name_loads_its_own_module_and_not_the_others() -> None:
    assert loaded("import cyclemap", ("casadi", "scipy", "matplotlib")) == []
    others = "cyclemap.maps.operator.transfer_operator", "cyclemap.maps.families.tongues", "scipy"
    assert loaded("import cyclemap.maps", ("cyclemap.maps.lifts.circle_map", *others)) == []
    assert loaded(
        "from cyclemap.maps import CircleMap", ("cyclemap.maps.lifts.circle_map", *others)
    ) == ["cyclemap.maps.lifts.circle_map"]


@pytest.mark.slow
def test_a_function_named_like_its_module_is_the_function_in_either_order() -> None:
    """Python binds an imported submodule on its package; the public name must not change with the
    order of imports.
    """
    for order in (
        "import {0}",
        "from {1} import {2}; import {0}",
        "import {0}; from {1} import {2}",
    ):
        lines = []
        for place in NAMESAKES:
            room, name = place.split(".")
            lines.append(order.format(f"cyclemap.{place}", f"cyclemap.{room}", name))
            lines.append(
                f"import cyclemap.{room}; assert callable(cyclemap.{room}.{name}), {place!r}"
            )
        assert loaded("\n".join(lines), ("cyclemap.collection.portrait",)) == [
            "cyclemap.collection.portrait"
        ]


def test_an_unknown_name_is_an_attribute_error() -> None:
    for package in ("cyclemap", "cyclemap.maps"):
        with pytest.raises(AttributeError, match="no attribute 'CircelMap'"):
            _ = import_module(package).CircelMap
    with pytest.raises(ImportError, match="cannot import name 'CircelMap'"):
        exec("from cyclemap.maps import CircelMap", {})


def test_a_room_without_its_source_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """The names' places are read from the package's text; where that is missing the import fails at
    once.
    """
    monkeypatch.setitem(sys.modules, "bare_room", ModuleType("bare_room"))
    with pytest.raises(ImportError, match="source text of bare_room is missing"):
        import_on_first_use("bare_room")


@pytest.mark.slow
def test_a_portrait_loads_nothing_that_it_does_not_use(tmp_path: Path) -> None:
    code = (
        "from cyclemap.cli.main import run\n"
        f"assert run(['portrait', 'plywood', '--out', {str(tmp_path)!r}, '--json', '-']) == 0\n"
    )
    slow = (
        "scipy.optimize",
        "scipy.stats",
        "scipy.interpolate",
        "scipy.spatial",
        "pandas",
        "h5py",
        "xarray",
    )
    parts = ("evidence", "resets", "sweeps", "figures", "mechanics.dynamic_model")
    assert loaded(
        code,
        (*slow, *(f"cyclemap.{part}" for part in parts), "matplotlib.pyplot", "matplotlib.figure"),
    ) == ["matplotlib.figure"]
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "portrait_plywood.json",
        "portrait_plywood.png",
    ]
