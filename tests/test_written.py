"""What results become in JSON: units, names, and numbers that are none."""

import json
import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from cyclemap.written import (
    ANGLE,
    DIRECTION,
    MILLIMETRES,
    UNWRITTEN,
    degrees,
    direction_deg,
    json_of,
    rows,
    written,
)


@dataclass(frozen=True)
class Rest:
    """An inner result, one of whose numbers has no unit of its own."""

    theta: float = field(metadata=DIRECTION)
    size: float


@dataclass(frozen=True)
class Course:
    """A result with fields of every kind."""

    turn: float = field(metadata=ANGLE)
    reach: tuple[float, ...] = field(metadata={"unit": MILLIMETRES, "name": "widest"})
    rests: tuple[Rest, ...]
    kept: object = field(metadata=UNWRITTEN)
    none: float | None = field(metadata=ANGLE)

    @property
    def half(self) -> float:
        """Half of the turn, rad."""
        return 0.5 * self.turn


RESULT = Course(math.pi, (0.25, math.nan), (Rest(-math.pi / 2, 2.0),), object(), None)


def test_fields_are_written_in_their_units_under_their_names_and_in_order() -> None:
    told = json_of(RESULT)
    assert list(told) == ["turn_deg", "widest_mm", "rests", "none_deg"]
    assert told == {
        "turn_deg": 180.0,
        "widest_mm": [250.0, None],
        "rests": [{"theta_deg": 270.0, "size": 2.0}],
        "none_deg": None,
    }


def test_a_unit_that_is_given_is_of_what_has_none_nested_results_too() -> None:
    told = json_of(RESULT, "half", "turn", "rests", unit=MILLIMETRES)
    assert told == {
        "half_mm": pytest.approx(500.0 * math.pi),
        "turn_deg": 180.0,
        "rests_mm": [{"theta_deg": 270.0, "size_mm": 2000.0}],
    }


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, np.float64("nan")])
def test_numbers_that_are_none_are_null_at_any_depth(bad: float) -> None:
    told = written({"a": [bad, (bad, np.array([1.0, bad]))], "b": bad})
    assert json.loads(json.dumps(told, allow_nan=False)) == {
        "a": [None, [None, [1.0, None]]],
        "b": None,
    }


def test_numpys_scalars_become_pythons_and_whole_numbers_stay_whole() -> None:
    told = written([np.int64(3), np.bool_(True), np.float32(0.5), Path("a/b"), 7], MILLIMETRES)
    assert told == [3, True, 500.0, str(Path("a/b")), 7]
    assert [type(entry) for entry in told] == [int, bool, float, str, int]


@pytest.mark.parametrize("turns", range(-3, 4))
def test_a_direction_does_not_depend_on_whole_turns_and_is_below_360(turns: int) -> None:
    for radians in (-1e-17, 0.0, 1.0, 6.0):
        found = direction_deg(radians + turns * 2.0 * math.pi)
        assert 0.0 <= found < 360.0
        assert math.remainder(found - degrees(radians), 360.0) == pytest.approx(0.0, abs=1e-12)


def test_rows_keep_columns_side_by_side_and_refuse_those_of_other_lengths() -> None:
    assert rows(cycle=np.arange(2), end=[[1.0, math.inf], [2.0, 3.0]]) == [
        {"cycle": 0, "end": [1.0, None]},
        {"cycle": 1, "end": [2.0, 3.0]},
    ]
    with pytest.raises(ValueError, match="zip"):
        rows(cycle=[0, 1], end=[1.0])
