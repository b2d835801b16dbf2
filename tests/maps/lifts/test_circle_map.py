"""CircleMap: lifts, breaks, one-sided limits, differences, samples, branches, what is refused."""

import math
from itertools import pairwise

import numpy as np
import pytest

from cyclemap.maps import CircleMap, inverse
from tests.maps.known_maps import TWO_PI, agree, lines, wavy, wavy_slope
from tests.refusals import refused

GRID = np.linspace(-15.0, 15.0, 3001)
TEXTBOOK = {
    "rigid": CircleMap.rigid(0.3),
    "arnold": CircleMap.arnold(0.2, 0.7),
    "folded": CircleMap.arnold(0.2, 2.5),
    "moebius": CircleMap.moebius(0.6, 0.2),
}


def sampled(count=300, start=0.0, slopes=True):
    x = start + np.linspace(0, TWO_PI, count, endpoint=False)
    return CircleMap.from_samples(x, wavy(x), wavy_slope(x) if slopes else None)


@pytest.mark.parametrize("exact", TEXTBOOK.values(), ids=TEXTBOOK)
def test_textbook_lifts_climb_by_a_turn_and_agree_with_their_scalar_forms_and_differences(exact):
    np.testing.assert_allclose(exact(GRID + TWO_PI) - exact(GRID), TWO_PI, rtol=1e-13)
    np.testing.assert_array_equal(exact.turn(GRID), exact(GRID) - GRID)
    agree([exact.scalar()(x) for x in GRID[::50]], exact(GRID[::50]), 1e-14)
    x = GRID[np.abs(GRID) < TWO_PI]
    agree(CircleMap(exact).derivative(x), exact.derivative(x), 2e-10)


@pytest.mark.parametrize("start", [0.0, 1.3, -9.0, TWO_PI])
def test_hermite_samples_converge_at_fourth_order_wherever_they_start(start):
    errors = [np.max(np.abs(sampled(n, start)(GRID) - wavy(GRID))) for n in (50, 100, 200)]
    assert errors[2] < 2e-8
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 3.8)


def test_slopes_left_out_still_interpolate_and_keep_monotone_data_monotone():
    made = sampled(200, slopes=False)
    assert np.max(np.abs(made(GRID) - wavy(GRID))) < 2e-5
    assert made.breaks.size == 0
    x = np.array([0.0, 1.0, 1.5, 2.0, 4.0, 6.0])
    steps = CircleMap.from_samples(x, np.array([0.0, 0.1, 2.5, 2.6, 2.61, 6.0]))
    assert np.all(np.diff(steps(np.linspace(0, TWO_PI, 4001))) >= -1e-15)


def test_a_repeated_angle_is_a_jump_kept_on_both_sides_or_a_kink():
    y = np.array([0.5, 1.2, 1.8, 2.6, 3.4, 5.2])
    made = CircleMap.from_samples([0.0, 1.0, 2.0, 2.0, 3.0, 5.0], y, np.full(6, 0.7))
    at, left, right = made.jumps()
    agree([at[0], left[0], right[0], made(2.0)], [2.0, 1.8, 2.6, 2.6], 1e-13)
    agree(made.left(2.0 - 2 * TWO_PI), 1.8 - 2 * TWO_PI, 1e-13)
    assert made.samples == 6
    x = np.array([0.0, 2.0, 2.0, 4.0])
    kinked = CircleMap.from_samples(x, x, [1.0, 0.5, 1.5, 1.0])
    assert kinked.breaks.tolist() == [2.0] and kinked.jumps()[0].size == 0
    agree([kinked.derivative(2.0, -1), kinked.derivative(2.0, 1)], [0.5, 1.5], 1e-12)


@pytest.mark.parametrize("start", [0.0, 0.7])
def test_an_end_point_that_does_not_close_makes_a_break_at_the_start(start):
    x = start + np.linspace(0, TWO_PI, 20)
    made = CircleMap.from_samples(x, 0.5 * x + 1, np.full(20, 0.5))
    agree(made.breaks, [start], 1e-14)
    agree(made.right(start) - made.left(start), 0.5 * TWO_PI, 1e-12)
    repeated = np.append(x[0], x[:-1])
    values = np.append(0.5 * x[-1] + 1 - TWO_PI, 0.5 * x[:-1] + 1)
    agree(CircleMap.from_samples(repeated, values, np.full(20, 0.5))(GRID), made(GRID), 1e-12)
    x = np.linspace(0, TWO_PI, 80)  # one that closes makes none
    assert CircleMap.from_samples(x, wavy(x), wavy_slope(x)).breaks.size == 0


def test_shape_preserving_branches_run_through_the_end_point():
    x = np.concatenate([np.linspace(0.2, 3.0, 60), np.linspace(3.0, 0.1 + TWO_PI, 60)])
    ahead = 0.5 * (x - 0.2 - TWO_PI) * (x < 0.2 + TWO_PI) * (np.arange(120) >= 60)
    made = CircleMap.from_samples(x, wavy(x) + ahead)
    assert made.breaks.tolist() == [3.0]
    assert abs(np.diff(made.derivative([0.2 - 1e-7, 0.2 + 1e-7]))[0]) < 1e-4


def test_differences_never_reach_across_a_break():
    upper = (TWO_PI - 1.0) / (TWO_PI - 2.0)

    def kinked(x):
        base = np.mod(x, TWO_PI)
        return x - base + np.where(base < 2.0, 0.5 * base, 1.0 + (base - 2.0) * upper)

    made = CircleMap(kinked, breaks=[0.0, 2.0])
    x = np.array([0.0, 1e-9, 1e-4, 1.0, 2.0 - 1e-4, 2.0 - 1e-9, 2.0, 2.0 + 1e-4, 6.0])
    agree(made.derivative(x), [0.5] * 6 + [upper] * 3, 1e-9)


def jumping(x):
    return TWO_PI * np.floor(x / TWO_PI) + np.mod(x + 2, TWO_PI)


def identity(x):
    return x


NOT_A_LIFT = {
    "is degree 1": lambda: CircleMap(lambda x: x + 0.1 * np.sin(x), degree=2),
    "not wrapped": lambda: CircleMap(lambda x: np.mod(x + 1, TWO_PI)),
    "jumps by 6.28": lambda: CircleMap(jumping),
    "jumps by 6.28.* none of its breaks": lambda: CircleMap(
        lambda x: np.mod(x + 1, TWO_PI), degree=0
    ),
    "nan at": lambda: CircleMap(lambda x: np.where(np.cos(x) > 0.9, np.nan, x)),
    "inf at": lambda: CircleMap(identity, lambda x: np.where(np.cos(x) > 0.9, np.inf, 1.0)),
    "complex128": lambda: CircleMap(lambda x: x + 0j),
    "int64": lambda: CircleMap(lambda x: np.floor(x).astype(np.int64)),
    "float32": lambda: CircleMap(lambda x: x.astype(np.float32)),
    "object": lambda: CircleMap(lambda x: x.astype(object)),
    "gives list": lambda: CircleMap(lambda x: x.tolist()),
    "gives float for": lambda: CircleMap(lambda x: 1.0),
    r"into \(1,\)": lambda: CircleMap(lambda x: np.ravel(x)[:1]),
    "must be vectorised": lambda: CircleMap(lambda x: math.sin(x) + x),
    "depending on the other entries": lambda: CircleMap(lambda x: x - x.mean() * (x.ndim == 2)),
    "leave its argument as it is": lambda: CircleMap(lambda x: np.add(x, 1.0, out=x)),
    "derivative gives .* not that of this lift": lambda: CircleMap(
        lambda x: x + 0.3 * np.sin(x), lambda x: 1 - 0.3 * np.cos(x)
    ),
    "derivative turns shape": lambda: CircleMap(identity, lambda x: np.ones(3)),
    "scalar form differs from the lift by": lambda: CircleMap.with_scalar(
        identity, None, lambda x: x + 1e-3
    ),
    "scalar form fails": lambda: CircleMap.with_scalar(identity, None, lambda x: "x"),
    "degree must be": lambda: CircleMap(identity, degree=0.5),
    "it must be finite everywhere": lambda: CircleMap(lambda x: x * np.nan),
    "must be callables": lambda: CircleMap(3.0),
    "breaks must be finite": lambda: CircleMap(identity, breaks=[np.nan]),
    "max_error must not be negative": lambda: CircleMap(identity, max_error=-1.0),
    "omega must be a finite": lambda: CircleMap.arnold(np.nan, 0.1),
    "a is 1": lambda: CircleMap.moebius(1.0, 0.1),
    "a is -0.5.*blaschke": lambda: CircleMap.moebius(-0.5, 0.0),
    "theta must be finite": lambda: CircleMap.from_samples([0, 1, np.nan], [0, 1, 2]),
    "theta decreases after": lambda: CircleMap.from_samples([0, 2, 1], [0, 1, 2]),
    "must cover one turn": lambda: CircleMap.from_samples([0, 3, 7], [0, 3, 7]),
    "three times": lambda: CircleMap.from_samples([0, 1, 1, 1, 2], [0, 1, 1, 1, 2]),
    "radians apart": lambda: CircleMap.from_samples([0, 1e-300, 1, 2], [0, 1e-300, 1, 2.1]),
    "must have as many": lambda: CircleMap.from_samples([0, 1, 2], [0, 1]),
    "at least 3": lambda: CircleMap.from_samples([0, 1], [0, 1]),
    "must have 1 axes": lambda: CircleMap.from_samples([[0, 1, 2]], [[0, 1, 2]]),
    r"shape \(0,\)": lambda: CircleMap.blaschke([]),
    r"zeros\[0\] is 1": lambda: CircleMap.blaschke([1.0]),
    r"zeros\[1\] is 0.8\+0.7j": lambda: CircleMap.blaschke([0.1, 0.8 + 0.7j]),
    r"zeros\[1\] is nan": lambda: CircleMap.blaschke([0.1, np.nan]),
    r"shape \(\)": lambda: CircleMap.blaschke(0.5),
    "complex numbers only": lambda: CircleMap.blaschke(["a"]),
}


@pytest.mark.parametrize("message", NOT_A_LIFT)
def test_the_refusal_names_what_is_wrong_with_the_lift(message):
    refused(NOT_A_LIFT[message], told=message)


@pytest.mark.parametrize("breaks", [[], [0.5]])
def test_a_lift_that_writes_to_its_argument_leaves_later_maps_as_they_are(breaks):
    refused(CircleMap, lambda x: np.add(x, 1.0, out=x), breaks=breaks, told="leave its argument")
    assert float(CircleMap(lambda x: x + np.sin(x))(0.5 * np.pi)) == 0.5 * np.pi + 1.0


def test_a_jump_of_many_radians_is_taken_where_it_is_a_break_and_steep_lifts_are_no_jumps():
    assert CircleMap(jumping, breaks=[0.0, TWO_PI - 2]).jumps()[0].size == 2
    assert CircleMap.moebius(1 - 1e-9, 0.3).derivative(0.0) > 1e9
    steep = 2.0**30
    assert CircleMap(lambda x: steep * x, lambda x: steep + 0 * x, degree=2**30).degree == 2**30


def test_a_tiny_negative_break_is_a_break_at_zero():
    assert CircleMap(identity, breaks=[-1e-17, TWO_PI, 2 * TWO_PI]).breaks.tolist() == [0.0]


def test_a_map_never_changes():
    made = sampled()
    with pytest.raises(AttributeError):
        made.degree = 2
    with pytest.raises(ValueError, match="read-only"):
        made.pieces.knots[0] = 1.0


@pytest.mark.parametrize("seed", range(5))
def test_a_blaschke_product_is_the_product_of_its_factors_and_its_slope_the_sum_of_poisson_kernels(
    seed,
):
    rng, omega = np.random.default_rng(seed), 0.1 * seed
    zeros = rng.uniform(0, 0.95, seed + 1) * np.exp(1j * rng.uniform(0, TWO_PI, seed + 1))
    made = CircleMap.blaschke(zeros, omega)
    z = np.exp(1j * GRID)
    factors = [(z - a) / (1 - np.conj(a) * z) for a in zeros]
    turned = np.exp(2j * np.pi * omega) * np.prod(factors, axis=0)
    agree(np.exp(1j * made(GRID)), turned, 3e-13)
    kernels = np.sum([(1 - abs(a) ** 2) / np.abs(z - a) ** 2 for a in zeros], axis=0)
    np.testing.assert_allclose(made.derivative(GRID), kernels, rtol=3e-13)
    np.testing.assert_allclose(made(GRID + TWO_PI) - made(GRID), TWO_PI * zeros.size, rtol=1e-12)
    assert made.degree == zeros.size
    agree([made.scalar()(x) for x in GRID[::50]], made(GRID[::50]), 3e-14)


def test_one_real_zero_is_the_moebius_map_and_zeros_at_the_origin_multiply_the_angle_exactly():
    for a, omega in [(0.0, 0.3), (0.95, 0.77)]:
        agree(CircleMap.blaschke([a], omega)(GRID), CircleMap.moebius(a, omega)(GRID), 4e-15)
    assert np.array_equal(CircleMap.blaschke([0, 0])(GRID), 2 * GRID)
    assert np.array_equal(CircleMap.blaschke([0, 0, 0j]).derivative(GRID), np.full(GRID.size, 3.0))


def test_a_zero_close_to_the_circle_costs_no_digits():
    """Against tan(F/2) = (1 + a)/(1 - a)·tan(θ/2), which is exact for Ω = 0."""
    a = 1 - 2.0**-30
    made, x = CircleMap.moebius(a, 0.0), np.array([1e-12, 1e-10, 1e-9, 3e-9, 1e-6, 0.1, 2.0])
    np.testing.assert_allclose(
        made(x), 2 * np.arctan((1 + a) / (1 - a) * np.tan(x / 2)), rtol=4e-15
    )
    assert made.derivative(0.0) == (1 + a) / (1 - a)


@pytest.mark.parametrize("step", [1e-9, 1e-3])
def test_a_jump_however_small_is_one_and_one_back_leaves_no_inverse(step):
    """Up at 3 it jumps back at 0, and the other way round."""
    for jump in (step, -step):
        stepped = CircleMap(
            lambda x, by=jump: x + 0.3 + by * (np.mod(x, TWO_PI) >= 3.0), breaks=[0.0, 3.0]
        )
        at, left, right = stepped.jumps()
        agree(at, [0.0, 3.0], 0.0)
        agree(right - left, [-jump, jump], 1e-13)
        refused(inverse, stepped, told="jumps back")


def test_a_given_derivative_is_off_by_rounding_alone_and_that_is_stated():
    theta = np.linspace(0.0, TWO_PI, 5001)
    slope, error = CircleMap.arnold(0.1, 0.9).derivative_and_error(theta)
    strength = np.longdouble(0.9)
    off = np.abs(slope - (1 - strength * np.cos(theta.astype(np.longdouble))))
    assert np.all(off <= error) and np.all(error < 1e-14)
    assert np.any(off > 0.0)


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


def joined(*ends):
    return [(a, b, identity, None) for a, b in zip(ends[::2], ends[1::2], strict=True)]


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
    "derivative of branch 0 gives float": [(0, TWO_PI, identity, lambda x: 1.0)],
    "must be callables": [(0, TWO_PI, 3.0, None)],
    "complex128": [(0, TWO_PI, lambda x: x + 0j, None)],
}


@pytest.mark.parametrize("message", BAD_BRANCHES)
def test_branches_that_do_not_make_one_turn_are_refused_with_the_value_that_is_wrong(message):
    refused(CircleMap.from_branches, BAD_BRANCHES[message], told=message)
