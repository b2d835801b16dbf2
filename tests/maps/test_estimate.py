"""Estimates: floats everywhere, with a bound that survives copying and cannot be changed."""

import copy
import json
import math
import pickle
from pathlib import Path

import numpy as np
import pytest

from cyclemap import maps
from cyclemap.errors import InvalidInput
from cyclemap.maps import Estimate, estimate


def test_an_estimate_is_a_float_that_keeps_its_bound_and_arithmetic_forgets_it() -> None:
    half = Estimate(0.5, 1e-3)
    assert half == 0.5 and json.dumps(half) == "0.5" and type(half + 1) is float
    for again in (copy.copy(half), copy.deepcopy(half), pickle.loads(pickle.dumps(half))):
        assert (float(again), again.error_bound) == (0.5, 1e-3)
    third = Estimate(1 / 3, 1e-17)  # rounded outward
    assert third.lower < 1 / 3 < third.upper and third.holds(1 / 3) and not third.holds(0.3334)
    with pytest.raises(AttributeError, match="never changes"):
        half.error_bound = 0.0
    for bound in (-1e-3, math.nan):
        with pytest.raises(InvalidInput, match="error_bound"):
            Estimate(1.0, bound)


def test_no_other_file_of_the_room_makes_its_own_allowance():
    room = Path(maps.__file__).parent
    files = [path for path in room.rglob("*.py") if path.name != "estimate.py"]
    assert len(files) > 30
    for path in files:
        text = path.read_text(encoding="utf-8")
        assert "finfo(float).eps" not in text and "ROUNDING =" not in text, path


def test_the_allowance_of_a_lift_covers_the_textbook_maps():
    """Their values in double against quadruple precision, where the machine has any."""
    x = np.linspace(0.0, 2 * np.pi, 5001)
    long = x.astype(np.longdouble)
    exact = long + 2 * np.longdouble(np.pi) * np.longdouble(0.1) - np.longdouble(0.9) * np.sin(long)
    off = np.abs(maps.CircleMap.arnold(0.1, 0.9)(x) - exact)
    assert np.max(off / (2 * np.pi + np.abs(x))) < estimate.LIFT
