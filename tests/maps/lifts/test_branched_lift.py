"""Maps joined from branches: each its own function, seams that are breaks, what is refused."""

from itertools import pairwise

import numpy as np
import pytest

from cyclemap.maps import CircleMap
from tests.maps.known_maps import TWO_PI, agree, lines, wavy, wavy_slope
from tests.refusals import refused

GRID = np.linspace(-15.0, 15.0, 3001)


@pytest.mark.parametrize("derivative", [True, False])
@pytest.mark.parametrize("degree", [-2, 0, 1, 5])
@pytest.mark.parametrize("start", [0.0, 1.3, 9.0, -20.0])
def test_every_branch_is_its_own_function_wherever_the_turn_starts_and_whatever_the_degree(
    start, degree, derivative
):
    seams = np.array([start, start + 1.0, start + 4.0, start + TWO_PI])
    branches = list(zip(seams[:-1], seams[1:], [0.0, 3.0, -1.0], [0.5, -1.0, 2.0], strict=True))
    made = lines(*branches, degree=degree, slopes=derivative)
    rng = np.random.default_rng(3)
    for first, last, offset, slope in branches:
        x = rng.uniform(first, last, 50)
        for lap in (-2, 0, 3):
            climbed = TWO_PI * degree * lap
            agree(made(x + TWO_PI * lap), offset + slope * x + climbed, 1e-13)
        agree(made.derivative(x), slope, 1e-13 if derivative else 1e-9)
        agree(made.left(last), offset + slope * last, 1e-13)
        agree(made.right(first), offset + slope * first, 1e-13)
        base = np.mod(first, TWO_PI)
        lap = np.round((base - first) / TWO_PI)
        agree(made(base), offset + slope * first + TWO_PI * degree * lap, 1e-13)
    agree(made.breaks, np.sort(np.mod(seams[:-1], TWO_PI)), 1e-14)
    x = rng.uniform(-20, 20, 100)
    agree([made.scalar()(y) for y in x], made(x), 1e-13)


def test_seams_where_value_and_slope_agree_are_no_breaks_and_kinks_are():
    cut = [0.3, 2.0, 5.0, 0.3 + TWO_PI]
    for slope in (wavy_slope, None):
        made = CircleMap.from_branches([(a, b, wavy, slope) for a, b in pairwise(cut)])
        assert made.breaks.size == 0
        agree(made(GRID), wavy(GRID), 1e-14)
        agree(made.derivative(GRID), wavy_slope(GRID), 1e-9)
    bent = (0.0, TWO_PI - 1.0, lambda x: x + 0.1 * x * (TWO_PI - 1 - x), None)
    made = CircleMap.from_branches([(-1.0, 0.0, lambda x: x, None), bent])
    agree(made.breaks, [0.0, TWO_PI - 1.0], 1e-14)
    assert made.jumps()[0].size == 0


def test_branches_are_called_inside_their_own_interval_only():
    def guarded(first, last):
        def line(x):
            assert np.all((np.asarray(x) >= first) & (np.asarray(x) <= last))
            return 0.5 * np.asarray(x)

        return line

    ends = [-1.0, 0.5, 3.0, TWO_PI - 1.0]
    made = CircleMap.from_branches([(a, b, guarded(a, b), None) for a, b in pairwise(ends)])
    x = np.concatenate([GRID, np.array(ends), np.nextafter(ends, -9), np.nextafter(ends, 9)])
    assert np.all(np.isfinite(made(x))) and np.all(np.abs(made.derivative(x) - 0.5) < 1e-9)
    agree(made.scalar()(3.0 + 7 * TWO_PI), 1.5 + 7 * TWO_PI, 1e-13)


def one(x):
    return x


def joined(*ends):
    return [(a, b, one, None) for a, b in zip(ends[::2], ends[1::2], strict=True)]


BAD_BRANCHES = {
    r"is \[\]: give a list .* at least one": [],
    "is 3: give a list": 3,
    r"branch 0 is \(0, 1\)": [(0, 1)],
    "branch 1 starts at 2.5 but branch 0 ends at 2: a gap of 0.5": joined(0, 2, 2.5, TWO_PI),
    "an overlap of 0.25": joined(0, 2, 1.75, TWO_PI),
    "a gap of 1e-10": joined(0, 2, 2 + 1e-10, TWO_PI),
    "span 6 radians": joined(0, 2, 2, 6),
    "span 6.5": joined(0, 6.5),
    "branch 1 runs from 2 to 1": joined(0, 2, 2, 1, 1, TWO_PI),
    "start of branch 0 must be a finite number, not nan": joined(np.nan, 2),
    "lift of branch 0 gives .*nan": [(0, TWO_PI, lambda x: np.where(x > 6, np.nan, x), None)],
    "derivative of branch 0 gives float": [(0, TWO_PI, one, lambda x: 1.0)],
    "must be callables": [(0, TWO_PI, 3.0, None)],
    "complex128": [(0, TWO_PI, lambda x: x + 0j, None)],
}


@pytest.mark.parametrize("message", BAD_BRANCHES)
def test_branches_that_do_not_make_one_turn_are_refused_with_the_value_that_is_wrong(message):
    refused(CircleMap.from_branches, BAD_BRANCHES[message], told=message)
