"""Bad requests to the room: each is refused by the name of what is wrong."""

from fractions import Fraction

import numpy as np
import pytest

from cyclemap import maps
from cyclemap.maps import (
    ARNOLD_FAMILY,
    CircleMap,
    DriftingMap,
    LocalNoise,
    ParametricLift,
    SlowZone,
    UniformNoise,
    VonMises,
    WrappedCauchy,
    WrappedNormal,
    transfer_operator,
)
from cyclemap.maps.families.family import break_motion
from tests.maps.known_maps import DOUBLING
from tests.refusals import refused

RIGID, STICKY, NOISE, UNIFORM = (
    CircleMap.rigid(0.1),
    CircleMap.arnold(0.1, 0.9),
    WrappedNormal(0.3),
    UniformNoise(1.0),
)
JUMPING_BACK = CircleMap.from_branches(
    [(0, 3, lambda x: 2 * x, None), (3, 2 * np.pi, lambda x: x, None)]
)
ROTATION = [maps.rotation_number, maps.rotation_interval]
MAP_ALONE = [
    *ROTATION,
    maps.basins,
    maps.slow_passages,
    maps.birkhoff_average,
    maps.lyapunov_exponent,
]
ZONE = SlowZone(1.0, (0.0, 2.0), "ghost", 10.0)
DRIFT = DriftingMap.between([(0, RIGID)])
SUMMARY = maps.predict_staircase(CircleMap.arnold(0.15, 0.9), WrappedNormal(0.1))
ARC = (0.0, 1.0)
NO_WIDTH = (0.0, -1.0, np.nan, np.inf, "wide")


def arnold(omega):
    return CircleMap.arnold(omega, 0.9)


def numbers(*values, **options):
    return maps.rotation_numbers(ARNOLD_FAMILY, *values, **options)


def plane(first, second, family=ARNOLD_FAMILY, **options):
    return maps.rotation_plane(family, first, second, **options)


def operator(circle_map=DOUBLING, noise=NOISE, **options):
    return transfer_operator(circle_map, noise, **options)


def tongue(ratio, within, family=arnold):
    return maps.tongue(family, ratio, within)


@pytest.mark.parametrize("ask", MAP_ALONE)
def test_what_is_no_map_is_refused(ask):
    refused(ask, np.sin, told="CircleMap")


@pytest.mark.parametrize(
    "ask",
    [*ROTATION, maps.upper_envelope, maps.lower_envelope, maps.birkhoff_average, maps.inverse],
)
def test_what_needs_degree_1_refuses_another(ask):
    refused(ask, DOUBLING, told="degree")


@pytest.mark.parametrize("ask", ROTATION)
@pytest.mark.parametrize(("name", "bad"), [("iterates", 0), ("max_period", 0), ("tolerance", -1.0)])
def test_counts_and_tolerances_of_rotation_are_checked(ask, name, bad):
    refused(ask, RIGID, told=name, **{name: bad})


@pytest.mark.parametrize(
    ("law", "name", "bad"),
    [
        *((WrappedNormal, "sigma", bad) for bad in NO_WIDTH),
        *((VonMises, "kappa", bad) for bad in NO_WIDTH),
        *((UniformNoise, "halfwidth", bad) for bad in NO_WIDTH),
        *((WrappedCauchy, "r", bad) for bad in (0.0, 1.0, 1.5, np.nan)),
    ],
)
def test_noise_of_no_width_is_refused(law, name, bad):
    refused(law, bad, told=name)


FAMILIES = [
    (lambda: tongue((2, 4), (-0.5, 1.5)), "lowest terms"),
    (lambda: tongue((1, 0), (-0.5, 1.5)), "lowest terms"),
    (lambda: tongue((1, -3), (-0.5, 1.5)), "lowest terms"),
    (lambda: tongue(0.5, (-0.5, 1.5)), "give a Fraction"),
    (lambda: tongue((1, 2.5), (-0.5, 1.5)), "whole number"),
    (lambda: tongue(0, (0.0, 1.0)), "left edge of the tongue 0 lies below 0"),
    (lambda: tongue(0, (-0.5, 0.05)), r"right edge of the tongue 0 lies above 0\.05"),
    (lambda: tongue(0, (-0.5, 0.5), lambda p: arnold(-p)), "the family falls"),
    (
        lambda: tongue((1, 3), (-0.5, 1.0), lambda p: arnold(p + 0.3 * np.sin(40 * p))),
        "the family falls",
    ),
    (lambda: tongue(0, (-0.5, 0.5), lambda p: DOUBLING), "degree 2"),
    (
        lambda: tongue(0, (-1.0, 1.0), lambda p: p + 1.0),
        r"family\(-1\) is 0\.0: it must return a CircleMap",
    ),
    (lambda: tongue(0, (-1.0, 1.0), 3.0), "give a callable"),
    (lambda: tongue(0, (1.0, 1.0), CircleMap.rigid), "low end must lie below"),
    (lambda: tongue(0, 1.0, CircleMap.rigid), "give a pair"),
    (lambda: tongue(0, (0.0, np.nan), CircleMap.rigid), "finite number"),
    (lambda: maps.tongues(CircleMap.arnold, [], [0.5], (-0.5, 1.5)), "give some of each"),
    (
        lambda: maps.follow_orbit(arnold, 1.0, (0.0, 0.5), at=0.3),
        "no orbit of period 1 and winding 0",
    ),
    (lambda: maps.follow_orbit(arnold, 0.0, (0.0, 0.5), at=0.7), "outside the parameters"),
    (lambda: maps.follow_orbit(arnold, np.nan, (0.0, 0.5)), "start must be a finite number"),
    (lambda: maps.follow_orbit(arnold, 0.0, (0.0, 0.5), period=0), "period must be at least 1"),
    (lambda: maps.follow_orbit(lambda p: p, 0.0, (0.0, 0.5)), "must return a CircleMap"),
    (lambda: maps.follow_orbit(arnold, 2.68, (0.4, 0.6), at=0.5, period=2), "wind 1 times"),
    (lambda: maps.saddle_nodes(arnold, (0.0, 1.0), 0), "period must be at least 1"),
    (lambda: maps.period_doublings(arnold, (1.0, 0.0)), "low end must lie below"),
    (lambda: maps.border_collisions(arnold, (0.0, np.inf)), "finite"),
    (lambda: maps.saddle_nodes(lambda p: CircleMap.rigid(0.0), (0.0, 1.0)), "every point"),
    (lambda: break_motion(np.array([0.01, 1.0, 6.2]), np.array([0.01, 1.0])), "3 and 2 breaks"),
    (lambda: numbers(0.5, [0.3, 1.2]), r"\(0.5, 1.2\).*nondecreasing.*rotation_interval"),
    (
        lambda: maps.rotation_numbers(ParametricLift(lambda x, p: x + p * np.sin(x)), [0.2, 1.5]),
        "nondecreasing",
    ),
    (
        lambda: maps.rotation_numbers(ParametricLift(lambda x, p: 2 * x + p), [0.2]),
        "nondecreasing lift of degree 1",
    ),
    (lambda: maps.rotation_numbers(ParametricLift(lambda x, p: np.zeros(3)), [0.2]), "broadcast"),
    (lambda: maps.rotation_numbers(ParametricLift(lambda x, p: x + 0j), [0.2]), "complex128"),
    (
        lambda: maps.rotation_numbers(ParametricLift(lambda x, p: x + float(p)), [0.2, 0.3]),
        "fails on many angles.*TypeError",
    ),
    (
        lambda: maps.rotation_numbers(ParametricLift(lambda x, p: np.add(x, p, out=x)), [0.2]),
        "leave them as they are",
    ),
    (
        lambda: maps.lyapunov_exponents(
            ParametricLift(lambda x, p: x + p, lambda x, p: np.where(p > 0.5, np.nan, 1.0)),
            [0.2, 0.6],
        ),
        r"at parameters \(0.6\).*nan",
    ),
    (
        lambda: maps.lyapunov_exponents(
            ParametricLift(lambda x, p: x + p, lambda x, p: 1 / 0), [0.2, 0.6]
        ),
        "the derivative fails on many angles.*ZeroDivisionError",
    ),
    (lambda: maps.rotation_numbers(lambda x, p: x + p, 0.1, 0.2), "ParametricLift"),
    (lambda: numbers(0.1, [0.2, np.nan]), "parameter 1 must be finite"),
    (lambda: numbers(), "parameters"),
    (lambda: numbers(0.1, 0.2, tolerance=0.0), "tolerance"),
    (lambda: numbers(0.1, 0.2, tolerance=0.2), "tolerance"),
    (lambda: numbers(0.1, 0.2, threads=0), "threads"),
    (lambda: ParametricLift(None), "lift"),
    (lambda: ParametricLift(np.add, 3.0), "derivative"),
    (lambda: ParametricLift(np.add, max_error=-1.0), "max_error"),
    (lambda: plane([0.1, np.nan], [0.1]), "first_values must be finite"),
    (lambda: plane([0.1], []), "second_values is empty"),
    (lambda: plane([0.1, 0.3, 0.2], [0.1]), "turns back"),
    (lambda: plane([0.1, 0.1], [0.1]), "turns back"),
    (lambda: plane([[0.1]], [0.1]), "axes"),
    (lambda: plane([0.1], [0.1], tolerance=0.2), "tolerance"),
    (lambda: plane([0.1], [0.1], None), "callable"),
    (lambda: plane([0.1], [0.1], lambda p, q: DOUBLING), "degree 1"),
    (lambda: plane([0.1], [0.1], lambda p, q: p + q), "must return a CircleMap"),
    (lambda: maps.orbit_diagram(arnold, []), "empty"),
    (lambda: maps.orbit_diagram(lambda K: K, [1.0]), "CircleMap"),
    (lambda: maps.lyapunov_exponents(CircleMap.arnold), "missing"),
]
ORBITS = [
    (lambda: maps.birkhoff_average(DOUBLING), "degree 2"),
    (lambda: maps.birkhoff_average(RIGID, iterates=15), "iterates"),
    (lambda: maps.birkhoff_average(RIGID, transient=-1), "transient"),
    (lambda: maps.birkhoff_average(RIGID, start=np.nan), "start"),
    (lambda: maps.birkhoff_average(RIGID, lambda x: 1.0), "entry by entry"),
    (lambda: maps.birkhoff_average(RIGID, lambda x: x * np.nan), "finite"),
    (lambda: maps.lyapunov_exponent(RIGID, NOISE, start=1.0), "leave it out"),
    (lambda: maps.lyapunov_exponent(RIGID, start=np.nan), "start"),
    (lambda: maps.basins(RIGID, max_period=0), "max_period"),
    (lambda: maps.basins(RIGID, left_over=0.0), "left_over"),
    (lambda: maps.basins(CircleMap.rigid(0.5), max_period=2), "every point near"),
    (lambda: maps.slow_passages(RIGID, 0), "period"),
    (lambda: maps.periodic_points(np.sin, 1), "CircleMap"),
    *((lambda bad=bad: maps.periodic_points(DOUBLING, bad), "period") for bad in (0, -2, 1.5)),
    (lambda: maps.periodic_points(DOUBLING, 2, 0.5), "winding"),
    (lambda: maps.periodic_points(CircleMap.rigid(0.0), 1), "every point near"),
    (lambda: maps.periodic_points(CircleMap.rigid(2.0), 1), "every point near"),
    (lambda: maps.periodic_points(CircleMap.rigid(0.2), 5), "every point near"),
]
LIFTS = [
    (
        lambda: maps.inverse(CircleMap.blaschke([0, 0])),
        "degree 2: only degree 1 or -1 .* preimages",
    ),
    (
        lambda: maps.inverse(CircleMap.arnold(0.2, 1.5)),
        "turns back on .*branches inverts each monotone piece",
    ),
    (lambda: maps.inverse(JUMPING_BACK), "jumps back by 3 at θ = 3"),
    (lambda: maps.nth_iterate(RIGID, -1), "n must be at least 0"),
    (lambda: maps.shifted(RIGID, 0.5), "turns must be a whole number"),
    (lambda: maps.conjugate(RIGID, np.nan), "angle must be a finite number"),
]
LAWS = [
    (lambda: UniformNoise(0.5).slope(0.1), "uniform noise has no density slope"),
    (lambda: operator(RIGID, VonMises(3.0)).diffusion, "sample_staircases"),
    (lambda: operator(RIGID, UNIFORM).diffusion, "sample_staircases"),
    *((lambda bad=bad: operator(RIGID).spectrum(bad), "k must") for bad in (0, -1, 1.5, None)),
    *((lambda bad=bad: operator(STICKY, bad), "noise") for bad in (None, 0.1, "WrappedNormal")),
    (lambda: operator(STICKY, WrappedNormal(1e-3)), "raise its width"),
    *((lambda bad=bad: operator(STICKY, modes=bad), "modes") for bad in (0, 2.5, 2001)),
    (lambda: operator(STICKY, UNIFORM, modes=10), "modes"),
    (lambda: operator(lambda x: x), "CircleMap"),
    (lambda: operator().rotation_number, "degree"),
    (lambda: operator().diffusion, "degree"),
    (lambda: operator().density([np.nan]), "theta"),
    (lambda: operator().eigenvalues(0), "k must"),
    (lambda: operator().moment(0.5), "n must"),
    (lambda: operator().expectation(lambda theta: np.sum(theta)), "entry"),
    (lambda: operator().expectation(lambda theta: np.full_like(theta, np.inf)), "finite"),
    (lambda: operator().expectation(1.0), "callable"),
]
PASSAGES = [
    *(
        (lambda bad=bad: maps.mean_passage_time(STICKY, NOISE, 0.5, bad), "arc")
        for bad in ((0.0, 7.0), (1.0, 1.0), (0.0, 2 * np.pi), (0.0, np.nan), 3.0, (0, 1, 2))
    ),
    (lambda: maps.mean_passage_time(STICKY, NOISE, 3.0, ARC), "outside the arc"),
    (lambda: maps.mean_passage_time(STICKY, WrappedNormal(1e-4), 0.8, ARC), "raise its width"),
    (lambda: maps.mean_passage_time(STICKY, None, 0.5, ARC), "the noise is None"),
    (lambda: maps.mean_passage_time(STICKY, NOISE, np.nan, ARC), "start"),
    (lambda: maps.hitting_probability(STICKY, NOISE, 0.0, (1.0, 2.0), (1.5, 3.0)), "overlap"),
    (lambda: maps.survival_probabilities(STICKY, NOISE, 3.0, ARC, 5), "outside the arc"),
    (lambda: maps.survival_probabilities(STICKY, UniformNoise(0.3), 0.5, ARC, 5), "jumps"),
    (lambda: maps.survival_probabilities(STICKY, NOISE, 0.5, ARC, -1), "cycles"),
]
NO_MAPS = [
    (lambda ask=ask: ask(None), "the map is None: give a CircleMap")
    for ask in (
        maps.branches,
        maps.inverse,
        maps.is_nondecreasing,
        maps.upper_envelope,
        maps.lower_envelope,
        maps.crossings_by_jump,
        lambda given: maps.preimages(given, 0.0),
        lambda given: maps.compose(given, RIGID),
        lambda given: maps.compose(RIGID, given),
        lambda given: maps.nth_iterate(given, 2),
        lambda given: maps.conjugate(given, 1.0),
        lambda given: maps.shifted(given, 1),
    )
] + [
    (lambda: RIGID.derivative(0.0, 5), "side is 5: give -1, 0 or 1"),
    (lambda: maps.tongues(CircleMap.arnold, 0, [0.4], (-0.5, 0.5)), "ratios is 0"),
    (lambda: maps.tongues(None, [0], [0.4], (-0.5, 0.5)), "family is None"),
]
STAIRCASES = [
    (lambda: maps.sample_staircase(STICKY, None, 0), "cycles"),
    (lambda: maps.sample_staircase(STICKY, None, 2.5), "cycles"),
    (lambda: maps.sample_staircase(STICKY, 0.1, 10), "the noise is 0.1"),
    (lambda: maps.sample_staircase(STICKY, None, 10, start=np.nan), "start"),
    (lambda: maps.sample_staircase(STICKY, None, 10, seed=-1), "seed"),
    (lambda: maps.sample_staircase(lambda x: x, None, 10), "give a CircleMap or a DriftingMap"),
    (lambda: maps.sample_staircases(STICKY, None, 10, []), "starts is empty"),
    (lambda: maps.sample_staircases(STICKY, None, 10, [np.nan]), "starts must be finite"),
    (lambda: maps.predict_staircase(STICKY, None), "the noise is None"),
    (lambda: maps.predict_staircase(DOUBLING, NOISE), "needs degree 1"),
    (lambda: LocalNoise((0.1, 0.2), 0.0), "pairs"),
    (lambda: LocalNoise((0.1,), 1.0), "in .0, 1"),
    (lambda: LocalNoise((0.1,), -0.1), "0, 1"),
    (lambda: DriftingMap.between([(10, RIGID), (10, STICKY)]), "each above the one before"),
    (lambda: DriftingMap(np.array([0.0, 1.0]), (RIGID,)), "give one map a cycle"),
    (lambda: DriftingMap.between([(0, DOUBLING)]), "degree 1"),
    (lambda: DriftingMap.between([]), "at least one"),
    (lambda: DriftingMap.of_family(arnold, np.zeros(10), 20), "one entry for each of 20 cycles"),
    (lambda: DriftingMap.of_family(3, np.zeros(10), 10), "family is 3"),
    (lambda: DRIFT.at(np.nan), "cycle must be a finite number"),
    (lambda: maps.predict_drift(RIGID, NOISE, 100), "give a DriftingMap"),
    (lambda: maps.predict_drift(DRIFT, NOISE, 1), "cycles must be at least 2"),
    (lambda: maps.compare_steps(SUMMARY, maps.find_steps(np.zeros(5))), "in this order"),
    (lambda: maps.find_steps([1.0]), "give 2 cycles at least"),
    (lambda: maps.find_steps([1.0, np.nan, 2.0]), "theta must be finite"),
    (lambda: maps.find_steps(np.zeros((2, 3))), "theta must have 1 axes"),
    (lambda: maps.find_steps(np.zeros(9), zones=[]), "give one SlowZone or more"),
    (lambda: maps.find_steps(np.zeros(9), zones=[ARC]), "give one SlowZone or more"),
    (
        lambda: maps.find_steps(
            np.zeros(9), zones=[ZONE, SlowZone(4.0, (3.0, 5.0), "ghost", 10.0, 1)]
        ),
        "of the same winding",
    ),
]
MANY = 10**11
SIZES = [
    lambda: maps.sample_staircase(STICKY, None, MANY),
    lambda: maps.sample_staircases(STICKY, None, 10**7, np.zeros(10)),
    lambda: maps.orbit_diagram(arnold, [0.1], cycles=MANY),
    lambda: maps.birkhoff_average(STICKY, iterates=MANY),
    lambda: maps.lyapunov_exponent(STICKY, transient=MANY),
    lambda: maps.rotation_number(STICKY, iterates=MANY),
    lambda: maps.survival_probabilities(STICKY, NOISE, 0.5, ARC, MANY),
    lambda: maps.nth_iterate(STICKY, MANY),
    lambda: maps.kneading_sequences(CircleMap.arnold(0.3, 3.0), MANY),
    lambda: maps.rest_multiplier(np.zeros(10**6), last=10**6),
    lambda: maps.bifurcation_curves(CircleMap.arnold, (0.0, 0.3), (0.5, 0.9), lines=MANY),
    lambda: maps.saddle_nodes(arnold, (0.0, 0.3), resolution=MANY),
    lambda: maps.predict_drift(DRIFT, NOISE, 100, points=MANY),
    lambda: maps.predict_drift(DRIFT, NOISE, MANY),
    lambda: maps.kneading_sequences(CircleMap.arnold(0.3, 3.0), 10**6),
    lambda: maps.lyapunov_exponents(CircleMap.arnold, 0.1, 0.9, cycles=MANY),
    lambda: maps.lyapunov_exponents(CircleMap.arnold, 0.1, 0.9, transient=MANY),
    lambda: maps.rotation_numbers(CircleMap.moebius, 0.5, 0.3, tolerance=1 / MANY),
    lambda: maps.rotation_plane(CircleMap.moebius, [0.5], [0.3], 1 / MANY),
    lambda: maps.tongue(arnold, (1, 10**6 + 3), (-0.5, 1.0)),
    lambda: maps.tongues(CircleMap.arnold, [Fraction(1, 2003)], [0.5], (-0.5, 1.0)),
]


@pytest.mark.parametrize("ask", SIZES)
def test_what_would_fill_the_memory_is_refused_before(ask):
    refused(ask, told="of at most")


@pytest.mark.parametrize(
    ("ask", "words"), [*FAMILIES, *ORBITS, *LIFTS, *LAWS, *PASSAGES, *STAIRCASES, *NO_MAPS]
)
def test_bad_requests_are_refused_with_what_is_wrong(ask, words):
    refused(ask, told=words)
