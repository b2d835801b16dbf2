"""Values of the room go through pickle, to other processes, and come back the same."""

import copy
import pickle

import numpy as np
import pytest

from cyclemap import maps
from cyclemap.maps import CircleMap, WrappedNormal
from tests.refusals import refused

ANGLES = np.linspace(-7.0, 9.0, 101)
SINE, FOLDED = CircleMap.arnold(0.1, 0.9), CircleMap.arnold(0.3, 3.0)
SAMPLED = CircleMap.from_samples([0, 1, 2, 3, 6], [0.1, 1.2, 1.9, 3.5, 6.2])


def two_waves(x):
    return x + 0.2 + 0.1 * np.sin(2 * x)


MAPS = {
    "rigid": CircleMap.rigid(0.25),
    "arnold": SINE,
    "moebius": CircleMap.moebius(0.5, 0.3),
    "blaschke": CircleMap.blaschke([0, 0.3j]),
    "samples": SAMPLED,
    "branches": CircleMap.from_branches(
        [(0, np.pi, np.sin, np.cos), (np.pi, 2 * np.pi, np.sin, None)], degree=0
    ),
    "own function": CircleMap(two_waves, max_error=1e-3),
    "composite": maps.compose(SAMPLED, FOLDED),
    "iterate": maps.nth_iterate(SINE, 3),
    "inverse": maps.inverse(SINE),
    "turned": maps.conjugate(SINE, 0.3),
    "shifted": maps.shifted(SINE, 2),
    "upper": maps.upper_envelope(FOLDED),
    "lower": maps.lower_envelope(FOLDED),
    "family": maps.ARNOLD_FAMILY(0.2, 0.3),
    "drifting": maps.DriftingMap.between([(0, SINE), (99, FOLDED)]).at(50),
}


@pytest.mark.parametrize("name", MAPS)
def test_a_map_comes_back_the_same(name):
    given = MAPS[name]
    back = pickle.loads(pickle.dumps(given))
    np.testing.assert_array_equal(back(ANGLES), given(ANGLES))
    np.testing.assert_array_equal(back.derivative(ANGLES), given.derivative(ANGLES))
    np.testing.assert_array_equal(back.breaks, given.breaks)
    assert back.scalar()(1.5) == given.scalar()(1.5)
    for name in ("degree", "max_error", "samples"):
        assert getattr(back, name) == getattr(given, name)
    assert (back.pieces is None) == (given.pieces is None)
    assert copy.copy(given) is given and copy.deepcopy(given) is given


VALUES = {
    "orbits": lambda: maps.periodic_orbits(FOLDED, 2),
    "points": lambda: maps.periodic_points(FOLDED, 3),
    "rotation": lambda: maps.rotation_number(SINE),
    "tongue": lambda: maps.tongue(lambda w: CircleMap.arnold(w, 0.9), 0, (-0.5, 0.5)),
    "basins": lambda: maps.basins(SINE),
    "branches": lambda: maps.branches(FOLDED),
    "exponent": lambda: maps.lyapunov_exponent(SINE),
    "operator": lambda: maps.transfer_operator(SINE, WrappedNormal(0.3)),
    "uniform operator": lambda: maps.transfer_operator(SINE, maps.UniformNoise(1.0)),
    "spectrum": lambda: maps.transfer_operator(SINE, WrappedNormal(0.3)).spectrum(3),
    "staircase": lambda: maps.sample_staircase(SINE, WrappedNormal(0.3), 50, seed=1),
    "summary": lambda: maps.predict_staircase(CircleMap.arnold(0.16, 0.9), WrappedNormal(0.1)),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", VALUES)
def test_results_pickle_too(name):
    given = VALUES[name]()
    back = pickle.loads(pickle.dumps(given))
    assert type(back) is type(given) and len(repr(back)) == len(repr(given))


def test_an_operator_keeps_what_it_has_worked_out():
    operator = maps.transfer_operator(SINE, WrappedNormal(0.3))
    gap = operator.spectral_gap
    back = pickle.loads(pickle.dumps(operator)).spectral_gap
    assert (back, back.error_bound) == (gap, gap.error_bound)


def test_a_lambda_is_refused_by_name():
    bare = CircleMap(lambda x: x + 0.1)
    told = r"cannot be pickled, as <function .*lambda.* def at the top of a module"
    for circle_map in (bare, maps.compose(SINE, bare)):
        refused(pickle.dumps, circle_map, told=told)


def test_a_map_keeps_its_breaks_when_the_array_that_gave_them_changes():
    """A copy in another process is the same map, whatever the caller wrote into the array since."""
    breaks = np.array([0.0])
    given = [
        CircleMap(CircleMap.rigid(0.1), None, breaks),
        CircleMap.with_scalar(np.positive, None, float, breaks=breaks),
        CircleMap.from_pieces(SAMPLED.pieces, breaks, 5),
    ]
    breaks[0] = 2.0
    for circle_map in given:
        back = pickle.loads(pickle.dumps(circle_map))
        assert circle_map.breaks.tolist() == back.breaks.tolist() == [0.0]
