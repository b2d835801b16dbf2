"""What rounding may leave is said in one place."""

from pathlib import Path

import numpy as np

from cyclemap import maps
from cyclemap.maps import rounding


def test_no_other_file_of_the_room_makes_its_own_allowance():
    room = Path(maps.__file__).parent
    files = [path for path in room.rglob("*.py") if path.name != "rounding.py"]
    assert len(files) > 50
    for path in files:
        text = path.read_text(encoding="utf-8")
        assert "finfo(float).eps" not in text and "ROUNDING =" not in text, path


def test_the_allowance_of_a_lift_covers_the_textbook_maps():
    """Their values in double against quadruple precision, where the machine has any."""
    x = np.linspace(0.0, 2 * np.pi, 5001)
    long = x.astype(np.longdouble)
    exact = long + 2 * np.longdouble(np.pi) * np.longdouble(0.1) - np.longdouble(0.9) * np.sin(long)
    off = np.abs(maps.CircleMap.arnold(0.1, 0.9)(x) - exact)
    assert np.max(off / (2 * np.pi + np.abs(x))) < rounding.LIFT
