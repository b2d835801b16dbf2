"""The public names of the package and its rooms: there when they are asked for, and their modules
not before.
"""

import subprocess
import sys
from importlib import import_module
from types import ModuleType

import pytest

import cyclemap as cm
from cyclemap.lazy_names import import_on_first_use

# The names that users were promised.
PROMISED = (
    "CollectionLoop CircleMap fixed_points periodic_orbits rotation_number rotation_interval "
    "lyapunov_exponent transfer_operator WrappedNormal WrappedCauchy VonMises UniformNoise "
    "load_pushes fit_map identify compare CycleMapError"
)
# All but the last have names of their own, told in a table of contents.
ROOMS = "collection", "evidence", "maps", "mechanics", "protocol", "resets", "sweeps", "views"


def test_the_top_level_holds_some_sixty_names_and_the_rooms_and_each_resolves():
    """What one begins with, no more; completion shows it, and every room is reached without an
    import of its own.
    """
    names = set(cm.__all__) - set(ROOMS)
    assert 50 <= len(names) <= 70 and set(PROMISED.split()) <= names
    assert [name for name in dir(cm) if not name.startswith("_")] == sorted(cm.__all__)
    assert None not in [getattr(cm, name) for name in cm.__all__]
    code = f"import cyclemap as cm; print([getattr(cm, name).__name__ for name in {ROOMS}])"
    words = [sys.executable, "-c", code]
    printed = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    assert printed.strip() == str([f"cyclemap.{name}" for name in ROOMS])


@pytest.mark.parametrize("room", ROOMS[:-1])
def test_the_docstring_of_a_room_is_its_table_of_contents(room):
    """help() of a room tells every public name of it once, with a few words, and no other."""
    module = getattr(cm, room)
    entries = [line.split(" : ") for line in module.__doc__.splitlines() if " : " in line]
    told = [name for names, words in entries for name in names.split(", ") if words.strip()]
    assert sorted(told) == sorted(module.__all__)


def loaded(code: str, *names: str) -> list[str]:
    """Which of the modules `names` a new process has loaded after `code`."""
    probe = f"print(*[name for name in {names!r} if name in sys.modules], file=sys.stderr)"
    words = [sys.executable, "-c", f"import sys\n{code}\n{probe}"]
    run = subprocess.run(words, capture_output=True, text=True, check=True)
    # A slow machine has a portrait say how far it is before that.
    return run.stderr.splitlines()[-1].split()


@pytest.mark.slow
@pytest.mark.parametrize("room", ROOMS[:-1])
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
    own = "cyclemap.maps.lifts.circle_map"
    others = "cyclemap.maps.operator.transfer_operator", "cyclemap.maps.families.tongues"
    slow = "casadi", "scipy", "matplotlib"
    assert loaded("import cyclemap, cyclemap.maps", own, *others, *slow) == []
    assert loaded("from cyclemap.maps import CircleMap", own, *others, *slow) == [own]


@pytest.mark.slow
@pytest.mark.parametrize("order", ["import {0}", "from {1} import {2}; import {0}"])
def test_a_function_named_like_its_module_is_the_function_in_either_order(order) -> None:
    """Python binds an imported submodule on its package; the public name stays the function."""
    lines = []
    for room, name in (
        ("collection", "fingerprint"),
        ("collection", "portrait"),
        ("sweeps", "run_sweep"),
    ):
        package = f"cyclemap.{room}"
        lines.append(order.format(f"{package}.{name}", package, name))
        lines.append(f"from {package} import {name}; assert callable({package}.{name})")
    module = "cyclemap.collection.portrait"
    assert loaded("\n".join(lines), module) == [module]


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
def test_a_portrait_loads_nothing_that_it_does_not_use(tmp_path) -> None:
    words = ["portrait", "plywood", "--out", str(tmp_path), "--json", "-"]
    code = f"from cyclemap.cli.main import run\nassert run({words!r}) == 0"
    parts = ("evidence", "resets", "sweeps", "figures", "mechanics.dynamic_model")
    rooms = [f"cyclemap.{part}" for part in parts]
    slow = ("scipy", "pandas", "h5py", "xarray", "matplotlib.pyplot", "matplotlib.figure")
    assert loaded(code, *rooms, *slow) == ["matplotlib.figure"]
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["portrait_plywood.json", "portrait_plywood.png"]
