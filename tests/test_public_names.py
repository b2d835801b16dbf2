"""The package's public names."""

import subprocess
import sys

import pytest

import cyclemap as cm

# The names that users were promised.
PROMISED = (
    "CollectionLoop CircleMap fixed_points periodic_orbits rotation_number rotation_interval "
    "lyapunov_exponent transfer_operator WrappedNormal WrappedCauchy VonMises UniformNoise "
    "load_pushes fit_map identify compare CycleMapError"
)
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


@pytest.mark.parametrize("room", [name for name in ROOMS if name != "views"])
def test_the_docstring_of_a_room_is_its_table_of_contents(room):
    """help() of a room tells every public name of it once, with a few words, and no other."""
    module = getattr(cm, room)
    entries = [line.split(" : ") for line in module.__doc__.splitlines() if " : " in line]
    told = [name for names, words in entries for name in names.split(", ") if words.strip()]
    assert sorted(told) == sorted(module.__all__)
