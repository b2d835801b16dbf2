"""Metastable sets: brute force over all cuts, equal wells, Monte Carlo, limits for every chain, none for rotations."""

from itertools import combinations

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import (
    CircleMap,
    UniformNoise,
    WrappedNormal,
    fixed_points,
    mean_passage_time,
    metastable_sets,
    transfer_operator,
)
from cyclemap.maps.operator.metastable_sets import StationaryFlow, best_cuts, leaving_chances
from cyclemap.maps.passages.killed_chain import killed_chain

TWO_PI = 2 * np.pi


def wells(count, tilt=0.0, drift=0.0):
    """``count`` stable zones; a first harmonic and a drift make them unlike, the drift also irreversible."""
    depth = 0.8 / count
    return CircleMap(
        lambda x: x + drift - depth * np.sin(count * x) + tilt * np.cos(x),
        lambda x: 1 - 0.8 * np.cos(count * x) - tilt * np.sin(x),
    )


def random_flow(size, seed):
    """The stationary flow of a random, irreversible chain."""
    moves = np.random.default_rng(seed).exponential(size=(size, size)) ** 3
    moves /= moves.sum(axis=1, keepdims=True)
    values, vectors = np.linalg.eig(moves.T)
    law = np.real(vectors[:, np.argmax(np.real(values))])
    return (law / law.sum())[:, None] * moves


def leaving(flow, cells):
    outside = np.setdiff1d(np.arange(flow.shape[0]), cells)
    return flow[np.ix_(cells, outside)].sum() / flow[cells].sum()


def total_leaving(flow, cuts):
    arcs = np.split(np.roll(np.arange(flow.shape[0]), -cuts[0]), np.asarray(cuts[1:]) - cuts[0])
    return sum(leaving(flow, arc) for arc in arcs)


def test_chances_of_leaving_every_arc_are_sums_over_the_flow():
    flow, judged = random_flow(9, 1), 0
    chances = leaving_chances(flow)
    for start in range(9):
        for length in range(1, 10):
            arc = (start + np.arange(length)) % 9
            expected = leaving(flow, arc) if length < 9 else 0.0
            assert chances[start, length - 1] == pytest.approx(expected, rel=1e-12)
            judged += 1
    assert judged == 81


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 3, 4, 5])
def test_the_cuts_are_the_best_of_all(count):
    """Against every choice of cuts on 10 cells, for random irreversible chains."""
    for seed in range(3):
        flow = random_flow(10, 10 * count + seed)
        found = best_cuts(leaving_chances(flow), count)
        least = min(total_leaving(flow, cuts) for cuts in combinations(range(10), count))
        assert len(set(found)) == count
        assert total_leaving(flow, found) == pytest.approx(least, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(("count", "sigma"), [(2, 0.3), (2, 0.1), (3, 0.2)])
def test_equal_wells_are_cut_at_their_unstable_points_into_equal_sets(count, sigma):
    found = metastable_sets(wells(count), WrappedNormal(sigma))
    assert found.metastable and found.arcs.shape == (count, 2)
    unstable = np.sort([float(p.points[0]) for p in fixed_points(wells(count)) if not p.stable])
    np.testing.assert_allclose(found.arcs[:, 0], unstable, atol=1e-6)
    np.testing.assert_allclose(found.weights, 1 / count, rtol=1e-10)
    np.testing.assert_allclose(found.leaving, found.leaving[0], rtol=1e-9)
    assert found.relative_error < 1e-11


def test_a_mirrored_pair_of_wells_flips_with_the_second_eigenvalue():
    """For two equal sets that relax at once the chain of sets is the whole slow dynamics: 1 - λ₂ is near 2·leaving."""
    found = metastable_sets(wells(2), WrappedNormal(0.2))
    ratio = (1 - abs(found.eigenvalues[1])) / (2 * found.leaving[0])
    assert 0.3 < ratio <= 1.0  # re-crossings count as leaving, but not as relaxation


def test_unlike_wells_of_an_irreversible_chain():
    """Global optimum, flows, weights and limits for a map that drifts round; weights and flows against the operator."""
    noise, one = WrappedNormal(0.3), wells(2, 0.1, 0.05)
    found, law = metastable_sets(one, noise), transfer_operator(one, noise)
    assert found.metastable and len(found.arcs) == 2
    np.testing.assert_allclose(found.transitions.sum(axis=1), 1, rtol=1e-14)
    np.testing.assert_allclose(found.weights @ found.transitions, found.weights, rtol=1e-11)
    x, w = np.polynomial.legendre.leggauss(120)
    for (low, high), weight, stay in zip(found.arcs, found.weights, found.staying, strict=True):
        theta, half = low + 0.5 * (high - low) * (1 + x), 0.5 * (high - low)
        mass = half * w * law.density(theta)
        assert mass.sum() == pytest.approx(weight, rel=1e-10)
        kept = mass @ noise.arc_probability(low - one(theta), high - one(theta)) / weight
        assert kept == pytest.approx(stay, rel=1e-10)
    np.testing.assert_allclose(found.residence_cycles, 1 / found.leaving)


@pytest.mark.slow
def test_no_cuts_nearby_or_far_are_better():
    """Moving the cuts at random, a little or anywhere, never lowers the chances of leaving."""
    noise, rng = WrappedNormal(0.3), np.random.default_rng(4)
    one = wells(2, 0.1, 0.05)
    flow = StationaryFlow.of(killed_chain(one, noise, ((0.0, TWO_PI),), (), False))
    for count in (2, 3):
        found = metastable_sets(one, noise, count, cells=96)
        best = found.leaving.sum()
        for scale in (1e-4, 1e-2, 3.0):
            for _ in range(6):
                cuts = np.sort(np.mod(found.arcs[:, 0] + rng.normal(0, scale, count), TWO_PI))
                moves = flow.between_arcs(cuts)[1]
                assert np.sum(moves[~np.eye(count, dtype=bool)]) >= best * (1 - 1e-10)


def test_very_deep_wells_keep_the_digits_of_their_chances():
    """At 1e-35 a cycle the weights' ratio is the ratio of passage times (detailed balance of two sets)."""
    found = metastable_sets(wells(2, 0.02), WrappedNormal(0.1))
    assert found.metastable and np.max(found.leaving) < 1e-25
    flow = found.weights * found.leaving
    assert flow[0] == pytest.approx(flow[1], rel=1e-9)
    points = [float(p.points[0]) for p in fixed_points(wells(2, 0.02)) if p.stable]
    times = {}
    for point in points:
        low, high = found.arcs[found.index(point)]
        inside = low + np.mod(point - low, TWO_PI)
        times[int(found.index(point))] = mean_passage_time(wells(2, 0.02), WrappedNormal(0.1), inside, (low, high))
    # Paths that leave re-cross alike from both sides, so residences and passages have one ratio.
    ratio = (times[0] / times[1]) / (found.residence_cycles[0] / found.residence_cycles[1])
    assert abs(ratio - 1) < 0.2


def test_rotations_single_wells_and_folds_have_none():
    for one in (CircleMap.rigid(0.3), CircleMap.rigid(0.0), CircleMap.arnold(0.1, 0.9), CircleMap.arnold(0.3, 3.0)):
        found = metastable_sets(one, WrappedNormal(0.25))
        assert not found.metastable and found.arcs.shape == (1, 2)
        assert found.staying[0] == 1 and np.isinf(found.residence_cycles[0])
        assert found.transitions.tolist() == [[1.0]]


@pytest.mark.slow
def test_turning_the_circle_turns_the_sets():
    base, shift = wells(2, 0.1, 0.05), 1.234
    turned = CircleMap(lambda x: base(x - shift) + shift, lambda x: base.derivative(x - shift))
    one, other = (metastable_sets(m, WrappedNormal(0.3)) for m in (base, turned))
    moved = np.sort(np.mod(one.arcs[:, 0] + shift, TWO_PI))
    np.testing.assert_allclose(other.arcs[:, 0], moved, atol=1e-5)
    np.testing.assert_allclose(np.sort(other.weights), np.sort(one.weights), rtol=1e-6)


def test_angles_find_their_set():
    found = metastable_sets(wells(2), WrappedNormal(0.3))
    index = found.index([[0.0, np.pi], [TWO_PI, -np.pi]])
    assert index.tolist() == [[1, 0], [1, 0]]
    for k, (low, high) in enumerate(found.arcs):
        assert np.all(found.index(np.linspace(low + 1e-9, high - 1e-9, 20)) == k)


def test_the_simulated_chain_stays_as_told():
    """One cycle from 400,000 angles drawn from the stationary law of the Fourier operator."""
    noise, one, rng = WrappedNormal(0.45), wells(2, 0.1, 0.05), np.random.default_rng(7)
    found, grid = metastable_sets(one, noise, 2), np.linspace(0, TWO_PI, 4_001)
    height = transfer_operator(one, noise).density(grid)
    mass = np.append(0.0, np.cumsum(0.5 * (height[1:] + height[:-1])))
    theta = np.interp(rng.uniform(0, mass[-1], 400_000), mass, grid)
    after = one(theta) + noise.sample(rng, theta.size)
    counts = np.zeros((2, 2))
    np.add.at(counts, (found.index(theta), found.index(after)), 1)
    visits = counts.sum(axis=1, keepdims=True)
    error = np.sqrt(found.transitions * (1 - found.transitions) / visits)
    assert np.all(np.abs(counts / visits - found.transitions) < 4 * error)
    assert np.all(np.abs(visits[:, 0] / theta.size - found.weights) < 4 * 0.5 / np.sqrt(theta.size))


def test_bad_requests_are_refused():
    one, noise = wells(2), WrappedNormal(0.3)
    with pytest.raises(InvalidInput, match="at most 12"):
        metastable_sets(one, noise, 13)
    with pytest.raises(InvalidInput, match="count"):
        metastable_sets(one, noise, 0)
    with pytest.raises(InvalidInput, match="cells"):
        metastable_sets(one, noise, cells=10)
    with pytest.raises(InvalidInput, match="jumps"):
        metastable_sets(one, UniformNoise(0.3))
