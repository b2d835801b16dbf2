"""Maps joined from branches: each its own function, seams that are breaks, what is refused."""

from itertools import pairwise

import numpy as np
import pytest

from cyclemap.maps import CircleMap
from tests.maps.known_maps import wavy, wavy_slope
from tests.refusals import refused

TWO_PI = 2 * np.pi
GRID = np.linspace(-15.0, 15.0, 3001)


def lines(slopes, offsets, start, seams, degree, derivative):
    """Straight branches y = offset + slope·x and the map made of them."""
    ends = [start, *seams, start + TWO_PI]
    branches = [
        (
            a,
            b,
            lambda x, s=s, c=c: c + s * x,
            (lambda x, s=s: np.full_like(x, s)) if derivative else None,
        )
        for a, b, s, c in zip(ends[:-1], ends[1:], slopes, offsets, strict=True)
    ]
    return branches, CircleMap.from_branches(branches, degree=degree)


@pytest.mark.parametrize("derivative", [True, False])
@pytest.mark.parametrize("degree", [-2, -1, 0, 1, 2, 5])
@pytest.mark.parametrize("start", [0.0, -0.5, 1.3, 9.0, -20.0])
def test_every_branch_is_its_own_function_wherever_the_turn_starts_and_whatever_the_degree(
    start, degree, derivative
):
    seams = [start + 1.0, start + 4.0]
    branches, made = lines([0.5, -1.0, 2.0], [0.0, 3.0, -1.0], start, seams, degree, derivative)
    rng = np.random.default_rng(3)
    for first, last, line, _ in branches:
        x = rng.uniform(first, last, 50)
        for lap in (-2, 0, 3):
            np.testing.assert_allclose(
                made(x + TWO_PI * lap), line(x) + TWO_PI * degree * lap, rtol=0, atol=1e-13
            )
        slope = line(1.0) - line(0.0)
        np.testing.assert_allclose(
            made.derivative(x), slope, rtol=0, atol=1e-13 if derivative else 1e-9
        )
        base = np.mod(first, TWO_PI)
        lap = np.round((base - first) / TWO_PI)
        np.testing.assert_allclose(
            made(base), line(first) + TWO_PI * degree * lap, rtol=0, atol=1e-13
        )
        np.testing.assert_allclose(made.left(last), line(last), rtol=0, atol=1e-13)
        np.testing.assert_allclose(made.right(first), line(first), rtol=0, atol=1e-13)
    np.testing.assert_allclose(
        made.breaks, np.sort(np.mod([start, *seams], TWO_PI)), rtol=0, atol=1e-14
    )
    one = made.scalar()
    x = rng.uniform(-20, 20, 100)
    np.testing.assert_allclose([one(y) for y in x], made(x), rtol=0, atol=1e-13)


def test_seams_where_value_and_slope_agree_are_no_breaks_and_kinks_are():
    cut = [0.3, 2.0, 5.0, 0.3 + TWO_PI]
    smooth = [(a, b, wavy, wavy_slope) for a, b in pairwise(cut)]
    assert CircleMap.from_branches(smooth).breaks.size == 0
    by_differences = CircleMap.from_branches([(a, b, wavy, None) for a, b in pairwise(cut)])
    assert by_differences.breaks.size == 0
    np.testing.assert_allclose(by_differences(GRID), wavy(GRID), rtol=0, atol=1e-14)
    np.testing.assert_allclose(by_differences.derivative(GRID), wavy_slope(GRID), rtol=0, atol=1e-9)
    bent = (0.0, TWO_PI - 1.0, lambda x: x + 0.1 * x * (TWO_PI - 1 - x), None)
    made = CircleMap.from_branches([(-1.0, 0.0, lambda x: x, None), bent])
    np.testing.assert_allclose(made.breaks, [0.0, TWO_PI - 1.0], atol=1e-14)
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
    assert made.scalar()(3.0 + 7 * TWO_PI) == pytest.approx(1.5 + 7 * TWO_PI, abs=1e-13)


def one(x):
    return x


BAD_BRANCHES = {
    r"is \[\]: give a list .* at least one": [],
    "is 3: give a list": 3,
    r"branch 0 is \(0, 1\)": [(0, 1)],
    "branch 1 starts at 2.5 but branch 0 ends at 2: a gap of 0.5": [
        (0, 2, one, None),
        (2.5, TWO_PI, one, None),
    ],
    "an overlap of 0.25": [(0, 2, one, None), (1.75, TWO_PI, one, None)],
    "a gap of 1e-10": [(0, 2, one, None), (2 + 1e-10, TWO_PI, one, None)],
    "span 6 radians": [(0, 2, one, None), (2, 6, one, None)],
    "span 6.5": [(0, 6.5, one, None)],
    "branch 1 runs from 2 to 1": [(0, 2, one, None), (2, 1, one, None), (1, TWO_PI, one, None)],
    "start of branch 0 must be a finite number, not nan": [(np.nan, 2, one, None)],
    "lift of branch 0 gives .*nan": [(0, TWO_PI, lambda x: np.where(x > 6, np.nan, x), None)],
    "derivative of branch 0 gives float": [(0, TWO_PI, one, lambda x: 1.0)],
    "must be callables": [(0, TWO_PI, 3.0, None)],
    "complex128": [(0, TWO_PI, lambda x: x + 0j, None)],
}


@pytest.mark.parametrize("message", BAD_BRANCHES)
def test_branches_that_do_not_make_one_turn_are_refused_with_the_value_that_is_wrong(message):
    refused(CircleMap.from_branches, BAD_BRANCHES[message], told=message)
