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


def test_an_estimate_is_a_float_and_arithmetic_forgets_the_bound() -> None:
    half = Estimate(0.5, 1e-3)
    assert half == 0.5
    assert json.dumps(half) == "0.5"
    assert type(half + 1) is float


def test_its_interval_is_rounded_outward() -> None:
    third = Estimate(1 / 3, 1e-17)
    assert third.lower < 1 / 3 < third.upper
    assert third.holds(1 / 3)
    assert not third.holds(0.3334)


def test_a_copy_and_a_pickle_keep_the_bound() -> None:
    known = Estimate(math.pi, 1e-12)
    for again in (copy.copy(known), copy.deepcopy(known), pickle.loads(pickle.dumps(known))):
        assert (float(again), again.error_bound) == (math.pi, 1e-12)


def test_an_estimate_cannot_be_changed() -> None:
    with pytest.raises(AttributeError, match="never changes"):
        Estimate(1.0, 0.1).error_bound = 0.0


@pytest.mark.parametrize("bound", [-1e-3, math.nan])
def test_a_bound_below_zero_is_refused(bound: float) -> None:
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
