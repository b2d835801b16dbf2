"""Bad requests to the room: each is refused by the name of what is wrong; nobody may write to
results.
"""

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
from cyclemap.maps.families.family import break_motion, parameter_tangent
from tests.maps.known_maps import DOUBLING, lines
from tests.refusals import refused

RIGID, STICKY, FOLDED = (
    CircleMap.rigid(0.1),
    CircleMap.arnold(0.1, 0.9),
    CircleMap.arnold(0.3, 3.0),
)
NOISE, UNIFORM = WrappedNormal(0.3), UniformNoise(1.0)
JUMPING_BACK = lines((0, 3, 0, 2), (3, 2 * np.pi, 0, 1))
ROTATION = [maps.rotation_number, maps.rotation_interval]
ZONE, OTHER = (SlowZone(1.0, (0.0, 2.0), "ghost", 10.0, winding) for winding in (0, 1))
DRIFT = DriftingMap.between([(0, RIGID)])
SUMMARY = maps.predict_staircase(CircleMap.arnold(0.15, 0.9), WrappedNormal(0.1))
ARC = (0.0, 1.0)


def arnold(omega):
    return CircleMap.arnold(omega, 0.9)


def falling(omega):
    return arnold(omega + 0.3 * np.sin(40 * omega))


def numbers(*values, **options):
    return maps.rotation_numbers(ARNOLD_FAMILY, *values, **options)


def along(lift, *values):
    return maps.rotation_numbers(ParametricLift(lift), values)


def exponents(slope):
    return maps.lyapunov_exponents(ParametricLift(lambda x, p: x + p, slope), [0.2, 0.6])


def plane(first, second, family=ARNOLD_FAMILY, **options):
    return maps.rotation_plane(family, first, second, **options)


def operator(circle_map=DOUBLING, noise=NOISE, **options):
    return transfer_operator(circle_map, noise, **options)


def tongue(ratio, within, family=arnold):
    return maps.tongue(family, ratio, within)


def passage(noise=NOISE, start=0.5, arc=ARC):
    return maps.mean_passage_time(STICKY, noise, start, arc)


def staying(noise=NOISE, start=0.5, cycles=5):
    return maps.survival_probabilities(STICKY, noise, start, ARC, cycles)


def each(ask, values, words):
    """One row for each bad value."""
    return [(lambda bad=bad: ask(bad), words) for bad in values]


NO_WIDTH = (0.0, -1.0, np.nan, np.inf, "wide")
LAWS = [
    *each(WrappedNormal, NO_WIDTH, "sigma"),
    *each(VonMises, NO_WIDTH, "kappa"),
    *each(UniformNoise, NO_WIDTH, "halfwidth"),
    *each(WrappedCauchy, (0.0, 1.0, 1.5, np.nan), "r "),
    (lambda: UNIFORM.slope(0.1), "uniform noise has no density slope"),
    (lambda: operator(RIGID, VonMises(3.0)).diffusion, "sample_staircases"),
    (lambda: operator(RIGID, UNIFORM).diffusion, "sample_staircases"),
    *each(operator(RIGID).spectrum, (0, -1, 1.5, None), "k must"),
    *each(lambda noise: operator(STICKY, noise), (None, 0.1, "WrappedNormal"), "noise"),
    (lambda: operator(STICKY, WrappedNormal(1e-3)), "raise its width"),
    *each(lambda modes: operator(STICKY, modes=modes), (0, 2.5, 2001), "modes"),
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
FAMILIES = [
    *each(lambda ratio: tongue(ratio, (-0.5, 1.5)), ((2, 4), (1, 0), (1, -3)), "lowest terms"),
    (lambda: tongue(0.5, (-0.5, 1.5)), "give a Fraction"),
    (lambda: tongue((1, 2.5), (-0.5, 1.5)), "whole number"),
    (lambda: tongue(0, (0.0, 1.0)), "left edge of the tongue 0 lies below 0"),
    (lambda: tongue(0, (-0.5, 0.05)), r"right edge of the tongue 0 lies above 0\.05"),
    (lambda: tongue(0, (-0.5, 0.5), lambda p: arnold(-p)), "the family falls"),
    (lambda: tongue((1, 3), (-0.5, 1.0), falling), "the family falls"),
    (lambda: tongue(0, (-0.5, 0.5), lambda p: DOUBLING), "degree 2"),
    (lambda: tongue(0, (-1.0, 1.0), float), r"family\(-1\) is -1\.0: it must return a CircleMap"),
    (lambda: tongue(0, (-1.0, 1.0), 3.0), "give a callable"),
    (lambda: tongue(0, (1.0, 1.0), CircleMap.rigid), "low end must lie below"),
    (lambda: tongue(0, 1.0, CircleMap.rigid), "give a pair"),
    (lambda: tongue(0, (0.0, np.nan), CircleMap.rigid), "finite number"),
    (lambda: maps.tongues(CircleMap.arnold, [], [0.5], (-0.5, 1.5)), "give some of each"),
    (lambda: maps.tongues(CircleMap.arnold, 0, [0.4], (-0.5, 0.5)), "ratios is 0"),
    (lambda: maps.tongues(CircleMap.arnold, np.array(3.0), [0.4], ARC), "give a sequence"),
    (lambda: maps.tongues(None, [0], [0.4], (-0.5, 0.5)), "family is None"),
    (lambda: maps.follow_orbit(arnold, 1.0, ARC, at=0.3), "no orbit of period 1 and winding 0"),
    (lambda: maps.follow_orbit(arnold, 0.0, (0.0, 0.5), at=0.7), "outside the parameters"),
    (lambda: maps.follow_orbit(arnold, np.nan, (0.0, 0.5)), "start must be a finite number"),
    (lambda: maps.follow_orbit(arnold, 0.0, (0.0, 0.5), period=0), "period must be at least 1"),
    (lambda: maps.follow_orbit(lambda p: p, 0.0, (0.0, 0.5)), "must return a CircleMap"),
    (lambda: maps.follow_orbit(arnold, 2.68, (0.4, 0.6), at=0.5, period=2), "wind 1 times"),
    (lambda: maps.saddle_nodes(arnold, (0.0, 1.0), 0), "period must be at least 1"),
    (lambda: maps.period_doublings(arnold, (1.0, 0.0)), "low end must lie below"),
    (lambda: maps.border_collisions(arnold, (0.0, np.inf)), "finite"),
    (lambda: maps.saddle_nodes(lambda p: CircleMap.rigid(0.0), (0.0, 1.0)), "every point"),
    (lambda: maps.bifurcation_curves(None, (0.02, 0.3), (0.5, 0.9)), "family is None"),
    (lambda: break_motion(np.array([0.01, 1.0, 6.2]), np.array([0.01, 1.0])), "3 and 2 breaks"),
    (lambda: numbers(0.5, [0.3, 1.2]), r"\(0.5, 1.2\).*nondecreasing.*rotation_interval"),
    (lambda: numbers([0.1, 0.2], [0.3, 0.4, 0.5]), "broadcast"),
    *each(lambda given: numbers(*given), ([0.1], [0.1] * 3), r"\d parameters are given, .*omega"),
    (lambda: maps.lyapunov_exponents(ARNOLD_FAMILY, [0.1]), r"\d parameters are given, .*omega"),
    (lambda: along(lambda x, p: x + p * np.sin(x), 0.2, 1.5), "nondecreasing"),
    (lambda: along(lambda x, p: 2 * x + p, 0.2), "nondecreasing lift of degree 1"),
    (lambda: along(lambda x, p: np.zeros(3), 0.2), "broadcast"),
    (lambda: along(lambda x, p: x + 0j, 0.2), "complex128"),
    (lambda: along(lambda x, p: x + float(p), 0.2, 0.3), "fails on many angles.*TypeError"),
    (lambda: along(lambda x, p: np.add(x, p, out=x), 0.2), "leave them as they are"),
    (lambda: exponents(lambda x, p: np.where(p > 0.5, np.nan, 1)), r"at parameters \(0.6\).*nan"),
    (lambda: exponents(lambda x, p: 1 / 0), "the derivative fails on many angles.*ZeroDivision"),
    (lambda: maps.rotation_numbers(lambda x, p: x + p, 0.1, 0.2), "ParametricLift"),
    (lambda: numbers(0.1, [0.2, np.nan]), "parameter 1 must be finite"),
    (lambda: numbers(), "parameters"),
    *each(lambda tolerance: numbers(0.1, 0.2, tolerance=tolerance), (0.0, 0.2), "tolerance"),
    (lambda: numbers(0.1, 0.2, threads=0), "threads"),
    (lambda: ParametricLift(None), "lift"),
    (lambda: ParametricLift(np.add, 3.0), "derivative"),
    (lambda: ParametricLift(np.add, max_error=-1.0), "max_error"),
    (lambda: plane([0.1, np.nan], [0.1]), "first_values must be finite"),
    (lambda: plane([0.1], []), "second_values is empty"),
    *each(lambda first: plane(first, [0.1]), ([0.1, 0.3, 0.2], [0.1, 0.1]), "turns back"),
    (lambda: plane([[0.1]], [0.1]), "axes"),
    (lambda: plane([0.1], [0.1], tolerance=0.2), "tolerance"),
    (lambda: plane([0.1], [0.1], None), "callable"),
    (lambda: plane([0.1], [0.1], lambda p, q: DOUBLING), "degree 1"),
    (lambda: plane([0.1], [0.1], lambda p, q: p + q), "must return a CircleMap"),
    (lambda: plane([0.1], [0.2], ParametricLift(lambda x, p: x + p)), "2 parameters are given"),
    (lambda: maps.orbit_diagram(arnold, []), "empty"),
    (lambda: maps.orbit_diagram(lambda K: K, [1.0]), "CircleMap"),
    (lambda: maps.lyapunov_exponents(CircleMap.arnold), "missing"),
]
NEED_DEGREE_ONE = (
    *(*ROTATION, maps.upper_envelope, maps.lower_envelope),
    *(maps.birkhoff_average, maps.inverse),
)
ORBITS = [
    *((lambda ask=ask: ask(DOUBLING), "degree") for ask in NEED_DEGREE_ONE),
    *((lambda ask=ask: ask(RIGID, iterates=0), "iterates") for ask in ROTATION),
    *((lambda ask=ask: ask(RIGID, max_period=0), "max_period") for ask in ROTATION),
    *((lambda ask=ask: ask(RIGID, tolerance=-1.0), "tolerance") for ask in ROTATION),
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
    *each(lambda period: maps.periodic_points(DOUBLING, period), (0, -2, 1.5), "period"),
    (lambda: maps.periodic_points(DOUBLING, 2, 0.5), "winding"),
    (lambda: maps.periodic_points(STICKY, 10**400), "the period: above 1e300"),
    *each(
        lambda given: maps.periodic_points(CircleMap.rigid(given[0]), given[1]),
        ((0.0, 1), (2.0, 1), (0.2, 5)),
        "every point near",
    ),
]
LIFTS = [
    (lambda: maps.inverse(DOUBLING), "degree 2: only degree 1 or -1 .* preimages"),
    (lambda: maps.inverse(FOLDED), "turns back on .*branches inverts each monotone piece"),
    (lambda: maps.inverse(JUMPING_BACK), "jumps back by 3 at θ = 3"),
    (lambda: maps.nth_iterate(RIGID, -1), "n must be at least 0"),
    (lambda: maps.shifted(RIGID, 0.5), "turns must be a whole number"),
    (lambda: maps.conjugate(RIGID, np.nan), "angle must be a finite number"),
    (lambda: RIGID.derivative(0.0, 5), "side is 5: give -1, 0 or 1"),
]
NO_ARC = ((0.0, 7.0), (1.0, 1.0), (0.0, 2 * np.pi), (0.0, np.nan), 3.0, (0, 1, 2))
PASSAGES = [
    *each(lambda arc: passage(arc=arc), NO_ARC, "arc"),
    (lambda: passage(start=3.0), "outside the arc"),
    (lambda: passage(WrappedNormal(1e-4), 0.8), "raise its width"),
    (lambda: passage(None), "the noise is None"),
    (lambda: passage(start=np.nan), "start"),
    (lambda: maps.hitting_probability(STICKY, NOISE, 0.0, (1.0, 2.0), (1.5, 3.0)), "overlap"),
    (lambda: staying(start=3.0), "outside the arc"),
    (lambda: staying(UniformNoise(0.3)), "jumps"),
    (lambda: staying(cycles=-1), "cycles"),
]
ASKED_OF_A_MAP = (
    *(*ROTATION, maps.basins, maps.slow_passages, maps.birkhoff_average, maps.lyapunov_exponent),
    *(maps.branches, maps.inverse, maps.is_nondecreasing, maps.crossings_by_jump),
    *(maps.upper_envelope, maps.lower_envelope, lambda given: maps.preimages(given, 0.0)),
    *(lambda given: maps.compose(given, RIGID), lambda given: maps.compose(RIGID, given)),
    *(lambda given: maps.nth_iterate(given, 2), lambda given: maps.conjugate(given, 1.0)),
    *(lambda given: maps.shifted(given, 1), lambda given: maps.periodic_points(given, 1)),
)
NO_MAPS = [
    (lambda ask=ask: ask(None), "the map is None: give a CircleMap") for ask in ASKED_OF_A_MAP
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
    (lambda: maps.find_steps(np.arange(9.0), zones=3.0), "zones is 3.0"),
    (lambda: maps.find_steps(np.zeros(9), zones=[]), "give one SlowZone or more"),
    (lambda: maps.find_steps(np.zeros(9), zones=[ARC]), "give one SlowZone or more"),
    (lambda: maps.find_steps(np.zeros(9), zones=[ZONE, OTHER]), "of the same winding"),
]
MANY = 10**11
SIZES = [
    lambda: maps.sample_staircase(STICKY, None, MANY),
    lambda: maps.sample_staircases(STICKY, None, 10**7, np.zeros(10)),
    lambda: maps.orbit_diagram(arnold, [0.1], cycles=MANY),
    lambda: maps.birkhoff_average(STICKY, iterates=MANY),
    lambda: maps.lyapunov_exponent(STICKY, transient=MANY),
    lambda: maps.rotation_number(STICKY, iterates=MANY),
    lambda: staying(cycles=MANY),
    lambda: maps.nth_iterate(STICKY, MANY),
    lambda: maps.kneading_sequences(FOLDED, MANY),
    lambda: maps.rest_multiplier(np.zeros(10**6), last=10**6),
    lambda: maps.bifurcation_curves(CircleMap.arnold, (0.0, 0.3), (0.5, 0.9), lines=MANY),
    lambda: maps.saddle_nodes(arnold, (0.0, 0.3), resolution=MANY),
    lambda: maps.predict_drift(DRIFT, NOISE, 100, points=MANY),
    lambda: maps.predict_drift(DRIFT, NOISE, MANY),
    lambda: maps.kneading_sequences(FOLDED, 10**6),
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


@pytest.mark.parametrize("period", [10**6, 10**30])
def test_huge_periods_are_refused_at_once(period):
    told = r"the period: 1e\+.*give a smaller one"
    for ask in (maps.periodic_points, maps.periodic_orbits):
        for proved in (False, True):
            refused(ask, STICKY, period, proved=proved, told=told)
    period //= 100  # of a family's orbits fewer are allowed
    for ask in (maps.bifurcations, maps.orbit_branches, maps.saddle_nodes):
        refused(ask, arnold, (0.0, 0.3), period, told=told)
    refused(maps.follow_orbit, arnold, 0.3, (0.0, 0.3), period=period, told=told)
    refused(maps.bifurcation_curves, CircleMap.arnold, (0.02, 0.3), (0.5, 0.9), period, told=told)


def test_results_cannot_be_written_to():
    spectrum = operator(STICKY).spectrum(3)
    edges = maps.tongues(CircleMap.arnold, [0], [0.4], (-0.5, 0.5))
    branch = maps.follow_orbit(arnold, 0.7, (0.05, 0.1))
    tangent = parameter_tangent(arnold, 0.1, 1e-3, (0.0, 0.2))
    for array in (
        *(spectrum.values, spectrum.error_bounds, spectrum.condition),
        *(spectrum.right, spectrum.left, edges.folded, branch.stable),
        *(*tangent.motions, tangent.break_rates),
    ):
        assert not array.flags.writeable
